# SPDX-License-Identifier: MIT
"""The air path of an engine file's [airpath] as document 001 models it (B. Boulkroune and others, "Actuator fault diagnosis with
application to a diesel engine testbed", 2015): four states, three flows, and how they change.

Units of this folder: kPa, g, g/s, s. State x = [intake pressure, air, recirculated gas in the intake, gas in the exhaust manifold];
output y = [intake pressure, gas in the exhaust manifold], the second from its pressure and temperature.
    x' = A(k) x + B [air flow, fuel flow] + F_egr W_egr + F_vgt W_t,   k: intake emptying rate, 1/s, affine in all that is scheduled
"""
import tomllib
from pathlib import Path

import numpy as np

R_AIR, R_EXHAUST = 0.287, 0.286      # kPa m3/(kg K): of a gram, 1e-3 of it
TURBINE_FLOW, TURBINE_EXPONENT = 0.762, 2.89  # of document 001's model as parameterised by Wahlstrom and Eriksson, 2011
CHOKED = 0.65                        # pressure ratio below which the valve's flow no longer grows, same source
C = np.array([[1.0, 0, 0, 0], [0, 0, 0, 1.0]])
STATES = ("intake pressure", "air", "recirculated gas", "exhaust gas")


class AirPath:
    def __init__(self, engine):
        a, cylinders = engine["airpath"], engine["cylinders"]
        self.ambient_kpa = a.get("ambient_kpa", 101.11)
        self.intake_m3, self.exhaust_m3 = 1e-3 * a["intake_l"], 1e-3 * a["exhaust_l"]
        self.kappa = a.get("heat_ratio", 1.0)
        self.charge_k, self.egr_k, self.exhaust_k = a.get("charge_k", 310.0), a.get("egr_k", 370.0), a.get("exhaust_k", 720.0)
        self.displaced_m3 = np.pi / 4 * cylinders["bore_m"] ** 2 * cylinders["stroke_m"] * len(cylinders["firing_order"])
        self.efficiency = (a.get("efficiency_rpm", [0.0]), np.atleast_1d(a["volumetric_efficiency"]))
        self.egr_area = (a.get("egr_opening", [0.0]), np.atleast_1d(a["egr_area_mm2"]))
        self.turbine_area = (a.get("turbine_position", [0.0]), np.atleast_1d(a["turbine_area_mm2"]))
        self.per_air = self.kappa * R_AIR * self.charge_k / self.intake_m3 * 1e-3    # kPa/g
        self.per_egr = self.kappa * R_EXHAUST * self.egr_k / self.intake_m3 * 1e-3
        self.per_exhaust = R_EXHAUST * self.exhaust_k / self.exhaust_m3 * 1e-3
        self.per_root = 1e-3 / np.sqrt(1e3 * R_EXHAUST * self.exhaust_k) * 1e3       # g/s of 1 mm2 and 1 kPa
        self.f_egr = np.array([self.per_egr, 0, 1, -1.0])
        self.f_vgt = np.array([0, 0, 0, -1.0])

    @staticmethod
    def load(path):
        return AirPath(tomllib.loads(Path(path).read_text()))

    def emptying(self, rpm):
        """k: what the cylinders take of the intake's gas, 1/s."""
        return np.interp(rpm, *self.efficiency) * self.displaced_m3 * rpm / 120 / self.intake_m3

    def a(self, k):
        return np.array([[-self.kappa * k, 0, 0, 0], [0, -k, 0, 0], [0, 0, -k, 0], [0, k, k, 0]])

    @property
    def b(self):
        """Columns: air flow, fuel flow."""
        return np.array([[self.per_air, 0], [1.0, 0], [0, 0], [0, 1.0]])

    def egr_flow(self, opening, intake, exhaust):
        """g/s, of pressures in kPa."""
        ratio = np.clip(intake / exhaust, CHOKED, 1)
        psi = 1 - ((1 - ratio) / (1 - CHOKED) - 1) ** 2
        return np.interp(opening, *self.egr_area) * self.per_root * exhaust * psi

    def turbine_flow(self, position, exhaust):
        drop = np.sqrt(np.maximum(1 - (exhaust / self.ambient_kpa) ** -TURBINE_EXPONENT, 0))
        return np.interp(position, *self.turbine_area) * self.per_root * exhaust * TURBINE_FLOW * drop

    def rate(self, x, rpm, air, fuel, opening, position):
        exhaust = self.per_exhaust * x[3]
        egr, turbine = self.egr_flow(opening, x[0], exhaust), self.turbine_flow(position, exhaust)
        return self.a(self.emptying(rpm)) @ x + self.b @ [air, fuel] + self.f_egr * egr + self.f_vgt * turbine

    def rest(self, rpm, air, fuel, opening, position):
        """The state in which nothing changes."""
        from scipy.optimize import brentq
        def exhaust_of(intake):
            return brentq(lambda e: self.turbine_flow(position, e) - air - fuel, self.ambient_kpa * 1.0001, 5000)
        exhaust, k = exhaust_of(0), self.emptying(rpm)
        intake = brentq(lambda p: self.per_air * air + self.per_egr * self.egr_flow(opening, p, exhaust) - self.kappa * k * p, 1, 2000)
        egr = self.egr_flow(opening, intake, exhaust)
        return np.array([intake, air / k, egr / k, exhaust / self.per_exhaust])

    def slopes(self, opening, position, intake, exhaust):
        """dW_egr/dp, dW_egr/dm_X, dW_t/dm_X, g/s a kPa or a g, by central differences."""
        def slope(flow, at):
            return (flow(at + 1e-4) - flow(at - 1e-4)) / 2e-4
        return np.array([slope(lambda p: self.egr_flow(opening, p, exhaust), intake),
                         self.per_exhaust * slope(lambda p: self.egr_flow(opening, intake, p), exhaust),
                         self.per_exhaust * slope(lambda p: self.turbine_flow(position, p), exhaust)])

    def jacobian(self, slopes):
        """Of F_egr W_egr + F_vgt W_t."""
        egr_p, egr_m, turbine_m = slopes
        return np.outer(self.f_egr, [egr_p, 0, 0, egr_m]) + np.outer(self.f_vgt, [0, 0, 0, turbine_m])
