#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Makes a recording of a 60-2 crank wheel and a cam, for the demo where no real recording is at hand.

A four-cylinder engine is cranked at 250 rpm, starts, and runs up to 1500 rpm, in 10 s. The kinetic energy of its crank
is written down in closed form over crank angle a (rad, 0 = firing TDC of cylinder 1),

    E(a) = J/2 w_mean(a)^2 - A(a) (cos(2a)/2 + cos(4a)/8),

so that the torque, its derivative, is the mean load balance plus one pulse a firing, A (sin 2a + sin(4a)/2), which
pushes after TDC and brakes before it. Time follows by Simpson's rule from tooth to tooth, rounded to the microsecond
of a logger. Wheel, cam and inertia are those of engine.toml beside this file.

Columns: time in s, crank level (a tooth's angle is at its falling edge), cam level (rises once a cycle).
"""
import math
import os
import sys

POSITIONS, TEETH = 60, 58
POSITION_0_DEG = 270.0
CAM_RISE_DEG, CAM_FALL_DEG = 420.0, 480.0
INERTIA_KGM2 = 0.25
CRANK_RPM, IDLE_RPM = 250.0, 1500.0
CRANK_PULSE_NM, IDLE_PULSE_NM = 45.0, 160.0
START_REV, START_WIDTH_REV = 16.0, 5.0
REST_S, END_S = 0.3, 10.0
STEPS_A_HALF_TOOTH = 4


def progress(angle_rad):
    """0 while cranking, 1 when running."""
    return 1 / (1 + math.exp(-(angle_rad / (2 * math.pi) - START_REV) / START_WIDTH_REV * 4))


def speed_radps(angle_rad):
    x = progress(angle_rad)
    mean = (CRANK_RPM + (IDLE_RPM - CRANK_RPM) * x) * math.pi / 30
    pulse_nm = CRANK_PULSE_NM + (IDLE_PULSE_NM - CRANK_PULSE_NM) * x
    pulse_j = pulse_nm * (math.cos(2 * angle_rad) / 2 + math.cos(4 * angle_rad) / 8)
    return math.sqrt(mean * mean - 2 * pulse_j / INERTIA_KGM2)


def duration_s(from_rad, to_rad):
    """Simpson's rule over 1/w."""
    n = 2 * STEPS_A_HALF_TOOTH
    h = (to_rad - from_rad) / n
    total = 0.0
    for i in range(n + 1):
        weight = 1 if i in (0, n) else 4 if i % 2 else 2
        total += weight / speed_radps(from_rad + i * h)
    return total * h / 3


def events():
    """(time in s, crank level, cam level), one a change."""
    half_tooth_deg = 180.0 / POSITIONS
    half_teeth, t_s, crank, cam = 21, REST_S, 0, 0
    yield 0.0, crank, cam
    while t_s < END_S:
        angle_deg = POSITION_0_DEG + half_teeth * half_tooth_deg
        place = half_teeth % (2 * POSITIONS)
        # A tooth is high for the half pitch before its falling edge.
        rises = place % 2 == 1 and (place + 1) // 2 % POSITIONS < TEETH
        falls = place % 2 == 0 and place // 2 < TEETH
        cam_now = int(CAM_RISE_DEG <= angle_deg % 720 < CAM_FALL_DEG)
        if rises or falls or cam_now != cam:
            crank, cam = (1 if rises else 0 if falls else crank), cam_now
            yield t_s, crank, cam
        next_rad = math.radians(angle_deg + half_tooth_deg)
        t_s += duration_s(math.radians(angle_deg), next_rad)
        half_teeth += 1


def main():
    if len(sys.argv) != 2:
        sys.exit("usage: make_trace.py FILE.csv")
    path = sys.argv[1]
    os.makedirs(os.path.dirname(path) or ".", exist_ok=True)
    with open(path + ".partial", "w", encoding="ascii", newline="\n") as out:
        out.write("time_s,crank,cam\n")
        for t_s, crank, cam in events():
            out.write(f"{t_s:.6f},{crank},{cam}\n")
    os.replace(path + ".partial", path)


if __name__ == "__main__":
    main()
