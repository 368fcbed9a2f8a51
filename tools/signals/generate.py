#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Makes hal/generated/sd_signals.{h,c}, the bus files of bus.py and docs/signals.md from hal/signals.toml.

Without arguments it rewrites the files that differ, and has bus_code.py do the same; with --check it only compares and
fails on a difference.
"""
import pathlib
import sys
import tomllib
import zlib

import bus
import bus_code

ROOT = pathlib.Path(__file__).resolve().parents[2]
TABLE = ROOT / "hal" / "signals.toml"
RATES = ("edge", "cycle", "firing")
OWNERS = ("crank", "torque", "cylinder", "firing", "misfire", "afr", "balance")
REQUIRED = {"input": {"name", "unit", "range", "text"},
            "signal": {"name", "unit", "range", "rate", "owner", "text"},
            "parameter": {"name", "unit", "range", "default", "owner", "text"}}
# at_start: the host makes tables of it, so that an ecu takes it with its page and not later.
OPTIONAL = {"input": set(), "signal": {"count"}, "parameter": {"at_start"}}
UNIT_SUFFIX = {"": "", "deg": "_deg", "rpm": "_rpm", "rad/s2": "_radps2", "Nm": "_nm", "J": "_j", "s": "_s",
               "1/rad": "_per_rad", "1/rad2": "_per_rad2", "cycles": "_cycles",
               "bar": "_bar", "mg": "_mg", "J/mg": "_jpmg", "%": "_percent"}


def load():
    table = tomllib.loads(TABLE.read_text())
    for kind, required in REQUIRED.items():
        names = set()
        for entry in table[kind]:
            missing, unknown = required - entry.keys(), entry.keys() - required - OPTIONAL[kind]
            assert not missing and not unknown, f"{TABLE.name}: {kind} {entry.get('name')}: {missing or unknown}"
            assert entry["name"] not in names, f"{TABLE.name}: {kind} {entry['name']} twice"
            assert entry["unit"] in UNIT_SUFFIX, f"{TABLE.name}: {entry['name']}: unit {entry['unit']}"
            assert entry.get("owner", OWNERS[0]) in OWNERS and entry.get("rate", "edge") in RATES, entry["name"]
            names.add(entry["name"])
    return table


def field(entry):
    return entry["name"].replace(".", "_") + UNIT_SUFFIX[entry["unit"]]


def constant(kind, entry):
    return f"SD_{kind}_" + entry["name"].replace(".", "_").upper()


def number(value):
    return f"{float(value):.9g}" + ("" if "." in f"{float(value):.9g}" or "e" in f"{float(value):.9g}" else ".0") + "f"


def header(table, signature):
    out = ["/* Generated from hal/signals.toml by tools/signals/generate.py: change the table, not this file. */",
           "/* SPDX-License-Identifier: MIT */",
           "/// sd_signals.h - every signal that leaves the ecu and every parameter that enters it.",
           "#ifndef SD_SIGNALS_H", "#define SD_SIGNALS_H", "#include <stddef.h>", "#include <stdint.h>", "",
           "/// Changes whenever the table does; calibration pages and logs carry it.",
           f"#define SD_SIGNALS_SIGNATURE 0x{signature:08x}u", "",
           "/// Channel of an SD_EVENT_SAMPLE.", "typedef enum sd_input {"]
    out += [f"    {constant('INPUT', entry)} = {i}, ///< {entry['text']} [{entry['unit'] or '-'}]"
            for i, entry in enumerate(table["input"])]
    out += ["} sd_input_t;", f"#define SD_INPUT_COUNT {len(table['input'])}u", "",
            "/// Channel of an SD_EVENT_SIGNAL.", "typedef enum sd_signal {"]
    channel = 0
    for entry in table["signal"]:
        span = f", {entry['count']} channels" if "count" in entry else ""
        out.append(f"    {constant('SIGNAL', entry)} = {channel}, ///< {entry['text']} [{entry['unit'] or '-'}{span}]")
        channel += entry.get("count", 1)
    out += ["} sd_signal_t;", f"#define SD_SIGNAL_COUNT {channel}u", "", "/// Present values, in channel order.",
            "typedef struct sd_signals {"]
    for entry in table["signal"]:
        span = f"[{entry['count']}]" if "count" in entry else ""
        out.append(f"    float {field(entry)}{span};")
    out += ["} sd_signals_t;", "", "/// Parameters of the working page; names, ranges and defaults in sd_parameter_infos.",
            "typedef struct sd_parameters {"]
    out += [f"    float {field(entry)}; ///< {entry['text']}" for entry in table["parameter"]]
    out += ["} sd_parameters_t;", f"#define SD_PARAMETER_COUNT {len(table['parameter'])}u", "",
            "typedef enum sd_rate { " + ", ".join(f"SD_RATE_{r.upper()}" for r in RATES) + " } sd_rate_t;",
            "typedef enum sd_owner { " + ", ".join(f"SD_OWNER_{o.upper()}" for o in OWNERS) + ", SD_OWNER_COUNT } sd_owner_t;",
            "", "/// One row of the table. `value` is the default of a parameter.",
            "typedef struct sd_signal_info {", "    const char *name, *unit;", "    float low, high, value;",
            "    uint8_t rate, owner;",
            "    uint8_t at_start; ///< 1: a parameter that comes with the page and is not set later, since the host makes tables of it.",
            "} sd_signal_info_t;", "",
            "extern const sd_signal_info_t sd_signal_infos[SD_SIGNAL_COUNT];       ///< By channel; an array has a row an element.",
            "extern const sd_signal_info_t sd_input_infos[SD_INPUT_COUNT];         ///< By channel; rate and owner say nothing.",
            "extern const sd_signal_info_t sd_parameter_infos[SD_PARAMETER_COUNT]; ///< In the order of sd_parameters_t.",
            "", "#endif", ""]
    return "\n".join(out)


def source(table):
    out = ["/* Generated from hal/signals.toml by tools/signals/generate.py: change the table, not this file. */",
           "/* SPDX-License-Identifier: MIT */", '#include "sd_signals.h"', "",
           "const sd_signal_info_t sd_signal_infos[SD_SIGNAL_COUNT] = {"]
    for entry in table["signal"]:
        for i in range(entry.get("count", 1)):
            name = entry["name"] + (f"[{i + 1}]" if "count" in entry else "")
            out.append(f'    {{ "{name}", "{entry["unit"]}", {number(entry["range"][0])}, {number(entry["range"][1])}, 0.0f, '
                       f'SD_RATE_{entry["rate"].upper()}, SD_OWNER_{entry["owner"].upper()}, 0 }},')
    out += ["};", "", "const sd_signal_info_t sd_input_infos[SD_INPUT_COUNT] = {"]
    for entry in table["input"]:
        out.append(f'    {{ "{entry["name"]}", "{entry["unit"]}", {number(entry["range"][0])}, {number(entry["range"][1])}, '
                   '0.0f, 0, 0, 0 },')
    out += ["};", "", "const sd_signal_info_t sd_parameter_infos[SD_PARAMETER_COUNT] = {"]
    for entry in table["parameter"]:
        out.append(f'    {{ "{entry["name"]}", "{entry["unit"]}", {number(entry["range"][0])}, {number(entry["range"][1])}, '
                   f'{number(entry["default"])}, SD_RATE_EDGE, SD_OWNER_{entry["owner"].upper()}, {int(entry.get("at_start", False))} }},')
    return "\n".join(out + ["};", ""])


def page(table):
    out = ["<!-- Generated from hal/signals.toml by tools/signals/generate.py: change the table, not this file. -->",
           "# Signals and parameters", "", "## Signals", "",
           "Health comes with every value: valid, degraded or invalid, and why.", "",
           "| channel | name | unit | range | rate | what |", "|---|---|---|---|---|---|"]
    channel = 0
    for entry in table["signal"]:
        count = entry.get("count", 1)
        span = f"{channel}" if count == 1 else f"{channel}-{channel + count - 1}"
        out.append(f"| {span} | `{entry['name']}` | {entry['unit'] or '-'} | {entry['range'][0]:g} to {entry['range'][1]:g} "
                   f"| {entry['rate']} | {entry['text']} |")
        channel += count
    out += ["", "## Inputs", "", "Sampled sensors and the controller's own commands (`SD_EVENT_SAMPLE`). A value outside its range is ignored",
            "and counted.", "", "| channel | name | unit | range | what |", "|---|---|---|---|---|"]
    for i, entry in enumerate(table["input"]):
        out.append(f"| {i} | `{entry['name']}` | {entry['unit'] or '-'} | {entry['range'][0]:g} to {entry['range'][1]:g} "
                   f"| {entry['text']} |")
    out += ["", "## Parameters", "", "The fields of TUNE.toml and of `--set`. Those marked *start* are made into tables by the host: an ecu takes them with its",
            "page and refuses a change. All others can be set between two teeth.", "",
            "| name | unit | range | default | set | what |", "|---|---|---|---|---|---|"]
    for entry in table["parameter"]:
        out.append(f"| `{entry['name']}` | {entry['unit'] or '-'} | {entry['range'][0]:g} to {entry['range'][1]:g} "
                   f"| {entry['default']:g} | {'start' if entry.get('at_start') else ''} | {entry['text']} |")
    return "\n".join(out + [""])


def main():
    table = load()
    signature = zlib.crc32(TABLE.read_bytes())
    files = {ROOT / "hal/generated/sd_signals.h": header(table, signature),
             ROOT / "hal/generated/sd_signals.c": source(table), ROOT / "docs/signals.md": page(table)}
    files |= {ROOT / "hal/generated" / name: text for name, text in bus.files(table).items()}
    stale = [path for path, text in files.items() if not path.exists() or path.read_text() != text]
    if "--check" in sys.argv[1:]:
        for path in stale:
            print(f"{path.relative_to(ROOT)} is not what hal/signals.toml says: run tools/signals/generate.py")
        return 1 if stale else 0
    for path in stale:
        path.parent.mkdir(exist_ok=True)
        path.write_text(files[path])
        print(f"wrote {path.relative_to(ROOT)}")
    return bus_code.main()


if __name__ == "__main__":
    sys.exit(main())
