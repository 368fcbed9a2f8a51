# SPDX-License-Identifier: MIT
"""The pictures of a look; None where there is nothing to draw."""
from chart import BLUE, Chart


def pattern(of_teeth):
    """How late each tooth comes, with the scatter of single passes."""
    if not of_teeth:
        return None
    teeth = sorted(of_teeth)
    chart = Chart("tooth, from 0 behind the mark", "late, deg of crank")
    chart.points(teeth, [of_teeth[t].mean() for t in teeth], "mean, and the scatter of single passes", BLUE,
                 sd=[of_teeth[t].std() for t in teeth])
    chart.level(0)
    return chart


def differences(of_cylinders):
    """Torque less the mean of all, with three standard deviations of that mean."""
    chart = Chart("", "torque less the mean of all, N m")
    chart.bars([f"cylinder {c}" for c in of_cylinders], [v[0] for v in of_cylinders.values()], "mean, and three of its standard deviations",
               BLUE, sd=[3 * v[1] for v in of_cylinders.values()], form="{:+.2f}")
    chart.level(0)
    return chart
