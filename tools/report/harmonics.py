# SPDX-License-Identifier: MIT
"""A torque over the engine cycle as a Fourier series in half the crank angle."""
import numpy as np

RESOLVED = 24  # the simulated engine's torque holds next to nothing beyond
GRID_DEG = np.arange(0, 720.1, 0.5)


def _basis(count, angle_deg):
    phase = np.outer(np.radians(angle_deg), np.arange(1, count + 1)) / 2
    return np.cos(phase), np.sin(phase)


class Series:
    """Mean and `cos`, `sin` coefficients; least squares, since the teeth leave gaps where the mark is."""

    def __init__(self, mean, cos, sin):
        self.mean, self.cos, self.sin = mean, cos, sin

    @classmethod
    def fit(cls, angle_deg, value, count):
        cos, sin = _basis(count, angle_deg)
        matrix = np.hstack([np.ones((len(angle_deg), 1)), cos, sin])
        c = np.linalg.lstsq(matrix, value, rcond=None)[0]
        return cls(c[0], c[1:count + 1], c[count + 1:])

    def first(self, count):
        return Series(self.mean, self.cos[:count], self.sin[:count])

    def at(self, angle_deg):
        cos, sin = _basis(len(self.cos), angle_deg)
        return self.mean + cos @ self.cos + sin @ self.sin

    def left_out_percent(self, count):
        """What the first `count` harmonics leave out: rms, of peak to peak."""
        whole = self.at(GRID_DEG[:-1])
        rest = whole - self.first(count).at(GRID_DEG[:-1])
        return 100 * np.sqrt(np.mean(rest**2)) / np.ptp(whole)


def shift_deg(early, late):
    """Crank angle by which `late` follows `early`, where they correlate best; means are left out."""
    count = min(len(early.cos), len(late.cos))
    cross = ((early.cos - 1j * early.sin)[:count] * np.conj(late.cos - 1j * late.sin)[:count])
    shifts_deg = np.arange(-45, 45.001, 0.01)
    rates = np.arange(1, count + 1) / 2
    return float(shifts_deg[np.argmax(np.real(np.exp(-1j * np.outer(np.radians(shifts_deg), rates)) @ cross))])
