#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The report of a small made-up replay: self-contained, with pictures, the same bytes twice, and clear refusals."""
import csv
import json
import math
import os
import subprocess
import sys
import tempfile
import unittest

from sixdeg_test import charts, outside

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
REPORT = os.path.join(ROOT, "tools", "report", "report.py")
COLUMNS = ["edge", "t_s", "class", "tooth", "angle_deg", "rpm", "accel_radps2", "torque_nm", "health", "fourier_nm"]

CYCLES = [[0, 0.1, 1, 1000, 900, "invalid"], [0, 0.1, 2, 1000, 500, "invalid"],
          [1, 0.2, 1, 1000, 40, "degraded"], [1, 0.2, 2, 1000, 30, "degraded"],
          [2, 0.3, 1, 1000, 92, "valid"], [2, 0.3, 2, 1000, 78, "valid"],
          [3, 0.4, 1, 1000, "", "valid"], [3, 0.4, 2, 1000, 78, "valid"]]


def summary(**changed):
    return {"edges": 1160, "revolutions": 20, "sync_losses": 0, "faults_coasted": 1, "first_sync_edge": 60,
            "rpm_last": 1000.0,
            "guess": {"wheel": "60-2", "edge": "falling", "column": 1, "gap_ratio": 3.04, "cam_column": 2},
            "engine": {"name": "test <engine>", "guessed": ["crank.inertia_kgm2"]},
            "files": {"/somewhere/made.csv": "00", "engine.toml": "11"},
            "assumptions": ["engine: crank.inertia_kgm2 is a guess"], **changed}


def teeth_rows():
    """20 revolutions at 1000 rpm; the first unsynced, one edge coasted, one spurious."""
    rows, tooth_s = [], 60 / 1000 / 60
    for position in range(20 * 60):
        tooth = position % 60
        if tooth >= 58:
            continue
        kind = "unsynced" if position < 60 else "coasted" if position == 300 else "spurious" if position == 500 else "tooth"
        synced = kind != "unsynced"
        angle_deg = position * 6 % 720
        rows.append([len(rows), f"{position * tooth_s:.6f}", kind, tooth if synced else "", angle_deg if synced else "",
                     1000 if synced else "", "", f"{50 * math.sin(math.radians(2 * angle_deg)):.3f}" if synced else "",
                     "valid" if synced else "invalid", ""])
    return rows


def write_csv(path, header, rows):
    with open(path, "w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows([header, *rows])


def write_folder(folder, columns=COLUMNS, rows=None, cycles=CYCLES, **changed):
    os.makedirs(folder, exist_ok=True)
    with open(os.path.join(folder, "summary.json"), "w", encoding="utf-8") as file:
        json.dump(summary(**changed), file)
    write_csv(os.path.join(folder, "teeth.csv"), columns, teeth_rows() if rows is None else rows)
    write_csv(os.path.join(folder, "cycles.csv"),
              ["cycle", "t_s", "cylinder", "rpm", "torque_nm", "health", "fourier_nm", "fourier_health"],
              [[*row, "", "invalid"] for row in cycles])


class Report(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.replay = os.path.join(self.folder.name, "replay")
        self.page = os.path.join(self.folder.name, "report.html")

    def run_report(self, *folders):
        return subprocess.run([sys.executable, REPORT, "--out", self.page, *(folders or [self.replay])],
                              capture_output=True, text=True, check=False)

    def read_page(self):
        with open(self.page, encoding="utf-8") as file:
            return file.read()

    def test_page_is_self_contained_with_pictures_and_figures(self):
        write_folder(self.replay)
        done = self.run_report()
        self.assertEqual(done.returncode, 0, done.stderr)
        page = self.read_page()
        self.assertEqual(len(charts(page)), 4)
        self.assertEqual(outside(page), [])
        self.assertFalse("/somewhere" in page)
        for text in ("made.csv", "60-2, falling, gap ratio 3.0", "test &lt;engine&gt;", "1000.0 rpm", "95.0 %",
                     "+6.0 N m, sd 1.0 over 2 cycles", "-6.0 N m, sd 1.0 over 2 cycles", "engine: crank.inertia_kgm2 is a guess"):
            self.assertTrue(text in page, text)
        self.assertIn("faults coasted through    1", done.stdout)

    def test_without_an_intake_pressure_there_is_no_torque_but_why(self):
        for intake, pictures in ((False, 3), (True, 4)):
            write_folder(self.replay, inputs={"intake": intake})
            done = self.run_report()
            self.assertEqual(done.returncode, 0, done.stderr)
            page = self.read_page()
            self.assertEqual(len(charts(page)), pictures)
            self.assertEqual('aria-label="torque over crank angle"' in page, intake)
            self.assertEqual("which this recording lacks (sixdeg replay --intake)" in page, not intake)
            self.assertEqual("No intake pressure was recorded" in page, not intake)

    def test_same_input_gives_same_bytes(self):
        write_folder(self.replay)
        self.run_report()
        first = self.read_page()
        self.run_report()
        self.assertTrue(first == self.read_page())

    def test_every_folder_gets_a_section(self):
        write_folder(self.replay)
        second = os.path.join(self.folder.name, "second")
        write_folder(second, files={"other.txt": "00"})
        self.assertEqual(self.run_report(self.replay, second).returncode, 0)
        page = self.read_page()
        self.assertEqual(len(charts(page)), 8)
        self.assertTrue("<h2>other.txt</h2>" in page)

    def test_recording_that_never_synced_is_drawn_without_pictures(self):
        rows = [[i, i * 1e-3, "unsynced", "", "", "", "", "", "invalid", ""] for i in range(100)]
        write_folder(self.replay, rows=rows, cycles=CYCLES[:2], first_sync_edge=None, rpm_last=None)
        done = self.run_report()
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(charts(self.read_page()), [])
        self.assertIn("never", done.stdout)

    def test_bad_folders_are_named_and_leave_no_page(self):
        write_folder(self.replay, columns=["time" if c == "t_s" else c for c in COLUMNS])
        done = self.run_report()
        self.assertEqual((done.returncode, os.path.exists(self.page)), (2, False))
        self.assertRegex(done.stderr, r"^report: .*teeth\.csv: has no column t_s\n$")
        os.remove(os.path.join(self.replay, "summary.json"))
        done = self.run_report()
        self.assertEqual((done.returncode, os.path.exists(self.page)), (2, False))
        self.assertRegex(done.stderr, r"^report: .*summary\.json: No such file or directory\n$")


if __name__ == "__main__":
    unittest.main()
