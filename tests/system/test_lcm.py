#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Plant and ecu as two processes over LCM, and LCM's own logger and player."""
import os
import pathlib
import signal
import subprocess
import time
import unittest

import bus_test
from bus_test import BusCases, BusFolder, ENGINE

URL = "udpm://239.255.76.67:7667?ttl=0"


class Lcm(BusCases, BusFolder):
    transport = "lcm:" + URL

    @unittest.skipUnless(os.environ.get("SD_FULL"), "a busy machine loses messages at this pace; test_ecu_log has the same at that of time")
    def test_a_log_of_lcms_own_logger_played_to_a_fresh_ecu(self):
        log = self.folder / "lcm.log"
        logger = subprocess.Popen(["lcm-logger", "--quiet", f"--lcm-url={URL}", log])
        self.processes.append(logger)
        time.sleep(0.5)
        self.sixdeg("run", self.scenario(), "--transport", self.transport, "--out", self.folder / "run")
        time.sleep(0.5)
        logger.send_signal(signal.SIGTERM)
        logger.wait()
        self.ecu()
        watch = self.start("watch", "--transport", self.transport, "--engine", ENGINE, "--out", self.folder / "played")
        time.sleep(0.5)
        # It ends with status 1 when all is played.
        subprocess.run(["lcm-logplayer", f"--lcm-url={URL}", "--regexp=SIXDEG_(INPUTS|TRUTH)", log], capture_output=True, timeout=60)
        out, _ = watch.communicate(timeout=60)
        self.assertIn("truth lost 0, edges without an answer 0", out)
        self.assertEqual(self.csv_bytes("run"), self.csv_bytes("played"))

    def test_what_is_no_bus_is_said_in_one_line(self):
        for transport, says in (("canal", "can:IFACE"), ("can:none0", "no"), ("lcm:nonsense", "LCM cannot use this")):
            done = self.sixdeg("ecu", ENGINE, "--transport", transport, status=2)
            self.assertIn(says, done.stderr.replace("this kernel has no CAN", "no"))
            self.assertIn(transport.split(":")[0], done.stderr)


if __name__ == "__main__":
    bus_test.in_own_network()
    unittest.main()
