#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""sixdeg ecu --record over LCM: what the ecu process lived through, replayed; one scenario, whichever way it went."""
import signal
import unittest

import bus_folder
from bus_folder import BusFolder, lcm_beats


class EcuLog(BusFolder):
    transport = "lcm:udpm://239.255.76.67:7667?ttl=0"
    new_beats = staticmethod(lcm_beats)

    def replayed(self, log):
        """Tables of the replay; the log's own outputs must come out again."""
        out = self.folder / f"{log.name}_replayed"
        self.assertGreater(self.replays(log, "--out", out)["outputs"]["recorded"], 10000)
        return [(out / name).read_bytes() for name in ("cycles.csv", "teeth.csv")]

    def test_logs_of_one_process_of_the_plant_and_of_the_ecu_give_the_same_tables(self):
        scenario, logs = self.scenario(), [self.folder / name for name in ("one", "plant", "ecu")]
        self.sixdeg("run", scenario, "--nominal", "--record", logs[0])
        ecu = self.ecu("--record", logs[2])
        self.sixdeg("plant", scenario, "--transport", self.transport, "--record", logs[1])
        ecu.end()
        expected = self.replayed(logs[0])
        for log in logs[1:]:
            with self.subTest(log=log.name):
                self.assertEqual(self.replayed(log), expected)

    def test_a_parameter_set_on_the_way_is_part_of_the_stream(self):
        beats, ecu = self.beats(), self.ecu("--record", self.folder / "ecu.sdlog")
        plant, _ = self.running_plant()
        beats.wait(100)
        for assignment in ("torque.harmonics=8", "misfire.work_per_fuel=15", "balance.integral_gain=0.2", "firing.enabled=0",
                           "firing.enabled=1"):
            self.sixdeg("parameter", "set", assignment, "--transport", self.transport)
            beats.wait(20)
        plant.kill()  # and the ecu carries on with a new one
        self.sixdeg("plant", self.scenario("cycles = 20", rpm=2000), "--transport", self.transport)
        self.assertEqual(ecu.end(signal.SIGINT), 0)
        self.replayed(self.folder / "ecu.sdlog")


if __name__ == "__main__":
    bus_folder.in_own_network()
    unittest.main()
