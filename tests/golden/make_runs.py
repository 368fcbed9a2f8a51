#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Makes the golden runs again: tests/golden/make_runs.py [NAME...]    (docs/results/golden.md)

Each is recorded with `sixdeg run --record`; of the log only what went into the ecu is kept, by name. A new recording has
other inputs wherever the simulated engine has changed, so its hashes are new too: make one again only on purpose, with
an ecu whose old hashes have just been confirmed.
"""
import argparse
import pathlib
import subprocess
import sys
import tempfile
import tomllib
import zlib

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools" / "log"))
from event_log import EventLog  # noqa: E402  the path comes first

HERE = pathlib.Path(__file__).resolve().parent
SIXDEG = ROOT / "build" / "host" / "sixdeg"
SCENARIOS = ROOT / "host_sim" / "data" / "scenarios"
ENGINES = "../engines/"  # as scenarios name them
LETTER = {1: "c", 2: "k", 3: "t", 8: "g"}  # crank edge, cam edge, clock, gap
SAMPLE = 4

FIGURE16, TIP_IN, LEARN = "figure16_1500rpm_9bar.toml", "tip_in.toml", "learn_pattern.toml"
PLAIN = "harmonics_1500rpm_2bar.toml"  # no exhaust sensor
USUAL = ["encoder.jitter_deg=0.01", "encoder.pattern_rms_deg=0.02", "cyclic.cov_percent=2"]

MISFIRING = USUAL + ["run={duration_s=6}", "speed={mode=\"dyno\",rpm=[2000,3500],time_s=[0,6]}", "load.bmep_bar=8",
                     "load.fuel_cut_s=[2.5,2.7]",
                     "misfires.one_in=25", "encoder.drop_rate=0.0003"]

# name: scenario; what is set in it; tune; and (second, command...) put into the stream: "p NAME VALUE" sets a parameter,
# "d NAME" restores it ("d all": the whole page), "q NAME" reads it, "g" is a gap. ticks: what the timer stands at first.
RUNS = {
    "smooth": (FIGURE16, ["run.duration_s=5", "encoder.jitter_deg=0.01"], {}, [], 0),
    "rough": (PLAIN, USUAL + ["run={duration_s=6}", "load.bmep_bar=6", "load.road_rms_nm=60"], {},
              [(4, "p firing.pattern_sd 0.05"), (4.5, "d all")], 0),
    "misfires": (PLAIN, USUAL + ["run={duration_s=6}", "speed.rpm=3000", "load.bmep_bar=8", "misfires.one_in=25",
                                 "misfires.burned_fraction=0.1"], {},
                 [(3, "q misfire.cyclic_variation"), (4, "p misfire.misfire_below 0.6"), (5, "p misfire.partial_burn_below 0.3"),
                  (5.2, "d misfire.misfire_below")], 0),
    "folsmo": (PLAIN, MISFIRING, {"misfire.method": 1},
               [(3, "q misfire.method"), (4, "p misfire.misfire_below 0.6"), (5, "p misfire.method 0"),
                                                         (5.5, "p misfire.method 1")], 0),
    "folsmo_q31": (PLAIN, MISFIRING, {"misfire.method": 1, "misfire.arithmetic": 1},
                   [(3, "p misfire.method 3"), (4, "p misfire.method 2"), (5, "p misfire.arithmetic 0")], 0),
    "fuel_cut": (LEARN, ["load.bmep_bar=6", "load.fuel_cut_s=[0.3,6.5]"], {},
                 [(7.5, "p firing.enabled 0"), (7.6, "p firing.enabled 1")], 0),
    "tip_in": (TIP_IN, ["run.duration_s=8", "load.time_s=[0,4,4.2,6,6.2]", "encoder.jitter_deg=0.01", "uego.sample_us=2000"],
               {"afr.delay_learning": 2}, [(5, "p balance.integral_gain 0.05"), (7, "p balance.source 2"), (7.5, "q afr.lag_error_sd")], 0),
    "faults": (PLAIN, USUAL + ["run={duration_s=8}", "speed={mode=\"dyno\",rpm=[700,700,4000,1500],time_s=[0,1,5,8]}", "load.bmep_bar=5",
                               "encoder.drop_rate=0.001", "encoder.drop_burst=2", "encoder.extra_rate=0.001", "encoder.extra_burst=1.5",
                               "encoder.cam.drop_rate=0.1"], {}, [(6, "g")], 2**32 - 3_000_000),
    "q31": (FIGURE16, ["run.duration_s=5", "encoder.jitter_deg=0.01", "uego.sample_us=2000"], {"torque.fixed_point": 1},
            [(4, "p torque.harmonics 8")], 0),
    "chain": (FIGURE16, ["run.duration_s=5", "encoder.jitter_deg=0.01", "uego.sample_us=2000"], {"afr.method": 2},
              [(4, "p afr.method 3")], 0),
    "fixed": (FIGURE16, ["run.duration_s=5", "encoder.jitter_deg=0.01", "uego.sample_us=2000", "exhaust_sensors.pressure_sample_us=2000"],
              {"torque.fixed_point": 1, "afr.method": 3, "afr.arithmetic": 1, "misfire.method": 1, "misfire.arithmetic": 1,
               "firing.enabled": 0}, [], 0),
    "twist": (PLAIN, USUAL + [f'engine="{ENGINES}eight_diesel.toml"', "run={duration_s=5}", "load.bmep_bar=8",
                              "misfires.one_in=60"], {}, [], 0),
    "dual_mass": (PLAIN, USUAL + [f'engine="{ENGINES}triple_10.toml"', "run={duration_s=5}", "speed.rpm=1200", "load.bmep_bar=6",
                                  "misfires.one_in=40"], {}, [], 0),
    "single": (PLAIN, USUAL + [f'engine="{ENGINES}single_generator.toml"', "run={duration_s=5}", "speed.rpm=3000",
                               "load.bmep_bar=4"], {}, [], 0),
}


def record(name, folder):
    """The log of a run, the command that made it and its engine's file."""
    scenario, settings, tune, _, _ = RUNS[name]
    arguments = [f"--set={item}" for item in settings] + [f"--set={key}={value}" for key, value in tune.items()]
    log = folder / "run.sdlog"
    subprocess.run([SIXDEG, "run", SCENARIOS / scenario, "--nominal", "--record", log] + arguments, check=True, stdout=subprocess.DEVNULL)
    made = " ".join(["sixdeg run", scenario, "--nominal"] + [f"'{item}'" for item in arguments])
    engine = next((item for item in settings if item.startswith("engine=")), None)
    if engine is None:
        engine = tomllib.loads((SCENARIOS / scenario).read_text())["engine"]
    return EventLog(log), made, pathlib.PurePosixPath(engine.split("=")[-1].strip('"')).name


def input_names(signature):
    """By channel."""
    text = (ROOT / "hal" / "signals.toml").read_bytes()
    if zlib.crc32(text) != signature:
        raise SystemExit("the program was built with another signal table: build sixdeg first")
    return [row["name"] for row in tomllib.loads(text.decode())["input"]]


def run_file(name, log, made, engine):
    names = input_names(log.signature)
    _, _, tune, extra, first_tick = RUNS[name]
    lines = ["# SPDX-License-Identifier: MIT", "# Made by tests/golden/make_runs.py: " + made, f"engine {engine}"]
    lines += [f"tune {key} {value}" for key, value in tune.items()]
    letters = [chr(ord("A") + i) for i in range(len(names))]
    seen = sorted(set(log.channel[(log.kind == SAMPLE) & ~log.out].tolist()))
    lines += [f"input {letters[i]} {names[i]}" for i in seen] + ["events"]
    waiting, last, offset = list(extra), 0, first_tick
    ticks = [int(t * log.tick_hz + 0.5) for t in log.time_s]
    for i in (~log.out).nonzero()[0]:
        while waiting and log.time_s[i] >= waiting[0][0]:
            lines.append(f"{waiting.pop(0)[1]}")  # no time of its own: that of the event before
        tick, kind = ticks[i] + offset, int(log.kind[i])
        step = "" if tick == last else str(tick - last)
        if kind == SAMPLE:
            lines.append(f"{letters[log.channel[i]]}{step} {str(log.value[i:i + 1].view('<f4')[0])}")
        else:
            lines.append(LETTER[kind] + step)
        last = tick
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("name", nargs="*", help="all without one")
    for name in parser.parse_args().name or RUNS:
        with tempfile.TemporaryDirectory() as folder:
            text = run_file(name, *record(name, pathlib.Path(folder)))
        (HERE / f"{name}.run").write_text(text)
        print(f"{name}: {len(text)} bytes, {text.count(chr(10))} lines")


if __name__ == "__main__":
    main()
