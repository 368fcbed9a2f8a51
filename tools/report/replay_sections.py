# SPDX-License-Identifier: MIT
"""A replayed recording: wheel, speed, torque where its inputs carry it, differences between cylinders."""
import replay_pictures as pictures
from page import listed, picture, table, text


def assumed(items):
    return "<h3>What the torque rests on</h3>" + listed(items, "assumed") if items else ""


def replay_section(replay):
    return [table(replay.figures()),
            picture(pictures.speed(replay.teeth), "speed over time", "No speed: the decoder never synced."),
            picture(pictures.mark(replay.teeth), "teeth around a mark", "No mark with decoded teeth on both sides."),
            torque(replay),
            *differences(replay),
            assumed(replay.assumptions())]


def torque(replay):
    if replay.lacks_intake():
        return text("No torque over crank angle: compression makes most of it, and how much follows from the intake pressure, which this "
                    "recording lacks (sixdeg replay --intake).")
    return picture(pictures.torque(replay.teeth), "torque over crank angle", "No torque over a whole cycle.")


def differences(replay):
    chart = pictures.contributions(replay)
    parts = [picture(chart, "cylinder contributions",
                     "No cylinder contributions: they take two cylinders and a known phase of the cycle.")]
    if chart and replay.lacks_intake():
        parts.append(text("No intake pressure was recorded, and it moves all cylinders alike: only the differences "
                          "between cylinders count. There is no truth to compare with."))
    return parts


def said(replay):
    s = replay.summary
    first = s["first_sync_edge"]
    synced = "the crank angle was never found" if first is None else f"the crank angle is known from edge {first} on"
    words = (f"Recording {replay.title()}: wheel {s['guess'].get('wheel', '?')}, {s['edges']} edges, {s['revolutions']:.0f} revolutions; "
             f"{synced} and was lost {s['sync_losses']} times.")
    guessed = s["engine"].get("guessed")
    return words + (f" Torques depend on guesses of the engine file: {', '.join(guessed)}." if guessed else "")
