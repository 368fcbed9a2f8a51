# SPDX-License-Identifier: MIT
"""The simulated engine's gas: document 004's Figures 2, 9, 10 and 11, from `sixdeg study gas SCENARIO.toml --out FOLDER`."""
import numpy as np

from chart import BLUE, GREEN, GREY, ORANGE, RED, Chart
from folder import BadFolder, Table
from page import picture, text

COLUMNS = ("t_s", "angle_deg", "cylinder_bar", "exhaust_gps", "manifold_bar", "manifold_kg", "turbine_gps", "turbine_rpm", "behind_bar",
           "manifold_burned", "tip_burned", "sensor_burned")
NO_ESTIMATOR = "The simulated engine alone, without an estimator; the document's curve is of its own engine."


class Gas:
    HEADER = ("", "mean", "smallest", "largest")

    def __init__(self, folder):
        rows = Table(folder, "gas.csv", COLUMNS)
        if not rows.rows:
            raise BadFolder(f"{rows.path}: is empty")
        self.columns = {name: rows.numbers(name) for name in COLUMNS}
        # Whole cycles, the first of them at 0; the firing TDC of cylinder 1 is at 360, in the middle of its cycle.
        angle = self.columns["angle_deg"]
        self.angle_deg = angle - 720 * np.floor(angle[0] / 720)

    def title(self):
        return f"Gas of the simulated engine, turbine at {self.columns['turbine_rpm'].mean():.0f} rpm"

    def figures(self):
        return [(what, f"{values.mean():.3g}", f"{values.min():.3g}", f"{values.max():.3g}") for what, values in
                (("cylinder, bar", self.columns["cylinder_bar"]), ("manifold, bar", self.columns["manifold_bar"]),
                 ("turbine, g/s", self.columns["turbine_gps"]), ("sensor, 1 - air/gas", self.columns["sensor_burned"]))]

    def assumptions(self):
        return []


def last_cycle(gas):
    """Rows from 360 deg before a firing TDC of the first cylinder to 360 after it, and the angle from that TDC."""
    top = 720 * np.floor((gas.angle_deg[-1] - 360) / 720)
    from_tdc = gas.angle_deg - top
    return np.abs(from_tdc) <= 360, from_tdc


def figure_2(gas):
    rows, from_tdc = last_cycle(gas)
    chart = Chart("deg from firing TDC", "cylinder pressure, bar", height=400)
    chart.line(from_tdc[rows], gas.columns["cylinder_bar"][rows], "simulated engine", BLUE, width=2)
    chart.mark(0, "TDC")
    chart.set_x(-180, 180, ticks=range(-180, 181, 45))
    return chart


def figure_9(gas):
    rows, from_tdc = last_cycle(gas)
    chart = Chart("deg from firing TDC", "flow, g/s", "manifold, bar")
    chart.line(from_tdc[rows], gas.columns["exhaust_gps"][rows], "out of cylinder 1", BLUE, width=2)
    chart.line(from_tdc[rows], gas.columns["turbine_gps"][rows], "through the turbine", ORANGE)
    chart.line(from_tdc[rows], gas.columns["manifold_bar"][rows], "pressure in the manifold", GREY, 1)
    chart.set_x(-360, 360, ticks=range(-360, 361, 90))
    return chart


def figure_10(several):
    chart = Chart("gas in the manifold, over the mean of the first curve", "flow through the turbine, g/s", height=420)
    unit_kg = several[0].columns["manifold_kg"].mean()
    for gas, color in zip(several, (BLUE, GREEN, ORANGE, RED)):
        chart.points(gas.columns["manifold_kg"] / unit_kg, gas.columns["turbine_gps"], f"{gas.columns['turbine_rpm'].mean():.0f} rpm",
                     color, size=3)
    return chart


def figure_11(gas):
    chart = Chart("crank angle, deg", "1 - air/gas", height=400)
    for name, what, color in (("manifold_burned", "in the manifold", GREEN), ("tip_burned", "at the sensor's tip", ORANGE),
                              ("sensor_burned", "as the sensor feels it", BLUE)):
        chart.line(gas.angle_deg, gas.columns[name], what, color, width=2)
    first = 180 * np.ceil(gas.angle_deg[0] / 180)
    chart.set_x(ticks=np.arange(first, gas.angle_deg[-1] + 1, 180))
    return chart


def figure_2_section(gas):
    return [text("Pressure in a cylinder at IMEP 6 bar. The document shows its engine model beside its test bench; here the model alone, "
                 "since there is no such bench. Without recirculated exhaust, which the document has at 35 %.", "lead"),
            picture(figure_2(gas), "cylinder pressure over crank angle"), text(NO_ESTIMATOR)]


def figure_9_section(gas):
    return [text("Flow from one cylinder into the exhaust manifold over a cycle, 1500 rpm, IMEP 11 bar.", "lead"),
            picture(figure_9(gas), "flow out of cylinder 1"), text(NO_ESTIMATOR)]


def figure_10_section(several):
    return [text("Flow through the turbine over the gas in the manifold, at several speeds of the turbine (1500 rpm, several loads): "
                 "every half degree of two cycles. The document's is a look-up table; the simulated turbine is a nozzle, so a curve is as "
                 "wide as the temperature swings within a cycle.", "lead"),
            picture(figure_10(several), "flow through the turbine over gas in the manifold"), text(NO_ESTIMATOR)]


def figure_11_section(gas):
    return [text("+20 % fuel on cylinder 1: what the lambda sensor has to tell it from, over two cycles.", "lead"),
            picture(figure_11(gas), "mixture in the manifold, at the sensor, and felt by it"), text(NO_ESTIMATOR)]
