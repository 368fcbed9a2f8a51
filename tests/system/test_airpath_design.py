#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The design of the air path's observers: it is made anew as it stands in the tree, and its certificate finds what is wrong."""
import os
import pathlib
import subprocess
import sys
import tempfile
import tomllib
import unittest

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
TOOLS = ROOT / "tools" / "airpath"
MODELS = ROOT / "host_sim" / "data" / "models"
AIR_PATH, DESIGN = MODELS / "airpath_matched.toml", MODELS / "airpath_matched_design.toml"
sys.path.insert(0, str(TOOLS))
import certificate  # noqa: E402
import covariance  # noqa: E402
from air_path import AirPath  # noqa: E402


def ran(*words):
    return subprocess.run([sys.executable, *words], capture_output=True, text=True)


@unittest.skipUnless(os.environ.get("SD_FULL"), "half a minute of a solver; with SD_FULL=1")
class Design(unittest.TestCase):
    def test_the_design_in_the_tree_is_what_the_tool_makes(self):
        kept = tomllib.loads(DESIGN.read_text())
        with tempfile.TemporaryDirectory() as folder:
            out = pathlib.Path(folder) / "new.toml"
            done = ran(TOOLS / "design.py", AIR_PATH, "--out", out)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            new = tomllib.loads(out.read_text())
        for one, other in zip(kept["observer"], new["observer"]):
            for name in ("m", "e", "k_low", "k_high"):
                np.testing.assert_allclose(one[name], other[name], rtol=0.02, atol=0.02 * np.abs(one[name]).max(), err_msg=name)
        np.testing.assert_allclose(kept["decision"]["mean_kpa"], new["decision"]["mean_kpa"], rtol=0.02)

    def test_a_design_that_cannot_be_says_what_binds(self):
        done = ran(TOOLS / "design.py", AIR_PATH, "--gain", "1")
        self.assertEqual(done.returncode, 0, done.stderr)
        for line in done.stdout.splitlines():
            self.assertRegex(line, "infeasible; these bind, .*gain")
        self.assertEqual(len(done.stdout.splitlines()), 2)


class Certificate(unittest.TestCase):
    def setUp(self):
        self.path, self.file = AirPath.load(AIR_PATH), tomllib.loads(DESIGN.read_text())

    def test_it_holds(self):
        self.assertTrue(certificate.check(self.path, self.file))

    def test_it_finds_a_fault_that_is_not_decoupled(self):
        self.file["observer"][0]["m"][0][3] += 0.01
        self.assertFalse(certificate.check(self.path, self.file))

    def test_it_finds_an_observer_that_does_not_converge(self):
        self.file["observer"][1]["k_high"][0][0] -= 12
        self.assertFalse(certificate.check(self.path, self.file))


class LongRun(unittest.TestCase):
    def test_white_residuals_are_white_and_others_are_not(self):
        random = np.random.default_rng(1)
        time = np.arange(60000) * 0.01
        white = random.normal(size=(60000, 2))
        coloured = white.copy()
        for i in range(1, len(coloured)):
            coloured[i] += 0.5 * coloured[i - 1]
        self.assertTrue(covariance.Covariance(np.column_stack([time, white])).is_white())
        found = covariance.Covariance(np.column_stack([time, coloured]))
        self.assertFalse(found.is_white())
        np.testing.assert_allclose(np.diag(found.long_run), [4, 4], rtol=0.2)


if __name__ == "__main__":
    unittest.main()
