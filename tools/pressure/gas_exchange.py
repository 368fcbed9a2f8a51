# SPDX-License-Identifier: MIT
"""Where each tooth of a single cylinder's wheel stands, from the revolution in which it does not fire, by teeth alone.

From BDC behind the firing to BDC ahead of the compression the gas does next to no work, so that the crank turns by its energy, the
reciprocating mass and a steady load: t(a) = t0 + integral of sqrt(J(a) / 2 (E - L a)) da. t0, E and L are fitted to each cycle; what is
left of a tooth, averaged over cycles, is its lateness. Load and the wheel's first two orders look alike in one revolution, so an error of
the reciprocating mass goes into the pattern.
"""
import tomllib

import numpy as np
from scipy.optimize import least_squares

FROM_DEG, TO_DEG, STEP_DEG = 180.0, 540.0, 0.5


class Crank:
    """Inertia over the angle from firing TDC, kg m2."""

    def __init__(self, engine_path):
        with open(engine_path, "rb") as file:
            engine = tomllib.load(file)
        self.inertia, self.mass = engine["crank"]["inertia_kgm2"], engine["crank"].get("reciprocating_mass_kg", 0.0)
        self.radius, self.rod = engine["cylinders"]["stroke_m"] / 2, engine["cylinders"]["rod_m"]

    def at(self, deg):
        a, r = np.radians(deg), self.radius
        arm = r * np.sin(a) * (1 + r * np.cos(a) / np.sqrt(self.rod ** 2 - (r * np.sin(a)) ** 2))
        return self.inertia + self.mass * arm ** 2


def lateness_of(crank, deg, t_s):
    """Of the teeth of one revolution, deg: by how much each comes behind a crank that nothing but a steady load slows."""
    grid = np.arange(FROM_DEG, TO_DEG + STEP_DEG, STEP_DEG)
    speed = np.radians(deg[-1] - deg[0]) / (t_s[-1] - t_s[0])
    energy = crank.at(deg).mean() / 2 * speed ** 2

    def late_s(p):
        slowness = np.sqrt(crank.at(grid) / 2 / (energy * (p[1] - p[2] * (grid - FROM_DEG) / 360)))
        passed = np.concatenate([[0], np.cumsum((slowness[1:] + slowness[:-1]) / 2 * np.radians(STEP_DEG))])
        return t_s - t_s[0] - p[0] * 1e-5 - np.interp(deg, grid, passed), np.interp(deg, grid, slowness)

    found = least_squares(lambda p: late_s(p)[0] * speed, [0.0, 1.0, 0.02])
    late, slowness = late_s(found.x)
    return np.degrees(late / slowness)


def tooth_pattern(replayed, engine_path, firing_tdc_deg, until_deg):
    """Lateness of each tooth by its position, deg, NaN where none passed; and how many cycles up to an angle it is from."""
    crank = Crank(engine_path)
    position = np.array([int(row["tooth"]) for row in replayed.known])
    local = replayed.deg - firing_tdc_deg
    found, cycles = [[] for _ in range(position.max() + 1)], 0
    for number in range(int(local[0] // 720), int(local[-1] // 720) + 1):
        at = np.flatnonzero((local >= 720 * number + FROM_DEG) & (local < 720 * number + TO_DEG) & (replayed.deg < until_deg))
        if len(at) < len(set(position)):
            continue
        cycles += 1
        for k, late in zip(position[at], lateness_of(crank, local[at] - 720 * number, replayed.t_s[at])):
            found[k].append(late)
    return np.array([np.mean(late) if late else np.nan for late in found]), cycles


def write_corrected(path, replayed, pattern):
    """Times of the placed teeth as they would be on a wheel without that pattern, a list of edges."""
    position = np.array([int(row["tooth"]) for row in replayed.known])
    speed = np.gradient(replayed.deg, replayed.t_s)
    times = replayed.t_s - np.nan_to_num(pattern)[position] / speed
    path.write_text("time [s]\n" + "".join(f"{t:.9f}\n" for t in times), encoding="utf-8")
