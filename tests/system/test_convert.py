#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""tools/log/convert.py: binary logs become tables that `sixdeg replay` reads; and the writer of event logs beside the reader."""
import contextlib
import io
import os
import pathlib
import random
import struct
import subprocess
import sys
import unittest

import numpy as np

from sixdeg_test import Folder

ROOT = pathlib.Path(__file__).resolve().parents[2]
SIXDEG = os.environ["SIXDEG"]
sys.path.append(str(ROOT / "tools" / "log"))
import convert
import event_log


def wheel_edges(revolutions=20, rpm=1500.0):
    """Times of the 58 teeth of 60-2."""
    pitch = 60 / rpm / 60
    return np.array([0.01 + k * pitch for k in range(revolutions * 60) if k % 60 < 58])


def levels(edges):
    back = edges + 0.3 * np.diff(edges).min()
    time = np.column_stack((edges, back)).ravel()
    return time, np.tile([0, 1], len(edges))


def mlg(version, fields, rows, marker_after=None):
    """A log as MegaLogViewer's format describes it; rows: tick and values."""
    kinds = {"u1": (0, "B"), "u2": (2, "H"), "f4": (7, "f")}
    head = struct.Struct(">6sHIHIHH" if version == 1 else ">6sHIIIHH")
    described = b"".join(struct.pack(">B34s10sBffb", kinds[kind][0], name.encode(), unit.encode(), 0, scale, shift, 0)
                         + bytes(0 if version == 1 else 34)
                         for name, unit, kind, scale, shift in fields)
    first = head.size + len(described)
    size = sum({"u1": 1, "u2": 2, "f4": 4}[f[2]] for f in fields)
    data = head.pack(b"MLVLG\0", version, 0, 0, first, size, len(fields)) + described
    for i, (tick, *values) in enumerate(rows):
        data += struct.pack(">BBH", 0, i & 255, tick & 0xffff) + struct.pack(">" + "".join(kinds[f[2]][1] for f in fields), *values) + b"\0"
        if i == marker_after:
            data += struct.pack(">BBH50s", 1, 0, tick & 0xffff, b"marker")
    return data


def number(value):
    """As .logicdata has it: how many bytes, and these, lowest first."""
    size = 0 if value == 0 else next(n for n in (1, 2, 3, 4, 8) if value < 1 << 8 * n)
    return bytes([size]) + value.to_bytes(size, "little")


def numbers(*values):
    return b"".join(number(v) for v in values)


def logicdata(channels, version=0x13, block=0x18):
    """channels: name and edges as (microsecond, level). After the layout in tools/log/logic.py."""
    count, end = len(channels), max(e[-1][0] for _, e in channels if e) + 100
    ids = b"".join(numbers(0x533F, i, 1) for i in range(count))
    one = b"\x08" + struct.pack("<d", 1.0)
    data = b"\x7f" + numbers(version, 10) + b"Data save2" + numbers(block, 0x54, 1000000, 0, 10, 100000, 0, 0, count, block, 0, block) + ids
    data += numbers(0, block, 0x533F, 7, 7, 0x54, 0, block, end // 4, 0, 0, 0, 0, 0, count, 0, 0, 0, 0x533F, 0, 1, 0, block, 0, 0, 0)
    for i, (name, _) in enumerate(channels):
        data += numbers(255, i, len(name)) + name.encode() + numbers(0, 0) + one + numbers(0, 0, 1, 0)
        data += numbers(0x533F, i + 1, 1, 0x8B, 0x45, 0x13) if i + 1 < count else number(0)
    data += numbers(block, 84, 84, 0, 84, 0, 84, *[0] * 6, block, 0, 0, 10, 0, 84, 10, 100000, 0, 0, 84, 0, 0, 1, 0, 0, 0, 0x533F, 7, 0)
    data += numbers(block, end, end, end, 0, 84, 0, block, 0, block, 84, 84, 84, 84, 0, block, 1000000, 0, 0, 0, 1, 0, 0, 0, 0x533F, 0, 0)
    data += numbers(0, 1, 1, 0, 1, 0x13, 84, block, 0, end, 0, 0, count, 1, 0, 1)
    for i, (_, edges) in enumerate(channels):
        data += logicdata_channel(i, edges, end, block)
    return data + numbers(0, 0, 0, 1, 1, 0, count, block) + ids


def logicdata_channel(i, edges, end, block):
    steps = np.diff([0] + [t for t, _ in edges])
    wide, first, last = bool(len(steps) and steps.max() > 0x7FFF), i == 0, edges[-1] if edges else (0, 0)
    data = numbers(0x16, *[84, block] * first, i + 1, 0, end, 1, last[0], end - last[0], last[1], 5 if not edges else 3 if wide else 2)
    data += numbers(*([0, block] + [0] * 11 + ([block] + [0] * 6) * wide + [block] if first else [0] * (15 if wide else 10)))
    data += numbers(len(edges), 0, len(edges), len(edges) >> 15, len(edges) & 0x7FFF)
    for step, (_, level) in zip(steps, edges):
        data += struct.pack("<I" if wide else "<H", int(step) | (0 if level else 0x80000000 if wide else 0x8000))
    data += b"\0" + numbers(*([block] + [0] * 6 + ([block] + [0] * 6) * (not wide) + [block] if first else [0] * (4 if wide else 9)))
    if not edges:
        return data + bytes(5)
    return data + numbers(1, 0, 1, 0, 1) + struct.pack("<QQqQ", 0, 0, -1, 3 if wide else 2)


class Convert(Folder):
    def convert(self, log, *options):
        out = self.folder / "out.csv"
        words = io.StringIO()
        with contextlib.redirect_stdout(words), contextlib.redirect_stderr(words):
            status = convert.main([str(log), str(out), *options])
        return status, words.getvalue(), out

    def replayed(self, out, *options):
        return subprocess.run([SIXDEG, "replay", str(out), *options], capture_output=True, text=True, timeout=60, check=False)

    def test_mlg_of_either_version(self):
        time, level = levels(wheel_edges())
        ticks = np.round(time / 1e-5).astype(int)
        for version in (1, 2):
            with self.subTest(version=version):
                log = self.folder / "a.mlg"
                rows = [(t, int(v), 200 + i % 7) for i, (t, v) in enumerate(zip(ticks, level))]
                log.write_bytes(mlg(version, [("crank", "", "u1", 1, 0), ("MAP", "kPa", "u2", 0.5, 0)], rows, marker_after=5))
                status, words, out = self.convert(log)
                self.assertEqual(status, 0, words)
                self.assertIn("2 channels", words)
                lines = out.read_text().splitlines()
                self.assertEqual(lines[0], 'time [s],"crank","MAP [kPa]"')
                self.assertEqual(lines[1].split(",")[1:], ["0", "100"])
                done = self.replayed(out)
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertIn("60-2, falling", done.stdout)

    def test_mf4(self):
        from asammdf import MDF, Signal

        time, level = levels(wheel_edges())
        log = self.folder / "a.mf4"
        with MDF(version="4.10") as mdf:
            mdf.append([Signal(level.astype(np.uint8), time, name="crank")])
            mdf.append([Signal(np.array([1.0, 1.1]), np.array([0.0, 0.2]), name="MAP", unit="bar")])
            mdf.save(log, overwrite=True)
        status, words, out = self.convert(log)
        self.assertEqual(status, 0, words)
        done = self.replayed(out, "--column", "crank")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("60-2, falling", done.stdout)
        self.assertEqual(self.convert(log, "--channel", "MAP")[0], 0)
        self.assertIn("has no channel RPM; it has crank, MAP", self.convert(log, "--channel", "RPM")[1])

    def test_lcm(self):
        log = self.folder / "a.lcm"
        ticks = np.round(wheel_edges() * 1e6).astype(int)
        events = [struct.pack(">IHHII", t, event_log.CRANK_EDGE, 0, 0, 0) for t in ticks]
        data = b""
        for i in range(0, len(events), 50):
            message = bytes(8) + struct.pack(">iii", len(events[i:i + 50]), i, 7) + b"".join(events[i:i + 50])
            data += struct.pack(">IqqII", convert.LCM_SYNC, i, i, 13, len(message)) + b"SIXDEG_INPUTS" + message
        log.write_bytes(data)
        status, words, out = self.convert(log)
        self.assertEqual(status, 0, words)
        self.assertIn("60-2, falling", self.replayed(out).stdout)

    def test_logicdata_as_rusefi_writes_it(self):
        crank = [(round(1e6 * t), int(v)) for t, v in zip(*levels(wheel_edges()))]
        slow = [(50000 + 80000 * i, (i + 1) % 2) for i in range(9)]
        for version, block in ((0x13, 0x18), (10, 0x15)):
            for channels in ([("Primary", crank), ("Secondary", slow), ("Trg", [])],
                             [("Sync", []), ("Secondary", slow), ("Primary", crank)],
                             [("Secondary", slow), ("Primary", crank)]):
                with self.subTest(version=version, first=channels[0][0]):
                    log = self.folder / "a.logicdata"
                    log.write_bytes(logicdata(channels, version, block))
                    read = {name: list(zip(np.round(1e6 * t).astype(int), v)) for name, _, t, v in convert.read(log, 1e6)}
                    self.assertEqual(read["Primary"][1:], crank)
                    self.assertEqual(read["Secondary"], [(0, 0)] + slow)
                    status, words, out = self.convert(log)
                    self.assertEqual(status, 0, words)
                    done = self.replayed(out)
                    self.assertEqual(done.returncode, 0, done.stderr)
                    self.assertIn("60-2, falling", done.stdout)
                    self.assertIn("convert.py", self.replayed(log).stderr)
        whole, chance = log.read_bytes(), random.Random(2)
        for i in range(200):
            data = bytearray(whole[:chance.randrange(1, len(whole))] if i % 2 else whole)
            for _ in range(chance.randrange(1, 4)):
                data[chance.randrange(1, min(len(data), 700) + 1) - 1] = chance.randrange(256)
            log.write_bytes(data)
            status, words, _ = self.convert(log)
            self.assertIn(status, (0, 2), words)
            self.assertEqual(len(words.splitlines()), 1, words)

    def test_vcd(self):
        log = self.folder / "a.vcd"
        rows = "".join(f"#{round(1e6 * t)}\n{int(v)}!\n" for t, v in zip(*levels(wheel_edges())))
        log.write_text(f"$date today $end\n$timescale 1 us $end\n$var wire 1 ! crank $end\n$var wire 8 # bus $end\n$enddefinitions $end\n"
                       f"$dumpvars\n0!\nb0 #\n$end\n{rows}")
        status, words, out = self.convert(log)
        self.assertEqual(status, 0, words)
        self.assertIn("60-2, falling", self.replayed(out).stdout)
        self.assertIn("convert.py", self.replayed(log).stderr)
        for bad in ("$enddefinitions $end\n#1\n", "$timescale 1us $end $var wire 1 ! c $end $enddefinitions $end\n#x 1!\n",
                    "$timescale 1us $end $var wire 1 ! c $end $enddefinitions $end\n#5 1! #4 0!\n"):
            log.write_text(bad)
            status, words, _ = self.convert(log)
            self.assertEqual((status, len(words.splitlines())), (2, 1), words)

    def test_damaged_logs_are_refused_in_one_line(self):
        log = self.folder / "a.mlg"
        whole = mlg(2, [("crank", "", "u1", 1, 0), ("MAP", "kPa", "f4", 1, 0)], [(i, i & 1, 1.0) for i in range(40)])
        chance = random.Random(1)
        for i in range(300):
            data = bytearray(whole[:chance.randrange(6, len(whole))] if i % 2 else whole)
            for _ in range(chance.randrange(4)):
                data[chance.randrange(5, len(data))] = chance.randrange(256)
            log.write_bytes(data)
            status, words, _ = self.convert(log)
            self.assertIn(status, (0, 2), words)
            self.assertEqual(len(words.splitlines()), 1, words)
        log.write_bytes(b"something else")
        self.assertEqual(self.convert(log)[0], 2)

    def test_a_log_is_not_written_over(self):
        log = self.folder / "out.csv"
        log.write_bytes(mlg(1, [("crank", "", "u1", 1, 0)], [(i, i & 1) for i in range(9)]))
        status, words, _ = self.convert(log)
        self.assertEqual(status, 2)
        self.assertIn("not written over", words)


class Writer(Folder):
    def test_what_is_written_is_read_and_replayed(self):
        engine = ROOT / "host_sim" / "data" / "engines" / "vw_aba.toml"
        done = subprocess.run([SIXDEG, "calibrate", str(engine), "--out", str(self.folder)], capture_output=True, text=True, timeout=120,
                              check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        page = next(self.folder.glob("*.bin")).read_bytes()
        ticks = np.round(wheel_edges() * 1e6).astype(int)
        events = [event_log.sample(0, 0, 1.0)] + [(t, event_log.CRANK_EDGE, 0, 0, 0) for t in ticks]
        log = self.folder / "made.sdlog"
        event_log.write_log(log, page, event_log.page_signature(page), 1e6, events, {"name": "made"})
        read = event_log.EventLog(log)
        self.assertEqual(len(read.kind), len(events))
        self.assertAlmostEqual(read.time_s[-1], wheel_edges()[-1], places=6)
        done = subprocess.run([SIXDEG, "replay", str(log)], capture_output=True, text=True, timeout=120, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("1160 edges, 17 whole revolutions", done.stdout)


if __name__ == "__main__":
    unittest.main()
