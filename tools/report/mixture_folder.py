# SPDX-License-Identifier: MIT
"""Reads what `sixdeg run` wrote of mixture and fuel trims: summary.json, cycles.csv, the scenario. Fields: docs/reference/files.md."""
import numpy as np

from folder import BadFolder, Table, read_summary
from run_folder import file_of_run

FIELDS = ("scenario", "afr", "balance", "perturbed", "set", "seed", "parameters", "engine", "files")
NUMBERS = ("t_s", "imep_true_bar", "torque_nm", "burned_true", "burned", "trim")
SMOOTH = 4  # cycles, as in the figures of the summary
TAKEN_UP = 0.8  # share of a step that counts as converged: document 004's estimate lies within 20 %
BALANCED_PERCENT = 3
ESTIMATORS = {1: "joint filter", 2: "chain with oscillators", 3: "document 004's chain"}  # by afr.method

BALANCE_ROWS = (("spread before, of lambda", "spread_before_percent", "{:.1f} %".format),
                ("cycles until it is below 3 %", "cycles_to_3_percent", lambda n: f"{n:.0f}" if n >= 0 else "not reached"),
                ("distance from the mean, at the end", "residual_percent", "{:.2f} %".format))
ESTIMATE_ROWS = (("estimate of lambda, rms of the last cycles, of the mean", "rms_points", "{:.2f} %".format),)


def names(runs, of=None):
    """What each run's estimate is by, numbered where there are several."""
    said = [(of or MixtureRun.source_of_estimate)(run) for run in runs]
    return [f"{n}: {name}" for n, name in enumerate(said, 1)] if len(said) > 1 else said


def running_mean(values, count=SMOOTH):
    """Over the last `count` along the last axis; NaN before."""
    kernel = np.ones(count) / count
    rows = np.atleast_2d(values)
    mean = np.array([np.convolve(row, kernel)[:len(row)] for row in rows])
    mean[:, :count - 1] = np.nan
    return mean.reshape(values.shape)


def spread_percent(values):
    """Largest less smallest cylinder, of their mean, cycle by cycle."""
    return 100 * (values.max(axis=0) - values.min(axis=0)) / values.mean(axis=0)


class MixtureRun:
    """A run with a wideband sensor. Arrays are [cylinder, cycle], NaN where a cell is empty."""

    HEADER = ("mixture of every cylinder", "nominal", "perturbed")

    def __init__(self, folder):
        self.folder = folder
        self.summary = read_summary(folder, FIELDS)
        self.scenario = file_of_run(folder, self.summary, "scenario", lambda table: "run" in table)
        table = Table(folder, "cycles.csv", NUMBERS + ("cycle", "cylinder"))
        cylinder, cycle = table.numbers("cylinder"), table.numbers("cycle")
        self.cylinders = np.unique(cylinder).astype(int)
        if len(self.cylinders) < 2:
            raise BadFolder(f"{table.path}: cylinder: there is only one, so nothing to balance")
        last = min(cycle[cylinder == c].max() for c in self.cylinders)
        rows = [np.flatnonzero((cylinder == c) & (cycle <= last) & (cycle >= 0)) for c in self.cylinders]
        if len({len(r) for r in rows}) != 1:
            raise BadFolder(f"{table.path}: cycle: not every cylinder has all of them")
        for name in NUMBERS:
            values = table.numbers(name)
            setattr(self, name, np.array([values[r] for r in rows]))
        if not np.isfinite(self.burned_true).any():
            raise BadFolder(f"{table.path}: burned_true: is empty: the scenario has no [uego]")
        self.time_s = self.t_s.mean(axis=0)

    def title(self):
        return self.summary["scenario"]

    def source(self):
        """What the trims follow."""
        source = {1: "lambda", 2: "torque"}.get(round(self.summary["parameters"]["balance.source"]), "nothing")
        return f"{source}, {self.source_of_estimate()}" if source == "lambda" else source

    def source_of_estimate(self):
        return ESTIMATORS[round(self.summary["parameters"].get("afr.method", 1))]

    def balanced_s(self):
        """Pairs from, to: when the trims were allowed, cut to the run."""
        on = self.scenario.get("control", {}).get("balance_on_s", [])
        end = self.time_s[-1]
        return [(a, min(b, end)) for a, b in zip(on[::2], on[1::2]) if a < end]

    def fuel_steps(self):
        """(time, cylinder, percent beyond nominal), in order of time."""
        steps = self.scenario.get("cylinders", {}).get("fuel_step", [])
        return sorted((s["at_s"], s["cylinder"], s["percent"]) for s in steps)

    def fuel_percent(self, cylinder, time_s):
        """What the injector gives beyond nominal, at these times."""
        first = self.scenario.get("cylinders", {}).get("fuel_percent", [0] * len(self.cylinders))[cylinder - 1]
        percent = np.full(len(time_s), float(first))
        for at_s, of, value in self.fuel_steps():
            if of == cylinder:
                percent[time_s >= at_s] = value
        return percent

    def switched_on(self):
        """Cycle at which the trims were allowed last."""
        return int(np.searchsorted(self.time_s, self.balanced_s()[-1][0]))

    def imep_spread_percent(self, cycles):
        """Of each cylinder's mean over these cycles."""
        return float(spread_percent(self.imep_true_bar[:, cycles].mean(axis=1, keepdims=True))[0])

    def taken_up_cycles(self):
        """For each fuel step: cycles from the first changed exhaust until the estimate has taken up most of it."""
        found = []
        starts = [s[0] for s in self.fuel_steps()]
        for (at_s, cylinder, _), until_s in zip(self.fuel_steps(), starts[1:] + [self.time_s[-1]]):
            row = list(self.cylinders).index(cylinder)
            before = int(np.searchsorted(self.time_s, at_s)) - 1
            after = int(np.searchsorted(self.time_s, until_s)) - 1
            truth, estimate = self.burned_true[row], self.burned[row]
            step = truth[after] - truth[before]
            if step == 0:
                found.append(None)
                continue
            first = before + int(np.argmax(np.abs(truth[before:after + 1] - truth[before]) > abs(step) / 2))
            start = estimate[max(before - 10, 0):before + 1].mean()
            share = (estimate[first:after + 1] - start) / step
            reached = np.flatnonzero(share > TAKEN_UP)
            found.append(int(reached[0]) + 1 if len(reached) else None)
        return found

    def convergence(self):
        """Of the fuel steps, in words."""
        cycles = self.taken_up_cycles()
        reached = sorted(c for c in cycles if c is not None)
        middle = f"median {reached[len(reached) // 2]} cycles, " if reached else ""
        return f"{middle}{len(reached)} of {len(cycles)} steps"

    def figures(self):
        """(name, nominal, perturbed) texts: of the balance, or of the estimate without one; "-" where there is none."""
        balance = self.summary["balance"] is not None
        rows = BALANCE_ROWS if balance else ESTIMATE_ROWS

        def text(of, key, form):
            group = of and of.get("balance" if balance else "afr")
            return form(group[key]) if group else "-"

        found = [(name, text(self.summary, key, form), text(self.summary["perturbed"], key, form)) for name, key, form in rows]
        return found if balance else [*found, ("taken up", self.convergence(), "")]

    def assumptions(self):
        return []
