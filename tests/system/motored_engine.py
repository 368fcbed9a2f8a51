# SPDX-License-Identifier: MIT
"""A recording of an engine without combustion, teeth and cylinder pressure in one table: isentropic gas, kinetic energy, fine steps.

The truth differs from the engine file by what is given: inertia, place of the wheel, and one tooth that stands off.
"""
import tomllib

import numpy as np

GAMMA, INTAKE_BAR, DRAG_NM, STEP_DEG = 1.36, 0.9, 4.0, 0.25
ODD_TOOTH, ODD_DEG = 7, 0.4


class Motored:
    def __init__(self, engine_path, inertia_kgm2, offset_deg):
        with open(engine_path, "rb") as file:
            engine = tomllib.load(file)
        self.cylinders, self.crank, self.wheel = engine["cylinders"], engine["crank"], engine["wheel"]
        self.inertia, self.offset = inertia_kgm2, offset_deg
        self.tdc = self.cylinders["firing_tdc_deg"]
        deg = np.arange(-360, 360, STEP_DEG)
        self.bar = np.where(np.abs(deg) < 150, INTAKE_BAR * (self._volume(150.0) / self._volume(deg)) ** GAMMA, INTAKE_BAR)
        arm = self._arm(deg)
        one = 1e5 * (self.bar - 1.013) * arm * self._area()
        turned = [np.roll(np.arange(len(deg)), int(tdc / STEP_DEG)) for tdc in self.tdc]
        self.torque = sum(one[t] for t in turned)
        self.moving = self.inertia + self.crank.get("reciprocating_mass_kg", 0) * sum((arm ** 2)[t] for t in turned)

    def _area(self):
        return np.pi / 4 * self.cylinders["bore_m"] ** 2

    def _arm(self, deg):
        a, r = np.radians(deg), self.cylinders["stroke_m"] / 2
        return r * np.sin(a) * (1 + r * np.cos(a) / np.sqrt(self.cylinders["rod_m"] ** 2 - (r * np.sin(a)) ** 2))

    def _volume(self, deg):
        a, r, rod = np.radians(deg), self.cylinders["stroke_m"] / 2, self.cylinders["rod_m"]
        way = r * (1 - np.cos(a)) + rod - np.sqrt(rod ** 2 - (r * np.sin(a)) ** 2)
        return self._area() * (self.cylinders["stroke_m"] / (self.cylinders["compression_ratio"] - 1) + way)

    def rows(self, speeds_rpm, cycles):
        """Time, s, crank level and cylinder pressure, bar, of so many cycles at each speed, coasting on from one to the next."""
        points, all_rows, start_s = len(self.bar), [], 0.0
        random = np.random.default_rng(3)
        for rpm in speeds_rpm:
            deg = -360 + STEP_DEG * np.arange(cycles * points + 1)
            torque = np.tile(self.torque, cycles) - DRAG_NM
            moving = np.append(np.tile(self.moving, cycles), self.moving[0])
            work = np.append(0, np.cumsum((torque + np.roll(torque, -1)) / 2)) * np.radians(STEP_DEG)
            speed = np.sqrt(2 * (moving[0] / 2 * (rpm * np.pi / 30) ** 2 + work) / moving)
            t = start_s + np.append(0, np.cumsum(np.radians(STEP_DEG) * 2 / (speed[1:] + speed[:-1])))
            every = slice(None, None, 4)
            all_rows += [(a, None, p) for a, p in zip(t[every], np.append(np.tile(self.bar, cycles), self.bar[0])[every])]
            for k in range(int(deg[-1] / 6) + 70):
                if k % 60 < 58:
                    tooth = self.wheel["position_0_deg"] + self.offset - 720 + 6 * k + (ODD_DEG if k % 60 == ODD_TOOTH else 0)
                    falls, rises = np.interp([tooth, tooth + 3], deg, t, left=np.nan, right=np.nan)
                    if falls > t[0] and rises < t[-1]:
                        all_rows += [(falls + random.normal(0, 2e-7), 0, np.nan), (rises, 1, np.nan)]
            start_s = t[-1] + 0.7
        return sorted(all_rows, key=lambda row: row[0])

    def write(self, path, speeds_rpm=(1200, 3000), cycles=14):
        level, bar = 1, INTAKE_BAR
        with open(path, "w", encoding="utf-8") as file:
            file.write("time [s],crank,pressure\n")
            for t, now, pressure in self.rows(speeds_rpm, cycles):
                level, bar = level if now is None else now, bar if np.isnan(pressure) else pressure
                file.write(f"{t:.8f},{level},{bar + 20:.4f}\n")
