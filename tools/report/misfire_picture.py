#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""What six detectors of misfires find over the false alarms they give, as a picture:

  build/venv/bin/python tools/report/misfire_picture.py FOLDER PICTURE.png

FOLDER is what `sixdeg study misfire --out FOLDER` wrote: a row a kind of engine, a column a road."""
import argparse

import numpy as np

from folder import BadFolder, Table
from style import BLUE, GREY, INK, ORANGE, PALE, RED, axes_grid, png

COLUMNS = ("kind", "physics", "road_rms_nm", "jitter_deg", "method", "false_percent", "found", "missed")
COLORS = {"monitor": BLUE, "FOLSMO": ORANGE, "FOSMO": RED, "ROO": GREY, "speed delta": INK, "running mean": PALE}
LIMIT = "monitor's limit"
LEAST_FALSE_PERCENT = 0.005  # where a limit without any false alarm is drawn


class Curves:
    def __init__(self, folder):
        table = Table(folder, "curves.csv", COLUMNS)
        if not len(table.rows):
            raise BadFolder(f"{table.path}: is empty")
        self.text = {name: table.texts(name) for name in ("kind", "physics", "method")}
        self.number = {name: table.numbers(name) for name in COLUMNS if name not in self.text}

    def kinds(self):
        return list(dict.fromkeys(self.text["kind"]))

    def roads(self):
        return list(dict.fromkeys(zip(self.number["road_rms_nm"], self.number["jitter_deg"])))

    def of(self, kind, physics, road, method):
        """False alarms and misfires found, both in percent."""
        rows = ((self.text["kind"] == kind) & (self.text["physics"] == physics) & (self.text["method"] == method)
                & (self.number["road_rms_nm"] == road[0]) & (self.number["jitter_deg"] == road[1]))
        missed = self.number["missed"][rows]
        return self.number["false_percent"][rows], 100 * self.number["found"][rows] / np.maximum(missed, 1)


def draw(curves, physics):
    kinds, roads = curves.kinds(), curves.roads()
    figure, all_axes = axes_grid(len(kinds), len(roads), 1 + 3 * len(kinds), sharex=True, sharey=True)
    for i, axes in enumerate(all_axes):
        kind, road = kinds[i // len(roads)], roads[i % len(roads)]
        for method, color in COLORS.items():
            axes.plot(*curves.of(kind, physics, road, method), color=color, label=method)
        alarms, found = curves.of(kind, physics, road, LIMIT)
        axes.plot(np.maximum(alarms, LEAST_FALSE_PERCENT), found, "o", color=BLUE, label=LIMIT)
        surface = f"rough road {road[0]:g} N m" if road[0] > 0 else "smooth road"
        axes.set(xscale="log", ylim=(0, 102))
        axes.set_title(f"{kind}, {surface}, {road[1]:g} deg", loc="left", fontsize=9)
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
        data = draw(Curves(options.folder), options.physics)
    except BadFolder as error:
        parser.exit(2, f"misfire_picture: {error}\n")
    with open(options.picture, "wb") as file:
        file.write(data)


if __name__ == "__main__":
    main()
