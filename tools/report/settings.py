# SPDX-License-Identifier: MIT
"""Which parameters of a run are not at their default, from hal/signals.toml."""
import pathlib
import tomllib

TABLE = pathlib.Path(__file__).resolve().parents[2] / "hal/signals.toml"


def defaults():
    with TABLE.open("rb") as file:
        return {parameter["name"]: parameter["default"] for parameter in tomllib.load(file)["parameter"]}


def changed(summary):
    """What was set beside scenario and defaults, as `name = value`. A default of 0 may stand for a value of the engine's: it counts as
    changed only where it was set by hand."""
    by_hand = dict(item.split("=", 1) for item in summary["set"])
    by_hand.pop("name", None)
    usual = defaults()
    for name, value in summary["parameters"].items():
        if name in usual and usual[name] and abs(value - usual[name]) > 1e-6 * abs(usual[name]):
            by_hand.setdefault(name, f"{value:g}")
    return [f"{name} = {value}" for name, value in by_hand.items()]


def words(summary):
    """A sentence about them."""
    names = changed(summary)
    return "Set beside the scenario and the defaults: " + ", ".join(names) + "." if names else "All parameters are at their defaults."
