#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""sixdeg sweep as a user meets it: table, picture, taking up where it stopped, cells that cannot run."""
import csv
import json
import os
import pathlib
import signal
import subprocess
import time
import unittest
import xml.dom.minidom

from sixdeg_test import Folder

ROOT = pathlib.Path(__file__).resolve().parents[2]
SIXDEG = os.environ["SIXDEG"]
DIESEL = ROOT / "host_sim" / "data" / "engines" / "diesel_22.toml"
GRID = ("--over", "speed.rpm=1000,1500", "--over", "load.bmep_bar=3,5,8")


class Sweep(Folder):
    def setUp(self):
        super().setUp()
        self.scenario = self.folder / "scenario.toml"
        self.scenario.write_text(f'engine = "{DIESEL}"\n[run]\ncycles = 25\n[speed]\nrpm = 1000\n[load]\nbmep_bar = 5\n')
        self.out = self.folder / "out"

    def sweep(self, *arguments):
        return subprocess.run([SIXDEG, "sweep", self.scenario, "--out", self.out, *map(str, arguments)],
                              capture_output=True, text=True, timeout=240)

    def rows(self):
        with open(self.out / "sweep.csv", newline="", encoding="utf-8") as file:
            return list(csv.DictReader(file))

    def test_every_cell_is_the_run_that_it_names(self):
        done = self.sweep(*GRID, "--nominal", "--set", "torque.harmonics=6")
        self.assertEqual(done.returncode, 0, done.stderr)
        rows = self.rows()
        self.assertEqual([(r["speed.rpm"], r["load.bmep_bar"]) for r in rows],
                         [(s, b) for s in ("1000", "1500") for b in ("3", "5", "8")])
        alone = self.folder / "alone.json"
        subprocess.run([SIXDEG, "run", self.scenario, "--nominal", "--set", "speed.rpm=1500", "--set", "load.bmep_bar=8",
                        "--set", "torque.harmonics=6", "--json", alone], check=True, capture_output=True)
        expected = json.loads(alone.read_text())
        for name in ("shift_deg", "rms_true_percent"):
            self.assertAlmostEqual(float(rows[-1][f"torque.{name}"]), expected["torque"][name], places=6)
        self.assertEqual(float(rows[-1]["edges"]), expected["edges"])
        self.assertEqual({r["error"] for r in rows}, {""})

    def test_picture_holds_every_cell(self):
        self.assertEqual(self.sweep(*GRID, "--nominal", "--figure", "torque.shift_deg").returncode, 0)
        svg = xml.dom.minidom.parse(str(self.out / "map.svg"))
        texts = [t.firstChild.data for t in svg.getElementsByTagName("text")]
        for row in self.rows():
            self.assertIn(f"{float(row['torque.shift_deg']):.3g}", texts)
        self.assertEqual(len(svg.getElementsByTagName("rect")), 1 + 6)
        wrong = self.sweep(*GRID, "--nominal", "--figure", "torque.shift_degs")  # of the cells that are there
        self.assertEqual((wrong.returncode, wrong.stderr),
                         (2, "sixdeg: --figure: torque.shift_degs: is no figure of a summary; the nearest is 'torque.shift_deg'\n"))

    def test_only_what_is_missing_is_run_again(self):
        self.assertEqual(self.sweep(*GRID, "--nominal").returncode, 0)
        before = (self.out / "sweep.csv").read_bytes()
        cells = sorted((self.out / "cells").iterdir())
        self.assertEqual(len(cells), 6)
        cells[2].unlink()
        kept = {c: c.stat().st_mtime_ns for c in cells if c != cells[2]}
        again = self.sweep(*GRID, "--nominal")
        self.assertIn("5 of 6 cells were done before", again.stdout)
        self.assertEqual(kept, {c: c.stat().st_mtime_ns for c in kept})
        # realtime_factor is measured anew; all else repeats.
        strip = [{k: v for k, v in r.items() if k != "realtime_factor"} for r in self.rows()]
        old = [{k: v for k, v in r.items() if k != "realtime_factor"} for r in csv.DictReader(before.decode().splitlines())]
        self.assertEqual(strip, old)
        self.scenario.write_text(self.scenario.read_text().replace("cycles = 25", "cycles = 26"))
        self.assertNotIn("were done before", self.sweep(*GRID, "--nominal").stdout)

    def test_a_stopped_sweep_keeps_what_is_done_and_no_half_run(self):
        self.scenario.write_text(self.scenario.read_text().replace("cycles = 25", "cycles = 2000"))
        process = subprocess.Popen([SIXDEG, "sweep", self.scenario, "--out", self.out, *GRID, "--nominal", "--jobs", "1"],
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True)
        for _ in range(1200):
            if list((self.out / "cells").glob("*.json")) if (self.out / "cells").exists() else []:
                break
            time.sleep(0.05)
        os.killpg(process.pid, signal.SIGINT)
        process.communicate(timeout=60)
        self.assertEqual(process.returncode, -signal.SIGINT)
        done = [r for r in self.rows() if not r["error"]]
        self.assertTrue(0 < len(done) < 6)
        self.assertEqual({float(r["cylinder_cycles"]) for r in done}, {7999.0})
        self.assertEqual([p for p in (self.out / "cells").iterdir() if p.suffix != ".json"], [])

    def test_a_cell_that_cannot_run_says_why_and_the_others_do(self):
        done = self.sweep("--over", "load.bmep_bar=5,39", "--nominal")
        self.assertEqual(done.returncode, 2)
        self.assertIn("1 cells of the sweep have no result", done.stderr)
        rows = self.rows()
        self.assertEqual(rows[0]["error"], "")
        self.assertIn("trapped air", rows[1]["error"])
        self.assertFalse((self.out / "map.svg").exists())

    def test_bad_grids_are_refused_before_anything_runs(self):
        for over, says in (("speed.rpm", "is not field=value"), ("speed.rpm=1000,,2000", "empty value"),
                           ("speed.rpm=1000,1000", "1000 twice")):
            done = self.sweep("--over", over)
            self.assertEqual(done.returncode, 2)
            self.assertIn(says, done.stderr)
            self.assertFalse(self.out.exists())


if __name__ == "__main__":
    unittest.main()
