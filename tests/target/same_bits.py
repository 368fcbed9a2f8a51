#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The golden runs on every processor, one hash of all outputs each (docs/start/porting.md).

    tests/target/same_bits.py                     every golden run once, on every processor
    tests/target/same_bits.py --teeth 1000000     again and again with crank edges moved by up to a tick, until each ecu has had so many
    tests/target/same_bits.py --run q31 --on powerpc --on armel
    tests/target/same_bits.py --teeth 1000000 --ecu sd_ecu_fixed     of one ecu only

Builds what is missing. powerpc and armel take their compilers and the user-mode emulator: tools/setup --foreign. Ends with 1 when a
processor says anything else than this machine.
"""
import argparse
import pathlib
import random
import shutil
import struct
import subprocess
import sys
import tempfile

from other_order import other_events, other_page, page_numbers

ROOT = pathlib.Path(__file__).resolve().parents[2]
BOARDS = {"cortex-m7": "mps2-an500", "cortex-m4f": "mps2-an386", "cortex-m3": "mps2-an385"}
FOREIGN = {"armel": "qemu-arm", "powerpc": "qemu-ppc"}
CRANK_EDGE, MOST_EVENTS = 1, 120_000  # what a board has room for
RUNS = sorted(path.stem for path in (ROOT / "tests/golden").glob("*.run"))
ECUS = {"sd_ecu": "budget_ecu", "sd_ecu_fixed": "budget_ecu_fixed"}  # their images on a board
FIXED = ("fixed", "q31", "faults", "folsmo_q31", "twist")  # runs for the ecu of fixed point too; the first it can take whole


def build(processors):
    wanted = {"host": ["budget_input", "hash_sd_ecu", "hash_sd_ecu_fixed"]}
    for name in processors:
        wanted[name] = list(ECUS.values()) if name in BOARDS else ["hash_sd_ecu", "hash_sd_ecu_fixed"]
    for preset, targets in wanted.items():
        done = subprocess.run([ROOT / "tools/build", preset, *targets], capture_output=True, text=True)
        if done.returncode != 0:
            raise SystemExit(done.stdout[-3000:] + done.stderr[-2000:])


def hash_of(text):
    return next((line.split()[1] for line in text.splitlines() if line.startswith("hash ")), f"none ({text.strip()[:80]})")


class Run:
    """Page and events of a golden run in files; turn n has its crank edges moved by up to a tick, turn 0 does not."""

    def __init__(self, name, folder, numbers):
        self.page, self.events = folder / "page", folder / "events"
        subprocess.run([ROOT / "build/host/tests/budget/budget_input", ROOT / f"tests/golden/{name}.run", self.page, self.events],
                       check=True, capture_output=True)
        self.name, self.folder, self.original = name, folder, self.events.read_bytes()
        (folder / "page.other").write_bytes(other_page(self.page.read_bytes(), numbers))
        self.teeth = sum(kind == CRANK_EDGE for _, kind, *_ in struct.iter_unpack("<IHHII", self.original[16:]))
        if len(self.original) // 16 > MOST_EVENTS:
            raise SystemExit(f"{name}: more events than a board holds")

    def turn(self, number):
        draw = random.Random(f"{self.name} {number}")
        moved = [(e[0] + draw.randint(-1, 1) & 0xffffffff, *e[1:]) if number and e[1] == CRANK_EDGE else e
                 for e in struct.iter_unpack("<IHHII", self.original[16:])]
        data = self.original[:16] + b"".join(struct.pack("<IHHII", *e) for e in moved)
        self.events.write_bytes(data)
        (self.folder / "events.other").write_bytes(other_events(data))

    def on_host(self, ecu):
        return self.said([ROOT / f"build/host/hash_{ecu}", self.page, self.events])

    def on(self, processor, ecu):
        if processor in BOARDS:
            return self.said(["qemu-system-arm", "-M", BOARDS[processor], "-display", "none", "-monitor", "none", "-serial", "none",
                              "-semihosting-config", "enable=on,target=native", "-kernel",
                              ROOT / f"build/{processor}/tests/budget/target/{ECUS[ecu]}",
                              "-device", f"loader,file={self.page},addr=0x200000,force-raw=on",
                              "-device", f"loader,file={self.events},addr=0x20200000,force-raw=on"])
        end = ".other" if processor == "powerpc" else ""
        return self.said([FOREIGN[processor], ROOT / f"build/{processor}/hash_{ecu}", f"{self.page}{end}", f"{self.events}{end}"])

    @staticmethod
    def said(words):
        done = subprocess.run(words, capture_output=True, text=True)
        return hash_of(done.stdout + done.stderr)


def compare(run, processors, turn, ecus):
    """Prints a line for each of these ecus; returns those that say something else, as "PROCESSOR ECU"."""
    run.turn(turn)
    wrong = []
    for ecu in ecus:
        here = run.on_host(ecu)
        differ = [name for name in processors if here.startswith("none") or run.on(name, ecu) != here]
        same = [name for name in processors if name not in differ]
        differs = f"; NOT on {', '.join(differ)}" if differ else ""
        print(f"{run.name:11} {ecu:12} {run.teeth:6} teeth  {here}  the same on {', '.join(same) or 'none'}{differs}", flush=True)
        wrong += [f"{name} {ecu}" for name in differ]
    return wrong


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--run", action="append", choices=RUNS, help="of these golden runs only; may be given again")
    parser.add_argument("--on", action="append", choices=[*BOARDS, *FOREIGN], help="on these processors only; may be given again")
    parser.add_argument("--ecu", action="append", choices=[*ECUS], help="of this ecu only")
    parser.add_argument("--teeth", type=int, default=0, metavar="N", help="go on until each ecu has had so many teeth on each processor")
    options = parser.parse_args()
    processors = options.on or [*BOARDS, *FOREIGN]
    tools = [FOREIGN[p] for p in processors if p in FOREIGN] + ["qemu-system-arm"] * any(p in BOARDS for p in processors)
    if missing := [tool for tool in tools if shutil.which(tool) is None]:
        raise SystemExit(f"same_bits: {', '.join(missing)} not installed; tools/setup --cross --foreign installs all")
    build(processors)
    numbers, wrong, turn, teeth = page_numbers(), [], 0, dict.fromkeys(options.ecu or ECUS, 0)
    with tempfile.TemporaryDirectory() as folder:
        runs = []
        for name in options.run or RUNS:
            (own := pathlib.Path(folder, name)).mkdir()
            runs.append(Run(name, own, numbers))
        while turn == 0 or any(count < options.teeth for count in teeth.values()):
            goes_on = [ecu for ecu, count in teeth.items() if turn == 0 or count < options.teeth]
            for run in runs:
                ecus = [ecu for ecu in goes_on if ecu == "sd_ecu" or run.name in FIXED]
                wrong += compare(run, processors, turn, ecus) if ecus else []
                for ecu in ecus:
                    teeth[ecu] += run.teeth
            if not any(teeth[ecu] for ecu in goes_on):
                break  # none of the runs is for this ecu
            turn += 1
    print(" and ".join(f"{count} teeth by {ecu}" for ecu, count in teeth.items()) + f", on {', '.join(processors)}: "
          + ("NOT the same bits" if wrong else "the same bits as on this machine"), flush=True)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
