# SPDX-License-Identifier: MIT
"""The pictures of a run: estimates beside the truth."""
import numpy as np

from chart import BLUE, GREEN, GREY, ORANGE, Chart
from harmonics import GRID_DEG

CYCLE_TICKS = range(0, 721, 90)


def decomposition(waves):
    """True torque of one cycle, and its first harmonics in growing number."""
    left_out = waves.left_out_percent()
    chart = Chart("crank angle, deg", *["torque, N m"] * len(left_out), columns=2, height=560,
                  titles=[f"n<sub>h</sub> = {count}: leaves out {percent:.1f} %" for count, percent in left_out.items()])
    for panel, count in enumerate(left_out):
        chart.line(waves.angle_deg, waves.true_nm, "true torque", GREY, panel, width=4, opacity=0.6)
        chart.line(GRID_DEG, waves.truth.first(count).at(GRID_DEG), "its first n<sub>h</sub> harmonics", BLUE, panel)
        chart.level(0, panel)
    chart.set_x(0, 720, ticks=CYCLE_TICKS)
    return chart


def waveform(waves, firings):
    """One cycle: truth, what n_h harmonics can show of it, the firmware's estimate, pole placement."""
    chart = Chart("crank angle, deg", "torque, N m", height=420)
    chart.line(waves.angle_deg, waves.true_nm, "true torque", GREY, width=4, opacity=0.6)
    chart.line(GRID_DEG, waves.truth.first(waves.n_h).at(GRID_DEG), f"its first {waves.n_h} harmonics", BLUE, width=4, opacity=0.4)
    chart.line(waves.angle_deg, waves.estimate_nm, "adaptive Fourier observer (firmware)", BLUE, width=1.8)
    if waves.filter_nm is not None:
        chart.line(waves.angle_deg, waves.filter_nm, "filter on tooth times (firmware)", GREEN, width=1.8)
    chart.line(waves.angle_deg, waves.pole_nm, "pole placement", ORANGE, dash="dot", width=1.8)
    chart.level(0)
    for angle_deg, cylinder in firings:
        chart.mark(angle_deg, f"TDC of {cylinder}", at_top=False)
    chart.set_x(0, 720, ticks=CYCLE_TICKS)
    return chart


def contributions(nominal, perturbed):
    """Torque of each cylinder, and its difference from the mean: truth beside estimates, as the summary has them."""
    series = [("true", GREY, nominal["true_nm"], None),
              ("estimate, nominal calibration", BLUE, nominal["estimate_nm"], nominal["sd_nm"])]
    if perturbed:
        series.append(("estimate, perturbed calibration", ORANGE, perturbed["estimate_nm"], perturbed["sd_nm"]))
    mean_nm = np.mean(nominal["true_nm"])
    cylinders = [f"cylinder {p + 1}" for p in range(len(nominal["true_nm"]))]
    chart = Chart("", "torque, N m", "less the mean, %", height=560)
    for name, color, torque_nm, sd_nm in series:
        torque_nm, sd_nm = np.array(torque_nm), None if sd_nm is None else np.array(sd_nm)
        chart.bars(cylinders, torque_nm, name, color, sd=sd_nm)
        chart.bars(cylinders, 100 * (torque_nm - torque_nm.mean()) / mean_nm, name, color, 1, form="{:+.1f}",
                   sd=None if sd_nm is None else 100 * sd_nm / mean_nm)
    chart.level(0, 1)
    return chart
