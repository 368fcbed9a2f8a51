# SPDX-License-Identifier: MIT
"""A Chart as a static PNG for a page of the docs: lines and points of panels one under another, with their limits."""
import base64

import numpy as np

from style import GREY, axes_grid, png

DASHES = {None: "-", "dash": "--", "dot": ":"}


def decoded(packed):
    return np.frombuffer(base64.b64decode(packed["bdata"]), dtype="<f4")


def as_png(chart):
    """PNG bytes."""
    layout = chart.layout
    figure, all_axes = axes_grid(chart.count, 1, 1 + 2.2 * chart.count, sharex=True)
    by_name = {"y" if panel == 0 else f"y{panel + 1}": axes for panel, axes in enumerate(all_axes)}
    for trace in chart.traces:
        line, marker = trace.get("line", {}), trace.get("marker", {})
        by_name[trace["yaxis"]].plot(decoded(trace["x"]), decoded(trace["y"]), DASHES[line.get("dash")] if line else "o",
                                     label=trace["name"],
                                     color=(line or marker)["color"], linewidth=line.get("width", 1), alpha=trace["opacity"],
                                     drawstyle="steps-post" if line.get("shape") == "hv" else "default")
    for shape in layout["shapes"]:
        if shape["yref"] in by_name:
            by_name[shape["yref"]].axhline(shape["y0"], color=GREY, linewidth=0.8, linestyle=":")
    for name, axes in by_name.items():
        vertical = layout["yaxis" + name[1:]]
        axes.set_ylabel(vertical["title"]["text"])
        if "range" in vertical:
            axes.set_ylim(*vertical["range"])
        if "tickvals" in vertical:
            axes.set_yticks(vertical["tickvals"])
        axes.legend(fontsize=8)
    all_axes[-1].set_xlabel(layout["xaxis"]["title"]["text"])
    return png(figure)
