#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""A large recording through `sixdeg replay`: memory and speed. Goals: at most 200 MB, at least 50 MB a second of one core.

usage: large_recording.py [--mb N]
       exit status 1 where a goal is missed
"""
import argparse
import os
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

SIXDEG = os.environ.get("SIXDEG", str(pathlib.Path(__file__).resolve().parents[2] / "build" / "host" / "sixdeg"))
STEP_S, RPM = 1e-5, 1500.0
MEMORY_MB, MB_A_SECOND = 200, 50


def write(path, size_mb):
    """Two voltages at 100 kHz: a 60-2 wheel and a cam, with noise; the same stretch of 8 cycles again and again at later times."""
    cycle_s, random = 120 / RPM, np.random.default_rng(1)
    time = np.arange(round(8 * cycle_s / STEP_S)) * STEP_S
    position = time * RPM / 60 * 60
    crank = np.where((position % 60 < 58) & (position % 1 < 0.5), 4.9, 0.1) + random.normal(0, 0.05, len(time))
    cam = np.where((position % 120 > 40) & (position % 120 < 60), 4.9, 0.1) + random.normal(0, 0.05, len(time))
    cells = [f",{a:.3f},{b:.3f}\n" for a, b in zip(crank, cam)]
    with open(path, "w", encoding="ascii") as out:
        out.write("time [s],crank [V],cam [V]\n")
        first = 0
        while out.tell() < size_mb * 1e6:
            out.write("".join(f"{(first + i) * STEP_S:.5f}{cell}" for i, cell in enumerate(cells)))
            first += len(cells)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--mb", type=float, default=1000)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "large.csv")
        write(path, options.mb)
        size_mb = os.path.getsize(path) / 1e6
        with subprocess.Popen([SIXDEG, "replay", path, "--out", os.path.join(folder, "out")], stdout=subprocess.PIPE, text=True) as process:
            words = process.stdout.read()
            _, status, used = os.wait4(process.pid, 0)
            process.returncode = os.waitstatus_to_exitcode(status)
    busy_s, memory_mb = used.ru_utime + used.ru_stime, used.ru_maxrss / 1024
    print(words.splitlines()[1])
    print(f"{size_mb:.0f} MB: {memory_mb:.0f} MB of memory, {busy_s:.1f} s of one core, {size_mb / busy_s:.0f} MB a second")
    return 0 if process.returncode == 0 and memory_mb <= MEMORY_MB and size_mb / busy_s >= MB_A_SECOND else 1


if __name__ == "__main__":
    sys.exit(main())
