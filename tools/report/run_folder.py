# SPDX-License-Identifier: MIT
"""Reads what `sixdeg run` wrote: summary.json, teeth.csv. Fields: docs/reference/files.md."""
import hashlib
import tomllib

import numpy as np

import pole_placement
from folder import BadFolder, Table, read_file, read_summary, require

FIELDS = ("scenario", "torque", "cylinders", "perturbed", "number", "seed", "set", "parameters", "engine", "files")
GROUP_FIELDS = {"torque": ("cycles_measured", "rms_true_percent", "rms_projection_percent", "shift_deg"),
                "cylinders": ("true_nm", "estimate_nm", "sd_nm", "imbalance_percent", "imbalance_rms_percent",
                              "mean_error_percent"),
                "calibration": ("inertia_percent", "reciprocating_percent", "wheel_offset_deg", "ranges")}
ACCURACY = (
    ("cylinders", "imbalance_percent", "imbalance, worst cylinder", "{:.2f} %"),
    ("cylinders", "imbalance_rms_percent", "imbalance, rms of the cylinders", "{:.2f} %"),
    ("cylinders", "mean_error_percent", "mean of all cylinders", "{:+.2f} %"),
    ("torque", "rms_true_percent", "waveform, rms", "{:.2f} %"),
    ("torque", "rms_projection_percent", "waveform, rms against its first n_h harmonics", "{:.2f} %"),
    ("torque", "shift_deg", "waveform, shift", "{:+.2f} deg"),
)


def file_of_run(folder, summary, what, fits):
    """The TOML file of the run that fits, unchanged since, as a table."""
    for path, digest in summary["files"].items():
        if not path.endswith(".toml"):
            continue
        content = read_file(path)
        if hashlib.sha256(content).hexdigest() != digest:
            raise BadFolder(f"{folder}/summary.json: files: {path} has changed since the run")
        table = tomllib.loads(content.decode("utf-8"))
        if fits(table):
            return table
    raise BadFolder(f"{folder}/summary.json: files: names no {what}")


class Teeth:
    """teeth.csv without false edges: truth and estimate where a tooth passed."""

    NUMBERS = ("t_s", "angle_deg", "torque_true_nm", "torque_nm")

    def __init__(self, folder):
        table = Table(folder, "teeth.csv", self.NUMBERS + ("tooth_true", "torque_health"))
        real = np.isfinite(table.numbers("tooth_true"))
        self.t_s, self.angle_deg, self.true_nm, self.estimate_nm = (table.numbers(n)[real] for n in self.NUMBERS)
        self.filter_nm = table.numbers("waveform_nm")[real] if "waveform_nm" in table.columns else None
        self.valid = (table.texts("torque_health") == "valid")[real]
        if self.t_s.size < 2:
            raise BadFolder(f"{table.path}: holds no teeth")

    def whole_cycles(self):
        """Index ranges of cycles 0 to 720 deg throughout which the estimate is valid, oldest first."""
        starts = np.flatnonzero(np.diff(self.angle_deg) < 0) + 1  # the first cycle lacks its beginning
        return [slice(a, b) for a, b in zip(starts[:-1], starts[1:])
                if np.all(self.valid[a:b]) and self.angle_deg[a] < 60 and self.angle_deg[b - 1] > 660]


class Run:
    HEADER = ("estimate against truth", "nominal", "perturbed")

    def __init__(self, folder):
        self.folder = folder
        self.summary = read_summary(folder, FIELDS)
        for place, table in (("summary", self.summary), ("perturbed", self.summary["perturbed"] or {})):
            for group in GROUP_FIELDS.keys() & table.keys():
                if table[group] is not None:
                    require(f"{folder}/summary.json: {place}.{group}", table[group], GROUP_FIELDS[group])
        self.teeth = Teeth(folder)
        self.engine = self._engine()

    def _engine(self):
        return file_of_run(self.folder, self.summary, "engine file", lambda table: "crank" in table and "cylinders" in table)

    def title(self):
        return self.summary["scenario"] or self.summary["engine"]["name"]

    def harmonics(self):
        """n_h of the observer."""
        return int(self.summary["parameters"]["torque.harmonics"])

    def cycles(self):
        """The last whole cycles, as many as the summary's figures are of."""
        torque = self.summary["torque"]
        return self.teeth.whole_cycles()[-torque["cycles_measured"]:] if torque else []

    def pole_placement_nm(self):
        return pole_placement.torque_nm(self.engine, self.teeth.t_s, self.teeth.angle_deg)

    def firings(self):
        """(angle in deg, physical cylinder) of the firing TDCs."""
        cylinders = self.engine["cylinders"]
        return list(zip(cylinders["firing_tdc_deg"], cylinders["firing_order"]))

    def assumptions(self):
        """Fields of the engine file that are guesses, which no comparison of the two shows."""
        guessed = self.summary["engine"].get("guessed")
        return ["guessed, for plant and firmware alike: " + ", ".join(guessed)] if guessed else []

    def figures(self):
        """Accuracy as (name, nominal, perturbed) texts; "-" where there is none."""
        def text(of, group, key, form):
            return form.format(of[group][key]) if of and of[group] else "-"

        return [(name, text(self.summary, group, key, form), text(self.summary["perturbed"], group, key, form))
                for group, key, name, form in ACCURACY]
