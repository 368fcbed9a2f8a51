#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Of a linked image: the stack that sd_ecu_init, sd_ecu_run and sd_ecu_task_run can take at most; no recursion, no heap, no loop without a
bound.

    tests/proof/stack.py build/cortex-m7/tests/budget/target/budget_ecu [--json]

The call graph is read from the machine code, the C library's functions included: every call, every jump into another function, and what
each function pushes and subtracts from the stack pointer, all of it as if it were taken at once. A call through a pointer goes out of
the ecu (to the port) or is one of INDIRECT below; its stack is the port's and comes on top. Loops that are no counted `for` stand in
LOOPS with the bound of each; one that is not there fails.
"""
import collections
import json
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
ROOTS = {"sd_ecu_init": 2048, "sd_ecu_run": 2048, "sd_ecu_task_run": 1024}  # bytes at most
MAY_LACK = "sd_ecu_task_run"  # an image whose port puts nothing off
HEAP = {"malloc", "free", "calloc", "realloc", "_sbrk", "sbrk", "_malloc_r", "_free_r", "alloca"}
LINE = re.compile(r"^\s*([0-9a-f]+):\t([a-z][a-z0-9.]*)(?:\t(.*?))?\s*(?:[@;].*)?$")
HEAD = re.compile(r"^([0-9a-f]+) <(\S+)>:$")
TARGET = re.compile(r"\b([0-9a-f]+) <([^>+]+)>")
# Functions that call through a pointer: whom.
INDIRECT = {"sd_ecu_run": "port->receive", "sd_ecu_parameter": "port->send", "sd_publish_part": "port->send", "on_task": "port->send"}
# Loops that are no `for` of a counter: how often at most.
LOOPS = {
    "firmware/afr/sd_exhaust.inc: while (then < whole)": "a delay is at most 62 positions and a cycle has 24 or more: 3 times",
    "firmware/afr/sd_afr_point.inc: while ((at + 2u < count)": "count: 4 at most",
    "firmware/ecu_fixed/sd_fixed_cycle.c: while (all && (self->work.piece": "each time a piece less: as many as the list has",
    "firmware/ecu/sd_ecu_cycle.c: while (all && (self->work.piece": "each time a piece less: as many as the list has",
    "firmware/ecu/sd_publish.c: do": "as many as a row has signals, and as many as it has parts",
    "firmware/ecu/sd_publish.c: while (--left > 0u)": "the same loop's end",
    "firmware/ecu/sd_ecu_events.c: while ((self->ready != 0u)": "as many events as the port hands over: the port bounds it",
    "firmware/crank/sd_crank_memory.c: while ((m + 1u < self->mark_count)": "the wheel's marks: SD_CRANK_MARKS_MAX",
    "firmware/crank/sd_crank_memory.c: while (clear == 0u)": "as many marks as follow one another by a single tooth: SD_CRANK_MARKS_MAX",
    "firmware/airpath/sd_airpath_q31.c: while ((d > INT32_MAX)": "halves of a number of 64 bits: 33",
    "firmware/torque/sd_fourier.inc: for (uint32_t left = self->harmonics; ; c += 2)": "harmonics: 12 at most",
    "firmware/torque/sd_motion.c: while ((x > 0.5f)": "10 at most",
    "firmware/torque/sd_kalman_firing.h: while ((at + 1u < t->speeds)": "speeds of the page, a number of 8 bits",
}


def registers(operands):
    """How many words a list such as {r4-r6, lr} takes."""
    words = 0
    for part in re.search(r"\{(.*)\}", operands)[1].replace(" ", "").split(","):
        names = {"sb": "r9", "sl": "r10", "fp": "r11", "ip": "r12"}
        ends = [int(names.get(end, end)[1:]) if names.get(end, end)[1:].isdigit() else None for end in part.split("-")]
        words += (ends[1] - ends[0] + 1 if len(ends) == 2 else 1) * (2 if part.startswith("d") else 1)
    return words


class Function:
    def __init__(self):
        self.own, self.calls, self.pointers, self.variable = 0, set(), 0, None

    def take(self, name, mnemonic, operands):
        """Adds what one instruction does to stack and graph."""
        base = mnemonic.split(".")[0]
        if base in ("push", "vpush") or (base in ("stmdb", "vstmdb") and operands.startswith("sp!")):
            self.own += 4 * registers(operands)
        elif (m := re.match(r"sp(?:, sp)?, #(\d+)$", operands)) and base in ("sub", "subw"):
            self.own += int(m[1])
        elif m := re.search(r"\[sp, #-(\d+)\]!", operands):
            self.own += int(m[1])
        elif operands.startswith("sp,") and base in ("sub", "mov", "bic"):
            self.variable = f"{mnemonic} {operands}"
        target = TARGET.search(operands)
        if target and base.startswith(("b", "cb")) and target[2] != name:
            self.calls.add(target[2])
        elif base == "blx" or (base == "bx" and operands != "lr"):
            self.pointers += 1


def read(image):
    functions, name = collections.defaultdict(Function), None
    text = subprocess.run(["arm-none-eabi-objdump", "-d", "--no-show-raw-insn", image], capture_output=True, text=True, check=True).stdout
    for line in text.splitlines():
        if head := HEAD.match(line):
            name = head[2]
        elif name and (m := LINE.match(line)):
            functions[name].take(name, m[2], m[3] or "")
    return functions


def deepest(functions, name, path=()):
    """(bytes, the way there) from a function on; ends the program where a function calls itself."""
    if name in path:
        raise SystemExit("stack: recursion: " + " > ".join(path[path.index(name):] + (name,)))
    below = max((deepest(functions, called, path + (name,)) for called in functions[name].calls), default=(0, ()))
    return functions[name].own + below[0], (name,) + below[1]


def reached(functions, name, found=None):
    found = set() if found is None else found
    if name not in found:
        found.add(name)
        for called in functions[name].calls:
            reached(functions, called, found)
    return found


def loops():
    """Loops of the firmware that are not counted and not in LOOPS; and what is in LOOPS and nowhere else."""
    found, wrong = set(), []
    for path in sorted((ROOT / "firmware").rglob("*.[chi]*")):
        for line in path.read_text().splitlines():
            code = line.split("/*")[0].split("///")[0]
            if re.search(r"\bgoto\b", code):
                wrong.append(f"{path.relative_to(ROOT)}: {line.strip()}")
            if not re.search(r"\bwhile \(|\bfor \([^;]*; *;|\bdo \{", code):
                continue
            known = [key for key in LOOPS if key.startswith(f"{path.relative_to(ROOT)}: ") and key.split(": ", 1)[1] in code]
            found.update(known)
            if not known:
                wrong.append(f"{path.relative_to(ROOT)}: {line.strip()}: a loop whose bound nobody has stated")
    return wrong + [f"{key}: is not there any more" for key in LOOPS if key not in found]


def look(image):
    """Bounds by root, and what is wrong."""
    functions, bounds, wrong = read(image), {}, []
    for root, most in ROOTS.items():
        if root == MAY_LACK and root not in functions:
            continue
        bounds[root] = deepest(functions, root)
        if bounds[root][0] > most or bounds[root][0] == 0:
            wrong.append(f"{root}: {bounds[root][0]} bytes of stack, {most} at most: {' > '.join(bounds[root][1])}")
        for name in sorted(reached(functions, root)):
            if name in HEAP:
                wrong.append(f"{root} reaches {name}")
            if functions[name].variable:
                wrong.append(f"{name} moves the stack pointer by a variable: {functions[name].variable}")
            if functions[name].pointers and name.split(".")[0] not in INDIRECT:
                wrong.append(f"{root} reaches {name}, which calls through a pointer and is not in INDIRECT")
    return bounds, wrong


if __name__ == "__main__":
    stack_bounds, faults = look(sys.argv[1])
    faults += loops()
    if "--json" in sys.argv:
        print(json.dumps({name: {"bytes": size, "way": way} for name, (size, way) in stack_bounds.items()}))
    else:
        for root_name, (size, way) in stack_bounds.items():
            print(f"{root_name}: {size} bytes at most, by {' > '.join(way)}")
    print("\n".join(faults), file=sys.stderr, end="\n" if faults else "")
    sys.exit(1 if faults else 0)
