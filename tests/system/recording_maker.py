# SPDX-License-Identifier: MIT
"""Recordings of crank wheels whose truth is known, made from a seed; shares no code with what reads them."""
import dataclasses

import numpy as np

SINGLE = [(n, m) for n in (12, 18, 20, 24, 30, 32, 36, 40, 48, 60, 72, 90, 100, 120) for m in (1, 2)]
SINGLE += [(12, 3), (25, 1), (35, 1), (59, 2), (61, 1)]
# Teeth before each mark; missing teeth of each.
MULTI = {"36-2-1": ((20, 13), (1, 2)), "36-2-2-2": ((16, 8, 6), (2, 2, 2)), "36-2-2-2 near": ((16, 1, 13), (2, 2, 2)),
         "44-2-2 apart": ((17, 23), (2, 2)),
         "44-2-2": ((20, 20), (2, 2)), "60-2-2 apart": ((20, 36), (2, 2)), "60-2-2": ((28, 28), (2, 2))}


@dataclasses.dataclass
class Made:
    """One recording and its truth."""
    name: str          # of the wheel
    teeth_deg: list    # angle of each tooth
    rpm: float
    jitter: float      # standard deviation of an edge, of a tooth spacing
    ripple: float
    revolutions: float
    form: str          # edges, levels, inverted, voltage, reluctance, apart
    text: str = ""
    mean_rpm: float = 0.0
    repeats: bool = False


def single(positions, missing):
    return f"{positions}-{missing}", [360 * p / positions for p in range(positions - missing)]


def several(key):
    steps, runs = MULTI[key]
    positions = sum(steps) + sum(runs)
    teeth, at = [], 0
    for step, run in zip(steps, runs):
        teeth += [360 * (at + i) / positions for i in range(step)]
        at += step + run
    return key.split(" ")[0], teeth


def added(positions):
    return f"{positions}+1", sorted([360 * p / positions for p in range(positions)] + [360 * (positions - 0.5) / positions])


def even(positions):
    """One of the two sensors of 24+1; the other is made in the form `apart`."""
    return f"{positions}+1", [360 * p / positions for p in range(positions)]


def times_of(angles_deg, made, phase):
    """Times at which the crank passes these angles (ascending, never wrapping), with ripple of a four-cylinder."""
    fine = np.arange(angles_deg[0] - 1, angles_deg[-1] + 1, 0.25)
    rpm = made.rpm * (1 + made.ripple * np.sin(2 * np.radians(fine) + phase))
    time = np.concatenate(([0], np.cumsum(0.25 / (6 * (rpm[1:] + rpm[:-1]) / 2))))
    return np.interp(angles_deg, fine, time)


def make(random, wheel, rpm, jitter, ripple, revolutions, form):
    name, teeth = wheel
    made = Made(name, teeth, rpm, jitter, ripple, revolutions, form)
    pitch_deg = min(b - a for a, b in zip(teeth, teeth[1:]))
    start = random.uniform(0, 360)
    turns = np.arange(int(revolutions) + 2)
    centre = (np.array(teeth)[None, :] + 360 * turns[:, None]).ravel()
    centre = centre[(centre >= start) & (centre < start + 360 * revolutions)]
    noisy = centre + np.clip(random.normal(0, 1, len(centre)), -2.5, 2.5) * jitter * pitch_deg
    noisy.sort()
    phase = random.uniform(0, 2 * np.pi)
    falling = times_of(noisy, made, phase) + random.choice([0.0, 0.37, 12.5])
    made.mean_rpm = (noisy[-1] - noisy[0]) / (falling[-1] - falling[0]) / 6
    spacing = pitch_deg / (6 * made.mean_rpm)
    width = 0.4 * np.minimum(np.diff(falling, append=falling[-1] + spacing), spacing)
    writers = {"edges": edge_list, "levels": level_list, "inverted": level_list, "voltage": voltage, "reluctance": voltage,
               "apart": two_sensors}
    made.text = writers[form](random, made, falling, width)
    return made


def edge_list(_, made, falling, width):
    return "".join(f"{t:.8f}\n" for t in falling)


def level_list(random, made, falling, width):
    """The tooth's edge without jitter of its own is the one at `falling`; the other one is rougher."""
    low, high = ("0", "1") if made.form == "levels" else ("1", "0")
    rows = [("0", high)] if falling[0] > 0 else []
    other = falling + width * random.uniform(0.8, 1.2, len(falling))
    for a, b in zip(falling, other):
        rows += [(f"{a:.8f}", low), (f"{b:.8f}", high)]
    return "Time [s],crank\n" + "".join(f"{a},{b}\n" for a, b in rows)


def two_sensors(random, made, falling, width):
    """Levels of an even wheel, and one tooth beside it, once a revolution or once in two, anywhere between two of the others."""
    every, first, place = len(made.teeth_deg) * random.choice([1, 2]), random.integers(0, len(made.teeth_deg)), random.uniform(0.1, 0.9)
    events = [(0.0, 0, 1)] if falling[0] > 0 else []
    for k, (a, b) in enumerate(zip(falling, falling + width)):
        events += [(a, 0, 0), (b, 0, 1)]
        if k % every == first and k + 1 < len(falling):
            at = a + (place + made.jitter * random.normal()) * (falling[k + 1] - a)
            events += [(at, 1, 1), (at + 0.3 * (falling[k + 1] - a), 1, 0)]
    level, rows = [1, 0], []
    for time, column, value in sorted(events):
        level[column] = value
        rows.append(f"{time:.8f},{level[0]},{level[1]}")
    return "Time [s],crank,home\n" + "\n".join(rows) + "\n"


def voltage(random, made, falling, width):
    """Samples of a Hall signal with slopes, or of a variable-reluctance one; some on an offset, some drifting."""
    spacing = np.median(np.diff(falling))
    step = spacing / 14
    time = np.arange(falling[0] - 3 * spacing, falling[-1] + 3 * spacing, step)
    near = np.clip(np.searchsorted(falling, time), 1, len(falling) - 1)
    behind, ahead = time - falling[near - 1], time - falling[near]
    off = np.where(np.abs(behind) < np.abs(ahead), behind, ahead) / spacing
    if made.form == "voltage":
        volt = 2.5 - 2.5 * np.clip((off + 0.0) / 0.1, -1, 1) * (np.abs(off) < 0.45)
        inside = (off > 0.1) & (off < 0.4)
        volt = np.where(inside, 0.1, np.where((off < -0.1) | (off >= 0.45), 4.9, volt))
    else:
        volt = -np.sin(np.pi * np.clip(off / 0.45, -1, 1)) * made.rpm / 300
    volt = volt + random.normal(0, 0.01 * np.ptp(volt), len(volt)) + random.choice([0, 1.5])
    if random.choice([True, False]):
        volt = volt + 0.15 * np.ptp(volt) * np.sin(2 * np.pi * time / (time[-1] - time[0]))
    return "time,V\n" + "".join(f"{t:.8f},{v:.4f}\n" for t, v in zip(time, volt))
