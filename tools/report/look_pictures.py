# SPDX-License-Identifier: MIT
"""The pictures of a look, as PNG bytes; None where there is nothing to draw."""
from style import BLUE, GREY, INK, ORANGE, axes_of, png


def pattern(of_teeth):
    """How late each tooth comes, with the scatter of single passes."""
    if not of_teeth:
        return None
    figure, axes = axes_of("How late each tooth comes", "tooth, from 0 behind the mark", "deg of crank")
    teeth = sorted(of_teeth)
    means = [of_teeth[t].mean() for t in teeth]
    axes.errorbar(teeth, means, yerr=[of_teeth[t].std() for t in teeth], fmt="o", color=BLUE, ecolor=GREY, markersize=4, linewidth=1)
    axes.axhline(0, color=INK, linewidth=0.6)
    return png(figure)


def differences(of_cylinders):
    """Torque less the mean of all, with three standard deviations of that mean."""
    figure, axes = axes_of("Cylinder contributions: torque less the mean of all", "cylinder", "N m")
    places = range(len(of_cylinders))
    axes.bar(places, [v[0] for v in of_cylinders.values()], width=0.55, color=BLUE)
    axes.errorbar(places, [v[0] for v in of_cylinders.values()], yerr=[3 * v[1] for v in of_cylinders.values()], fmt="none",
                  ecolor=ORANGE, capsize=6)
    axes.axhline(0, color=INK, linewidth=0.8)
    axes.set_xticks(places, [str(c) for c in of_cylinders])
    axes.grid(axis="x", visible=False)
    return png(figure)
