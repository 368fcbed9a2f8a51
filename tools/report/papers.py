# SPDX-License-Identifier: MIT
"""The figures and tables of the five papers: where each is in the report, or why it is not.

A paper is named by its number here; docs/reference/references.md has its authors and title."""
import html

SCHEMATIC = "a diagram of the method, without data"
# (paper, what it is, section of the report that has it, or None with the reason)
FIGURES = (
    ("000", "Figures 1 and 2: speed, its estimate and error, a cylinder fails", "figure-000-1", ""),
    ("000", "Figures 3 and 4: acceleration, healthy and with a cylinder that fails", "figure-000-3", ""),
    ("000", "Table 2: bands of error and convergence", "table-000-2", ""),
    ("001", "Figures 1 to 3: testbed and its signals", None, SCHEMATIC),
    ("001", "Figure 4: inputs of the model", "figure-001-4", ""),
    ("001", "Figures 5 and 6: manifold pressures", "figure-001-5", ""),
    ("001", "Figure 7: gas of the cylinders", "figure-001-7", ""),
    ("001", "Figure 8: scheme of the residuals", None, SCHEMATIC),
    ("001", "Figure 9 and Table 2: faults of valve and vanes", "figure-001-9", ""),
    ("002", "Figure 1: turbocharged engine", None, SCHEMATIC),
    ("002", "Table 1: observability index of three sensors", "table-002-1", ""),
    ("003", "Figures 1, 3, 4, 5: structure of model and observers", None, SCHEMATIC),
    ("003", "Figure 2: torque of the shaft over its torsion", "figure-003-2", ""),
    ("003", "Figure 6: torsion and residuals", "figure-003-6", ""),
    ("004", "Figures 1, 3, 4, 8, 13: engine, prototyping system, masses, exhaust, blocks", None, SCHEMATIC),
    ("004", "Figure 2: cylinder pressure, model and bench", "figure-004-2", ""),
    ("004", "Figure 5: harmonics of the torque", "figure-004-5", ""),
    ("004", "Figure 6: torque by two observers, simulation", "figure-004-6", ""),
    ("004", "Figure 7: torque by the observer, engine", "figure-004-7", ""),
    ("004", "Figure 9: flow from a cylinder", "figure-004-9", ""),
    ("004", "Figure 10: flow through the turbine", "figure-004-10", ""),
    ("004", "Figure 11: lambda sensor, one injector off", "figure-004-11", ""),
    ("004", "Figure 12: mixture, simulation at 3500 rpm", "figure-004-12", ""),
    ("004", "Figure 14: mixture, 1500 rpm, 9 bar", "figure-004-14", ""),
    ("004", "Figure 15: mixture, 1500 rpm, 6 bar", "figure-004-15", ""),
    ("004", "Table 2: time of each block", "table-004-2", ""),
    ("004", "Figure 16: torque balancing", "figure-004-16", ""),
)


def index(anchors):
    """A table of all, with links to those that this report has."""
    rows = []
    for paper, what, anchor, reason in FIGURES:
        if anchor in anchors:
            place = f'<a href="#{anchor}">drawn</a>'
        else:
            place = html.escape(reason or "not drawn: its folder was not given to the report")
        rows.append(f"<tr><td>document {paper}</td><td>{html.escape(what)}</td><td>{place}</td></tr>")
    return f"<table class=\"papers\">{''.join(rows)}</table>"
