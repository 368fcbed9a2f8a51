# SPDX-License-Identifier: MIT
"""Clients that no one here wrote, on the bus of a running scenario: candump, cangen, cantools, python-can."""
import json
import os
import pathlib
import signal
import subprocess
import time
import unittest

import can
import cantools

from sixdeg_test import Folder, table

ROOT = pathlib.Path(__file__).resolve().parents[2]
SIXDEG = os.environ["SIXDEG"]
DIESEL = ROOT / "host_sim" / "engines" / "diesel_22.toml"
DATABASE = cantools.database.load_file(ROOT / "hal" / "generated" / "sixdeg.dbc")
MESSAGES = {message.frame_id: message for message in DATABASE.messages}


class Bus(Folder):
    def start(self, *command, **options):
        process = subprocess.Popen(list(map(str, command)), **options)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        return process

    def run_scenario(self, name):
        scenario = self.folder / "scenario.toml"
        scenario.write_text(f'engine = "{DIESEL}"\n[run]\ncycles = 20\n[speed]\nrpm = 1000\n[load]\nbmep_bar = 5\n')
        out = self.folder / name
        subprocess.run([SIXDEG, "run", scenario, "--transport", "can:vcan0", "--out", out], check=True, timeout=120,
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        return out


class Clients(Bus):
    def test_candump_and_cantools_decode_live_estimates(self):
        dump = self.folder / "dump.log"
        with dump.open("w") as file:  # a buffer for all of it: the run does not wait for whoever listens
            candump = self.start("candump", "-L", "-r", 8388608, "vcan0", stdout=file)
        time.sleep(0.3)
        teeth = table(self.run_scenario("run") / "teeth.csv")
        time.sleep(1)
        candump.send_signal(signal.SIGINT)
        candump.wait(10)
        rows = {}  # by tick: a row of signals may need several frames
        for line in dump.read_text().splitlines():
            identifier, data = line.split()[2].split("##" if "##" in line else "#")
            message = MESSAGES.get(int(identifier, 16))
            if message and message.name.startswith("edge"):
                values = message.decode(bytes.fromhex(data[1:]))  # behind the flags of an FD frame
                rows.setdefault(values["tick"], {}).update(values)
        self.assertEqual(len(rows), len(teeth))
        known = 0
        for theirs, ours in zip(rows.values(), teeth):
            self.assertEqual(str(theirs["crank_health"]), ours["health"])
            if ours["torque_nm"]:
                self.assertAlmostEqual(theirs["torque_mass"], float(ours["torque_nm"]), delta=0.0006)
                self.assertEqual(theirs["crank_tooth"], float(ours["tooth"]))
                known += 1
        self.assertGreater(known, 1500)

    def test_noise_of_others_is_ignored_and_counted(self):
        quiet = self.run_scenario("quiet")
        for noise in (["-I", "5ff", "-L", "i", "-D", "i"], ["-e", "-I", "1234567", "-D", "i"], ["-f", "-I", "600", "-L", "64"],
                      ["-I", "A1", "-L", "3"]):  # the last has our identifier, and a length that is not ours
            self.start("cangen", "vcan0", "-g", "2", *noise)
        noisy = self.run_scenario("noisy")
        self.assertEqual((noisy / "cycles.csv").read_bytes(), (quiet / "cycles.csv").read_bytes())
        bus = json.loads((noisy / "summary.json").read_text())["bus"]
        self.assertGreater(bus["foreign"], 20)
        self.assertEqual(json.loads((quiet / "summary.json").read_text())["bus"]["foreign"], 0)

    def test_python_can_sets_a_parameter(self):
        self.start(SIXDEG, "ecu", DIESEL, "--transport", "can:vcan0", stderr=subprocess.DEVNULL)
        request, answer = (DATABASE.get_message_by_name(name) for name in ("parameter_request", "parameter"))
        with can.Bus(interface="socketcan", channel="vcan0", fd=True) as bus:

            def ask(command, value=0.0):
                data = request.encode({"command": command, "index": "torque_harmonics", "value": value}, strict=False)
                bus.send(can.Message(arbitration_id=request.frame_id, data=data, is_extended_id=False))
                until = time.monotonic() + 1
                while time.monotonic() < until:
                    message = bus.recv(0.1)
                    if message and message.arbitration_id == answer.frame_id:
                        said = answer.decode(message.data)
                        return str(said["result"]), said["value"]
                return None

            until = time.monotonic() + 20
            while not ask("read") and time.monotonic() < until:  # the ecu takes its time to start
                pass
            self.assertEqual(ask("set", 8), ("ok", 8))
            self.assertEqual(ask("set", 13), ("out_of_range", 8))
            self.assertEqual(ask("read_reference"), ("ok", 5))
            self.assertEqual(ask("restore"), ("ok", 5))
            self.assertEqual(ask("read"), ("ok", 5))


if __name__ == "__main__":
    unittest.main()
