# SPDX-License-Identifier: MIT
"""Reads what `sixdeg replay` wrote: summary.json, teeth.csv, cycles.csv. Fields: docs/reference/files.md."""
import os

import numpy as np

from folder import BadFolder, Table, read_summary

FIELDS = ("edges", "revolutions", "sync_losses", "faults_coasted", "first_sync_edge", "rpm_last", "guess", "engine",
          "files", "assumptions")


class Teeth:
    """teeth.csv: one entry an edge; NaN where the cell is empty."""

    NUMBERS = ("t_s", "tooth", "angle_deg", "rpm", "torque_nm")

    def __init__(self, folder):
        table = Table(folder, "teeth.csv", self.NUMBERS + ("class", "health", "fourier_nm"))
        self.t_s, self.tooth, self.angle_deg, self.rpm, self.torque_nm = (table.numbers(n) for n in self.NUMBERS)
        self.kind, self.health = table.texts("class"), table.texts("health")
        self.fourier_nm = table.numbers("fourier_nm")
        self.torque_source = "the filter on tooth times"
        if not np.isfinite(self.torque_nm).any():  # no engine file, or the filter is off
            self.torque_nm, self.torque_source = self.fourier_nm, "the Fourier observer"
        if self.t_s.size == 0:
            raise BadFolder(f"{table.path}: holds no edges")


class Replay:
    HEADER = ()

    def __init__(self, folder):
        self.folder = folder
        self.summary = read_summary(folder, FIELDS)
        self.teeth = Teeth(folder)
        self.cycles = Table(folder, "cycles.csv", ("cycle", "cylinder", "torque_nm", "health", "fourier_nm", "fourier_health"))

    def lacks_intake(self):
        """Whether the replay had no intake pressure, without which a torque has no level. An event log carries its own readings."""
        return self.summary.get("inputs", {}).get("intake") is False

    def title(self):
        """Name of the recording: the file of the replay that is no TOML."""
        names = [os.path.basename(n) for n in self.summary["files"]]
        return next((n for n in names if not n.endswith(".toml")), os.path.basename(self.folder))

    def pattern(self):
        guess = self.summary["guess"]
        ratio = guess.get("gap_ratio")
        text = f"{guess.get('wheel', '?')}, {guess.get('edge', '?')}"
        return f"{text}, gap ratio {ratio:.1f}" if ratio else text

    def contributions(self):
        """By physical cylinder: torque less the mean of all, N m, one entry a cycle.

        A recording of teeth lacks the intake pressure, which moves all cylinders alike: only differences count.
        """
        filter_tells = np.isin(self.cycles.texts("health"), ("valid", "degraded")).any()
        health, torque = ("health", "torque_nm") if filter_tells else ("fourier_health", "fourier_nm")
        told = np.isin(self.cycles.texts(health), ("valid", "degraded"))
        cycle, cylinder, torque = (self.cycles.numbers(n) for n in ("cycle", "cylinder", torque))
        cylinders = np.unique(cylinder[np.isfinite(cylinder)])
        differences = {int(c): [] for c in cylinders}
        for one in np.unique(cycle[told]):
            rows = told & (cycle == one) & np.isfinite(torque)
            if len(cylinders) < 2 or rows.sum() != len(cylinders):
                continue
            for c, value in zip(cylinder[rows], torque[rows] - torque[rows].mean()):
                differences[int(c)].append(float(value))
        return {c: np.array(values) for c, values in differences.items() if values}

    def figures(self):
        """The short table, as (name, value) texts."""
        s, valid = self.summary, float(np.mean(self.teeth.health == "valid"))
        table = [
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
        for cylinder, values in self.contributions().items():
            table.append((f"cylinder {cylinder} less the mean",
                          f"{values.mean():+.1f} N m, sd {values.std():.1f} over {values.size} cycles"))
        return table

    def assumptions(self):
        """What replay took for granted; it names the engine's guessed fields there."""
        return list(self.summary["assumptions"])
