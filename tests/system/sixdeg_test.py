# SPDX-License-Identifier: MIT
"""What the tests of commands share."""
import base64
import csv
import json
import pathlib
import re
import struct
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


def charts(page):
    """The pictures of a page of tools/report: what plotly.js is given."""
    return [json.loads(data) for data in re.findall(r'<figure class="chart".*?<script type="application/json">(.*?)</script>', page, re.S)]


def values(of):
    """Numbers of a trace, as the page packs them."""
    return struct.unpack(f"<{len(base64.b64decode(of['bdata'])) // 4}f", base64.b64decode(of["bdata"]))


def outside(page):
    """What a page asks of other places, the packed library aside: it should be nothing."""
    return re.findall(r"https?://[^\s\"<]*|file://[^\s\"<]*|\bsrc=|<link", page)


class ReportFolder(Folder):
    """A test of tools/report/report.py, which writes self.page."""

    SCRIPT = pathlib.Path(__file__).resolve().parents[2] / "tools/report/report.py"

    def setUp(self):
        super().setUp()
        self.page = self.folder / "report.html"

    def report(self, *arguments):
        return subprocess.run([sys.executable, str(self.SCRIPT), "--out", str(self.page), *map(str, arguments)],
                              capture_output=True, text=True, check=False)

    def says(self, page, words):
        """A page is long, so that only the words are shown where they are missing."""
        self.assertTrue(words in page, words)

    def drawn(self, *arguments):
        done = self.report(*arguments)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        page = self.page.read_text()
        # A paper's figure names its estimator and what is not at its default, or says that it has none.
        for anchor, section in re.findall(r'<section id="(figure-[^"]+)">(.*?)</section>', page, re.S):
            self.assertRegex(section, "at their defaults|Set beside|Its settings|without an (?:estimator|observer)|Here L |A formula",
                             anchor)
        return page
