#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The speed at which the first tooth comes before the one ahead has been handled, of each image (docs/start/porting.md).

    tests/target/first_overrun.py                     on every image, golden run smooth
    tests/target/first_overrun.py --on cortex-m3 --run fuel_cut

A golden run happens at its own times on the emulated board (hal/cortexm/bench.c), faster and faster, until the port counts an overrun.
An instruction takes 8 ns there, which is the whole model: 125 million instructions a second. Another controller has its clock over the
cycles that it takes for an instruction, and the speed goes with that.
"""
import argparse
import pathlib
import struct
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
BOARDS = {"cortex-m7": "mps2-an500", "cortex-m4f": "mps2-an386", "cortex-m3": "mps2-an385", "cortex-m3-fixed": "mps2-an385"}
TIMER_NS, NORMAL, LAST, SHIFT = 40, 25 << 16, 0xffffffff, 3  # NORMAL: a tick of 1 us, in ticks of 40 ns with 16 bits behind the point
CRANK_EDGE, TEETH = 1, 58  # of a wheel of 60 - 2


def end_of(said):
    """sd_link_end_t: stack, overruns, lost edges, lost others, longest, edges that came during work."""
    at = 16
    while (count := struct.unpack_from("<I", said, at)[0]) != LAST:
        at += 24 + 16 * count
    return struct.unpack_from("<6I", said, at + 24)


def happen(processor, page, events, step, folder):
    bench = folder / "bench"
    bench.write_bytes(struct.pack("<4I", len(events) // 16, page.stat().st_size, step, 0) + events)
    done = subprocess.run(["qemu-system-arm", "-M", BOARDS[processor], "-display", "none", "-monitor", "none", "-serial", "none",
                           "-icount", f"shift={SHIFT},sleep=off", "-semihosting-config", "enable=on,target=native",
                           "-kernel", ROOT / f"build/{processor}/sixdeg_image",
                           "-device", f"loader,file={page},addr=0x200000,force-raw=on",
                           "-device", f"loader,file={bench},addr=0x20200000,force-raw=on"],
                          stdin=subprocess.DEVNULL, capture_output=True, timeout=600)
    if done.returncode != 0:
        raise SystemExit(f"first_overrun: the controller ended with {done.returncode}: {done.stderr.decode()[-300:]}")
    return end_of(done.stdout)


def first_overrun(processor, page, events, folder):
    """(shortest step without an overrun, how it went there): by halving, to half a percent."""
    calm, hasty = 4 * NORMAL, NORMAL // 64
    at_calm = happen(processor, page, events, calm, folder)
    if at_calm[1]:
        raise SystemExit(f"first_overrun: {processor} overruns at a quarter of the speed too")
    while calm > 1.005 * hasty:
        middle = round((calm * hasty) ** 0.5)
        said = happen(processor, page, events, middle, folder)
        if said[1]:
            hasty = middle
        else:
            calm, at_calm = middle, said
    return calm, at_calm


def highest_rpm(events):
    """Of one revolution of the run at its own speed."""
    ticks = [tick for tick, kind, *_ in struct.iter_unpack("<IHHII", events) if kind == CRANK_EDGE]
    return max(60e6 / (b - a) for a, b in zip(ticks, ticks[TEETH:]) if b > a)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--run", default="smooth", help="golden run; its wheel has 60 - 2 teeth")
    parser.add_argument("--on", action="append", choices=BOARDS, help="on these images only; may be given again")
    parser.add_argument("--events", type=int, default=8000, metavar="N", help="of the run's first so many events")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        page = folder / "page"
        subprocess.run([ROOT / "build/host/tests/budget/budget_input", ROOT / f"tests/golden/{options.run}.run", page, folder / "events"],
                       check=True, capture_output=True)
        events = (folder / "events").read_bytes()[16:16 * (options.events + 1)]
        own_rpm = highest_rpm(events)
        for processor in options.on or BOARDS:
            step, (stack, _, _, _, longest, nested) = first_overrun(processor, page, events, folder)
            print(f"{processor:16} first overrun above {own_rpm * NORMAL / step:6.0f} rpm; there the longest tooth takes "
                  f"{longest * TIMER_NS / 1000:.1f} us, {nested} edges come during work; stack {stack} B", flush=True)


if __name__ == "__main__":
    sys.exit(main())
