# SPDX-License-Identifier: MIT
"""The pictures of misfires: what was judged, against the truth."""
import numpy as np

from chart import BLUE, CYLINDERS, GREEN, GREY, ORANGE, RED, Chart
from misfire_folder import LEAST_FALSE_PERCENT, LIMIT, METHODS

LOOK = {"healthy, judged so": (BLUE, "circle", 4), "misfire, found": (RED, "circle", 8), "misfire, overlooked": (RED, "circle-open", 11),
        "healthy, called a misfire": (ORANGE, "x", 9)}


def index(runs):
    """A panel a run: the index of every firing, the limit, and what each firing was in truth."""
    chart = Chart("time, s", *[f"index, {run.method()}" for run in runs], height=190 + 220 * len(runs))
    for panel, run in enumerate(runs):
        for what, rows in run.groups():
            color, symbol, size = LOOK[what]
            if rows.any():
                chart.points(run.t_s[rows], run.index[rows], what, color, panel, symbol=symbol, size=size)
        chart.line(run.t_s[run.judged], run.limit[run.judged], "limit, below which a firing is a misfire", GREY, panel, dash="dash",
                   step=True)
    return chart


def counts(run):
    """By cylinder: how many misfires there were, and what became of them."""
    of = run.counts()
    cylinders = [f"cylinder {c}" for c in of]
    chart = Chart("", "firings", height=300)
    for column, name, color in ((1, "misfires, true", GREY), (2, "found", GREEN), (3, "overlooked", RED), (4, "false alarms", ORANGE)):
        chart.bars(cylinders, [row[column] for row in of.values()], name, color, form="{:.0f}")
    return chart


def acceleration(run):
    """What document 000's observer sees: mean acceleration of each firing."""
    chart = Chart("time, s", "acceleration, rad/s2", height=320)
    for what, rows in run.groups():
        color, symbol, size = LOOK[what]
        if rows.any():
            chart.points(run.t_s[rows], run.acceleration[rows], what, color, symbol=symbol, size=size)
    return chart


def detectors(curves, physics):
    """A panel a kind of engine and road: misfires found over false alarms, a curve a detector."""
    kinds, roads = curves.kinds(), curves.roads()
    chart = Chart("false alarms, %", *["misfires found, %"] * (len(kinds) * len(roads)), columns=len(roads), log_x=True,
                  titles=[curves.words(kind, road) for kind in kinds for road in roads], height=150 + 260 * len(kinds))
    for panel in range(len(kinds) * len(roads)):
        kind, road = kinds[panel // len(roads)], roads[panel % len(roads)]
        for method, color in zip(METHODS, (BLUE, ORANGE, RED, GREY, *CYLINDERS[3:])):
            alarms, found = curves.of(kind, physics, road, method)
            chart.line(alarms, found, method, color, panel, width=2.5 if method == METHODS[0] else 1.5)
        alarms, found = curves.of(kind, physics, road, LIMIT)
        chart.points(np.maximum(alarms, LEAST_FALSE_PERCENT), found, "the monitor at its own limit", BLUE, panel, size=9)
        chart.set_y(0, 103, panel)
    return chart
