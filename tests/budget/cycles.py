#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""A model of what an instruction takes on a Cortex-M4F or M3, in cycles, from the tables of Arm's reference manuals
(docs/results/costs.md).

    tests/budget/cycles.py IMAGE [cortex-m3]     one line an instruction: address, slow, more when it branches, quick, more

Memory answers at once (flash wait states and caches are the board's). Where sources have a range, its slow end and its quick end are kept.
What is not found in the table has 0, with which the plugin ends when it is executed. Sources, each checked on 28 November 2026:

- integers: Arm 100166, section 3.3.1, table 3-1 (Cortex-M4), and DDI 0337H, table 3-1 (Cortex-M3): a taken branch 1 + P with P of 1 to 3,
  a division 2 to 12, a load 2 or 1 behind another one, N registers 1 + N.
- floating point: the same manual's table, as Texas Instruments print it in SWCU192, table 3-27. It has 2 cycles for one float to or from a
  core register; gcc's description of the pipeline (cortex-m4-fpu.md) and a measurement (compendium.i-0.nl) have 1: slow and quick end.
- pairs: "load/store timings" of the same manual, in SWCU192, section 3.5.3: an address that the instruction in front computed costs a cycle
  more, a store none of its own, a load beside the program counter perhaps one more, a jump by table 6.
- a taken branch: measured on a Cortex-M4 (compendium.i-0.nl, "Branch timing"), 2 cycles, and 3 to a wide instruction that is not aligned:
  the quick end. P = 3 everywhere is the slow end.
"""

import re
import subprocess
import sys

REFILL, QUICK_REFILL, DIVISION = 3, 1, 12  # a division takes 2 to 12, by its numbers: 12 at both ends
LINE = re.compile(r"^\s*([0-9a-f]+):\t([a-z][a-z0-9]*(?:\.[a-z0-9]+)*)(?:\t(.*?))?\s*(?:[@;].*)?$")
CONDITION = "(?:eq|ne|cs|hs|cc|lo|mi|pl|vs|vc|hi|ls|ge|lt|gt|le|al)?"
ENDING = re.compile(r"\.(?:n|w|f32|f64|s32|u32|s16|u16|s8|u8|8|16|32|64)")
PLAIN = (
    "adc add addw adr and asr bfc bfi bic cmn cmp clz eor lsl lsr mov movt movw mvn neg orn orr pkhbt pkhtb qadd qsub qdadd qdsub rbit"
    " rev rev16 revsh ror rrx rsb sbc sbfx sel ssat usat sub subw sxtb sxth sxtab sxtah sadd16 ssub16 teq tst ubfx uxtb uxth uxtab uxtah"
    " nop smuad smulbb smulbt smultb smultt smulwb smulwt smmul smmulr mul cpsie cpsid uadd8 usub8"
).split()
MULTIPLY = {
    "mla": (1, 2), "mls": (1, 2), "smmla": (1, 2), "smmlar": (1, 2), "smlabb": (1, 2), "smlad": (1, 2), "smull": (1, 5),
    "umull": (1, 5), "smlal": (1, 7), "umlal": (1, 7), "umaal": (1, 7), "smlalbb": (1, 7), "smlald": (1, 7),
}  # M4, M3's longest
UNCHANGING = {"cmp", "cmn", "tst", "teq", "nop", "cpsie", "cpsid"}  # no result
M3_SHORTEST = {"smull": 3, "umull": 3, "smlal": 4, "umlal": 4}
FLOATING = {
    "vadd": 1, "vsub": 1, "vmul": 1, "vnmul": 1, "vabs": 1, "vneg": 1, "vcmp": 1, "vcmpe": 1, "vcvt": 1, "vcvtr": 1, "vmrs": 1,
    "vmsr": 1, "vmov": 1, "vdiv": 14, "vsqrt": 14, "vldr": 2, "vstr": 2, "vmla": 3, "vmls": 3, "vnmla": 3, "vnmls": 3, "vfma": 3,
    "vfms": 3, "vfnma": 3, "vfnms": 3, "vsel": 1, "vmaxnm": 1, "vminnm": 1, "vrinta": 1, "vrintz": 1,
}
LATE = {"vadd", "vsub", "vmul", "vnmul", "vcvt", "vabs", "vneg"}  # a result that the next instruction wants takes a cycle more
BRANCH = re.compile(rf"^(b|bl|blx|bx)({CONDITION})$")
LOAD, STORE = re.compile(r"^ldr(?:s?[bh])?$"), re.compile(r"^str[bh]?$")


def registers(operands):
    """How many registers a list such as {r4-r6, lr} has."""
    count = 0
    for part in re.search(r"\{(.*)\}", operands)[1].replace(" ", "").split(","):
        ends = re.findall(r"(?:[rsd])(\d+)", part)
        count += int(ends[1]) - int(ends[0]) + 1 if "-" in part and len(ends) == 2 else 1
        if "-" in part and len(ends) != 2:  # such as r8-sl
            names = {"sl": 10, "fp": 11, "ip": 12, "sb": 9}
            count += names[part.split("-")[1]] - int(ends[0])
    return count


def base_of(mnemonic):
    """The instruction's name without width, type, condition and the S that sets flags."""
    name = ENDING.sub("", mnemonic)
    known = (
        set(PLAIN)
        | set(MULTIPLY)
        | set(FLOATING)
        | {
            "ldrd",
            "strd",
            "ldm",
            "stm",
            "ldmia",
            "stmia",
            "ldmdb",
            "stmdb",
            "push",
            "pop",
            "vpush",
            "vpop",
            "vldmia",
            "vstmia",
            "vstmdb",
            "vldmdb",
            "sdiv",
            "udiv",
            "tbb",
            "tbh",
            "cbz",
            "cbnz",
        }
    )
    for candidate in (
        name,
        re.sub(rf"{CONDITION}$", "", name, count=1),
        name[:-1] if name.endswith("s") else name,
        re.sub(rf"s{CONDITION}$", "", name, count=1),
        name[:-2],
    ):
        if candidate in known or LOAD.match(candidate) or STORE.match(candidate):
            return candidate
    return name


def cost(mnemonic, operands, before, is_m3):
    """(cycles, more when it branches) of an instruction; before: the name of the one in front of it."""
    if re.match(r"^it[te]*$", mnemonic):
        return 1, 0
    branch = BRANCH.match(ENDING.sub("", mnemonic))
    if branch:
        return 1, REFILL
    name = base_of(mnemonic)
    if name in ("cbz", "cbnz"):
        return 1, REFILL
    if name in ("tbb", "tbh"):
        return 3, REFILL
    if name in ("push", "pop", "ldm", "stm", "ldmia", "stmia", "ldmdb", "stmdb", "vpush", "vpop", "vldmia", "vstmia", "vstmdb", "vldmdb"):
        words = registers(operands) * (2 if re.search(r"\{d", operands) else 1)
        return 1 + words, REFILL if re.search(r"\bpc\b", operands) else 0
    if name in ("ldrd", "strd"):
        return 3, 0
    if LOAD.match(name):
        return (1 if before and LOAD.match(before) else 2), REFILL  # a jump by table is a load of pc
    if STORE.match(name):
        return (2 if re.search(r"\[\w+, [a-z]", operands) else 1), 0
    if name in ("sdiv", "udiv"):
        return DIVISION, 0
    if name in MULTIPLY:
        return MULTIPLY[name][1 if is_m3 else 0], 0
    if name in FLOATING:
        return (2 if name == "vmov" and operands.count(",") > 1 else FLOATING[name]), 0
    if name in PLAIN:
        return 1, REFILL if operands.startswith("pc") else 0
    if name in ("bkpt", "dsb", "isb", "udf", "svc", "msr", "mrs", "wfi", "dmb"):
        return 4, 0
    return 0, 0


def wide_and_unaligned(text):
    """Addresses of instructions of 4 bytes that do not begin at a multiple of 4: what a branch to them takes is a cycle more."""
    places = [int(match[1], 16) for match in map(LINE.match, text.splitlines()) if match]
    return {place for place, following in zip(places, places[1:]) if place % 4 == 2 and following - place == 4}


def quick_refill(mnemonic, operands, branched, wide):
    """Cycles that a taken branch adds at least. Where it goes is known of a direct one; a return may go to the worse kind."""
    if not branched or LOAD.match(mnemonic) or mnemonic.startswith("tb"):
        return branched
    target = re.match(r"(?:\w+, )?([0-9a-f]+) <", operands)
    return QUICK_REFILL + (1 if not target or int(target[1], 16) in wide else 0)


def of_image(image, core):
    """Lines "address slow more quick more" of all code of the image."""
    text = subprocess.run(["arm-none-eabi-objdump", "-d", "--no-show-raw-insn", image], capture_output=True, text=True, check=True).stdout
    lines, before, result, computed, wide = [], None, None, None, wide_and_unaligned(text)
    for line in text.splitlines():
        match = LINE.match(line)
        if not match:
            before = result = computed = None  # another function
            continue
        address, mnemonic, operands = match[1], match[2], match[3] or ""
        cycles, branched = cost(mnemonic, operands, before, core.startswith("cortex-m3"))
        if (
            cycles
            and result
            and re.search(rf"\b{result}\b", operands.split(",", 1)[-1] if not mnemonic.startswith(("vcmp", "vstr")) else operands)
        ):
            cycles += 1
        if computed and re.search(rf"\[.*\b{computed}\b", operands):
            cycles += 1
        before = base_of(mnemonic)
        quick = cycles
        if before == "vmov" and re.match(r"^(s\d+, r|s\d+, [sfil]|r\d+, s|[sfil][blpr], s)", operands) and operands.count(",") == 1:
            cycles += 0 if re.match(r"^s\d+, s\d", operands) else 1
        if LOAD.match(before) and "[pc" in operands:
            cycles += 1
        if core.startswith("cortex-m3") and before in M3_SHORTEST:
            quick -= MULTIPLY[before][1] - M3_SHORTEST[before]
        result = operands.split(",")[0] if before in LATE else None
        computed = operands.split(",")[0] if (before in PLAIN or before in MULTIPLY) and before not in UNCHANGING else None
        lines.append(f"{address} {cycles} {branched} {quick} {quick_refill(mnemonic, operands, branched, wide)}")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    print(of_image(sys.argv[1], (sys.argv[2:] or ["cortex-m4f"])[0]), end="")
