#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The ecu of fixed point (docs/theory/fixed.md): its linked image has no floating-point arithmetic; it says the same bits on the target as
on the host, and what the usual ecu says in q31 within the bounds below; and what a tooth costs."""
import pathlib
import re
import subprocess
import sys
import tempfile
import tomllib
import unittest
import warnings

import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import budget  # noqa: E402  the path comes first

ROOT = budget.ROOT
CORE = "cortex-m3-fixed"
# AEABI names of float and double arithmetic, comparisons and conversions, and libgcc's own names for them.
FLOATING = re.compile(r"^__aeabi_(c?[fd]|u?[il]2[fd])\w*$|^__(\w+)[sd]f[23]$|^__(float|fix)\w+$|^__\w*(sf|df)\w*$")
# How far the two may be apart, in the signals' units: of an edge, of a firing and of a cycle.
BOUNDS = {"crank.edge_class": 0, "crank.tooth": 0, "crank.angle": 1e-4, "crank.phase_known": 0, "crank.speed": 1e-3,
          "crank.acceleration": 1e-2,
          "torque.mass": 1e-3, "torque.innovation": 1e-4, "work.cycle": 1e-3, "work.change": 2e-3, "work.sd": 1e-4, "work.firing": 0,
          "misfire.verdict": 0, "misfire.inhibit": 0, "misfire.cylinder": 0, "misfire.index": 1e-3, "misfire.residual": 0.1,
          "cycle.speed": 1e-3, "cycle.cylinder_torque": 1e-2, "cycle.cylinder_sd": 1e-4,
          # A new operating point takes effect some teeth earlier, since there are fewer pieces before it; trims have a simpler law.
          "afr.cylinder_burned": 2e-3, "afr.cylinder_sd": 2e-3}
# Trims of a replay answer to nothing and grow, and the simpler law, which takes nothing back for noise, makes all of them larger alike:
# so by shares of the largest of them.
SHARES = {"balance.trim": 0.2}
USUAL = {"afr.cylinder_burned": 1e-6, "afr.cylinder_sd": 1e-4}  # and the median of that


def floating(image):
    names = subprocess.run(["arm-none-eabi-nm", image], capture_output=True, text=True, check=True).stdout.split("\n")
    return sorted({line.split()[-1] for line in names if line and FLOATING.match(line.split()[-1])})


def image_of(core):
    return ROOT / "build" / core / "tests/budget/target/budget_ecu"


def signals(data):
    """(tick, value, health) by channel."""
    events = numpy.frombuffer(data, dtype=[("tick", "<u4"), ("kind", "<u2"), ("channel", "<u2"), ("value", "<f4"), ("flags", "<u4")])
    events = events[events["kind"] == 16]
    return {int(c): events[events["channel"] == c] for c in numpy.unique(events["channel"])}


class Fixed(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp())
        files = [cls.folder / name for name in ("page", "events", "float", "fixed")]
        tools = ROOT / "build/host/tests/budget"
        subprocess.run([tools / "budget_input", ROOT / "tests/golden/fixed.run"] + files[:3], check=True, capture_output=True)
        subprocess.run([tools / "budget_fixed"] + files[:2] + files[3:], check=True, capture_output=True)
        cls.float, cls.fixed = (signals(path.read_bytes()) for path in files[2:])
        cls.rows = cls.channels()

    @staticmethod
    def channels():
        """Channels of each signal, by name."""
        table = tomllib.loads((ROOT / "hal/signals.toml").read_text())["signal"]
        rows, channel = {}, 0
        for row in table:
            rows[row["name"]] = range(channel, channel + row.get("count", 1))
            channel += row.get("count", 1)
        return rows

    def pairs(self, name):
        """Values of both ecus at the ticks at which both say something valid; from the second second on, when all has settled."""
        found = []
        for channel in self.rows[name]:
            usual, fixed = self.float[channel], self.fixed[channel]
            _, a, b = numpy.intersect1d(usual["tick"], fixed["tick"], return_indices=True)
            good = ((usual["flags"][a] & 0xff) == 0) & ((fixed["flags"][b] & 0xff) == 0) & (usual["tick"][a] > 2_000_000)
            found.append(numpy.stack([usual["value"][a][good], fixed["value"][b][good]], axis=1))
        return numpy.concatenate(found)

    def test_the_linked_image_has_no_floating_point(self):
        self.assertEqual(floating(image_of(CORE)), [])

    def test_and_the_look_for_it_finds_some_where_there_is_some(self):
        found = floating(image_of("cortex-m3"))
        for name in ("__aeabi_fadd", "__aeabi_fmul", "__aeabi_fdiv", "__aeabi_i2f", "__aeabi_f2iz", "__aeabi_fcmplt"):
            self.assertIn(name, found)

    def test_it_says_what_the_usual_ecu_says_in_q31(self):
        for name, bound in BOUNDS.items():
            pairs = self.pairs(name)
            self.assertGreater(len(pairs), 30, name)
            apart = numpy.abs(pairs[:, 0] - pairs[:, 1])
            self.assertLessEqual(apart.max(), bound, name)
            self.assertLessEqual(numpy.median(apart), USUAL.get(name, bound), name)
        for name, share in SHARES.items():
            pairs = self.pairs(name)
            self.assertLessEqual(numpy.abs(pairs[:, 0] - pairs[:, 1]).max(), share * numpy.abs(pairs).max(), name)
        moved = self.pairs("torque.mass")[:, 0]
        self.assertGreater(moved.max() - moved.min(), 100, "the comparison must be about something")

    def test_a_crank_that_hardly_turns_slows_down_and_speeds_up(self):
        """An eighth each tooth, at 3 to 7 s a tooth: 64 times that change has more than 32 bits."""
        waits = [1_000_000] * 57 + [3_000_000]
        slower = [round(2.9e6 * 1.12**n) for n in range(8)]
        run = self.folder / "slow.run"
        head = ["engine diesel_22.toml", "tune torque.fixed_point 1", "tune afr.method 3", "tune afr.arithmetic 1", "tune misfire.method 1",
                "tune misfire.arithmetic 1", "tune firing.enabled 0", "tune crank.stall_time 10", "events"]
        steps = [round(1e6 * 1.08**n) for n in range(14)]
        run.write_text("\n".join(head + [f"c{wait}" for wait in waits * 4 + steps + slower + slower[::-1]]) + "\n")
        files = [self.folder / f"slow_{name}" for name in ("page", "events", "float", "fixed")]
        tools = ROOT / "build/host/tests/budget"
        subprocess.run([tools / "budget_input", run] + files[:3], check=True, capture_output=True)
        subprocess.run([tools / "budget_fixed"] + files[:2] + files[3:], check=True, capture_output=True)
        channel = self.rows["crank.acceleration"][0]
        usual, fixed = (signals(path.read_bytes())[channel] for path in files[2:])
        self.assertEqual(usual["tick"].tolist(), fixed["tick"].tolist())
        self.assertLess(usual["value"].min(), -1e-3, "it slows down")
        self.assertGreater(usual["value"].max(), 1e-3, "and speeds up")
        numpy.testing.assert_allclose(fixed["value"], usual["value"], rtol=1e-5)

    def test_what_is_not_built_says_so(self):
        said = self.fixed[self.rows["firing.waveform"][0]]
        self.assertEqual(set((said["flags"] & 0xff).tolist()), {2}, "invalid")
        self.assertTrue(all(int(flags) >> 8 & 512 for flags in said["flags"]), "not built")
        self.assertEqual(set(self.fixed[self.rows["misfire.monitor"][0]]["value"].tolist()), {3}, "the monitor judges nothing")

    def test_trims_balance_the_cylinders(self):
        """The golden run's injectors are even until 19 s, so that trims stay small; but they move."""
        trims = self.pairs("balance.trim")[:, 1]
        self.assertGreater(numpy.abs(trims).max(), 1e-4)
        self.assertLess(numpy.abs(trims).max(), 0.2)

    def test_the_target_says_the_same_bits_and_a_tooth_is_cheap(self):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ResourceWarning)
            run = budget.Run("fixed", CORE)
        self.assertTrue(run.same, "host and Cortex-M3 say the same")
        average = run.figure({"group": "event", "classes": "settled"})
        worst = run.figure({"group": "event", "classes": "placed", "worst": True})
        print(f"\na tooth on a Cortex-M3: {average} instructions on average, {worst} at most; ecu {run.sizes['ecu']} B", file=sys.stderr)
        self.assertLessEqual(average, 4000)
        self.assertGreater(average, 1000, "it must be doing something")


if __name__ == "__main__":
    unittest.main()
