# SPDX-License-Identifier: MIT
"""Torque over the angle by pressure and by each observer, and work of each cycle, as CSV for tools/report."""
import csv
import pathlib

import numpy as np

import observers as obs

COLUMNS = ("pattern", "angle_deg", "pressure_nm", *obs.WAVEFORMS)


def torque_rows(pattern, replayed, cycles):
    """The last cycle of which every observer tells the whole, each curve less its mean; the last cycle where there is none."""
    told = {key: obs.usable(replayed.known, value, health) for key, (value, health, _) in obs.WAVEFORMS.items()}
    whole = [c for c in cycles if all(np.all(np.isfinite(x[obs.truth_at_teeth(replayed, c)[0]])) for x in told.values())]
    inside, local, truth = obs.truth_at_teeth(replayed, (whole or cycles)[-1])
    curves = [obs.without_mean(truth), *(obs.without_mean(x[inside]) for x in told.values())]
    for deg, *values in zip(local, *curves):
        yield [pattern, f"{deg:.2f}", *(f"{v:.3f}" if np.isfinite(v) else "" for v in values)]


def write(folder, results):
    """torque.csv, of recordings of a single cylinder; work.csv, of every cycle by pressure and by the energy at the same teeth."""
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / "torque.csv").open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file)
        table.writerow(("recording", *COLUMNS))
        for result in results:
            for pattern, replayed in result["replayed"].items():
                table.writerows([result["name"], *row] for row in torque_rows(pattern, replayed,
                                                                              result["cycles"][len(result["cycles"]) // 2:]))
    with (folder / "work.csv").open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file)
        table.writerow(("recording", "cycle", "pressure_j", "same_teeth_j"))
        for result in results:
            said = result["told"].get(obs.SAME_TEETH, {})
            table.writerows([result["name"], i, f"{c.work_j:.4f}", f"{said[i]:.4f}" if i in said else ""] for i,
                            c in enumerate(result["cycles"]))
