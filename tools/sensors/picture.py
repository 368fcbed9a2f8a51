# SPDX-License-Identifier: MIT
"""Picture of a `sixdeg sensors --json` result: what a lower index costs, and how the sets spread over the index.

  build/venv/bin/python tools/sensors/picture.py result.json picture.png
"""
import argparse
import json
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (the backend must be chosen first)

most_drawn = 20000  # more dots than this only blacken the picture


def place(entry):
    """Where a set stands: sets of one index stand side by side by their number of sensors."""
    return entry["worst"] + 0.12 * (len(entry["sensors"]) - 3), entry["cost"]


def draw_costs(axes, result):
    """Every set as a dot, the Pareto front named."""
    sets = [s for s in result["sets"] if s["worst"] > 0][:most_drawn]
    for size in sorted({len(s["sensors"]) for s in sets}):
        dots = [place(s) for s in sets if len(s["sensors"]) == size]
        axes.plot(*zip(*dots), ".", markersize=4, label=f"{size} sensor" + "s" * (size > 1))
    front = result["pareto"]
    if front:
        axes.plot(*zip(*map(place, front)), "ro", fillstyle="none", label="Pareto front")
    for entry in front[:12]:
        names = "\n".join(entry["sensors"])
        axes.annotate(names, place(entry), (5, 5), textcoords="offset points", fontsize=7, color="darkred")
    axes.set(xlabel="observability index, worst regime", ylabel="cost")
    axes.legend(fontsize=8)


def draw_histogram(axes, result):
    """Number of sets by index, one group of bars a regime; 0 stands for not observable."""
    regimes = result["regimes"]
    width = 0.8 / len(regimes)
    for i, regime in enumerate(regimes):
        index = [int(k) + (i - (len(regimes) - 1) / 2) * width for k in regime["histogram"]]
        bars = axes.bar(index, list(regime["histogram"].values()), width, label=regime["name"])
        axes.bar_label(bars, fontsize=6, rotation=90, padding=2)
    axes.set(xlabel="observability index (0 = not observable)", ylabel="sets", yscale="log")
    axes.margins(y=0.15)
    axes.legend()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("result", help="file written by sixdeg sensors --json")
    parser.add_argument("picture", help="file to write, .png or .svg")
    options = parser.parse_args()
    result = json.loads(Path(options.result).read_text())
    figure, (left, right) = plt.subplots(1, 2, figsize=(13, 5.5), layout="constrained")
    figure.suptitle(f"{result['model']}: sets that reveal {' '.join(result['targets'])}")
    draw_costs(left, result)
    draw_histogram(right, result)
    figure.savefig(options.picture, dpi=120)


if __name__ == "__main__":
    main()
