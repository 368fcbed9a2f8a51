#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Cylinder pressure into work and torque (tools/pressure), and the page of tools/evidence: docs/results/evidence.md."""
import json
import os
import pathlib
import subprocess
import sys
import unittest

import numpy as np

from sixdeg_test import Folder

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools/pressure"))
import cylinder  # noqa: E402  (the tool's folder is no package)
import evidence  # noqa: E402
import gas_exchange  # noqa: E402
import observers  # noqa: E402
import page  # noqa: E402

ENGINE = "host_sim/data/engines/single_generator.toml"
RECORDING = "../shared/data/real_single_pressure_full_load.txt"


class Pressure(unittest.TestCase):
    """A cylinder whose pressure is known, read by a sensor that knows no zero."""

    def setUp(self):
        self.geometry = cylinder.Geometry.read(ROOT / ENGINE)
        self.deg = np.arange(-800.0, 3 * 720, 0.2)
        local = (self.deg + 360) % 720 - 360
        v = self.geometry.volume(local) / self.geometry.volume(180.0)
        closed, self.top = np.abs(local) < 180, 0.8
        burned = np.where(local > 0, 1.9, 1.0) # heat at once at TDC
        self.true_bar = np.where(closed, self.top * burned * v ** -1.32, self.top)
        self.t_s = self.deg / 18000

    def cycles(self, shift_deg=0.0, intake_bar=None, off_deg=0.0):
        return cylinder.cycles_of(self.geometry, self.deg + off_deg, self.t_s, self.true_bar + 30, 0.0, intake_bar, shift_deg)

    def test_level_is_found_by_compression_and_by_intake(self):
        for intake in (None, self.top):
            cycles = self.cycles(intake_bar=intake)
            self.assertEqual(len(cycles), 3)
            for cycle in cycles:
                self.assertAlmostEqual(cycle.level_bar, -30, delta=0.02)
        self.assertAlmostEqual(cylinder.pressure_at_bdc(self.geometry, self.cycles()), self.top, delta=0.01)

    def test_work_is_that_of_the_closed_form_and_does_not_need_the_level(self):
        v1, v2 = self.geometry.volume(180.0), self.geometry.volume(0.0)
        line = 1e5 * self.top / 0.32 * v1 * ((v1 / v2) ** 0.32 - 1)
        for intake in (None, 5.0):
            self.assertAlmostEqual(self.cycles(intake_bar=intake)[0].work_j, 0.9 * line, delta=0.01 * line)

    def test_torque_is_what_the_work_comes_from(self):
        cycle = self.cycles()[1]
        self.assertAlmostEqual(np.trapezoid(cycle.torque_nm, np.radians(cycle.deg)), cycle.work_j, delta=0.01 * cycle.work_j)

    def test_tdc_is_where_compression_is_polytropic(self):
        for off in (-2.0, 0.0, 1.5):
            shift, sd = cylinder.tdc_shift(self.geometry, self.deg + off, self.true_bar + 30, 0.0)
            self.assertAlmostEqual(shift, off, delta=0.5)
            self.assertTrue(0.5 < sd < 2.0, "an exponent off by 0.02 moves it by more than a degree")


class OneOfSeveral(unittest.TestCase):
    def test_change_is_compared_with_the_change(self):
        """What is told of one cylinder of several is how it differs from the cycle before."""
        work = [100.0, 104.0, 98.0, 101.0, 95.0]
        cycles = [cylinder.Cycle(720.0 * i, None, None, None, 0.0, w, None) for i, w in enumerate(work)]
        told = {i: work[i] - work[i - 1] for i in range(1, 5)}
        figures = evidence.work_figures(cycles, {observers.CHANGE: told, observers.FILTER_FIRING: {}})
        self.assertIsNone(figures[observers.FILTER_FIRING])
        self.assertEqual(figures[observers.CHANGE].count, 4)
        self.assertAlmostEqual(figures[observers.CHANGE].correlation, 1)
        self.assertAlmostEqual(figures[observers.CHANGE].rms_percent, 0)
        told[2] += 5
        self.assertAlmostEqual(evidence.work_figures(cycles, {observers.CHANGE: told})[observers.CHANGE].rms_percent,
                               100 * np.std([5, 0, 0, 0]) / np.mean(work))


class GasExchange(unittest.TestCase):
    def test_pattern_is_what_the_teeth_have(self):
        """A crank that a steady load slows, and whose wheel is off by 0.2 deg; its mean and slope are the crank's own."""
        crank = gas_exchange.Crank(ROOT / ENGINE)
        crank.mass = 0.0 # so that what three fitted numbers take is a parabola
        true = 0.2 * np.random.default_rng(3).normal(size=60)
        fine = np.arange(178, 542.001, 0.05)
        slowness = np.sqrt(crank.at(fine) / 2 / (960 - 8 * np.radians(fine - 180))) * np.radians(0.05)
        passed = np.concatenate([[0], np.cumsum((slowness[1:] + slowness[:-1]) / 2)])
        deg = np.arange(180, 540, 6.0)
        late = gas_exchange.lateness_of(crank, deg, np.interp(deg + true, fine, passed))
        line = np.polynomial.polynomial.polyfit(deg, late - true, 2)
        self.assertLess(np.abs(late - true - np.polynomial.polynomial.polyval(deg, line)).max(), 0.005)


class Page(Folder):
    def setUp(self):
        super().setUp()
        if not (ROOT / RECORDING).exists():
            self.skipTest("the recording is not here")

    def evidence(self, *options):
        out, figures = self.folder / "evidence.md", self.folder / "figures.json"
        done = subprocess.run([ROOT / "tools/evidence", ENGINE, RECORDING, "--pressure", "1", *options, "--out", out, "--json", figures],
                              cwd=ROOT, capture_output=True, text=True, check=False, env=os.environ)
        self.assertEqual(done.returncode, 0, done.stderr)
        return out.read_text(), json.loads(figures.read_text())["real_single_pressure_full_load.txt"]

    def test_docs_say_what_the_command_says(self):
        text, figures = self.evidence("--bar", "51.95")
        docs = (ROOT / "docs/results/evidence.md").read_text()
        self.assertEqual(text.replace(f"--out {self.folder}", "--out docs/results"), docs, "run the command of docs/results/evidence.md")
        same = figures["work"]["0"]["energy at the same teeth (`work.cycle`)"]
        self.assertGreaterEqual(same["correlation"], page.GOALS["correlation"])
        self.assertLessEqual(same["rms_percent"], page.GOALS["rms"])
        best = figures["waveform"]["from the gas exchange of the first half, +0"]["filter"]
        self.assertGreaterEqual(best["r2"], page.GOALS["r2"])
        self.assertTrue((self.folder / "pictures/evidence_real_single_pressure_full_load.png").exists())

    def test_what_cannot_be_used_is_said_in_a_line(self):
        done = subprocess.run([ROOT / "tools/evidence", ENGINE, RECORDING, "--pressure", "bar"], cwd=ROOT, capture_output=True, text=True,
                              check=False, env=os.environ)
        self.assertEqual((done.returncode, done.stderr.count("\n")), (2, 1), done.stderr)
        self.assertIn("column 'bar' is not one of 0, 1, 2", done.stderr)


if __name__ == "__main__":
    unittest.main()
