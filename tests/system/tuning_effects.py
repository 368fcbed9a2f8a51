#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""What each change of docs/start/tuning.md does, run anew with the default and with the change:

  build/venv/bin/python tests/system/tuning_effects.py [WORD...]      all, or those whose change holds one of the words; 15 s of one core

Prints the words that the page should have; exit status 1 where the page says something else."""
import json
import os
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools/report"))
from airpath_folder import AirPathRun  # noqa: E402

PAGE = ROOT / "docs/start/tuning.md"
SIXDEG = os.environ.get("SIXDEG", str(ROOT / "build/host/sixdeg"))
MISFIRES = ("harmonics_1500rpm_2bar", "misfires.one_in=20", "cyclic.cov_percent=5", "run.cycles=400")
ROUGH = (*MISFIRES, "speed.rpm=5000", "load.bmep_bar=1", "load.road_rms_nm=60")
JITTER = ("balance_1000rpm_5bar", "encoder.jitter_deg=0.05")
STEP = ("trajectory_1500rpm_9bar", "run.duration_s=5")
FIGURE_16 = ("figure16_1500rpm_9bar", "run.duration_s=44")


def run(base, *changes):
    """The summary of a run, and what the air path's faults came to."""
    scenario, *sets = base
    words = [word for one in (*sets, *changes) for word in ("--set", one)]
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([SIXDEG, "run", ROOT / f"host_sim/data/scenarios/{scenario}.toml", "--nominal", "--out", folder, *words],
                       check=True, capture_output=True)
        summary = json.loads((pathlib.Path(folder) / "summary.json").read_text())
        if scenario.startswith("airpath"):
            summary["delays"] = [row[3] for row in AirPathRun(folder).figures()]
    return summary


def rate(of):
    return f"{of['hits']} of {of['of']}"


def alarms(s):
    return f"{rate(s['misfire']['false_alarms'])} false alarms, {rate(s['misfire']['detected'])} misfires found"


def partial(s):
    return f"{rate(s['misfire']['partial_found'])} found as partial burns"


def mixture(s):
    return f"error {s['afr']['rms_points']:.2f} %"


def trims(s):
    return f"within 3 % after {s['balance']['cycles_to_3_percent']:.0f} cycles, {s['balance']['residual_percent']:.2f} % at the end"


EFFECTS = (  # (base, changes, what is said of a summary)
    (JITTER, ("firing.edge_sd=0.05", "torque.edge_sd=0.05"),
     lambda s: f"single firing {s['firing']['single_percent']:.2f} %, imbalance {s['firing']['imbalance_percent']:.2f} %"),
    ((*STEP, "uego.noise_per_rthz=5e-4"), ("afr.sensor_noise=5e-4",),
     lambda s: f"{mixture(s)}, wrong cylinder {s['afr']['wrong_cylinder_percent']:.0f} %"),
    (ROUGH, ("firing.load_walk=0.3",), alarms),
    ((*MISFIRES, "misfires.burned_fraction=0.55"), ("misfire.misfire_below=0.6",), partial),
    ((*MISFIRES, "misfires.burned_fraction=0.85"), ("misfire.partial_burn_below=0.9",), partial),
    (MISFIRES, ("misfire.start_inhibit_cycles=0",), lambda s: f"{s['misfire']['not_judged']} firings not judged"),
    (MISFIRES, ("misfire.method=1",), lambda s: f"{s['misfire']['separation']:.1f} deviations apart"),
    (STEP, ("afr.cylinder_drift=0.002",), mixture),
    (STEP, ("afr.cylinder_drift=0.02",), mixture),
    (STEP, ("afr.cylinder_jump=0",), mixture),
    (FIGURE_16, ("balance.integral_gain=0.5", "balance.trim_rate=0.1"), trims),
    (FIGURE_16, ("balance.integral_gain=0.1",), trims),
    (("trajectory_1500rpm_9bar",), ("afr.method=3",), mixture),
    (("fuel_step_5bar",), ("firing.torque_change=2",),
     lambda s: f"imbalance {s['firing']['imbalance_percent']:.2f} %, waveform {s['firing']['waveform_rms_percent']:.2f} %"),
    (("airpath_section7",), ("airpath.detect_threshold=5", "airpath.isolate_threshold=5"), lambda s: f"after {' and '.join(s['delays'])}"),
    (("airpath_section7",), ("airpath.detect_threshold=60", "airpath.isolate_threshold=60"),
     lambda s: f"after {' and '.join(s['delays'])}"),
    (("shuffle", "run.duration_s=10"), ("driveline.damping=1",), lambda s: f"asks for up to {s['driveline']['largest_request_nm']:.0f} Nm"),
)


def main():
    page, other, before = PAGE.read_text(), 0, {}
    for base, changes, said in EFFECTS:
        name = ", ".join(changes)
        if sys.argv[1:] and not any(word in name for word in sys.argv[1:]):
            continue
        if (base, said) not in before:
            before[base, said] = said(run(base))
        words = f"{before[base, said]} -> {said(run(base, *changes))}"
        there = words in page
        other += not there
        print(f"{'     ' if there else 'OTHER'} {name}: {words}", flush=True)
    return 1 if other else 0


if __name__ == "__main__":
    sys.exit(main())
