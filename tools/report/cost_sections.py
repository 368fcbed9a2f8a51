# SPDX-License-Identifier: MIT
"""Document 004's Table 2, from `sixdeg bench blocks --json FILE`."""
import json

from chart import BLUE, GREEN, GREY, Chart
from folder import BadFolder, read_file, require
from page import picture, table, text

ARITHMETIC = (("f32_us", "single precision", BLUE), ("q31_us", "fixed point", GREEN), ("dense_us", "the same with dense matrices", GREY))


class Bench:
    HEADER = ("block", "document 004", "single precision", "fixed point", "dense matrices")

    def __init__(self, path):
        try:
            found = json.loads(read_file(path))
        except ValueError as error:
            raise BadFolder(f"{path}: {error}") from error
        self.blocks = require(path, found, ("blocks", "tooth"))["blocks"]
        self.tooth = found["tooth"]

    def title(self):
        return "Time of each block"

    def figures(self):
        def us(of, key):
            return f"{of[key]:.3f} us" if key in of else "-"

        return [(name, f"{of['table2_us']} us" if "table2_us" in of else "-", *(us(of, key) for key, _, _ in ARITHMETIC))
                for name, of in self.blocks.items()]

    def assumptions(self):
        return []


def chart_of(bench):
    chart = Chart("", "us a call", height=420)
    for key, name, color in ARITHMETIC:
        chart.bars(list(bench.blocks), [of.get(key, float("nan")) for of in bench.blocks.values()], name, color, form="{:.2f}")
    return chart


def section(bench):
    tooth = bench.tooth
    words = "; ".join(f"{number}: {of['average_us']:.2f} us on average, {of['worst_us']:.2f} us at worst" for number, of in tooth.items())
    return [text("Microseconds a call on the machine that made this report. The document's are of its own computer, so only ratios between "
                 "rows compare.", "lead"),
            table(bench.figures(), bench.HEADER), picture(chart_of(bench), "time of each block"),
            text(f"All that the firmware does with one tooth: {words}. On controllers: docs/results/costs.md.")]
