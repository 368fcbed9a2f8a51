# SPDX-License-Identifier: MIT
"""Pictures of document 001's Figures 4 to 7 and 9, as PNG bytes."""
from airpath_folder import DECISIONS, RESIDUALS
from style import BLUE, GREY, ORANGE, PALE, RED, axes_grid, png

DECISION_NAMES = ("EGR opens", "EGR closes", "VGT closes", "VGT opens")
COLOURS = (BLUE, PALE, ORANGE, RED)


def finish(figure, all_axes):
    all_axes[-1].set_xlabel("s")
    for axes in all_axes:
        if axes.get_legend_handles_labels()[0]:
            axes.legend(fontsize=8, loc="best")
    return png(figure)


def figure_4(model):
    data = model.columns
    figure, (speed, fuel, positions) = axes_grid(3, 1, 7.5, sharex=True)
    speed.plot(data["t_s"], data["rpm"], color=BLUE)
    speed.set_ylabel("rpm")
    fuel.plot(data["t_s"], data["air_gps"] / 20, color=PALE, label="air, over 20")
    fuel.plot(data["t_s"], data["fuel_gps"], color=BLUE, label="fuel")
    fuel.set_ylabel("g/s")
    positions.plot(data["t_s"], data["egr"], color=BLUE, label="EGR valve")
    positions.plot(data["t_s"], data["vgt"], color=ORANGE, label="VGT vanes")
    positions.set_ylabel("opening")
    return finish(figure, (speed, fuel, positions))


def figure_5_and_6(model):
    data = model.columns
    figure, axes = axes_grid(3, 1, 8.5, sharex=True)
    for place, name in zip(axes, ("intake", "exhaust")):
        place.plot(data["t_s"], data[name + "_read_kpa"], color=PALE, linewidth=0.7, label="measured")
        place.plot(data["t_s"], data[name + "_kpa"], color=BLUE, label="true")
        place.plot(data["t_s"], data[name + "_model_kpa"], "--", color=ORANGE, label="model")
        place.set_ylabel(f"{name}, kPa")
    for name, colour in (("intake", BLUE), ("exhaust", ORANGE)):
        axes[2].plot(data["t_s"], abs(data[name + "_model_kpa"] - data[name + "_kpa"]), color=colour, label=name)
    axes[2].set_ylabel("error, kPa")
    return finish(figure, axes)


def figure_7(model):
    data = model.columns
    figure, axes = axes_grid(2, 1, 5.5, sharex=True)
    for place, name, what in zip(axes, ("drawn", "leaving"), ("into the cylinders", "out of them")):
        place.plot(data["t_s"], data[name + "_gps"], color=BLUE, label="true")
        place.plot(data["t_s"], data[name + "_model_gps"], "--", color=ORANGE, label="model")
        place.set_ylabel(f"{what}, g/s")
    return finish(figure, axes)


def figure_9(run):
    data = run.columns
    figure, (actuators, residuals, decisions) = axes_grid(3, 1, 8.5, sharex=True)
    for name, colour in (("egr", BLUE), ("vgt", ORANGE)):
        actuators.plot(data["t_s"], data[name + "_true"], color=colour, label=f"{name.upper()} true")
        actuators.plot(data["t_s"], data[name + "_command"], "--", color=GREY, linewidth=0.9)
    actuators.set_ylabel("opening")
    for name, sigma, colour in zip(RESIDUALS, run.sigma, (ORANGE, BLUE)):
        residuals.plot(data["t_s"], data[name] / sigma, color=colour, linewidth=0.8, label=f"r{name[-2]}")
    residuals.set_ylabel("residual, sigma")
    for name, what, colour in zip(DECISIONS, DECISION_NAMES, COLOURS):
        decisions.plot(data["t_s"], data[name], color=colour, label=what)
    decisions.axhline(0, color=GREY, linewidth=0.8)
    decisions.set_ylabel("decision")
    return finish(figure, (actuators, residuals, decisions))
