# SPDX-License-Identifier: MIT
"""Reads what `sixdeg run` wrote of misfires: summary.json, cycles.csv. Fields: docs/reference/files.md."""
import numpy as np

from folder import BadFolder, Table, read_summary, require

FIELDS = ("scenario", "misfire", "misfires_true", "engine", "set", "seed", "parameters", "number")
RATES = ("detected", "false_alarms")
NUMBERS = ("t_s", "cycle", "cylinder", "misfire_true", "misfire_index", "misfire_limit", "misfire_verdict", "misfire_acceleration")
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
