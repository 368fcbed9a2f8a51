# SPDX-License-Identifier: MIT
"""Pictures of document 003's Figures 2 and 6."""
import numpy as np

from chart import BLUE, GREY, ORANGE, Chart

SHOWN_S = (1.9, 3.4)
KINKS_RAD = (-0.01, -0.04)  # torsion less that of the equilibrium, where the shaft becomes stiff


def figure_6(driveline):
    data = driveline.columns
    shown = (data["time_s"] >= SHOWN_S[0]) & (data["time_s"] <= SHOWN_S[1])
    time = data["time_s"][shown]
    chart = Chart("time, s", "torsion, rad", "residual, rpm", "location")
    chart.line(time, data["torsion_rad"][shown], "torsion less equilibrium", GREY, width=4, opacity=0.6)
    chart.line(time, data["estimate_rad"][shown], "continuous observer", BLUE)
    for kink in KINKS_RAD:
        chart.level(kink, 0, f"kink at {kink:g} rad")
    for name, color in (("r2_rpm", BLUE), ("r3_rpm", ORANGE)):
        chart.line(time, data[name][shown], f"residual {name[:2]}", color, 1)
    chart.line(time, data["location"][shown], "true location", GREY, 2, step=True, width=4, opacity=0.6)
    chart.line(time, data["found"][shown], "location found", BLUE, 2, step=True)
    chart.set_y(0.7, 3.3, 2, ticks=(1, 2, 3))
    return chart


def figure_2():
    """Torque of the shaft over its torsion, by the parameters that Figure 6 is made with (docs/theory/driveline.md)."""
    soft_nmprad, stiff_nmprad, kink_rad = 2400, 8000, 0.015
    torsion = np.linspace(-0.05, 0.05, 401)
    beyond = np.sign(torsion) * np.maximum(np.abs(torsion) - kink_rad, 0)
    chart = Chart("torsion, rad", "torque of the shaft, N m", height=360)
    chart.line(torsion, soft_nmprad * (torsion - beyond) + stiff_nmprad * beyond, "elastic torque", BLUE, width=2)
    for kink in (-kink_rad, kink_rad):
        chart.mark(kink, f"{kink:g} rad")
    chart.level(0)
    return chart
