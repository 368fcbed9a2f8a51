# SPDX-License-Identifier: MIT
"""Document 003's Figures 2 and 6."""
import driveline_pictures as pictures
from page import picture, table, text


def figure_2_section(_):
    return [text("The shaft is soft within the kinks, 2400 N m/rad, and stiff beyond, 8000 N m/rad. Its location is 1 wound back beyond "
                 "the kink, 2 between the kinks, 3 wound forward beyond it. A formula, drawn with the parameters of Figure 6.", "lead"),
            picture(pictures.figure_2(), "torque of the shaft over its torsion")]


def figure_6_section(driveline):
    return [text("10 N m less from the engine at 2 s, without noise: torsion of the shaft and its estimate, residuals of the soft and of "
                 "the stiff location, and which location was found.", "lead"),
            text("Estimator: the document's hybrid observer (sd_driveline_hybrid) in steps of 1 ms. Its settings: poles of the residual "
                 "generators -60, -70, -80 1/s, of the continuous observer -12, -15, -18 1/s, threshold 0.02 rpm; no location is "
                 "left before its own residual has fitted for 10 ms or 60 ms have gone by."),
            picture(pictures.figure_6(driveline), "torsion, residuals, locations"),
            table(driveline.figures(), driveline.HEADER)]


def said(driveline):
    late = [row[3] for row in driveline.figures()]
    return f"Driveline, Figure 6 of document 003: {len(late)} changes of the shaft's location, found after {', '.join(late)}."
