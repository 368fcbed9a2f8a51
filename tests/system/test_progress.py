#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""What a long command shows of its progress: a line that a terminal alone sees, redrawn, gone at the end; nothing of it in any output."""
import os
import pathlib
import pty
import re
import subprocess
import sys
import time
import unittest

from sixdeg_test import Folder

ROOT = pathlib.Path(__file__).resolve().parents[2]
SIXDEG = pathlib.Path(os.environ["SIXDEG"])
SCENARIO = ROOT / "host_sim/data/scenarios/balance_1000rpm_5bar.toml"


def on_terminal(words, **output):
    """Exit status, and all that the terminal got; stderr is a terminal, stdout too where it is not given."""
    ours, theirs = pty.openpty()
    process = subprocess.Popen(words, stdin=subprocess.DEVNULL, stderr=theirs, **({"stdout": theirs} | output))
    os.close(theirs)
    got = b""
    try:
        while piece := os.read(ours, 65536):
            got += piece
    except OSError:  # Linux says so when the other end is closed
        pass
    os.close(ours)
    return process.wait(), got.decode()


def seen(transcript):
    """The lines that stand on the terminal in the end."""
    lines = [""]
    for part in re.split(r"(\r\n|\r\033\[K)", transcript):
        if part == "\r\n":
            lines.append("")
        elif part == "\r\033[K":
            lines[-1] = ""
        else:
            lines[-1] += part
    return "\n".join(lines)


def shares(transcript):
    return [int(share) for share in re.findall(r"\[#*\.*\] (\d+) %", transcript)]


def without_pace(text):
    return re.sub(r", [\d.]+ times real time", "", text)


def run_of(cycles):
    return [SIXDEG, "run", SCENARIO, "--nominal", "--set", f"run.cycles={cycles}"]


class Programs(Folder):
    """The line comes after a second, so a run must last longer than that on this machine, however fast it is."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        began = time.monotonic()
        subprocess.run(run_of(1000), capture_output=True, check=True)
        cls.RUN = run_of(int(1000 * max(1, 3 / (time.monotonic() - began))))

    def test_a_bar_grows_and_is_gone_at_the_end(self):
        status, transcript = on_terminal(self.RUN)
        self.assertEqual(status, 0)
        grown = shares(transcript)
        self.assertGreater(len(set(grown)), 2, transcript)
        self.assertEqual(grown, sorted(grown))
        self.assertRegex(transcript, r"\r\033\[Krun: simulating \[#+\.+\] \d+ %, \d+ s left")
        plain = subprocess.run(self.RUN, capture_output=True, text=True, check=True)
        self.assertEqual(without_pace(seen(transcript)), without_pace(plain.stdout), "the terminal shows what a file gets, and no more")
        self.assertEqual(plain.stderr, "", "no terminal, no progress")

    def test_a_file_gets_nothing_of_it(self):
        with open(self.folder / "out", "wb") as out:
            status, transcript = on_terminal(self.RUN, stdout=out)
        self.assertEqual(status, 0)
        self.assertGreater(len(shares(transcript)), 2)
        self.assertEqual(seen(transcript), "")
        self.assertNotIn("\033", (self.folder / "out").read_text())

    def test_rows_that_come_meanwhile_stand_above_it(self):
        words = [SIXDEG, "study", "driveline", "drive", "--seconds", "30"]
        status, transcript = on_terminal(words)
        self.assertEqual(status, 0)
        self.assertRegex(transcript, r"study driveline: row \d+ of \d+ \[")
        plain = subprocess.run(words, capture_output=True, text=True, check=True)
        self.assertEqual(seen(transcript), plain.stdout)


class Tools(Folder):
    def test_a_tool_in_python_draws_the_same_line(self):
        script = self.folder / "tool.py"
        script.write_text(f"""import sys, time
sys.path.insert(0, {str(ROOT / 'tools')!r})
import progress
for i in progress.over(range(4), "tool: piece"):
    time.sleep(0.5)
    print("done", i)
""")
        status, transcript = on_terminal([sys.executable, script])
        self.assertEqual(status, 0)
        self.assertRegex(transcript, r"tool: piece [34] of 4 \[#+\.+\] \d+ %, \d s left")
        self.assertEqual(seen(transcript), "done 0\ndone 1\ndone 2\ndone 3\n")
        plain = subprocess.run([sys.executable, script], capture_output=True, text=True, check=True)
        self.assertEqual((plain.stdout, plain.stderr), ("done 0\ndone 1\ndone 2\ndone 3\n", ""))


if __name__ == "__main__":
    unittest.main()
