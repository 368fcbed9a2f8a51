#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The demo's made trace: 58 teeth and one gap a revolution, cranking to 1500 rpm in 10 s, the same bytes every time."""
import csv
import os
import subprocess
import sys
import tempfile
import unittest

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
MAKE = os.path.join(ROOT, "tools", "trace", "make_trace.py")


def edges(rows, column, level):
    return [float(b["time_s"]) for a, b in zip(rows, rows[1:]) if a[column] != b[column] and b[column] == level]


class Trace(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        with tempfile.TemporaryDirectory() as folder:
            texts = []
            for name in ("a.csv", "b.csv"):
                path = os.path.join(folder, name)
                subprocess.run([sys.executable, MAKE, path], check=True)
                with open(path, encoding="ascii") as file:
                    texts.append(file.read())
        cls.texts = texts
        cls.rows = list(csv.DictReader(texts[0].splitlines()))

    def test_same_bytes(self):
        self.assertEqual(self.texts[0], self.texts[1])

    def test_teeth_and_speed(self):
        falling = edges(self.rows, "crank", "0")
        intervals = [b - a for a, b in zip(falling, falling[1:])]
        marks = [i for i in range(1, len(intervals) - 1) if intervals[i] > 2 * max(intervals[i - 1], intervals[i + 1])]
        self.assertEqual({b - a for a, b in zip(marks, marks[1:])}, {58})
        rpm = [60 / (falling[b] - falling[a]) for a, b in zip(marks, marks[1:])]
        self.assertAlmostEqual(rpm[0], 250, delta=15)
        self.assertAlmostEqual(rpm[-1], 1500, delta=1)
        self.assertAlmostEqual(float(self.rows[-1]["time_s"]), 10, delta=0.01)

    def test_cam_rises_once_a_cycle_at_tooth_25(self):
        falling, rising = edges(self.rows, "crank", "0"), edges(self.rows, "cam", "1")
        # At the running speed, where one cycle lasts 80 ms.
        self.assertAlmostEqual(rising[-1] - rising[-2], 0.08, delta=1e-4)
        intervals = [b - a for a, b in zip(falling, falling[1:])]
        before = max(i for i, t_s in enumerate(falling) if t_s <= rising[-1])
        last_mark = max(i for i in range(before) if intervals[i] > 2 * intervals[i - 1])
        self.assertEqual(before - last_mark - 1, 25)


if __name__ == "__main__":
    unittest.main()
