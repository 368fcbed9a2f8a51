#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""What residuals scatter by, and whether the formulas for white residuals hold for them.

    covariance.py RESIDUALS.csv
RESIDUALS.csv: a header, then a row a step: time in s and the residuals. The long-run covariance is that of means over batches of 1 s, times
their length: what a sum of residuals, which a CUSUM is, scatters by for each of its terms. Of white residuals it is that of one of them.
"""
import sys

import numpy as np

BATCH_S = 1.0


def read(path):
    table = np.loadtxt(path, delimiter=",", skiprows=1, ndmin=2)
    return table


class Covariance:
    def __init__(self, table):
        time, residual = table[:, 0], table[:, 1:]
        self.step_s = float(np.median(np.diff(time)))
        batch = max(int(round(BATCH_S / self.step_s)), 1)
        count = len(residual) // batch
        if count < 30:
            raise SystemExit(f"{count} batches of {BATCH_S:g} s: at least 30 are needed for a covariance")
        self.seconds = count * batch * self.step_s
        self.mean = residual.mean(0)
        means = residual[:count * batch].reshape(count, batch, -1).mean(1)
        self.long_run = np.cov(means.T) * batch
        self.single = np.cov(residual.T)
        self.error = np.sqrt(2 / (count - 1))   # relative standard deviation of a variance
        whole = residual - self.mean
        self.first = (whole[1:] * whole[:-1]).mean(0) / whole.var(0)

    def is_white(self):
        ratio = np.diag(self.long_run) / np.diag(self.single)
        return bool(np.all(np.abs(ratio - 1) < 3 * self.error + 0.05))

    def report(self):
        for i, (long_run, single, first) in enumerate(zip(np.diag(self.long_run), np.diag(self.single), self.first)):
            print(f"residual {i + 1}: mean {self.mean[i]:+.4f}, sd {np.sqrt(single):.3f}, long-run sd {np.sqrt(long_run):.3f} "
                  f"(+-{50 * self.error:.1f} %), correlation with the step before {first:+.2f}")
        if self.is_white():
            print("these residuals are white within what can be told: the white-noise formulas of threshold and delay hold")
        else:
            print("THE WHITE-NOISE FORMULA OF THE THRESHOLD FAILS for these residuals: take the threshold from false alarms that were "
                  "measured or sampled, and the long-run covariance")


if __name__ == "__main__":
    if len(sys.argv) != 2 or sys.argv[1] in ("-h", "--help"):
        sys.exit(__doc__)
    Covariance(read(sys.argv[1])).report()
