# SPDX-License-Identifier: MIT
"""docs/results/proofs.md and docs/results/misra.md as text, from what prove.py keeps."""

import textwrap
import tomllib

# What no driver has, with what stands in the place of a proof.
OTHERS = [
    (
        "stages and wiring of the usual ecu (firmware/ecu, sd_afr.c, sd_cylinders.c), stored pages (sd_page.c, sd_learned.c)",
        "no driver; they call the kernels above, and the ecu of fixed point, whose events and inputs they share, has one",
        "sanitized in test_ecu, which runs them with faults, parameters and damaged pages, and in the unit test of each",
    ),
    (
        "numbers of float kernels: that they stay finite and in range",
        "not proved: covariances and series are bounded by relations that intervals do not hold; with any bits in the state there is"
        " nothing to start from",
        "each checks its state at every step and starts afresh or rejects, NaN included (in_unit, sd_within): the unit test of each"
        " gives it what is no number",
    ),
    (
        "that the position of a tooth is one of the wheel's",
        "not proved: which byte of four is the next mark is arithmetic on bits",
        "no index of the decoder depends on it; blocks check the position that they are given; test_crank and its fuzzing look at each",
    ),
]
# Where a driver has alarms that stay: how many, and what they are.
NO_NUMBER = (
    "Frama-C 25 keeps NaN in the range of x where x > 0 has been asked; the conversion is bounded on both sides by comparisons, which leave"
    " NaN out"
)
BETWEEN = (
    "where a speed lies between two of the page, of which it is above one and below the next, is a share of 0 to 1, which intervals do not"
    " see; it becomes a whole number, and the weights of two gains"
)
KEPT = {
    "f32_airpath": (1, NO_NUMBER),
    "f32_exhaust": (2, NO_NUMBER),
    "f32_fourier": (1, NO_NUMBER),
    "f32_joint": (1, NO_NUMBER),
    "f32_point": (1, NO_NUMBER),
    "f32_misfire": (1, "a firing's cylinder is set where its index is one of the engine's, and asked for where it is again"),
    "f32_firings": (1, NO_NUMBER),
    "f32_fired": (1, NO_NUMBER),
    "f32_kalman_4": (5, BETWEEN),
    "f32_kalman_8": (5, BETWEEN),
    "f32_kalman_fourier": (5, BETWEEN),
}
WHAT = {
    "verbs": "every verb of q31 (sd_num.h) and every function of scaled numbers (sd_scaled.h)",
    "scaled_make": "the contract of sd_scaled_make, which the others use in place of its body",
    "fourier_q31": "torque observer: step, reading, restart, revolution shifted; every even number of positions, 1 to 12 harmonics",
    "wheel_q31": "document 000's observers, alone and on the wheel: tooth, verdict, init; wheels of 12 and 120 positions, any marks",
    "exhaust_q31": (
        "manifold and delay: step, measured pressure, shares from every eighth position on, operating point; cycles of 24, 132, 240"
        " positions"
    ),
    "point_q31": "operating point: begin, every piece of its work, gains of the sensor's inversion; any page at all",
    "trims_q31": "trims of the ecu of fixed point: any state, parameters and estimate at all; 1 to 8 cylinders",
    "crank": (
        "decoder on any wheel that init takes: edges, cam, stall, lost sync in each mode, from any state in its ranges; and that it is in"
        " them again afterwards"
    ),
    "crank_init": "decoder's init, any configuration at all: what it leaves is in those ranges",
    "airpath_q31": "air path's diagnosis: tables looked at, step, hold, wait; any state, tables in range, any measurements",
    "work_q31": "work of a cycle: teeth, windows, reading by integers; any state, windows and teeth",
    "bases": "verbs of sd_bases.h for all arguments; two by the contracts that every_number tries",
    "saturate": "the contract of sd_sat_q31, which the last two use in place of its body",
    "f32_fourier": "torque observer; every twelfth number of positions",
    "f32_wheel": "document 000's observers, alone and on the wheel; 12, 48, 84, 120 positions",
    "f32_exhaust": "manifold and delay; any cycle",
    "f32_chain": "sensor inverted, observer of cylinders, chain; cycles of 24, 132, 240 positions",
    "f32_point": "operating point",
    "f32_joint": "joint filter, and the model of the trims that learns the delay; 1 to 8 cylinders",
    "f32_misfire": "misfire monitor",
    "f32_balance": "fuel balance and its watch",
    "f32_driveline": "guard filter, document 003's observers, damping",
    "f32_airpath": "air path's diagnosis",
    "f32_kalman_4": "filters on tooth times, motion, road; 4 cylinders, 60 positions",
    "f32_kalman_8": "the same; 8 cylinders, two modes of twist, 60 positions",
    "f32_kalman_fourier": "the same; 12 harmonics, 36 positions",
    "f32_pattern": "learning in fuel cut: tooth pattern, exponent, twist, zeros; 4 cylinders, and 8 with two modes",
    "f32_fired": "learning of the tooth pattern while the engine fires, hidden directions: teeth, the three steps of the task; 4 cylinders",
    "f32_firings": (
        "single firings: which filter is believed, what is learned when; any wheel, 1 to 8 cylinders, filters and learning by contract"
    ),
    "f32_punctual": "even tooth periods of a known wheel; every time that a tooth leaves",
    "f32_work": "work of a cycle read; any windows",
    "guard_q31": (
        "driveline's guard filter: tooth, edge of the wheels, init, restart; any state, tables and model that init takes, 1 to 8 gears"
    ),
    "fixed_ecu": (
        "ecu of fixed point: init, one event of each kind, parameters, 10 ms task, with decoder, misfires, mixture, what is said; any state"
        " and page in range, kernels by contract"
    ),
    "fixed_cycle": "the same ecu's pieces of a cycle's work and their begin: cylinders, mixture, trims, signals, operating point",
    "crank_inverse": "the contract of sd_inverse_of, which the decoder's driver uses in place of its body",
    "chain_q31": "sensor inverted, observer of cylinders, chain: step, set, reading; cycles of 24, 132, 240 positions",
    "broken": "the negative control: four faults of the kinds that matter",
}
PROOFS = """<!-- SPDX-License-Identifier: MIT -->
<!-- Generated by tests/proof/prove.py --pages from tests/proof/proved.toml: do not edit. -->
# What is proved, and what is not

    tests/proof/prove.py eva                        # Frama-C on the fixed-point kernels; some minutes
    tests/proof/prove.py misra tidy                 # cppcheck and clang-tidy on the firmware
    tests/proof/prove.py eva misra tidy --keep      # keeps what they say, and writes this page and misra.md
    tests/proof/prove.py numbers                    # a few functions with every number that there is; minutes
    tests/proof/stack.py build/cortex-m7/tests/budget/target/budget_ecu    # stack bound, recursion, heap, loops

The first three need Debian packages that tools/setup does not install (frama-c-base with OCaml, cppcheck, clang-tidy); each says so where
its program is missing. tools/check compares this page with what was kept, and runs the last one.

## Fixed point: Frama-C's Eva

For all inputs, all states and all page values in the ranges that the headers state, at once: no signed overflow, no shift by a size that
there is not, no index or pointer out of bounds, no division by 0, no read of what was never written. A driver of tests/proof/eva fills
state, tables and arguments with intervals and calls the kernel as it is; a state is taken to be anything, not only what calls can reach.
The decoder's state has ranges (eva/crank_ranges.h): init leaves it in them, and every call does, so that what holds for one call holds for
ever. The air path's sums of residuals are taken to be of at most a million steps, which is more than a window has.

Three functions go by Newton's steps or digit by digit, which intervals cannot follow: `every_number.c` tries sd_reciprocal, sd_root_q31 and
sd_sqrt_by_bits_f32 with every argument under a sanitizer, the last against the hardware's root, bit for bit. Drivers take what they promise
(eva/contracts_*.h) for granted. So do the drivers of the ecu of fixed point and of single firings with the kernels that they call: a kernel
may leave anything in its state and its answer, but for the few indices that its own driver asserts.
"""
NOT_COVERED = """
What this does not cover:

- Values: that a result is the right one is what unit tests and golden runs are for.
- A conversion to a narrower signed type is taken modulo, as gcc defines it. sd_sat_q31 takes halves of a word apart that way on purpose.
- Floats are only carried by these kernels, so their value is not judged; the few that init reads are ranges given above.
- The portable forms are analysed, not the instructions of a core with the DSP extension; emulated cores that have it give the hash of
  the host, which has not.
- The analysis is by intervals. Rows of a matrix have a quarter of the sum that sd_row_fits_q31 allows for each number, and a sine of
  exactly -1 is a case of its own (fourier_q31), where a cosine beside it is within the table's tolerance of 0.
- Other wheels: where a driver names some cycles or wheels, it holds for those; the decoder's names none.
- Loops end by the list of stack.py, not by this analysis.
"""
FLOATS = """
## Float kernels, whatever bits they are given

State, tables and inputs may be any bits, NaN and infinite included, but for counts and indices, which are in the ranges that init leaves:
no index out of bounds, no read of what was never written, no overflow of whole numbers, no conversion of a float that no whole
number holds. Where a number of alarms stays, its reason stands beside it.
What it says of a number's value is nothing: below.

"""
STACK = """
## Stack, recursion, heap, loops

`tests/proof/stack.py` reads the machine code of the linked image: every call, every jump into another function, everything that a function
pushes or subtracts from the stack pointer. In ctest (`stack_bound`) for all four images, with an image that recurses, takes heap and calls
through pointers as negative control. On a Cortex-M7 sd_ecu_init takes at most 1,080 bytes, sd_ecu_run at most 1,092 (1,128 on a Cortex-M3)
and sd_ecu_task_run, which that may interrupt, at most 584 (652); [costs.md](costs.md) has what painting finds of the first two. The port's
own receive and send come on top. An ecu reaches no heap function, nothing recursive, and no pointer call but the port's. Every loop that
is no counted `for` stands in that file with its bound; one that does not fails the test.

What this does not cover: an interrupt's own frame (up to 104 bytes with floating point), the port, and a counted `for` whose limit comes
from the page (positions, cylinders, harmonics: init refuses what is larger than the arrays).
"""


def table(head, rows):
    return "\n".join(["| " + " | ".join(head) + " |", "|" + "---|" * len(head)] + ["| " + " | ".join(row) + " |" for row in rows]) + "\n"


def proofs(kept, root):
    rows = [
        [
            name,
            WHAT[name] + (f"; {KEPT[name][1]}" if result["alarms"] > 0 and name in KEPT else ""),
            ", ".join(f"`{kernel.split('/')[-1]}`" for kernel in result["kernels"]) or "headers",
            "it must have some" if name == "broken" else "proved" if result["alarms"] == 0 else "not proved",
            str(result["alarms"]),
            f"{result['reached']} %",
        ]
        for name, result in kept.get("eva", {}).items()
        if name in WHAT
    ]
    drivers = sorted(path.stem for path in (root / "tests/proof/eva").glob("*.c"))
    assert drivers == sorted(WHAT), "every driver has a line in proof_pages.py"
    rows += [[name, WHAT[name], "", "not run to its end yet", "-", "-"] for name in drivers if name not in kept.get("eva", {})]
    head = ["driver", "what", "kernels", "state", "alarms", "statements reached"]
    tidy = dict(kept.get("tidy", {}))
    files = tidy.pop("files", 0)
    reasons = tomllib.loads((root / "tests/proof/misra.toml").read_text())["tidy"]
    lines = [f"- `{name}`, {count} times: {reasons.get(name, 'no reason is stated')}" for name, count in sorted(tidy.items())]
    return (
        PROOFS
        + "\n"
        + table(head, [row for row in rows if not row[0].startswith("f32_")])
        + NOT_COVERED
        + FLOATS
        + table(head, [row for row in rows if row[0].startswith("f32_")])
        + "\n## Everything else\n\nWhat no driver shows, with what stands in the place of a proof:\n\n"
        + table(["block", "state of proof", "instead"], [list(row) for row in OTHERS])
        + STACK
        + f"\n## clang-tidy\n\nChecks bugprone, cert and the static analyzer over {files} files. What they say, and why it stays:\n\n"
        + "\n".join(textwrap.fill(line, 138, subsequent_indent="  ", break_on_hyphens=False) for line in lines)
        + "\n\n## MISRA\n\n[misra.md](misra.md) has the numbered deviations.\n"
    )


def misra(kept, root):
    found = kept.get("misra", {})
    rows = [
        [str(d["number"]), ", ".join(d["rules"]), ", ".join(str(found.get(rule, 0)) for rule in d["rules"]), d["why"]]
        for d in tomllib.loads((root / "tests/proof/misra.toml").read_text())["deviation"]
    ]
    return (
        "<!-- SPDX-License-Identifier: MIT -->\n<!-- Generated by tests/proof/prove.py --pages from tests/proof/misra.toml and"
        " proved.toml: do not edit. -->\n# MISRA C:2012: deviations\n\n    tests/proof/prove.py misra        # needs Debian's cppcheck"
        " 2.10; fails where a rule without a deviation is broken\n\n"
        + textwrap.fill(
            "cppcheck's MISRA addon looks at firmware/ (the ecu of fixed point by itself, since its names are the usual one's). It finds"
            " what can be found in the text; rules that need judgement, and directives, it does not look at. Every rule that the firmware"
            " breaks has a deviation here, a rule that is not here is kept, and a deviation that nothing needs any more fails too.",
            138,
        )
        + "\n\n"
        + table(["number", "rules", "places", "why"], rows)
    )
