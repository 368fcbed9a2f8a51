#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Plant and ecu as two processes over LCM."""
import os
import pty
import re
import select
import socket
import subprocess
import unittest

import bus_folder
from bus_cases import BusCases
from bus_folder import BusFolder, ENGINE, PATIENCE_S, SIXDEG, lcm_beats

URL = "udpm://239.255.76.67:7667?ttl=0"


class Lcm(BusCases, BusFolder):
    transport = "lcm:" + URL
    new_beats = staticmethod(lcm_beats)

    def flood(self):
        """More than any receive buffer holds, on a channel nobody takes."""
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as out:
            out.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 0)
            for sequence in range(20000):
                out.sendto(b"LC02" + sequence.to_bytes(4, "big") + b"NOISE\0" + bytes(1000), ("239.255.76.67", 7667))

    def test_the_live_view_is_redrawn_in_a_terminal(self):
        ours, theirs = pty.openpty()
        watch = subprocess.Popen([SIXDEG, "watch", "--transport", self.transport], stdout=theirs, stderr=subprocess.DEVNULL)
        self.addCleanup(watch.wait)
        self.addCleanup(watch.kill)
        os.close(theirs)
        self.ecu()
        self.running_plant()
        seen = b""
        # Torque beside the mean of all, then the misfire index beside its limit.
        bars = rb"\n4 +\d+\.\d +-\d+\.\d% #[# ]*\| *healthy +\d\.\d\d #+\|#+ "
        while seen.count(b"\033[H\033[J") < 3 or not re.search(bars, seen):
            self.assertTrue(select.select([ours], [], [], PATIENCE_S)[0], seen)
            seen += os.read(ours, 65536)
        os.close(ours)

    def test_what_is_no_bus_is_said_in_one_line(self):
        for transport, says in (("canal", "can:IFACE"), ("can:none0", "no"), ("lcm:nonsense", "LCM cannot use this")):
            done = self.sixdeg("ecu", ENGINE, "--transport", transport, status=2)
            self.assertIn(says, done.err.replace("this kernel has no CAN", "no"))
            self.assertIn(transport.split(":")[0], done.err)


if __name__ == "__main__":
    bus_folder.in_own_network()
    unittest.main()
