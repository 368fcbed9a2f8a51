#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""docs/results/costs.md: what the firmware costs on the controllers of IMAGES below, from figures that are kept in costs.toml.

    tests/budget/costs.py                     writes docs/results/costs.md from the kept figures
    tests/budget/costs.py --measure           builds, runs every run on every image (some minutes), keeps the figures, writes the page
    tests/budget/costs.py --check             ends with 1 when the page is not of the kept figures, or a measured one is 2 % off
    tests/budget/costs.py --check --quick     the same of a few runs; of all with SD_FULL=1

The compiler is pinned, since another one makes other instructions.
"""

import argparse
import collections
import json
import os
import pathlib
import re
import subprocess
import sys
import tomllib

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import budget  # noqa: E402  the path comes first
import costs_page  # noqa: E402
sys.path.insert(0, str(budget.ROOT / "tools"))
import progress  # noqa: E402

KEPT = budget.HERE / "costs.toml"
PAGE = budget.ROOT / "docs" / "results" / "costs.md"
COMPILER = "12.2.1 20221205"  # gcc-arm-none-eabi 15:12.2.rel1-1, Debian 12's
RUNS = [
    "smooth",
    "restart",
    "faults",
    "fuel_cut",
    "tip_in",
    "misfires",
    "folsmo",
    "folsmo_q31",
    "q31",
    "chain",
    "fixed",
    "twist",
    "eight_lambda",
    "eight_6000",
    "dual_mass",
    "single",
]
ALONE = ["blocks", "peers"]
PLAN = {
    "cortex-m7": RUNS + ALONE,
    "cortex-m4f": RUNS + ALONE,
    "cortex-m3-fixed": ["fixed", "faults", "restart", "folsmo_q31", "twist"],
    "cortex-m3": ["smooth", "blocks", "peers"],
}
QUICK = {"cortex-m4f": ["twist", "blocks", "peers"]}  # the other core with kept figures of its own is budget.py's
STATES = {
    "sd_crank": ["sd_crank_t"],
    "sd_fourier": ["sd_fourier_f32_t", "sd_fourier_q31_t"],
    "sd_kalman": ["sd_kalman_t"],
    "sd_firings": ["sd_firings_t"],
    "sd_misfire": ["sd_misfire_t"],
    "sd_switched_wheel": ["sd_wheel_f32_t", "sd_wheel_q31_t"],
    "sd_exhaust": ["sd_exhaust_f32_t", "sd_exhaust_q31_t"],
    "sd_afr_chain": ["sd_afr_chain_f32_t", "sd_afr_chain_q31_t"],
    "sd_afr_joint": ["sd_afr_joint_t"],
    "sd_afr": ["sd_afr_t"],
    "sd_balance": ["sd_balance_t"],
    "sd_driveline_guard": ["sd_driveline_guard_f32_t", "sd_driveline_guard_q31_t"],
    "sd_driveline_hybrid": ["sd_driveline_hybrid_t"],
    "sd_airpath_bank": ["sd_airpath_bank_f32_t", "sd_airpath_bank_q31_t"],
    "sd_ecu": ["sd_ecu_t"],
}


def compiler():
    said = subprocess.run(["arm-none-eabi-gcc", "--version"], capture_output=True, text=True, check=True).stdout.splitlines()[0]
    return None if COMPILER in said else f"costs: the figures are of arm-none-eabi-gcc {COMPILER}; this one says: {said}"


def row(counts):
    """Events; mean and worst instructions, cycles at the slow end of the model and at its quick one."""
    events = sum(count.events for count in counts)
    return [
        events,
        round(sum(c.total for c in counts) / events),
        max(c.most for c in counts),
        round(sum(c.slow for c in counts) / events),
        max(c.most_slow for c in counts),
        round(sum(c.quick for c in counts) / events),
        max(c.most_quick for c in counts),
    ]


def of_run(run):
    """Figures of a run: every class of event as a whole, groups over placed teeth, and of blocks each function by its class."""
    figures = {}
    if run.name in budget.ALONE:
        wanted = {
            f"sd_{f}"
            for f in (
                "crank_edge",
                "fourier_step_f32",
                "fourier_step_q31",
                "wheel_tooth_f32",
                "wheel_tooth_q31",
                "wheel_judge_f32",
                "wheel_judge_q31",
                "exhaust_step_f32",
                "exhaust_step_q31",
                "afr_chain_step_f32",
                "afr_chain_step_q31",
                "uego_step_f32",
                "uego_step_q31",
                "afr_observer_step_f32",
                "afr_observer_step_q31",
                "afr_joint_step",
                "driveline_guard_step_f32",
                "driveline_guard_step_q31",
                "driveline_hybrid_step",
                "airpath_step_f32",
                "airpath_step_q31",
            )
        }
        for (name, event_class), count in sorted(run.counts.items()):
            if event_class != "other" and (name in wanted or name.startswith("peer_")):
                figures[f"{event_class}.{name}"] = row([count])
        return figures
    settled, placed = budget.PLAN["settled"], budget.PLAN["placed"]
    for event_class in budget.PLAN["classes"]:
        if ("event", event_class) in run.counts and event_class not in ("setup", "other"):
            figures[event_class] = row([run.counts["event", event_class]])
    if ("task", "clock") in run.counts:
        figures["task"] = row([run.counts["task", "clock"]])
    groups = [name for name in budget.PLAN["groups"] if name not in ("event", "task")]
    for name in ["event"] + groups:
        of = {c: run.counts[name, c] for c in placed if (name, c) in run.counts}
        if any(c in settled for c in of):
            mean, most = row([of[c] for c in of if c in settled]), row(list(of.values()))
            figures["tooth" if name == "event" else f"part.{name}"] = [mean[0], mean[1], most[2], mean[3], most[4], mean[5], most[6]]
    figures["stack"] = [run.said["stack_init"], run.said["stack_run"]]
    return figures


def sizes(core):
    """.text, .rodata and .data of each library, bytes; of each block's state; of the image."""
    folder, found = budget.ROOT / "build" / core / "firmware", {}
    for library in sorted(folder.glob("*/libsd_*.a")):
        if library.parent.name == ("ecu" if core.endswith("-fixed") else "ecu_fixed"):
            continue
        total = collections.Counter()
        text = subprocess.run(["arm-none-eabi-size", "-A", library], capture_output=True, text=True, check=True).stdout
        for name, size in re.findall(r"^\.(text|rodata|data|bss)\S*\s+(\d+)", text, re.M):
            total[name] += int(size)
        found[f"library.{library.stem[3:]}"] = [total["text"], total["rodata"], total["data"] + total["bss"]]
    if not core.endswith("-fixed"):
        found |= {f"state.{name}": [size] for name, size in states(core).items()}
    return found


def states(core):
    """sizeof of each block's state: the target's compiler is asked for arrays that long."""
    folder = budget.ROOT / "build" / "budget" / core
    flags = next(
        p["cacheVariables"]["SD_CPU_FLAGS"]
        for p in json.loads((budget.ROOT / "CMakePresets.json").read_text())["configurePresets"]
        if p["name"] == core
    ).split()
    lines = [f'#include "{header}.h"' for header in STATES] + [f"char size_of_{t}[sizeof({t})];" for of in STATES.values() for t in of]
    (folder / "states.c").write_text("\n".join(lines) + "\n")
    paths = [
        f"-I{path}"
        for part in ("firmware/*", "hal", "hal/inproc", "hal/generated")
        for path in sorted(budget.ROOT.glob(part))
        if path.is_dir() and path.name != "ecu_fixed"
    ]
    subprocess.run(
        ["arm-none-eabi-gcc", "-mthumb", *flags, "-std=c11", *paths, "-c", folder / "states.c", "-o", folder / "states.o"], check=True
    )
    text = subprocess.run(["arm-none-eabi-nm", "-S", folder / "states.o"], capture_output=True, text=True, check=True).stdout
    return {m[2]: int(m[1], 16) for m in re.finditer(r"^\S+ (\S+) \S size_of_(\w+)$", text, re.M)}


def measure(plan):
    figures, wrong = {}, []
    for core, names in plan.items():
        for name in progress.over(names, f"costs.py: {core}, run"):
            run = budget.Run(name, core)
            if not run.same:
                wrong.append(f"{core} {name}: the target says other bits than the host")
            figures |= {f"{core}.{name}.{key}": value for key, value in of_run(run).items()}
        figures |= {f"{core}.bytes.{key}": value for key, value in sizes(core).items()}
    return figures, wrong


def compare(measured, kept):
    """What is more than 2 % off, instructions, cycles and bytes alike; code as it grows is no fault, so that libraries are left out."""
    wrong = []
    for key, values in measured.items():
        if key not in kept:
            wrong.append(f"{key}: new")
        elif ".library." not in key:
            for now, then in zip(values, kept[key]):
                if now > budget.MORE * then or now < budget.LESS * then:
                    wrong.append(f"{key}: {values}, kept {kept[key]}: {'MORE' if now > then else 'LESS: --measure keeps it'}")
                    break
    return wrong


def keep(figures):
    head = (
        "# SPDX-License-Identifier: MIT\n# Written by tests/budget/costs.py --measure: events; mean and worst instructions, cycles slow"
        " and quick;\n"
    )
    lines = "".join(f'"{key}" = {value}\n' for key, value in figures.items())
    KEPT.write_text(head + f'# stack of init and run; bytes of .text, .rodata, .data and .bss.\ncompiler = "{COMPILER}"\n' + lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--measure", action="store_true", help="run everything and keep the figures")
    parser.add_argument("--check", action="store_true", help="compare, write nothing")
    parser.add_argument("--quick", action="store_true", help="measure a few runs only")
    parser.add_argument("--no-build", action="store_true", help="all is built")
    arguments = parser.parse_args()
    plan, wrong = QUICK if arguments.quick and os.environ.get("SD_FULL") != "1" else PLAN, [compiler()] if compiler() else []
    if wrong and arguments.measure:
        raise SystemExit(wrong[0])
    measured = {}
    if arguments.measure or arguments.check:
        if not arguments.no_build:
            for core in plan:
                budget.build(core)
        measured, differ = measure(plan)
        wrong += differ
    if arguments.measure:
        keep(measured)
    kept = tomllib.loads(KEPT.read_text())
    kept.pop("compiler")
    page = costs_page.text(kept)
    if not arguments.check:
        PAGE.write_text(page)
        return print("\n".join(wrong)) or (1 if wrong else 0)
    wrong += compare(measured, kept)
    if page != PAGE.read_text():
        wrong.append("docs/results/costs.md is not what the kept figures say; tests/budget/costs.py writes it")
    print("\n".join(wrong) or f"costs: {len(measured)} figures are within 2 % of the kept ones, and docs/results/costs.md is of these")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
