# SPDX-License-Identifier: MIT
"""What a run says of the emulated controller that its firmware ran on (docs/start/porting.md)."""
CLOCK_HZ = {"cortex-m7": 216e6, "cortex-m4f": 168e6, "cortex-m3": 120e6, "cortex-m3-fixed": 120e6}  # of usual parts with such a core
SPEEDS_RPM = (1000, 3000, 6000, 8000)


def positions(engine):
    """Of the wheel, a revolution; missing teeth count."""
    wheel = engine.get("wheel", {})
    return int(wheel.get("positions") or wheel.get("pattern", "60-2").split("-")[0])


def share(instructions, rpm, wheel, clock_hz):
    """Of the time from tooth to tooth, %, at an instruction a cycle."""
    return 100 * instructions * rpm * wheel / 60 / clock_hz


def overrun_rpm(instructions, wheel, clock_hz):
    """Speed at which so many instructions last from tooth to tooth."""
    return 60 * clock_hz / (wheel * instructions)


def rows(controller, engine):
    """(name, average tooth, worst tooth)."""
    clock_hz, wheel, tooth = CLOCK_HZ[controller["core"]], positions(engine), controller["tooth_instructions"]
    average, worst = tooth["average"], tooth["worst"]
    return [("instructions", f"{average:,}", f"{worst:,}"),
            *((f"share of a tooth at {rpm} rpm", *(f"{share(n, rpm, wheel, clock_hz):.1f} %" for n in (average, worst)))
              for rpm in SPEEDS_RPM),
            ("speed at which teeth come faster", "", f"{overrun_rpm(worst, wheel, clock_hz):,.0f} rpm")]


def words(controller):
    """What the table rests on."""
    return (f"The same firmware, as an image for a {controller['name']} on an emulated board, in closed loop with this engine: "
            f"{controller['tooth_instructions']['count']:,} teeth, {controller['overruns']} of them before the one ahead had been handled. "
            f"{controller['ecu_bytes']:,} bytes of state and {controller['stack_bytes']:,} of stack. Shares at "
            f"{CLOCK_HZ[controller['core']] / 1e6:.0f} MHz and an instruction a cycle, which is a model: flash, caches and divisions come "
            "on top, and a core with two pipes does some at once.")
