#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The stack bounds of the images that are built, and that the look at them finds recursion, heap, pointers and new loops where there
are some."""
import pathlib
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import stack  # noqa: E402  the path comes first

FAULTY = """
#include <stdlib.h>
volatile unsigned kept;
__attribute__((noinline)) unsigned odd(unsigned n);
__attribute__((noinline)) unsigned even(unsigned n) { return (n == 0u) ? 1u : 1u + odd(n - 1u); }
__attribute__((noinline)) unsigned odd(unsigned n) { return (n == 0u) ? 0u : 2u * even(n - 1u); }
__attribute__((noinline)) unsigned deep(void) { volatile unsigned a[700]; a[kept] = 1u; return a[1]; }
void sd_ecu_init(void) { BODY_OF_INIT }
void sd_ecu_run(unsigned (*other)(void)) { BODY_OF_RUN }
int main(void) { sd_ecu_init(); sd_ecu_run(deep); return 0; }
"""


def image(init, run):
    folder = pathlib.Path(tempfile.mkdtemp())
    (folder / "a.c").write_text(FAULTY.replace("BODY_OF_INIT", init).replace("BODY_OF_RUN", run))
    subprocess.run(["arm-none-eabi-gcc", "-mthumb", "-mcpu=cortex-m3", "-O1", "--specs=nosys.specs", folder / "a.c", "-o",
                    folder / "a.elf"],
                   check=True, capture_output=True)
    return folder / "a.elf"


class Stack(unittest.TestCase):
    def test_images_stay_below_their_bound(self):
        for core in ("cortex-m7", "cortex-m4f", "cortex-m3", "cortex-m3-fixed"):
            bounds, wrong = stack.look(stack.ROOT / "build" / core / "tests/budget/target/budget_ecu")
            self.assertEqual(wrong, [], core)
            self.assertGreater(bounds["sd_ecu_run"][0], 500, "painting finds more than that")
            bounds, wrong = stack.look(stack.ROOT / "build" / core / "sixdeg_image")
            self.assertEqual(wrong, [], core)
            self.assertIn("sd_ecu_task_run", bounds)

    def test_every_loop_has_a_bound(self):
        self.assertEqual(stack.loops(), [])

    def test_recursion_is_found(self):
        with self.assertRaisesRegex(SystemExit, "recursion"):
            stack.look(image("kept = deep();", "kept = even(kept) + deep();"))

    def test_heap_depth_and_pointers_are_found(self):
        _, wrong = stack.look(image("kept = deep(); kept = *(volatile unsigned *)malloc(kept);", "kept = other() + deep();"))
        self.assertTrue(any("bytes of stack" in line for line in wrong), wrong)
        self.assertTrue(any("malloc" in line for line in wrong), wrong)

    def test_a_loop_that_nobody_bounded_is_found(self):
        kept = stack.LOOPS.pop("firmware/torque/sd_motion.c: while ((x > 0.5f)")
        self.assertEqual(len(stack.loops()), 1)
        stack.LOOPS["firmware/torque/sd_motion.c: while ((x > 0.5f)"] = kept


if __name__ == "__main__":
    unittest.main()
