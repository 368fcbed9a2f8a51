#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Clients that no one here wrote on vcan0: candump, cangen, cantools, python-can."""
import json
import pathlib
import re
import signal
import unittest

import can
import cantools

from bus_folder import PATIENCE_S, BusFolder, ROOT, until
from sixdeg_test import table

DBC = cantools.database.load_file(ROOT / "hal" / "generated" / "sixdeg.dbc")


def listeners():
    return sum(line.split()[:1] == ["vcan0"] for path in pathlib.Path("/proc/net/can").glob("rcvlist_*")
               for line in path.read_text().splitlines())


class Clients(BusFolder):
    transport = "can:vcan0"

    def test_what_candump_and_cantools_read_is_what_the_run_wrote(self):
        # With a buffer for all of it: the run does not wait for whoever listens.
        before = listeners()
        dump = self.process("candump", "-L", "-r", "8388608", "vcan0")
        until(lambda: listeners() > before, "candump")
        self.sixdeg("run", self.scenario("cycles = 12"), "--transport", self.transport, "--out", self.folder / "run")
        until(lambda: " 0F2#" in dump.out, "the end of the run")
        dump.end(signal.SIGINT)
        teeth, rows, answered = table(self.folder / "run" / "teeth.csv"), {}, 0
        for line in dump.out.splitlines():
            identifier, data = re.match(r"\(.*\) vcan0 ([0-9A-F]{3})##?(.*)", line).groups()
            message = DBC.get_message_by_frame_id(int(identifier, 16))
            answered += message.name == "done"
            if message.name.startswith("edge"):  # the signals of a tooth, in as many frames as they need
                values = message.decode(bytes.fromhex(data[1:]))
                rows.setdefault(values["tick"], {}).update(values)
        self.assertGreater(answered, 100)
        self.assertEqual(len(rows), len(teeth))
        known = 0
        for heard, written in zip(rows.values(), teeth):
            self.assertEqual(str(heard["crank_health"]), written["health"])
            if written["torque_nm"]:
                self.assertAlmostEqual(heard["torque_mass"], float(written["torque_nm"]), delta=0.0006)
                self.assertEqual(heard["crank_tooth"], float(written["tooth"]))
                known += 1
        self.assertGreater(known, 1000)

    def beside(self, *noises):
        """The ecu's counters after a run beside cangen; the run must be the one without it."""
        scenario = self.scenario("cycles = 12")
        self.sixdeg("run", scenario, "--nominal", "--out", self.folder / "quiet")
        ecu = self.ecu()
        for noise in noises:
            self.process("cangen", "vcan0", *noise)
        self.sixdeg("plant", scenario, "--transport", self.transport, "--out", self.folder / "noisy")
        self.assertEqual(self.csv_bytes("quiet"), self.csv_bytes("noisy"))
        ecu.end()
        return {name: int(number) for name, number in re.findall(r"(\w+) (\d+)", ecu.err)}

    def test_noise_and_foreign_frames_are_ignored_and_counted(self):
        # Extended identifiers, any length, classic and FD.
        counts = self.beside(["-g", "1", "-I", "r", "-e"], ["-g", "1", "-I", "r", "-e", "-f"])
        self.assertGreater(counts["foreign"], 5)

    def test_our_identifiers_with_other_lengths_change_nothing(self):
        # teeth, time, edge
        counts = self.beside(["-g", "1", "-I", "A0", "-L", "5"], ["-g", "1", "-I", "A1", "-L", "3"], ["-g", "1", "-I", "B0", "-L", "8"])
        self.assertGreater(counts["malformed"], 5)
        self.assertGreater(json.loads((self.folder / "noisy" / "summary.json").read_text())["bus"]["malformed"], 0)

    def test_python_can_sets_a_parameter(self):
        self.ecu()
        bus = can.Bus("vcan0", interface="socketcan", fd=True)
        self.addCleanup(bus.shutdown)
        request, answered = DBC.get_message_by_name("parameter_request"), DBC.get_message_by_name("parameter").frame_id
        for command, index, value, result, holds in (("set", "torque_harmonics", 7, "ok", 7),
                                                     ("set", "misfire_cyclic_variation", 9, "out_of_range", 0.2),
                                                     ("set", "firing_torque_change", 30, "at_start", 10), ("restore", "all", 0, "ok", 0),
                                                     ("read", "torque_harmonics", 0, "ok", 5)):
            data = request.encode({"command": command, "index": index, "value": value})
            bus.send(can.Message(arbitration_id=request.frame_id, data=data, is_extended_id=False))
            message = None
            while message is None or message.arbitration_id != answered:
                message = bus.recv(PATIENCE_S)
                self.assertIsNotNone(message, "no answer")
            answer = DBC.decode_message(answered, message.data)
            self.assertEqual((answer["command"], answer["index"], answer["result"]), (command, index, result))
            self.assertAlmostEqual(answer["value"], holds, places=6)


if __name__ == "__main__":
    unittest.main()
