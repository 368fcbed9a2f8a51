# SPDX-License-Identifier: MIT
"""The pictures of a replay. Each function returns None where there is nothing to draw."""
import numpy as np

from chart import BLUE, GREY, ORANGE, RED, Chart

MARKS = {"coasted": (ORANGE, "triangle-down", "coasted through"), "spurious": (RED, "x", "spurious"),
         "unsynced": (GREY, "circle", "not yet synced")}
LAST_CYCLES = 8
TEETH_BESIDE_MARK = 12


def speed(teeth):
    """Speed over time, faults marked where they happened."""
    known = np.isfinite(teeth.rpm)
    if not known.any():
        return None
    chart = Chart("time, s", "speed, rpm")
    chart.line(teeth.t_s[known], teeth.rpm[known], "speed, tooth by tooth", BLUE, width=0.9)
    for kind, (color, symbol, label) in MARKS.items():
        chosen = teeth.kind == kind
        if chosen.any():
            # An edge without a speed of its own is drawn at the speed around it.
            rpm = np.interp(teeth.t_s[chosen], teeth.t_s[known], teeth.rpm[known])
            chart.points(teeth.t_s[chosen], rpm, f"{label} ({chosen.sum()})", color, symbol=symbol)
    chart.set_y(0, 1.05 * np.nanmax(teeth.rpm))
    return chart
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


def _over_one_another(cycles, span_deg, unit):
    chart = Chart("crank angle, deg", unit)
    older = f"the {len(cycles) - 1} before"
    for age, (angle_deg, values) in reversed(list(enumerate(cycles))):
        chart.line(angle_deg, values, older if age else f"last whole {'cycle' if span_deg == 720 else 'revolution'}", GREY if age else BLUE,
                   width=1 if age else 2, opacity=0.5 if age else 1)
    chart.level(0)
    chart.set_x(0, span_deg, ticks=range(0, span_deg + 1, 90))
    return chart


def torque(teeth):
    """Torque over crank angle, the last cycles over one another."""
    cycles, span_deg = _last_cycles(teeth, teeth.torque_nm)
    return _over_one_another(cycles, span_deg, "torque, N m") if cycles else None


def torque_swing(teeth, with_scale):
    """The Fourier observer's torque less the mean of each cycle; of the mean swing where the scale is not known."""
    cycles, span_deg = _last_cycles(teeth, teeth.fourier_nm)
    if not cycles:
        return None
    cycles = [(angle_deg, values - values.mean()) for angle_deg, values in cycles]
    if with_scale:
        return _over_one_another(cycles, span_deg, "torque less its mean, N m")
    swing = np.mean([np.ptp(values) for _, values in cycles]) or 1
    shares = [(angle_deg, 100 * values / swing) for angle_deg, values in cycles]
    return _over_one_another(shares, span_deg, "torque less its mean, % of its swing")


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
    chart = Chart(f"time after the first tooth behind the mark at {teeth.t_s[middle]:.3f} s, ms", "since the edge before, ms")
    numbers = np.array([f"{n:.0f}" if np.isfinite(n) else "?" for n in teeth.tooth[shown]])
    for kind in dict.fromkeys(teeth.kind[shown]):
        color, symbol, label = MARKS.get(kind, (BLUE, "circle", "tooth, with its number"))
        of_kind = teeth.kind[shown] == kind
        chart.points(t_ms[of_kind], interval_ms[of_kind], label, color, symbol=symbol, text=numbers[of_kind])
    chart.set_y(0, 1.2 * interval_ms.max())
    return chart


def contributions(replay):
    """What each cylinder gives more or less than the mean of all: bars, and every cycle as a dot."""
    values = replay.contributions()
    if not values:
        return None
    count = max(v.size for v in values.values())
    chart = Chart("cylinder", "torque less the mean of all, N m")
    for place, (cylinder, of_cycles) in enumerate(values.items()):
        beside = place + np.linspace(-0.22, 0.22, of_cycles.size)
        chart.points(beside, of_cycles, f"each of {count} cycles, in order", ORANGE, size=5)
        chart.line([place - 0.3, place + 0.3], [of_cycles.mean()] * 2, "mean", BLUE, width=3)
    chart.level(0)
    chart.set_x(-0.6, len(values) - 0.4)
    chart.name_x(range(len(values)), map(str, values))
    return chart
