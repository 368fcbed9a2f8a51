# SPDX-License-Identifier: MIT
"""A recording with cylinder pressure beside crank teeth: its columns, and the crank angle that sixdeg gives each of its samples."""
import csv
import json
import pathlib
import re
import subprocess

import numpy as np

KNOWN = ("tooth", "coasted")


class Unusable(Exception):
    """Why a recording cannot be used, one sentence."""


def columns(path):
    """Numbers of a text recording, a row a sample, and the names of its columns (numbers where it has none)."""
    names, skip = None, 0
    with open(path, encoding="utf-8", errors="replace") as file:
        for line in file:
            cells = [c.strip().strip('"') for c in re.split(r"[,;\t]|\s+", line.strip()) if c.strip()]
            if cells and all(is_number(c) for c in cells):
                break
            names, skip = cells or names, skip + 1
    split = next((c for c in ",;" if c in line), None)
    numbers = np.genfromtxt(path, delimiter=split, skip_header=skip, invalid_raise=False)
    if numbers.ndim != 2 or len(numbers) < 100:
        raise Unusable(f"{path}: holds no table of numbers")
    return numbers, names or [str(i) for i in range(numbers.shape[1])]


def is_number(text):
    try:
        float(text)
    except ValueError:
        return False
    return True


def column(names, wanted, path):
    """Index of a column by its number from 0 or its name."""
    if wanted.isdigit() and int(wanted) < len(names):
        return int(wanted)
    found = [i for i, name in enumerate(names) if wanted.lower() in name.lower()]
    if len(found) != 1:
        raise Unusable(f"{path}: column '{wanted}' is not one of {', '.join(names)}")
    return found[0]


def replay(sixdeg, recording, engine, out, options=()):
    """Rows of each table of `sixdeg replay`, and its summary."""
    done = subprocess.run([str(sixdeg), "replay", str(recording), "--engine", str(engine), "--out", str(out), *options],
                          capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise Unusable(f"{recording}: {done.stderr.strip() or 'sixdeg replay failed'}")
    return Replayed(out)


class Replayed:
    """What sixdeg says of a recording."""

    def __init__(self, folder):
        folder = pathlib.Path(folder)
        self.summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
        self.teeth, self.firings, self.work = (self.table(folder / f"{name}.csv") for name in ("teeth", "firings", "work"))
        known = [t for t in self.teeth if t["class"] in KNOWN]
        if len(known) < 120:
            raise Unusable(f"{folder}: the crank angle is known for less than two revolutions")
        self.t_s = numbers(known, "t_s")
        self.deg = np.unwrap(numbers(known, "angle_deg"), period=720)
        if np.any(np.diff(self.deg) <= 0):
            raise Unusable("the crank angle is lost within the recording")
        self.known = known

    @staticmethod
    def table(path):
        with open(path, encoding="utf-8") as file:
            return list(csv.DictReader(file))

    def angle(self, t_s):
        """Crank angle without end, deg, linear between teeth; NaN outside of them."""
        return np.interp(t_s, self.t_s, self.deg, left=np.nan, right=np.nan)


def numbers(rows, name):
    """A column as numbers, NaN where a cell is empty."""
    return np.array([float(row[name]) if row[name] else np.nan for row in rows])
