#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Made recordings through `sixdeg replay`: how many are read right, refused, and read wrongly.

usage: recordings.py [--count N] [--seed N]
       exit status 1 when one is read wrongly, or refused without a reason that the docs allow
"""
import argparse
import collections
import json
import os
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

import recording_maker as maker

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "tools"))
import progress  # noqa: E402  the path comes first

SIXDEG = os.environ.get("SIXDEG", str(pathlib.Path(__file__).resolve().parents[2] / "build" / "host" / "sixdeg"))
FORMS = ("edges", "levels", "inverted", "voltage", "reluctance")


def draw(random):
    kind = random.uniform()
    if kind < 0.7:
        wheel = maker.single(*maker.SINGLE[random.integers(len(maker.SINGLE))])
    elif kind < 0.95:
        wheel = maker.several(list(maker.MULTI)[random.integers(len(maker.MULTI))])
    else:
        wheel = maker.added(24) if kind < 0.975 else maker.even(24)
    rpm = float(np.exp(random.uniform(np.log(60), np.log(9000))))
    jitter = float(random.choice([0, 0.01, 0.03, 0.05, 0.1]))
    ripple = float(random.choice([0, 0.1, 0.2, 0.4])) if rpm < 400 else float(random.choice([0, 0.05]))
    form = str(random.choice(FORMS))
    return maker.make(random, wheel, rpm, jitter, ripple, float(random.uniform(4, 25)), "apart" if kind >= 0.975 else form)


def repeats(made):
    """Whether the wheel, or one that looks alike, has its marks evenly several times a revolution."""
    return made.name in ("44-2-2", "60-2-2", "18-2", "20-2", "30-2")


def excuse(made, words):
    """The reason to refuse that the docs allow, or nothing."""
    if repeats(made) and "repeat" in words:
        return "marks repeat"
    return "jitter 10 %" if made.jitter >= 0.1 else "short" if made.revolutions < 7 else None


def judge(made, status, summary, words):
    """read, the reason why it was refused or not followed, bad refusal, wrong; what was said; and whether the wheel was named right."""
    if summary is None:
        return excuse(made, words) or "bad refusal", words, False
    said, speed = summary["guess"]["wheel"], summary["rpm_last"]
    right = said == made.name and (speed is None or abs(speed / made.mean_rpm - 1) < 0.1 + 1.5 * made.ripple)
    if not right:
        return "wrong", f"{said}, {speed} rpm", False
    return ("read", "", True) if status == 0 else (excuse(made, words) or "bad refusal", words, True)


def run(made, folder):
    path, out = folder / "made.csv", folder / "summary.json"
    path.write_text(made.text)
    out.unlink(missing_ok=True)
    done = subprocess.run([SIXDEG, "replay", str(path), "--json", str(out)], capture_output=True, text=True, timeout=120, check=False)
    if done.returncode not in (0, 2, 3):
        return "wrong", f"status {done.returncode}: {done.stderr}", False
    return judge(made, done.returncode, json.loads(out.read_text()) if out.exists() else None, done.stderr.strip())


def run_all(count, seed, show=print):
    """Outcomes of `count` recordings: of all, and of those whose wheel has one mark and is no half or third of one with more."""
    all_of_them, one_mark = collections.Counter(), collections.Counter()
    with tempfile.TemporaryDirectory() as folder:
        for i in progress.over(range(count), "recordings.py: recording"):
            made = draw(np.random.default_rng([seed, i]))
            outcome, words, named = run(made, pathlib.Path(folder))
            all_of_them[outcome] += 1
            if made.name.count("-") == 1 and not repeats(made):
                one_mark[outcome] += 1
                one_mark["named"] += named
            if outcome in ("wrong", "bad refusal"):
                show(f"{i}: {outcome}: {made.name}, {made.form}, {made.rpm:.0f} rpm, jitter {made.jitter}, ripple {made.ripple}, "
                     f"{made.revolutions:.1f} revolutions: {words[:200]}")
    return all_of_them, one_mark


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--count", type=int, default=600)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    everything, one_mark = run_all(options.count, options.seed)
    print(f"{options.count} recordings:", ", ".join(f"{name} {n}" for name, n in sorted(everything.items())))
    named = one_mark.pop("named", 0)
    share, named_share = (100 * n / max(1, sum(one_mark.values())) for n in (one_mark["read"], named))
    print("of them wheels of one mark, but those that may be a part of a revolution:",
          ", ".join(f"{name} {n}" for name, n in sorted(one_mark.items())), f"({share:.1f} % read, {named_share:.1f} % named right)")
    return 1 if everything["wrong"] or everything["bad refusal"] else 0


if __name__ == "__main__":
    sys.exit(main())
