#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""What a step of each AFR block costs: instructions and floating-point operations, counted from what the program executes
(callgrind's count of each instruction, objdump's name of it), never timed. Prints the table of docs/results/afr.md.

    test_afr_cost.py AFR_PROBE ENGINE.toml
"""
import collections
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

PROBE, ENGINE = sys.argv[1:3]
STEPS = ["sd_exhaust_step_f32", "sd_exhaust_step_q31", "sd_afr_chain_step_f32", "sd_afr_chain_step_q31", "sd_afr_joint_step"]
FLOP = re.compile(r"(add|sub|mul|div|sqrt)(ss|ps)$")
TABLE_2_US = {"A": "2.70", "BC": "6.70 and < 0.05", "D": "6.35"}  # document 004
ROWS = {"A": "A, observer", "BC": "B and C, manifold and delay", "D": "D, sensor inverted", "wiring": "wiring", "sum": "all"}
# Instructions and flop a step as of docs/results/afr.md; a block may take GROWTH more.
GROWTH = 1.1
BUDGET = {("fourier", "f32"): {"A": (64, 13), "BC": (320, 56), "D": (139, 63), "wiring": (22, 0)},
          ("oscillator", "f32"): {"D": (139, 63)},
          ("fourier", "q31"): {"A": (152, 0), "BC": (497, 0), "D": (313, 0), "wiring": (23, 0)},
          ("oscillator", "q31"): {"D": (349, 0)},
          ("joint", "f32"): {"wiring": (304, 101)},
          ("joint_fixed", "f32"): {"wiring": (112, 39)}}


def run(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def mnemonics():
    """Of each address of the program."""
    lines = re.findall(r"^ +([0-9a-f]+):\t(\S+)", run("objdump", "-d", "--no-show-raw-insn", PROBE), re.M)
    return {int(address, 16): name for address, name in lines}


def executed(arguments):
    """How often each address was executed within the steps, and how often each step was called."""
    with tempfile.NamedTemporaryFile() as out:
        run("valgrind", "--tool=callgrind", f"--callgrind-out-file={out.name}", "--dump-instr=yes", "--compress-pos=no",
            "--compress-strings=no", *(f"--toggle-collect={step}" for step in STEPS), PROBE, *arguments)
        text = pathlib.Path(out.name).read_text()
    count, calls, callee, of_call = collections.Counter(), collections.Counter(), "", False
    for line in text.splitlines():
        if line.startswith("cfn="):
            callee = line[4:]
        elif line.startswith("calls="):
            calls[callee] += int(line[6:].split()[0])
            of_call = True  # the next line is what the callee cost
        elif line.startswith("0x"):
            address, _, cost = line.split()[:3]
            if not of_call:
                count[int(address, 16)] += int(cost)
            of_call = False
    return count, calls


def functions(addresses):
    """Of each address: the function and those inlined into it, innermost first."""
    text = run("addr2line", "-afi", "-e", PROBE, *(hex(a) for a in addresses))
    stacks, stack = {}, None
    for line in text.splitlines():
        if line.startswith("0x"):
            stack = stacks.setdefault(int(line, 16), [])
        elif "/" not in line and not line.startswith("??"):
            stack.append(line)
    return stacks


def block(stack):
    """B with C, which share a pass over the cylinders, D, A, or what stands on them: the joint filter, or the chain's wiring."""
    outer = stack[-1]
    if outer.startswith("sd_exhaust_step"):
        return "BC"
    return {"sd_uego": "D", "sd_afr_observer": "A"}.get(re.sub(r"_step.*", "", outer), "wiring")


def measured(method, number):
    """{block: (instructions, flop)} a step, "sum" of all."""
    count, calls = executed([method, ENGINE] + (["q31"] if number == "q31" else []))
    names, stacks, cost = mnemonics(), functions(count), collections.defaultdict(lambda: [0.0, 0.0])
    exhaust_steps = calls[f"sd_exhaust_step_{number}"]
    steps = calls["sd_afr_joint_step"] or calls[f"sd_afr_chain_step_{number}"]
    assert steps and exhaust_steps >= steps, calls
    for address, times in count.items():
        which = block(stacks[address]) if stacks.get(address) else "wiring"  # a call to the C library
        each = times / (exhaust_steps if which == "BC" else steps)
        operation = FLOP.match(names.get(address, ""))
        flop = each * (4 if operation[2] == "ps" else 1) if operation else 0.0
        for key in (which, "sum"):
            cost[key][0] += each
            cost[key][1] += flop
    return {which: (round(value[0]), round(value[1])) for which, value in cost.items()}


def table(cost, size):
    def cell(key, which):
        instructions, flop = cost[key][which]
        return f"{instructions}, {flop}" if key[1] == "f32" else f"{instructions}"

    yield "| block | f32: instructions, flop, state | q31: instructions, state | Table 2, us |"
    yield "|---|---|---|---|"
    step = {"A": "sd_afr_observer_step_", "BC": "sd_exhaust_step_", "D": "sd_uego_step_"}
    for method, name in (("fourier", "Fourier law"), ("oscillator", "oscillators")):
        for which in ("A", "BC", "D") if method == "fourier" else ("D",):
            bytes_of = [f"{size[step[which] + n]} B" for n in ("f32", "q31")]
            yield (f"| {ROWS[which]}{', ' + name if which == 'D' else ''} | {cell((method, 'f32'), which)}, {bytes_of[0]} | "
                   f"{cell((method, 'q31'), which)}, {bytes_of[1]} | {TABLE_2_US[which]} |")
        whole = [size["sd_exhaust_step_" + n] + size["sd_afr_chain_step_" + n] for n in ("f32", "q31")]
        yield (f"| chain, {name} | {cell((method, 'f32'), 'sum')}, {whole[0]} B | {cell((method, 'q31'), 'sum')}, {whole[1]} B | 15.8 |")
    for method, name in (("joint", "joint filter, Riccati"), ("joint_fixed", "joint filter, fixed gains")):
        yield f"| {name} | {cell((method, 'f32'), 'wiring')}, {size['sd_afr_joint_step']} B | | |"
        whole = size["sd_exhaust_step_f32"] + size["sd_afr_joint_step"]
        yield f"| with B and C | {cell((method, 'f32'), 'sum')}, {whole} B | | |"


class Cost(unittest.TestCase):
    def test_no_block_costs_more_than_its_budget(self):
        cost = {(method, number): measured(method, number) for method, number in BUDGET}
        size = {name: int(bytes_) for name, bytes_ in (line.split() for line in run(PROBE).splitlines())}
        print("\n".join(table(cost, size)))
        for key, budget in BUDGET.items():
            for which, allowed in budget.items():
                for spent, most, unit in zip(cost[key][which], allowed, ("instructions", "flop")):
                    self.assertLessEqual(spent, GROWTH * most, f"{key} {which}: {unit}")
                    self.assertGreater(spent, 0.5 * most - 1, f"{key} {which}: {unit}; or is it not counted any more?")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
