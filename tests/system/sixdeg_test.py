# SPDX-License-Identifier: MIT
"""What the tests of commands share."""
import csv
import pathlib
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
