# SPDX-License-Identifier: MIT
"""What the tests over LCM and over CAN share: the same behaviour is asked of both."""
import csv
import json
import os
import random
import re
import signal
import subprocess
import sys
import time

from bus_folder import ENGINE, MIXTURE, ROOT
from event_log import SIGNAL, EventLog
from sixdeg_test import table

LONG = bool(os.environ.get("SD_FULL"))
SETTLED_CYCLES = 10
GAP = 8  # sd_event_kind_t


def channel_of(name):
    """Number of a signal's first channel (hal/signals.toml)."""
    import tomllib
    at = 0
    for entry in tomllib.loads((ROOT / "hal" / "signals.toml").read_text())["signal"]:
        if entry["name"] == name:
            return at
        at += entry.get("count", 1)
    raise KeyError(name)


CYLINDER_TORQUE = channel_of("cycle.cylinder_torque")


class BusCases:
    """Mixed into a BusFolder that names a transport."""

    def same_bytes(self, scenario, *options):
        """Rows of a run over the bus that are those of one process to the byte, and its summary."""
        self.sixdeg("run", scenario, "--nominal", "--out", self.folder / "one", *options)
        done = self.sixdeg("run", scenario, "--out", self.folder / "two", "--transport", self.transport, "--record", self.folder / "log",
                           *options)
        self.assertEqual(self.csv_bytes("one"), self.csv_bytes("two"))
        one, two = (json.loads((self.folder / n / "summary.json").read_text()) for n in ("one", "two"))
        bus = two.pop("bus")
        self.assertEqual((bus["edges_unanswered"], bus["silences"], bus["restarts"], bus["unsent"]), (0, 0, 0, 0))
        for summary in (one, two):
            summary.pop("realtime_factor")
        self.assertEqual(one, two)
        self.replays(self.folder / "log")
        print("\n" + done.out, file=sys.stderr)
        return table(self.folder / "two" / "cycles.csv"), two

    def test_in_lock_step_every_byte_is_that_of_one_process(self):
        cycles, _ = self.same_bytes(self.scenario(more=MIXTURE))
        valid = [r for r in cycles if r["health"] == "valid"]
        self.assertGreater(len(valid), 20, "the comparison must be about estimates")
        for column in ("burned", "burned_true", "trim", "misfire_index"):
            self.assertGreater(sum(float(r[column] or 0) != 0 for r in valid), 10, column)

    def test_verdicts_of_the_switched_observers_are_those_of_one_process(self):
        """FOLSMO in the ecu, f32 and q31: acceleration, residual and verdict of each firing."""
        for arithmetic in (0, 1):
            with self.subTest(arithmetic=arithmetic):
                cycles, summary = self.same_bytes(self.scenario("cycles = 60"), "--set", "misfires.one_in=12",
                                                  "--set", "misfire.method=1", "--set", f"misfire.arithmetic={arithmetic}")
                self.assertEqual(summary["misfire"]["method"], f"FOLSMO, {'q31' if arithmetic else 'f32'}")
                judged = [r for r in cycles if r["misfire_verdict"] in ("0", "2")]
                self.assertGreater(len(judged), 100)
                self.assertGreater(sum(r["misfire_verdict"] == "2" for r in judged), 5)
                for column in ("misfire_acceleration", "misfire_residual", "misfire_index"):
                    self.assertGreater(sum(float(r[column]) != 0 for r in judged), 100, column)

    def test_the_chain_in_q31_says_the_same_bytes_over_the_bus(self):
        """Document 004's chain in fixed point, with a pressure sensor in the manifold and trims by a PI law."""
        scenario = self.scenario(more=MIXTURE + "[exhaust_sensors]\npressure_noise_bar = 0.005\ntemperature = true\n")
        choices = [word for setting in ("afr.method=3", "afr.arithmetic=1", "balance.proportional_gain=0.1") for word in ("--set", setting)]
        self.sixdeg("run", scenario, "--nominal", "--out", self.folder / "one", *choices)
        self.sixdeg("run", scenario, "--nominal", "--out", self.folder / "f32", "--set", "afr.method=3", "--set",
                    "balance.proportional_gain=0.1")
        self.sixdeg("run", scenario, "--out", self.folder / "two", "--transport", self.transport, *choices)
        self.assertEqual(self.csv_bytes("one"), self.csv_bytes("two"))
        q31, f32 = (table(self.folder / name / "cycles.csv") for name in ("two", "f32"))
        burned = [(float(a["burned"]), float(b["burned"])) for a, b in zip(q31, f32) if a["burned"] and b["burned"]]
        self.assertGreater(sum(a != 0 for a, b in burned), 40, "mixtures arrive")
        self.assertTrue(any(a != b for a, b in burned), "in the other arithmetic")
        self.assertLess(max(abs(a - b) for a, b in burned), 2e-3)

    def test_the_air_path_says_the_same_bytes_over_the_bus(self):
        """Document 001's section 7 until the valve's fault is named."""
        section_7 = ROOT / "host_sim" / "data" / "scenarios" / "airpath_section7.toml"
        self.same_bytes(section_7, "--set", "run.duration_s=16")
        one, two = (table(self.folder / name / "airpath.csv") for name in ("one", "two"))
        self.assertEqual(one, two)
        self.assertEqual({row["airpath.fault"] for row in two}, {"0.00000", "1.00000"})

    def test_a_third_party_hears_truth_and_estimates(self):
        """In lock-step nobody waits for a listener, so a busy machine may make it lose something; it says so then."""
        scenario = self.scenario(more=MIXTURE)
        for _ in range(3):
            watch = self.watch("--engine", ENGINE, "--out", self.folder / "heard")
            self.sixdeg("run", scenario, "--out", self.folder / "run", "--transport", self.transport)
            try:
                watch.wait(20)
            except subprocess.TimeoutExpired:  # the end of the run was lost
                watch.kill()
            if "truth lost 0, edges without an answer 0" in watch.out:
                break
        self.assertIn("truth lost 0, edges without an answer 0", watch.out)
        self.assertEqual(self.csv_bytes("run"), self.csv_bytes("heard"))
        self.assertRegex(watch.out, r"lamp off, misfires 1, partial burns 0")
        self.assertRegex(watch.out, r"\n4 +\d+\.\d +-\d+\.\d% #+[ |#]*\| +healthy +[01]\.\d\d #+\|#+ ")

    def test_parameters_at_run_time(self):
        ecu = self.ecu("--set", "torque.harmonics=4")
        ask = lambda *words, status=0: self.sixdeg("parameter", *words, "--transport", self.transport, status=status)
        self.assertEqual(ask("get", "torque.harmonics").out, "torque.harmonics = 4\n")
        self.assertEqual(ask("diff").out, "")
        ask("set", "torque.harmonics=6", "crank.stall_time=0.25", "misfire.partial_burn_below=0.7", "balance.integral_gain=0.1",
            "firing.settle_cycles=5")
        changed = ("crank.stall_time: 0.25, reference 0.5\ntorque.harmonics: 6, reference 4\nfiring.settle_cycles: 5, reference 3\n"
                   "misfire.partial_burn_below: 0.7, reference 0.8\nbalance.integral_gain: 0.1, reference 0.25\n")
        self.assertEqual(ask("diff").out, changed)
        for assignment, says in (("torque.harmonics=99", "out of range; allowed is [0, 12]"),
                                 ("firing.torque_change=30", "goes into tables that `sixdeg calibrate` makes"),
                                 ("misfire.partial_burn_below=0.3", "its block cannot run with this value")):
            refused = ask("set", assignment, status=2)
            self.assertIn(f"{assignment.split('=')[0]}: {says}", refused.err)
            self.assertEqual(refused.err.count("\n"), 1)
        ask("set", "torque.nothing=1", status=2)
        # What was dumped starts another ecu with the same page.
        tune = self.folder / "dumped.toml"
        tune.write_text(ask("dump").out)
        self.assertEqual(len(re.findall(" = ", tune.read_text())),
                         len(re.findall(r"^\[\[parameter\]\]", (ROOT / "hal/signals.toml").read_text(), re.M)))
        ask("restore", "crank.stall_time")
        self.assertEqual(ask("diff").out, changed.split("\n", 1)[1])
        ask("restore")
        self.assertEqual(ask("diff").out, "")
        ecu.end()
        self.ecu("--tune", tune)
        self.assertEqual(ask("dump").out, tune.read_text())
        self.assertEqual(ask("diff").out, "")

    def test_a_second_ecu_is_refused_and_the_first_stays(self):
        first = self.ecu()
        done = self.sixdeg("ecu", ENGINE, "--transport", self.transport, status=2)
        self.assertIn("another ecu is on this bus", done.err)
        self.assertEqual(done.err.count("\n"), 1)
        self.sixdeg("plant", self.scenario("cycles = 3"), "--transport", self.transport)
        self.assertIsNone(first.popen.poll())

    def test_in_real_time_nothing_is_faster_than_the_clock(self):
        self.sixdeg("run", self.scenario("cycles = 12"), "--transport", self.transport, "--real-time", "--json", self.folder / "s.json")
        summary = json.loads((self.folder / "s.json").read_text())
        self.assertEqual(summary["bus"]["pace"], "real time")
        self.assertLessEqual(summary["realtime_factor"], 1.05)
        self.assertLessEqual(summary["bus"]["missed_deadlines"], summary["bus"]["clock_events"])

    def test_signals_leave_whole_files(self):
        beats = self.beats()
        for number in (signal.SIGTERM, signal.SIGINT):
            with self.subTest(number=number):
                out, logs = self.folder / number.name, [self.folder / f"{number.name}_{name}.sdlog" for name in ("plant", "ecu")]
                ecu = self.ecu("--record", logs[1])
                plant = self.start("plant", self.scenario("duration_s = 600"), "--transport", self.transport, "--out", out, "--record",
                                   logs[0])
                beats.wait(100)
                self.assertEqual(plant.end(number), -number)
                self.assertEqual(ecu.end(number), 0)
                with (out / "cycles.csv").open() as file:
                    rows = list(csv.reader(file))
                self.assertGreater(len(rows), 10)
                self.assertEqual({len(r) for r in rows}, {len(rows[0])})
                self.assertGreaterEqual(json.loads((out / "summary.json").read_text())["cylinder_cycles"], len(rows) - 5)
                for log in logs:
                    self.assertGreater(self.replays(log)["edges"], 400)

    # ---- faults --------------------------------------------------------------------------------------------------

    def test_an_ecu_killed_and_started_anew_is_valid_again_within_ten_cycles(self):
        kills, dice, beats = 25 if LONG else 2, random.Random(1), self.beats()
        ecu = self.ecu()
        plant, out = self.running_plant()
        for kill in range(1, kills + 1):
            beats.wait(100 + dice.randrange(40))  # 25 cycles and more
            time.sleep(0.005 * dice.random())
            ecu.kill()
            if kill % 10 == 2:  # long enough for the plant to go on without it
                plant.expect("the ecu does not answer; the plant goes on without it", 1 + kill // 10)
            ecu = self.ecu()
            plant.expect("the ecu has been started anew", kill)
        beats.wait(100)
        plant.end()
        cycles, returns = self.valid_by_cycle(out), self.cycles_of_return(out)
        self.assertEqual(len(returns), kills)
        for at in returns:
            self.assertTrue(all(cycles[c] for c in range(at + SETTLED_CYCLES, at + 20)), (at, cycles))
        self.assertGreaterEqual(sum(not valid for valid in cycles.values()), 5 * kills, "the gaps must show")

    def cycles_of_return(self, out):
        """In which cycles a new ecu spoke first: of an edge whose angle it did not know yet."""
        returns, cycle, before, known = [], 0, 0.0, False
        for row in table(out / "teeth.csv"):
            cycle += float(row["angle_deg"]) < before - 360
            before = float(row["angle_deg"])
            if known and row["class"] == "unsynced":
                returns.append(cycle)
            known = row["health"] == "valid" or known and row["class"] != "unsynced"
        return returns

    def test_a_plant_killed_and_started_anew_gets_valid_estimates_within_ten_cycles(self):
        kills, dice, beats = 25 if LONG else 2, random.Random(2), self.beats()
        ecu = self.ecu("--record", self.folder / "ecu.sdlog")
        for kill in range(1, kills + 1):
            plant, _ = self.running_plant()
            beats.wait(100 + dice.randrange(40))
            time.sleep(0.005 * dice.random())
            plant.kill()
            if kill % 10 == 2:
                ecu.expect("the plant is silent", 1 + kill // 10)
            self.assertIsNone(ecu.popen.poll(), "it carries on")
        plant, out = self.running_plant()
        ecu.expect("the plant has been started anew", kills)
        beats.wait(100)
        plant.end()
        cycles = self.valid_by_cycle(out)
        self.assertTrue(all(cycles[c] for c in range(SETTLED_CYCLES + 1, max(cycles) - 1)), cycles)
        self.assertEqual(ecu.end(), 0)
        # What the ecu itself said after each of the gaps.
        log = EventLog(self.folder / "ecu.sdlog")
        is_cycle = log.out & (log.kind == SIGNAL) & (log.channel == CYLINDER_TORQUE)
        gaps = (~log.out & (log.kind == GAP)).nonzero()[0]
        self.assertEqual(len(gaps), kills)
        for at, following in zip(gaps, [*gaps[1:], len(log.kind)]):
            valid = (log.flags[at:following][is_cycle[at:following]] & 0xff) == 0
            self.assertGreater(len(valid), SETTLED_CYCLES)
            self.assertTrue(valid[SETTLED_CYCLES - 1:].all(), valid)

    def test_a_full_socket_buffer(self):
        """An ecu that is stopped reads nothing; what finds no room is lost, known to be lost, and made up for."""
        beats, ecu = self.beats(), self.ecu()
        plant, out = self.running_plant()
        beats.wait(60)
        ecu.popen.send_signal(signal.SIGSTOP)
        plant.expect("the plant goes on without it")
        self.flood()
        time.sleep(0.3)  # teeth that find no room
        ecu.popen.send_signal(signal.SIGCONT)
        plant.expect("the ecu answers again")
        self.came_back(beats, plant, out)
        ecu.end()
        self.assertGreater(int(re.search(r"gaps (\d+)", ecu.err)[1]), 0, ecu.err)

    def came_back(self, beats, plant, out):
        beats.wait(100)
        plant.end()
        cycles = self.valid_by_cycle(out)
        last = max(cycles)
        self.assertTrue([c for c in cycles if not cycles[c] and 11 < c < last - 11], "the fault must show")
        self.assertTrue(all(cycles[c] for c in range(last - 12, last - 1)), cycles)
