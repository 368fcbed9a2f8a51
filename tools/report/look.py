#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""One page about the engine that a recording is of, from the folder that `sixdeg replay` wrote.

usage: look.py FOLDER --name RECORDING --out PAGE.html
       exit status 2 and one line for a folder that cannot be drawn
"""
import argparse
import html
import os
import sys

import numpy as np

import tooth_pattern
from folder import BadFolder, Table, read_summary
from replay_folder import Replay
from sections import picture, table, text

STYLE = """
body { font: 16px/1.5 system-ui, sans-serif; color: #222; max-width: 62rem; margin: 2rem auto; padding: 0 1rem; }
h1 { font-weight: 600; margin-bottom: 0; } h2 { margin-top: 2.4rem; border-bottom: 1px solid #ddd; font-weight: 600; }
p.lead { color: #555; margin-top: .2rem; } p.note, p.none { color: #555; font-size: .9rem; margin: .4rem 0; }
ul.first { font-size: 1.25rem; line-height: 1.7; } img { width: 100%; margin: .6rem 0; } table { border-collapse: collapse; }
th { text-align: left; font-weight: 600; } td, th { padding: .15rem 1.2rem .15rem 0; } td:first-child { color: #555; }
div.unknown { border: 1px solid #d9822b; border-left-width: 6px; padding: .3rem 1.2rem; margin-top: 2.4rem; }
"""
CLEAR = 3  # standard deviations from which a difference is said


class Look:
    """A replay with its firings."""

    def __init__(self, folder):
        self.replay = Replay(folder)
        self.summary = read_summary(folder, ("guess", "decoder", "misfire", "notes", "assumptions", "synced_percent", "not_followed"))
        self.firings = Table(folder, "firings.csv", ("t_s", "cylinder", "torque_nm", "sd_nm", "health", "verdict", "lambda"))
        self.has_intake = not any("no intake pressure" in a for a in self.summary["assumptions"])
        self.has_engine = self.summary["engine"]["name"] != "not given"

    def differences(self):
        """By cylinder: torque less the mean of all, its standard deviation (N m), firings; and the mean of all. Empty without a phase."""
        told = np.isin(self.firings.texts("health"), ("valid", "degraded"))
        cylinder, torque = self.firings.numbers("cylinder"), self.firings.numbers("torque_nm")
        known = told & np.isfinite(torque)
        numbers = np.unique(cylinder[known]).astype(int)
        if len(numbers) < 2 or not self.has_engine:
            return {}, None
        means = {c: torque[known & (cylinder == c)] for c in numbers}
        middle = float(np.mean([v.mean() for v in means.values()]))
        return {int(c): (float(v.mean() - middle), float(v.std(ddof=1) / np.sqrt(len(v))) if len(v) > 1 else float("inf"), len(v))
                for c, v in means.items()}, middle

    def pattern(self):
        teeth = self.replay.teeth
        placed = np.isin(teeth.kind, ("tooth", "coasted")) & np.isfinite(teeth.tooth)
        positions = int(self.summary["guess"]["wheel"].split("-")[0].split("+")[0])
        return tooth_pattern.deviations(teeth.tooth[placed], teeth.t_s[placed], teeth.rpm[placed], positions)

    def misfires(self):
        return [c for c in self.summary["misfire"]["cylinders"] if c["judged"]]


def first_things(look, pattern):
    """What a person acts on, most urgent first; nothing that the inputs do not carry."""
    if look.summary["not_followed"]:
        return [f"The recording could not be followed: {look.summary['not_followed']}."]
    said = []
    for row in look.misfires():
        if row["misfires"] > 0:
            share = 100 * row["misfires"] / row["judged"]
            said.append(f"Cylinder {row['cylinder']} misfired {row['misfires']} times in {row['judged']} firings ({share:.1f} %).")
    differences, middle = look.differences()
    for cylinder, (off, sd, _) in sorted(differences.items(), key=lambda item: -abs(item[1][0])):
        if abs(off) < CLEAR * sd:
            continue
        way = "more" if off > 0 else "less"
        if look.has_intake and middle > 0:
            said.append(f"Cylinder {cylinder} gives {abs(100 * off / middle):.0f} ± {100 * sd / middle:.0f} % {way} torque than the mean.")
        else:
            said.append(f"Cylinder {cylinder} gives {abs(off):.1f} ± {sd:.1f} N m {way} than the mean.")
    for tooth, late_deg, sd in tooth_pattern.worst(pattern):
        said.append(f"Tooth {tooth} (counted from 0 behind the mark) comes {abs(late_deg):.2f} ± {sd:.2f} deg {'late' if late_deg > 0 else 'early'}.")
    faults = look.summary["faults_coasted"]
    if faults:
        said.append(f"{faults} teeth were missing or added, {look.summary['sync_losses']} times the angle was lost.")
    return said or ["Nothing stands out: wheel and speed are read without a fault."]


def unknown(look):
    """What is not known, and why."""
    items = list(look.summary["assumptions"])
    if not look.has_engine:
        items.insert(0, "Torque of the cylinders: no engine file was given, which would say geometry, inertia and firing order.")
    elif not look.differences()[0]:
        items.insert(0, "Contribution of single cylinders: the phase of the cycle is not known, or the recording is too short.")
    if not look.misfires():
        items.append("Misfires: not judged; that takes an engine file, the phase and the injected fuel.")
    if all(value == "" for value in look.firings.texts("lambda")):
        items.append("Mixture of the cylinders: that takes intake pressure, injected fuel, a lambda sensor and the exhaust in the engine file.")
    return items


def listed(items, kind):
    return f'<ul class="{kind}">' + "".join(f"<li>{html.escape(item)}</li>" for item in items) + "</ul>"


def cylinder_parts(look, pictures):
    differences, middle = look.differences()
    if not differences:
        return [text("No contribution of single cylinders; why is said below.", "none")]
    rows = [(f"cylinder {c}", f"{off:+.2f} N m", f"{sd:.2f} N m", f"{count}") for c, (off, sd, count) in differences.items()]
    return [picture(pictures.differences(differences), "cylinder contributions"),
            table(rows, ("", "less the mean", "standard deviation", "firings")),
            text("From the filter on tooth times. The deviation is that of the mean over the firings, as they scatter.")]


def misfire_parts(look):
    rows = [(f"cylinder {r['cylinder']}", str(r["misfires"]), str(r["partial"]), str(r["judged"]), f"{r['window_200_percent']:.1f} %",
             f"{r['window_1000_percent']:.1f} %") for r in look.misfires()]
    if not rows:
        return [text("Not judged; why is said below.", "none")]
    return [table(rows, ("", "misfires", "partial burns", "firings judged", "last 200 revolutions", "last 1000"))]


def page(look, name):
    # Imported late: a bad folder is reported at once, not after the plotting library has loaded.
    import look_pictures
    import replay_pictures as pictures

    pattern = look.pattern()
    replay = look.replay
    source = replay.teeth.torque_source
    parts = [f"<h1>{html.escape(name)}</h1>", text(f"{replay.pattern()}; engine: {look.summary['engine']['name']}", "lead"),
             listed(first_things(look, pattern), "first"),
             "<h2>Wheel and sync</h2>", table(replay.figures()[:9] + [("in sync", f"{look.summary['synced_percent']:.1f} % of the time")]),
             listed(look.summary["notes"], "notes"),
             "<h2>Speed</h2>", picture(pictures.speed(replay.teeth), "speed over time", "No speed: the decoder never synced."),
             "<h2>Tooth pattern</h2>", picture(look_pictures.pattern(pattern), "tooth pattern", "Too few whole revolutions for a pattern."),
             "<h2>Cylinders</h2>", *cylinder_parts(look, look_pictures),
             "<h2>Misfires</h2>", *misfire_parts(look),
             "<h2>Torque over the cycle</h2>",
             picture(pictures.torque(replay.teeth), "torque over crank angle", "No torque over a whole cycle."),
             text(f"From {source}." + ("" if look.has_engine else " In proportion only: the inertia is not known.")),
             '<div class="unknown"><h2>What is not known, and why</h2>', listed(unknown(look), "unknown"), "</div>"]
    return ('<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
            f"<title>{html.escape(name)}</title><style>{STYLE}</style></head>\n<body>" + "\n".join(parts) + "\n</body></html>\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("folder")
    parser.add_argument("--name", required=True)
    parser.add_argument("--out", required=True)
    options = parser.parse_args()
    try:
        text_of_page = page(Look(options.folder), options.name)
        with open(options.out + ".partial", "w", encoding="utf-8", newline="\n") as out:
            out.write(text_of_page)
        os.replace(options.out + ".partial", options.out)
    except (BadFolder, OSError) as error:
        print(f"look: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
