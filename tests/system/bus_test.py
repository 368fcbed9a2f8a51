# SPDX-License-Identifier: MIT
"""What the tests over LCM and over CAN share: the same behaviour is asked of both."""
import csv
import json
import os
import pathlib
import random
import re
import signal
import subprocess
import sys
import time
import unittest

from sixdeg_test import Folder, table

ROOT = pathlib.Path(__file__).resolve().parents[2]
SIXDEG = os.environ["SIXDEG"]
ENGINE = ROOT / "host_sim" / "engines" / "diesel_22.toml"
FUEL = "fuel_percent = [10, 0, 0, -20]"
SETTLED_CYCLES = 10


def in_own_network():
    """Runs this program again where LCM's multicast stays within it, if the machine lets us."""
    if os.environ.get("SD_OWN_NETWORK"):
        return
    network = "ip link set lo up && ip link set lo multicast on && ip route add 224.0.0.0/4 dev lo"
    unshare = ["unshare", "--net"] + ([] if os.getuid() == 0 else ["--map-root-user"])
    if subprocess.run(unshare + ["sh", "-c", network], capture_output=True).returncode == 0:
        os.environ["SD_OWN_NETWORK"] = "1"
        os.execvp("unshare", unshare + ["sh", "-c", network + ' && exec "$@"', "sh", sys.executable] + sys.argv)


class BusFolder(Folder):
    transport = None  # of the derived class

    def setUp(self):
        super().setUp()
        self.processes = []
        self.addCleanup(self.stop_all)

    def stop_all(self):
        for process in self.processes:
            if process.poll() is None:
                process.kill()
            process.wait()
            for stream in (process.stdout, process.stderr):
                if stream:
                    stream.close()

    def scenario(self, run="cycles = 25", rpm=1000):
        path = self.folder / "scenario.toml"
        path.write_text(f'engine = "{ENGINE}"\n[run]\n{run}\n[speed]\nrpm = {rpm}\n[load]\nbmep_bar = 5\n[cylinders]\n{FUEL}\n'
                        "[[misfires.event]]\ncycle = 20\ncylinder = 4\n")
        return path

    def start(self, *arguments):
        process = subprocess.Popen([SIXDEG, *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.processes.append(process)
        return process

    def sixdeg(self, *arguments, status=0):
        done = subprocess.run([SIXDEG, *map(str, arguments)], capture_output=True, text=True, timeout=250)
        self.assertEqual(done.returncode, status, done.stderr)
        return done

    def ecu(self, *more):
        process = self.start("ecu", ENGINE, "--transport", self.transport, *more)
        line = process.stderr.readline()
        self.assertIn("running on", line)
        return process

    def end(self, process, number=signal.SIGTERM):
        process.send_signal(number)
        return process.communicate(timeout=60)

    def csv_bytes(self, name):
        return [(self.folder / name / file).read_bytes() for file in ("cycles.csv", "teeth.csv")]


class BusCases:
    """Mixed into a BusFolder that names a transport."""

    kills = 50  # in the long set

    def test_in_lock_step_every_byte_is_that_of_one_process(self):
        scenario = self.scenario()
        self.sixdeg("run", scenario, "--nominal", "--out", self.folder / "one")
        done = self.sixdeg("run", scenario, "--out", self.folder / "two", "--transport", self.transport, "--record", self.folder / "log")
        self.assertEqual(self.csv_bytes("one"), self.csv_bytes("two"))
        one, two = (json.loads((self.folder / n / "summary.json").read_text()) for n in ("one", "two"))
        bus = two.pop("bus")
        self.assertEqual((bus["edges_unanswered"], bus["silences"], bus["restarts"], bus["unsent"]), (0, 0, 0, 0))
        for summary in (one, two):
            summary.pop("realtime_factor")
        self.assertEqual(one, two)
        valid = [r for r in table(self.folder / "two" / "cycles.csv") if r["health"] == "valid"]
        self.assertGreater(len(valid), 20, "the comparison must be about estimates")
        # The recorded stream through a fresh ecu says the same, event for event.
        self.sixdeg("replay", self.folder / "log", "--json", self.folder / "r.json")
        self.assertTrue(json.loads((self.folder / "r.json").read_text())["outputs"]["identical"])
        print("\n" + done.stdout, file=sys.stderr)

    def test_a_third_party_hears_truth_and_estimates(self):
        """In lock-step nobody waits for a listener, so a busy machine may make it lose something; it says so then."""
        scenario, out = self.scenario(), ""
        for _ in range(3):
            watch = self.start("watch", "--transport", self.transport, "--engine", ENGINE, "--out", self.folder / "heard")
            time.sleep(0.5)
            self.sixdeg("run", scenario, "--out", self.folder / "run", "--transport", self.transport)
            try:
                out, _ = watch.communicate(timeout=20)
            except subprocess.TimeoutExpired:  # the end of the run was lost
                watch.kill()
                watch.communicate()
            if "truth lost 0, edges without an answer 0" in out:
                break
        self.assertIn("truth lost 0, edges without an answer 0", out)
        self.assertEqual(self.csv_bytes("run"), self.csv_bytes("heard"))

    def test_parameters_at_run_time(self):
        self.ecu("--set", "torque.harmonics=4")
        ask = lambda *words, status=0: self.sixdeg("parameter", *words, "--transport", self.transport, status=status)
        self.assertEqual(ask("get", "torque.harmonics").stdout, "torque.harmonics = 4\n")
        self.assertEqual(ask("diff").stdout, "")
        ask("set", "torque.harmonics=6", "crank.stall=0.25")
        self.assertEqual(ask("diff").stdout, "crank.stall: 0.25, reference 0.5\ntorque.harmonics: 6, reference 4\n")
        refused = ask("set", "torque.harmonics=99", status=2)
        self.assertIn("torque.harmonics: out of range; allowed is [0, 12]", refused.stderr)
        self.assertEqual(refused.stderr.count("\n"), 1)
        ask("set", "torque.nothing=1", status=2)
        ask("restore")
        self.assertEqual(ask("diff").stdout, "")
        self.assertEqual(len(ask("get").stdout.splitlines()), len(re.findall(r"^\[\[parameter\]\]", (ROOT / "hal/signals.toml").read_text(), re.M)))

    def test_a_second_ecu_is_refused_and_the_first_stays(self):
        first = self.ecu()
        done = self.sixdeg("ecu", ENGINE, "--transport", self.transport, status=2)
        self.assertIn("another ecu is on this bus", done.stderr)
        self.sixdeg("plant", self.scenario("cycles = 3"), "--transport", self.transport)
        self.assertIsNone(first.poll())

    def test_in_real_time_nothing_is_faster_than_the_clock(self):
        self.sixdeg("run", self.scenario("cycles = 12"), "--transport", self.transport, "--real-time", "--json", self.folder / "s.json")
        summary = json.loads((self.folder / "s.json").read_text())
        self.assertEqual(summary["bus"]["pace"], "real time")
        self.assertLessEqual(summary["realtime_factor"], 1.05)
        self.assertLessEqual(summary["bus"]["missed_deadlines"], summary["bus"]["clock_events"])

    def test_signals_leave_whole_files(self):
        for number in (signal.SIGTERM, signal.SIGINT):
            with self.subTest(number=number):
                out = self.folder / number.name
                run = self.start("run", self.scenario("duration_s = 600"), "--transport", self.transport, "--out", out)
                time.sleep(2)
                self.end(run, number)
                self.assertEqual(run.returncode, -number)
                rows = table(out / "cycles.csv")
                self.assertGreater(len(rows), 10)
                self.assertEqual({len(r) for r in csv.reader((out / "cycles.csv").open())}, {len(rows[0])})
                self.assertTrue(json.loads((out / "summary.json").read_text())["cylinder_cycles"] >= len(rows) - 4)

    @unittest.skipUnless(os.environ.get("SD_FULL"), "part of the long set: SD_FULL=1")
    def test_whoever_is_killed_and_started_anew_is_valid_again_within_ten_cycles(self):
        """Alternately ecu and plant, at random moments."""
        dice = random.Random(1)
        page = self.scenario("duration_s = 600", rpm=3000)
        plant_words = ("plant", page, "--transport", self.transport)
        ecu = self.ecu()
        for kill in range(self.kills):
            out = self.folder / f"kill{kill}"
            plant = self.start(*plant_words, "--out", out)
            time.sleep(1.2 + dice.random())
            if kill % 2:  # the plant: the ecu carries on, and a new plant finds it
                plant.kill()
                plant.communicate()
                self.assertIsNone(ecu.poll())
                plant = self.start(*plant_words, "--out", out)
                time.sleep(1.5)
                self.end(plant)
                cycles = self.valid_by_cycle(out)
                self.assertTrue(all(cycles[c] for c in range(SETTLED_CYCLES + 2, max(cycles) - 2)), cycles)
            else:  # the ecu: the plant carries on and says so
                ecu.kill()
                ecu.communicate()
                time.sleep(0.1 + 0.3 * dice.random())
                ecu = self.ecu()
                time.sleep(1.5)
                _, errors = self.end(plant)
                self.assertIn("the ecu has been started anew", errors)
                cycles = self.valid_by_cycle(out)
                lost = [c for c in cycles if not cycles[c] and 15 < c < max(cycles) - 2]
                self.assertTrue(lost, "the gap must show")
                self.assertLessEqual(max(lost) - self.cycle_of_return(out), SETTLED_CYCLES)

    def cycle_of_return(self, out):
        """In which cycle the new ecu spoke first: of an edge whose angle it did not know yet."""
        cycle, before, known = 0, 0.0, False
        for row in table(out / "teeth.csv"):
            cycle += float(row["angle_deg"]) < before - 360
            before = float(row["angle_deg"])
            known |= row["health"] == "valid"
            if known and row["class"] == "unsynced":
                return cycle
        self.fail("no new ecu")

    def valid_by_cycle(self, out):
        cycles = {}
        for row in table(out / "cycles.csv"):
            cycles[int(row["cycle"])] = cycles.get(int(row["cycle"]), True) and row["health"] == "valid"
        return cycles
