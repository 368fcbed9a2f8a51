#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Compiles the examples of docs/start/lifting-a-block.md and of README against copies of firmware/num and their block, and runs them."""
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
TORQUE_MAIN = """
#include <stdio.h>
int main(void) {
    if (torque_start() != 0) { return 1; }
    /* 10 Nm on 0.25 kg m2 from 100 rad/s: energy grows by 10 Nm times the angle. */
    float torque = 0.0f;
    for (unsigned k = 1; k < 120u * 20u; ++k) {
        const double pitch = 6.283185307179586 / 60, energy = 1250.0 + 10.0 * pitch * (k - 0.5);
        torque = torque_on_tooth(k % 120u, 1u, (uint32_t)(pitch / sqrt(2.0 * energy / 0.25) * 1e6 + 0.5));
    }
    printf("%f", (double)torque);
    return 0;
}
"""
CRANK_MAIN = """
#include <stdio.h>
int main(void) {
    if (crank_start() != SD_OK) { return 1; }
    int wrong = 0, right = 0;
    /* 1000 rpm, from the middle of a revolution. */
    for (unsigned k = 17; k < 60u * 20u; ++k) {
        if (k % 60u >= 58u) { continue; }
        const int said = crank_on_edge(k * 1000u);
        if (said == (int)(k % 60u)) { ++right; } else if (said >= 0) { ++wrong; }
    }
    printf("%d", wrong == 0 ? right : -wrong);
    return 0;
}
"""


def said_by(page, main, block, *more):
    """What the page's example prints when `main` calls it."""
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        for name in ("num", block):
            shutil.copytree(ROOT / "firmware" / name, folder / name)
        example = re.search(r"```c\n(.*?)```", page.read_text(), re.DOTALL).group(1)
        (folder / "example.c").write_text(example + main)
        subprocess.run(["cc", "-std=c11", "-ffp-contract=off", "-Wall", "-Wextra", "-Werror", "-Inum", f"-I{block}", "example.c",
                        *map(str, (folder / block).glob("*.c")), *more, "-o", "example"], cwd=folder, check=True)
        return float(subprocess.run([folder / "example"], capture_output=True, text=True, check=True).stdout)


torque = said_by(ROOT / "docs" / "start" / "lifting-a-block.md", TORQUE_MAIN, "torque", "-lm")
if abs(torque - 10) > 0.5:
    sys.exit(f"the lifted observer says {torque} Nm, not 10")
teeth = said_by(ROOT / "README.md", CRANK_MAIN, "crank")
if teeth < 17 * 58:
    sys.exit(f"the lifted decoder placed {teeth} of 1143 teeth rightly; negative: so many wrongly")
