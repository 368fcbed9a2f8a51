#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Draws what the commands of sixdeg wrote into one self-contained page and prints its short tables.

usage: report.py --out REPORT.html [OPTION FOLDER...]... [FOLDER...]
       each option names what its folders show; folders alone are runs and replays
       exit status 2 and one line for a folder that cannot be drawn
"""
import argparse
import functools
import html
import pathlib
import sys
from typing import Callable, NamedTuple

import airpath_sections
import controller
import cost_sections
import driveline_sections
import gas_sections
import misfire_sections
import mixture_sections
import observer_sections
import page
import papers
import pressure_sections
import replay_sections
import sensor_sections
import torque_sections
from airpath_folder import AirPathModel, AirPathRun
from cost_sections import Bench
from driveline_folder import Driveline
from folder import BadFolder, read_summary
from gas_sections import Gas
from misfire_folder import MisfireCurves, MisfireRun
from mixture_folder import MixtureRun
from observer_sections import Observers
from pressure_sections import PressureBeside
from replay_folder import Replay
from run_folder import Run
from sensor_sections import SensorSets

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import progress  # noqa: E402  the path comes first


class Kind(NamedTuple):
    """An option, how its folders are read, and the sections that they give."""
    option: str
    metavar: str
    count: object  # of folders: a number, "+" or "*"
    help: str
    read: Callable  # of each folder
    sections: tuple  # (anchor, title, build), build from what was read: of one folder itself, of several a list
    said: Callable = None  # a sentence of the summary, from what was read of the first folder


def trajectory(figure, conditions, said=None):
    return Kind(f"figure-{figure}", "RUN", "+", f"document 004: injectors moved at {conditions}; by one method, then by others", MixtureRun,
                ((f"figure-004-{figure}", f"Document 004, Figure {figure}: mixture of every cylinder, {conditions}",
                  functools.partial(mixture_sections.trajectory_section, figure=figure)),), said)


def gas(figure, conditions, title, build, count=1):
    return Kind(f"figure-{figure}", "FOLDER", count, f"document 004: of sixdeg study gas, {conditions}", Gas,
                ((f"figure-004-{figure}", f"Document 004, Figure {figure}: {title}", build),))


KINDS = (
    Kind("misfire", "RUN", "+", "runs with misfires, of one scenario and seed: by the monitor, then by observers of document 000",
         MisfireRun, (("misfire", "Misfire", misfire_sections.section),), misfire_sections.said),
    Kind("misfire-study", "FOLDER", 1, "six detectors of misfires: of sixdeg study misfire --out FOLDER", MisfireCurves,
         (("misfire-study", "Six detectors of misfires on the same teeth", misfire_sections.study_section),)),
    Kind("observers", "FOLDER", 1, "document 000: of sixdeg study observers --out FOLDER --json FOLDER/table2.json", Observers,
         (("figure-000-1", "Document 000, Figures 1 and 2: speed by FOLSMO, and its error", observer_sections.figures_1_and_2_section),
          ("figure-000-3", "Document 000, Figures 3 and 4: acceleration by FOLSMO", observer_sections.figures_3_and_4_section),
          ("table-000-2", "Document 000, Table 2: error and convergence", observer_sections.table_2_section))),
    gas("2", "6 bar", "cylinder pressure", gas_sections.figure_2_section),
    Kind("figure-5", "RUN", 1, "document 004, section 3.3.1: 1500 rpm, 2 bar", Run,
         (("figure-004-5", "Document 004, Figure 5: harmonics of the torque", torque_sections.figure_5_section),)),
    Kind("figure-6", "RUN", 1, "document 004, section 3.3.3: 1000 rpm, 5 bar", Run,
         (("figure-004-6", "Document 004, Figure 6: torque at 1000 rpm and 5 bar", torque_sections.figure_6_section),),
         torque_sections.said),
    Kind("figure-7", "FOLDER", 1, "document 004, a real engine: of tools/evidence --curves FOLDER --json FOLDER/figures.json",
         PressureBeside, (("figure-004-7", "Document 004, Figure 7: torque of a real engine", pressure_sections.section),),
         pressure_sections.said),
    gas("9", "11 bar", "flow from a cylinder", gas_sections.figure_9_section),
    gas("10", "at several loads", "flow through the turbine", gas_sections.figure_10_section, "+"),
    gas("11", "20 percent more fuel on cylinder 1", "lambda sensor with one injector off", gas_sections.figure_11_section),
    trajectory("14", "1500 rpm, 9 bar", mixture_sections.said), trajectory("15", "1500 rpm, 6 bar"), trajectory("12", "3500 rpm, no noise"),
    Kind("figure-16", "RUN", "+", "document 004: trims from lambda, from torque, and by other methods", MixtureRun,
         (("figure-004-16", "Document 004, Figure 16: torque balancing", mixture_sections.figure_16_section),), mixture_sections.said),
    Kind("air-path-model", "FOLDER", 1, "document 001: of sixdeg study airpath model", AirPathModel,
         (("figure-001-4", "Document 001, Figure 4: inputs of the air path", airpath_sections.figure_4_section),
          ("figure-001-5", "Document 001, Figures 5 and 6: pressures of the manifolds", airpath_sections.figures_5_and_6_section),
          ("figure-001-7", "Document 001, Figure 7: gas of the cylinders", airpath_sections.figure_7_section))),
    Kind("air-path", "RUN", 1, "document 001: of sixdeg run airpath_section7.toml", AirPathRun,
         (("figure-001-9", "Document 001, Figure 9 and Table 2: faults of valve and vanes", airpath_sections.faults_section),),
         airpath_sections.said),
    Kind("driveline", "FOLDER", 1, "document 003: of sixdeg study driveline figure-6", Driveline,
         (("figure-003-2", "Document 003, Figure 2: torque of the shaft", driveline_sections.figure_2_section),
          ("figure-003-6", "Document 003, Figure 6: torsion of the driveline", driveline_sections.figure_6_section)),
         driveline_sections.said),
    Kind("sensors", "FILE", 1, "document 002: of sixdeg sensors host_sim/data/models/turbo_si_13.toml --json FILE", SensorSets,
         (("table-002-1", "Document 002, Table 1: choice of three sensors", sensor_sections.section),)),
    Kind("bench", "FILE", 1, "document 004, table 2: of sixdeg bench blocks --json FILE", Bench,
         (("table-004-2", "Document 004, Table 2: time of each block", cost_sections.section),)),
)


class Section(NamedTuple):
    anchor: str
    title: str
    parts: list  # as HTML


def of_folder(path, number):
    """A run, which has a scenario, or a replay: what was read, its section, its sentence."""
    if "scenario" in read_summary(path, ()):
        run = Run(path)
        return run, Section(f"run-{number}", run.title(), torque_sections.run_section(run) + of_controller(run)), torque_sections.said(run)
    replay = Replay(path)
    return replay, Section(f"recording-{number}", replay.title(), replay_sections.replay_section(replay)), replay_sections.said(replay)


def of_controller(run):
    about = run.summary.get("controller")
    if not about:
        return []
    return ["<h3>Your engine, on this controller</h3>", page.text(controller.words(about)),
            page.table(controller.rows(about, run.engine), ("", "average tooth", "worst tooth"))]


def gathered(options):
    """All that the options name: what was read, sections, sentences."""
    read, sections, said = [], [], []
    for kind in KINDS:
        paths = getattr(options, kind.option.replace("-", "_"))
        if not paths:
            continue
        of_kind = [kind.read(path) for path in paths]
        read += of_kind
        given = of_kind[0] if kind.count == 1 else of_kind
        sections += [Section(anchor, title, build(given)) for anchor, title, build in kind.sections]
        if kind.said and (words := kind.said(of_kind[0])):
            said.append((words, kind.sections[0][0]))
    for number, path in enumerate(options.folders, 1):
        one, section, words = of_folder(path, number)
        read.append(one)
        sections.append(section)
        if words:
            said.append((words, section.anchor))
    if not sections:
        raise BadFolder("no folder given")
    return read, sections, said


def engines(read):
    """The engines of runs and replays, each once, with what nobody measured of it."""
    found = {}
    for one in read:
        engine = getattr(one, "summary", {}).get("engine") or {}
        if engine.get("name"):
            found[engine["name"]] = engine.get("guessed") or []
    return found


def summary(read, said):
    of = [f"{html.escape(name)}{html.escape(' (guessed in its file: ' + ', '.join(guessed) + ')') if guessed else ''}"
          for name, guessed in engines(read).items()]
    parts = ["<h2>Summary</h2>"]
    if of:
        parts.append("<p>Engines: " + "; ".join(of) + ".</p>")
    points = [f'<li>{html.escape(words)} <a href="#{anchor}">Pictures</a></li>' for words, anchor in said]
    parts.append('<ul class="first">' + "".join(points) + "</ul>")
    parts.append(page.text("A simulated engine has a known truth, and errors are against it."))
    parts.append(page.text("Every picture can be zoomed by drawing a rectangle, reset by a double click, and a click on a name in its "
                           "legend switches that trace off.", "note screen"))
    return parts


def whole(read, sections, said):
    lead = "Crank teeth and one lambda sensor, simulated and recorded, through the firmware that runs on the engine controller."
    contents = "".join(f'<li><a href="#{s.anchor}">{html.escape(s.title)}</a></li>' for s in sections)
    body = ["<h1>Torque, misfire and mixture of every cylinder</h1>", page.text(lead, "lead"), *summary(read, said),
            f"<nav><h2>Contents</h2><ul>{contents}<li><a href=\"#papers\">Figures of the papers</a></li></ul></nav>"]
    body += [f'<section id="{s.anchor}"><h2>{html.escape(s.title)}</h2>\n' + "\n".join(s.parts) + "</section>" for s in sections]
    body.append('<section id="papers"><h2>Figures of the papers</h2>' + papers.index({s.anchor for s in sections}) + "</section>")
    return page.whole("sixdeg: torque, misfire and mixture of every cylinder", body)


def print_table(folder):
    print(f"\n  {folder.title()}")
    rows = ([folder.HEADER] if folder.HEADER else []) + folder.figures()
    width = max(len(row[0]) for row in rows)
    for name, *values in rows:
        print(f"    {name:<{width}}  " + "".join(f"{value:<12}" for value in values).rstrip())
    for assumption in folder.assumptions():
        print(f"    ! {assumption}")


def main():
    parser = argparse.ArgumentParser(description="one self-contained page from folders that sixdeg wrote")
    parser.add_argument("folders", nargs="*", metavar="FOLDER")
    for kind in KINDS:
        parser.add_argument(f"--{kind.option}", nargs=kind.count, metavar=kind.metavar, help=kind.help)
    parser.add_argument("--out", required=True, metavar="REPORT.html")
    options = parser.parse_args()
    try:
        read, sections, said = gathered(options)
    except BadFolder as error:
        print(f"report: {error}", file=sys.stderr)
        return 2
    page.write(options.out, whole(read, sections, said))
    for one in read:
        print_table(one)
    return 0


if __name__ == "__main__":
    with progress.Progress("report"):
        sys.exit(main())
