#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""LCM's own logger and player around a run in lock-step. The logger queues 30 messages and drops the rest, so the run is
slowed down; and it is here, because in the CAN guest all share one CPU and none is late on its own."""
import pathlib
import subprocess
import time
import unittest

import bus_folder
from bus_folder import PATIENCE_S, BusFolder, ENGINE, MIXTURE, until

URL = "udpm://239.255.76.67:7667?ttl=0"


def listeners():
    """Sockets at LCM's port."""
    return sum(line.split()[1].endswith(":1DF3") for line in pathlib.Path("/proc/net/udp").read_text().splitlines()[1:])


class LcmLog(BusFolder):
    transport = "lcm:" + URL

    def test_a_log_of_lcms_own_logger_played_to_a_fresh_ecu(self):
        """What is lost all the same is told; the run is logged again then."""
        scenario, log = self.scenario(more=MIXTURE), self.folder / "lcm.log"
        for _ in range(3):
            before = listeners()
            logger = self.process("lcm-logger", "--quiet", "--force", f"--lcm-url={URL}", log)
            until(lambda: listeners() > before, "lcm-logger")
            self.sixdeg("run", scenario, "--transport", self.transport, "--pace", "2", "--out", self.folder / "run")
            size = -1
            while size != (size := log.stat().st_size):  # it still writes
                time.sleep(0.5)
            logger.end()
            ecu = self.ecu()
            watch = self.watch("--engine", ENGINE, "--out", self.folder / "played")
            # The player ends with status 1 when all is played.
            subprocess.run(["lcm-logplayer", f"--lcm-url={URL}", "--regexp=SIXDEG_(INPUTS|TRUTH)", log], capture_output=True,
                           timeout=PATIENCE_S)
            try:
                watch.wait(20)
            except subprocess.TimeoutExpired:  # the end of the run was lost
                watch.kill()
            ecu.end()
            if "truth lost 0, edges without an answer 0" in watch.out:
                break
        self.assertIn("truth lost 0, edges without an answer 0", watch.out)
        self.assertEqual(self.csv_bytes("run"), self.csv_bytes("played"))


if __name__ == "__main__":
    bus_folder.in_own_network()
    unittest.main()
