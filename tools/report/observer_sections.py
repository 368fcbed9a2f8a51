# SPDX-License-Identifier: MIT
"""Document 000's Figures 1 to 4 and Table 2, from `sixdeg study observers --out FOLDER --json FOLDER/table2.json`."""
import json
import os

from chart import BLUE, GREY, ORANGE, Chart
from folder import BadFolder, Table, read_file
from page import picture, table, text

FIGURES = {"figure_1.csv": ("t_s", "speed_mps", "estimate_mps", "estimate_not_told_mps"),
           "figure_2.csv": ("t_s", "error_mps", "error_not_told_mps"),
           "figure_3.csv": ("t_s", "accel_mps2", "estimate_mps2"),
           "figure_4.csv": ("t_s", "accel_mps2", "estimate_mps2", "estimate_not_told_mps2")}
# Printed in document 000's Table 2: band without a fault, with a misfire (%), convergence.
PRINTED = {"ROO": ("0.5 .. 5.2", "-0.9 .. 7.8", "0.12 s"), "FOSMO": ("-1 .. 0.3", "-1.1 .. 0.8", "0.4 s"),
           "FOLSMO": ("-0.2 .. 0.8", "-0.6 .. 0.7", "0.3 s"), "ours": ("", "", "")}
SHOWN_S = 0.6
TOLD = ("FOLSMO, told of the failure", BLUE)
NOT_TOLD = ("FOLSMO, not told", ORANGE)


class Observers:
    HEADER = ("observer", "no fault, %", "misfire known, %", "misfire unknown, %", "within 2 %")

    def __init__(self, folder):
        self.figure = {}
        for name, columns in FIGURES.items():
            rows = Table(folder, name, columns)
            self.figure[name] = {column: rows.numbers(column) for column in columns}
        path = os.path.join(folder, "table2.json")
        try:
            cases = json.loads(read_file(path))
            self.case, about = next(iter(cases.items()))
            self.gains = about["gains"]
            self.rows = {(r["observer"], r["condition"]): r for r in about["rows"] if r["domain"] == "time"}
        except (ValueError, KeyError, TypeError, StopIteration) as error:
            raise BadFolder(f"{path}: is no table of sixdeg study observers: {error}") from error

    def title(self):
        return f"Document 000's observers: {self.case}"

    def _band(self, observer, condition):
        low, high = self.rows[observer, condition]["band_percent"]
        return f"{low:.2f} .. {high:.2f}"

    def figures(self):
        return [(name, self._band(name, "no fault"), self._band(name, "misfire known"), self._band(name, "misfire unknown"),
                 f"{self.rows[name, 'no fault']['to_2_percent_s']:.3f} s") for name in PRINTED if (name, "no fault") in self.rows]

    def assumptions(self):
        return []

    def words(self):
        gains = self.gains
        return text(f"{self.case}; the document prints none of its gains. Here L {gains['luenberger']:g}, rho {gains['sliding']:g}, l of "
                    f"ROO {gains['roo']:.3g}. One cylinder fails from time 0 on. An observer's input either knows that (told) or not; the "
                    "document does not say which it shows.")


def figures_1_and_2(observers):
    speed, error = observers.figure["figure_1.csv"], observers.figure["figure_2.csv"]
    chart = Chart("time, s", "speed, m/s", "error, m/s")
    chart.line(speed["t_s"], speed["speed_mps"], "true", GREY, width=4, opacity=0.6)
    for suffix, (name, color) in (("", TOLD), ("_not_told", NOT_TOLD)):
        chart.line(speed["t_s"], speed[f"estimate{suffix}_mps"], name, color)
        chart.line(error["t_s"], error[f"error{suffix}_mps"], name, color, 1)
    chart.set_x(0, SHOWN_S)
    return chart


def figures_3_and_4(observers):
    healthy, failing = observers.figure["figure_3.csv"], observers.figure["figure_4.csv"]
    chart = Chart("time, s", "healthy, m/s2", "a cylinder fails, m/s2")
    for panel, data in enumerate((healthy, failing)):
        chart.line(data["t_s"], data["accel_mps2"], "true", GREY, panel, width=4, opacity=0.6)
        chart.line(data["t_s"], data["estimate_mps2"], TOLD[0], TOLD[1], panel)
    chart.line(failing["t_s"], failing["estimate_not_told_mps2"], *NOT_TOLD, 1)
    chart.set_x(0, SHOWN_S)
    return chart


def figures_1_and_2_section(observers):
    return [text("Speed of the crank's pin and its estimate by FOLSMO, and the error between them. The estimate starts 0.3 m/s "
                 "off.", "lead"),
            picture(figures_1_and_2(observers), "speed, its estimate and error"), observers.words()]


def figures_3_and_4_section(observers):
    return [text("Acceleration and its estimate by FOLSMO: all cylinders healthy (Figure 3), and one that fails (Figure 4).", "lead"),
            picture(figures_3_and_4(observers), "acceleration, healthy and with a failing cylinder"), observers.words()]


def table_2_section(observers):
    rows = [(name, *PRINTED[name], *here) for name, *here in observers.figures()]
    header = ("observer", "document: no fault", "misfire", "convergence", "here: no fault", "misfire known", "misfire unknown",
              "within 2 %")
    return [text("Error of the acceleration in percent of its largest value: lowest and highest from 0.6 s on. \"ours\" is the project's "
                 "observer of every cylinder's input, for this benchmark alone.", "lead"),
            table(rows, header), observers.words(),
            text("The document's band with a misfire is reached only by observers that are told of it. Why, and with which gains its "
                 "order of FOLSMO before FOSMO comes out: docs/results/observers.md.")]
