# SPDX-License-Identifier: MIT
"""Raw frames on vcan0, for tests that count them or make bad ones."""
import pathlib
import re
import socket
import struct

ROOT = pathlib.Path(__file__).resolve().parents[2]
FRAME = struct.Struct("=IBBBB64s")  # struct canfd_frame of linux/can.h: id, length, flags, two reserved, data
NAMES = {name: int(number) for number, name in re.findall(r"^BO_ (\d+) (\w+):", (ROOT / "hal/generated/sixdeg.dbc").read_text(), re.M)}


def can_socket(*identifiers):
    """A socket on vcan0 that takes FD frames, of these identifiers only where some are given."""
    can = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
    can.setsockopt(socket.SOL_CAN_RAW, socket.CAN_RAW_FD_FRAMES, 1)
    if identifiers:
        can.setsockopt(socket.SOL_CAN_RAW, socket.CAN_RAW_FILTER, b"".join(struct.pack("=II", i, 0x7FF) for i in identifiers))
    can.settimeout(10)
    can.bind(("vcan0",))
    return can
