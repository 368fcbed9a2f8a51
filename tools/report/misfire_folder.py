# SPDX-License-Identifier: MIT
"""Reads what `sixdeg run` wrote of misfires: summary.json, cycles.csv; and `sixdeg study misfire`: curves.csv. Fields:
docs/reference/files.md, docs/results/misfire-study.md."""
import numpy as np

from folder import BadFolder, Table, read_summary, require

FIELDS = ("scenario", "misfire", "misfires_true", "engine", "set", "seed", "parameters", "number")
RATES = ("detected", "false_alarms")
NUMBERS = ("t_s", "cycle", "cylinder", "misfire_true", "misfire_index", "misfire_limit", "misfire_verdict", "misfire_acceleration")
CURVES = ("kind", "physics", "road_rms_nm", "jitter_deg", "method", "false_percent", "found", "missed")
METHODS = ("monitor", "FOLSMO", "FOSMO", "ROO", "speed delta", "running mean")
LIMIT = "monitor's limit"
LEAST_FALSE_PERCENT = 0.005  # where a limit without any false alarm is drawn
HEALTHY, PARTIAL, MISFIRE, NOT_JUDGED = range(4)


class MisfireRun:
    """A run with misfires. Arrays have an entry a firing, in order of time; NaN where a cell is empty."""

    HEADER = ("", "firings judged", "misfires", "found", "overlooked", "false alarms")

    def __init__(self, folder):
        self.folder = folder
        self.summary = read_summary(folder, FIELDS)
        self.score = require(f"{folder}/summary.json: misfire", self.summary["misfire"], RATES + ("method", "separation"))
        table = Table(folder, "cycles.csv", NUMBERS)
        columns = [table.numbers(name) for name in NUMBERS]
        order = np.argsort(columns[0], kind="stable")
        self.t_s, self.cycle, self.cylinder, truth, self.index, self.limit, verdict, self.acceleration = (c[order] for c in columns)
        self.judged = np.isfinite(verdict) & (verdict != NOT_JUDGED)
        self.missed, self.named = truth == 1, verdict == MISFIRE
        if not self.judged.any():
            raise BadFolder(f"{table.path}: misfire_verdict: no firing was judged")

    def title(self):
        return f"{self.summary['scenario']}, judged by {self.method()}"

    def method(self):
        return self.score["method"]

    def groups(self):
        """(what, which firings) that a picture tells apart; every judged firing is in one."""
        judged, missed, named = self.judged, self.missed, self.named
        return (("healthy, judged so", judged & ~missed & ~named), ("misfire, found", judged & missed & named),
                ("misfire, overlooked", judged & missed & ~named), ("healthy, called a misfire", judged & ~missed & named))

    def counts(self):
        """By physical cylinder: (judged, misfires, found, overlooked, false alarms)."""
        of = {}
        for cylinder in np.unique(self.cylinder).astype(int):
            here = (self.cylinder == cylinder) & self.judged
            found = int((here & self.missed & self.named).sum())
            misfires = int((here & self.missed).sum())
            of[int(cylinder)] = (int(here.sum()), misfires, found, misfires - found, int((here & ~self.missed & self.named).sum()))
        return of

    def figures(self):
        rows = [(f"cylinder {cylinder}", *map(str, counts)) for cylinder, counts in self.counts().items()]
        return [*rows, ("all", *map(str, np.sum(list(self.counts().values()), axis=0)))]

    def assumptions(self):
        return []


class MisfireCurves:
    """Misfires found over the share of false alarms: a curve a detector, kind of engine, physics and road."""

    HEADER = ("", "found at 0.1 % false alarms")

    def __init__(self, folder):
        self.folder = folder
        table = Table(folder, "curves.csv", CURVES)
        if not len(table.rows):
            raise BadFolder(f"{table.path}: is empty")
        self.text = {name: table.texts(name) for name in ("kind", "physics", "method")}
        self.number = {name: table.numbers(name) for name in CURVES if name not in self.text}
        cells = Table(folder, "cells.csv", ("rpm", "bmep_bar"))
        self.points = [sorted({float(x) for x in cells.numbers(name)}) for name in ("rpm", "bmep_bar")]

    def where(self):
        """"1000, 1500 rpm, 1 bar"."""
        return ", ".join(f"{', '.join(f'{x:g}' for x in values)} {unit}" for values, unit in zip(self.points, ("rpm", "bar")))

    def title(self):
        return "Six detectors of misfires"

    def kinds(self):
        return list(dict.fromkeys(self.text["kind"]))

    def physics(self):
        return list(dict.fromkeys(self.text["physics"]))

    def roads(self):
        return list(dict.fromkeys(zip(self.number["road_rms_nm"], self.number["jitter_deg"])))

    @staticmethod
    def words(kind, road):
        surface = f"rough road {road[0]:g} N m" if road[0] > 0 else "smooth road"
        return f"{kind}, {surface}, {road[1]:g} deg"

    def rows(self, kind, physics, road, method):
        return ((self.text["kind"] == kind) & (self.text["physics"] == physics) & (self.text["method"] == method)
                & (self.number["road_rms_nm"] == road[0]) & (self.number["jitter_deg"] == road[1]))

    def of(self, kind, physics, road, method):
        """False alarms and misfires found, both in percent."""
        rows = self.rows(kind, physics, road, method)
        missed = self.number["missed"][rows]
        return self.number["false_percent"][rows], 100 * self.number["found"][rows] / np.maximum(missed, 1)

    def misfires(self, kind, physics, road):
        return int(self.number["missed"][self.rows(kind, physics, road, LIMIT)][0])

    def figures(self):
        """Of the last road, which is the hardest."""
        kind, physics, road = self.kinds()[0], self.physics()[-1], self.roads()[-1]
        rows = []
        for method in METHODS:
            alarms, found = self.of(kind, physics, road, method)
            rows.append((f"{method}, {self.words(kind, road)}", f"{np.interp(0.1, alarms, found):.1f} %"))
        return rows

    def assumptions(self):
        return []
