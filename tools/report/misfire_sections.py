# SPDX-License-Identifier: MIT
"""Misfires: the monitor's verdicts, and document 000's observers on the same teeth."""
import html

import misfire_pictures as pictures
import settings
from page import picture, table, text


def rate(of):
    """"45 of 45 (100.0 %, between 92.1 and 100.0 % with 95 % confidence)"."""
    if not of["of"]:
        return "none of none"
    low, high = of["bounds_95_percent"]
    return f"{of['hits']} of {of['of']} ({of['percent']:.2f} %; with 95 % confidence between {low:.2f} and {high:.2f} %)"


def said(run):
    score = run.score
    return (f"Misfire, judged by {run.method()}: {rate(score['detected'])} misfires were found, and {rate(score['false_alarms'])} healthy "
            f"firings were called one. The index of healthy firings and that of misfires lie {score['separation']:.1f} standard "
            "deviations apart.")


def section(runs):
    """runs: of one scenario and seed, so of the same teeth; the first is the one that is looked at closely."""
    first, *others = runs
    parts = [text(f"Simulated, so the truth is known: {first.summary['engine']['name']}, {first.summary['scenario']}, seed "
                  f"{first.summary['seed']}. {settings.words(first.summary)}", "lead"),
             text("The index of a firing is its torque over what its fuel should give: 1 is healthy, 0 gave nothing. Below the limit it is "
                  "a misfire. Each point is one firing; its colour is the truth."),
             picture(pictures.index(runs), "index of every firing and its limit"),
             picture(pictures.counts(first), "misfires by cylinder"),
             table(first.figures(), first.HEADER)]
    for other in others:
        score = other.score
        parts += [f"<h3>The same teeth by {html.escape(score['method'])} of document 000</h3>",
                  text(f"{rate(score['detected'])} misfires found, {rate(score['false_alarms'])} healthy firings called one; "
                       f"{score['separation']:.1f} standard deviations apart, where the monitor has {first.score['separation']:.1f}. "
                       f"{settings.words(other.summary)} The observer's estimate of the crank's acceleration, a mean over each firing:"),
                  picture(pictures.acceleration(other), f"acceleration by {score['method']}")]
    return parts


WORDS = {"own": "Engines as their file says", "other": "Engines of other physics, which no calibration knows of"}


def study_section(curves):
    """Six detectors on the same made teeth, document 000's observers among them."""
    kind, road = curves.kinds()[0], curves.roads()[0]
    parts = [text("Misfires found over the share of healthy firings that are called one, on edge times of simulated engines with "
                  "misfires 1 in 50 that nobody told of. A detector is better the higher its curve is at the left. FOLSMO, FOSMO "
                  "and ROO are document 000's observers; speed delta and running mean are methods of open engine controllers. Each "
                  "curve has the best limit at each operating point, which somebody could set who knew the truth; the dot is the "
                  "monitor as it is.", "lead"),
             text(f"Operating points: {curves.where()}. {curves.misfires(kind, curves.physics()[-1], road)} misfires a panel. All settings "
                  "are at their defaults. The whole set of engines, with intervals: docs/results/misfire-study.md.", "note")]
    for physics in curves.physics():
        parts += [f"<h3>{WORDS.get(physics, html.escape(physics))}</h3>",
                  picture(pictures.detectors(curves, physics), "misfires found over false alarms")]
    return parts
