# SPDX-License-Identifier: MIT
"""Torque of runs: contributions of cylinders, waveforms, document 004's Figures 5 and 6."""
import run_pictures as pictures
import settings
from page import picture, table, text
from waveform import Waveforms

MISSING_WAVES = "No torque to compare: no whole cycle with a valid estimate, or the speed is prescribed."


def waves_of(run):
    """The run's waveforms; None where it has none."""
    return Waveforms(run) if run.cycles() else None


def what_was_run(run):
    s = run.summary
    words = [f"Simulated, so the truth is known: {s['engine']['name']}",
             f"firmware in {s['number']}, n_h = {run.harmonics()}", f"seed {s['seed']}", *run.assumptions()]
    return text(f"{'; '.join(words)}. {settings.words(s)}", "lead")


def contributions(run):
    nominal, perturbed = run.summary["cylinders"], (run.summary["perturbed"] or {}).get("cylinders")
    if not nominal:
        return [text("No torque of single cylinders to compare.", "none")]
    return [picture(pictures.contributions(nominal, perturbed), "cylinder contributions"),
            text("By the adaptive Fourier observer. The short lines on the bars are the standard deviation that the firmware itself "
                 "states; it covers the noise of tooth times, not an error of the calibration.")]


def accuracy(run):
    parts = [table(run.figures(), run.HEADER)]
    if run.summary["torque"]:
        parts.append(text(f"Over the last {run.summary['torque']['cycles_measured']} cycles. Torques of cylinders in "
                          "percent of their true mean, waveforms of the true peak to peak."))
    drawn = (run.summary["perturbed"] or {}).get("calibration")
    if drawn:
        ranges = drawn["ranges"]
        parts.append(text("Perturbed: a second run whose calibration is wrong by amounts drawn from the seed: inertia "
                          f"{drawn['inertia_percent']:+.1f} % (of +-{ranges['inertia_percent']:g}), reciprocating mass "
                          f"{drawn['reciprocating_percent']:+.1f} % (+-{ranges['reciprocating_percent']:g}), wheel "
                          f"{drawn['wheel_offset_deg']:+.2f} deg (+-{ranges['wheel_offset_deg']:g}), and of each cylinder "
                          f"compression (+-{ranges['compression_percent']:g} %) and trapped mass "
                          f"(+-{ranges['trapped_mass_percent']:g} %)."))
    return parts


def waveform(run, waves):
    if not waves:
        return [text(MISSING_WAVES, "none")]
    return [picture(pictures.waveform(waves, run.firings()), "torque over one cycle")]


def decomposition(waves):
    if not waves:
        return [text(MISSING_WAVES, "none")]
    return [picture(pictures.decomposition(waves), "torque and its harmonics")]


def said(run):
    """The accuracy of cylinders' torques, in a sentence; nothing where there is none."""
    nominal, perturbed = run.summary["cylinders"], (run.summary["perturbed"] or {}).get("cylinders")
    if not nominal:
        return ""
    words = (f"Torque of each cylinder, {run.title()}: its difference from the mean of all is wrong by at most "
             f"{nominal['imbalance_percent']:.2f} % of that mean")
    if perturbed:
        words += f", and by {perturbed['imbalance_percent']:.2f} % with a calibration that is wrong on purpose"
    return words + f". The firmware itself states a standard deviation of {max(nominal['sd_nm']):.2f} N m."


def run_section(run):
    waves = waves_of(run)
    return [what_was_run(run), *contributions(run), *accuracy(run), *waveform(run, waves), *decomposition(waves)]


def figure_6_section(run):
    """Document 004, section 3.3.3 and figure 6, with what it claims there."""
    waves = waves_of(run)
    parts = [what_was_run(run), *waveform(run, waves)]
    if waves:
        claims = [("phase shift of the adaptive Fourier observer", "none", f"{waves.shift_deg:+.2f} deg"),
                  ("phase shift of pole placement", "18 deg", f"{waves.pole_lag_deg:+.1f} deg"),
                  (f"largest torque, of that of the best {waves.n_h} harmonics", "almost reached",
                   f"{waves.peak_percent:.1f} %")]
        parts += [table(claims, ("claim", "document 004", "here")),
                  text("Estimators: the document's adaptive Fourier observer in the firmware (torque.mass), the project's filter on tooth "
                       "times (firing.waveform), and pole placement, which the document compares with, in Python. All get the same tooth "
                       "times. Torque less load and friction, which move all of a curve alike. Shifts are where a curve correlates "
                       f"best with the truth, or with its first {waves.n_h} harmonics: more an estimate of {waves.n_h} "
                       "cannot show, and where these peak later than the truth, so does the estimate. The document "
                       "does not print the poles of pole placement; here both are at -6/rad, to settle within a firing interval.")]
    return [*parts, *contributions(run), *accuracy(run)]


def figure_5_section(run):
    """Document 004, figure 5, with what section 3.3.1 claims."""
    waves = waves_of(run)
    parts = [what_was_run(run), *decomposition(waves)]
    if waves:
        left_out = waves.left_out_percent()
        here = ", ".join(f"{percent:.1f} %" for percent in left_out.values())
        parts += [table([("harmonics that represent the torque well", "at least 5",
                          f"{', '.join(map(str, left_out))} leave out {here}")], ("claim", "document 004", "here")),
                  text("No estimator: the true torque of the last cycle and its own harmonics, by least squares over the teeth. "
                       "What is left out is an rms, in percent of peak to peak. Harmonics count from one period a "
                       "cycle, 720 deg: a four-cylinder that fires evenly has none below the fourth.")]
    return parts
