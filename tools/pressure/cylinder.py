# SPDX-License-Identifier: MIT
"""Cylinder pressure into torque and work: level (pegging), angle of TDC, work of each cycle.

The sensor tells changes of pressure, so its level is set anew for each cycle. By `intake`: the mean pressure within 10 deg of the BDC
before compression is the intake's. By `compression`: p + b = C V^-n from the closing of the intake valve to 40 deg ahead of TDC, with n
given; b by least squares. Work of the closed cycle does not depend on the level, so these differ in torque alone.
"""
import dataclasses
import tomllib

import numpy as np

PASCAL_PER_BAR = 1e5
EXPONENT, EXPONENT_SD = 1.32, 0.02  # of unburned mixture in a cool cylinder (Heywood, Internal Combustion Engine Fundamentals, 9.2)


@dataclasses.dataclass
class Geometry:
    """Of one cylinder, and when it fires."""
    bore_m: float
    stroke_m: float
    rod_m: float
    compression: float
    intake_close_deg: float
    firing_order: list
    firing_tdc_deg: list
    inertia_kgm2: float

    @classmethod
    def read(cls, path):
        with open(path, "rb") as file:
            engine = tomllib.load(file)
        c = engine["cylinders"]
        return cls(c["bore_m"], c["stroke_m"], c["rod_m"], c["compression_ratio"], engine.get("valves", {}).get("intake_close_deg", 580.0),
                   c["firing_order"], c["firing_tdc_deg"], engine["crank"]["inertia_kgm2"])

    @property
    def displaced_m3(self):
        return np.pi / 4 * self.bore_m ** 2 * self.stroke_m

    def _height(self, deg):
        a, r = np.radians(deg), self.stroke_m / 2
        root = np.sqrt(self.rod_m ** 2 - (r * np.sin(a)) ** 2)
        return r * (1 - np.cos(a)) + self.rod_m - root, r * np.sin(a) * (1 + r * np.cos(a) / root)

    def volume(self, deg):
        return self.displaced_m3 / (self.compression - 1) + np.pi / 4 * self.bore_m ** 2 * self._height(deg)[0]

    def slope(self, deg):
        """dV/da, m3/rad."""
        return np.pi / 4 * self.bore_m ** 2 * self._height(deg)[1]


@dataclasses.dataclass
class Cycle:
    """One cycle of a cylinder, from 360 deg ahead of its firing TDC to 360 deg behind it."""
    tdc_deg: float
    deg: np.ndarray      # from TDC
    bar: np.ndarray      # absolute
    t_s: np.ndarray
    level_bar: float     # what was added
    work_j: float        # integral of p dV
    torque_nm: np.ndarray  # (p - 1 bar) dV/da


def compression_fit(geometry, deg, bar, exponent, window):
    """C of a volume at BDC, b, and the rms of what is left, of p + b = C (V/V_bdc)^-n in a window of deg from TDC."""
    inside = (deg > window[0]) & (deg < window[1])
    if inside.sum() < 10:
        return np.nan, np.nan, np.nan
    shape = (geometry.volume(deg[inside]) / geometry.volume(180.0)) ** -exponent
    fitted = np.polynomial.polynomial.polyfit(shape, bar[inside], 1)
    left = bar[inside] - fitted[0] - fitted[1] * shape
    return fitted[1], -fitted[0], np.sqrt(np.mean(left ** 2))


def level(geometry, deg, bar, intake_bar=None, exponent=EXPONENT):
    """What to add to a cycle's pressure, bar."""
    if intake_bar is not None:
        return intake_bar - np.mean(bar[np.abs(deg + 180) < 10])
    return compression_fit(geometry, deg, bar, exponent, (geometry.intake_close_deg - 720 + 10, -40))[1]


def pressure_at_bdc(geometry, cycles):
    """Of these cycles, by the polytropic line of their compression, bar absolute: what the intake pressure must have been."""
    window = (geometry.intake_close_deg - 720 + 10, -40)
    return float(np.mean([compression_fit(geometry, c.deg, c.bar, EXPONENT, window)[0] for c in cycles]))


def cycles_of(geometry, deg, t_s, bar, firing_tdc_deg, intake_bar=None, shift_deg=0.0):
    """Whole cycles of the cylinder that fires at this angle. shift_deg: by how much later than the teeth say TDC is."""
    first = int(np.ceil((np.nanmin(deg) + 360 - firing_tdc_deg - shift_deg) / 720))
    last = int(np.floor((np.nanmax(deg) - 360 - firing_tdc_deg - shift_deg) / 720))
    cycles = []
    for number in range(first, last + 1):
        tdc = 720 * number + firing_tdc_deg + shift_deg
        inside = np.abs(deg - tdc) <= 360
        local, raw = deg[inside] - tdc, bar[inside]
        added = level(geometry, local, raw, intake_bar)
        pressure, volume = raw + added, geometry.volume(local)
        work = PASCAL_PER_BAR * np.sum((pressure[1:] + pressure[:-1]) / 2 * np.diff(volume))
        torque = PASCAL_PER_BAR * (pressure - 1) * geometry.slope(local)
        cycles.append(Cycle(tdc - shift_deg, local, pressure, t_s[inside], added, work, torque))
    return cycles


def tdc_shift(geometry, deg, bar, firing_tdc_deg):
    """By how much later than the teeth say TDC is, deg, and its standard deviation: where compression is polytropic best, by windows and
    exponents. Heat to the walls and spikes of the ignition move it, which is what the spread over windows says."""
    tops = [720 * n + firing_tdc_deg for n in range(int(np.ceil((np.nanmin(deg) + 200) / 720)), int(np.nanmax(deg) // 720))]
    tries = np.arange(-6, 6.01, 0.25)
    answers = []
    for window in ((-110, -25), (-100, -30), (-90, -25), (-120, -40)):
        for exponent in (EXPONENT - EXPONENT_SD, EXPONENT, EXPONENT + EXPONENT_SD):
            left = [np.nanmean([compression_fit(geometry, deg - top - shift, bar, exponent, window)[2] ** 2 for top in tops])
                    for shift in tries]
            answers.append(tries[int(np.argmin(left))])
    return float(np.mean(answers)), float(np.std(answers))
