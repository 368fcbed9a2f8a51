# SPDX-License-Identifier: MIT
"""Document 001's figures: the air path's model, and the faults of its actuators."""
import airpath_pictures as pictures
import settings
from page import picture, table, text

MODEL_WORDS = ("The true ones are of the full air path of the simulated engine; nothing was fitted to this drive. The model is the "
               "four-state one that the firmware's observers use, without an observer.")


def figure_4_section(model):
    return [text("What goes into the engine, over the drive of the following figures; without an estimator.", "lead"),
            picture(pictures.figure_4(model), "speed, fuel and air, valve and vanes")]


def figures_5_and_6_section(model):
    return [text("Both manifolds' pressures: measured, true, and of the model with its error. " + MODEL_WORDS, "lead"),
            picture(pictures.figure_5_and_6(model), "pressures and the model's error"), table(model.figures(), model.HEADER)]


def figure_7_section(model):
    return [text("The cylinders' gas. " + MODEL_WORDS, "lead"), picture(pictures.figure_7(model), "gas into and out of the cylinders")]


def faults_section(run):
    return [text("What the firmware says of a step of the EGR valve and one of the vanes (Figure 9). Two observers, each blind to one "
                 "actuator (Figure 8 is their diagram).", "lead"),
            text("Estimators: the two unknown-input observers of the firmware (the document's, with gains of our design), their learned "
                 f"offsets, and the multi-CUSUM. {settings.words(run.summary)}"),
            picture(pictures.figure_9(run), "actuators, normalised residuals, decision functions"), table(run.figures(), run.HEADER),
            text("Table 2 as measured: mean of each residual in the last half of each fault, in standard deviations of a healthy one."),
            table(run.incidence(), ("fault", "residual 1", "residual 2"))]


def said(run):
    faults = [f"a fault of the {what} from {start} on is " + ("not found" if delay == "not found" else f"named {named} after {delay}")
              for what, start, named, delay in run.figures()]
    return "Air path, section 7 of document 001: " + "; ".join(faults) + "."
