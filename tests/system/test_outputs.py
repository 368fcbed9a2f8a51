#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""What is written where: never over an input, through a device or a FIFO, to what a link names; and how a run that failed ends."""
import json
import os
import stat
import subprocess
import threading
import unittest

from sixdeg_test import Folder, table
from test_replay import ENGINES, sixdeg, square_wheel


class Outputs(Folder):
    def setUp(self):
        super().setUp()
        self.wheel = self.folder / "wheel.csv"
        square_wheel(self.wheel)

    def test_an_input_is_not_written_over(self):
        before = self.wheel.read_bytes()
        link = self.folder / "link.csv"
        link.symlink_to(self.wheel)
        for target in (self.wheel, link):
            done = sixdeg("replay", self.wheel, "--json", target)
            self.assertEqual(done.returncode, 2)
            self.assertIn("is an input of this command", done.stderr)
            self.assertEqual(self.wheel.read_bytes(), before)

    def test_a_link_stays_and_its_file_is_written(self):
        target, link = self.folder / "target.json", self.folder / "link.json"
        target.write_text("old")
        link.symlink_to(target)
        self.assertEqual(sixdeg("replay", self.wheel, "--json", link).returncode, 0)
        self.assertTrue(link.is_symlink())
        self.assertEqual(json.loads(target.read_text())["revolutions"], 17)

    def test_a_name_written_wrongly_is_answered_with_the_nearest(self):
        engine = self.folder / "engine.toml"
        engine.write_text((ENGINES / "diesel_22.toml").read_text().replace("bore_m", "boore_m"))
        for words, meant in ((["rplay", self.wheel], "replay"), (["replay", self.wheel, "--jsno", "x"], "--json"),
                             (["study", "drivelin"], "driveline"), (["replay", self.folder / "whel.csv"], "wheel.csv"),
                             (["calibrate", engine], "cylinders.boore_m"), (["study", "afr", "acuracy"], "accuracy"),
                             (["run", ENGINES.parent / "scenarios/balance_1000rpm_5bar.toml", "--set", "speed.rmp=1000"], "speed.rpm"),
                             (["parameter", "get", "torque.harmonic", "--transport", "lcm"], "torque.harmonics"),
                             (["calibrate", ENGINES / "diesel_22.toml", "--set", "misfire.start_inhibit_cylces=3"],
                              "misfire.start_inhibit_cycles")):
            done = sixdeg(*words)
            self.assertEqual(done.returncode, 2)
            self.assertIn(f"; the nearest is '{meant}'\n", done.stderr)
        self.assertNotIn("nearest", sixdeg("replay", self.folder / "quite_another").stderr)

    def test_a_name_of_before_is_answered_with_the_present_one(self):
        tune = self.folder / "tune.toml"
        tune.write_text("[misfire]\nstart = 3\n")
        for words in (["--set", "misfire.start=3"], [tune]):
            done = sixdeg("calibrate", ENGINES / "diesel_22.toml", *words)
            self.assertEqual(done.returncode, 2)
            self.assertIn("misfire.start: is not a known field; it is called 'misfire.start_inhibit_cycles' now\n", done.stderr)

    def test_a_fifo_is_written_through(self):
        fifo = self.folder / "fifo"
        os.mkfifo(fifo)
        heard = []
        reader = threading.Thread(target=lambda: heard.append(fifo.read_text()))
        reader.start()
        self.assertEqual(sixdeg("replay", self.wheel, "--json", fifo).returncode, 0)
        reader.join(20)
        self.assertTrue(stat.S_ISFIFO(fifo.stat().st_mode))
        self.assertEqual(json.loads(heard[0])["revolutions"], 17)

    def test_a_device_stays_one(self):
        self.assertEqual(sixdeg("replay", self.wheel, "--json", "/dev/null").returncode, 0)
        self.assertTrue(stat.S_ISCHR(os.stat("/dev/null").st_mode))

    def test_a_recording_that_never_synced_has_a_status_of_its_own(self):
        rows = self.wheel.read_text().splitlines()[:2 + 2 * 75]
        self.wheel.write_text("\n".join(rows) + "\n")
        done = sixdeg("replay", self.wheel, "--wheel", "60-2", "--edge", "falling", "--column", "1", "--out", self.folder / "out")
        self.assertEqual(done.returncode, 3, done.stderr)
        self.assertEqual(len(done.stderr.splitlines()), 1)
        self.assertIn("never synced: the recording is short", done.stderr)
        self.assertIn("never synced", json.loads((self.folder / "out" / "summary.json").read_text())["not_followed"])


class Inputs(Folder):
    """What goes in beside teeth."""

    def test_readings_come_from_a_number_a_column_or_a_file(self):
        wheel, other = self.folder / "wheel.csv", self.folder / "map.csv"
        square_wheel(wheel)
        rows = wheel.read_text().splitlines()
        wheel.write_text("\n".join([rows[0] + ",MAP [kPa]"] + [row + ",100" for row in rows[1:]]) + "\n")
        other.write_text("time [s],MAP [kPa]\n0,100\n0.5,100\n1,100\n")
        outs = []
        for i, source in enumerate(("1", "MAP [kPa]", "column:2", f"{other}", f"{other}:1", "2")):
            out = self.folder / f"out{i}"
            done = sixdeg("replay", wheel, "--column", "1", "--engine", ENGINES / "diesel_22.toml", "--parity", "first", "--intake", source,
                          "--out", out)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertNotIn("no intake pressure", done.stdout)
            outs.append([(row["torque_nm"], row["health"]) for row in table(out / "cycles.csv")])
        self.assertIn("valid", [health for _, health in outs[0]])
        self.assertTrue(all(out == outs[0] for out in outs[:5]))
        self.assertNotEqual(outs[0], outs[5])

    def test_a_cam_comes_from_a_column_or_a_file(self):
        rows, edges = ["time [s],crank,cam"], []
        for k in range(40 * 60):
            if k % 60 < 58:
                time, cam = 0.01 + k * 60 / 1500 / 60, 100 <= k % 120 < 110
                rows += [f"{time:.7f},0,{cam:d}", f"{time + 0.0003:.7f},1,{cam:d}"]
                edges += [f"{time:.7f}"] if k % 120 == 100 else []
        both, crank, cam, times = (self.folder / name for name in ("both.csv", "crank.csv", "cam.csv", "times.csv"))
        both.write_text("\n".join(rows) + "\n")
        crank.write_text("\n".join(row.rsplit(",", 1)[0] for row in rows) + "\n")
        cam.write_text("\n".join(row.split(",")[0] + "," + row.split(",")[2] for row in rows) + "\n")
        times.write_text("\n".join(edges) + "\n")
        outs = []
        for recording, source in ((both, "cam"), (both, "column:2"), (crank, cam), (crank, f"{cam}:cam"), (crank, times)):
            out = self.folder / f"cam{len(outs)}"
            done = sixdeg("replay", recording, "--wheel", "60-2", "--edge", "falling", "--engine", ENGINES / "vw_aba.toml",
                          "--cam", source, "--out", out)
            self.assertEqual(done.returncode, 0, done.stderr)
            outs.append((out / "teeth.csv").read_bytes())
            summary = json.loads((out / "summary.json").read_text())
            self.assertEqual(summary["guess"]["cam_teeth"], 1)
            self.assertLessEqual(summary["decoder"]["cam_edges_rejected"], 2, "those before the angle is known")
        self.assertTrue(all(out == outs[0] for out in outs))
        done = sixdeg("replay", crank, "--cam", cam, "--json", cam)
        self.assertEqual(done.returncode, 2)
        self.assertIn("cam.csv", done.stderr)

    def test_bad_sources_are_named(self):
        wheel = self.folder / "wheel.csv"
        square_wheel(wheel)
        for option, value, says in (("--intake", "100", "outside [0.05, 6] bar"), ("--fuel", "no such", "is no column"),
                                    ("--cam", "9", "is no column")):
            done = sixdeg("replay", wheel, option, value)
            self.assertEqual(done.returncode, 2)
            self.assertIn(says, done.stderr)


if __name__ == "__main__":
    unittest.main()
