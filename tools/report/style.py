# SPDX-License-Identifier: MIT
"""How the static pictures of the docs look, and PNG bytes that are the same for the same numbers."""
import io
import os
import sys

# The font cache belongs to the build folder, not to the user's home.
os.environ.setdefault("MPLCONFIGDIR", os.path.join(sys.prefix, "matplotlib"))

import matplotlib  # noqa: E402

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

INK, BLUE, PALE, ORANGE, RED, GREY = "#222222", "#1f5f99", "#b9d3ea", "#d9822b", "#c23b22", "#9a9a9a"

plt.rcParams.update({"font.size": 10, "axes.edgecolor": INK, "axes.spines.top": False, "axes.spines.right": False,
                     "axes.grid": True, "grid.color": "#e6e6e6", "axes.axisbelow": True, "legend.frameon": False})


def png(figure):
    data = io.BytesIO()
    # Without the version of the library in it, the same numbers give the same bytes.
    figure.savefig(data, format="png", dpi=110, metadata={"Software": None})
    plt.close(figure)
    return data.getvalue()


def axes_grid(rows, columns, height, **how):
    """A figure with many, as a flat list; how: as of plt.subplots."""
    figure, axes = plt.subplots(rows, columns, figsize=(10, height), layout="constrained", squeeze=False, **how)
    return figure, list(axes.flat)
