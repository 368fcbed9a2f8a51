# SPDX-License-Identifier: MIT
"""Document 004's Figure 7, on a real recording of teeth and cylinder pressure, from
`tools/evidence ENGINE.toml RECORDING --pressure COLUMN --json FOLDER/figures.json --curves FOLDER`."""
import json
import os

import numpy as np

from chart import BLUE, GREEN, GREY, Chart
from folder import BadFolder, Table, read_file
from page import picture, table, text

OBSERVERS = (("fourier", "adaptive Fourier observer (document 004)", BLUE), ("filter", "filter on tooth times (ours)", GREEN))


class PressureBeside:
    HEADER = ("torque over the angle, tooth pattern", "R2, Fourier observer", "R2, filter", "cycles")

    def __init__(self, folder):
        torque = Table(folder, "torque.csv", ("recording", "pattern", "angle_deg", "pressure_nm", "filter", "fourier"))
        names = torque.texts("recording")
        if not len(names):
            raise BadFolder(f"{torque.path}: is empty: it takes an engine of one cylinder")
        self.name = str(names[0])
        first, pattern = names == self.name, torque.texts("pattern")
        columns = {name: torque.numbers(name) for name in ("angle_deg", "pressure_nm", "filter", "fourier")}
        self.curves = {str(p): {name: values[first & (pattern == p)] for name, values in columns.items()}
                       for p in dict.fromkeys(pattern[first])}
        work = Table(folder, "work.csv", ("recording", "cycle", "pressure_j", "same_teeth_j"))
        first = work.texts("recording") == self.name
        self.work = {name: work.numbers(name)[first] for name in ("cycle", "pressure_j", "same_teeth_j")}
        path = os.path.join(folder, "figures.json")
        try:
            self.found = json.loads(read_file(path))[self.name]
            self.waveform = {key.removesuffix(", +0"): of for key, of in self.found["waveform"].items() if key.endswith(", +0")}
            self.by_work = next(iter(self.found["work"]["0"].values()))
        except (ValueError, KeyError, StopIteration) as error:
            raise BadFolder(f"{path}: is nothing of tools/evidence: {error}") from error

    def title(self):
        return f"Cylinder pressure beside the teeth: {self.name}"

    def figures(self):
        def r2(of, key):
            return f"{of[key]['r2']:.2f}" if of.get(key) else "-"

        return [(pattern, r2(of, "fourier"), r2(of, "filter"), str((of.get("filter") or of.get("fourier") or {}).get("cycles", 0)))
                for pattern, of in self.waveform.items()]

    def assumptions(self):
        return []


def torque(beside):
    shown = {p: c for p, c in beside.curves.items() if p in ("as built", "from the gas exchange of the first half")}
    chart = Chart("deg from firing TDC", *["torque less its mean, N m"] * len(shown), height=120 + 280 * len(shown),
                  titles=[f"tooth pattern {p}" for p in shown])
    for panel, data in enumerate(shown.values()):
        chart.line(data["angle_deg"], data["pressure_nm"], "by cylinder pressure", GREY, panel, width=4, opacity=0.6)
        for key, name, color in OBSERVERS:
            chart.line(data["angle_deg"], data[key], name, color, panel)
    return chart


def work(beside):
    data = beside.work
    told = np.isfinite(data["same_teeth_j"])
    chart = Chart("cycle", "work less its mean, J", height=300)
    for name, what, color in (("pressure_j", "by cylinder pressure", GREY),
                              ("same_teeth_j", "energy at the same teeth (work.cycle)", GREEN)):
        chart.line(data["cycle"][told], data[name][told] - data[name][told].mean(), what, color, width=2)
    return chart


def section(beside):
    by_work = beside.by_work
    return [text("A real engine at full load: torque from cylinder pressure, (p - 1 bar) dV/da, beside what the firmware makes of the "
                 f"teeth alone. Recording {beside.name}, the last cycle of its second half.", "lead"),
            picture(torque(beside), "torque over the angle, by pressure and by observers"), table(beside.figures(), beside.HEADER),
            text("R2 is the share of the torque's variance that an estimate explains, over the second half of the recording; below 0 a "
                 "flat line is nearer. What decides is the pattern of the wheel's own errors. \"From the gas exchange\": learned outside "
                 "the firmware, from the revolution in which the cylinder does not fire. All parameters are at their defaults."),
            picture(work(beside), "work of each cycle"),
            text(f"How the work of cycles differs, by the teeth: correlation {by_work['correlation']:.3f}, rms "
                 f"{by_work['rms_percent']:.2f} % of the mean work, over {by_work['count']} cycles. More: docs/results/evidence.md.")]


def said(beside):
    by_work = beside.by_work
    return (f"Real engine with cylinder pressure, {beside.name}: how the work of {by_work['count']} cycles differs is known from teeth "
            f"alone, correlation {by_work['correlation']:.3f}, rms {by_work['rms_percent']:.2f} % of the mean work.")
