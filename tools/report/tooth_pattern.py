# SPDX-License-Identifier: MIT
"""How far each tooth of the wheel is off, from the times of its edges."""
import numpy as np

WINDOW = 6  # teeth on either side that say where one should be
LEAST_TURNS, MOST_TURNS = 5, 40


def _pass(position, angle, t_s, pitch_deg):
    """One array a tooth: deg by which it comes later than its neighbours say."""
    found = {}
    for i in range(WINDOW, len(t_s) - WINDOW):
        near = np.r_[i - WINDOW:i, i + 1:i + WINDOW + 1]
        x = angle[near] - angle[i]
        if x[-1] - x[0] > (2 * WINDOW + 8) * pitch_deg or np.any(np.diff(t_s[i - WINDOW:i + WINDOW + 1]) <= 0):
            continue
        fit = np.polyfit(x, t_s[near] - t_s[i], 3)
        if fit[-2] > 0:
            found.setdefault(int(position[i]), []).append(-fit[-1] / fit[-2])
    return {tooth: np.array(values) for tooth, values in found.items() if len(values) >= LEAST_TURNS}


def deviations(position, t_s, rpm, positions):
    """Angle in deg by which each tooth comes late, one array a tooth position; gaps of the mark and faults are left out.

    position, t_s, rpm: of placed edges in order; the last revolutions count. A cubic through the neighbours takes out what the speed
    does; what is slower than some teeth, compression among it, goes with it. A tooth that is far off is put right before its neighbours
    are looked at.
    """
    position, t_s, rpm = (values[-MOST_TURNS * positions:] for values in (position, np.array(t_s, dtype=float), rpm))
    pitch_deg = 360 / positions
    angle = np.cumsum(np.diff(position, prepend=position[0] if len(position) else 0) % positions) * pitch_deg
    put_right = {}
    for _ in range(4):
        found = _pass(position, angle, t_s, pitch_deg)
        rest = [(tooth, late, sd) for tooth, late, sd in worst(found) if tooth not in put_right]
        if not rest:
            break
        tooth, late_deg, _ = rest[0]
        put_right[tooth] = late_deg
        here = (position == tooth) & np.isfinite(rpm) & (rpm > 0)
        t_s[here] -= late_deg / (6 * np.median(rpm[np.isfinite(rpm)]))
    return {tooth: values + put_right.get(tooth, 0) for tooth, values in found.items()}


def worst(of_teeth, count=3):
    """Teeth that are off beyond what scatters: (tooth, deg late, standard deviation of that mean), the farthest first."""
    if not of_teeth:
        return []
    means = np.array([v.mean() for v in of_teeth.values()])
    usual = 1.4826 * np.median(np.abs(means - np.median(means))) + 1e-9
    rows = [(tooth, float(v.mean()), float(v.std() / np.sqrt(len(v)))) for tooth, v in of_teeth.items()]
    rows = [r for r in rows if abs(r[1]) > max(4 * usual, 4 * r[2], 0.02)]
    return sorted(rows, key=lambda r: -abs(r[1]))[:count]
