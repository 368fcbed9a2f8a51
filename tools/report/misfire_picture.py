#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""What six detectors of misfires find over the false alarms they give, as a picture:

  build/venv/bin/python tools/report/misfire_picture.py FOLDER PICTURE.png

FOLDER is what `sixdeg study misfire --out FOLDER` wrote: a row a kind of engine, a column a road."""
import argparse

import numpy as np

from folder import BadFolder
from misfire_folder import LEAST_FALSE_PERCENT, LIMIT, MisfireCurves
from style import BLUE, GREY, INK, ORANGE, PALE, RED, axes_grid, png

COLORS = {"monitor": BLUE, "FOLSMO": ORANGE, "FOSMO": RED, "ROO": GREY, "speed delta": INK, "running mean": PALE}


def draw(curves, physics):
    kinds, roads = curves.kinds(), curves.roads()
    figure, all_axes = axes_grid(len(kinds), len(roads), 1 + 3 * len(kinds), sharex=True, sharey=True)
    for i, axes in enumerate(all_axes):
        kind, road = kinds[i // len(roads)], roads[i % len(roads)]
        for method, color in COLORS.items():
            axes.plot(*curves.of(kind, physics, road, method), color=color, label=method)
        alarms, found = curves.of(kind, physics, road, LIMIT)
        axes.plot(np.maximum(alarms, LEAST_FALSE_PERCENT), found, "o", color=BLUE, label=LIMIT)
        axes.set(xscale="log", ylim=(0, 102))
        axes.set_title(curves.words(kind, road), loc="left", fontsize=9)
    for axes in all_axes[-len(roads):]:
        axes.set_xlabel("false alarms, %")
    for axes in all_axes[::len(roads)]:
        axes.set_ylabel("misfires found, %")
    all_axes[-1].legend(fontsize=7, loc="center left")  # free: on a rough road one curve is above it and all others are below
    return png(figure)


def main():
    parser = argparse.ArgumentParser(description="what detectors of misfires find over the false alarms they give")
    parser.add_argument("folder", metavar="FOLDER")
    parser.add_argument("picture", metavar="PICTURE.png")
    parser.add_argument("--physics", choices=("own", "other"), default="other")
    options = parser.parse_args()
    try:
        data = draw(MisfireCurves(options.folder), options.physics)
    except BadFolder as error:
        parser.exit(2, f"misfire_picture: {error}\n")
    with open(options.picture, "wb") as file:
        file.write(data)


if __name__ == "__main__":
    main()
