# SPDX-License-Identifier: MIT
"""The pictures of a run, as PNG bytes: estimates beside the truth."""
import numpy as np

from harmonics import GRID_DEG
from style import BLUE, GREY, INK, ORANGE, PALE, RED, axes_grid, axes_of, png


def _cycle_axes(axes):
    axes.axhline(0, color=INK, linewidth=0.6)
    axes.set_xlim(0, 720)
    axes.set_xticks(range(0, 721, 90))


def decomposition(waves):
    """True torque of one cycle, and its first harmonics in growing number."""
    figure, panels = axes_grid(2, 2, 5.6)
    for axes, (count, percent) in zip(panels, waves.left_out_percent().items()):
        truth, = axes.plot(waves.angle_deg, waves.true_nm, color=GREY, linewidth=3)
        first, = axes.plot(GRID_DEG, waves.truth.first(count).at(GRID_DEG), color=BLUE, linewidth=1.4)
        axes.set_title(f"$n_h$ = {count}: leaves out {percent:.1f} %", loc="left", color=INK)
        axes.sharex(panels[0])
        axes.sharey(panels[0])
        _cycle_axes(axes)
    for axes in panels[2:]:
        axes.set_xlabel("crank angle, deg")
    for axes in panels[::2]:
        axes.set_ylabel("torque, N m")
    figure.legend([truth, first], ["true torque", "its first $n_h$ harmonics"], loc="outside upper center", ncols=2)
    return png(figure)


def waveform(waves, firings):
    """One cycle: truth, what n_h harmonics can show of it, the firmware's estimate, pole placement."""
    figure, axes = axes_of("", "crank angle, deg", "torque, N m", 5)
    axes.plot(waves.angle_deg, waves.true_nm, color=BLUE, linewidth=3, label="true torque")
    axes.plot(GRID_DEG, waves.truth.first(waves.n_h).at(GRID_DEG), color=PALE, linewidth=4,
              label=f"its first {waves.n_h} harmonics")
    axes.plot(waves.angle_deg, waves.estimate_nm, "--", color=RED, linewidth=1.8, label="Fourier observer (firmware)")
    axes.plot(waves.angle_deg, waves.pole_nm, ":", color=INK, linewidth=1.8, label="pole placement")
    _cycle_axes(axes)
    low, high = axes.get_ylim()
    axes.set_ylim(low - 0.06 * (high - low), high)
    for angle_deg, cylinder in firings:
        axes.axvline(angle_deg, color=GREY, linewidth=0.8, linestyle=(0, (4, 4)))
        axes.annotate(f"TDC of cylinder {cylinder}", (angle_deg, 0), xycoords=("data", "axes fraction"),
                      textcoords="offset points", xytext=(5, 5), fontsize=8, color=INK)
    figure.legend(loc="outside upper center", ncols=4)
    return png(figure)


def contributions(nominal, perturbed):
    """Torque of each cylinder, and its difference from the mean: truth beside estimates, as the summary has them."""
    series = [("true", GREY, nominal["true_nm"], None),
              ("estimate, nominal calibration", BLUE, nominal["estimate_nm"], nominal["sd_nm"])]
    if perturbed:
        series.append(("estimate, perturbed calibration", ORANGE, perturbed["estimate_nm"], perturbed["sd_nm"]))
    mean_nm = np.mean(nominal["true_nm"])
    places, width = np.arange(len(nominal["true_nm"])), 0.84 / len(series)
    figure, (upper, lower) = axes_grid(2, 1, 6.4)
    for i, (name, color, torque_nm, sd_nm) in enumerate(series):
        torque_nm, sd_nm = np.array(torque_nm), None if sd_nm is None else np.array(sd_nm)
        at = places + (i - (len(series) - 1) / 2) * width
        style = {"width": 0.92 * width, "color": color, "ecolor": INK, "capsize": 3}
        bars = upper.bar(at, torque_nm, yerr=sd_nm, label=name, **style)
        upper.bar_label(bars, fmt="{:.1f}", fontsize=8, padding=2)
        percent = 100 * (torque_nm - torque_nm.mean()) / mean_nm
        bars = lower.bar(at, percent, yerr=None if sd_nm is None else 100 * sd_nm / mean_nm, **style)
        lower.bar_label(bars, fmt="{:+.1f}", fontsize=8, padding=2)
    upper.set_title("Combustion torque of each cylinder, mean over the 180 deg after its TDC", loc="left", color=INK)
    upper.set_ylabel("torque, N m")
    lower.set_title("Difference from the mean of all cylinders", loc="left", color=INK)
    lower.set_ylabel("% of the true mean")
    lower.set_xlabel("cylinder")
    lower.axhline(0, color=INK, linewidth=0.8)
    for axes in (upper, lower):
        axes.margins(y=0.12)
        axes.set_xticks(places, [f"{p + 1}" for p in places])
        axes.grid(axis="x", visible=False)
    figure.legend(loc="outside upper center", ncols=len(series))
    return png(figure)
