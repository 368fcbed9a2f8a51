# SPDX-License-Identifier: MIT
"""What the tests of commands share."""
import csv
import pathlib
import subprocess
import sys
import tempfile
import unittest


def table(path):
    """Rows of a CSV file, each a dictionary by column."""
    with path.open() as file:
        return list(csv.DictReader(file))


class Folder(unittest.TestCase):
    """A test with a folder of its own, self.folder."""

    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.folder = pathlib.Path(temporary.name)
        self.addCleanup(temporary.cleanup)


class ReportFolder(Folder):
    """A test of tools/report/report.py, which writes self.page."""

    SCRIPT = pathlib.Path(__file__).resolve().parents[2] / "tools/report/report.py"

    def setUp(self):
        super().setUp()
        self.page = self.folder / "report.html"

    def report(self, *arguments):
        return subprocess.run([sys.executable, str(self.SCRIPT), "--out", str(self.page), *map(str, arguments)],
                              capture_output=True, text=True, check=False)

    def drawn(self, *arguments):
        done = self.report(*arguments)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return self.page.read_text()
