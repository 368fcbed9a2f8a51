# SPDX-License-Identifier: MIT
"""What each observer says of a recording beside its cylinder pressure: work of a cycle, and torque over the angle."""
import dataclasses

import numpy as np

import recording as rec

SAME_TEETH = "energy at the same teeth (`work.cycle`)"
CHANGE = "energy at the same teeth, against the cycle before (`work.change`)"  # the one value that is of one cylinder of several
FILTER_FIRING = "filter on tooth times, its firing (`firing.torque`)"
WAVEFORMS = {"filter": ("torque_nm", "torque_health", "filter on tooth times (`firing.waveform`)"),
             "fourier": ("fourier_nm", "fourier_health", "Fourier observer (`torque.mass`)")}
MEAN_STEP_DEG = 2.0


@dataclasses.dataclass
class Figures:
    """Of an estimate x against truth y, each less its mean; percent of the mean truth."""
    count: int
    correlation: float
    rms_percent: float
    gain: float
    skill: float  # 1 less the mean square error over that of the baseline

    @classmethod
    def of(cls, x, y, baseline, mean):
        if len(x) < 3:
            return None
        a, b, scale = x - np.mean(x), y - np.mean(y), 100 / mean
        both = np.sqrt(np.mean(a ** 2) * np.mean(b ** 2))
        error = np.mean((a - b) ** 2)
        return cls(len(x), float(np.mean(a * b) / both) if both > 0 else 0.0, float(scale * np.sqrt(error)),
                   float(np.mean(a * b) / np.mean(a ** 2)) if both > 0 else 0.0, float(1 - error / np.mean((y - baseline) ** 2)))


def usable(rows, value, health):
    """A column with NaN where the value is invalid."""
    x = rec.numbers(rows, value)
    x[[row[health] == "invalid" for row in rows]] = np.nan
    return x


def work_by_cycle(replayed, cycles, cylinder, single):
    """Each observer's work of the cycles that it tells, by index into `cycles`, J; of one cylinder of several what is its own alone."""
    tdc = np.array([c.tdc_deg for c in cycles])

    def by_tdc(deg, values):
        found = {}
        for at, value in zip(deg, values):
            index = np.searchsorted(tdc, at) - 1
            if np.isfinite(value) and index >= 0 and at - tdc[index] < 720:
                found[int(index)] = float(value)
        return found

    def of_table(rows, value, factor):
        own = [r for r in rows if int(r["cylinder"]) == cylinder]
        return by_tdc(replayed.angle(rec.numbers(own, "t_s")), factor * usable(own, value, "health")) if own else {}

    same = {SAME_TEETH: of_table(replayed.work, "work_j", 1.0)} if single else {CHANGE: of_table(replayed.work, "change_j", 1.0)}
    told = {**same, FILTER_FIRING: of_table(replayed.firings, "torque_nm", np.pi)}
    if not single:
        return told
    for value, health, name in WAVEFORMS.values():
        torque = usable(replayed.known, value, health)
        means = [np.mean(torque[np.abs(replayed.deg - top) <= 360]) for top in tdc] # NaN where any tooth has none
        told[f"{name}, integrated"] = {i: 4 * np.pi * m for i, m in enumerate(means) if np.isfinite(m)}
    return told


def without_mean(x):
    return x - np.mean(x)


def truth_at_teeth(replayed, cycle):
    """Teeth of a cycle, and the torque of its pressure there, less its mean over the cycle."""
    inside = np.flatnonzero(np.abs(replayed.deg - cycle.tdc_deg) <= 357)
    local = replayed.deg[inside] - cycle.tdc_deg
    even = np.interp(np.arange(-360, 360, 1.0), cycle.deg, cycle.torque_nm)
    return inside, local, np.interp(local, cycle.deg, cycle.torque_nm) - np.mean(even)


def mean_waveform(replayed, cycles):
    """Of these cycles: torque over the angle from TDC, less its mean, as a function of it."""
    grid = np.arange(-360, 360 + MEAN_STEP_DEG, MEAN_STEP_DEG)
    curves = [np.interp(grid, *truth_at_teeth(replayed, cycle)[1:]) for cycle in cycles]
    mean = np.mean(curves, axis=0)
    return lambda deg: np.interp(deg, grid, mean)


def waveform_figures(replayed, cycles, value, health, baseline):
    """Share explained (R2), skill over the baseline, and how many cycles, of torque at teeth less each cycle's mean."""
    torque = usable(replayed.known, value, health)
    error = truth = usual = count = 0.0
    for cycle in cycles:
        inside, local, y = truth_at_teeth(replayed, cycle)
        if not np.all(np.isfinite(torque[inside])):
            continue
        y = without_mean(y)
        error += np.sum((without_mean(torque[inside]) - y) ** 2)
        truth += np.sum(y ** 2)
        usual += np.sum((without_mean(baseline(local)) - y) ** 2)
        count += 1
    if count == 0:
        return None
    return {"r2": 1 - error / truth, "baseline": 1 - usual / truth, "skill": 1 - error / usual, "cycles": int(count)}
