#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Which revolution of the cycle is which in a recording: cams of several teeth, moving ones, with faults, no cam at all; work of a cycle;
what is learned of one recording and used in the next."""
import csv
import json
import unittest

import numpy as np

from sixdeg_test import Folder
from test_replay import ENGINES, RECORDINGS, sixdeg

PITCH_DEG, FIRST_DEG = 6, 282  # of vw_aba.toml: angle of position 0


def crank_and_cam(path, cam_deg, moves_deg=0.0, lost=(), added_deg=(), turns=60, rpm=1500.0):
    """A 60-2 wheel and cam edges at these angles of the engine's cycle, all in order of time, from cycle position 0 on."""
    events = []
    for k in range(turns * 60):
        if k % 60 < 58:
            events += [(k * PITCH_DEG, 1, 0), (k * PITCH_DEG + 3, 1, 1)]
    for cycle in range(turns // 2):
        for i, deg in enumerate(cam_deg):
            at = cycle * 720 + (deg - FIRST_DEG) % 720 + moves_deg * cycle / (turns // 2)
            if (cycle, i) not in lost:
                events += [(at, 2, 1), (at + 12, 2, 0)]
    events += [(deg, 2, level) for start in added_deg for deg, level in ((start, 1), (start + 5, 0))]
    level, rows = {1: 1, 2: 0}, ["t,crank,cam", "0,1,0"]
    for deg, column, value in sorted(events):
        level[column] = value
        rows.append(f"{0.01 + deg / 6 / rpm:.8f},{level[1]},{level[2]}")
    path.write_text("\n".join(rows) + "\n")


class Replayed(Folder):
    def replay(self, recording, *options):
        out = self.folder / "out"
        done = sixdeg("replay", recording, "--out", out, *options)
        self.assertEqual(done.returncode, 0, done.stderr)
        with open(out / "teeth.csv", encoding="utf-8") as teeth, open(out / "firings.csv", encoding="utf-8") as firings:
            tables = list(csv.DictReader(teeth)), list(csv.DictReader(firings))
        return json.loads((out / "summary.json").read_text()), *tables, done.stdout


class Phase(Replayed):
    def engine(self, edge_deg):
        path = self.folder / "engine.toml"
        text = (ENGINES / "vw_aba.toml").read_text()
        path.write_text(text.replace("edge_deg = 165", f"edge_deg = {edge_deg}"))
        return path

    def right_share(self, teeth, rpm=1500.0):
        """Of the last half of the teeth, those whose angle is that of the engine's cycle."""
        last = teeth[len(teeth) // 2:]
        truth = [(FIRST_DEG + (float(t["t_s"]) - 0.01) * rpm * 6) % 720 for t in last]
        return np.mean([abs((float(t["angle_deg"]) - deg + 360) % 720 - 360) < 1 for t, deg in zip(last, truth)])

    def cam(self, cam_deg, tells_deg, teeth_said, **how):
        recording = self.folder / "cam.csv"
        crank_and_cam(recording, cam_deg, **how)
        summary, teeth, _, said = self.replay(recording, "--engine", self.engine(tells_deg), "--column", "1")
        self.assertEqual(summary["guess"]["cam_column"], 2)
        self.assertEqual(summary["guess"]["cam_teeth"], teeth_said)
        self.assertEqual(self.right_share(teeth), 1)
        return summary, said

    def test_one_tooth_beside_an_even_wheel_is_mark_and_cam(self):
        recording, rows, pitch = self.folder / "two.csv", ["time [s],crank,home"], 60 / 900 / 24
        chance = np.random.default_rng(5)
        for k in range(40 * 24):
            at = 0.01 + (k + 0.05 * np.clip(chance.normal(), -2, 2)) * pitch
            rows += [f"{at:.8f},0,0", f"{at + 0.4 * pitch:.8f},1,{k % 48 == 7:d}"]
        recording.write_text("\n".join(rows) + "\n")
        summary, teeth, _, said = self.replay(recording, "--engine", self.engine(270), "--wheel", "24+1")
        self.assertEqual(summary["guess"]["wheel"], "24+1")
        self.assertEqual((summary["sync_losses"], summary["decoder"]["cam_edges_rejected"]), (0, 2))
        self.assertLess(summary["first_sync_edge"], 50)
        self.assertIn("comes every 48 teeth, once in two revolutions", said)
        # Position 0 is the tooth behind the single one, and the engine file says where in the cycle that is.
        last = [t for t in teeth[len(teeth) // 2:] if t["angle_deg"]]
        truth = [(FIRST_DEG + ((float(t["t_s"]) - 0.01) / pitch - 8) * 15) % 720 for t in last]
        self.assertGreater(len(last), 300)
        self.assertLess(np.max([abs((float(t["angle_deg"]) - deg + 360) % 720 - 360) for t, deg in zip(last, truth)]), 8)

    def test_one_tooth(self):
        summary, _ = self.cam([165], 165, 1)
        self.assertEqual(summary["decoder"]["cam_edges_rejected"], 1, "the one before the angle is known")

    def test_three_teeth(self):
        _, said = self.cam([100, 340, 600], 100, 3)
        self.assertIn("3 edges a cycle", said)

    def test_four_teeth_of_which_two_tell(self):
        for tells_deg in (225, 660):
            _, said = self.cam([45, 225, 405, 660], tells_deg, 4)
            self.assertIn("4 edges a cycle", said)

    def test_a_cam_that_moves(self):
        _, said = self.cam([165], 165, 1, moves_deg=30)
        self.assertIn("the cam moves", said)

    def test_four_teeth_that_move(self):
        _, said = self.cam([45, 225, 405, 660], 225, 4, moves_deg=25)
        self.assertIn("the cam moves", said)

    def test_lost_and_added_edges(self):
        summary, said = self.cam([165], 165, 1, lost={(8, 0), (15, 0)}, added_deg=[20 * 360 + 50])
        self.assertEqual(summary["decoder"]["cam_edges_rejected"], 2, "the one before the angle is known, and the added one")
        self.assertIn("2 of 29 cam edges were rejected", said)

    def test_a_wrong_angle_is_said(self):
        recording = self.folder / "cam.csv"
        crank_and_cam(recording, [165])
        _, _, _, said = self.replay(recording, "--engine", self.engine(265), "--column", "1")
        self.assertIn("cam.edge_deg is 265 in the engine file, the recording has the edge at 165 or 525 deg: too far off", said)

    def test_no_cam_of_an_engine_that_fires_alike_in_both_revolutions(self):
        recording = self.folder / "wheel.csv"
        crank_and_cam(recording, [])
        summary, _, _, said = self.replay(recording, "--engine", ENGINES / "vw_aba.toml", "--column", "1")
        self.assertIn("fires at the same angles a revolution later", said)
        self.assertFalse(summary["inputs"]["phase"])

    def test_no_cam_and_nothing_that_tells(self):
        recording = self.folder / "wheel.csv"
        crank_and_cam(recording, [])
        engine = self.folder / "single.toml"
        engine.write_text((ENGINES / "single_generator.toml").read_text())
        _, _, _, said = self.replay(recording, "--engine", engine, "--column", "1", "--edge", "falling")
        self.assertIn("do not tell clearly which revolution begins one", said)


class RealSingle(Replayed):
    """The recording has the cylinder's pressure beside the teeth, so its phase is known."""

    def setUp(self):
        super().setUp()
        self.recording = RECORDINGS / "real_single_pressure_full_load.txt"
        if not self.recording.exists():
            self.skipTest("the recording is not here")
        self.options = ("--engine", ENGINES / "single_generator.toml")

    def test_phase_is_found_without_a_cam(self):
        summary, teeth, firings, said = self.replay(self.recording, *self.options)
        self.assertIn("no cam: the", said)
        self.assertTrue(summary["inputs"]["phase"])
        time, volts = np.loadtxt(self.recording, usecols=(0, 1)).T
        known = [t for t in teeth if t["angle_deg"] and t["health"] == "valid"]
        angle = np.unwrap([float(t["angle_deg"]) for t in known], period=720)
        tops_deg = np.arange(np.ceil(angle[0] / 720), angle[-1] // 720) * 720
        for t_s in np.interp(tops_deg, angle, [float(t["t_s"]) for t in known]):
            beside = volts[np.abs(time - t_s) < 0.002].max()
            opposite = volts[np.abs(time - t_s - 60 / 3000) < 0.002].max()
            self.assertGreater(beside, opposite + 0.2, "the pressure peaks where the angle is 0")
        self.assertGreater(len(firings), 6)

    def test_work_of_a_cycle(self):
        _, teeth, firings, _ = self.replay(self.recording, *self.options)
        known = [f for f in firings if f["work_j"]]
        self.assertGreater(len(known), 5)
        rpm = {t["t_s"]: float(t["rpm"]) for t in teeth if t["rpm"]}
        work = np.array([float(f["work_j"]) for f in known])
        # Sums of what the crank gains from cycle to cycle are what its speed shows from the first to the last.
        ends = []
        for f in (known[0], known[-1]):
            near = [r for t, r in rpm.items() if -0.0033 < float(t) - float(f["t_s"]) <= 0]
            ends.append(np.mean(np.square(near)) * (np.pi / 30) ** 2)
        self.assertAlmostEqual(work[1:].sum(), 0.0195 / 2 * (ends[1] - ends[0]), delta=0.05 * np.abs(work).sum())
        _, _, loaded, _ = self.replay(self.recording, *self.options, "--load", "8.1")
        more = [float(b["work_j"]) - float(a["work_j"]) for a, b in zip(firings, loaded) if a["work_j"]]
        self.assertAlmostEqual(np.mean(more), 4 * np.pi * 8.1, delta=0.01)

    def test_given_parity_overrules(self):
        _, first, _, _ = self.replay(self.recording, *self.options, "--parity", "first")
        _, second, _, _ = self.replay(self.recording, *self.options, "--parity", "second")
        last = [float(rows[-1]["angle_deg"]) for rows in (first, second)]
        self.assertAlmostEqual(abs(last[0] - last[1]), 360, delta=0.01)

    def test_what_is_learned_goes_into_the_next(self):
        page = self.folder / "learned.bin"
        self.replay(self.recording, *self.options, "--learn", page)
        summary, _, _, _ = self.replay(self.recording, *self.options, "--learned", page)
        self.assertIn(str(page), summary["files"])
        done = sixdeg("replay", self.recording, *self.options, "--learned", self.recording)
        self.assertEqual(done.returncode, 2)
        self.assertIn("learned", done.stderr)


if __name__ == "__main__":
    unittest.main()
