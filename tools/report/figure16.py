# SPDX-License-Identifier: MIT
"""Draws Figure 16 of document 004 from cycles.csv of `sixdeg run host_sim/scenarios/figure16_1500rpm_9bar.toml --out DIR`:
burned share, torque and fuel trim of every cylinder. figure16.py DIR PICTURE.png"""
import csv
import pathlib
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

MARKS = {7.5: "control off", 19: "cylinder 2 off", 36: "control on"}


def columns(path):
    """Rows of cycles.csv by cylinder: {cylinder: {column: [values]}}, NaN where a cell is empty."""
    found = {}
    with open(path, newline="") as file:
        for row in csv.DictReader(file):
            cylinder = found.setdefault(int(row["cylinder"]), {})
            for name, text in row.items():
                if name != "health":
                    cylinder.setdefault(name, []).append(float(text) if text else float("nan"))
    return found


def draw_figure16(cycles_csv, picture, marks=MARKS):
    """Four rows: true and estimated burned share, estimated torque, fuel trim; one colour a cylinder."""
    cylinders = columns(cycles_csv)
    rows = [("burned_true", "burned share, true", 1), ("burned", "burned share, estimated", 1),
            ("torque_nm", "torque, estimated, Nm", 1), ("trim", "fuel trim, %", 100)]
    figure, axes = plt.subplots(len(rows), 1, sharex=True, figsize=(9, 9), layout="constrained")
    for axis, (name, label, factor) in zip(axes, rows):
        for number, data in sorted(cylinders.items()):
            axis.plot(data["t_s"], [factor * v for v in data[name]], linewidth=0.8, label=f"cylinder {number}")
        for time_s in marks:
            axis.axvline(time_s, color="0.6", linewidth=0.8, linestyle=":")
        axis.set_ylabel(label)
    for time_s, text in marks.items():
        axes[0].annotate(text, (time_s, 1.02), xycoords=("data", "axes fraction"), fontsize=8)
    axes[0].legend(loc="lower left", ncols=4, fontsize=8)
    axes[-1].set_xlabel("time, s")
    figure.savefig(picture, dpi=110, metadata={"Software": None})
    plt.close(figure)


if __name__ == "__main__":
    draw_figure16(pathlib.Path(sys.argv[1]) / "cycles.csv", sys.argv[2])
