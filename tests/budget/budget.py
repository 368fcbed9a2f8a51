#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Instructions and bytes of the firmware on an emulated core (docs/results/budget.md).

    tests/budget/budget.py                 builds, replays the golden runs on a Cortex-M7, prints the figures beside the kept ones
    tests/budget/budget.py --update        and keeps them
    tests/budget/budget.py --run smooth --functions   every function of one run, by class of tooth

Ends with 1 when a figure is more than 2 % above the kept one, or so far below that the kept one guards nothing, or when the
target says anything else than the host.
"""
import argparse
import collections
import csv
import pathlib
import shutil
import subprocess
import sys
import tomllib

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import cycles  # noqa: E402  the path comes first

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "tools"))
import progress  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[2]
HERE = pathlib.Path(__file__).resolve().parent
KEPT = HERE / "figures.toml"
PLAN = tomllib.loads((HERE / "budget.toml").read_text())
BOARD = {"cortex-m7": "mps2-an500", "cortex-m4f": "mps2-an386", "cortex-m3": "mps2-an385", "cortex-m3-fixed": "mps2-an385"}
PAGE_AT, EVENTS_AT = 0x00200000, 0x20200000  # target/board.h
MORE, LESS = 1.02, 0.98  # of the kept figure
ALONE = {"blocks": ("budget_blocks", "block_classes"), "peers": ("budget_peers", "peer_classes")}  # no run of the ecu: image, classes

Counts = collections.namedtuple("Counts", "events calls total most slow most_slow quick most_quick")


def images_of(core):
    return ["budget_ecu"] if core.endswith("-fixed") else ["budget_ecu", "budget_blocks", "budget_peers"]


def build(core):
    """The programs, where anything changed; quiet when all is well."""
    for preset, targets in (("host", ["budget_input", "budget_fixed", "budget_plugin"]), (core, images_of(core))):
        done = subprocess.run([ROOT / "tools" / "build", preset] + targets, capture_output=True, text=True)
        if done.returncode != 0:
            raise SystemExit(done.stdout[-4000:] + done.stderr[-2000:])


def words(text):
    """Lines "NAME HEX" as numbers."""
    return {name: int(value, 16) for name, value in (line.split() for line in text.splitlines() if len(line.split()) == 2)}


class Run:
    """One golden run on host and target, or blocks one at a time on the target: said (by name), sizes (by symbol) and counts
    (by group or function, and class)."""

    def __init__(self, name, core):
        self.folder = ROOT / "build" / "budget" / core
        self.folder.mkdir(parents=True, exist_ok=True)
        image, classes = ALONE.get(name, ("budget_ecu", "classes"))
        self.name, self.core = name, core
        self.image = ROOT / "build" / core / "tests/budget/target" / image
        self.sizes = self.symbols()
        loaded, host = ([], {}) if name in ALONE else self.inputs()
        target = words(self.emulate(loaded))
        self.same = host.pop("hash", None) == target.pop("hash", None)
        self.said = host | target
        if "stack_run" in self.said:
            self.said["ram"] = self.sizes["ecu"] + self.sizes.get("page", 0) + max(self.said["stack_init"], self.said["stack_run"])
        names = PLAN[classes]
        self.counts = {(row["name"], names[int(row["class"])]): Counts(*(int(row[key]) for key in Counts._fields))
                       for row in csv.DictReader(self.file("csv").open())}

    def file(self, end):
        return self.folder / f"{self.name}.{end}"

    @staticmethod
    def file_of_run(name):
        here = HERE / f"{name}.run"
        return here if here.exists() else ROOT / f"tests/golden/{name}.run"

    def inputs(self):
        """Makes page and events; returns what the emulator loads, and what the host says of them."""
        twice = PLAN["twice"].get(self.name)
        made = subprocess.run([ROOT / "build/host/tests/budget/budget_input", *(["--twice"] if twice else []),
                               self.file_of_run(twice or self.name), self.file("page"), self.file("events")],
                              capture_output=True, text=True)
        if made.returncode != 0:
            raise SystemExit(made.stderr)
        if self.core.endswith("-fixed"):  # another ecu says something else
            said = subprocess.run([ROOT / "build/host/tests/budget/budget_fixed", self.file("page"), self.file("events")],
                                  capture_output=True, text=True, check=True)
            made.stdout += said.stdout
        loaded = [f"loader,file={self.file(end)},addr={at:#x},force-raw=on" for end, at in (("page", PAGE_AT), ("events", EVENTS_AT))]
        return loaded, words(made.stdout)

    def emulate(self, loaded):
        """Runs the image; returns what it prints. The plugin writes the counts."""
        files = ",".join(f"{key}={self.file(key)}" for key in ("symbols", "groups", "cycles")) + f",out={self.file('csv')}"
        done = subprocess.run(
            ["qemu-system-arm", "-M", BOARD[self.core], "-display", "none", "-monitor", "none", "-serial", "none",
             "-semihosting-config", "enable=on,target=native", "-kernel", self.image,
             "-plugin", f"{ROOT}/build/host/tests/budget/libbudget_plugin.so,{files}"]
            + [word for device in loaded for word in ("-device", device)], capture_output=True, text=True, timeout=600)
        if done.returncode != 0:
            raise SystemExit(f"{self.name}: the target ended with {done.returncode}: {done.stdout}{done.stderr}")
        return done.stderr + done.stdout

    def symbols(self):
        """Writes what the plugin reads; returns the sizes of the image's variables, and of code and constants."""
        self.file("groups").write_text("".join(f"{group} {function}\n" for group, of in PLAN["groups"].items() for function in of))
        text = subprocess.run(["arm-none-eabi-nm", "-S", self.image], capture_output=True, text=True, check=True).stdout
        self.file("symbols").write_text(text)
        self.file("cycles").write_text(cycles.of_image(self.image, self.core))
        rows = [line.split() for line in text.splitlines()]
        rows = [row for row in rows if len(row) == 4]
        code = sum(int(row[1], 16) for row in rows if row[2] in "tTwWrR")
        return {row[3]: int(row[1], 16) for row in rows if row[2] in "bBdD"} | {"code": code}

    def figure(self, plan):
        """None: nothing of the kind has run."""
        if "of" in plan:
            return self.said.get(plan["of"], self.sizes.get(plan["of"]))
        classes = PLAN.get(plan["classes"], [plan["classes"]])
        counts = [self.counts[plan["group"], c] for c in classes if (plan["group"], c) in self.counts]
        if not counts:
            return None
        if plan.get("worst"):
            return max(count.most for count in counts)
        return round(sum(count.total for count in counts) / sum(count.events for count in counts))

    def functions(self):
        """Every group and function by class: calls an event, mean and worst of an event."""
        print(f"{'':32}" + f"{'class':>12}" + "".join(f"{head:>8}" for head in ("events", "calls", "mean", "worst")))
        for (name, event_class), count in sorted(self.counts.items()):
            cells = (count.events, f"{count.calls / count.events:.1f}", round(count.total / count.events), count.most)
            print(f"{name:32}{event_class:>12}" + "".join(f"{cell:>8}" for cell in cells))


def verdict(figure, kept):
    if figure is None:
        return "missing"
    if kept is None:
        return "new"
    if figure > MORE * kept:
        return "MORE"
    return "LESS: --update" if figure < LESS * kept else "ok"


def report(runs, kept):
    """Prints the table; returns the figures by name, and what is wrong."""
    figures, wrong = {}, [f"{run.name}: the target says other bits than the host" for run in runs.values() if not run.same]
    print(f"{'':38}{'run':>10}{'now':>10}{'kept':>10}{'goal':>8}")
    for plan in PLAN["figure"]:
        if plan["run"] not in runs:
            continue
        name, value = plan["name"], runs[plan["run"]].figure(plan)
        judged = "shown" if plan.get("shown") else verdict(value, kept.get(name))
        above = value is not None and value > plan.get("goal", value)
        figures[name] = None if plan.get("shown") else value
        cells = ["-" if cell is None else str(cell) for cell in (value, kept.get(name), plan.get("goal"))]
        print(f"{name:38}{plan['run']:>10}{cells[0]:>10}{cells[1]:>10}{cells[2]:>8}  {judged}{', above the goal' if above else ''}")
        if judged not in ("ok", "new", "shown"):
            wrong.append(f"{name}: {judged}")
    compared = [run.name for run in runs.values() if run.same and run.name not in ALONE]
    if compared:
        print("host and target say the same, to the bit, in " + ", ".join(compared))
    return figures, wrong


def keep(figures):
    lines = ["# SPDX-License-Identifier: MIT", "# Written by tests/budget/budget.py --update: instructions of an event, bytes.", ""]
    KEPT.write_text("\n".join(lines + [f'"{name}" = {value}' for name, value in figures.items() if value is not None]) + "\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--run", action="append", choices=PLAN["runs"], help="of this run only; may be given again")
    parser.add_argument("--core", default="cortex-m7", choices=BOARD, help="kept figures are the Cortex-M7's")
    parser.add_argument("--functions", action="store_true", help="print every function by class instead")
    parser.add_argument("--update", action="store_true", help="keep the figures as they are now")
    parser.add_argument("--no-build", action="store_true", help="all is built")
    arguments = parser.parse_args()
    if not all(map(shutil.which, ("qemu-system-arm", "arm-none-eabi-gcc"))):
        raise SystemExit("budget: needs the Arm compiler and the emulator; tools/setup --cross installs them")
    if not arguments.no_build:
        build(arguments.core)
    runs = {name: Run(name, arguments.core) for name in progress.over(arguments.run or PLAN["runs"], "budget.py: run")}
    if arguments.functions:
        for run in runs.values():
            run.functions()
        return 0
    kept = tomllib.loads(KEPT.read_text()) if KEPT.exists() else {}
    if arguments.core != "cortex-m7":  # kept figures and goals are its
        kept = {}
        for plan in PLAN["figure"]:
            plan.pop("goal", None)
    figures, wrong = report(runs, kept)
    if arguments.update and arguments.core == "cortex-m7":
        keep(kept | figures)
        return 0
    for line in wrong:
        print(line)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
