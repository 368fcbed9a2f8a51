# SPDX-License-Identifier: MIT
"""Reads what `sixdeg replay` wrote: summary.json, teeth.csv, cycles.csv. Fields: docs/files.md."""
import csv
import json
import math
import os

import numpy as np


class BadFolder(Exception):
    """A folder that cannot be drawn; the text names file and field."""


def _read_columns(path):
    with open(path, newline="", encoding="utf-8") as file:
        rows = csv.DictReader(file)
        columns = {name: [] for name in rows.fieldnames or []}
        for row in rows:
            for name in columns:
                columns[name].append(row[name] or "")
    return columns


def _numbers(texts):
    return np.array([float(t) if t else math.nan for t in texts])


class Teeth:
    """teeth.csv: one entry an edge; NaN where the cell is empty."""

    NUMBERS = ("t_s", "tooth", "angle_deg", "rpm", "torque_nm")

    def __init__(self, path):
        columns = _read_columns(path)
        for name in self.NUMBERS + ("class", "health"):
            if name not in columns:
                raise BadFolder(f"{path}: has no column {name}")
        self.t_s, self.tooth, self.angle_deg, self.rpm, self.torque_nm = (_numbers(columns[n]) for n in self.NUMBERS)
        self.kind = np.array(columns["class"])
        self.health = np.array(columns["health"])
        if self.t_s.size == 0:
            raise BadFolder(f"{path}: holds no edges")


class Replay:
    def __init__(self, folder):
        self.folder = folder
        summary_path = os.path.join(folder, "summary.json")
        try:
            with open(summary_path, encoding="utf-8") as file:
                self.summary = json.load(file)
            self.teeth = Teeth(os.path.join(folder, "teeth.csv"))
            self.cycles = _read_columns(os.path.join(folder, "cycles.csv"))
        except OSError as error:
            raise BadFolder(f"{error.filename}: {error.strerror}") from error
        except ValueError as error:
            raise BadFolder(f"{folder}: {error}") from error
        for name in ("edges", "revolutions", "sync_losses", "faults_coasted", "first_sync_edge", "rpm_last", "guess",
                     "engine", "files", "assumptions"):
            if name not in self.summary:
                raise BadFolder(f"{summary_path}: has no field {name}")

    def recording(self):
        """Name of the recording: the file of the replay that is no TOML."""
        names = [os.path.basename(n) for n in self.summary["files"]]
        return next((n for n in names if not n.endswith(".toml")), os.path.basename(self.folder))

    def pattern(self):
        guess = self.summary["guess"]
        ratio = guess.get("gap_ratio")
        text = f"{guess.get('wheel', '?')}, {guess.get('edge', '?')}"
        return f"{text}, gap ratio {ratio:.1f}" if ratio else text

    def cylinder_torque(self):
        """Mean and spread of torque a cycle, per cylinder; only cycles whose torque is valid."""
        rows = {}
        columns = self.cycles
        if not {"cylinder", "torque_nm", "health"} <= set(columns):
            return []
        for cylinder, torque, health in zip(columns["cylinder"], columns["torque_nm"], columns["health"]):
            if cylinder and torque and health == "valid":
                rows.setdefault(int(float(cylinder)), []).append(float(torque))
        return [(c, float(np.mean(v)), float(np.std(v)), len(v)) for c, v in sorted(rows.items())]

    def figures(self):
        """The short table, as (name, value) texts."""
        s, valid = self.summary, float(np.mean(self.teeth.health == "valid"))
        table = [
            ("recording", self.recording()),
            ("wheel", self.pattern()),
            ("engine", str(s["engine"].get("name", "")) or "none given"),
            ("edges", f"{s['edges']}"),
            ("revolutions", f"{s['revolutions']:.0f}"),
            ("synced at edge", "never" if s["first_sync_edge"] is None else f"{s['first_sync_edge']}"),
            ("sync losses", f"{s['sync_losses']}"),
            ("faults coasted through", f"{s['faults_coasted']}"),
            ("edges valid", f"{100 * valid:.1f} %"),
            ("speed, last revolution", "none" if s["rpm_last"] is None else f"{s['rpm_last']:.1f} rpm"),
        ]
        for cylinder, mean, spread, count in self.cylinder_torque():
            table.append((f"torque, cylinder {cylinder}", f"{mean:.1f} +- {spread:.1f} N m over {count} cycles"))
        return table

    def assumptions(self):
        """What replay took for granted; it names the engine's guessed fields there."""
        return list(self.summary["assumptions"])
