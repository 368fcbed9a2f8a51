#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The simulated engine against tools that share nothing with it.

Cylinder pressure, motored and fired, against Cantera's NASA polynomials of air in a reactor with a moving piston;
heat release and wall loss are computed here from the equations of docs/theory/plant.md. Crank torque against an energy
balance with geometry, inertia and friction computed here from the engine file.
"""
import csv
import math
import subprocess
import sys
import tomllib
import unittest

import cantera as ct
import numpy as np

PROBE, ENGINE = sys.argv[1:3]
EICHELBERG = 7.80e-3  # W/(m2 K), p in Pa, T in K, c_m in m/s


def load_engine():
    with open(ENGINE, "rb") as file:
        return tomllib.load(file)


def trace(rpm, fuel_mg, load_nm, step_deg=0.5):
    command = [PROBE, "trace", ENGINE, str(rpm), str(fuel_mg), str(load_nm), str(step_deg)]
    text = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    rows = list(csv.DictReader(text.splitlines()))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}


class Geometry:
    def __init__(self, engine):
        c = engine["cylinders"]
        self.bore, self.rod, self.r = c["bore_m"], c["rod_m"], c["stroke_m"] / 2
        self.area = math.pi / 4 * self.bore**2
        self.clearance = self.area * 2 * self.r / (c["compression_ratio"] - 1)

    def travel(self, a):
        return self.r + self.rod - self.r * np.cos(a) - np.sqrt(self.rod**2 - (self.r * np.sin(a)) ** 2)

    def slope(self, a):
        """d(travel)/d(angle) by a central difference: no formula shared with the code under test."""
        d = 1e-5
        return (self.travel(a + d) - self.travel(a - d)) / (2 * d)

    def volume(self, a):
        return self.clearance + self.area * self.travel(a)

    def walls(self, a):
        return 2 * self.area + math.pi * self.bore * self.travel(a)


def burn_rate(engine, heat_j, a):
    """J/rad of all Wiebe pulses at angle a from firing TDC."""
    total = 0.0
    for pulse in engine["combustion"]["pulse"]:
        y = (a - math.radians(pulse["start_deg"])) / math.radians(pulse["duration_deg"])
        if y > 0:
            m, k = pulse["shape"], math.log(1000)
            rate = k * (m + 1) * y**m * math.exp(-k * y ** (m + 1))
            total += pulse.get("share", 1) * heat_j * rate / math.radians(pulse["duration_deg"])
    return total


def cantera_pressure(engine, angles, times, p0, t0, heat_j, mean_speed):
    """Pressure of a reactor of air along angle(t), rad from firing TDC, from (p0, t0) on."""
    geometry = Geometry(engine)
    gas = ct.Solution("air.yaml")
    gas.TPX = t0, p0, "N2:0.78, O2:0.21, AR:0.01"
    cylinder = ct.IdealGasReactor(gas, clone=False)
    cylinder.chemistry_enabled = False
    cylinder.volume = geometry.volume(angles[0])
    outside = ct.Solution("air.yaml")
    outside.TP = engine["plant"]["wall"]["temperature_k"], 1e5
    around = ct.Reservoir(outside, clone=False)

    def speed(t):
        return np.interp(t, times, np.gradient(angles, times))

    def angle(t):
        return np.interp(t, times, angles)

    ct.Wall(cylinder, around, A=geometry.area, velocity=lambda t: float(geometry.slope(angle(t)) * speed(t)))
    ct.Wall(around, cylinder, A=1.0, Q=lambda t: float(burn_rate(engine, heat_j, angle(t)) * speed(t)))
    walls = ct.Wall(cylinder, around, A=1.0)
    net = ct.ReactorNet([cylinder])
    net.rtol, net.atol = 1e-8, 1e-12
    net.initial_time = times[0]
    # A kink as sharp as the start of combustion must not be stepped over.
    net.max_time_step = times[1] - times[0]
    factor = engine["plant"]["wall"]["factor"] * EICHELBERG * (2 * 2 * geometry.r * mean_speed / (2 * math.pi)) ** (1 / 3)
    pressure = []
    for a, t in zip(angles, times):
        if t > times[0]:
            net.advance(t)
        state = cylinder.phase if hasattr(cylinder, "phase") else cylinder.thermo
        pressure.append(state.P)
        walls.heat_transfer_coeff = factor * math.sqrt(state.P * state.T) * geometry.walls(a)
    return np.array(pressure)


class Cantera(unittest.TestCase):
    """The plant's gas is a parabola fitted to 1.3 % of c_v; a pressure follows it more closely than that."""

    def compare(self, rpm, fuel_mg):
        engine = load_engine()
        step = 0.25
        data = trace(rpm, fuel_mg, 0 if fuel_mg == 0 else 60, step)
        valves = engine["valves"]
        first = round(valves["intake_close_deg"] / step)
        last = round((720 + valves["exhaust_open_deg"]) / step)
        part = slice(first, last)
        angles = np.radians(data["angle_deg"][part]) - 4 * math.pi
        mass, p0 = data["trapped_kg"][first], data["p0_pa"][first]
        t0 = engine["plant"]["air"]["charge_temperature_k"]
        self.assertAlmostEqual(mass * 287.0 * t0 / (p0 * Geometry(engine).volume(angles[0])), 1, places=9)
        heat = 1e-6 * fuel_mg * engine["plant"]["combustion"]["heating_value_mjpkg"] * 1e6
        outside = cantera_pressure(engine, angles, data["time_s"][part], p0, t0, heat, rpm * math.pi / 30)
        error = data["p0_pa"][part] / outside - 1
        print(f"{rpm} rpm, {fuel_mg} mg: peak {data['p0_pa'][part].max() / 1e5:.2f} bar, Cantera {outside.max() / 1e5:.2f}, "
              f"largest difference {100 * abs(error).max():.2f} %, rms {100 * np.sqrt((error**2).mean()):.2f} %")
        self.assertGreater(outside.max(), 20e5)
        self.assertLess(abs(error).max(), 0.013)

    def test_motored(self):
        self.compare(1000, 0)

    def test_fired(self):
        self.compare(1000, 17)

    def test_fired_fast(self):
        self.compare(4000, 17)


class Crank(unittest.TestCase):
    def test_energy_balance_of_two_cycles(self):
        """Work of all pistons, from pressures alone, = change of kinetic energy + friction + load, to 0.1 %."""
        engine = load_engine()
        geometry = Geometry(engine)
        data = trace(1000, 17, 60)
        angle = np.radians(data["angle_deg"])
        tdcs = np.radians(engine["cylinders"]["firing_tdc_deg"])
        gas = np.zeros_like(angle)
        inertia = np.full_like(angle, engine["crank"]["inertia_kgm2"])
        for lane, tdc in enumerate(tdcs):
            slope = geometry.slope(angle - tdc)
            gas += (data[f"p{lane}_pa"] - 1.013e5) * geometry.area * slope
            inertia += engine["crank"]["reciprocating_mass_kg"] * slope**2
        displacement = len(tdcs) * geometry.area * 2 * geometry.r
        n = data["speed_radps"] * 30 / math.pi / 1000
        c0, c1, c2 = engine["plant"]["friction"]["fmep_bar"]
        friction = 1e5 * (c0 + c1 * n + c2 * n**2) * displacement / (4 * math.pi)
        kinetic = inertia * data["speed_radps"] ** 2 / 2
        work = np.trapezoid(gas, angle)
        spent = kinetic[-1] - kinetic[0] + np.trapezoid(friction + 60, angle)
        print(f"work {work:.2f} J, accounted {spent:.2f} J, difference {100 * abs(work - spent) / work:.4f} %")
        self.assertLess(abs(work - spent), 1e-3 * work)
        # And instant by instant: the torque the truth channel names is the one the pressures make.
        self.assertLess(abs(gas - data["gas_nm"]).max(), 1e-6 * abs(gas).max())

    def test_time_is_the_integral_of_slowness(self):
        data = trace(1000, 17, 60)
        passed = np.trapezoid(1 / data["speed_radps"], np.radians(data["angle_deg"]))
        self.assertLess(abs(passed / (data["time_s"][-1] - data["time_s"][0]) - 1), 1e-6)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
