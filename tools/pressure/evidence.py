# SPDX-License-Identifier: MIT
"""Torque and work from crank teeth against measured cylinder pressure: a page of figures, of any recording that has both."""
import argparse
import pathlib
import sys
import tempfile

import numpy as np

import curves
import cylinder as cyl
import gas_exchange
import observers as obs
import page
import pictures
import recording as rec

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import progress  # noqa: E402  the path comes first


class Measured:
    """A recording: what sixdeg says of it, and its cycles by pressure."""

    def __init__(self, path, options, folder):
        self.path, self.options, self.folder = pathlib.Path(path), options, pathlib.Path(folder)
        self.geometry = cyl.Geometry.read(options.engine)
        self.cylinder = options.cylinder or self.geometry.firing_order[0]
        self.firing_deg = self.geometry.firing_tdc_deg[self.geometry.firing_order.index(self.cylinder)]
        numbers, names = rec.columns(path)
        self.names = names
        at = rec.column(names, options.pressure, path)
        self.intake_bar = options.intake
        self.replayed = self.replay("recorded", self.path)
        guess = self.replayed.summary["guess"]
        self.t_s = numbers[:, 0] * guess["time_unit_s"] - guess["time_origin_s"]
        self.deg = self.replayed.angle(self.t_s)
        self.inside = np.isfinite(self.deg)
        self.bar = options.bar * numbers[:, at]
        self.cycles = self.cycles_at(0)
        if self.intake_bar is None: # stands in for the sensor that the recording lacks
            self.intake_bar = cyl.pressure_at_bdc(self.geometry, self.cycles)
            self.replayed = self.replay("with_intake", self.path)
        if len(self.cycles) < 4:
            raise rec.Unusable(f"{path}: {len(self.cycles)} whole cycles with a known angle; at least 4 are needed")

    def replay(self, name, path, *more):
        intake = [] if self.intake_bar is None else ["--intake", f"{self.intake_bar:.3f}"]
        words = [*intake, *self.options.replay, *more]
        return rec.replay(self.options.sixdeg, path, self.options.engine, self.folder / name, words)

    def cycles_at(self, shift_deg):
        at = self.inside
        return cyl.cycles_of(self.geometry, self.deg[at], self.t_s[at], self.bar[at], self.firing_deg, self.options.intake, shift_deg)

    def with_gas_exchange(self, told_intake):
        """Replayed with its teeth where the gas exchange of the first half puts them; nothing where it tells no cycle. told_intake: the
        observers know the intake pressure."""
        until = self.cycles[len(self.cycles) // 2].tdc_deg - 360
        pattern, cycles = gas_exchange.tooth_pattern(self.replayed, self.options.engine, self.firing_deg, until)
        if cycles == 0:
            return None
        edges = self.folder / "corrected.csv"
        gas_exchange.write_corrected(edges, self.replayed, pattern)
        words = ["--wheel", self.replayed.summary["guess"]["wheel"]] + (["--intake", f"{self.intake_bar:.3f}"] if told_intake else [])
        replayed = rec.replay(self.options.sixdeg, edges, self.options.engine, self.folder / "corrected", words)
        middle = len(replayed.deg) // 2
        replayed.deg += 720 * np.round((self.replayed.angle(replayed.t_s[middle]) - replayed.deg[middle]) / 720)
        return replayed

    def with_learned_half(self):
        """Replayed with the tooth pattern that its first half teaches; and how many cycles the firmware learned from."""
        half, learned = self.folder / "first_half.txt", self.folder / "learned.bin"
        lines = self.path.read_text(encoding="utf-8", errors="replace").splitlines(keepends=True)
        half.write_text("".join(lines[:len(lines) // 2]), encoding="utf-8")
        try:
            self.replay("half", half, "--learn", str(learned))
            return self.replay("learned", self.path, "--learned", str(learned))
        except rec.Unusable:
            return None


def work_figures(cycles, told):
    """Of each observer, against the work of these cycles."""
    work = np.array([c.work_j for c in cycles])
    half = np.mean(work[:len(work) // 2])
    rows = {}
    for name, values in told.items():
        change = name == obs.CHANGE
        at = [i for i in sorted(values) if change <= i < len(cycles)]
        truth = np.array([work[i] - (work[i - 1] if change else 0) for i in at])
        rows[name] = obs.Figures.of(np.array([values[i] for i in at]), truth, 0 if change else half, np.mean(work))
    return rows


def waveforms(measured, others, replayed, shift_deg=0):
    """Figures of each observer's torque over the second half of the cycles (all where other recordings give the baseline)."""
    cycles = measured.cycles_at(shift_deg)
    half = len(cycles) // 2
    if others:
        means = [obs.mean_waveform(o.replayed, o.cycles) for o in others]
        baseline, scored = (lambda deg: np.mean([m(deg) for m in means], axis=0)), cycles
    else:
        baseline, scored = obs.mean_waveform(measured.replayed, cycles[:half]), cycles[half:]
    return {key: obs.waveform_figures(replayed, scored, value, health, baseline) for key, (value, health, _) in obs.WAVEFORMS.items()}


def assess(measured, others):
    """All figures of a recording."""
    m = measured
    single = len(m.geometry.firing_order) == 1
    told = obs.work_by_cycle(m.replayed, m.cycles, m.cylinder, single)
    result = {"name": m.path.name, "cycles": m.cycles, "told": told, "summary": m.replayed.summary,
              "intake_bar": m.intake_bar, "geometry": m.geometry, "replayed": {"as built": m.replayed} if single else {},
              "tdc": cyl.tdc_shift(m.geometry, m.deg[m.inside], m.bar[m.inside], m.firing_deg),
              "cycles_moved": {shift: m.cycles_at(shift) for shift in (-1, 1)}}
    result["work"] = {shift: work_figures(result["cycles_moved"].get(shift, m.cycles), told) for shift in (-1, 0, 1)}
    if single:
        result["waveform"] = {("as built", shift): waveforms(m, others, m.replayed, shift) for shift in (-1, 0, 1)}
        result["learned_work"] = {}
        gas = "from the gas exchange of the first half"
        for how, replayed in (("as the firmware learns it from the first half", m.with_learned_half()), (gas, m.with_gas_exchange(True)),
                              (f"{gas}, intake pressure not told", m.with_gas_exchange(False))):
            if replayed:
                result["replayed"][how] = replayed
                result["waveform"].update({(how, shift): waveforms(m, others, replayed, shift) for shift in (-1, 0, 1)})
                result["learned_work"][how] = work_figures(m.cycles, obs.work_by_cycle(replayed, m.cycles, m.cylinder, single))
    return result


def arguments():
    parser = argparse.ArgumentParser(prog="tools/evidence", description=__doc__)
    parser.add_argument("engine", metavar="ENGINE.toml")
    parser.add_argument("recordings", nargs="+", metavar="RECORDING", help="text: time first, crank signal and cylinder pressure "
                        "beside it; others of the same engine give the baseline")
    parser.add_argument("--pressure", required=True, metavar="COLUMN", help="of the pressure, number from 0 or name")
    parser.add_argument("--bar", type=float, default=1.0, metavar="X", help="bar a unit of that column; its zero is found")
    parser.add_argument("--intake", type=float, metavar="BAR", help="intake pressure, for the level; without it compression tells it")
    parser.add_argument("--cylinder", type=int, metavar="N", help="whose pressure it is; the first of the firing order otherwise")
    parser.add_argument("--replay", action="append", default=[], metavar="OPTION", help="one more word for sixdeg replay, as "
                        "--replay=--column --replay=2")
    parser.add_argument("--out", default="evidence.md", metavar="PAGE.md", help="page; pictures go into the folder pictures beside it")
    parser.add_argument("--json", metavar="FILE", help="figures alone")
    parser.add_argument("--curves", metavar="FOLDER", help="torque over the angle and work of each cycle as CSV, for tools/report")
    parser.add_argument("--sixdeg", default=str(pathlib.Path(__file__).resolve().parents[2] / "build/host/sixdeg"), help=argparse.SUPPRESS)
    return parser.parse_args()


def main():
    options = arguments()
    out = pathlib.Path(options.out)
    with tempfile.TemporaryDirectory() as folder:
        try:
            all_of_them = [Measured(path, options, pathlib.Path(folder) / str(i)) for i, path in enumerate(options.recordings)]
        except (rec.Unusable, OSError) as error:
            print(f"evidence: {error}", file=sys.stderr)
            return 2
        results = [assess(m, [o for o in all_of_them if o is not m]) for m in all_of_them]
        (out.parent / "pictures").mkdir(parents=True, exist_ok=True)
        for measured, result in zip(all_of_them, results):
            result["picture"] = f"pictures/evidence_{measured.path.stem}.png"
            pictures.draw(out.parent / result["picture"], measured.replayed, measured.cycles, result["told"], result["name"])
        page.write(out, results, options)
        if options.json:
            page.write_json(options.json, results)
        if options.curves:
            curves.write(options.curves, results)
    print(f"the page: {out}")
    return 0


if __name__ == "__main__":
    with progress.Progress("evidence"):
        sys.exit(main())
