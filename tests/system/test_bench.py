#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""sixdeg bench: every block is timed, beside its fixed-point and its dense form and document 004's Table 2. No time is asserted."""
import json
import math
import os
import subprocess
import unittest

from sixdeg_test import Folder

SIXDEG = os.environ["SIXDEG"]

# Block: whether it has a form in q31, and one in dense matrices.
BLOCKS = {
    "crank decoder": (False, False),
    "Fourier observer": (True, True),
    "filters on tooth times": (False, False),
    "FOLSMO": (True, True),
    "FOSMO": (True, True),
    "ROO": (True, True),
    "misfire monitor": (False, False),
    "A, observer of cylinders": (True, True),
    "B and C, manifold and delay": (True, False),
    "D, sensor inverted, Fourier law": (True, False),
    "D, sensor inverted, oscillators": (True, True),
    "A to D, the chain": (True, False),
    "joint filter": (False, True),
    "fuel balance": (False, False),
}
TABLE_2 = {"A,": "2.70", "B and C,": "6.70 + < 0.05", "D,": "6.35", "A to D,": "15.80"}  # us, by what a block's name begins with


class Bench(Folder):
    def test_every_block_is_there(self):
        done = subprocess.run([SIXDEG, "bench", "--seconds", "0.0005", "--repetitions", "1", "--json", self.folder / "bench.json"],
                              capture_output=True, text=True, timeout=240)
        self.assertEqual(done.returncode, 0, done.stderr)
        found = json.loads((self.folder / "bench.json").read_text())
        self.assertEqual(set(found["blocks"]), set(BLOCKS))
        for name, (fixed, dense) in BLOCKS.items():
            wanted = {"f32_us"} | ({"q31_us"} if fixed else set()) | ({"dense_us", "dense_over_f32"} if dense else set())
            wanted |= {"dense_over_q31"} if fixed and dense else set()
            row = found["blocks"][name]
            table2 = [figure for start, figure in TABLE_2.items() if name.startswith(start)]
            self.assertEqual(row.pop("table2_us", None), table2[0] if table2 else None, name)
            self.assertEqual(set(row), wanted, name)
            for key, figure in row.items():
                self.assertTrue(math.isfinite(figure) and figure > 0, (name, key, figure))
            self.assertIn(name, done.stdout)

    def test_a_whole_tooth_is_no_less_than_its_parts(self):
        done = subprocess.run([SIXDEG, "bench", "--seconds", "0.0005", "--repetitions", "1", "--json", "-"], capture_output=True, text=True,
                              timeout=240)
        self.assertEqual(done.returncode, 0, done.stderr)
        tooth = json.loads(done.stdout)["tooth"]
        self.assertEqual(set(tooth), {"f32", "q31"})
        for name, time in tooth.items():
            self.assertGreater(time["average_us"], 0, name)
            self.assertGreaterEqual(time["worst_us"], time["average_us"], name)


if __name__ == "__main__":
    unittest.main()
