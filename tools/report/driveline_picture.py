#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Picture of document 003's Figure 6, as PNG bytes, or as a file:

  build/venv/bin/python tools/report/driveline_picture.py FOLDER PICTURE.png

FOLDER is what `sixdeg study driveline figure-6 --out FOLDER` wrote."""
import argparse

from driveline_folder import Driveline
from style import BLUE, GREY, ORANGE, axes_grid, png

SHOWN_S = (1.9, 3.4)
KINKS_RAD = (-0.01, -0.04)  # torsion less that of the equilibrium, where the shaft becomes stiff


def figure_6(driveline):
    data = driveline.columns
    shown = (data["time_s"] >= SHOWN_S[0]) & (data["time_s"] <= SHOWN_S[1])
    time = data["time_s"][shown]
    figure, (torsion, residuals, locations) = axes_grid(3, 1, 7.5, sharex=True)
    torsion.plot(time, data["torsion_rad"][shown], color=BLUE, label="torsion less equilibrium")
    torsion.plot(time, data["estimate_rad"][shown], "--", color=ORANGE, label="continuous observer")
    for kink in KINKS_RAD:
        torsion.axhline(kink, color=GREY, linewidth=0.8)
    torsion.set_ylabel("rad")
    for name, color in (("r2_rpm", BLUE), ("r3_rpm", ORANGE)):
        residuals.plot(time, data[name][shown], color=color, label=name[:2])
    residuals.set_ylabel("residual, rpm")
    locations.step(time, data["location"][shown], where="post", color=BLUE, label="location")
    locations.step(time, data["found"][shown], "--", where="post", color=ORANGE, label="found")
    locations.set(yticks=[1, 2, 3], ylim=(0.8, 3.2), xlabel="s")
    for axes in (torsion, residuals, locations):
        axes.legend(fontsize=8)
    return png(figure)


def main():
    parser = argparse.ArgumentParser(description="Figure 6 of document 003 as a picture")
    parser.add_argument("folder", metavar="FOLDER")
    parser.add_argument("picture", metavar="PICTURE.png")
    options = parser.parse_args()
    with open(options.picture, "wb") as file:
        file.write(figure_6(Driveline(options.folder)))


if __name__ == "__main__":
    main()
