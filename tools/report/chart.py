# SPDX-License-Identifier: MIT
"""A picture that a reader can zoom and whose traces can be switched off: panels of traces, as data for plotly.js.

    chart = Chart("time, s", "torque, N m")
    chart.line(t_s, torque_nm, "true torque", BLUE)
    page.picture(chart, "torque over time")

Colours are of middle lightness: they show on white paper and on a dark screen. Text, grid and axes get theirs from page.css.
What is drawn is thinned so that the page stays small; nothing that is computed goes through here.
"""
import base64

import numpy as np

BLUE, ORANGE, RED, GREEN, GREY = "#3d85c6", "#dd8a2e", "#d64550", "#2f9e83", "#8c8c8c"
CYLINDERS = (BLUE, RED, GREEN, "#cc9a1f", "#9a6fc4", "#5fa8d3", "#a9745b", GREY)
MOST_POINTS = 1500  # of a trace: more than a screen has pixels across the picture
DIGITS = 6  # of a number that is written out


def numbers(values):
    """As plotly.js reads them: 32-bit floats in base64; NaN is a gap."""
    return {"dtype": "f4", "bdata": base64.b64encode(np.asarray(values, dtype="<f4").tobytes()).decode()}


def thinned(x, y, most=MOST_POINTS):
    """The smallest and the largest value of each of most/2 stretches, in order, so that no peak and no gap is lost."""
    x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
    if len(x) <= most:
        return x, y
    kept = set()
    for part in np.array_split(np.arange(len(x)), most // 2):
        known = part[np.isfinite(y[part])]
        kept.update([known[np.argmin(y[known])], known[np.argmax(y[known])]] if len(known) else part[:1])
    rows = np.array(sorted(kept | {0, len(x) - 1}))
    return x[rows], y[rows]


def plain(value):
    """A number of a layout, short."""
    return float(f"{float(value):.{DIGITS}g}")


class Chart:
    """Panels one under another, or in columns; those of a column share their horizontal axis."""

    def __init__(self, x, *panels, columns=1, titles=(), heights=None, height=None, log_x=False):
        """x: name of the horizontal axis with its unit. panels: the vertical ones. heights: their shares. height: of all, pixels."""
        self.traces, self.columns, self.count = [], columns, len(panels)
        self._named = set()
        rows = -(-len(panels) // columns)
        self.layout = {"height": height or 120 + 190 * rows + (90 if rows == 1 else 0), "shapes": [], "annotations": [],
                       "margin": {"l": 64, "r": 40, "t": 34, "b": 48}, "hovermode": "x unified",
                       "paper_bgcolor": "rgba(0,0,0,0)", "plot_bgcolor": "rgba(0,0,0,0)", "font": {"family": "system-ui, sans-serif"},
                       "showlegend": True, "modebar": {"orientation": "v", "bgcolor": "rgba(0,0,0,0)", "color": GREY},
                       "legend": {"orientation": "h", "x": 0, "y": plain(1 + (20 if titles else 4) / (190 * rows)), "yanchor": "bottom"}}
        self._axes(x, panels, rows, heights or [1] * rows, log_x)
        for panel, title in enumerate(titles):
            self._note(title, x=0, y=1, xref=self._x(panel) + " domain", yref=self._y(panel) + " domain", xanchor="left", yanchor="bottom")

    def _axes(self, x, panels, rows, heights, log_x):
        gap, top = 0.22 / rows if rows > 1 else 0, 1.0
        if self.columns == 1:
            gap *= 0.4
        shares = np.array(heights) / sum(heights) * (1 - gap * (rows - 1))
        for row in range(rows):
            for panel in range(row * self.columns, min((row + 1) * self.columns, len(panels))):
                # Placed by the row: the last one begins at the axis itself.
                title = panels[panel] if panel % self.columns == 0 else ""  # those beside have the same
                axis = {"title": {"text": title}, "domain": [max(plain(top - shares[row]), 0), plain(top)], "automargin": True}
                if self.columns > 1:
                    axis["anchor"] = self._x(panel)
                self.layout["yaxis" + self._y(panel)[1:]] = axis
            top -= shares[row] + gap
        width = 1 / self.columns
        for column in range(self.columns):
            last = max(p for p in range(len(panels)) if p % self.columns == column)
            axis = {"title": {"text": x}, "anchor": self._y(last), "automargin": True, "zeroline": False}
            if self.columns > 1:
                axis["domain"] = [plain(column * width + (0.05 if column else 0)), plain((column + 1) * width - 0.01)]
            if column:
                axis["matches"] = "x"
            if log_x:
                axis["type"] = "log"
            self.layout["xaxis" + self._x(column)[1:]] = axis

    def _x(self, panel):
        column = panel % self.columns
        return "x" if column == 0 else f"x{column + 1}"

    def _y(self, panel):
        return "y" if panel == 0 else f"y{panel + 1}"

    def _add(self, trace, name, panel, x, y):
        trace.update({"name": name, "legendgroup": name, "xaxis": self._x(panel), "yaxis": self._y(panel)})
        if name in self._named:
            trace["showlegend"] = False
        self._named.add(name)
        # Names of bars are text, and an axis of them has one place a name.
        trace["x"] = list(x) if len(x) and isinstance(x[0], str) else numbers(x)
        trace["y"] = numbers(y)
        self.traces.append(trace)

    def line(self, x, y, name, color, panel=0, *, width=1.5, dash=None, opacity=1, step=False):
        x, y = thinned(x, y)
        line = {"color": color, "width": width} | ({"dash": dash} if dash else {}) | ({"shape": "hv"} if step else {})
        self._add({"type": "scatter", "mode": "lines", "line": line, "opacity": opacity}, name, panel, x, y)

    def points(self, x, y, name, color, panel=0, *, symbol="circle", size=6, sd=None, text=None, opacity=1):
        """sd: standard deviations, as whiskers. text: beside each point, a list."""
        trace = {"type": "scatter", "mode": "markers" if text is None else "markers+text", "opacity": opacity,
                 "marker": {"color": color, "symbol": symbol, "size": size}}
        if text is not None:
            trace |= {"text": list(text), "textposition": "top center", "textfont": {"size": 10}}
        if sd is not None:
            trace["error_y"] = {"type": "data", "array": numbers(sd), "color": GREY, "thickness": 1}
        if text is None and sd is None:
            x, y = thinned(x, y)
        self._add(trace, name, panel, x, y)

    def bars(self, x, y, name, color, panel=0, *, sd=None, form="{:.1f}"):
        """A bar a place, its value written beside it."""
        trace = {"type": "bar", "marker": {"color": color}, "text": [form.format(v) if np.isfinite(v) else "" for v in y],
                 "textposition": "outside", "cliponaxis": False, "textfont": {"size": 10}}
        if sd is not None:
            trace["error_y"] = {"type": "data", "array": numbers(sd), "color": GREY, "thickness": 1}
        self._add(trace, name, panel, x, y)
        self.layout["xaxis" + self._x(panel)[1:]]["type"] = "category"

    def _note(self, text, **where):
        self.layout["annotations"].append({"text": text, "showarrow": False, "align": "left", "font": {"size": 11}, **where})

    def _line_shape(self, dash="dot", **where):
        self.layout["shapes"].append({"type": "line", "line": {"color": GREY, "width": 1, "dash": dash}, **where})

    def level(self, value, panel=0, text=""):
        """A limit across a panel."""
        self._line_shape(xref=self._x(panel) + " domain", yref=self._y(panel), x0=0, x1=1, y0=plain(value), y1=plain(value))
        if text:
            self._note(text, x=1, y=plain(value), xref=self._x(panel) + " domain", yref=self._y(panel), xanchor="right", yanchor="bottom")

    def mark(self, x, text="", at_top=True):
        """A vertical line through all panels of the first column, and words at one end of it."""
        self._line_shape("dash", xref="x", yref="paper", x0=plain(x), x1=plain(x), y0=0, y1=1)
        if text:
            self._note(text, x=plain(x), y=1 if at_top else 0, xref="x", yref="paper", xanchor="left",
                       yanchor="top" if at_top else "bottom")

    def shade(self, start, end, text=""):
        """A stretch of the horizontal axis, in grey."""
        self.layout["shapes"].append({"type": "rect", "xref": "x", "yref": "paper", "x0": plain(start), "x1": plain(end), "y0": 0, "y1": 1,
                                      "fillcolor": GREY, "opacity": 0.14, "line": {"width": 0}, "layer": "below"})
        if text:
            self._note(text, x=plain((start + end) / 2), y=1, xref="x", yref="paper", xanchor="center", yanchor="top")

    def set_x(self, low=None, high=None, *, ticks=None):
        for column in range(self.columns):
            axis = self.layout["xaxis" + self._x(column)[1:]]
            if low is not None:
                axis["range"] = [plain(low), plain(high)]
            if ticks is not None:
                axis["tickvals"] = [plain(t) for t in ticks]

    def name_x(self, places, names):
        """Words in place of numbers below the axis of the first column."""
        self.layout["xaxis"] |= {"tickvals": [plain(p) for p in places], "ticktext": list(names), "showgrid": False}

    def set_y(self, low, high, panel=0, *, ticks=None, log=False):
        axis = self.layout["yaxis" + self._y(panel)[1:]]
        axis["range"] = [plain(low), plain(high)]
        if ticks is not None:
            axis["tickvals"] = [plain(t) for t in ticks]
        if log:
            axis["type"] = "log"

    def as_data(self):
        """What Plotly.newPlot takes: data and layout."""
        return {"data": self.traces, "layout": self.layout}
