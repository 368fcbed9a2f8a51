# SPDX-License-Identifier: MIT
"""Nonlinear unknown-input observers of document 001, one for each actuator, by linear matrix inequalities.

    z' = sum mu_k (N_k z + L_k y) + G g + M phi(xhat),   xhat = z - E y,   r = gamma (y - C xhat)                  (7)
    N_k = M A_k - K_k C (9a), L_k = K_k (I + C E) - M A_k E (9b), G = M B (9c), M = I + E C (9d), M F = 0 (9e)
    E = U + Y V, U = -F (C F)^+, V = I - (C F)(C F)^+ (10)
The error e = xhat - x obeys e' = (N + M J) e, J the Jacobian of phi between x and xhat. P M = P (I + U C) + Ytil V C and P K_k = Ktil_k
make inequalities of it that are linear in P, Ytil, Ktil_k.

The pseudo-inverse of (10) is taken with a weight: the unknown flow is found by the exhaust's mass, which it moves by seven standard
deviations of the noise where the intake pressure moves by two. What nothing in y tells of is left out of the inequalities, since its error
dies with the emptying rate whatever the design: the air in the intake, which a measured flow feeds, and in the observer that sees the EGR
valve the recirculated gas too.

Forms:
    bounded    J within the box of its three slopes, a vertex a corner; the product's. Every pole's real part is between -most and -least in
               the sense of one Lyapunov function, Y leaves `seen` of the other fault, and gains are the smallest.
    printed    the document's (17): the six entries of J one at a time, each times their number, all four states; nothing bounds poles or Y.
    output     phi of the measured outputs and Y = 0: only the linear part is left.
    lipschitz  that of W. Chen and M. Saif, 2006, the document's reference 18: |phi(xhat) - phi(x)| <= lipschitz |e|.
"""
import itertools
import warnings
from dataclasses import dataclass, field

import cvxpy as cp
import numpy as np

from air_path import C

KEEP = {"vgt": [0, 2, 3], "egr": [0, 3]} # states of the inequalities
SCALE = np.array([10.0, 3.0, 1.7, 0.6])  # of the states, about ten times what noise does to each
EPS = 1e-6
WEIGHT = np.diag([0.0, 1.0])             # of the outputs in (10)


@dataclass
class Limits:
    """What a design keeps."""
    k: tuple                    # emptying rates at the ends of the speed range, 1/s
    slopes: np.ndarray          # [least, most] of each of the three slopes
    sigma: np.ndarray           # noise of the two outputs
    least: float                # of the poles, 1/s
    most: float
    damping: float = 0.7        # least damping of a pair of poles
    seen: float = 0.97          # share of the other fault's direction that Y must leave
    gain: float = None          # most of the gain; None: the smallest is looked for
    lipschitz: float = None
    drop: tuple = ()            # names of constraints left out


@dataclass
class Observer:
    name: str                   # of the fault that it sees
    f: np.ndarray               # direction that it does not see
    other: np.ndarray           # and that it sees
    e: np.ndarray
    k: list                     # one a vertex of the speed
    output_fed: bool = False
    figures: dict = field(default_factory=dict)

    @property
    def m(self):
        return np.eye(4) + self.e @ C

    def k_at(self, rate, ends):
        share = (ends[1] - rate) / (ends[1] - ends[0])
        return share * self.k[0] + (1 - share) * self.k[1]

    def n(self, path, rate, ends):
        return self.m @ path.a(rate) - self.k_at(rate, ends) @ C

    def l(self, path, rate, ends):
        return self.k_at(rate, ends) @ (np.eye(2) + C @ self.e) - self.m @ path.a(rate) @ self.e


class Infeasible(Exception):
    pass


def decoupling(f):
    """U and V of (10)."""
    cf = (C @ f)[:, None]
    square = (cf.T @ WEIGHT @ cf).item()
    if square < 1e-12:
        raise Infeasible("rank condition: C F = 0")
    left = cf.T @ WEIGHT / square
    return -f[:, None] @ left, np.eye(2) - cf @ left


def corners(path, limits, form, name):
    """Jacobians whose hull holds J, or what of it M leaves."""
    every = [path.jacobian(s) for s in itertools.product(*[tuple(r) for r in limits.slopes])]
    if form in ("output", "lipschitz"):
        return [np.zeros((4, 4))]
    if form == "bounded":
        left = (name == "egr", name == "egr", name == "vgt")   # M takes the flow away whose fault is not seen
        return [path.jacobian(s) for s in itertools.product(*[tuple(r) if flow else (0.0,) for r, flow in zip(limits.slopes, left)])]
    out = []
    entries = [(0, 0), (0, 3), (2, 0), (2, 3), (3, 0), (3, 3)]
    for i, j in entries:
        for pick in (min, max):
            one = np.zeros((4, 4))
            one[i, j] = len(entries) * pick(w[i, j] for w in every)
            out.append(one)
    return out


class Problem:
    """Variables and constraints of one design."""

    def __init__(self, path, limits, name, form):
        self.path, self.limits, self.name, self.form = path, limits, name, form
        self.f, self.other = (path.f_egr, path.f_vgt) if name == "vgt" else (path.f_vgt, path.f_egr)
        self.u, self.v = decoupling(self.f)
        self.keep = [0, 1, 2, 3] if form in ("printed", "lipschitz") else KEEP[name]
        size = len(self.keep)
        self.s, self.s_inv = np.diag(SCALE[self.keep]), np.diag(1 / SCALE[self.keep])
        self.pick = np.eye(4)[self.keep]
        self.p = cp.Variable((size, size), symmetric=True)
        self.y = np.zeros((size, 2)) if form == "output" else cp.Variable((size, 2))
        self.k = [cp.Variable((size, 2)) for _ in limits.k]
        self.pm = self.p @ (self.s_inv @ self.pick @ (np.eye(4) + self.u @ C)) + self.y @ (self.v @ C)   # P M, rows of KEEP, scaled
        self.rules = [("P", self.p >> np.eye(size))]

    def spread(self):
        """P (N + M J) of every vertex."""
        for rate, k in zip(self.limits.k, self.k):
            for j in corners(self.path, self.limits, self.form, self.name):
                yield self.pm @ ((self.path.a(rate) + j) @ self.pick.T @ self.s) - k @ (C @ self.pick.T @ self.s)

    def constrain(self):
        lim, eye = self.limits, np.eye(len(self.keep))
        sine, cosine = lim.damping, np.sqrt(1 - lim.damping ** 2)
        for g in self.spread():
            he, skew = g + g.T, g - g.T
            if self.form == "lipschitz":
                whole = cp.bmat([[he + lim.lipschitz ** 2 * eye, self.pm @ self.pick.T @ self.s], [(self.pm @ self.pick.T @ self.s).T,
                        -eye]])
                self.rules.append(("Lipschitz", (whole + whole.T) / 2 << -EPS * np.eye(2 * len(eye))))
                continue
            least = 0 if self.form == "printed" else lim.least
            self.rules.append(("slowest pole", he + 2 * least * self.p << -EPS * eye))
            if self.form == "bounded":
                self.rules.append(("fastest pole", he + 2 * lim.most * self.p >> EPS * eye))
                sector = cp.bmat([[sine * he, cosine * skew], [-cosine * skew, sine * he]])
                self.rules.append(("damping", (sector + sector.T) / 2 << -EPS * np.eye(2 * len(eye))))
        sigma = np.diag(lim.sigma)
        gain = sum(cp.norm(k @ sigma) for k in self.k) + cp.norm(self.y @ sigma)
        if self.form in ("bounded", "lipschitz"):
            whole = np.linalg.norm(self.s_inv @ self.pick @ (np.eye(4) + self.u @ C) @ self.other)
            self.rules.append(("sensitivity", cp.norm(self.y @ (self.v @ C @ self.other)) <= (1 - lim.seen) * whole))
            if lim.gain is not None and self.form == "bounded":
                self.rules.append(("gain", gain <= lim.gain))
        self.rules = [(what, rule) for what, rule in self.rules if what not in lim.drop]
        return gain

    def observer(self, status, gain):
        back = self.s @ np.linalg.inv(self.p.value)
        e, ks = np.array(self.u), [np.zeros((4, 2)) for _ in self.k]
        if self.form != "output":
            e[self.keep] += back @ self.y.value @ self.v
        for k, found in zip(ks, self.k):
            k[self.keep] = back @ found.value
        p = self.s_inv @ self.p.value @ self.s_inv
        return Observer(self.name, self.f, self.other, e, ks, self.form == "output", {"status": status, "gain": gain, "p": p})


def solve(path, limits, name, form="bounded"):
    """The observer that sees the fault `name`. Raises Infeasible."""
    problem = Problem(path, limits, name, form)
    gain = problem.constrain()
    goal = gain if form in ("bounded", "output") else 0
    task = cp.Problem(cp.Minimize(goal), [rule for _, rule in problem.rules])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")   # an inaccurate optimum is checked by the certificate
        try:
            task.solve(solver=cp.CLARABEL)
        except cp.SolverError:
            raise Infeasible("the solver gives up") from None
    if task.status not in (cp.OPTIMAL, cp.OPTIMAL_INACCURATE):
        raise Infeasible(task.status)
    return problem.observer(task.status, float(gain.value))


def what_binds(path, limits, name):
    """Which single constraints, left out, make an infeasible design feasible."""
    found = []
    for what in ("slowest pole", "fastest pole", "damping", "sensitivity", "gain"):
        try:
            solve(path, Limits(**{**vars(limits), "drop": (what,)}), name)
            found.append(what)
        except Infeasible:
            pass
    return found or ["no single one"]


def most_lipschitz(path, limits, name, sees):
    """The largest constant at which the Lipschitz form has a solution, within 1 %; sees: with the constraint of sensitivity."""
    low, high = 0.0, 1e-3
    def feasible(constant):
        try:
            drop = () if sees else ("sensitivity",)
            solve(path, Limits(**{**vars(limits), "lipschitz": constant, "drop": drop}), name, "lipschitz")
            return True
        except Infeasible:
            return False
    while feasible(high) and high < 1e6:
        low, high = high, 4 * high
    while high > 1.01 * low + 1e-6:
        middle = (low + high) / 2
        low, high = (middle, high) if feasible(middle) else (low, middle)
    return low
