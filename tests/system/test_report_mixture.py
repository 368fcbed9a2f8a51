#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The report of mixture and fuel trims: its figures against made runs whose answers are known, and clear refusals."""
import hashlib
import json
import os
import pathlib
import re
import subprocess
import unittest

from sixdeg_test import ReportFolder, charts, outside

ROOT = pathlib.Path(__file__).resolve().parents[2]
CYCLE_S, CYCLES, ON_S, STEP_S = 0.08, 200, 8.0, 4.0
SCENARIO = f"""[run]
duration_s = 16
[cylinders]
fuel_percent = [10, 0, 0, -10]
[[cylinders.fuel_step]]
at_s = {STEP_S}
cylinder = 2
percent = 20
[control]
balance_on_s = [{ON_S}, 1000]
"""
TAKES_UP = 0.3  # share of a change that the made estimate takes up in a cycle: more than 0.8 after 5
COLUMNS = "cycle,cylinder,t_s,imep_true_bar,torque_nm,burned_true,burned,trim"


def percents(cycle, balanced):
    """Fuel beyond nominal: the step, and no spread from when the trims are on, if they do anything."""
    t_s = cycle * CYCLE_S
    if balanced and t_s >= ON_S:
        return [0, 0, 0, 0]
    return [10, 20 if t_s >= STEP_S else 0, 0, -10]


def write_run(folder, source=1, header=COLUMNS, burned=True, balanced=True, **changed):
    folder.mkdir()
    scenario = folder / "scenario.toml"
    scenario.write_text(SCENARIO)
    balance = {"spread_before_percent": 27.3, "cycles_to_3_percent": 12, "residual_percent": 0.4}
    summary = {"scenario": "made <trims>", "afr": {"rms_points": 1.5}, "balance": balance,
               "perturbed": {"balance": {**balance, "cycles_to_3_percent": -1}}, "set": [], "seed": 3,
               "parameters": {"balance.source": source}, "engine": {"name": "test engine"},
               "files": {str(scenario): hashlib.sha256(scenario.read_bytes()).hexdigest()}, **changed}
    (folder / "summary.json").write_text(json.dumps(summary))
    lines, estimate = [header], [0.5 * (1 + p / 100) for p in percents(0, balanced)]
    for cycle in range(CYCLES):
        for i, percent in enumerate(percents(cycle, balanced)):
            truth = 0.5 * (1 + percent / 100)
            estimate[i] += TAKES_UP * (truth - estimate[i])
            cells = [cycle, i + 1, (cycle + i / 4) * CYCLE_S, 10 * (1 + percent / 100), 100, truth if burned else "", estimate[i], 0]
            lines.append(",".join(map(str, cells)))
    (folder / "cycles.csv").write_text("\n".join(lines) + "\n")


class MixtureReport(ReportFolder):
    def setUp(self):
        super().setUp()
        self.runs = [self.folder / "lambda", self.folder / "torque"]

    def test_figure_16_states_what_the_runs_hold_and_the_same_bytes_twice(self):
        for run, source in zip(self.runs, (1, 2)):
            write_run(run, source)
        page = self.drawn("--figure-16", *self.runs)
        self.assertEqual(len(charts(page)), 2)
        self.assertEqual(outside(page), [])
        self.assertTrue("Fuel trims, made &lt;trims&gt;: cylinders that were 27.3 % apart" in page)
        spread = 100 * 30 / 105  # +20 less -10 %, of the mean +5 %
        self.assertRegex(page, f"spread before the control is on</td><td>[^<]*</td><td>{spread:.1f} %</td><td>{spread:.1f} %</td>")
        self.assertRegex(page, "last 20 cycles</td><td>[^<]*</td><td>0.0 %</td><td>0.0 %</td>")
        self.says(page, "<td>cycles until it is below 3 %</td><td></td><td>12 / not reached</td><td>12 / not reached</td>")
        self.assertTrue(page == self.drawn("--figure-16", *self.runs))

    def test_convergence_is_counted_from_the_first_exhaust_of_a_step(self):
        write_run(self.runs[0], balanced=False, balance=None, perturbed=None)
        page = self.drawn("--figure-14", self.runs[0])
        self.says(page, "<td>within 4 engine cycles</td><td>median 5 cycles, 1 of 1 steps</td>")
        self.says(page, "<td>1.50 % of the mean</td>")
        self.assertEqual(len(charts(page)), 1)

    def test_what_sixdeg_writes_is_drawn(self):
        scenario = self.folder / "scenario.toml"
        text = (ROOT / "host_sim/data/scenarios/figure16_1500rpm_9bar.toml").read_text()
        scenario.write_text(text.replace("../engines", str(ROOT / "host_sim/data/engines")).replace("duration_s = 45", "duration_s = 7")
                            .replace("at_s = 19", "at_s = 2").replace("[0, 7.5, 36, 1000]", "[0, 1, 3, 1000]"))
        subprocess.run([os.environ["SIXDEG"], "run", scenario, "--nominal", "--out", self.runs[0]], check=True, capture_output=True)
        balance = json.loads((self.runs[0] / "summary.json").read_text())["balance"]
        page = self.drawn("--figure-16", self.runs[0], self.runs[0])
        self.says(page, f"{balance['spread_before_percent']:.1f} % / -")
        last = float(re.search("last 20 cycles</td><td>[^<]*</td><td>([^ ]*) %", page)[1])
        self.assertLess(last, 5)
        self.assertGreater(balance["cycles_to_3_percent"], 0)

    def test_bad_folders_are_named_and_leave_no_page(self):
        def refused(message, **how):
            write_run(self.runs[0], **how)
            done = self.report("--figure-14", self.runs[0])
            self.assertEqual((done.returncode, self.page.exists(), done.stderr.count("\n")), (2, False, 1), done.stderr)
            self.assertRegex(done.stderr, message)
            for file in self.runs[0].iterdir():
                file.unlink()
            self.runs[0].rmdir()

        refused(r"cycles\.csv: has no column trim", header=COLUMNS.replace("trim", "trims"))
        refused(r"burned_true: is empty: the scenario has no \[uego\]", burned=False)
        refused(r"summary\.json: files: names no scenario", files={})


if __name__ == "__main__":
    unittest.main()
