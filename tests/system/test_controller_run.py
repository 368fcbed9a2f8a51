#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""sixdeg run --transport qemu:CORE: the plant in closed loop with the firmware on an emulated controller is the same to the byte as with
the firmware in this process; also when the controller is reset or killed. What is missing is named."""
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import time
import unittest

from sixdeg_test import Folder

SIXDEG = pathlib.Path(os.environ["SIXDEG"])
SCENARIOS = pathlib.Path(__file__).resolve().parents[2] / "host_sim/data/scenarios"
FULL = "SD_FULL" in os.environ
FIGURE16 = (SCENARIOS / "figure16_1500rpm_9bar.toml",
            ["--set", f"run.duration_s={6 if FULL else 3}", "--set", "control.balance_on_s=[1.5,1000]"])
MISFIRES = (SCENARIOS / "harmonics_1500rpm_2bar.toml", ["--set", f"run={{duration_s={5 if FULL else 2}}}", "--set", "speed.rpm=3000",
                                                         "--set", "misfires.one_in=10", "--set", "load.bmep_bar=8",
                                                         "--set", "encoder.jitter_deg=0.01"])


class Controller(Folder):
    def command(self, scenario, transport, *more):
        path, settings = scenario
        return [SIXDEG, "run", path, "--nominal", *settings, "--transport", transport, "--out", self.folder / transport, *more]

    def run_it(self, scenario, transport, *more):
        done = subprocess.run(self.command(scenario, transport, *more), capture_output=True, text=True, timeout=200)
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads((self.folder / transport / "summary.json").read_text())

    def same(self, transport, files=("teeth.csv", "cycles.csv")):
        for name in files:
            here, there = ((self.folder / folder / name).read_bytes() for folder in ("inproc", transport))
            self.assertGreater(here.count(b"\n"), 20)
            self.assertTrue(here == there, f"{name} differs")

    def closed_loop(self, scenario, transport, *more):
        logs = [] if more else [["--record", self.folder / name] for name in ("a.sdlog", "b.sdlog")]
        here = self.run_it(scenario, "inproc", *(logs[0] if logs else more))
        there = self.run_it(scenario, transport, *(logs[1] if logs else more))
        self.same(transport)
        if logs:
            self.assertTrue((self.folder / "a.sdlog").read_bytes() == (self.folder / "b.sdlog").read_bytes(), "event logs differ")
        self.assertEqual(there["controller"]["edges_unanswered"], 0)
        for key in set(here) - {"realtime_factor", "perturbed"}:
            self.assertEqual(here[key], there[key], key)
        return there

    def test_figure_16_is_the_same_to_the_byte(self):
        there = self.closed_loop(FIGURE16, "qemu:cortex-m7")
        self.assertIsNotNone(there["balance"], "trims were on")
        cost = there["controller"]["tooth_instructions"]
        self.assertGreater(cost["worst"], cost["average"])
        self.assertTrue(2000 < cost["average"] < 6000, cost)

    def test_so_is_a_run_with_misfires(self):
        there = self.closed_loop(MISFIRES, "qemu:cortex-m4f")
        self.assertGreater(there["misfires_true"], 5)
        self.assertEqual(there["misfire"]["detected"]["hits"], there["misfire"]["detected"]["of"])

    def test_so_is_one_whose_controller_is_reset(self):
        there = self.closed_loop(MISFIRES, "qemu:m7", "--restart", "1")
        self.assertEqual((there["controller"]["restarts"], there["controller"]["died"]), (1, 0))
        self.assertGreaterEqual(there["sync_losses"], 1)

    def test_one_whose_controller_is_killed_goes_on(self):
        path, settings = FIGURE16
        going = subprocess.Popen(self.command((path, settings + ["--set", "run.duration_s=10"]), "qemu:m7"), stdout=subprocess.PIPE,
                                 stderr=subprocess.PIPE, text=True)
        killed = None
        until = time.monotonic() + 60
        while killed is None and time.monotonic() < until and going.poll() is None:
            for child in pathlib.Path(f"/proc/{going.pid}/task/{going.pid}/children").read_text().split():
                if pathlib.Path(f"/proc/{child}/comm").read_text().startswith("qemu-system"):
                    time.sleep(0.3)
                    os.kill(killed := int(child), signal.SIGKILL)
            time.sleep(0.02)
        out, err = going.communicate(timeout=200)
        self.assertEqual(going.returncode, 0, err)
        self.assertIn("has died and is started anew", err)
        summary = json.loads((self.folder / "qemu:m7" / "summary.json").read_text())
        self.assertEqual(summary["controller"]["died"], 1)
        self.assertEqual(summary["wrong_teeth"], 0)
        self.assertIn(",valid,", (self.folder / "qemu:m7" / "teeth.csv").read_text().splitlines()[-1] + ",", "the angle is known again")

    def refused(self, *words, program=SIXDEG, path=None):
        done = subprocess.run([program, "run", FIGURE16[0], "--nominal", *words], capture_output=True, text=True, timeout=60,
                              env=os.environ | ({"PATH": path} if path is not None else {}))
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
        return done.stderr

    def test_what_is_missing_is_named(self):
        self.assertIn("tools/setup --cross", self.refused("--transport", "qemu:m7", path=str(self.folder)))
        self.assertIn("qemu:cortex-m4f", self.refused("--transport", "qemu:cortex-m33"))
        alone = self.folder / "sixdeg"
        shutil.copy(SIXDEG, alone)
        message = self.refused("--transport", "qemu:cortex-m7", program=alone)
        self.assertIn("tools/build cortex-m7 sixdeg_image", message)
        self.assertIn("--restart", self.refused("--transport", "lcm", "--restart", "1"))


if __name__ == "__main__":
    sys.exit(unittest.main())
