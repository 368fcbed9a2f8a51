#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""tools/look: from a recording to one page, which says first what to act on and at last what is not known."""
import os
import pathlib
import subprocess
import unittest

from sixdeg_test import Folder
from test_replay import ENGINES, RECORDINGS, square_wheel

ROOT = pathlib.Path(__file__).resolve().parents[2]


class Look(Folder):
    def look(self, *arguments):
        page = self.folder / "page.html"
        done = subprocess.run([str(ROOT / "tools/look"), *map(str, arguments), "--out", str(page)], capture_output=True, text=True,
                              timeout=240, env=os.environ, check=False)
        return done, page.read_text() if page.exists() else None

    def test_a_wheel_alone(self):
        wheel = self.folder / "wheel.csv"
        square_wheel(wheel)
        done, page = self.look(wheel)
        self.assertEqual(done.returncode, 0, done.stderr)
        for words in ("60-2", "Nothing stands out", "no engine file was given", "What is not known", "<figure class=\"chart\""):
            self.assertTrue(words in page, words)
        self.assertFalse("http:" in page or "https:" in page)
        self.assertFalse("Cylinder 1 gives" in page)

    def test_a_tooth_that_is_off_is_named(self):
        wheel = self.folder / "wheel.csv"
        pitch = 60 / 1500 / 60
        wheel.write_text("".join(f"{0.01 + (k + (0.1 if k % 60 == 30 else 0)) * pitch:.9f}\n" for k in range(20 * 60) if k % 60 < 58))
        done, page = self.look(wheel)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertTrue("Tooth 30 (counted from 0 behind the mark) comes 0.60 ± 0.00 deg late" in page, page[1200:2000])
        self.assertFalse("Tooth 31" in page)

    def test_one_that_cannot_be_followed_has_a_page_that_says_why(self):
        wheel = self.folder / "wheel.csv"
        square_wheel(wheel, revolutions=2)
        done, page = self.look(wheel, "--wheel", "60-2", "--edge", "falling", "--column", "1")
        self.assertEqual(done.returncode, 3, done.stderr)
        self.assertTrue("could not be followed" in page)

    def test_one_that_cannot_be_read_has_none(self):
        text = self.folder / "text.csv"
        text.write_text("no numbers\n")
        done, page = self.look(text)
        self.assertEqual((done.returncode, page), (2, None))
        self.assertEqual(len(done.stderr.splitlines()), 1)

    def test_a_real_one_with_its_engine(self):
        name = RECORDINGS / "real_60-2_vw_aba.csv"
        if not name.exists():
            self.skipTest(f"{name.name} is not here")
        done, page = self.look(name, ENGINES / "vw_aba.toml")
        self.assertEqual(done.returncode, 0, done.stderr)
        for words in ("60-2", "crank.inertia_kgm2 is a guess", "cylinder 1 (or 4, cam.edge_deg is a guess)", "if the inertia is as guessed",
                      "How much torque the engine or a cylinder gives: that takes the intake pressure", "swing of the torque",
                      "How much of the differences between cylinders is the wheel",
                      "nor how many N m without a measured inertia"):
            self.assertTrue(words in page, words)
        self.assertFalse('aria-label="torque over crank angle"' in page, "no torque without an intake pressure")

    def test_with_intake_pressure_there_is_a_torque(self):
        name = RECORDINGS / "real_60-2_vw_aba.csv"
        if not name.exists():
            self.skipTest(f"{name.name} is not here")
        done, page = self.look(name, ENGINES / "vw_aba.toml", "--intake", "0.4")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertTrue('aria-label="torque over crank angle"' in page)
        self.assertFalse("takes the intake pressure" in page)


if __name__ == "__main__":
    unittest.main()
