#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""sixdeg run with pages kept from before: the same bytes as without, whatever lies in the folder."""
import json
import os
import pathlib
import shutil
import subprocess
import unittest

from sixdeg_test import Folder

ROOT = pathlib.Path(__file__).resolve().parents[2]
SIXDEG = os.environ["SIXDEG"]
ENGINES = ROOT / "host_sim" / "data" / "engines"
MOST_PAGES = 64


class KeptPages(Folder):
    def setUp(self):
        super().setUp()
        self.cache = self.folder / "cache"
        self.engine = self.folder / "engine.toml"
        shutil.copy(ENGINES / "single_generator.toml", self.engine)
        self.scenario = self.folder / "scenario.toml"
        self.scenario.write_text('engine = "engine.toml"\n[run]\ncycles = 12\n[speed]\nrpm = 1500\n[load]\nbmep_bar = 2\n')

    def command(self, out, *options):
        return [SIXDEG, "run", str(self.scenario), "--nominal", "--out", str(self.folder / out), *map(str, options)]

    def run_once(self, *options):
        """All that the run wrote, but for the time that it took."""
        done = subprocess.run(self.command("out", *options), capture_output=True, text=True, timeout=120, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        return self.written("out")

    def written(self, out):
        files = {path.name: path.read_text() for path in (self.folder / out).iterdir()}
        summary = json.loads(files.pop("summary.json"))
        del summary["realtime_factor"]
        return summary, files

    def pages(self):
        return sorted(self.cache.glob("*.page")) if self.cache.exists() else []

    def test_a_kept_page_gives_the_same_bytes_as_one_made_anew(self):
        anew = self.run_once("--no-cache")
        self.assertEqual(self.run_once("--cache", self.cache), anew)
        (page,) = self.pages()
        made = page.stat().st_ino
        self.assertEqual(self.run_once("--cache", self.cache), anew)
        self.assertEqual([p.stat().st_ino for p in self.pages()], [made])  # read, not written again

    def test_another_tune_or_engine_text_has_a_page_of_its_own(self):
        first = self.run_once("--cache", self.cache)
        self.run_once("--cache", self.cache, "--set", "firing.edge_sd=0.05")
        self.assertEqual(len(self.pages()), 2)
        self.engine.write_text(self.engine.read_text() + "\n# heavier\n")
        self.run_once("--cache", self.cache)
        self.assertEqual(len(self.pages()), 3)
        self.assertEqual(self.run_once("--cache", self.cache)[1], first[1])

    def test_damaged_cut_empty_and_foreign_pages_are_made_anew(self):
        anew = self.run_once("--cache", self.cache)
        (page,) = self.pages()
        good = page.read_bytes()
        self.run_once("--cache", self.cache, "--set", "firing.edge_sd=0.05")
        (other,) = (p for p in self.pages() if p != page)
        damaged = bytearray(good)
        damaged[len(good) // 2] ^= 1
        for bad in (bytes(damaged), good[:-4], b"", b"no page", other.read_bytes()):
            with self.subTest(size=len(bad)):
                page.write_bytes(bad)
                self.assertEqual(self.run_once("--cache", self.cache), anew)
                self.assertEqual(page.read_bytes(), good)

    def test_runs_at_the_same_time_share_a_folder(self):
        anew = self.run_once("--no-cache")
        running = [subprocess.Popen(self.command(f"out{i}", "--cache", self.cache), stdout=subprocess.DEVNULL) for i in range(4)]
        self.assertEqual([process.wait(timeout=120) for process in running], [0] * 4)
        for i in range(4):
            self.assertEqual(self.written(f"out{i}"), anew)
        self.assertEqual([path.suffix for path in self.cache.iterdir()], [".page"])

    def test_a_folder_that_cannot_be_written_is_no_error(self):
        self.cache.write_text("a file")
        self.assertEqual(self.run_once("--cache", self.cache), self.run_once("--no-cache"))

    def test_so_many_pages_and_no_more(self):
        self.cache.mkdir()
        for i in range(MOST_PAGES + 3):
            old = self.cache / f"{i:064x}.page"
            old.write_text("old")
            os.utime(old, (1000 + i, 1000 + i))
        self.run_once("--cache", self.cache)
        left = {page.name for page in self.pages()}
        self.assertEqual(len(left), MOST_PAGES)
        self.assertNotIn(f"{3:064x}.page", left)  # the oldest went
        self.assertIn(f"{4:064x}.page", left)

    def test_usual_folder_is_that_of_the_base_directories(self):
        home = self.folder / "home"
        for name, where in (("XDG_CACHE_HOME", home / "sixdeg"), ("HOME", home / ".cache" / "sixdeg")):
            with self.subTest(name):
                environment = {key: value for key, value in os.environ.items() if key not in ("XDG_CACHE_HOME", "HOME")}
                environment[name] = str(home)
                subprocess.run(self.command("out"), env=environment, check=True, stdout=subprocess.DEVNULL, timeout=120)
                self.assertEqual(len(list(where.glob("*.page"))), 1)


if __name__ == "__main__":
    unittest.main()
