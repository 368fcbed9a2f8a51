# SPDX-License-Identifier: MIT
"""Pictures of document 001's Figures 4 to 7 and 9."""
from airpath_folder import DECISIONS, RESIDUALS
from chart import BLUE, GREEN, GREY, ORANGE, RED, Chart

DECISION_NAMES = ("EGR opens", "EGR closes", "VGT closes", "VGT opens")
COLOURS = (BLUE, GREEN, ORANGE, RED)


def figure_4(model):
    data = model.columns
    chart = Chart("time, s", "speed, rpm", "flow, g/s", "opening")
    chart.line(data["t_s"], data["rpm"], "speed", GREY)
    chart.line(data["t_s"], data["air_gps"] / 20, "air, a twentieth", GREEN, 1)
    chart.line(data["t_s"], data["fuel_gps"], "fuel", RED, 1)
    chart.line(data["t_s"], data["egr"], "EGR valve", BLUE, 2)
    chart.line(data["t_s"], data["vgt"], "VGT vanes", ORANGE, 2)
    return chart


def figure_5_and_6(model):
    data = model.columns
    chart = Chart("time, s", "intake, kPa", "exhaust, kPa", "error, kPa")
    for panel, name in enumerate(("intake", "exhaust")):
        chart.line(data["t_s"], data[name + "_read_kpa"], "measured", GREY, panel, width=0.8, opacity=0.6)
        chart.line(data["t_s"], data[name + "_kpa"], "true", BLUE, panel)
        chart.line(data["t_s"], data[name + "_model_kpa"], "model", ORANGE, panel, dash="dash")
    for name, colour in (("intake", GREEN), ("exhaust", RED)):
        chart.line(data["t_s"], abs(data[name + "_model_kpa"] - data[name + "_kpa"]), f"error of the model, {name}", colour, 2)
    return chart


def figure_7(model):
    data = model.columns
    chart = Chart("time, s", "into the cylinders, g/s", "out of them, g/s")
    for panel, name in enumerate(("drawn", "leaving")):
        chart.line(data["t_s"], data[name + "_gps"], "true", BLUE, panel)
        chart.line(data["t_s"], data[name + "_model_gps"], "model", ORANGE, panel, dash="dash")
    return chart


def figure_9(run):
    data = run.columns
    chart = Chart("time, s", "opening", "residual, sd", "decision", heights=(2, 2, 2))
    for name, colour in (("egr", BLUE), ("vgt", ORANGE)):
        chart.line(data["t_s"], data[name + "_true"], f"{name.upper()} true", colour)
        chart.line(data["t_s"], data[name + "_command"], f"{name.upper()} command", colour, dash="dash", opacity=0.6)
    for name, sigma, colour in zip(RESIDUALS, run.sigma, (ORANGE, BLUE)):
        chart.line(data["t_s"], data[name] / sigma, f"residual {name[-2]}", colour, 1, width=1)
    for name, what, colour in zip(DECISIONS, DECISION_NAMES, COLOURS):
        chart.line(data["t_s"], data[name], what, colour, 2)
    chart.level(0, 2)
    return chart
