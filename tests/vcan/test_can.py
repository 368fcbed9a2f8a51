#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Plant and ecu as two processes over vcan0, and what befalls such a bus."""
import subprocess
import unittest

from bus_cases import BusCases
from bus_folder import Beats, BusFolder, PATIENCE_S
from can_frames import NAMES, can_socket


class Can(BusCases, BusFolder):
    transport = "can:vcan0"
    new_beats = staticmethod(lambda: Beats(can_socket(NAMES["done"])))

    def flood(self):
        """More than the receive buffer of 8 MB holds, on an identifier nobody takes."""
        subprocess.run(["cangen", "vcan0", "-g", "0", "-i", "-I", "300", "-n", "60000"], check=True, timeout=PATIENCE_S)

    def test_the_interface_goes_down_and_up(self):
        beats, ecu = self.beats(), self.ecu()
        plant, out = self.running_plant()
        beats.wait(60)
        subprocess.run(["ip", "link", "set", "vcan0", "down"], check=True)
        self.addCleanup(subprocess.run, ["ip", "link", "set", "vcan0", "up"])
        plant.expect("the plant goes on without it")
        ecu.expect("the plant is silent")
        subprocess.run(["ip", "link", "set", "vcan0", "up"], check=True)
        plant.expect("the ecu answers again")
        ecu.expect("the plant is back")
        beats = self.beats()
        self.came_back(beats, plant, out)
        self.assertIsNone(ecu.popen.poll())


if __name__ == "__main__":
    unittest.main()
