#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The driveline in the ecu, on the simulated engine with a car, by `sixdeg run`. Bounds on both sides: docs/results/driveline.md."""
import json
import os
import pathlib
import subprocess
import unittest

from sixdeg_test import Folder

ROOT = pathlib.Path(__file__).resolve().parents[2]
DATA = ROOT / "host_sim" / "data"
DRIVE, SHUFFLE = DATA / "scenarios" / "drive.toml", DATA / "scenarios" / "shuffle.toml"


class Driveline(Folder):
    def run_it(self, scenario, *options):
        command = [os.environ["SIXDEG"], "run", str(scenario), "--nominal", "--json", str(self.folder / "summary.json"), *options]
        done = subprocess.run(command, capture_output=True, text=True, timeout=300)
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads((self.folder / "summary.json").read_text())

    def test_location_and_torsion_by_the_ecus_own_torque(self):
        found = self.run_it(DRIVE)["driveline"]
        self.assertEqual(found["rows"], 6001)
        self.assertGreater(found["changes"], 10)
        self.assertGreater(found["told_percent"], 98)
        self.assertLess(found["wrong_percent"], 0.1)
        self.assertLess(found["torsion_rms_rad"], 3e-4)
        self.assertGreater(found["torsion_rms_rad"], 5e-5)
        self.assertGreater(found["reference_wrong_percent"], 10)  # the published bank, on teeth
        self.assertEqual(found["largest_request_nm"], 0)

    def test_damping_asks_once_it_is_allowed(self):
        found = self.run_it(DRIVE, "--set", "driveline.damping=1", "--set", "run.duration_s=10")["driveline"]
        self.assertGreater(found["largest_request_nm"], 1)
        self.assertLessEqual(found["largest_request_nm"], 25)

    def test_another_gear_and_an_open_clutch(self):
        more = ("--set", "run.duration_s=12", "--set", "vehicle.clutch_open_s=[4, 6]", "--set", "vehicle.shift=[{at_s = 9, gear = 3}]")
        found = self.run_it(DRIVE, *more)["driveline"]
        self.assertLess(found["told_percent"], 60)  # 2.8 s, and a second to settle after each and at the start
        self.assertGreater(found["told_percent"], 45)
        self.assertLess(found["wrong_percent"], 1)
        self.assertLess(found["torsion_rms_rad"], 5e-3)

    def test_misfires_while_the_car_shuffles(self):
        summary = self.run_it(SHUFFLE)
        misfire = summary["misfire"]
        self.assertGreater(misfire["detected"]["of"], 20)
        self.assertEqual(misfire["detected"]["hits"], misfire["detected"]["of"])
        self.assertEqual(misfire["false_alarms"]["hits"], 0)

    def test_a_gear_that_is_told_is_no_shift(self):
        rough = ("--set", "load.road_rms_nm=60", "--set", "cyclic.cov_percent=20", "--set", "encoder.jitter_deg=0.01")
        told = self.run_it(SHUFFLE, *rough)["misfire"]["not_judged"]
        silent = self.run_it(SHUFFLE, *rough, "--set", "vehicle.tell_gear=false")["misfire"]["not_judged"]
        self.assertLess(told, 0.25 * silent)
        self.assertGreater(silent, 300)

    def test_a_car_needs_a_driveline(self):
        done = subprocess.run([os.environ["SIXDEG"], "run", str(DATA / "scenarios" / "tip_in.toml"), "--set", "vehicle.gear=1"],
                              capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 2)
        self.assertIn("vehicle: needs an engine file with [driveline]", done.stderr)


if __name__ == "__main__":
    unittest.main()
