# SPDX-License-Identifier: MIT
"""What folders of `sixdeg replay` and `sixdeg run` have in common. Fields: docs/reference/files.md."""
import csv
import json
import math
import os

import numpy as np


class BadFolder(Exception):
    """A folder that cannot be drawn; the text is one line and names file and field."""


def read_file(path):
    try:
        with open(path, "rb") as file:
            return file.read()
    except OSError as error:
        raise BadFolder(f"{path}: {error.strerror}") from error


def read_summary(folder, fields):
    """summary.json, an object with these fields."""
    path = os.path.join(folder, "summary.json")
    try:
        summary = json.loads(read_file(path))
    except ValueError as error:
        raise BadFolder(f"{path}: {error}") from error
    return require(path, summary, fields)


def require(place, table, fields):
    """The table, if it is one and has these fields."""
    if not isinstance(table, dict):
        raise BadFolder(f"{place}: is no table")
    for name in fields:
        if name not in table:
            raise BadFolder(f"{place}: has no field {name}")
    return table


class Table:
    """A CSV file by columns: texts by name, or numbers with NaN where the cell is empty."""

    def __init__(self, folder, name, columns):
        self.path = os.path.join(folder, name)
        try:
            rows = csv.DictReader(read_file(self.path).decode("utf-8").splitlines())
            self.rows = list(rows)
        except (ValueError, csv.Error) as error:
            raise BadFolder(f"{self.path}: {error}") from error
        self.columns = rows.fieldnames or []
        for column in columns:
            if column not in self.columns:
                raise BadFolder(f"{self.path}: has no column {column}")

    def texts(self, column):
        return np.array([row[column] or "" for row in self.rows], dtype=str)

    def numbers(self, column):
        try:
            return np.array([float(row[column]) if row[column] else math.nan for row in self.rows])
        except ValueError as error:
            raise BadFolder(f"{self.path}: {column}: {error}") from error
