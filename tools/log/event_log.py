# SPDX-License-Identifier: MIT
"""Reads an event log, .sdlog (docs/reference/log.md), into arrays, and writes one from arrays."""
import hashlib
import json
import struct

import numpy as np

HEADER = struct.Struct("<4sIIId")  # magic, signature of the signal table, bytes of description and page, ticks a second
EVENT = np.dtype([("tick", "<u4"), ("kind", "<u2"), ("channel", "<u2"), ("value", "<u4"), ("flags", "<u4")])
OUT = 0x8000  # in kind: from the ecu
CRANK_EDGE, CAM_EDGE, SAMPLE, WHEEL_EDGE, SIGNAL = 1, 2, 4, 5, 16  # sd_event_kind_t


class LogError(Exception):
    """One line: the file, and what is wrong with it."""


class EventLog:
    """about (a dictionary), signature, page (bytes), tick_hz, and per event: time_s, out, kind, channel, value, flags."""

    def __init__(self, path):
        data = path.read_bytes()
        if data[:4] != b"SDL1":
            raise LogError(f"{path}: is no event log: it does not begin with SDL1")
        if len(data) < HEADER.size + 32 or hashlib.sha256(data[:-32]).digest() != data[-32:]:
            raise LogError(f"{path}: is truncated or damaged: its checksum is wrong")
        _, self.signature, about, page, self.tick_hz = HEADER.unpack_from(data)
        first = HEADER.size + about
        self.about = json.loads(data[HEADER.size:first])
        self.page = data[first:first + page]
        events = np.frombuffer(data[first + page:-32], EVENT)
        self.out = (events["kind"] & OUT) != 0
        self.kind = events["kind"] & ~np.uint16(OUT)
        self.channel, self.value, self.flags = events["channel"], events["value"], events["flags"]
        self.time_s = seconds(events["tick"], self.tick_hz)


def seconds(tick, tick_hz):
    """Time of ticks that wrap at 2^32; steps back, as of a cam edge between two teeth, are small."""
    if len(tick) == 0:
        return np.zeros(0)
    step = np.diff(tick).astype(np.uint32).view(np.int32).astype(np.int64)
    return (int(tick[0]) + np.concatenate(([0], np.cumsum(step)))) / tick_hz


def write_log(path, page, signature, tick_hz, events, about=None):
    """Writes an event log that `sixdeg replay` takes.

    page: bytes of a calibration page (`sixdeg calibrate`); signature: of the signal table that it was made with (the page holds it,
    page_signature); events: tuples or an array of EVENT, in order of time; about: a dictionary for people. The file is whole or not there.
    """
    description = json.dumps(about or {}).encode()
    data = HEADER.pack(b"SDL1", signature, len(description), len(page), tick_hz) + description + page
    data += np.array(events, dtype=EVENT).tobytes()
    partial = path.with_name(path.name + ".partial")
    partial.write_bytes(data + hashlib.sha256(data).digest())
    partial.replace(path)


def page_signature(page):
    """Signature of the signal table that a calibration page was made with."""
    return struct.unpack_from("<I", page, 8)[0]


def sample(tick, channel, value):
    """Event of one reading of a sensor: channel as in hal/signals.toml, from 0."""
    return tick, SAMPLE, channel, struct.unpack("<I", struct.pack("<f", value))[0], 0
