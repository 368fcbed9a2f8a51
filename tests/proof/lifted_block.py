#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Compiles the example of docs/lifting-a-block.md against copies of firmware/num and firmware/torque, and runs it."""
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
MAIN = """
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

with tempfile.TemporaryDirectory() as temporary:
    folder = pathlib.Path(temporary)
    for block in ("num", "torque"):
        shutil.copytree(ROOT / "firmware" / block, folder / block)
    example = re.search(r"```c\n(.*?)```", (ROOT / "docs" / "lifting-a-block.md").read_text(), re.DOTALL).group(1)
    (folder / "example.c").write_text(example + MAIN)
    subprocess.run(["cc", "-std=c11", "-ffp-contract=off", "-Wall", "-Wextra", "-Werror", "-Inum", "-Itorque", "example.c",
                    *map(str, (folder / "torque").glob("*.c")), "-lm", "-o", "example"], cwd=folder, check=True)
    torque = float(subprocess.run([folder / "example"], capture_output=True, text=True, check=True).stdout)
    if abs(torque - 10) > 0.5:
        sys.exit(f"the lifted observer says {torque} Nm, not 10")
