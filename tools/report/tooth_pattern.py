# SPDX-License-Identifier: MIT
"""How far each tooth of the wheel is off, from the times of its edges."""
import numpy as np

WINDOW = 6  # teeth on either side that say where one should be
LEAST_TURNS = 5


def deviations(position, t_s, rpm, positions):
    """Angle in deg by which each tooth comes late, one array a tooth position; gaps of the mark and faults are left out.

    position, t_s, rpm: of placed edges in order. A cubic through the neighbours takes out what the speed does; what is slower than some
    teeth, compression among it, goes with it.
    """
    pitch_deg = 360 / positions
    step = np.diff(position, prepend=position[0]) % positions
    angle = np.cumsum(step) * pitch_deg
    found = {}
    for i in range(WINDOW, len(t_s) - WINDOW):
        near = np.r_[i - WINDOW:i, i + 1:i + WINDOW + 1]
        x = angle[near] - angle[i]
        if x[-1] - x[0] > (2 * WINDOW + 8) * pitch_deg or np.any(np.diff(t_s[i - WINDOW:i + WINDOW + 1]) <= 0):
            continue
        fit = np.polyfit(x, t_s[near] - t_s[i], 3)
        if not np.isfinite(rpm[i]) or rpm[i] <= 0:
            continue
        found.setdefault(int(position[i]), []).append(-fit[-1] * rpm[i] * 6)
    return {tooth: np.array(values) for tooth, values in found.items() if len(values) >= LEAST_TURNS}


def worst(of_teeth, count=3):
    """Teeth that are off beyond what scatters: (tooth, deg late, standard deviation of that mean), the farthest first."""
    if not of_teeth:
        return []
    means = np.array([v.mean() for v in of_teeth.values()])
    usual = 1.4826 * np.median(np.abs(means - np.median(means))) + 1e-9
    rows = [(tooth, float(v.mean()), float(v.std() / np.sqrt(len(v)))) for tooth, v in of_teeth.items()]
    rows = [r for r in rows if abs(r[1]) > max(4 * usual, 4 * r[2], 0.02)]
    return sorted(rows, key=lambda r: -abs(r[1]))[:count]
