#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""sixdeg ecu --record over LCM: what the ecu process lived through, replayed; one scenario, whichever way it went."""
import json
import signal
import subprocess
import time
import unittest

import bus_test
from bus_test import BusFolder

URL = "udpm://239.255.76.67:7667?ttl=0"


class EcuLog(BusFolder):
    transport = "lcm:" + URL

    def replay(self, log):
        """Tables of the replay; the log's own outputs must come out again."""
        out = self.folder / f"{log.name}_replayed"
        self.sixdeg("replay", log, "--out", out)
        summary = json.loads((out / "summary.json").read_text())
        self.assertTrue(summary["outputs"]["identical"], summary["outputs"])
        self.assertGreater(summary["outputs"]["recorded"], 10000)
        return [(out / name).read_bytes() for name in ("cycles.csv", "teeth.csv")]

    def test_one_process_lcm_and_lcms_own_log_in_a_fresh_ecu(self):
        scenario, logs = self.scenario(), [self.folder / name for name in ("one", "plant", "ecu", "played")]
        self.sixdeg("run", scenario, "--nominal", "--record", logs[0])
        recorder = subprocess.Popen(["lcm-logger", f"--lcm-url={URL}", self.folder / "lcm.log"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.processes.append(recorder)
        time.sleep(0.5)
        ecu = self.ecu("--record", logs[2])
        self.sixdeg("plant", scenario, "--transport", self.transport, "--real-time", "--record", logs[1])
        self.end(ecu)
        time.sleep(0.5)
        self.end(recorder)
        fresh = self.ecu("--record", logs[3])
        subprocess.run(["lcm-logplayer", f"--lcm-url={URL}", "--regexp=SIXDEG_INPUTS", self.folder / "lcm.log"], check=True, capture_output=True, timeout=60)
        time.sleep(0.5)
        self.end(fresh)
        expected = self.replay(logs[0])
        for log in logs[1:]:
            with self.subTest(log=log.name):
                self.assertEqual(self.replay(log), expected)

    def test_a_parameter_set_on_the_way_is_part_of_the_stream(self):
        ecu = self.ecu("--record", self.folder / "ecu.sdlog")
        plant = self.start("plant", self.scenario("duration_s = 600", rpm=3000), "--transport", self.transport, "--real-time")
        time.sleep(1.5)
        self.sixdeg("parameter", "set", "torque.harmonics=8", "--transport", self.transport)
        time.sleep(1)
        plant.kill()  # and the ecu carries on with a new one
        plant.communicate()
        self.sixdeg("plant", self.scenario("cycles = 20", rpm=2000), "--transport", self.transport, "--real-time")
        self.end(ecu, signal.SIGINT)
        self.assertEqual(ecu.returncode, 0)
        self.replay(self.folder / "ecu.sdlog")


if __name__ == "__main__":
    bus_test.in_own_network()
    unittest.main()
