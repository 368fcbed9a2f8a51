# SPDX-License-Identifier: MIT
"""The pictures of mixture and fuel trims, as PNG bytes."""
import numpy as np

from mixture_folder import BALANCED_PERCENT, running_mean, spread_percent
from style import BLUE, CYLINDERS, GREY, INK, ORANGE, axes_grid, png

OFF = "#f1f1f1"
CALM = 10  # cycles, over which the indicated pressure is averaged


def _lines(axes, run, values, **style):
    for cylinder, row in zip(run.cylinders, values):
        axes.plot(run.time_s, row, color=CYLINDERS[cylinder - 1], **style)


def _phases(panels, run):
    """Shades where the trims are off, and says above the first panel what happens."""
    on = run.balanced_s()
    edges = sorted({0.0, run.time_s[-1], *(t for pair in on for t in pair), *(s[0] for s in run.fuel_steps())})
    for start, end in zip(edges[:-1], edges[1:]):
        middle = (start + end) / 2
        balanced = any(a <= middle < b for a, b in on)
        words = "control on" if balanced else "control off"
        words += "".join(f",\ninjector of cylinder {c} now {p:+g} %" for t, c, p in run.fuel_steps() if t == start)
        for axes in panels:
            if not balanced:
                axes.axvspan(start, end, color=OFF, zorder=0, linewidth=0)
            axes.axvline(start, color=GREY, linewidth=0.8, linestyle=(0, (4, 4)))
        panels[0].annotate(words, (middle, 1.03), xycoords=("data", "axes fraction"), ha="center", va="bottom", fontsize=9,
                           color=INK)


def _cylinder_legend(figure, run, more=()):
    from matplotlib.lines import Line2D

    entries = [Line2D([], [], color=CYLINDERS[c - 1], linewidth=2.4, label=f"cylinder {c}") for c in run.cylinders]
    figure.legend(handles=entries + list(more), loc="outside upper center", ncols=len(entries) + len(more))


def figure_16(run):
    """Indicated pressure, estimated mixture, trims, and how far apart the cylinders are, over the whole run."""
    figure, panels = axes_grid(4, 1, 10.5, sharex=True, height_ratios=(3, 3, 2, 2))
    imep, mixture, trim, spread = panels
    _lines(imep, run, run.imep_true_bar, linewidth=0.5, alpha=0.25)
    _lines(imep, run, running_mean(run.imep_true_bar, CALM), linewidth=1.6)
    imep.set_ylabel("IMEP, bar")
    _lines(mixture, run, run.burned_true, linewidth=3, alpha=0.35)
    _lines(mixture, run, run.burned, linewidth=0.9)
    mixture.set_ylabel("lambda (burned share)")
    _lines(trim, run, 100 * run.trim, linewidth=1.4)
    trim.set_ylabel("fuel trim, %")
    for values, color, label in ((run.burned_true, BLUE, "of lambda"), (run.imep_true_bar, ORANGE, "of IMEP")):
        spread.plot(run.time_s, spread_percent(running_mean(values)), color=color, linewidth=1.3, label=label)
    _limit(spread)
    spread.set_ylabel("true spread, %")
    spread.legend(loc="upper left", ncols=2, fontsize=9)
    spread.set_xlabel("time, s")
    spread.set_xlim(0, run.time_s[-1])
    _phases(panels, run)
    for axes in panels:
        axes.grid(axis="x", visible=False)
    _cylinder_legend(figure, run, _true_and_estimated())
    figure.align_ylabels(panels)
    return png(figure)


def _true_and_estimated():
    from matplotlib.lines import Line2D

    return (Line2D([], [], color=INK, linewidth=3, alpha=0.35, label="true lambda"),
            Line2D([], [], color=INK, linewidth=0.9, label="estimate"))


def _limit(axes):
    axes.axhline(BALANCED_PERCENT, color=INK, linewidth=0.8, linestyle=":")
    axes.annotate(f"{BALANCED_PERCENT} %", (1.005, BALANCED_PERCENT), xycoords=("axes fraction", "data"), va="center", fontsize=8,
                  color=INK)
    axes.set_ylim(bottom=0)


def switched_on(runs, before=10, after=60):
    """How far apart the cylinders are, cycle by cycle from when the control is switched on, for each source."""
    figure, (left, right) = axes_grid(1, 2, 4, sharey=True)
    for axes, name, words in ((left, "burned_true", "lambda"), (right, "imep_true_bar", "IMEP")):
        for run, color in zip(runs, (BLUE, ORANGE)):
            on = run.switched_on()
            part = slice(on - before, on + after)
            spread = spread_percent(running_mean(getattr(run, name)))[part]
            axes.plot(np.arange(-before, len(spread) - before), spread, color=color, linewidth=1.8, label=f"from {run.source()}")
        axes.axvline(0, color=GREY, linewidth=0.8, linestyle=(0, (4, 4)))
        _limit(axes)
        axes.set_xlim(-before, after)
        axes.set_title(f"True spread of {words}, mean of 4 cycles", loc="left", color=INK)
        axes.set_xlabel("cycles since the control is on")
    left.set_ylabel("% of the mean")
    figure.legend(*left.get_legend_handles_labels(), loc="outside upper center", ncols=2)
    return png(figure)


def trajectory(run):
    """Fuel of each injector above, estimated and true mixture below."""
    figure, (fuel, mixture) = axes_grid(2, 1, 5.6, sharex=True, height_ratios=(1, 2))
    _lines(fuel, run, [run.fuel_percent(c, run.time_s) for c in run.cylinders], linewidth=1.6, drawstyle="steps-post")
    fuel.set_ylabel("fuel, % beyond nominal")
    _lines(mixture, run, run.burned_true, linewidth=3.5, alpha=0.35)
    _lines(mixture, run, run.burned, linewidth=1)
    mixture.set_ylabel("lambda (burned share)")
    mixture.set_xlabel("time, s")
    settled = run.time_s > 1
    low, high = np.nanmin(run.burned_true[:, settled]), np.nanmax(run.burned_true[:, settled])
    mixture.set_ylim(low - 0.2 * (high - low), high + 0.2 * (high - low))
    mixture.set_xlim(0, run.time_s[-1])
    figure.align_ylabels()
    _cylinder_legend(figure, run, _true_and_estimated())
    return png(figure)
