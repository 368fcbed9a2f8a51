# SPDX-License-Identifier: MIT
"""The observer document 004 compares with: torque as a constant that the kinetic energy drags along.

    phi' = T - 2 p e    T' = -p^2 e    e = phi - E     per rad of crank angle

with E = J(alpha) omega^2 / 2 of the tooth period, J where its middle stands. Both poles are at -p.
"""
import numpy as np

POLE_PER_RAD = 6.0  # settles within a firing interval


def inertia_kgm2(engine, angle_deg):
    """J(alpha) of the engine file: the crank and the reciprocating masses, each with its (dx/dalpha)^2."""
    cylinders, crank = engine["cylinders"], engine["crank"]
    r, rod = cylinders["stroke_m"] / 2, cylinders["rod_m"]
    total = np.full(len(angle_deg), float(crank["inertia_kgm2"]))
    for tdc_deg in cylinders["firing_tdc_deg"]:
        sin, cos = np.sin(np.radians(angle_deg - tdc_deg)), np.cos(np.radians(angle_deg - tdc_deg))
        lever_m = r * sin + r**2 * sin * cos / np.sqrt(rod**2 - (r * sin)**2)
        total += crank.get("reciprocating_mass_kg", 0) * lever_m**2
    return total


def torque_nm(engine, t_s, angle_deg):
    """The torque at each tooth, from times as the engine's capture timer rounds them."""
    tick_hz = engine.get("timer", {}).get("tick_hz", 1e6)
    captured_s = np.floor(t_s * tick_hz) / tick_hz
    turned_deg = np.diff(angle_deg) % 720
    omega = np.radians(turned_deg) / np.diff(captured_s)
    energy_j = inertia_kgm2(engine, angle_deg[1:] - turned_deg / 2) * omega**2 / 2
    torque, estimates = 0.0, [0.0]
    phi = energy_j[0]
    for turn, energy in zip(np.radians(turned_deg), energy_j):
        # Exact while the energy holds: exp(A d) = exp(-p d) (1 + (A + p) d).
        e, p, left = phi - energy, POLE_PER_RAD, np.exp(-POLE_PER_RAD * turn)
        phi = energy + left * (e + (torque - p * e) * turn)
        torque = left * (torque + (p * torque - p * p * e) * turn)
        estimates.append(torque)
    return np.array(estimates)
