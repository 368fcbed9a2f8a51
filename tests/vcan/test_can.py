#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Plant and ecu as two processes over vcan0, and clients that no one here wrote: candump, cangen, cantools, python-can."""
import pathlib
import os
import re
import signal
import subprocess
import time
import unittest

import can
import cantools

from bus_test import BusCases, BusFolder, ENGINE, ROOT
from sixdeg_test import table

LONG = unittest.skipUnless(os.environ.get("SD_FULL"), "part of the long set: SD_FULL=1")
DBC = cantools.database.load_file(ROOT / "hal" / "generated" / "sixdeg.dbc")


class Can(BusCases, BusFolder):
    transport = "can:vcan0"
    kills = 10  # the guest is slow

    def bus(self):
        bus = can.Bus("vcan0", interface="socketcan", fd=True)
        self.addCleanup(bus.shutdown)
        return bus

    @LONG
    def test_candump_and_cantools_decode_live_estimates(self):
        dump = subprocess.Popen(["candump", "-r", "4000000", "-T", "3000", "-L", "vcan0,0B0:7F0"], stdout=subprocess.PIPE, text=True)
        self.processes.append(dump)
        time.sleep(0.3)
        self.sixdeg("run", self.scenario("cycles = 12"), "--transport", self.transport, "--out", self.folder / "out")
        text, _ = dump.communicate()
        speeds, done = [], 0
        for line in text.splitlines():
            identifier, data = re.match(r"\(.*\) vcan0 ([0-9A-F]{3})##?(.*)", line).groups()
            message = DBC.get_message_by_frame_id(int(identifier, 16))
            values = message.decode(bytes.fromhex(data[1:] if message.is_fd else data))
            if message.name == "edge" and values["crank_health"] == "valid":
                speeds.append(f"{values['crank_speed']:.3f}")
            done += message.name == "done"
        self.assertGreater(len(speeds), 1000)
        self.assertEqual(speeds, [r["rpm"] for r in table(self.folder / "out" / "teeth.csv") if r["health"] == "valid"])
        self.assertGreater(done, 100)

    def test_noise_and_foreign_frames_are_ignored_and_counted(self):
        scenario = self.scenario("cycles = 15")
        self.sixdeg("run", scenario, "--nominal", "--out", self.folder / "one")
        ecu = self.ecu()
        # Identifiers of others (0x300 to 0x3ff), any length, classic and FD.
        noise = [subprocess.Popen(["cangen", "vcan0", "-g", "1", "-I", "r", *more]) for more in (["-e"], ["-e", "-f"])]
        self.processes += noise
        self.sixdeg("plant", scenario, "--transport", self.transport, "--out", self.folder / "two")
        for process in noise:
            process.kill()
        self.assertEqual(self.csv_bytes("one"), self.csv_bytes("two"))
        _, errors = self.end(ecu)
        self.assertGreater(int(re.search(r"foreign (\d+)", errors)[1]), 20, errors)

    def test_python_can_sets_a_parameter(self):
        self.ecu()
        bus = self.bus()
        request = DBC.get_message_by_name("parameter_request")
        data = request.encode({"command": "set", "index": "torque_harmonics", "value": 7.0})
        bus.send(can.Message(arbitration_id=request.frame_id, data=data, is_extended_id=False))
        until = time.time() + 10
        while time.time() < until:
            message = bus.recv(1)
            if message and message.arbitration_id == DBC.get_message_by_name("parameter").frame_id:
                answer = DBC.decode_message(message.arbitration_id, message.data)
                self.assertEqual((answer["result"], answer["index"], answer["value"]), ("ok", "torque_harmonics", 7.0))
                break
        else:
            self.fail("no answer")
        got = self.sixdeg("parameter", "get", "torque.harmonics", "--transport", self.transport)
        self.assertEqual(got.stdout, "torque.harmonics = 7\n")

    @LONG
    def test_the_interface_goes_down_and_up(self):
        ecu = self.ecu()
        plant = self.start("plant", self.scenario("duration_s = 600", rpm=3000), "--transport", self.transport,
                           "--out", self.folder / "out")
        time.sleep(2)
        subprocess.run(["ip", "link", "set", "vcan0", "down"], check=True)
        time.sleep(2.5)
        subprocess.run(["ip", "link", "set", "vcan0", "up"], check=True)
        time.sleep(2)
        self.end(plant)
        self.assertIsNone(ecu.poll())
        self.came_back()

    @LONG
    def test_a_full_socket_buffer(self):
        """An ecu that is stopped for a while reads nothing; what finds no room is lost, known to be lost, and made up for."""
        ecu = self.ecu()
        plant = self.start("plant", self.scenario("duration_s = 600", rpm=6000), "--transport", self.transport,
                           "--out", self.folder / "out")
        time.sleep(2)
        ecu.send_signal(signal.SIGSTOP)
        time.sleep(7) # silent after 2 s; then the plant goes on and fills the buffer
        ecu.send_signal(signal.SIGCONT)
        time.sleep(2)
        self.end(plant)
        _, errors = self.end(ecu)
        self.assertGreater(int(re.search(r"gaps (\d+)", errors)[1]), 0, errors)
        self.came_back()

    def came_back(self):
        cycles = self.valid_by_cycle(self.folder / "out")
        last = max(cycles)
        lost = [c for c in cycles if not cycles[c] and 15 < c < last - 2]
        self.assertTrue(lost)
        self.assertTrue(all(cycles[c] for c in range(last - 15, last - 2)), cycles)


if __name__ == "__main__":
    unittest.main()
