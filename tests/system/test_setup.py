#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""tools/setup beside another package manager: it waits. With an apt-get, dpkg-query and id of the test's own."""
import os
import pathlib
import shutil
import subprocess
import unittest

from sixdeg_test import Folder

ROOT = pathlib.Path(__file__).resolve().parents[2]
LOCKED = "E: Could not get lock /var/lib/apt/lists/lock. It is held by process 7 (apt-get)"


class Setup(Folder):
    def setUp(self):
        super().setUp()
        (self.folder / "tools").mkdir()
        for name in ("setup", "requirements.txt"):
            shutil.copy(ROOT / "tools" / name, self.folder / "tools")
        # The Python packages are there, as the stamp says.
        stamp = self.folder / "build" / "venv" / ".installed"
        stamp.parent.mkdir(parents=True)
        command = 'printf "%s %s" "$(python3 --version)" "$(sha256sum < tools/requirements.txt)"'
        stamp.write_text(subprocess.run(["bash", "-c", command], cwd=self.folder, capture_output=True, text=True, check=True).stdout + "\n")
        self.program("dpkg-query", "exit 1")
        self.program("id", "echo 0")

    def program(self, name, body):
        path = self.folder / "bin" / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(f"#!/bin/sh\n{body}\n")
        path.chmod(0o755)

    def setup_with(self, apt_get, patience_s="60", *options):
        self.program("apt-get", f'echo "$@" >> {self.folder}/called\n{apt_get}')
        environment = dict(os.environ, PATH=f"{self.folder}/bin:{os.environ['PATH']}", SD_SETUP_PAUSE_S="0", SD_SETUP_PATIENCE_S=patience_s)
        done = subprocess.run([self.folder / "tools" / "setup", *options], capture_output=True, text=True, env=environment, timeout=60)
        return done, (self.folder / "called").read_text().splitlines()

    def test_tries_again_until_the_lock_is_free(self):
        done, called = self.setup_with(f'[ $(wc -l < {self.folder}/called) -gt 3 ] || {{ echo "{LOCKED}" >&2; exit 100; }}')
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual([line.split()[-1] for line in called[:4]], ["update"] * 4)
        self.assertIn(" install ", called[4])
        self.assertEqual(len(called), 5)
        self.assertEqual(done.stderr.count("trying again"), 3)

    def test_gives_up_after_its_patience_and_at_once_for_another_fault(self):
        done, called = self.setup_with(f'echo "{LOCKED}" >&2; exit 100', patience_s="0")
        self.assertEqual((done.returncode, len(called)), (100, 1))
        done, called = self.setup_with("echo 'E: Failed to fetch' >&2; exit 100")
        self.assertEqual((done.returncode, len(called)), (100, 2))

    def test_leaves_python_for_later_where_told(self):
        stamp = self.folder / "build" / "venv" / ".installed"
        stamp.write_text("of another day\n")
        done, called = self.setup_with("exit 0", "60", "--cross", "--no-python")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("gcc-arm-none-eabi", called[1])
        self.assertEqual(stamp.read_text(), "of another day\n")


if __name__ == "__main__":
    unittest.main()
