# SPDX-License-Identifier: MIT
"""What every other test here rests on: vcan0 carries CAN FD frames of 64 bytes from one socket to another."""
import unittest

from can_frames import FRAME, can_socket


class Vcan(unittest.TestCase):
    def test_an_fd_frame_there_and_back(self):
        with can_socket() as here, can_socket() as there:
            here.send(FRAME.pack(0x123, 64, 0, 0, 0, bytes(range(64))))
            frame = there.recv(FRAME.size)
            self.assertEqual(FRAME.unpack(frame)[0:2] + FRAME.unpack(frame)[5:], (0x123, 64, bytes(range(64))))
            there.send(FRAME.pack(0x124, 12, 0, 0, 0, bytes(reversed(range(12)))))
            back = FRAME.unpack(here.recv(FRAME.size))
            self.assertEqual((back[0], back[1], back[5][:12]), (0x124, 12, bytes(reversed(range(12)))))


if __name__ == "__main__":
    unittest.main()
