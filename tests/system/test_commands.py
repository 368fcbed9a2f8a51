#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Every command of sixdeg, as the docs write it: each is run, shortened where it would take long. And `-` as a file."""
import json
import os
import pathlib
import re
import shlex
import subprocess
import sys
import unittest

from motored_engine import Motored
from sixdeg_test import Folder

ROOT = pathlib.Path(__file__).resolve().parents[2]
SIXDEG = os.environ["SIXDEG"]
DATA = ROOT / "host_sim" / "data"
SCENARIO = (f'engine = "{DATA}/engines/diesel_22.toml"\n[run]\ncycles = 60\n[speed]\nrpm = 1500\n[load]\nbmep_bar = 5\n'
            "[cyclic]\ncov_percent = 5\n[misfires]\none_in = 10\n")
# What the docs leave to the reader.
PLACES = {"SCENARIO.toml": "scenario.toml", "ENGINE.toml": str(DATA / "engines/diesel_22.toml"), "TUNE.toml": "tune.toml",
          "MODEL.toml": str(DATA / "models/turbo_si_13.toml"), "SUMMARY.json": "summary.json", "FIELD=V,V,...": "speed.rpm=1000",
          "COLUMN": "pressure", "FROM:TO": "0:99", "speed.rpm=N": "speed.rpm=1500", "run.cycles=N": "run.cycles=3",
          "elastic.stiffness_percent=S": "elastic.stiffness_percent=0", "DIR": "out",
          'engine="../engines/NAME.toml"': 'engine="../engines/eight_diesel.toml"',
          "cylinders.fuel_percent=[-25,0,...]": "cylinders.fuel_percent=[-25,0,0,0,0,0,0,0]"}
# Where a command is one of many cases, the rest of it is as good shorter.
SHORTER = {"run": ["--nominal", "--set", "run.cycles=3"], "plant": ["--nominal", "--set", "run.cycles=3"],
           "sweep": ["--nominal", "--set", "run.cycles=3", "--jobs", "1"], "study afr": ["--seeds", "1", "--cases", "1"],
           "study loop": ["--seeds", "1"], "study observers": ["--cycles", "60", "--rpm", "1500", "--bar", "1"],
           "study trips": ["--trips", "2"], "study gas": ["--set", "run.duration_s=0.5"],
           "study engines": ["--engines", "1"], "study identify": ["--engines", "1"],
           "study misfire": ["--engines", "1", "--cycles", "40", "--rpm", "1500", "--bar", "1"],
           "study driveline": ["--seconds", "10"], "study airpath": ["--runs", "10", "--hours", "0.1"],
           "bench": ["--seconds", "0.0005", "--repetitions", "1"]}
ONE_PART = {"study afr": "blame", "study loop": "rest", "study driveline": "figure-6", "study misfire": "rigid",
            "study engines": "one-speed", "study airpath": "decoupling"}


def help_of(path):
    return subprocess.run([SIXDEG, *path, "--help"], capture_output=True, text=True, check=True).stdout


def leaves(path=()):
    """Every command that is no group, as a tuple of words, with its help."""
    text = help_of(path)
    names = re.findall(r"^  ([a-z]\S*)", text.partition("Options:")[2], re.M)
    found = {} if names else {path: text}
    for name in names:
        found.update(leaves((*path, name)))
    return found


def without_options(text):
    """The text without its [optional parts], which begin a word; [1,2] within a word is a value."""
    while (start := re.search(r"(?<!\S)\[", text)):
        depth, end = 1, start.end()
        while depth:
            depth += {"[": 1, "]": -1}.get(text[end], 0)
            end += 1
        text = text[:start.start()] + re.sub(r"^\.\.\.", "", text[end:])
    return text


def commands_in(text):
    """All that a page of the docs has of `sixdeg ...`, a list of words each."""
    found = [" ".join(c.split()) for c in re.findall(r"`((?:[^`\n]+\n?){1,3})`", text)]
    for block in re.findall(r"(?:^ {4}.+\n)+", text, re.M) + re.findall(r"^```\w*\n(.*?)^```", text, re.M | re.S):
        found += re.sub(r"\n\s+--", " --", block).split("\n")
    for line in found:
        if (command := re.search(r"(?:^\s*|(?<=/)|(?<= ))sixdeg (?=[a-z])(.*)", line)) and not line.strip().startswith("#"):
            yield shlex.split(without_options(command.group(1)), comments=True)


class Docs(Folder):
    @classmethod
    def setUpClass(cls):
        cls.leaves = leaves()

    def setUp(self):
        super().setUp()
        (self.folder / "host_sim").symlink_to(ROOT / "host_sim")
        (self.folder / "scenario.toml").write_text(SCENARIO)
        (self.folder / "tune.toml").write_text("[torque]\nharmonics = 5\n")
        self.done = set()  # what ran in this folder: shortened, some commands of the docs are the same
        subprocess.run([sys.executable, ROOT / "tools/trace/make_trace.py", self.folder / "trace.csv"], check=True)
        Motored(DATA / "engines/diesel_22.toml", 0.21, 1.2).write(self.folder / "motored.csv", cycles=8)
        self.ran(["run", "scenario.toml", "--nominal", "--json", "summary.json"])

    def ran(self, words):
        """Runs it in the test's folder. Over a bus it goes no further than to the bus, which is not there."""
        words = list(words)
        status, reason = 0, ""
        if "--transport" in words:
            at = words.index("--transport") + 1
            words[at], status, reason = "nowhere", 2, "nowhere"
        if tuple(words) in self.done:
            return
        done = subprocess.run([SIXDEG, *words], capture_output=True, text=True, cwd=self.folder, timeout=120)
        self.assertEqual(done.returncode, status, f"{words}: {done.stderr}")
        self.assertIn(reason, done.stderr)
        self.done.add(tuple(words))

    def checked(self, words):
        """The command that the words are, after running it; None where they only name one, whose options are looked up then."""
        path = next((tuple(words[:n]) for n in (2, 1) if tuple(words[:n]) in self.leaves), None)
        if path is None:
            self.assertIn(tuple(words[:1]), {leaf[:1] for leaf in self.leaves}, words)
            return None
        rest, text, name = words[len(path):], self.leaves[path], " ".join(path)
        rest = [str(ROOT / word) if word.startswith("../shared/") else word for word in rest]
        recordings_there = all(pathlib.Path(word).exists() for word in rest if word.startswith(str(ROOT / "..")))
        required = re.findall(r"^  (\S+) .*REQUIRED", text, re.M)
        positional = bool(rest) and not rest[0].startswith("--")
        if not recordings_there or any(r not in rest if r.startswith("--") else not positional for r in required):
            for option in (w for w in rest if w.startswith("--")):
                self.assertRegex(text, rf"(?m)^  {option}\b", words)
            return None
        for placeholder, value in PLACES.items():
            rest = [value if word == placeholder else word for word in rest]
        rest = [re.sub(r"^([a-z.=]+[^,\[\]]*),[^\[\]]*$", r"\1", word) if before == "--over" else word.split("|")[0]
                for before, word in zip([""] + rest, rest)]
        recordings = {("replay",): "trace.csv", ("identify",): "motored.csv"}
        rest = [recordings.get(path, w) if w == "FILE" else w for w in rest]
        shorter = SHORTER.get(name, [])
        if "run.cycles=3" in shorter and "duration_s" in (self.folder / rest[0]).read_text():
            shorter = [w.replace("run.cycles=3", "run.duration_s=0.5") for w in shorter]
        for i, word in enumerate(rest):  # an option stands once, but for --set
            if word and word.startswith("--") and word in shorter and word != "--set":
                rest[i:i + (1 if word == "--nominal" else 2)] = [None] * (1 if word == "--nominal" else 2)
        rest = [w for w in rest if w is not None]
        self.ran([*path, *([] if positional or name not in ONE_PART else [ONE_PART[name]]), *rest, *shorter])
        return path

    def test_help_begins_with_an_example_of_every_command_that_runs(self):
        examples = re.findall(r"e\.g\. sixdeg (.+)", help_of(()))
        self.assertEqual({words.split()[0] for words in examples}, {leaf[0] for leaf in self.leaves})
        for words in examples:
            with self.subTest(example=words):
                self.assertIsNotNone(self.checked(words.split()))

    def test_every_command_runs_as_the_docs_write_it(self):
        run = set()
        done = []
        for page in [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]:
            for words in commands_in(page.read_text()):
                if words in done:
                    continue
                done.append(words)
                with self.subTest(page=page.name, command=" ".join(words)):
                    run.add(self.checked(words))
        self.assertEqual(set(self.leaves) - run, set(), "commands that no page of the docs shows in full")


class StandardOutput(Folder):
    def out(self, *words, status=0):
        done = subprocess.run([SIXDEG, *map(str, words)], capture_output=True, cwd=self.folder, timeout=120)
        self.assertEqual(done.returncode, status, done.stderr)
        self.assertEqual(list(self.folder.glob("-*")), [])
        self.assertTrue(done.stderr)  # the words for people
        return done.stdout

    def test_a_file_named_minus_goes_to_standard_output_alone(self):
        engine, model = DATA / "engines/diesel_22.toml", DATA / "models/satellite_orbit.toml"
        scenario = self.folder / "scenario.toml"
        scenario.write_text(SCENARIO)
        log = self.out("run", scenario, "--nominal", "--set", "run.cycles=3", "--record", "-")
        (self.folder / "kept.sdlog").write_bytes(log)
        for words in (["calibrate", engine, "--out", self.folder / "page"], ["run", scenario, "--nominal"], ["sensors", model],
                      ["replay", self.folder / "kept.sdlog"], ["study", "observers"], ["bench", *SHORTER["bench"]]):
            for option in (["--json", "-"], ["--json=-"]):
                with self.subTest(command=words, option=option):
                    self.assertIsInstance(json.loads(self.out(*words, *option)), dict)
        self.out("run", scenario, "--nominal", "--learn", "-")

    def test_a_folder_cannot_be_minus(self):
        for words in (["calibrate", "none.toml"], ["run", "none.toml"], ["replay", "none.csv"], ["sweep", "none.toml", "--over", "seed=1"],
                      ["watch", "--transport", "lcm"]):
            with self.subTest(command=words):
                self.assertEqual(self.out(*words, "--out", "-", status=2), b"")


if __name__ == "__main__":
    unittest.main()
