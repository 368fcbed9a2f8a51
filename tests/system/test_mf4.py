#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""tools/log/mf4.py: what asammdf reads back is what the firmware said and what the plant knew."""
import contextlib
import hashlib
import io
import os
import pathlib
import struct
import subprocess
import sys
import tomllib
import unittest

import numpy as np
from asammdf import MDF

from sixdeg_test import Folder, table

ROOT = pathlib.Path(__file__).resolve().parents[2]
SIXDEG = os.environ["SIXDEG"]
sys.path.append(str(ROOT / "tools" / "log"))
import event_log
import mf4  # in this process: asammdf takes seconds to import

SIGNALS = {row["name"]: row for row in tomllib.loads((ROOT / "hal" / "signals.toml").read_text())["signal"]}


def channel_of(name):
    """First channel of a signal."""
    at = 0
    for row in SIGNALS.values():
        if row["name"] == name:
            return at
        at += row.get("count", 1)
    raise KeyError(name)


class Mf4(Folder):
    def setUp(self):
        super().setUp()
        scenario = self.folder / "scenario.toml"
        scenario.write_text(f'engine = "{ROOT}/host_sim/data/engines/diesel_22.toml"\n[run]\ncycles = 20\n[speed]\nrpm = 1000\n'
                            "[load]\nbmep_bar = 5\n[encoder]\nextra_rate = 0.002\n")
        self.log = self.folder / "a.sdlog"
        self.run_scenario(scenario)

    def run_scenario(self, scenario):
        subprocess.run([SIXDEG, "run", scenario, "--nominal", "--record", self.log, "--out", self.folder / "run"], check=True,
                       stdout=subprocess.DEVNULL)

    def export(self, *options, status=0):
        out, said = self.folder / "a.mf4", io.StringIO()
        with contextlib.redirect_stderr(said), contextlib.redirect_stdout(io.StringIO()):
            self.assertEqual(mf4.main(list(map(str, (self.log, out, *options)))), status, said.getvalue())
        if status:
            self.assertEqual(list(self.folder.glob("*.mf4")), [])
            return said.getvalue()
        return MDF(out)

    def test_values_times_units_and_comments(self):
        subprocess.run([SIXDEG, "replay", self.log, "--out", self.folder / "replayed"], check=True, stdout=subprocess.DEVNULL)
        teeth, cycles = table(self.folder / "replayed" / "teeth.csv"), table(self.folder / "replayed" / "cycles.csv")
        with self.export("--truth", self.folder / "run") as mdf:
            for name, column, digits in (("crank.angle", "angle_deg", 3), ("torque.mass", "fourier_nm", 3), ("crank.speed", "rpm", 3)):
                signal = mdf.get(name, ignore_invalidation_bits=True)
                self.assertEqual((signal.unit, signal.comment), (SIGNALS[name]["unit"], SIGNALS[name]["text"]))
                self.assertEqual(len(signal.samples), len(teeth))
                self.assertEqual(list(np.round(signal.timestamps, 9)), [float(row["t_s"]) for row in teeth])
                known = [i for i, row in enumerate(teeth) if row[column]]
                self.assertGreater(len(known), 2000)
                np.testing.assert_allclose(signal.samples[known], [float(teeth[i][column]) for i in known], atol=0.6 * 10**-digits)
            valid = mdf.get("torque.mass")
            self.assertEqual(len(valid.samples), sum(row["fourier_health"] != "invalid" for row in teeth))
            self.assertEqual([text.decode() for text in mdf.get("torque.health").samples], [row["fourier_health"] for row in teeth])
            third = mdf.get("cycle.cylinder_torque[3]", ignore_invalidation_bits=True)
            np.testing.assert_allclose(third.samples, [float(row["fourier_nm"]) for row in cycles if row["cylinder"] == "3"], atol=0.0006)

    def test_truth_stands_beside_the_estimate(self):
        teeth, cycles = table(self.folder / "run" / "teeth.csv"), table(self.folder / "run" / "cycles.csv")
        with self.export("--truth", self.folder / "run") as mdf:
            estimate, truth = mdf.get("torque.mass"), mdf.get("torque.mass_true")
            self.assertEqual(truth.unit, estimate.unit)
            np.testing.assert_allclose(truth.samples, [float(row["torque_true_nm"]) for row in teeth])
            np.testing.assert_allclose(truth.timestamps, [float(row["t_s"]) for row in teeth])
            # Both are torques of the same teeth: after settling they belong together.
            late = estimate.timestamps > 1.5
            true = np.interp(estimate.timestamps[late], truth.timestamps, truth.samples)
            self.assertGreater(np.corrcoef(estimate.samples[late], true)[0, 1], 0.8)
            cylinder = mdf.get("cycle.cylinder_torque_true[1]")
            np.testing.assert_allclose(cylinder.samples,
                                       [float(row["torque_true_nm"]) for row in cycles if row["cylinder"] == "1"][:len(cylinder.samples)])
            self.assertAlmostEqual(float(np.diff(cylinder.timestamps).mean()), 0.12, delta=0.004)

    def test_single_firings_misfires_and_mixture(self):
        scenario = self.folder / "scenario.toml"
        scenario.write_text(scenario.read_text().replace("cycles = 20", "cycles = 40")
                            + "[[misfires.event]]\ncycle = 30\ncylinder = 4\n[uego]\nnoise_per_rthz = 1e-4\n")
        self.run_scenario(scenario)
        cycles = table(self.folder / "run" / "cycles.csv")
        with self.export("--truth", self.folder / "run") as mdf:
            for name in ("firing.torque", "firing.sd", "misfire.index", "misfire.verdict", "misfire.rate_200[4]", "misfire.lamp",
                         "afr.cylinder_burned[1]", "balance.trim[1]"):
                signal, row = mdf.get(name, ignore_invalidation_bits=True), SIGNALS[name.split("[")[0]]
                self.assertEqual((signal.unit, signal.comment), (row["unit"], row["text"]))
            verdict, cylinder = mdf.get("misfire.verdict"), mdf.get("misfire.cylinder")
            self.assertEqual(list(cylinder.samples[verdict.samples == 2]), [4])
            truth = mdf.get("cylinder.misfire_true[4]")
            at = verdict.timestamps[verdict.samples == 2][0]
            self.assertLess(abs(at - truth.timestamps[truth.samples == 1][0]), 0.15, "a cycle is 0.12 s")
            self.assertEqual(mdf.get("firing.torque").timestamps.tolist(), mdf.get("firing.sd").timestamps.tolist())
            for number in range(1, 5):
                burned, truth = mdf.get(f"afr.cylinder_burned[{number}]"), mdf.get(f"afr.cylinder_burned_true[{number}]")
                self.assertEqual(list(truth.samples),
                                 [float(r["burned_true"]) for r in cycles if r["cylinder"] == str(number)][:len(truth.samples)])
                self.assertLess(abs(burned.samples[-1] - truth.samples[-1]), 0.1)
                self.assertIn(f"cycle.cylinder_torque_true[{number}]", mdf.channels_db)

    def test_without_truth_there_is_none(self):
        with self.export() as mdf:
            self.assertFalse([name for name in mdf.channels_db if "_true" in name])
            self.assertEqual(len(mdf.get("input.crank_edge").samples), len(table(self.folder / "run" / "teeth.csv")))
            pressure = mdf.get("input.air.intake_pressure")
            self.assertEqual(pressure.unit, "bar")
            self.assertTrue(((pressure.samples > 0.2) & (pressure.samples < 4)).all())
            np.testing.assert_allclose(np.diff(pressure.timestamps)[:-1], 0.01, atol=2e-6)  # the last ends the run

    def rewrite(self, change):
        """Has `change` work on the list of the log's events, and puts a right checksum behind them."""
        data = self.log.read_bytes()
        _, _, about, page, _ = event_log.HEADER.unpack_from(data)
        first = event_log.HEADER.size + about + page
        events = [data[at:at + 16] for at in range(first, len(data) - 32, 16)]
        data = data[:first] + b"".join(change(events))
        self.log.write_bytes(data + hashlib.sha256(data).digest())

    def test_a_cycle_said_in_pieces_and_the_edges_of_other_wheels(self):
        with self.export() as mdf:
            whole = {name: (mdf.get(name).samples.tolist(), mdf.get(name).timestamps.tolist()) for name in ("cycle.speed", "misfire.count")}
        self.assertGreater(len(whole["cycle.speed"][0]), 10)

        def change(events):
            out, waiting = [], []
            for event in events:
                _, kind, channel, _, _ = struct.unpack("<IHHII", event)
                if kind == event_log.OUT | event_log.SIGNAL and channel in (channel_of("misfire.count"), channel_of("balance.trim")):
                    waiting.append(event)  # said behind the edge's row
                    continue
                if kind == event_log.CRANK_EDGE:
                    out += waiting
                    waiting = []
                    for wheel in (1, 4):
                        out.append(struct.pack("<IHHII", *struct.unpack_from("<I", event), event_log.WHEEL_EDGE, wheel, 0, 0))
                out.append(event)
            return out + waiting

        self.rewrite(change)
        with self.export() as mdf:
            for name, (samples, times) in whole.items():
                self.assertEqual((mdf.get(name).samples.tolist(), mdf.get(name).timestamps.tolist()), (samples, times), name)
            edges = mdf.get("input.crank_edge")
            for wheel in (1, 4):
                self.assertEqual(mdf.get(f"input.wheel_edge[{wheel}]").timestamps.tolist(), edges.timestamps.tolist())

    def test_errors_are_one_line(self):
        self.assertIn("cannot be read", self.export("--truth", self.folder / "none", status=2))
        teeth = self.folder / "run" / "teeth.csv"
        teeth.write_text("".join(teeth.read_text().splitlines(True)[:-1]))
        self.assertIn("is of another run", self.export("--truth", self.folder / "run", status=2))
        self.log.write_bytes(self.log.read_bytes()[:-1])
        self.assertEqual(self.export(status=2), f"mf4: {self.log}: is truncated or damaged: its checksum is wrong\n")


if __name__ == "__main__":
    unittest.main()
