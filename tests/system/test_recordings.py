#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""A sample of the made recordings: none is read wrongly. All of them: tests/system/recordings.py --count 600."""
import os
import unittest

import recordings

COUNT = 600 if os.environ.get("SD_FULL") else 60


class Recordings(unittest.TestCase):
    def test_none_is_read_wrongly(self):
        words = []
        everything, one_mark = recordings.run_all(COUNT, 2, words.append)
        self.assertEqual(everything["wrong"], 0, words)
        self.assertLessEqual(everything["bad refusal"], COUNT / 300, words)
        self.assertGreater(one_mark.pop("named"), 0.95 * sum(one_mark.values()), words)
        self.assertGreater(one_mark["read"], 0.95 * sum(one_mark.values()), words)


if __name__ == "__main__":
    unittest.main()
