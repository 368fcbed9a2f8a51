#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""candump's frames, decoded by cantools, against the tables of the run; frames of our name and not our length."""
import json
import re
import signal
import subprocess
import time
import unittest

import cantools

from bus_test import BusFolder, ROOT
from sixdeg_test import table

DBC = cantools.database.load_file(ROOT / "hal" / "generated" / "sixdeg.dbc")


class Clients(BusFolder):
    transport = "can:vcan0"

    def test_what_candump_and_cantools_read_is_what_the_run_wrote(self):
        log = self.folder / "dump.log"
        with log.open("w") as file:  # and a buffer for all of it: the run does not wait for whoever listens
            dump = subprocess.Popen(["candump", "-L", "-r", "8388608", "vcan0"], stdout=file)
        self.processes.append(dump)
        time.sleep(0.3)
        self.sixdeg("run", self.scenario("cycles = 12"), "--transport", self.transport, "--out", self.folder / "run")
        time.sleep(1)
        dump.send_signal(signal.SIGINT)
        dump.wait(30)
        teeth, rows = table(self.folder / "run" / "teeth.csv"), {}
        for line in log.read_text().splitlines():
            identifier, data = re.match(r"\(.*\) vcan0 ([0-9A-F]{3})##?(.*)", line).groups()
            message = DBC.get_message_by_frame_id(int(identifier, 16))
            if message.name.startswith("edge"):  # the signals of a tooth, in as many frames as they need
                values = message.decode(bytes.fromhex(data[1:]))
                rows.setdefault(values["tick"], {}).update(values)
        self.assertEqual(len(rows), len(teeth))
        known = 0
        for heard, written in zip(rows.values(), teeth):
            self.assertEqual(str(heard["crank_health"]), written["health"])
            if written["torque_nm"]:
                self.assertAlmostEqual(heard["torque_mass"], float(written["torque_nm"]), delta=0.0006)
                self.assertEqual(heard["crank_tooth"], float(written["tooth"]))
                known += 1
        self.assertGreater(known, 1000)

    def test_our_identifiers_with_other_lengths_change_nothing(self):
        scenario = self.scenario("cycles = 12")
        self.sixdeg("run", scenario, "--nominal", "--out", self.folder / "quiet")
        ecu = self.ecu()
        for noise in (["-I", "A0", "-L", "5"], ["-I", "A1", "-L", "3"], ["-I", "B0", "-L", "8"]):  # teeth, time, edge
            self.processes.append(subprocess.Popen(["cangen", "vcan0", "-g", "2", *noise]))
        self.sixdeg("plant", scenario, "--transport", self.transport, "--out", self.folder / "noisy")
        self.assertEqual(self.csv_bytes("quiet"), self.csv_bytes("noisy"))
        self.assertGreater(json.loads((self.folder / "noisy" / "summary.json").read_text())["bus"]["malformed"], 10)
        _, errors = self.end(ecu)
        self.assertGreater(int(re.search(r"malformed (\d+)", errors)[1]), 20, errors)


if __name__ == "__main__":
    unittest.main()
