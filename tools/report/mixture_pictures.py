# SPDX-License-Identifier: MIT
"""The pictures of mixture and fuel trims."""
import numpy as np

from chart import BLUE, CYLINDERS, GREEN, ORANGE, Chart
from mixture_folder import BALANCED_PERCENT, MixtureRun, names, running_mean, spread_percent

CALM = 10  # cycles, over which the indicated pressure is averaged
TRUE = {"width": 4, "opacity": 0.4}


def _lines(chart, run, values, panel, what="", **style):
    for cylinder, row in zip(run.cylinders, values):
        chart.line(run.time_s, row, f"cylinder {cylinder}{what}", CYLINDERS[cylinder - 1], panel, **style)


def _phases(chart, run):
    """Shades where the trims are off, and says above what happens."""
    on = run.balanced_s()
    edges = sorted({0.0, run.time_s[-1], *(t for pair in on for t in pair), *(s[0] for s in run.fuel_steps())})
    for start, end in zip(edges[:-1], edges[1:]):
        middle = (start + end) / 2
        balanced = any(a <= middle < b for a, b in on)
        words = "control on" if balanced else "control off"
        words += "".join(f",<br>cylinder {c} at {p:+g} %" for t, c, p in run.fuel_steps() if t == start)
        if not balanced:
            chart.shade(start, end)
        chart.mark(start, words)


def figure_16(run):
    """Indicated pressure, estimated mixture, trims, and how far apart the cylinders are, over the whole run."""
    chart = Chart("time, s", "IMEP, bar", "1 - air/gas", "trim, %", "true spread, %", heights=(3, 3, 2, 2), height=900)
    _lines(chart, run, running_mean(run.imep_true_bar, CALM), 0, ", true", width=1.6)
    _lines(chart, run, run.burned_true, 1, ", true", **TRUE)
    _lines(chart, run, run.burned, 1, ", estimate", width=1)
    _lines(chart, run, 100 * run.trim, 2, ", estimate", width=1.4)
    for values, color, label in ((run.burned_true, BLUE, "spread of the mixture"), (run.imep_true_bar, ORANGE, "spread of IMEP")):
        chart.line(run.time_s, spread_percent(running_mean(values)), label, color, 3)
    chart.level(BALANCED_PERCENT, 3, f"{BALANCED_PERCENT} %")
    chart.set_x(0, run.time_s[-1])
    _phases(chart, run)
    return chart


def switched_on(runs, before=10, after=60):
    """How far apart the cylinders are, cycle by cycle from when the control is switched on, for each source."""
    chart = Chart("cycles since the control is on", "% of the mean", "", columns=2, height=340,
                  titles=("true spread of the mixture, mean of 4 cycles", "true spread of IMEP, mean of 4 cycles"))
    for panel, name in enumerate(("burned_true", "imep_true_bar")):
        for run, source, color in zip(runs, names(runs, MixtureRun.source), (BLUE, ORANGE, GREEN)):
            on = run.switched_on()
            spread = spread_percent(running_mean(getattr(run, name)))[on - before:on + after]
            chart.line(np.arange(-before, len(spread) - before), spread, f"trims from {source}", color, panel, width=1.8)
        chart.level(BALANCED_PERCENT, panel, f"{BALANCED_PERCENT} %")
    chart.set_x(-before, after)
    return chart


def trajectory(runs):
    """Fuel of each injector above; estimated and true mixture below, a panel an estimator."""
    first = runs[0]
    chart = Chart("time, s", "fuel, %", *(f"1 - air/gas, {name}" for name in names(runs)), heights=(1, *[2] * len(runs)),
                  height=240 + 280 * len(runs))
    _lines(chart, first, [first.fuel_percent(c, first.time_s) for c in first.cylinders], 0, ", true", width=1.6, step=True)
    for panel, run in enumerate(runs, 1):
        _lines(chart, run, run.burned_true, panel, ", true", **TRUE)
        _lines(chart, run, run.burned, panel, ", estimate", width=1)
        settled = run.time_s > 1
        low, high = np.nanmin(run.burned_true[:, settled]), np.nanmax(run.burned_true[:, settled])
        chart.set_y(low - 0.2 * (high - low), high + 0.2 * (high - low), panel)
    chart.set_x(0, first.time_s[-1])
    return chart
