# SPDX-License-Identifier: MIT
"""The pictures of a replay, as PNG bytes. Each function returns None where there is nothing to draw."""
import numpy as np

from style import BLUE, GREY, INK, ORANGE, RED, axes_of, png

MARKS = {"coasted": (ORANGE, "v", "coasted through"), "spurious": (RED, "x", "spurious"),
         "unsynced": (GREY, ".", "not yet synced")}
LAST_CYCLES = 8
TEETH_BESIDE_MARK = 12


def speed(teeth):
    """Speed over time, faults marked where they happened."""
    known = np.isfinite(teeth.rpm)
    if not known.any():
        return None
    figure, axes = axes_of("Speed, tooth by tooth", "time, s", "speed, rpm")
    axes.plot(teeth.t_s[known], teeth.rpm[known], color=BLUE, linewidth=0.7)
    for kind, (color, marker, label) in MARKS.items():
        chosen = teeth.kind == kind
        if not chosen.any():
            continue
        # An edge without a speed of its own is drawn at the speed around it.
        rpm = np.interp(teeth.t_s[chosen], teeth.t_s[known], teeth.rpm[known])
        axes.plot(teeth.t_s[chosen], rpm, marker, color=color, markersize=5, label=f"{label} ({chosen.sum()})")
    axes.set_ylim(bottom=0)
    if axes.get_legend_handles_labels()[0]:
        axes.legend(loc="lower right")
    return png(figure)


def _cycles(angle_deg):
    """Index ranges in which the crank angle only rises."""
    starts = np.flatnonzero(np.diff(angle_deg) < 0) + 1
    bounds = [0, *starts.tolist(), len(angle_deg)]
    return list(zip(bounds[:-1], bounds[1:]))


def _last_cycles(teeth, torque_nm):
    """(angle, torque) of the last whole cycles, the newest first, and the angle they span; nothing without one."""
    known = np.isfinite(torque_nm) & np.isfinite(teeth.angle_deg) & (teeth.kind == "tooth")
    if not known.any():
        return [], 0
    angle_deg, torque_nm = teeth.angle_deg[known], torque_nm[known]
    span_deg = 720 if angle_deg.max() > 360 else 360
    # The first and last are cut off somewhere on the way.
    whole = [(a, b) for a, b in _cycles(angle_deg) if angle_deg[b - 1] - angle_deg[a] > 0.9 * span_deg][-LAST_CYCLES:]
    return [(angle_deg[a:b], torque_nm[a:b]) for a, b in reversed(whole)], span_deg


def _over_one_another(cycles, span_deg, title, unit):
    figure, axes = axes_of(f"{title}, last {len(cycles)} {'cycles' if span_deg == 720 else 'revolutions'}", "crank angle, deg", unit)
    for age, (angle_deg, values) in enumerate(cycles):
        axes.plot(angle_deg, values, color=BLUE if age == 0 else GREY, linewidth=1.6 if age == 0 else 0.7, zorder=3 if age == 0 else 2)
    axes.axhline(0, color=INK, linewidth=0.6)
    axes.set_xlim(0, span_deg)
    axes.set_xticks(range(0, span_deg + 1, 90))
    return png(figure)


def torque(teeth):
    """Torque over crank angle, the last cycles over one another; the newest is dark."""
    cycles, span_deg = _last_cycles(teeth, teeth.torque_nm)
    return _over_one_another(cycles, span_deg, "Torque at the crank", "torque, N m") if cycles else None


def torque_swing(teeth, with_scale):
    """The Fourier observer's torque less the mean of each cycle; of the mean swing where the scale is not known."""
    cycles, span_deg = _last_cycles(teeth, teeth.fourier_nm)
    if not cycles:
        return None
    cycles = [(angle_deg, values - values.mean()) for angle_deg, values in cycles]
    if with_scale:
        return _over_one_another(cycles, span_deg, "Swing of the torque", "torque less its mean, N m")
    swing = np.mean([np.ptp(values) for _, values in cycles]) or 1
    shares = [(angle_deg, 100 * values / swing) for angle_deg, values in cycles]
    return _over_one_another(shares, span_deg, "Swing of the torque", "torque less its mean, % of its swing")


def mark(teeth):
    """Intervals between edges around the last mark, with the tooth numbers that the decoder gave."""
    firsts = np.flatnonzero((teeth.tooth == 0) & (teeth.kind == "tooth"))
    firsts = firsts[(firsts > TEETH_BESIDE_MARK) & (firsts < len(teeth.t_s) - TEETH_BESIDE_MARK)]
    if firsts.size == 0:
        return None
    middle = firsts[-1]
    shown = np.arange(middle - TEETH_BESIDE_MARK, middle + TEETH_BESIDE_MARK)
    t_ms = 1e3 * (teeth.t_s[shown] - teeth.t_s[middle])
    interval_ms = 1e3 * (teeth.t_s[shown] - teeth.t_s[shown - 1])
    figure, axes = axes_of(f"Decoded teeth around the mark at {teeth.t_s[middle]:.3f} s", "time after the first tooth, ms",
                         "time since the edge before, ms")
    axes.vlines(t_ms, 0, interval_ms, color=GREY, linewidth=1)
    for i, x, y in zip(shown, t_ms, interval_ms):
        color = MARKS[teeth.kind[i]][0] if teeth.kind[i] in MARKS else BLUE
        axes.plot(x, y, "o", color=color, markersize=4)
        label = f"{teeth.tooth[i]:.0f}" if np.isfinite(teeth.tooth[i]) else "?"
        axes.annotate(label, (x, y), textcoords="offset points", xytext=(0, 6), ha="center", fontsize=8, color=INK)
    axes.set_ylim(0, 1.2 * interval_ms.max())
    return png(figure)


def contributions(replay):
    """What each cylinder gives more or less than the mean of all: bars, and every cycle as a dot."""
    values = replay.contributions()
    if not values:
        return None
    count = max(v.size for v in values.values())
    figure, axes = axes_of(f"Cylinder contributions: torque less the mean of all, {count} cycles", "cylinder",
                           "difference, N m")
    for place, of_cycles in enumerate(values.values()):
        bar = axes.bar(place, of_cycles.mean(), width=0.55, color=BLUE)
        beside = place + np.linspace(-0.22, 0.22, of_cycles.size)
        dots, = axes.plot(beside, of_cycles, "o", color=ORANGE, markersize=4, markeredgecolor="white",
                          markeredgewidth=0.5)
    axes.axhline(0, color=INK, linewidth=0.8)
    axes.set_xticks(range(len(values)), [f"{c}" for c in values])
    axes.grid(axis="x", visible=False)
    figure.legend([bar, dots], ["mean", "each cycle, in order"], loc="outside right upper")
    return png(figure)
