#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""sixdeg replay and calibrate as a user meets them: figures on the real recordings, files, errors."""
import hashlib
import json
import os
import pathlib
import subprocess
import unittest

from sixdeg_test import Folder, table

ROOT = pathlib.Path(__file__).resolve().parents[2]
SIXDEG = os.environ["SIXDEG"]
ENGINES = ROOT / "host_sim" / "data" / "engines"
RECORDINGS = ROOT.parent / "shared" / "data"


def sixdeg(*arguments):
    return subprocess.run([SIXDEG, *map(str, arguments)], capture_output=True, text=True, timeout=120)


def square_wheel(path, revolutions=20, rpm=1500.0, missing=2, positions=60):
    """A constant-speed wheel as an event list: falling edge at each tooth, back up half a pitch later."""
    pitch = 60 / rpm / positions
    rows = ["time_s,crank", "0,1"]
    for k in range(revolutions * positions):
        if k % positions < positions - missing:
            rows += [f"{0.01 + k * pitch:.9f},0", f"{0.01 + (k + 0.5) * pitch:.9f},1"]
    path.write_text("\n".join(rows) + "\n")


class RealRecordings(Folder):
    def replay(self, name, *options):
        if not (RECORDINGS / name).exists():
            self.skipTest(f"{name} is not here")
        done = sixdeg("replay", RECORDINGS / name, "--out", self.folder / "out", *options)
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads((self.folder / "out" / "summary.json").read_text()), done.stdout

    def test_vw_aba(self):
        summary, printed = self.replay("real_60-2_vw_aba.csv")
        self.assertIn("60-2, falling, gap ratio 3.3", printed)
        self.assertEqual(summary["edges"], 2577)
        self.assertEqual(summary["sync_losses"], 0)
        self.assertLessEqual(summary["first_sync_edge"], 121, "the edge after the second gap")
        self.assertAlmostEqual(summary["rpm_last"], 1688, delta=3)
        self.assertEqual(summary["guess"]["cam_column"], 2)
        self.assertEqual(summary["faults_coasted"], 0)

    def test_vw_aba_with_its_engine_knows_the_cylinders(self):
        summary, _ = self.replay("real_60-2_vw_aba.csv", "--engine", ENGINES / "vw_aba.toml")
        self.assertIn("crank.inertia_kgm2", summary["engine"]["guessed"])
        rows = table(self.folder / "out" / "cycles.csv")
        self.assertGreater(sum(r["fourier_health"] == "degraded" for r in rows), 20)  # a phase, and no intake pressure
        self.assertIn("no intake pressure", " ".join(summary["assumptions"]))

    def test_single_with_pressure(self):
        summary, printed = self.replay("real_single_pressure_full_load.txt")
        self.assertIn("60-2, rising, gap ratio 3.5", printed)
        self.assertEqual(summary["sync_losses"], 0)
        rows = [r for r in table(self.folder / "out" / "teeth.csv") if r["class"] == "tooth"]
        self.assertGreater(len(rows), 1300)
        zeros = [i for i, r in enumerate(rows) if r["tooth"] == "0"]
        self.assertEqual({b - a for a, b in zip(zeros, zeros[1:])}, {58})

    def test_noisy_36_2(self):
        summary, _ = self.replay("real_36-2_noisy.csv")
        self.assertEqual(summary["guess"]["wheel"], "36-2")
        self.assertLessEqual(summary["sync_losses"], 1)
        self.assertIsNotNone(summary["first_sync_edge"])

    def test_analogue_vr(self):
        summary, _ = self.replay("real_60-2_vr_analog.csv")
        self.assertEqual(summary["guess"]["wheel"], "60-2")
        self.assertEqual(summary["sync_losses"], 0)
        self.assertGreater(summary["revolutions"], 30)


class Output(Folder):
    def setUp(self):
        super().setUp()
        self.wheel = self.folder / "wheel.csv"
        square_wheel(self.wheel)

    def test_one_row_an_edge_and_the_true_speed(self):
        done = sixdeg("replay", self.wheel, "--out", self.folder / "out")
        self.assertEqual(done.returncode, 0, done.stderr)
        summary = json.loads((self.folder / "out" / "summary.json").read_text())
        rows = table(self.folder / "out" / "teeth.csv")
        self.assertEqual(len(rows), 20 * 58)
        self.assertEqual(summary["edges"], len(rows))
        self.assertEqual(list(rows[0])[:9], ["edge", "t_s", "class", "tooth", "angle_deg", "rpm", "accel", "torque_nm", "health"])
        self.assertAlmostEqual(summary["rpm_last"], 1500, delta=0.01)
        self.assertEqual(summary["first_sync_edge"], 116)
        self.assertEqual(summary["revolutions"], 17)
        self.assertEqual({r["class"] for r in rows}, {"unsynced", "tooth"})
        for row in rows[200:]:
            self.assertAlmostEqual(float(row["rpm"]), 1500, delta=1)
            self.assertAlmostEqual(float(row["angle_deg"]) % 360, 6 * int(row["tooth"]), places=3)
            self.assertEqual(row["health"], "valid")
        self.assertEqual(summary["files"][str(self.wheel)], hashlib.sha256(self.wheel.read_bytes()).hexdigest())

    def test_same_input_same_bytes(self):
        contents = []
        for run in ("a", "b"):
            sixdeg("replay", self.wheel, "--out", self.folder / run, "--json", self.folder / f"{run}.json")
            contents.append([(self.folder / run / n).read_bytes() for n in ("summary.json", "teeth.csv", "cycles.csv")] +
                            [(self.folder / f"{run}.json").read_bytes()])
        self.assertEqual(contents[0], contents[1])

    def test_fixed_point_agrees_with_float(self):
        torque = {}
        for number in ("f32", "q31"):
            sixdeg("replay", self.wheel, "--number", number, "--out", self.folder / number)
            torque[number] = [float(r["fourier_nm"]) for r in table(self.folder / number / "teeth.csv") if r["fourier_nm"]]
        self.assertEqual(len(torque["f32"]), len(torque["q31"]))
        self.assertGreater(len(torque["f32"]), 900)
        self.assertLess(max(abs(a - b) for a, b in zip(*torque.values())), 0.001 * 1500)

    def test_set_and_tune_reach_the_firmware(self):
        tune = self.folder / "tune.toml"
        tune.write_text("[torque]\nharmonics = 3\n")
        done = sixdeg("replay", self.wheel, "--tune", tune, "--set", "torque.gain_energy=2.5", "--json", self.folder / "s.json")
        self.assertEqual(done.returncode, 0, done.stderr)
        parameters = json.loads((self.folder / "s.json").read_text())["parameters"]
        self.assertEqual(parameters["torque.harmonics"], 3)
        self.assertEqual(parameters["torque.gain_energy"], 2.5)
        self.assertEqual(parameters["torque.gain_mean"], 0.3)

    def test_calibrate_writes_page_and_source(self):
        done = sixdeg("calibrate", ENGINES / "diesel_22.toml", "--out", self.folder / "page", "--json", self.folder / "f.json")
        self.assertEqual(done.returncode, 0, done.stderr)
        page = (self.folder / "page" / "diesel_22.bin").read_bytes()
        self.assertEqual(page[:4], b"SDC3")
        self.assertEqual(json.loads((self.folder / "f.json").read_text())["sha256"], hashlib.sha256(page).hexdigest())
        source = self.folder / "page" / "diesel_22.c"
        inside = [int(b, 16) for b in source.read_text().split("{")[1].split("}")[0].replace("\n", " ").split(",") if b.strip()]
        self.assertEqual(bytes(inside), page)
        subprocess.run(["gcc", "-std=c11", "-Wall", "-Wextra", "-Werror", "-fsyntax-only", source], check=True)


class Errors(Folder):
    """One line that names file, field and range; status 2; nothing written."""

    def setUp(self):
        super().setUp()
        self.wheel = self.folder / "wheel.csv"
        square_wheel(self.wheel)

    def refused(self, *arguments, says):
        out = self.folder / "out"
        done = sixdeg(*arguments, "--out", out)
        self.assertEqual(done.returncode, 2, done.stderr)
        for word in says:
            self.assertIn(word, done.stderr)
        self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
        self.assertFalse(out.exists())

    def engine(self, old, new):
        path = self.folder / "engine.toml"
        path.write_text((ENGINES / "diesel_22.toml").read_text().replace(old, new, 1))
        return path

    def test_recordings(self):
        self.refused("replay", self.folder / "no.csv", says=["no.csv", "cannot be read"])
        (self.folder / "text.csv").write_text("0,0\n1,one\n")
        self.refused("replay", self.folder / "text.csv", says=["text.csv", "line 2"])
        self.refused("replay", self.wheel, "--column", "7", says=["wheel.csv", "7"])
        self.refused("replay", self.wheel, "--wheel", "60-9", says=["--wheel", "60-9", "12 to 120"])
        self.refused("replay", self.wheel, "--edge", "upward", says=["--edge", "upward", "falling"])

    def test_engine_files(self):
        for old, new, says in (("inertia_kgm2 = 0.25", "inertia_kgm2 = 25", ["crank.inertia_kgm2", "[0.0001, 10] kg m2"]),
                               ("inertia_kgm2 = 0.25", "inertia = 0.25", ["crank.inertia_kgm2", "is missing"]),
                               ("[1, 3, 4, 2]", "[1, 3, 4, 4]", ["cylinders.firing_order"]),
                               ("bore_m = 0.087", 'bore_m = "87 mm"', ["cylinders.bore_m", "not a number"]),
                               ("bore_m = 0.087", "bore_m = nan", ["cylinders.bore_m", "[0.02, 0.5] m"]),
                               ('pattern = "60-2"', 'pattern = "60"', ["wheel.pattern", "like 60-2"]),
                               ("[crank]", "[crank]\nflywheel_kg = 3", ["crank.flywheel_kg", "not a known field"]),
                               ("[crank]", "[crank", ["line"])):
            with self.subTest(new=new):
                engine = self.engine(old, new)
                self.refused("replay", self.wheel, "--engine", engine, says=["engine.toml", *says])
                self.refused("calibrate", engine, says=["engine.toml", *says])

    def test_tunes(self):
        tune = self.folder / "tune.toml"
        for text, says in (("[torque]\nharmonics = 13\n", ["torque.harmonics", "[0, 12]"]),
                           ("[torque]\nharmonics = 2.5\n", ["torque.harmonics", "whole number"]),
                           ("[torque]\ngain_reference = 60\n", ["torque"]),
                           ("[torque]\nharmonic = 5\n", ["torque.harmonic", "not a known field"])):
            tune.write_text(text)
            with self.subTest(text=text):
                self.refused("calibrate", ENGINES / "diesel_22.toml", tune, says=["tune.toml", *says])
        for assignment, says in (("torque.harmonics=99", ["torque.harmonics", "[0, 12]"]), ("torque.harmonics", ["--set"]),
                                 ("torque.nothing=1", ["torque.nothing", "not a known field"])):
            with self.subTest(assignment=assignment):
                self.refused("replay", self.wheel, "--set", assignment, says=says)

    def test_output_that_cannot_be_written(self):
        (self.folder / "file").write_text("in the way")
        done = sixdeg("replay", self.wheel, "--out", self.folder / "file" / "out")
        self.assertEqual(done.returncode, 2)
        self.assertIn("cannot be written", done.stderr)

    def test_usage(self):
        self.assertEqual(sixdeg().returncode, 2)
        self.assertEqual(sixdeg("replay").returncode, 2)
        self.assertEqual(sixdeg("nonsense").returncode, 2)
        self.assertEqual(sixdeg("--help").returncode, 0)
        self.assertEqual(sixdeg("replay", self.wheel, "--number", "f64").returncode, 2)


if __name__ == "__main__":
    unittest.main()
