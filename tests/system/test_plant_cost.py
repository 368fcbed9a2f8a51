#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The plant's cost is linear in cylinders: instructions of one cycle, counted by valgrind, never timed."""
import re
import subprocess
import sys
import unittest

PROBE, ENGINE = sys.argv[1:3]
CYCLES = 20


def instructions(cylinders, cycles):
    command = ["valgrind", "--tool=none", "--log-file=/dev/null", "true"]
    subprocess.run(command, check=True)  # says at once when valgrind is missing
    command = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", PROBE, "turn", ENGINE, str(cylinders), str(cycles)]
    text = subprocess.run(command, check=True, capture_output=True, text=True).stderr
    return int(re.search(r"Collected : (\d+)", text).group(1))


class Cost(unittest.TestCase):
    def test_each_pair_of_cylinders_costs_the_same(self):
        """Reading files and making tables is subtracted."""
        cost = {n: (instructions(n, 2 * CYCLES) - instructions(n, CYCLES)) / (CYCLES * 1440) for n in (2, 4, 6, 8)}
        print("instructions a step:", {n: round(c) for n, c in cost.items()})
        pair = (cost[8] - cost[2]) / 3
        for n in (2, 4, 6):
            self.assertLess(abs(cost[n + 2] - cost[n] - pair), 0.15 * pair)
        self.assertGreater(pair, 0)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
