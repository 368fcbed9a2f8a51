# SPDX-License-Identifier: MIT
"""Document 001's figures from two folders: `sixdeg study airpath model --out FOLDER` (Figures 4 to 7), and `sixdeg run` of its section 7
(Figures 8 and 9)."""
import numpy as np

from folder import BadFolder, Table, read_summary

MODEL = ("t_s", "rpm", "fuel_gps", "air_gps", "egr", "vgt", "intake_kpa", "intake_model_kpa", "exhaust_kpa", "exhaust_model_kpa",
         "intake_read_kpa", "exhaust_read_kpa", "drawn_gps", "drawn_model_gps", "leaving_gps", "leaving_model_gps")
RESIDUALS = ("airpath.residual[1]", "airpath.residual[2]")
DECISIONS = tuple(f"airpath.decision[{i}]" for i in range(1, 5))
RUN = ("t_s", "egr_command", "vgt_command", "egr_read", "vgt_read", "egr_true", "vgt_true", "airpath.fault", "airpath.phase",
       "airpath.since", *RESIDUALS, *DECISIONS)
NAMES = ("none", "EGR valve", "VGT vanes", "both or another")
SETTLED_S, OFF = 2, 0.02  # of the model's drive; a position this far from its command is faulty, if for long


def numbers(folder, file, columns):
    table = Table(folder, file, columns)
    if not table.rows:
        raise BadFolder(f"{table.path}: is empty")
    return {name: table.numbers(name) for name in columns}


class AirPathModel:
    """The four-state model beside the full air path."""
    HEADER = ("error of the mean", "mean", "largest")

    def __init__(self, path):
        self.columns = numbers(path, "figures_4_to_7.csv", MODEL)

    def title(self):
        return "Air path: document 001, figures 4 to 7"

    def figures(self):
        data, rows = self.columns, []
        settled = data["t_s"] >= SETTLED_S
        for name, what in (("intake_{}kpa", "intake pressure"), ("exhaust_{}kpa", "exhaust pressure"),
                           ("drawn_{}gps", "gas into the cylinders"), ("leaving_{}gps", "gas out of them")):
            true = data[name.format("")][settled]
            off = 100 * np.abs(data[name.format("model_")][settled] - true) / true.mean()
            rows.append((what, f"{off.mean():.2f} %", f"{off.max():.2f} %"))
        return rows

    def assumptions(self):
        return []


class AirPathRun:
    """Faults of valve and vanes through the firmware."""
    HEADER = ("fault", "from", "named", "delay")

    def __init__(self, path):
        self.summary = read_summary(path, ("set", "parameters"))
        self.columns = numbers(path, "airpath.csv", RUN)
        self.sigma = [self._healthy(name).std() or 1.0 for name in RESIDUALS]

    def title(self):
        return "Air path: document 001, section 7, figures 8 and 9"

    def faults(self):
        """(actuator, from, to) of each time for which a true position is off its command; the actuator's way is no fault."""
        data, found = self.columns, []
        for number, name in ((1, "egr"), (2, "vgt")):
            off = np.abs(data[name + "_true"] - data[name + "_command"]) > OFF
            edges = np.flatnonzero(np.diff(np.concatenate([[0], off, [0]])))
            found += [(number, data["t_s"][a], data["t_s"][b - 1]) for a, b in zip(edges[::2], edges[1::2]) if b - a > 50]
        return sorted(found, key=lambda fault: fault[1])

    def _healthy(self, name):
        data = self.columns
        first = min((start for _, start, _ in self.faults()), default=np.inf)
        values = data[name][(data["airpath.phase"] == 3) & (data["t_s"] < first)]
        if not len(values):
            raise BadFolder("airpath.csv: has no time without a fault in which the ecu decides")
        return values

    def figures(self):
        data, rows = self.columns, []
        for number, start, end in self.faults():
            after = (data["t_s"] >= start) & (data["t_s"] <= end) & (data["airpath.fault"] > 0)
            named = data["airpath.fault"][after]
            first = data["t_s"][after][0] - start if len(named) else None
            rows.append((NAMES[number], f"{start:.2f} s", NAMES[int(named[0])] if len(named) else "nothing",
                         "not found" if first is None else f"{first:.2f} s"))
        return rows

    def incidence(self):
        """Table 2 as measured: mean of each residual in the last half of each fault, in standard deviations of a healthy one."""
        data, rows = self.columns, []
        for number, start, end in self.faults():
            late = (data["t_s"] >= (start + end) / 2) & (data["t_s"] <= end)
            rows.append((NAMES[number], *(f"{data[name][late].mean() / sigma:+.1f}" for name, sigma in zip(RESIDUALS, self.sigma))))
        return rows

    def assumptions(self):
        return []
