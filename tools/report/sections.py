# SPDX-License-Identifier: MIT
"""The sections of the page, as HTML, and what they say in words."""
import base64
import html

import controller
from run_folder import Run

MISSING_WAVES = "No torque to compare: no whole cycle with a valid estimate, or the speed is prescribed."


def table(rows, header=()):
    head = "".join(f"<th>{html.escape(cell)}</th>" for cell in header)
    body = "".join("<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
    return f"<table>{f'<tr>{head}</tr>' if header else ''}{body}</table>"


def text(words, kind="note"):
    return f'<p class="{kind}">{html.escape(words)}</p>'


def picture(png, name, missing=""):
    if png is None:
        return text(missing, "none")
    return f'<img alt="{html.escape(name)}" src="data:image/png;base64,{base64.b64encode(png).decode()}">'


def assumed(items):
    if not items:
        return ""
    lines = "".join(f"<li>{html.escape(a)}</li>" for a in items)
    return f'<h3>What the torque rests on</h3><ul class="assumed">{lines}</ul>'


def replay_section(replay):
    # Imported late: a bad folder is reported at once, not after the plotting library has loaded.
    import replay_pictures as pictures

    return [table(replay.figures()),
            picture(pictures.speed(replay.teeth), "speed over time", "No speed: the decoder never synced."),
            picture(pictures.mark(replay.teeth), "teeth around a mark", "No mark with decoded teeth on both sides."),
            _torque(replay),
            *_differences(replay),
            assumed(replay.assumptions())]


def _torque(replay):
    import replay_pictures as pictures

    if replay.lacks_intake():
        return text("No torque over crank angle: compression makes most of it, and how much follows from the intake pressure, which this "
                    "recording lacks (sixdeg replay --intake).")
    return picture(pictures.torque(replay.teeth), "torque over crank angle", "No torque over a whole cycle.")


def _differences(replay):
    import replay_pictures as pictures

    png = pictures.contributions(replay)
    parts = [picture(png, "cylinder contributions",
                     "No cylinder contributions: they take two cylinders and a known phase of the cycle.")]
    if png and replay.lacks_intake():
        parts.append(text("No intake pressure was recorded, and it moves all cylinders alike: only the differences "
                          "between cylinders count. There is no truth to compare with."))
    return parts


def _waves(run):
    """The run's waveforms; None where it has none."""
    from waveform import Waveforms

    return Waveforms(run) if run.cycles() else None


def _what_was_run(run):
    s = run.summary
    words = [f"Simulated, so the truth is known: {s['engine']['name']}",
             f"firmware in {s['number']}, n_h = {run.harmonics()}", f"seed {s['seed']}", *run.assumptions()]
    return text("; ".join(words) + ".", "lead")


def _contributions(run):
    nominal, perturbed = run.summary["cylinders"], (run.summary["perturbed"] or {}).get("cylinders")
    if not nominal:
        return [text("No torque of single cylinders to compare.", "none")]
    import run_pictures as pictures

    return [picture(pictures.contributions(nominal, perturbed), "cylinder contributions"),
            text("The short lines on the bars are the standard deviation that the firmware itself states; it covers "
                 "the noise of tooth times, not an error of the calibration.")]


def _accuracy(run):
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


def _waveform(run, waves):
    if not waves:
        return [text(MISSING_WAVES, "none")]
    import run_pictures as pictures

    return [picture(pictures.waveform(waves, run.firings()), "torque over one cycle")]


def _decomposition(waves):
    if not waves:
        return [text(MISSING_WAVES, "none")]
    import run_pictures as pictures

    return [picture(pictures.decomposition(waves), "torque and its harmonics")]


def run_section(run):
    waves = _waves(run)
    return [_what_was_run(run), *_contributions(run), *_accuracy(run), *_waveform(run, waves), *_decomposition(waves)]


def figure_6_section(run):
    """Document 004, section 3.3.3 and figure 6, with what it claims there."""
    waves = _waves(run)
    parts = [_what_was_run(run), *_contributions(run), *_accuracy(run),
             "<h3>Figure 6 of document 004, redrawn</h3>", *_waveform(run, waves)]
    if waves:
        claims = [("phase shift of the adaptive Fourier observer", "none", f"{waves.shift_deg:+.2f} deg"),
                  ("phase shift of pole placement", "18 deg", f"{waves.pole_lag_deg:+.1f} deg"),
                  (f"largest torque, of that of the best {waves.n_h} harmonics", "almost reached",
                   f"{waves.peak_percent:.1f} %")]
        parts += [table(claims, ("claim", "document 004", "here")),
                  text("Torque less load and friction, which move all of a curve alike. Shifts are where a curve correlates "
                       f"best with the truth, or with its first {waves.n_h} harmonics: more an estimate of {waves.n_h} "
                       "cannot show, and where these peak later than the truth, so does the estimate. The document "
                       "does not print the poles of pole placement; here both are at -6/rad, to settle within a firing "
                       "interval. Both observers get the same tooth times.")]
    return parts


def figure_5_section(run):
    """Document 004, figure 5, with what section 3.3.1 claims."""
    waves = _waves(run)
    parts = [_what_was_run(run), "<h3>Figure 5 of document 004, redrawn</h3>", *_decomposition(waves)]
    if waves:
        left_out = waves.left_out_percent()
        here = ", ".join(f"{percent:.1f} %" for percent in left_out.values())
        parts += [table([("harmonics that represent the torque well", "at least 5",
                          f"{', '.join(map(str, left_out))} leave out {here}")], ("claim", "document 004", "here")),
                  text("What is left out is an rms, in percent of peak to peak. Harmonics count from one period a "
                       "cycle, 720 deg: a four-cylinder that fires evenly has none below the fourth.")]
    return parts


def _mixture_words(run):
    s = run.summary
    words = [f"Simulated, so the truth is known: {s['engine']['name']}", f"seed {s['seed']}",
             "lambda is the document's: 1 - air/gas of what a cylinder lets out, its burned share"]
    return text("; ".join(words) + ".", "lead")


def figure_16_section(run, other):
    """Document 004, figure 16: trims from the estimated mixture, and the same from torque alone."""
    import mixture_pictures as pictures

    def figures(of, cycles):
        return f"{of.imep_spread_percent(cycles):.1f} %"

    on = run.switched_on()
    before, last = slice(on - 20, on), slice(-20, None)
    claims = [("torque of the cylinders, spread before the control is on", "to be seen in the figure", figures(run, before), figures(other, before)),
              ("the same, last 20 cycles", "\"able to balance the torque\"", figures(run, last), figures(other, last))]
    for (name, *values), (_, *others) in zip(run.figures(), other.figures()):
        claims.append((name, "", " / ".join(values), " / ".join(others)))
    return [_mixture_words(run), "<h3>Figure 16 of document 004, redrawn: trims from one lambda sensor</h3>",
            picture(pictures.figure_16(run), "balance from lambda over time"),
            text("The document shows IMEP above and the estimated AFR below, for the same sequence on a test bench. IMEP: pale, "
                 "single cycles; bold, mean of 10. Grey: trims off. The last row is the largest cylinder less the smallest, "
                 "of the mean."),
            "<h3>The same from torque alone</h3>",
            picture(pictures.switched_on([run, other]), "spread after switching on, from lambda and from torque"),
            table(claims, ("claim", "document 004", "from lambda, nominal / perturbed", "from torque, nominal / perturbed")),
            text("Perturbed: the same run with a calibration that is wrong by amounts drawn from the seed, compression and "
                 "trapped mass of single cylinders among them. What that makes of the torques stays in the trims; the mixture "
                 "needs only the phase of the gas.")]


def trajectory_section(run, figure):
    """Document 004, figures 12, 14 and 15: the estimate while injectors are moved one by one."""
    import mixture_pictures as pictures

    afr = run.summary["afr"]
    return [_mixture_words(run), f"<h3>Figure {figure} of document 004, redrawn</h3>",
            picture(pictures.trajectory(run), "mixture while injectors move"),
            table([("convergence", "within 4 engine cycles", run.convergence()),
                   ("error of a cylinder, rms of the last cycles", "none printed", f"{afr['rms_points']:.2f} % of the mean")],
                  ("claim", "document 004", "here")),
            text("Convergence: from the first exhaust of a step until the estimate has taken up 80 % of it. "
                 + {"12": "As in the document, a simulation without sensor noise; the filter is told so.",
                    "14": "Sensor noise 0.5 % of a 6 deg sample.", "15": "At a lower load; sensor noise as above."}[figure])]


def driveline_section(driveline):
    import driveline_picture as pictures

    return [text("10 N m less from the engine at 2 s, without noise: torsion of the shaft and its estimate, residuals of the soft and of "
                 "the stiff location, and which location was found.", "lead"),
            picture(pictures.figure_6(driveline), "torsion, residuals, locations"),
            table(driveline.figures(), driveline.HEADER)]


def _controller(folder):
    about = folder.summary.get("controller") if isinstance(folder, Run) else None
    if not about:
        return []
    return ["<h3>Your engine, on this controller</h3>", text(controller.words(about)),
            table(controller.rows(about, folder.engine), ("", "average tooth", "worst tooth"))]


def airpath_model_section(model):
    import airpath_pictures as pictures

    return [text("What goes into the engine (Figure 4), both manifolds' pressures measured, true and of the four-state model with its error "
                 "(Figures 5 and 6), and the cylinders' gas (Figure 7). The true ones are of the full air path; nothing was fitted to this drive.", "lead"),
            picture(pictures.figure_4(model), "speed, fuel and air, valve and vanes"),
            picture(pictures.figure_5_and_6(model), "pressures and the model's error"), picture(pictures.figure_7(model), "gas into and out of the cylinders"),
            table(model.figures(), model.HEADER)]


def airpath_run_section(run):
    import airpath_pictures as pictures

    return [text("Two observers, each blind to one actuator (Figure 8, Table 2: each residual in each fault, in standard deviations of a healthy one), "
                 "and what the firmware says of a step of the EGR valve and one of the vanes (Figure 9).", "lead"),
            table(run.incidence(), ("fault", "residual 1", "residual 2")),
            picture(pictures.figure_9(run), "actuators, normalised residuals, decision functions"), table(run.figures(), run.HEADER)]


def section(folder, build=None):
    """One folder's part of the page."""
    build = build or (run_section if isinstance(folder, Run) else replay_section)
    return "\n".join([f"<h2>{html.escape(folder.title())}</h2>", *build(folder), *_controller(folder)])
