#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""sixdeg run --record and sixdeg replay of what it wrote: the same events to the bit, other parameters, stops, errors."""
import json
import os
import pathlib
import signal
import subprocess
import time
import unittest

from sixdeg_test import Folder, table

ROOT = pathlib.Path(__file__).resolve().parents[2]
SIXDEG = os.environ["SIXDEG"]
DIESEL = ROOT / "host_sim" / "data" / "engines" / "diesel_22.toml"


class LogFolder(Folder):
    def scenario(self, cycles=25, engine=DIESEL):
        path = self.folder / "scenario.toml"
        path.write_text(f'engine = "{engine}"\n[run]\ncycles = {cycles}\n[speed]\nrpm = 1000\n[load]\nbmep_bar = 5\n'
                        "[encoder]\ndrop_rate = 0.001\n[cylinders]\nfuel_percent = [10, 0, 0, -20]\n")
        return path

    def sixdeg(self, *arguments, status=0):
        done = subprocess.run([SIXDEG, *map(str, arguments)], capture_output=True, text=True, timeout=120)
        self.assertEqual(done.returncode, status, done.stderr)
        return done

    def record(self, name="a", *options, **scenario):
        log = self.folder / f"{name}.sdlog"
        self.sixdeg("run", self.scenario(**scenario), "--nominal", "--record", log, "--out", self.folder / f"{name}_run", *options)
        return log

    def replay(self, log, *options):
        out = self.folder / "replayed"
        self.sixdeg("replay", log, "--out", out, *options)
        return json.loads((out / "summary.json").read_text()), (out / "teeth.csv").read_bytes(), (out / "cycles.csv").read_bytes()


class Replay(LogFolder):
    def test_events_out_are_the_recorded_ones(self):
        for number in ("f32", "q31"):
            with self.subTest(number=number):
                summary, _, _ = self.replay(self.record(number, "--number", number))
                self.assertEqual(summary["edges"], len(table(self.folder / f"{number}_run" / "teeth.csv")))
                self.assertTrue(summary["outputs"]["identical"])
                self.assertGreater(summary["outputs"]["recorded"], 7 * summary["edges"])
                self.assertEqual(summary["outputs"]["recorded"], summary["outputs"]["replayed"])

    def test_tables_are_the_runs_firmware_side(self):
        self.replay(self.record())
        replayed, run = (table(self.folder / name / "teeth.csv") for name in ("replayed", "a_run"))
        self.assertEqual(len(replayed), len(run))
        for theirs, ours in zip(run, replayed):
            for column, of_replay in (("class", "class"), ("tooth", "tooth"), ("health", "health"), ("torque_health", "fourier_health")):
                self.assertEqual(theirs[column], ours[of_replay])
            self.assertAlmostEqual(float(theirs["t_s"]), float(ours["t_s"]), delta=2e-6)
            self.assertEqual(bool(theirs["torque_nm"]), bool(ours["fourier_nm"]))
            if ours["fourier_nm"]:
                self.assertAlmostEqual(float(theirs["torque_nm"]), float(ours["fourier_nm"]), delta=0.0011)
        ours = {(row["cylinder"], row["fourier_nm"]) for row in table(self.folder / "replayed" / "cycles.csv")}
        theirs = {(row["cylinder"], row["torque_nm"]) for row in table(self.folder / "a_run" / "cycles.csv") if row["torque_nm"]}
        self.assertGreater(len(theirs), 50)
        self.assertLessEqual(theirs, ours)

    def test_beside_its_truth_the_replay_gives_the_runs_tables_to_the_byte(self):
        log = self.record(cycles=40)
        _, *again = self.replay(log, "--truth", self.folder / "a_run")
        self.assertEqual(again, [(self.folder / "a_run" / name).read_bytes() for name in ("teeth.csv", "cycles.csv")])
        _, teeth, _ = self.replay(log, "--truth", self.folder / "a_run", "--set", "torque.harmonics=8")
        self.assertNotEqual(teeth, again[0])

    def test_truth_of_another_run_is_refused_by_name(self):
        log, _ = self.record(), self.record("other", cycles=26)
        out = self.folder / "never"
        for folder, named in (("other_run", "teeth.csv"), ("nowhere", "teeth.csv"), ("replayed", "row 1, angle_deg")):
            if folder == "replayed": self.replay(log)
            done = self.sixdeg("replay", log, "--truth", self.folder / folder, "--out", out, status=2)
            self.assertIn(named, done.stderr)
            self.assertFalse(out.exists())

    def test_other_parameters_give_what_a_run_with_them_gives(self):
        plain, eight = self.record(), self.record("eight", "--set", "torque.harmonics=8")
        summary, *changed = self.replay(plain, "--set", "torque.harmonics=8")
        self.assertFalse(summary["outputs"]["identical"])
        self.assertEqual(summary["parameters"]["torque.harmonics"], 8)
        summary, *recorded = self.replay(eight)
        self.assertEqual(changed, recorded)
        # What is not set stays as the log has it.
        tune = self.folder / "tune.toml"
        tune.write_text("[torque]\ngain_mean = 0.31\n")
        summary, *_ = self.replay(eight, "--tune", tune)
        self.assertEqual((summary["parameters"]["torque.harmonics"], summary["parameters"]["torque.gain_mean"]), (8, 0.31))

    def test_a_timer_that_wraps(self):
        fast = self.folder / "fast.toml"
        fast.write_text(DIESEL.read_text().replace("tick_hz = 1e6", "tick_hz = 2e8"))
        # 2^32 ticks are 21.5 s; the decoder's longest stall is shorter then.
        summary, *_ = self.replay(self.record("a", "--set", "crank.stall_time=0.08", cycles=190, engine=fast))
        self.assertTrue(summary["outputs"]["identical"])
        self.assertGreater(float(table(self.folder / "replayed" / "teeth.csv")[-1]["t_s"]), 22)

    def test_the_same_run_gives_the_same_log(self):
        self.assertEqual(self.record("a").read_bytes(), self.record("b").read_bytes())


class Stop(LogFolder):
    def test_a_signal_leaves_whole_files(self):
        for number in (signal.SIGTERM, signal.SIGINT):
            with self.subTest(signal=number.name):
                log, out = self.folder / f"{number.name}.sdlog", self.folder / number.name
                run = subprocess.Popen([SIXDEG, "run", self.scenario(cycles=200000), "--nominal", "--record", log, "--out", out],
                                       stdout=subprocess.DEVNULL)
                partial = pathlib.Path(f"{log}.partial")
                deadline = time.monotonic() + 60
                while not (partial.exists() and partial.stat().st_size > 300000) and time.monotonic() < deadline:
                    time.sleep(0.01)
                run.send_signal(number)
                self.assertEqual(run.wait(60), -number)
                self.assertFalse(partial.exists())
                summary, *_ = self.replay(log)
                self.assertTrue(summary["outputs"]["identical"])
                self.assertEqual(summary["edges"], len(table(out / "teeth.csv")))


class Errors(LogFolder):
    def refused(self, expected, *arguments):
        out = self.folder / "refused"
        done = self.sixdeg(*arguments, "--out", out, status=2)
        self.assertEqual(len(done.stderr.splitlines()), 1)
        self.assertIn(expected, done.stderr)
        self.assertFalse(out.exists())

    def test_one_line_says_what_is_wrong(self):
        log = self.record()
        whole = log.read_bytes()
        touched = self.folder / "touched.sdlog"
        touched.write_bytes(whole[:-100])
        self.refused("touched.sdlog: is truncated or damaged", "replay", touched)
        touched.write_bytes(whole[:5000] + bytes([whole[5000] ^ 1]) + whole[5001:])
        self.refused("touched.sdlog: is truncated or damaged", "replay", touched)
        touched.write_bytes(whole[:20])
        self.refused("touched.sdlog: is truncated", "replay", touched)
        self.refused("--engine: an event log holds its own calibration page", "replay", log, "--engine", DIESEL)
        self.refused("torque: these parameters cannot start the observer", "replay", log, "--set", "torque.gain_energy=37")
        self.refused("torque.harmonics: 13 is outside [0, 12]", "replay", log, "--set", "torque.harmonics=13")
        self.refused("cannot be written", "run", self.scenario(), "--record", log / "below")


if __name__ == "__main__":
    unittest.main()
