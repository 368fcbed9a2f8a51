#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""README's picture: the speed at each tooth, the torque from it, and what each firing did, of a run with a misfire.

    build/host/sixdeg run host_sim/data/scenarios/balance_1000rpm_5bar.toml --set misfires.one_in=20 --out DIR
    tools/report/overview.py DIR docs/overview.svg
"""
import csv
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import style  # noqa: E402

AROUND = 5       # firings before and after the misfire that is drawn
SETTLED = 30     # cycles until everything is learned
VERDICTS = {"0": style.BLUE, "1": style.ORANGE, "2": style.RED, "3": style.GREY}


def rows(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def window(firings):
    """The firings around the first lone misfire after the start."""
    for i in range(AROUND, len(firings) - AROUND):
        around = firings[i - AROUND:i + AROUND + 1]
        if int(firings[i]["cycle"]) >= SETTLED and [f["misfire_true"]
                                                    for f in around].count("1") == 1 and firings[i]["misfire_true"] == "1":
            return around
    sys.exit("overview: no lone misfire in this run; add --set misfires.one_in=20")


def picture(folder):
    firings = window(rows(folder / "cycles.csv"))
    first, last = float(firings[0]["t_s"]), float(firings[-1]["t_s"])
    between = (last - first) / (len(firings) - 1)
    begin, end = first - between / 2, last + between / 2  # the row's time is in the middle of its expansion
    teeth = [t for t in rows(folder / "teeth.csv") if begin <= float(t["t_s"]) <= end and t["rpm"] and t["waveform_nm"]]
    style.plt.rcParams.update({"svg.hashsalt": "sixdeg", "svg.fonttype": "none"})  # the same numbers give the same bytes; text stays text
    figure, (speed, torque, work) = style.plt.subplots(3, 1, figsize=(9, 6), sharex=True, layout="constrained")
    ms = [1e3 * (float(t["t_s"]) - begin) for t in teeth]
    speed.plot(ms, [float(t["rpm"]) for t in teeth], ".-", color=style.INK, markersize=3, linewidth=0.6)
    speed.set_ylabel("speed at each tooth, rpm")
    speed.set_title("In: the time of every tooth of the crank wheel", loc="left")
    torque.plot(ms, [float(t["torque_true_nm"]) for t in teeth], color=style.PALE, linewidth=4, label="true")
    torque.plot(ms, [float(t["waveform_nm"]) for t in teeth], color=style.BLUE, linewidth=1, label="estimated")
    torque.set_ylabel("torque, Nm")
    torque.set_title("Out: torque every 6 degrees, gas less load", loc="left")
    torque.legend(loc="upper right", bbox_to_anchor=(1, 1.2), ncols=2)
    for firing in firings:
        middle = 1e3 * (float(firing["t_s"]) - begin)
        work.bar(middle, float(firing["misfire_index"]), 700 * between, color=VERDICTS[firing["misfire_verdict"]])
        work.text(middle, 0.06, firing["cylinder"], ha="center", color="black" if firing["misfire_true"] == "1" else "white")
    work.set_ylabel("work over what\nthe fuel should give")
    work.set_title("Out: every firing, its cylinder, and a misfire named (red)", loc="left")
    work.set_xlabel("time, ms")
    return figure


def main():
    folder, out = map(pathlib.Path, sys.argv[1:])
    picture(folder).savefig(out, format="svg", metadata={"Date": None, "Creator": None})


if __name__ == "__main__":
    main()
