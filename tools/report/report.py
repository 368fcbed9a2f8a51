#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Draws what `sixdeg run` and `sixdeg replay` wrote into one self-contained page and prints its short tables.

usage: report.py --out REPORT.html [--figure-16 RUN RUN] [--figure-14 RUN] [--figure-15 RUN] [--figure-12 RUN]
                 [--figure-6 RUN] [--figure-5 RUN] [--driveline FOLDER]
                 [--air-path MODEL RUN] [FOLDER...]
       exit status 2 and one line for a folder that cannot be drawn
"""
import argparse
import functools
import os
import sys

import sections
from airpath_folder import AirPathModel, AirPathRun
from driveline_folder import Driveline
from folder import BadFolder, read_summary
from mixture_folder import MixtureRun
from replay_folder import Replay
from run_folder import Run

STYLE = """
body { font: 16px/1.5 system-ui, sans-serif; color: #222; max-width: 62rem; margin: 2rem auto; padding: 0 1rem; }
h1 { font-weight: 600; margin-bottom: 0; } h2 { margin-top: 3rem; border-bottom: 1px solid #ddd; font-weight: 600; }
p.lead { color: #555; margin-top: .2rem; } p.note { color: #555; font-size: .85rem; margin: .4rem 0; }
img { width: 100%; margin: .6rem 0; } table { border-collapse: collapse; }
th { text-align: left; font-weight: 600; } td, th { padding: .15rem 1.2rem .15rem 0; } td:first-child { color: #555; }
ul.assumed { color: #8a4b00; } p.none { color: #555; font-style: italic; }
"""


def open_folder(path):
    """A run, which has a scenario, or a replay."""
    return Run(path) if "scenario" in read_summary(path, ()) else Replay(path)


def page(parts):
    text = "\n".join(sections.section(folder, build) for folder, build in parts)
    lead = "Crank teeth and one lambda sensor, simulated and recorded, through the firmware that runs on the engine controller."
    return ('<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><title>sixdeg: torque and mixture of every cylinder</title>'
            f"<style>{STYLE}</style></head>\n<body><h1>Torque and mixture of every cylinder</h1>"
            f'<p class="lead">{lead}</p>\n{text}\n</body></html>\n')


def print_table(folder):
    print(f"\n  {folder.title()}")
    rows = ([folder.HEADER] if folder.HEADER else []) + folder.figures()
    width = max(len(row[0]) for row in rows)
    for name, *values in rows:
        print(f"    {name:<{width}}  " + "".join(f"{value:<12}" for value in values).rstrip())
    for assumption in folder.assumptions():
        print(f"    ! {assumption}")


def main():
    parser = argparse.ArgumentParser(description="one self-contained page from folders of sixdeg run and sixdeg replay")
    parser.add_argument("folders", nargs="*", metavar="FOLDER")
    parser.add_argument("--figure-16", nargs=2, metavar="RUN",
                        help="document 004, figure 16: trims from lambda, and from torque")
    for figure, what in (("14", "1500 rpm, 9 bar"), ("15", "1500 rpm, 6 bar"), ("12", "3500 rpm, no noise")):
        parser.add_argument(f"--figure-{figure}", metavar="RUN", help=f"document 004: injectors moved at {what}")
    parser.add_argument("--figure-6", metavar="RUN", help="document 004, section 3.3.3: 1000 rpm, 5 bar")
    parser.add_argument("--figure-5", metavar="RUN", help="document 004, section 3.3.1: 1500 rpm, 2 bar")
    parser.add_argument("--driveline", metavar="FOLDER", help="document 003, figure 6: of sixdeg study driveline figure-6")
    parser.add_argument("--air-path", nargs=2, metavar=("MODEL", "RUN"),
                        help="document 001, figures 4 to 9: of sixdeg study airpath model, and of sixdeg run airpath_section7.toml")
    parser.add_argument("--out", required=True, metavar="REPORT.html")
    options = parser.parse_args()
    trajectories = {figure: getattr(options, f"figure_{figure}") for figure in ("14", "15", "12")}
    documented = ((options.figure_6, sections.figure_6_section), (options.figure_5, sections.figure_5_section))
    try:
        parts = []
        if options.figure_16:
            run, other = map(MixtureRun, options.figure_16)
            parts.append((run, functools.partial(sections.figure_16_section, other=other)))
        parts += [(MixtureRun(path), functools.partial(sections.trajectory_section, figure=figure))
                  for figure, path in trajectories.items() if path]
        parts += [(Run(path), build) for path, build in documented if path]
        if options.driveline:
            parts.append((Driveline(options.driveline), sections.driveline_section))
        if options.air_path:
            parts += [(AirPathModel(options.air_path[0]), sections.airpath_model_section), (AirPathRun(options.air_path[1]),
                    sections.airpath_run_section)]
        parts += [(open_folder(path), None) for path in options.folders]
        if not parts:
            raise BadFolder("no folder given")
        text = page(parts)
    except BadFolder as error:
        print(f"report: {error}", file=sys.stderr)
        return 2
    with open(options.out + ".partial", "w", encoding="utf-8", newline="\n") as out:
        out.write(text)
    os.replace(options.out + ".partial", options.out)
    for folder, _ in parts:
        print_table(folder)
    return 0


if __name__ == "__main__":
    sys.exit(main())
