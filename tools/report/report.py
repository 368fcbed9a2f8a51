#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Draws what `sixdeg replay` wrote into one self-contained page and prints its short table.

usage: report.py --out REPORT.html FOLDER...      exit status 2 and one line for a folder that cannot be drawn
"""
import argparse
import base64
import html
import os
import sys

from replay_folder import BadFolder, Replay

STYLE = """
body { font: 16px/1.5 system-ui, sans-serif; color: #222; max-width: 62rem; margin: 2rem auto; padding: 0 1rem; }
h1 { font-weight: 600; margin-bottom: 0; } h2 { margin-top: 3rem; border-bottom: 1px solid #ddd; font-weight: 600; }
p.lead { color: #555; margin-top: .2rem; } img { width: 100%; margin: .6rem 0; }
table { border-collapse: collapse; } td { padding: .15rem 1.2rem .15rem 0; } td:first-child { color: #555; }
ul.assumed { color: #8a4b00; } p.none { color: #555; font-style: italic; }
"""


def picture(png, name, missing):
    if png is None:
        return f'<p class="none">{html.escape(missing)}</p>'
    return f'<img alt="{html.escape(name)}" src="data:image/png;base64,{base64.b64encode(png).decode()}">'


def section(replay):
    # Imported late: a bad folder is reported at once, not after the plotting library has loaded.
    import pictures

    rows = "".join(f"<tr><td>{html.escape(k)}</td><td>{html.escape(v)}</td></tr>" for k, v in replay.figures())
    parts = [f"<h2>{html.escape(replay.recording())}</h2>", f"<table>{rows}</table>",
             picture(pictures.speed(replay.teeth), "speed over time", "No speed: the decoder never synced."),
             picture(pictures.mark(replay.teeth), "teeth around a mark", "No mark with decoded teeth on both sides."),
             picture(pictures.torque(replay.teeth), "torque over crank angle", "No torque over a whole cycle.")]
    assumed = replay.assumptions()
    if assumed:
        items = "".join(f"<li>{html.escape(a)}</li>" for a in assumed)
        parts.append(f'<h3>What the torque rests on</h3><ul class="assumed">{items}</ul>')
    return "\n".join(parts)


def page(replays):
    sections = "\n".join(section(r) for r in replays)
    return (f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><title>sixdeg: crank teeth and torque</title>'
            f"<style>{STYLE}</style></head>\n<body><h1>Crank teeth and torque</h1>"
            f'<p class="lead">Recorded edges, replayed through the firmware that runs on the engine controller.</p>\n'
            f"{sections}\n</body></html>\n")


def print_table(replay):
    width = max(len(name) for name, _ in replay.figures())
    print()
    for name, value in replay.figures():
        print(f"  {name:<{width}}  {value}")
    for assumption in replay.assumptions():
        print(f"  ! {assumption}")
    print()


def main():
    parser = argparse.ArgumentParser(description="one self-contained page from folders of sixdeg replay")
    parser.add_argument("folders", nargs="+", metavar="FOLDER")
    parser.add_argument("--out", required=True, metavar="REPORT.html")
    options = parser.parse_args()
    try:
        replays = [Replay(folder) for folder in options.folders]
    except BadFolder as error:
        print(f"report: {error}", file=sys.stderr)
        return 2
    text = page(replays)
    with open(options.out + ".partial", "w", encoding="utf-8", newline="\n") as out:
        out.write(text)
    os.replace(options.out + ".partial", options.out)
    for replay in replays:
        print_table(replay)
    return 0


if __name__ == "__main__":
    sys.exit(main())
