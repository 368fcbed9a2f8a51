# SPDX-License-Identifier: MIT
"""The picture of a recording: work of each cycle, and torque over the angle of one, each observer beside the pressure."""
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (the backend must be chosen first)
import numpy as np  # noqa: E402

import observers as obs  # noqa: E402


def draw_work(axes, cycles, told):
    truth = np.array([c.work_j for c in cycles])
    axes.plot(range(len(truth)), truth - truth.mean(), "k.-", label="cylinder pressure")
    for (name, values), style in zip(told.items(), ("o-", "s--", "^:", "v:")):
        if len(values) > 2 and np.ptp(list(values.values())) < 4 * np.ptp(truth): # what is far off would leave nothing to see of the rest
            at = sorted(values)
            mean = np.mean([truth[i] for i in at]) - truth.mean()
            said = np.array([values[i] for i in at])
            axes.plot(at, said - said.mean() + mean, style, markersize=4, linewidth=0.8, label=name.split(" (")[0])
    axes.set(xlabel="cycle", ylabel="work less its mean, J")
    axes.legend(fontsize=7)


def draw_waveform(axes, replayed, cycles, titles):
    value, health, _ = obs.WAVEFORMS["filter"]
    good = [c for c in cycles if np.all(np.isfinite(obs.usable(replayed.known, value, health)[obs.truth_at_teeth(replayed, c)[0]]))]
    cycle = (good or cycles)[-1]
    inside, local, truth = obs.truth_at_teeth(replayed, cycle)
    axes.plot(local, obs.without_mean(truth), "k", label="cylinder pressure")
    for (value, health, name), style in zip(obs.WAVEFORMS.values(), ("C0", "C1")):
        said = obs.usable(replayed.known, value, health)[inside]
        if np.all(np.isfinite(said)):
            axes.plot(local, obs.without_mean(said), style, linewidth=0.8, label=name.split(" (")[0])
    axes.set(xlabel="deg from firing TDC", ylabel="torque less its mean, Nm", title=titles)
    axes.title.set_size(8)
    axes.legend(fontsize=7)


def draw(path, replayed, cycles, told, title):
    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 3.6), layout="constrained")
    draw_work(left, cycles, told)
    draw_waveform(right, replayed, cycles, title)
    figure.savefig(path, dpi=80, metadata={"Software": None})
    plt.close(figure)
