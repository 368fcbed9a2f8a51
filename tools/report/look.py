#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""One page about the engine that a recording is of, from the folder that `sixdeg replay` wrote.

usage: look.py FOLDER --name RECORDING --out PAGE.html
       exit status 2 and one line for a folder that cannot be drawn
"""
import argparse
import html
import sys

import numpy as np

import look_pictures
import page as pages
import replay_pictures as pictures
import tooth_pattern
from folder import BadFolder, Table, read_summary
from replay_folder import Replay
from page import listed, picture, table, text

FIELDS = ("guess", "decoder", "inputs", "misfire", "notes", "assumptions", "synced_percent", "not_followed")
CLEAR = 4  # standard deviations from which a difference is said


class Look:
    """A replay with its firings."""

    def __init__(self, folder):
        self.replay = Replay(folder)
        self.summary = read_summary(folder, FIELDS)
        self.firings = Table(folder, "firings.csv", ("firing", "t_s", "cylinder", "torque_nm", "sd_nm", "health", "verdict", "lambda"))
        self.has_intake = self.summary["inputs"]["intake"]
        engine = self.summary["engine"]
        self.has_engine = engine["name"] != "not given"
        self.knows_inertia = self.has_engine and "crank.inertia_kgm2" not in engine["guessed"]
        self.order = engine["firing_order"]

    def name(self, cylinder):
        """Of a cylinder; with the one that fires a revolution later where nothing measured tells them apart."""
        half, rest = divmod(len(self.order), 2)
        if rest or "cam.edge_deg" not in self.summary["engine"]["guessed"]:
            return f"cylinder {cylinder}"
        other = self.order[(self.order.index(cylinder) + half) % len(self.order)]
        return f"cylinder {cylinder} (or {other}, cam.edge_deg is a guess)"

    def differences(self):
        """By cylinder: torque less that of all firings around it, standard deviation of that mean (N m), firings; and the mean of all.

        Around: one cycle, half of it on either side, so that what the engine does as a whole is in no difference. Empty without a phase.
        """
        told = np.isin(self.firings.texts("health"), ("valid", "degraded"))
        cylinder, torque, number = (self.firings.numbers(n) for n in ("cylinder", "torque_nm", "firing"))
        if len(self.order) < 2 or not self.has_engine or len(torque) <= len(self.order):
            return {}, None
        torque = np.where(told, torque, np.nan)
        weights = np.ones(len(self.order) + 1 - len(self.order) % 2)
        if len(self.order) % 2 == 0:
            weights[[0, -1]] = 0.5
        off = torque - np.convolve(torque, weights / weights.sum(), "same")
        beside = len(weights) // 2
        off[:beside] = off[len(off) - beside:] = np.nan
        unbroken = np.diff(number, prepend=number[0] - 1) == 1
        known = np.isfinite(off) & (np.convolve(unbroken, np.ones(len(weights)), "same") == len(weights))
        found = {int(c): off[known & (cylinder == c)] for c in np.unique(cylinder[known])}
        if len(found) < len(self.order) or min(len(v) for v in found.values()) < 2:
            return {}, None
        return ({c: (float(v.mean()), float(v.std(ddof=1) / np.sqrt(len(v))), len(v)) for c, v in found.items()},
                float(np.nanmean(torque)))

    def scale(self):
        """What the numbers in N m rest on where the inertia is no measured one; with a blank before it."""
        return "" if self.knows_inertia else " if the inertia is as guessed"

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
            name = look.name(row["cylinder"]).capitalize()
            said.append(f"{name} misfired {row['misfires']} times in {row['judged']} firings ({share:.1f} %).")
    differences, middle = look.differences()
    for cylinder, (off, sd, _) in sorted(differences.items(), key=lambda item: -abs(item[1][0])):
        if abs(off) < CLEAR * sd:
            continue
        way, name = "more" if off > 0 else "less", look.name(cylinder).capitalize()
        if look.has_intake and middle > 0:
            said.append(f"{name} gives {abs(100 * off / middle):.0f} ± {100 * sd / middle:.0f} % {way} torque than the mean.")
        else:
            said.append(f"{name} gives {abs(off):.1f} ± {sd:.1f} N m {way} than the mean{look.scale()}.")
    for tooth, late_deg, sd in tooth_pattern.worst(pattern):
        way = "late" if late_deg > 0 else "early"
        said.append(f"Tooth {tooth} (counted from 0 behind the mark) comes {abs(late_deg):.2f} ± {sd:.2f} deg {way}.")
    faults = look.summary["faults_coasted"]
    if faults:
        said.append(f"{faults} teeth were missing or added, {look.summary['sync_losses']} times the angle was lost.")
    return said or ["Nothing stands out: wheel and speed are read without a fault."]


def unknown(look):
    """What is not known, and why."""
    items = list(look.summary["assumptions"])
    if look.has_engine and not look.has_intake:
        items.insert(0, "How much torque the engine or a cylinder gives: that takes the intake pressure (--intake).")
    if not look.has_engine:
        items.insert(0, "Torque of the cylinders: no engine file was given, which would say geometry, inertia and firing order.")
    elif len(look.order) > 1 and not look.differences()[0]:
        items.insert(0, "Contribution of single cylinders: the phase of the cycle is not known, or the recording is too short.")
    if look.differences()[0] and not look.summary["inputs"]["learned"]:
        items.insert(0, "How much of the differences between cylinders is the wheel's: teeth that are off look like cylinders that differ. "
                        "A tooth pattern learned in fuel cut (--learned) takes that out.")
    if not look.misfires():
        items.append("Misfires: not judged; that takes an engine file, the phase and the injected fuel.")
    if all(value == "" for value in look.firings.texts("lambda")):
        items.append("Mixture of the cylinders: that takes intake pressure, injected fuel, a lambda sensor and the exhaust in the "
                     "engine file.")
    return items


def cylinder_parts(look):
    differences, middle = look.differences()
    if look.has_engine and len(look.order) == 1:
        return [text("One cylinder: there is no other to compare it with.", "none")]
    if not differences:
        return [text("No contribution of single cylinders; why is said below.", "none")]
    rows = [(look.name(c), f"{off:+.2f} N m", f"{sd:.2f} N m", f"{count}") for c, (off, sd, count) in differences.items()]
    return [picture(look_pictures.differences(differences), "cylinder contributions"),
            table(rows, ("", "less the mean", "standard deviation", "firings")),
            text("From the filter on tooth times: each firing less the mean of the cycle around it"
                 + (". " if look.knows_inertia else ", in N m" + look.scale() + ". ")
                 + "The deviation is that of the mean over the firings, as they scatter.")]


def torque_parts(look):
    """The torque where its inputs carry it; otherwise only how it swings, and without a scale where the inertia is not measured."""
    teeth, none = look.replay.teeth, "No torque over a whole cycle."
    if look.has_intake and look.has_engine:
        return [picture(pictures.torque(teeth), "torque over crank angle", none), text(f"From {teeth.torque_source}{look.scale()}.")]
    words = ("From the Fourier observer, each cycle less its mean: how much torque it is in all, the teeth do not tell without the "
             "intake pressure")
    if not look.knows_inertia:
        words += ", nor how many N m without a measured inertia"
    return [picture(pictures.torque_swing(teeth, look.knows_inertia), "swing of the torque over crank angle", none), text(words + ".")]


def misfire_parts(look):
    rows = [(f"cylinder {r['cylinder']}", str(r["misfires"]), str(r["partial"]), str(r["judged"]), f"{r['window_200_percent']:.1f} %",
             f"{r['window_1000_percent']:.1f} %") for r in look.misfires()]
    if not rows:
        return [text("Not judged; why is said below.", "none")]
    return [table(rows, ("", "misfires", "partial burns", "firings judged", "last 200 revolutions", "last 1000"))]


def page(look, name):
    pattern = look.pattern()
    replay = look.replay
    parts = [f"<h1>{html.escape(name)}</h1>", text(f"{replay.pattern()}; engine: {look.summary['engine']['name']}", "lead"),
             listed(first_things(look, pattern), "first"),
             "<h2>Wheel and sync</h2>", table(replay.figures()[:9] + [("in sync", f"{look.summary['synced_percent']:.1f} % of the time")]),
             listed(look.summary["notes"], "notes"),
             "<h2>Speed</h2>", picture(pictures.speed(replay.teeth), "speed over time", "No speed: the decoder never synced."),
             "<h2>Tooth pattern</h2>", picture(look_pictures.pattern(pattern), "tooth pattern", "Too few whole revolutions for a pattern."),
             "<h2>Cylinders</h2>", *cylinder_parts(look),
             "<h2>Misfires</h2>", *misfire_parts(look),
             "<h2>Torque over the cycle</h2>", *torque_parts(look),
             '<div class="unknown"><h2>What is not known, and why</h2>', listed(unknown(look), "unknown"), "</div>"]
    return pages.whole(name, parts)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("folder")
    parser.add_argument("--name", required=True)
    parser.add_argument("--out", required=True)
    options = parser.parse_args()
    try:
        text_of_page = page(Look(options.folder), options.name)
        pages.write(options.out, text_of_page)
    except (BadFolder, OSError) as error:
        print(f"look: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
