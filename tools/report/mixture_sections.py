# SPDX-License-Identifier: MIT
"""Mixture of the cylinders and fuel trims: document 004's Figures 12, 14, 15 and 16."""
import mixture_pictures as pictures
import settings
from mixture_folder import MixtureRun, names
from page import listed, picture, table, text

METHODS = {1: "the project's joint filter", 2: "the document's chain, its sensor inverted by oscillators",
           3: "the document's own chain, its sensor inverted by the adaptive Fourier law"}
CONDITIONS = {"12": "As in the document, a simulation without sensor noise.", "14": "Sensor noise 0.5 % of a 6 deg sample.",
              "15": "At a lower load; sensor noise as above."}


def method(run):
    return METHODS[round(run.summary["parameters"].get("afr.method", 1))]


def mixture_words(run):
    s = run.summary
    return text(f"Simulated, so the truth is known: {s['engine']['name']}; seed {s['seed']}. The mixture is drawn as the document's "
                "lambda, 1 - air/gas of what a cylinder lets out: its burned share.", "lead")


def estimators(runs):
    """A numbered list, as the pictures and tables number the runs."""
    return text("Estimators:") + listed([f"{method(run)}. {settings.words(run.summary)}" for run in runs], "note", "ol")


def error(run):
    afr = run.summary["afr"]
    return f"{afr['rms_points']:.2f} % of the mean" if afr else "not scored: never valid in these cycles"


def said(run):
    """What the mixture's estimate, or the trims, came to."""
    balance = run.summary["balance"]
    if balance:
        cycles = balance["cycles_to_3_percent"]
        reached = f"within 3 % after {cycles:.0f} cycles" if cycles >= 0 else "not within 3 % by the end"
        return (f"Fuel trims, {run.title()}: cylinders that were {balance['spread_before_percent']:.1f} % apart in mixture are {reached}, "
                f"and a cylinder's mean distance from the mean of all is {balance['residual_percent']:.2f} % at the end.")
    afr = run.summary["afr"]
    if not afr:
        return f"Mixture of each cylinder from one lambda sensor, {run.title()}: no valid estimate."
    stated = f"; the firmware states {afr['stated_points']:.2f} %" if "stated_points" in afr else ""
    return (f"Mixture of each cylinder from one lambda sensor, {run.title()}: wrong by {afr['rms_points']:.2f} % of the mean "
            f"(rms{stated}). A change is followed, to 80 %, after: {run.convergence()}.")


def figure_16_section(runs):
    """Document 004, figure 16: trims from the estimated mixture, and the same from torque alone, or by the document's own chain."""
    run, *others = runs

    def spread(of, cycles):
        return f"{of.imep_spread_percent(cycles):.1f} %"

    on = run.switched_on()
    before, last = slice(on - 20, on), slice(-20, None)
    claims = [("torque of the cylinders, spread before the control is on", "to be seen in the figure",
               *(spread(of, before) for of in runs)),
              ("the same, last 20 cycles", "\"able to balance the torque\"", *(spread(of, last) for of in runs))]
    for rows in zip(*(of.figures() for of in runs)):
        claims.append((rows[0][0], "", *(" / ".join(values) for _, *values in rows)))
    return [mixture_words(run), picture(pictures.figure_16(run), "balance from lambda over time"),
            text("The document shows IMEP above and the estimated AFR below, for the same sequence on a test bench. IMEP: mean of 10 "
                 "cycles. Grey: trims off. The last row is the largest cylinder less the smallest, of the mean."),
            picture(pictures.switched_on(runs), "spread after switching on, by source of the trims"),
            table(claims, ("claim, nominal / perturbed", "document 004", *names(runs, MixtureRun.source))),
            estimators(runs),
            text("Perturbed: the same run with a calibration that is wrong by amounts drawn from the seed, compression and "
                 "trapped mass of single cylinders among them. What that makes of the torques stays in the trims; the mixture "
                 "needs only the phase of the gas.")]


def trajectory_section(runs, figure):
    """Document 004, figures 12, 14 and 15: the estimate while injectors are moved one by one; a panel an estimator."""
    rows = [("convergence", "within 4 engine cycles", *(run.convergence() for run in runs)),
            ("error of a cylinder, rms of the last cycles", "none printed",
             *(error(run) for run in runs))]
    return [mixture_words(runs[0]), picture(pictures.trajectory(runs), "mixture while injectors move"),
            table(rows, ("claim", "document 004", *names(runs))),
            estimators(runs),
            text("Convergence: from the first exhaust of a step until the estimate has taken up 80 % of it. " + CONDITIONS[figure])]
