#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Turns a binary log of another program into a table that `sixdeg replay` reads.

usage: convert.py LOG OUT.csv [--channel NAME]... [--tick-hz HZ] [--list]
       LOG: MF4 or MDF (by asammdf), MegaLogViewer MLG (.mlg, .mlv), LCM (of lcm-logger, with the plant's events),
            .logicdata of rusEFI and FOME, VCD
       exit status 2 and one line for a log that cannot be read
"""
import argparse
import os
import pathlib
import struct
import sys

import numpy as np

from event_log import CAM_EDGE, CRANK_EDGE, LogError, seconds
from logic import read_logicdata, read_vcd

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import progress  # noqa: E402  the path comes first

# ---- MegaLogViewer, versions 1 and 2: big endian; a head, one description a field, then records ----

MLG_HEAD = {1: struct.Struct(">6sHIHIHH"), 2: struct.Struct(">6sHIIIHH")}
MLG_FIELD_BYTES = {1: 55, 2: 89}
MLG_TYPES = {0: ">u1", 1: ">i1", 2: ">u2", 3: ">i2", 4: ">u4", 5: ">i4", 6: ">i8", 7: ">f4", 10: ">u1", 11: ">u2", 12: ">u4"}
MLG_TICK_S = 1e-5  # of the 16 bit counter in each record
MLG_MARKER_BYTES = 50


def mlg_fields(path, data):
    """(version, offset of the first record, bytes of a record, fields as name, unit, type, scale, transform)."""
    version = struct.unpack_from(">H", data, 6)[0] if len(data) >= 8 else 0
    head = MLG_HEAD.get(version)
    if head is None or len(data) < head.size:
        raise LogError(f"{path}: is an MLG log of version {version}, or cut off; versions 1 and 2 are read")
    *_, first, size, count = head.unpack_from(data)
    step = MLG_FIELD_BYTES[version]
    if head.size + step * count > len(data) or first > len(data):
        raise LogError(f"{path}: is cut off within its {count} fields")
    fields = []
    for i in range(count):
        at = head.size + i * step
        kind, name, unit, _, scale, transform = struct.unpack_from(">B34s10sBff", data, at)
        if kind not in MLG_TYPES:
            raise LogError(f"{path}: field {i} is of the unknown type {kind}")
        fields.append((text_of(name), text_of(unit), MLG_TYPES[kind], scale, transform))
    return first, size, fields


def text_of(raw):
    return raw.split(b"\0")[0].decode("latin-1").strip()


def read_mlg(path, data):
    """Channels as (name, unit, times, values), all of one rate."""
    first, size, fields = mlg_fields(path, data)
    record = np.dtype([("block", "u1"), ("counter", "u1"), ("tick", ">u2"), *((f"f{i}", f[2]) for i, f in enumerate(fields)),
                       ("check", "u1")])
    if record.itemsize != size + 5:
        raise LogError(f"{path}: records of {size} bytes do not hold its {len(fields)} fields of {record.itemsize - 5} bytes")
    pieces, at = [], first
    while at + 4 <= len(data):
        if data[at] == 1:  # a marker: text for people
            at += 4 + MLG_MARKER_BYTES
            continue
        run = 0
        while at + (run + 1) * record.itemsize <= len(data) and data[at + run * record.itemsize] == 0:
            run += 1
        if run == 0:
            break  # the logger was stopped within a record
        pieces.append(np.frombuffer(data, record, run, at))
        at += run * record.itemsize
    if not pieces:
        raise LogError(f"{path}: holds no records")
    rows = np.concatenate(pieces)
    ticks = rows["tick"].astype(np.int64)
    time_s = (ticks[0] + np.concatenate(([0], np.cumsum(np.diff(ticks) % 65536)))) * MLG_TICK_S
    channels = [(name, unit, (rows[f"f{i}"].astype(float) + shift) * scale) for i, (name, unit, _, scale, shift) in enumerate(fields)]
    named = next((values for name, unit, values in channels if name.lower() == "time" and np.all(np.diff(values) >= 0)), None)
    time_s = time_s if named is None else named
    return [(name, unit, time_s, values) for name, unit, values in channels if values is not named]


# ---- LCM: what lcm-logger wrote of the channel that carries events to the ecu ----

LCM_SYNC = 0xEDA1DA01
LCM_EVENT = np.dtype([("tick", ">u4"), ("kind", ">u2"), ("channel", ">u2"), ("value", ">u4"), ("flags", ">u4")])


def lcm_messages(path, data):
    """(channel, bytes) of every message."""
    at = 0
    while at + 28 <= len(data):
        sync, _, _, channel, size = struct.unpack_from(">IqqII", data, at)
        if sync != LCM_SYNC:
            raise LogError(f"{path}: is damaged at byte {at}: no LCM event begins there")
        at += 28 + channel + size
        if at > len(data):
            break  # the logger was stopped within an event
        yield data[at - channel - size:at - size].decode("latin-1"), data[at - size:at]


def read_lcm(path, data, tick_hz):
    """Crank and cam as levels that fall (crank) and rise (cam) at their edges."""
    ticks = {CRANK_EDGE: [], CAM_EDGE: []}
    for channel, message in lcm_messages(path, data):
        if channel != "SIXDEG_INPUTS" or len(message) < 20:
            continue
        count = struct.unpack_from(">i", message, 8)[0]
        if count < 0 or 20 + count * LCM_EVENT.itemsize > len(message):
            raise LogError(f"{path}: holds a SIXDEG_INPUTS message that is cut off")
        for event in np.frombuffer(message, LCM_EVENT, count, 20):
            if int(event["kind"]) in ticks:
                ticks[int(event["kind"])].append((int(event["tick"])))
    crank = seconds(np.array(ticks[CRANK_EDGE], dtype=np.uint32), tick_hz)
    if len(crank) == 0:
        raise LogError(f"{path}: holds no crank edges on the channel SIXDEG_INPUTS")
    channels = [pulses("crank", crank, 0)]
    if ticks[CAM_EDGE]:
        cam = seconds(np.array(ticks[CRANK_EDGE][:1] + ticks[CAM_EDGE], dtype=np.uint32), tick_hz)[1:]
        channels.append(pulses("cam", cam, 1))
    return channels


def pulses(name, time_s, level):
    """A level that becomes `level` at each time and goes back a third of the way to the next."""
    back = time_s + np.diff(time_s, append=time_s[-1] + (time_s[-1] - time_s[-2] if len(time_s) > 1 else 1)) / 3
    time = np.column_stack((time_s, back)).ravel()
    return name, "", time, np.tile([level, 1 - level], len(time_s))


# ---- MF4 and MDF ----

def read_mdf(path):
    from asammdf import MDF  # takes seconds to import

    channels = []
    with MDF(path) as mdf:
        for group, _ in enumerate(mdf.groups):
            for channel in mdf.groups[group].channels:
                signal = mdf.get(channel.name, group=group, raw=False, ignore_invalidation_bits=False)
                if signal.samples.dtype.kind in "biuf" and len(signal) and channel.name not in ("t", "time", "Time"):
                    channels.append((channel.name, signal.unit, signal.timestamps, signal.samples.astype(float)))
    return channels


def read(path, tick_hz):
    with path.open("rb") as file:
        start = file.read(4096)
    if start[:3] == b"MDF" or start[:5] == b"UnFin":
        return read_mdf(path)
    if start[:5] == b"MLVLG":
        return read_mlg(path, path.read_bytes())
    if start[:4] == struct.pack(">I", LCM_SYNC):
        return read_lcm(path, path.read_bytes(), tick_hz)
    if start[:1] == b"\x7f":
        return read_logicdata(path, path.read_bytes())
    if start.lstrip()[:1] == b"$" or b"$enddefinitions" in start:
        return read_vcd(path, path.read_bytes())
    raise LogError(f"{path}: is no MF4, MLG, LCM, .logicdata or VCD log; texts go to sixdeg replay as they are")


def choose(path, channels, names):
    if not names:
        return channels
    missing = [name for name in names if name not in [c[0] for c in channels]]
    if missing:
        raise LogError(f"{path}: has no channel {missing[0]}; it has {', '.join(c[0] for c in channels)}")
    return [c for c in channels if c[0] in names]


def write(channels, out_path):
    """One row a moment at which any channel has a value; a channel without one then is blank, which holds the value before."""
    times = np.unique(np.concatenate([c[2] for c in channels]))
    places = [np.searchsorted(c[2], times, side="right") - 1 for c in channels]
    partial = out_path.with_name(out_path.name + ".partial")
    with partial.open("w", encoding="utf-8", newline="\n") as out:
        out.write(",".join(["time [s]", *(f'"{name} [{unit}]"' if unit else f'"{name}"' for name, unit, *_ in channels)]) + "\n")
        for i, time in enumerate(times):
            cells = []
            for (_, _, own, values), place in zip(channels, places):
                at = place[i]
                cells.append(f"{values[at]:.9g}" if at >= 0 and own[at] == time else "")
            out.write(f"{time:.9f}," + ",".join(cells) + ("," if not cells[-1] else "") + "\n")
    os.replace(partial, out_path)


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("log", type=pathlib.Path)
    parser.add_argument("out", type=pathlib.Path, nargs="?")
    parser.add_argument("--channel", action="append", help="only this one; as often as one likes")
    parser.add_argument("--tick-hz", type=float, default=1e6, help="capture ticks a second of an LCM log")
    parser.add_argument("--list", action="store_true", help="say what channels there are")
    options = parser.parse_args(arguments)
    try:
        channels = choose(options.log, read(options.log, options.tick_hz), options.channel)
        if not channels:
            raise LogError(f"{options.log}: holds no channel of numbers")
        if options.list or options.out is None:
            for name, unit, time_s, _ in channels:
                print(f"{name}  {unit}  {len(time_s)} samples")
            return 0
        if options.out.exists() and options.out.samefile(options.log):
            raise LogError(f"{options.out}: is the log itself; it is not written over")
        write(channels, options.out)
    except (LogError, OSError) as error:
        print(f"convert: {error}", file=sys.stderr)
        return 2
    print(f"{options.out}: {len(channels)} channels")
    return 0


if __name__ == "__main__":
    with progress.Progress("convert"):
        sys.exit(main())
