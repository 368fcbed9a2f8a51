#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Checks a design by itself: eigenvalues over a dense grid of speeds and slopes, the decoupling, what a fault does to each residual in
standard deviations. It takes matrices from the file and the model from the engine file, and nothing from the solver.

    certificate.py ENGINE.toml DESIGN.toml
Exit status 1 where the certificate does not hold.
"""
import itertools
import sys
import tomllib
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
from air_path import C, AirPath  # noqa: E402

SPEEDS, SLOPES = 21, 11   # points of the grid along the speed and along each slope


def matrices(observer):
    return [np.array(observer[name]) for name in ("m", "e", "k_low", "k_high")]


def decoupling(path, observer):
    """Largest element of M F over that of F for the fault that is not seen, and of M - I - E C."""
    m, e, _, _ = matrices(observer)
    unseen = path.f_egr if observer["sees"] == "vgt" else path.f_vgt
    return np.abs(m @ unseen).max() / np.abs(unseen).max(), np.abs(m - np.eye(4) - e @ C).max()


def error_matrix(path, observer, rate, ends, slopes):
    m, _, low, high = matrices(observer)
    share = (rate - ends[0]) / (ends[1] - ends[0])
    return m @ (path.a(rate) + path.jacobian(slopes)) - (low + share * (high - low)) @ C


def grid(path, observer, design):
    """Real parts of the poles, slowest and fastest, and the least damping of a pair; the air's pole, -k, is left out."""
    slowest, fastest, damping = -np.inf, np.inf, 1.0
    ends = design["k"]
    points = np.array(list(itertools.product(*[np.linspace(*row, SLOPES) for row in design["slopes"]])))
    m, _, _, _ = matrices(observer)
    parts = [m @ (path.jacobian(one)) for one in np.eye(3)]   # the Jacobian is linear in its slopes
    keep = [0, 2, 3] if observer["sees"] == "vgt" else [0, 3]
    for rate in np.linspace(*ends, SPEEDS):
        whole = error_matrix(path, observer, rate, ends, np.zeros(3)) + np.einsum("ns,sij->nij", points, parts)
        poles = np.linalg.eigvals(whole[:, keep][:, :, keep])
        slowest, fastest = max(slowest, poles.real.max()), min(fastest, poles.real.min())
        damping = min(damping, (-poles.real / np.abs(poles)).min())
        every = np.linalg.eigvals(whole).real.max()
        slowest = max(slowest, every) if every >= 0 else slowest   # what the inequalities leave out must die too
    return slowest, fastest, damping


def lyapunov(path, observer, design):
    """Largest eigenvalue of He[P (N + M J)] over P, halved: below 0, no sequence of speeds and slopes can make the error grow."""
    p, worst, ends = np.array(observer["p"]), -np.inf, design["k"]
    keep = [0, 2, 3] if observer["sees"] == "vgt" else [0, 3]
    root = np.linalg.cholesky(p)
    back = np.linalg.inv(root)
    for rate in ends:
        for slopes in itertools.product(*design["slopes"]):
            g = p @ error_matrix(path, observer, rate, ends, slopes)[np.ix_(keep, keep)]
            worst = max(worst, np.linalg.eigvalsh(back @ (g + g.T) @ back.T).max() / 2)
    return worst


def shifts(path, observer, design):
    """Residual in the end for 1 g/s of unknown flow of each actuator, kPa, at the design's middle."""
    m, _, low, high = matrices(observer)
    rate, slopes = design["middle_k"], design["middle_slopes"]
    whole = error_matrix(path, observer, rate, design["k"], slopes)
    gamma = np.array(observer["gamma"])
    return {name: float(-gamma @ C @ np.linalg.solve(whole, m @ f)) for name, f in (("egr", path.f_egr), ("vgt", path.f_vgt))}


def check(path, file):
    design, ok = file["design"], True
    for observer in file["observer"]:
        sees, other = observer["sees"], "egr" if observer["sees"] == "vgt" else "vgt"
        leak, form = decoupling(path, observer)
        slowest, fastest, damping = grid(path, observer, design)
        decay = lyapunov(path, observer, design)
        shift = shifts(path, observer, design)
        sigma = np.abs(np.array(observer["gamma"]) @ np.diag(design["sigma"])).sum()
        fault = design["fault_gps"][sees] * shift[sees]
        holds = leak < 1e-6 and form < 1e-6 and slowest < 0 and decay < 0 and abs(shift[other]) < 0.01 * abs(shift[sees])
        ok = ok and holds
        print(f"observer that sees {sees}: M F {leak:.1e}, M - I - E C {form:.1e}; poles {slowest:.2f} to {fastest:.1f} 1/s, "
              f"damping {damping:.2f}; Lyapunov decay {-decay:.2f} 1/s")
        print(f"    residual of 1 g/s: {sees} {shift[sees]:+.3f} kPa, {other} {shift[other]:+.1e}; a fault of 0.05 of {sees} "
              f"({design['fault_gps'][sees]:+.1f} g/s): {abs(fault) / sigma:.1f} standard deviations{'' if holds else '   DOES NOT HOLD'}")
    return ok


if __name__ == "__main__":
    if len(sys.argv) != 3 or sys.argv[1] in ("-h", "--help"):
        sys.exit(__doc__)
    sys.exit(0 if check(AirPath.load(sys.argv[1]), tomllib.loads(Path(sys.argv[2]).read_text())) else 1)
