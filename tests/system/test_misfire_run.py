#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The misfire monitor in the ecu, on the simulated engine, by `sixdeg run`."""
import json
import math
import os
import pathlib
import subprocess
import unittest

from sixdeg_test import Folder, table

ROOT = pathlib.Path(__file__).resolve().parents[2]
DIESEL = ROOT / "host_sim" / "data" / "engines" / "diesel_22.toml"
HEALTHY, PARTIAL, MISFIRE, NOT_JUDGED = "0", "1", "2", "3"


class Monitor(Folder):
    def run_it(self, rpm=1500, bar=5, cycles=120, more="", encoder="pattern_rms_deg = 0.02\njitter_deg = 0.01", load="", mode="dyno"):
        path = self.folder / "scenario.toml"
        path.write_text(f'engine = "{DIESEL}"\n[run]\ncycles = {cycles}\n[speed]\nmode = "{mode}"\nrpm = {rpm}\n[load]\n'
                        f'{"" if bar is None else f"bmep_bar = {bar}"}\n{load}\n'
                        f"[cyclic]\ncov_percent = 5\n{more}\n[encoder]\n{encoder}\n")
        done = subprocess.run([os.environ["SIXDEG"], "run", str(path), "--out", str(self.folder / "out")], capture_output=True,
                              text=True, timeout=300)
        self.assertEqual(done.returncode, 0, done.stderr)
        return table(self.folder / "out" / "cycles.csv"), json.loads((self.folder / "out" / "summary.json").read_text())["misfire"]

    def judged(self, cycles):
        rows = [r for r in cycles if r["misfire_verdict"] not in ("", NOT_JUDGED)]
        self.assertGreater(len(rows), 0.7 * len(cycles))
        return rows

    def test_events_are_found_where_they_were(self):
        events = [(40, 3), (55, 1), (56, 4), (70, 2), (71, 2), (90, 1)]
        more = "[misfires]\n" + "event = [" + ", ".join(f"{{cycle = {c}, cylinder = {n}}}" for c, n in events) + "]"
        cycles, summary = self.run_it(more=more)
        found = {(int(r["cycle"]), int(r["cylinder"])) for r in cycles if r["misfire_verdict"] == MISFIRE}
        self.assertEqual(found, set(events))
        below = {(int(r["cycle"]), int(r["cylinder"]))
                 for r in self.judged(cycles) if float(r["misfire_index"]) < float(r["misfire_limit"])}
        self.assertEqual(below, set(events), "the limit of each firing is what it was judged by")
        self.assertEqual((summary["detected"]["hits"], summary["detected"]["of"]), (6, 6))
        self.assertEqual((summary["false_alarms"]["hits"], summary["wrong_cylinder"]), (0, 0))

    def test_continuous_single_and_pairs(self):
        for cylinders in ([3], [1, 4], [1, 3]):
            with self.subTest(cylinders=cylinders):
                cycles, _ = self.run_it(more=f"[misfires]\ncontinuous = {cylinders}")
                for r in self.judged(cycles):
                    expected = MISFIRE if int(r["cylinder"]) in cylinders else HEALTHY
                    self.assertEqual(r["misfire_verdict"], expected, r)

    def test_partial_burns_are_told_from_misfires(self):
        cycles, summary = self.run_it(more="[misfires]\none_in = 10\nburned_fraction = 0.65", cycles=160)
        weak = [r["misfire_verdict"] for r in self.judged(cycles) if int(r["cycle"]) >= 50 and float(r["torque_true_nm"]) < 85]
        self.assertGreater(len(weak), 20)
        self.assertGreater(weak.count(PARTIAL) / len(weak), 0.9)
        self.assertEqual(summary["partial_as_misfire"], 0)

    def test_fuel_cut_is_not_judged(self):
        cycles, summary = self.run_it(cycles=150, load="fuel_cut_s = [6, 6.6]")
        self.assertEqual((summary["false_alarms"]["hits"], summary["detected"]["of"]), (0, 0))
        self.assertTrue(any(r["misfire_verdict"] == NOT_JUDGED and float(r["torque_true_nm"]) < 1 for r in cycles))

    def test_a_rough_road_is_noticed_and_misfires_on_it_are_found(self):
        cycles, summary = self.run_it(rpm=1000, bar=1, cycles=500, more="[misfires]\none_in = 50", load="road_rms_nm = 60")
        late = [r for r in cycles if int(r["cycle"]) >= 15 and r["rough"]]
        self.assertGreater(sum(r["rough"] == "1" for r in late) / len(late), 0.97)
        self.assertGreaterEqual(summary["detected"]["hits"], summary["detected"]["of"] - 1)
        self.assertGreater(summary["detected"]["of"], 25)
        self.assertLessEqual(summary["false_alarms"]["hits"], 2)

    def test_misfires_are_no_rough_road(self):
        cycles, _ = self.run_it(rpm=1500, bar=5, cycles=200, more="[misfires]\none_in = 10")
        self.assertEqual({r["rough"] for r in cycles if int(r["cycle"]) >= 15 and r["rough"]}, {"0"})

    def test_a_road_that_begins_makes_no_false_alarm(self):
        """1500 rpm, fuel and load of 4 bar, and from 14 to 20 s 60 Nm rms of four sines beside it."""
        sines = [(3.7, 0.3), (6.1, 1.7), (9.4, 2.9), (13.2, 4.1)]
        knots = [(t / 100, 69.6 + (60 * 2**0.5 / 2 * sum(math.sin(2 * math.pi * f * t / 100 + p) for f, p in sines)
                                   if 1400 <= t < 2000 else 0))
                 for t in range(2500)]
        load = f"bmep_bar = 4\ntorque_nm = {[round(v, 3) for _, v in knots]}\ntime_s = {[t for t, _ in knots]}"
        cycles, summary = self.run_it(bar=None, cycles=300, mode="free", load=load)
        rough = [(float(r["t_s"]), r["rough"]) for r in cycles if r["rough"]]
        states = lambda start, end: {state for t, state in rough if start < t < end}
        self.assertEqual(states(10, 13.9), {"0"})
        self.assertEqual(states(15, 20), {"1"}, "noticed within a second")
        self.assertEqual(states(22.5, 25), {"0"})
        self.assertLessEqual(summary["false_alarms"]["hits"], 1)

    def test_lost_edges_never_make_a_misfire(self):
        _, summary = self.run_it(encoder="pattern_rms_deg = 0.02\njitter_deg = 0.01\ndrop_rate = 0.002\nextra_rate = 0.002", cycles=200)
        self.assertGreater(summary["false_alarms"]["of"], 100)
        self.assertEqual(summary["false_alarms"]["hits"], 0)


if __name__ == "__main__":
    unittest.main()
