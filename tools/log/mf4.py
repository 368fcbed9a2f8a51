#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Turns an event log into MF4 for the viewers of measurement data: tools/log/mf4.py RUN.sdlog [--truth DIR] OUT.mf4

Names, units and comments are those of hal/signals.toml. Samples that the firmware flagged invalid are marked so in the
file. --truth: the folder that `sixdeg run --out` wrote in the same run; what it knows better stands beside each estimate
under the same name with `_true`.
"""
import argparse
import csv
import os
import pathlib
import sys
import tomllib
import zlib

import numpy as np
from asammdf import MDF, Signal

from event_log import CAM_EDGE, CRANK_EDGE, SAMPLE, SIGNAL, WHEEL_EDGE, EventLog, LogError

TABLE = pathlib.Path(__file__).resolve().parents[2] / "hal" / "signals.toml"
HEALTH = {"val_0": 0, "text_0": "valid", "val_1": 1, "text_1": "degraded", "val_2": 2, "text_2": "invalid", "default": ""}
# Columns of the run's tables that hold the truth of a signal.
TOOTH_TRUTH = {"crank.angle": "angle_deg", "crank.speed": "rpm_true", "crank.tooth": "tooth_true", "torque.mass": "torque_true_nm"}
CYLINDER_TRUTH = {"cycle.cylinder_torque": ("torque_true_nm", "Nm"), "cylinder.imep": ("imep_true_bar", "bar"),
                  "cylinder.misfire": ("misfire_true", ""), "afr.cylinder_burned": ("burned_true", "")}


def read_table(signature):
    """The rows of signals and of inputs, by channel; an array has one an element, numbered from 1."""
    text = TABLE.read_bytes()
    if zlib.crc32(text) != signature:
        raise LogError(f"the log was written with signal table {signature:08x}, {TABLE.name} here is {zlib.crc32(text):08x}")
    table, rows = tomllib.loads(text.decode()), []
    for entry in table["signal"]:
        for i in range(entry.get("count", 1)):
            rows.append(entry | {"name": entry["name"] + (f"[{i + 1}]" if "count" in entry else "")})
    return rows, table["input"]


def estimates(log, rows):
    """Groups of signals that share their times: what the ecu sends together."""
    groups = {}
    signals = log.out & (log.kind == SIGNAL)
    for channel, row in enumerate(rows):
        here = signals & (log.channel == channel)
        if not here.any():
            continue
        health = (log.flags[here] & 0xff).astype(np.uint8)
        time_s = log.time_s[here]
        group = groups.setdefault((row["rate"], time_s.tobytes()), {})
        group[row["name"]] = Signal(samples=log.value[here].view("<f4"), timestamps=time_s, name=row["name"], unit=row["unit"],
                                    comment=row["text"], invalidation_bits=health == 2)
        owner = f"{row['owner']}.health" + ("" if row["rate"] == "edge" else f"_{row['rate']}")
        group.setdefault(owner, Signal(samples=health, timestamps=time_s, name=owner, conversion=HEALTH,
                                       comment=f"Health of the {row['owner']} signals sent with it."))
        why = owner.replace("health", "why")
        group.setdefault(why, Signal(samples=(log.flags[here] >> 8).astype(np.uint32), timestamps=time_s, name=why,
                                     comment="Reasons, one bit each: SD_WHY_ in firmware/num/sd_status.h."))
    return [list(group.values()) for group in groups.values()]


def inputs(log, sensors):
    """What went in. Edges have no value but their time, so they are counted."""
    edges = [(CRANK_EDGE, 0, "input.crank_edge"), (CAM_EDGE, 0, "input.cam_edge")]
    wheels = np.unique(log.channel[~log.out & (log.kind == WHEEL_EDGE)])
    edges += [(WHEEL_EDGE, wheel, f"input.wheel_edge[{wheel}]") for wheel in wheels]
    for kind, channel, name in edges:
        here = ~log.out & (log.kind == kind) & (log.channel == channel)
        if here.any():
            yield [Signal(samples=np.arange(1, here.sum() + 1, dtype=np.uint32), timestamps=log.time_s[here], name=name,
                          comment="Edges so far.")]
    for channel, row in enumerate(sensors):
        here = ~log.out & (log.kind == SAMPLE) & (log.channel == channel)
        if here.any():
            yield [Signal(samples=log.value[here].view("<f4"), timestamps=log.time_s[here], name=f"input.{row['name']}",
                          unit=row["unit"], comment=row["text"])]


def columns(path, names):
    """Columns of numbers; an empty cell is nan."""
    try:
        with path.open() as file:
            rows = list(csv.DictReader(file))
        return {name: np.array([float(row[name] or "nan") for row in rows]) for name in names}
    except OSError as error:
        raise LogError(f"{path}: cannot be read ({error.strerror})") from None
    except (KeyError, ValueError) as error:
        raise LogError(f"{path}: is not what sixdeg run writes ({error})") from None


def truth(folder, rows, edges):
    """Truth at the teeth, and of each cylinder's cycle at the end of the plant's cycle: crank angle 720 (cycle + 1)."""
    units = {row["name"].split("[")[0]: row["unit"] for row in rows}
    teeth = columns(folder / "teeth.csv", ["t_s", *TOOTH_TRUTH.values()])
    cycles = columns(folder / "cycles.csv", ["cycle", "cylinder", *(column for column, _ in CYLINDER_TRUTH.values())])
    if len(teeth["t_s"]) != edges:
        raise LogError(f"{folder}: is of another run: it has {len(teeth['t_s'])} crank edges, the log has {edges}")
    group = []
    for name, column in TOOTH_TRUTH.items():
        known = np.isfinite(teeth[column])
        group.append(Signal(samples=teeth[column], timestamps=teeth["t_s"], name=f"{name}_true", unit=units[name],
                            comment="Of the simulated engine.", invalidation_bits=~known))
    yield group
    turned_deg = np.unwrap(teeth["angle_deg"], period=720)
    for cylinder in np.unique(cycles["cylinder"]):
        of = cycles["cylinder"] == cylinder
        end_deg = 720 * (cycles["cycle"][of] + 1)
        passed = end_deg <= turned_deg[-1]
        time_s = np.interp(end_deg[passed], turned_deg, teeth["t_s"])
        yield [Signal(samples=cycles[column][of][passed], timestamps=time_s, name=f"{name}_true[{cylinder:.0f}]", unit=unit,
                      comment="Of the simulated engine's cycle that has just ended.")
               for name, (column, unit) in CYLINDER_TRUTH.items() if np.isfinite(cycles[column]).all()]


def export(log_path, truth_folder, out_path):
    log = EventLog(log_path)
    rows, sensors = read_table(log.signature)
    groups = estimates(log, rows) + list(inputs(log, sensors))
    if truth_folder:
        groups += truth(truth_folder, rows, np.count_nonzero(~log.out & (log.kind == CRANK_EDGE)))
    with MDF(version="4.10") as mdf:
        mdf.header.comment = f"sixdeg {log.about.get('sixdeg', '')}: {log.about.get('name', '')}"
        for group in groups:
            mdf.append(group, comment="sixdeg", common_timebase=True)
        partial = out_path.with_name(out_path.name + ".partial.mf4")
        mdf.save(partial, overwrite=True, compression=2)
    os.replace(partial, out_path)
    return sum(map(len, groups))


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("log", type=pathlib.Path)
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--truth", type=pathlib.Path, help="folder of the same run, from sixdeg run --out")
    options = parser.parse_args(arguments)
    try:
        count = export(options.log, options.truth, options.out)
    except (LogError, OSError) as error:
        print(f"mf4: {error}", file=sys.stderr)
        return 2
    print(f"{options.out}: {count} channels")
    return 0


if __name__ == "__main__":
    sys.exit(main())
