#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Whole scenarios in closed loop with an emulated controller, each the same to the byte as in one process (docs/start/porting.md).

    tests/target/whole_runs.py                        figure16, misfires, air path on every core with a floating-point unit or without
    tests/target/whole_runs.py --on cortex-m7 --run figure16

Plant and controller wait for each other. Compared are the event log, which has every event that went in and out, and the tables. Each also
with a controller that is reset in the midst, where there is no log: it holds one life of an ecu. Ends with 1 when anything differs.
"""
import argparse
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
SIXDEG, SCENARIOS = ROOT / "build/host/sixdeg", ROOT / "host_sim/data/scenarios"
CORES = ("cortex-m7", "cortex-m4f", "cortex-m3")
RUNS = {
    "figure16": ("figure16_1500rpm_9bar.toml", []),
    "misfires": ("harmonics_1500rpm_2bar.toml", ["run={duration_s=20}", "speed={mode=\"dyno\",rpm=[1000,5000],time_s=[0,20]}",
                "load.bmep_bar=8", "misfires.one_in=25", "encoder.jitter_deg=0.01", "encoder.drop_rate=0.0003"]),
    "airpath": ("airpath_section7.toml", []),
}


def run(folder, name, transport, restart):
    """Files of a run, by name."""
    scenario, settings = RUNS[name]
    folder.mkdir()
    words = [SIXDEG, "run", SCENARIOS / scenario, "--nominal", "--transport", transport, "--out", folder]
    words += [word for setting in settings for word in ("--set", setting)]
    words += ["--restart", "5"] if restart else ["--record", folder / "run.sdlog"]  # a log holds one life of an ecu
    done = subprocess.run(words, capture_output=True, text=True)
    if done.returncode != 0:
        raise SystemExit(f"whole_runs: {name} over {transport} ended with {done.returncode}: {done.stderr[-500:]}")
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.suffix in (".csv", ".sdlog")}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--run", action="append", choices=RUNS, help="these scenarios only; may be given again")
    parser.add_argument("--on", action="append", choices=CORES, help="on these cores only; may be given again")
    options = parser.parse_args()
    wrong = 0
    for preset, target in [("host", "sixdeg")] + [(core, "sixdeg_image") for core in options.on or CORES]:
        if subprocess.run([ROOT / "tools/build", preset, target], capture_output=True).returncode != 0:
            raise SystemExit(f"whole_runs: tools/build {preset} {target} fails")
    for name in options.run or RUNS:
        for restart in (False, True):
            with tempfile.TemporaryDirectory() as made:
                here = run(pathlib.Path(made, "inproc"), name, "inproc", restart)
                data = b"".join(here[file] for file in sorted(here))
                print(f"{name:9} {'reset at 5 s' if restart else 'whole':12} {len(data):9} bytes", end="", flush=True)
                for core in options.on or CORES:
                    there = run(pathlib.Path(made, core), name, f"qemu:{core}", restart)
                    differ = [file for file in here if here[file] != there.get(file)]
                    wrong += len(differ)
                    print(f"; {core} {'the same' if not differ else 'NOT: ' + ', '.join(differ)}", end="", flush=True)
                print()
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
