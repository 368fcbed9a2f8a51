# SPDX-License-Identifier: MIT
"""Document 002's Table 1, from `sixdeg sensors host_sim/data/models/turbo_si_13.toml --json FILE`."""
import json

from chart import BLUE, ORANGE, Chart
from folder import BadFolder, read_file, require
from page import picture, table, text

BEST = 10  # sets that are listed


class SensorSets:
    HEADER = ("sensors", "document 002", "here, unchoked", "here, choked")

    def __init__(self, path):
        try:
            found = json.loads(read_file(path))
        except ValueError as error:
            raise BadFolder(f"{path}: {error}") from error
        self.found = require(path, found, ("model", "targets", "regimes", "sets", "published"))

    def title(self):
        return f"Sensor sets of {self.found['model']}"

    def figures(self):
        return [(", ".join(one["sensors"]), str(one["published"]), *map(str, one["index"])) for one in self.found["published"]]

    def best(self):
        return [(", ".join(one["sensors"]), *map(str, one["index"]), f"{one['cost']:g}") for one in self.found["sets"][:BEST]]

    def assumptions(self):
        return []


def histogram(sets):
    regimes = sets.found["regimes"]
    indices = sorted({int(index) for regime in regimes for index in regime["histogram"]})
    chart = Chart("observability index", "sets of three sensors", height=340)
    for regime, color in zip(regimes, (BLUE, ORANGE)):
        chart.bars([str(i) for i in indices], [regime["histogram"].get(str(i), 0) for i in indices], f"throttle {regime['name']}", color,
                   form="{:.0f}")
    return chart


def section(sets):
    count = sum(sets.found["regimes"][0]["histogram"].values())
    return [text(f"How many derivatives of three sensors' signals tell {', '.join(sets.found['targets'])}: the smaller the index, the "
                 f"sooner the states are known. All {count} sets of three are ranked, exactly, with random numbers for the model's "
                 "coefficients.", "lead"),
            table(sets.figures(), sets.HEADER),
            picture(histogram(sets), "how many sets have which index"),
            text(f"The {BEST} best, and what they cost by the prices in the model's file:"),
            table(sets.best(), ("sensors", "unchoked", "choked", "cost")),
            text("By structure alone: no estimator, and no setting but the model's. Where the document's figure differs: "
                 "docs/theory/sensors.md.")]
