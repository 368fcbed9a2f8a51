#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Designs the two observers of document 001 for an engine file with an [airpath], and what its residuals decide by.

    design.py ENGINE.toml --out DESIGN.toml [--form output] [--residuals RESIDUALS.csv]
    design.py ENGINE.toml --forms      what each form of the inequality gives: feasible or not, what binds, how blind its residual is
    design.py ENGINE.toml --gain G     one product design with gains of at most G: where there is none, which constraint binds
--expect: what the decision expects of each residual, over what a fault of 0.05 leaves: more leaves room for offsets of a model that is
not the plant. --other, up to twice: what a wrong sensor or a leak leaves in both residuals, so that no actuator is named for it.
--variance: of each residual, in place of the noise's.
--residuals: healthy residuals of this design, from `sixdeg study airpath residuals --out FOLDER`: their long-run covariance is taken.
"""
import argparse
import itertools
import sys
import tomllib
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
import certificate  # noqa: E402
import covariance  # noqa: E402
import nuio  # noqa: E402
from air_path import C, AirPath  # noqa: E402
sys.path.insert(0, str(Path(__file__).parents[1]))
import progress  # noqa: E402

# Where the engine runs: speeds, openings, vanes, exhaust pressures and pressure ratios that the inequalities hold for.
RPM = (1000.0, 2000.0)
OPENINGS, VANES, EXHAUST_KPA, RATIOS = (0.1, 0.35, 0.6), (0.25, 0.44, 0.65), np.linspace(125, 350, 10), np.linspace(0.66, 0.999, 12)
MIDDLE = {"rpm": 1500.0, "air": 113.0, "fuel": 7.0, "opening": 0.35, "position": 0.44}
NOISE_KPA = (1.0, 2.0)              # of the two pressures
LEAST = {"vgt": 3.0, "egr": 2.5}    # 1/s, of the slowest pole
MOST = {"vgt": 40.0, "egr": 20.0}   # and of the fastest
FAULT = {"egr": 0.05, "vgt": -0.05} # of interest
TUNED = {"egr": 0.65, "vgt": 0.6}  # share of the residual such a fault leaves that the decision expects: less is sooner, since it rises


def limits(path):
    grid = itertools.product(OPENINGS, VANES, EXHAUST_KPA, RATIOS)
    slopes = np.array([path.slopes(o, v, r * e, e) for o, v, e, r in grid])
    return {"k": (float(path.emptying(RPM[0])), float(path.emptying(RPM[1]))), "slopes": np.stack([slopes.min(0), slopes.max(0)], 1),
            "sigma": np.array([NOISE_KPA[0], NOISE_KPA[1] / path.per_exhaust])}


def limits_of(path, name, **more):
    return nuio.Limits(**limits(path), **{"least": LEAST[name], "most": MOST[name], **more})


def middle(path):
    x = path.rest(**MIDDLE)
    exhaust = path.per_exhaust * x[3]
    slopes = path.slopes(MIDDLE["opening"], MIDDLE["position"], x[0], exhaust)
    egr = path.egr_flow(MIDDLE["opening"] + FAULT["egr"], x[0], exhaust) - path.egr_flow(MIDDLE["opening"], x[0], exhaust)
    turbine = path.turbine_flow(MIDDLE["position"] + FAULT["vgt"], exhaust) - path.turbine_flow(MIDDLE["position"], exhaust)
    return x, slopes, {"egr": float(egr), "vgt": float(turbine)}


def as_table(observer):
    return {"sees": observer.name, "output_fed": observer.output_fed, "gamma": [1.0, 0.0], "m": observer.m.tolist(),
            "e": observer.e.tolist(),
            "k_low": observer.k[0].tolist(), "k_high": observer.k[1].tolist(), "p": observer.figures["p"].tolist()}


def design(path, form, residuals):
    observers = [nuio.solve(path, limits_of(path, name), name, form) for name in ("vgt", "egr")]
    state, slopes, fault = middle(path)
    rate, lim = float(path.emptying(MIDDLE["rpm"])), limits(path)
    file = {"design": {"k": list(lim["k"]), "slopes": lim["slopes"].tolist(), "sigma": lim["sigma"].tolist(), "middle_k": rate,
                       "middle_state": state.tolist(), "middle_slopes": slopes.tolist(), "fault_gps": fault},
                               "observer": [as_table(o) for o in observers]}
    shift = [certificate.shifts(path, o, file["design"])[o["sees"]] * fault[o["sees"]] for o in file["observer"]]
    white = [float(lim["sigma"][0])] * 2
    file["decision"] = {"fault_kpa": [abs(s) for s in shift], "mean_kpa": [abs(s) * TUNED[o.name] for s, o in zip(shift, observers)],
                        "sign": [float(np.sign(s)) for s in shift], "covariance": [[white[0] ** 2, 0.0], [0.0, white[1] ** 2]],
                        "source": "the noise of the intake pressure, until residuals are recorded"}
    if residuals:
        found = covariance.Covariance(covariance.read(residuals))
        found.report()
        file["decision"].update(covariance=found.long_run.tolist(), source=f"long run, {found.seconds:.0f} s of healthy residuals")
    return file


def text(value):
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return '"' + value + '"'
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(text(v) for v in value) + "]"
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{k} = {text(v)}" for k, v in value.items()) + " }"
    return f"{float(f'{value:.7g}') + 0.0!r}"


def write(file, engine, out):
    lines = ["# SPDX-License-Identifier: MIT",
            f"# Made by tools/airpath/design.py from {Path(engine).name}; do not edit. docs/theory/airpath.md says what it holds.",
             "# Units: kPa, g, s. Rows of matrices are states: intake pressure, air, recirculated gas, exhaust gas."]
    for name in ("design", "decision"):
        lines += ["", f"[{name}]"] + [f"{k} = {text(v)}" for k, v in file[name].items()]
    for observer in file["observer"]:
        lines += ["", "[[observer]]"] + [f"{k} = {text(v)}" for k, v in observer.items()]
    Path(out).write_text("\n".join(lines) + "\n")


def show_forms(path):
    rate, slopes = float(path.emptying(MIDDLE["rpm"])), middle(path)[1]
    for name in ("vgt", "egr"):
        lim = limits_of(path, name)
        for form in ("bounded", "printed", "output"):
            try:
                o = nuio.solve(path, lim, name, form)
            except nuio.Infeasible:
                print(f"{name}: {form:9s} infeasible; without it there is one: {', '.join(nuio.what_binds(path, lim, name))}")
                continue
            jacobian = np.zeros((4, 4)) if o.output_fed else o.m @ path.jacobian(slopes)
            whole = o.n(path, rate, lim.k) + jacobian
            poles = np.sort(np.linalg.eigvals(whole).real)
            whole_speed = path.per_egr   # kPa of a gram, of the decoupled design of either
            seen = np.abs(C @ o.m @ o.other)[0] / whole_speed
            print(f"{name}: {form:9s} feasible; the fault reaches the residual with {seen:.3f} of the decoupled design's speed; "
                  f"poles {poles.round(1).tolist()} 1/s")
        box = [nuio.SCALE[:, None] ** -1 * path.jacobian(s) * nuio.SCALE for s in itertools.product(*lim.slopes)]
        actual = max(np.linalg.norm(j, 2) for j in box)
        for seen, what in ((True, "that keeps the residual's sensitivity"), (False, "that may be blind")):
            most = nuio.most_lipschitz(path, lim, name, seen)
            print(f"{name}: Lipschitz form {what}: feasible up to a constant of {most:.3g}; phi has {actual:.0f}"
                  f"{': infeasible' if most < actual else ''}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("engine")
    parser.add_argument("--out")
    parser.add_argument("--form", choices=("bounded", "output"), default="bounded")
    parser.add_argument("--residuals")
    parser.add_argument("--forms", action="store_true")
    parser.add_argument("--gain", type=float)
    parser.add_argument("--expect", type=float, nargs=2, metavar=("VGT", "EGR"))
    parser.add_argument("--other", type=float, nargs=2, action="append", default=[], metavar="KPA")
    parser.add_argument("--variance", type=float, metavar="KPA2")
    options = parser.parse_args()
    path = AirPath.load(options.engine)
    if options.expect:
        TUNED.update(zip(("vgt", "egr"), options.expect))
    if options.forms:
        return show_forms(path)
    if options.gain is not None:
        for name in ("vgt", "egr"):
            lim = limits_of(path, name, gain=options.gain)
            try:
                print(f"{name}: feasible, gain {nuio.solve(path, lim, name).figures['gain']:.2f}")
            except nuio.Infeasible:
                binds = ", ".join(nuio.what_binds(path, lim, name))
                print(f"{name}: infeasible; these bind, and leaving one out makes it feasible: {binds}")
        return None
    try:
        file = design(path, options.form, options.residuals)
    except nuio.Infeasible as error:
        sys.exit(f"{options.engine}: no observer keeps all limits: {error}")
    if options.variance is not None:
        file["decision"].update(covariance=[[options.variance, 0.0], [0.0, options.variance]], source="given")
    if options.other:
        file["decision"]["others_kpa"] = options.other
    if options.out:
        write(file, options.engine, options.out)
    return None if certificate.check(path, file) else 1


if __name__ == "__main__":
    with progress.Progress("design"):
        sys.exit(main())
