# SPDX-License-Identifier: MIT
"""The torque waveforms of a run, in numbers: what document 004's figures 5 and 6 show."""
import numpy as np

from harmonics import GRID_DEG, RESOLVED, Series, shift_deg

COUNTS = (3, 5, 8, 12)


class Waveforms:
    """Over the last whole cycles of a run; there must be one."""

    def __init__(self, run):
        cycles = run.cycles()
        teeth, pole_nm, n_h = run.teeth, run.pole_placement_nm(), run.harmonics()
        rows = np.concatenate([np.arange(c.start, c.stop) for c in cycles])
        angle_deg = teeth.angle_deg[rows]
        self.cycles, self.n_h = len(cycles), n_h
        resolved = min(RESOLVED, len(rows) // len(cycles) // 3)  # coarse wheels allow less
        self.truth = Series.fit(angle_deg, teeth.true_nm[rows], resolved)
        estimate = Series.fit(angle_deg, teeth.estimate_nm[rows], n_h)
        self.shift_deg = shift_deg(self.truth.first(n_h), estimate)
        self.pole_lag_deg = shift_deg(self.truth, Series.fit(angle_deg, pole_nm[rows], resolved))
        self.peak_percent = 100 * estimate.at(GRID_DEG).max() / self.truth.first(n_h).at(GRID_DEG).max()
        last = np.arange(cycles[-1].start, cycles[-1].stop + 1)  # up to the next cycle's first tooth
        self.angle_deg = np.append(teeth.angle_deg[last[:-1]], 720 + teeth.angle_deg[last[-1]])
        self.true_nm, self.estimate_nm, self.pole_nm = teeth.true_nm[last], teeth.estimate_nm[last], pole_nm[last]
        self.filter_nm = None if teeth.filter_nm is None else teeth.filter_nm[last]

    def left_out_percent(self):
        """By number of harmonics, as far as the teeth tell."""
        return {n: self.truth.left_out_percent(n) for n in COUNTS if n < len(self.truth.cos)}
