# SPDX-License-Identifier: MIT
"""Logs of logic analysers: the .logicdata that rusEFI and FOME write, and VCD. Each gives channels as (name, unit, times, levels).

The layout of .logicdata is that of the writer in rusEFI's console (LogicdataStreamFile, by andreika), of 2020 and later. A file is a row of
numbers: one byte says how many bytes follow, lowest first; 0 stands for itself. In between are texts (length and characters) and, in each
channel, the edges as bare words of 16 or 32 bits: samples since the edge before, and in the highest bit whether the level fell.
What Saleae's own program saves is packed otherwise and is refused.
"""
import struct

import numpy as np

from event_log import LogError

FOREIGN = "is no .logicdata as rusEFI and FOME write it; open it in Saleae's Logic and export the table as CSV"
CHANNEL, EMPTY, SHORT, LONG = 0x16, 5, 2, 3
CHANNELS_MAX = 64


class Numbers:
    """Reads on from where it stands."""

    def __init__(self, path, data):
        self.path, self.data, self.at = path, data, 0

    def foreign(self):
        return LogError(f"{self.path}: {FOREIGN} (byte {self.at})")

    def bytes(self, count):
        if count < 0 or self.at + count > len(self.data):
            raise self.foreign()
        self.at += count
        return self.data[self.at - count:self.at]

    def number(self):
        count = self.bytes(1)[0]
        if count > 8:
            raise self.foreign()
        return int.from_bytes(self.bytes(count), "little")

    def skip(self, count):
        for _ in range(count):
            self.number()

    def text(self):
        return self.bytes(self.number()).decode("latin-1").strip()


def logicdata_head(numbers):
    """(samples a second, names of the channels), and goes on to the first channel's edges. Counts are of numbers in the layout."""
    numbers.bytes(1)
    numbers.number()  # version, or the length of the title in older ones
    if numbers.text() != "Data save2":
        raise numbers.foreign()
    numbers.skip(2)
    frequency = numbers.number()
    numbers.skip(5)
    count = numbers.number()
    if not 0 < count <= CHANNELS_MAX or not 1000 <= frequency <= 1e9:
        raise numbers.foreign()
    numbers.skip(2 + 1 + 3 * count + 1 + 1 + 3 + 2)
    numbers.skip(7)
    if numbers.number() != count:
        raise numbers.foreign()
    numbers.skip(3 + 3 + 1 + 4)
    names = []
    for channel in range(count):
        numbers.skip(2)
        names.append(numbers.text() or f"Channel {channel}")
        numbers.skip(7 + (6 if channel + 1 < count else 1))
    numbers.skip(13 + 20 + 7 + 2 + 6 + 19)
    numbers.skip(9)
    return frequency, names


def logicdata_channel(numbers, channel):
    """Samples and levels of one channel; without edges the level it has all along."""
    if numbers.number() != CHANNEL:
        raise numbers.foreign()
    first = channel == 0
    numbers.skip(2 if first else 0)
    if numbers.number() != channel + 1:
        raise numbers.foreign()
    numbers.skip(5)
    last, kind = numbers.number(), numbers.number()
    if kind == EMPTY:
        skip_empty(numbers)
        return np.zeros(1), np.array([int(last == 1)])
    if kind not in (SHORT, LONG):
        raise numbers.foreign()
    numbers.skip(2 + 11 + (7 if kind == LONG else 0) + 1 if first else 10 + (5 if kind == LONG else 0))
    count = numbers.number()
    numbers.skip(4)
    words = np.frombuffer(numbers.bytes(count * (4 if kind == LONG else 2)), "<u4" if kind == LONG else "<u2").astype(np.int64)
    numbers.bytes(1)
    numbers.skip((7 + (0 if kind == LONG else 7) + 1) if first else 4 + (0 if kind == LONG else 5))
    numbers.skip(5)
    numbers.bytes(32)
    top = 1 << (31 if kind == LONG else 15)
    levels = (words & top == 0).astype(int)
    return np.concatenate(([0], np.cumsum(words & (top - 1)))), np.concatenate(([1 - levels[0]] if count else [int(last == 1)], levels))


def skip_empty(numbers):
    """Behind a channel without edges, only zeros and marks of blocks come before the next channel or the end."""
    while numbers.at < len(numbers.data):
        at = numbers.at
        if numbers.number() in (CHANNEL, 1):
            numbers.at = at
            return


def read_logicdata(path, data):
    numbers = Numbers(path, data)
    frequency, names = logicdata_head(numbers)
    channels = []
    for i, name in enumerate(names):
        samples, levels = logicdata_channel(numbers, i)
        channels.append((name, "", samples / frequency, levels))
    return channels


# ---- VCD, as PulseView, GTKWave's sources and rusEFI's console write it ----

VCD_UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "ps": 1e-12, "fs": 1e-15}


def read_vcd(path, data):
    """Wires of one bit, and reals; wider ones are left out."""
    head, _, body = data.decode("latin-1").partition("$enddefinitions")
    unit_s, channels = vcd_head(path, head)
    now = 0.0
    tokens = iter(body.replace("$end", " ").split())
    for token in tokens:
        if token[0] in "bBrR":
            next(tokens, None)  # the code of a wider wire
        elif token[0] == "#":
            try:
                now = int(token[1:]) * unit_s
            except ValueError:
                raise LogError(f"{path}: '{token[:20]}' is no time") from None
        elif token[0] in "01" and token[1:] in channels:
            channels[token[1:]][2].append((now, int(token[0])))
    read = [(name, "", *np.array(rows, dtype=float).T) for name, _, rows in channels.values() if rows]
    if any(np.any(np.diff(times) < 0) for _, _, times, _ in read):
        raise LogError(f"{path}: has a time that goes back")
    return read


def vcd_head(path, head):
    """(seconds of a unit, {code: (name, code, rows to come)} of the wires of one bit)."""
    words = head.split()
    unit_s, channels = None, {}
    for i, word in enumerate(words):
        if word == "$timescale":
            scale = "".join(words[i + 1:i + 3]).removesuffix("$end")
            number = scale.rstrip("fpnumsu")
            if number.isdigit() and scale[len(number):] in VCD_UNITS:
                unit_s = int(number) * VCD_UNITS[scale[len(number):]]
        if word == "$var" and i + 4 < len(words) and words[i + 2] == "1":
            channels[words[i + 3]] = (words[i + 4], words[i + 3], [])
    if unit_s is None or not channels:
        raise LogError(f"{path}: is a VCD without a timescale, or without wires of one bit")
    return unit_s, channels
