# SPDX-License-Identifier: MIT
"""A folder of `sixdeg study driveline figure-6 --out FOLDER`: document 003's Figure 6."""
import numpy as np

from folder import BadFolder, Table

COLUMNS = ("time_s", "torsion_rad", "estimate_rad", "r1_rpm", "r2_rpm", "r3_rpm", "location", "found")


class Driveline:
    HEADER = ("change at", "from", "to", "found later by")

    def __init__(self, path):
        table = Table(path, "figure_6.csv", COLUMNS)
        self.columns = {name: table.numbers(name) for name in COLUMNS}
        if not len(table.rows):
            raise BadFolder(f"{table.path}: is empty")

    def title(self):
        return "Driveline: document 003, figure 6"

    def _changes(self, name):
        """When, from and to of each change of a column."""
        values = self.columns[name]
        return [(self.columns["time_s"][i + 1], int(values[i]), int(values[i + 1])) for i in np.flatnonzero(np.diff(values))]

    def figures(self):
        """A row a change: when it was, and how late it was found, before the next one."""
        real, found = self._changes("location"), self._changes("found")
        ends = [change[0] for change in real[1:]] + [np.inf]
        rows = []
        for (time, before, after), end in zip(real, ends):
            late = next((t - time for t, _, to in found if time <= t < end and to == after), None)
            rows.append((f"{time:.3f} s", str(before), str(after), "not found" if late is None else f"{1e3 * late:.0f} ms"))
        return rows

    def assumptions(self):
        return []
