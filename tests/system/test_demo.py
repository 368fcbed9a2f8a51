#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""tools/demo as a new user runs it, and its report in a browser. A minute of two cores, so with SD_FULL=1 alone."""
import os
import pathlib
import subprocess
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
REPORT = ROOT / "out/demo/report.html"


@unittest.skipUnless("SD_FULL" in os.environ, "a minute; with SD_FULL=1")
class Demo(unittest.TestCase):
    def test_the_report_is_made_and_every_picture_of_it_drawn(self):
        done = subprocess.run([ROOT / "tools/demo"], capture_output=True, text=True, timeout=1000, check=False)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertIn("demo: out/demo/report.html is ready", done.stdout)
        self.assertFalse((ROOT / "out/demo.partial").exists())
        looked = subprocess.run([sys.executable, ROOT / "tests/system/test_report_browser.py"], capture_output=True, text=True, timeout=600,
                                check=False, env=os.environ | {"SD_REPORT": str(REPORT)})
        self.assertEqual(looked.returncode, 0, looked.stderr)


if __name__ == "__main__":
    unittest.main()
