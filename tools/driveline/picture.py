# SPDX-License-Identifier: MIT
"""Picture of document 003's Figure 6, from the CSV that `sixdeg study driveline figure-6 --out FOLDER` writes.

  build/venv/bin/python tools/driveline/picture.py figure_6.csv figure_6.png
"""
import argparse
import csv

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (the backend must be chosen first)

shown_s = (1.9, 3.4)


def columns(path):
    """The file's columns as lists of numbers, as far as the picture shows them."""
    with open(path, newline="") as file:
        rows = [row for row in csv.DictReader(file) if shown_s[0] <= float(row["time_s"]) <= shown_s[1]]
    return {name: [float(row[name]) for row in rows] for name in rows[0]}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("trace", help="figure_6.csv")
    parser.add_argument("picture", help="file to write, .png or .svg")
    options = parser.parse_args()
    data = columns(options.trace)
    time = data["time_s"]
    figure, (torsion, residuals, locations) = plt.subplots(3, 1, sharex=True, figsize=(9, 7), layout="constrained")
    torsion.plot(time, data["torsion_rad"], label="torsion less equilibrium")
    torsion.plot(time, data["estimate_rad"], "--", label="continuous observer")
    for threshold in (-0.01, -0.04):
        torsion.axhline(threshold, color="grey", linewidth=0.6)
    torsion.set(ylabel="rad")
    for name in ("r2_rpm", "r3_rpm"):
        residuals.plot(time, data[name], label=name[:2])
    residuals.set(ylabel="residual, rpm")
    locations.step(time, data["location"], where="post", label="location")
    locations.step(time, data["found"], "--", where="post", label="found")
    locations.set(yticks=[1, 2, 3], ylim=(0.8, 3.2), xlabel="s")
    for axes in (torsion, residuals, locations):
        axes.legend(fontsize=8)
    figure.savefig(options.picture, dpi=80)


if __name__ == "__main__":
    main()
