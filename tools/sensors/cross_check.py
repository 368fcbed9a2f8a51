# SPDX-License-Identifier: MIT
"""Structural answers of `sixdeg sensors` against the published faultdiagnosistoolbox and SciPy.

Overlap: whether a set of sensors makes the whole state structurally observable. We ask
  - the toolbox's IsObservable() on a model of differential constraints built from the TOML file,
  - its structural rank (Dulmage-Mendelsohn) and SciPy's of the Shields-Pearson matrix, built here,
  - sixdeg's Lin and Shields-Pearson answers (sensors alone) and its exact index (0 = not observable).
All must agree for every set, on the files named and on seeded random models. Prints one line a model; exit 1 on a
difference.

  build/venv/bin/python tools/sensors/cross_check.py --sixdeg build/host/sixdeg host_sim/data/models/*.toml
"""
import argparse
import json
import random
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

import faultdiagnosistoolbox as fdt
import numpy as np
from faultdiagnosistoolbox import dmperm
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import structural_rank


def structures(model):
    """(regime, states, sensors) for every regime, shared quantities spelt out as sets of states."""
    lost_by_regime = {model.get("full_regime", "full"): {}} | model.get("regimes", {})
    for regime, lost in lost_by_regime.items():
        shared = {}

        def links(kind, name, depends):
            kept = [d for d in depends if d not in lost.get(kind, {}).get(name, [])]
            return set().union(*[shared.get(d, {d}) for d in kept])

        for name, depends in model.get("shared", {}).items():
            shared[name] = links("shared", name, depends)
        states = {name: links("states", name, depends) for name, depends in model["states"].items()}
        sensors = {name: links("sensors", name, s["sees"]) for name, s in model["sensors"].items()}
        yield regime, states, sensors


def augmented(model, states, sensors, chosen):
    """Rows of A and C, as sets of state names, with the lag states of the chosen sensors."""
    a, c = dict(states), []
    for name in chosen:
        seen = sensors[name]
        for i, _ in enumerate(model["sensors"][name].get("lags_s", [])):
            own = f"{name}_lag{i}"
            a[own] = seen | {own}
            seen = {own}
        c.append(seen)
    return a, c


def toolbox_observable(a, c):
    unknown = list(a) + ["d_" + name for name in a]
    relations = [["d_" + name, *sorted(depends)] for name, depends in a.items()]
    relations += [fdt.DiffConstraint("d_" + name, name) for name in a]
    relations += [[f"y{i}", *sorted(seen)] for i, seen in enumerate(c)]
    model = fdt.DiagnosisModel(
        {"type": "VarStruc", "x": unknown, "f": [], "z": [f"y{i}" for i in range(len(c))], "rels": relations}
    )
    # DiagnosisModel.IsObservable() without equations looks at none of them; the function below looks at all.
    return bool(dmperm.IsObservable(model.X))


def shields_pearson_matrix(a, c):
    n, column = len(a), {name: i for i, name in enumerate(a)}
    dense_a, dense_c = np.zeros((n, n), int), np.zeros((len(c), n), int)
    for name, depends in a.items():
        dense_a[column[name], [column[d] for d in depends]] = 1
    for row, seen in enumerate(c):
        dense_c[row, [column[d] for d in seen]] = 1
    staircase = np.zeros((n * (n - 1), n * n), int)
    for block in range(n - 1):
        rows = slice(block * n, (block + 1) * n)
        staircase[rows, rows] = np.eye(n, dtype=int)
        staircase[rows, (block + 1) * n : (block + 2) * n] = dense_a
    return np.vstack([staircase, np.kron(np.eye(n, dtype=int), dense_c)])


def sixdeg_answers(program, path, names, size):
    """Ours, by regime number: {set of sensors: index of the whole state} and the table of sensors alone."""
    with tempfile.TemporaryDirectory() as folder:
        result = Path(folder) / "result.json"
        command = [program, "sensors", str(path), "--all", "--size", str(size), "--json", str(result)]
        subprocess.run([*command, "--target", ",".join(names)], check=True, capture_output=True)
        found = json.loads(result.read_text())
    return {tuple(s["sensors"]): s["index"] for s in found["sets"]}, {s["sensor"]: s for s in found["alone"]}


def check(program, path, size):
    model = tomllib.loads(Path(path).read_text())
    size = min(size, len(model["sensors"]))
    sets, alone = sixdeg_answers(program, path, list(model["states"]), size)
    compared = observable = 0
    differences = []
    for number, (regime, states, sensors) in enumerate(structures(model)):
        for chosen, index in sets.items():
            a, c = augmented(model, states, sensors, chosen)
            matrix = shields_pearson_matrix(a, c)
            answers = {
                "toolbox": toolbox_observable(a, c),
                "toolbox rank": int(dmperm.srank(matrix)) == matrix.shape[1],
                "scipy rank": structural_rank(csr_matrix(matrix)) == matrix.shape[1],
                "index": index[number] > 0,
            }
            if len(chosen) == 1:
                answers["lin"] = alone[chosen[0]]["lin"][number]
                answers["shields-pearson"] = alone[chosen[0]]["shields_pearson"][number]
            compared += 1
            observable += answers["index"]
            if len(set(answers.values())) > 1:
                differences.append(f"  {regime} {' '.join(chosen)}: {answers}")
    print(f"{Path(path).name}: {compared} sets compared, {observable} observable, {len(differences)} differences")
    print("\n".join(differences), end="\n" if differences else "")
    return len(differences)


def random_model(seed):
    """Sparse enough that about half of the sets fail, by a missing path or by a dilation."""
    draw = random.Random(seed)
    states = [f"x{i}" for i in range(draw.randint(3, 7))]
    lines = [f'name = "random {seed}"', "[states]"]
    for state in states:
        depends = [s for s in states if draw.random() < 1.6 / len(states)]
        lines.append(f"{state} = {json.dumps(depends)}")
    lines.append("[sensors]")
    for i in range(draw.randint(2, 4)):
        lag = ", lags_s = [1.0]" if draw.random() < 0.3 else ""
        lines.append(f"y{i} = {{ sees = {json.dumps(draw.sample(states, draw.randint(1, 2)))}{lag} }}")
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sixdeg", required=True, help="the program to check")
    parser.add_argument("--size", type=int, default=2, help="sensors in a set, at most")
    parser.add_argument("--random", type=int, default=30, help="random models besides the files")
    parser.add_argument("models", nargs="*")
    options = parser.parse_args()
    differences = sum(check(options.sixdeg, path, options.size) for path in options.models)
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(options.random):
            path = Path(folder) / f"random_{seed}.toml"
            path.write_text(random_model(seed))
            differences += check(options.sixdeg, path, 4)
    sys.exit(1 if differences else 0)


if __name__ == "__main__":
    main()
