#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Makes hal/generated/sd_signals.{h,c}, the bus files of bus.py and docs/reference/signals.md from hal/signals.toml.

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
INPUTS_MAX = 32  # a bit each in the masks of owners, and an identifier each on CAN
AGE_MAX_S = 10  # so that an age in ticks is far below the wrap of the timer
REQUIRED = {"rate": {"name", "text"}, "owner": {"name", "text"}, "input": {"name", "unit", "range", "age", "usual", "text"},
            "signal": {"name", "unit", "range", "rate", "owner", "text"},
            "parameter": {"name", "unit", "range", "default", "owner", "text"}}
# at_start: the host makes tables of it, so that an ecu takes it with its page and not later. was: a name of before, refused with the new
# one.
OPTIONAL = {"rate": {"period"}, "owner": {"degraded_without", "invalid_without"}, "input": set(), "signal": {"count"},
            "parameter": {"at_start", "was"}}
UNIT_SUFFIX = {"": "", "deg": "_deg", "rpm": "_rpm", "rad/s2": "_radps2", "Nm": "_nm", "J": "_j", "s": "_s",
               "1/rad": "_per_rad", "1/rad2": "_per_rad2", "cycles": "_cycles",
               "K": "_k", "bar": "_bar", "kPa": "_kpa", "g/s": "_gps", "mg": "_mg", "J/mg": "_jpmg", "%": "_percent",
               "rad": "_rad", "rad/s": "_radps", "Nm s/rad": "_nmsprad", "Nm/s": "_nmps"}


def load(path=TABLE):
    table = tomllib.loads(path.read_text())
    for kind, required in REQUIRED.items():
        names = set()
        for entry in table[kind]:
            missing, unknown = required - entry.keys(), entry.keys() - required - OPTIONAL[kind]
            assert not missing and not unknown, f"{path.name}: {kind} {entry.get('name')}: {missing or unknown}"
            assert entry["name"] not in names, f"{path.name}: {kind} {entry['name']} twice"
            assert entry.get("unit", "") in UNIT_SUFFIX, f"{path.name}: {entry['name']}: unit {entry['unit']}"
            names.add(entry["name"])
        for entry in table[kind]:
            assert kind != "parameter" or entry.get("was") not in names, f"{path.name}: {entry['was']} is a parameter's name again"
    check_references(table, path)
    return table


def names_of(table, kind):
    return [entry["name"] for entry in table[kind]]


def check_references(table, path):
    inputs, owners, rates = (names_of(table, kind) for kind in ("input", "owner", "rate"))
    assert len(inputs) <= INPUTS_MAX, f"{path.name}: {len(inputs)} inputs; there is room for {INPUTS_MAX}"
    for entry in table["signal"] + table["parameter"]:
        assert entry["owner"] in owners and entry.get("rate", rates[0]) in rates, f"{path.name}: {entry['name']}: owner or rate"
    for rate in rates:
        assert any(entry["rate"] == rate for entry in table["signal"]), f"{path.name}: no signal of rate {rate}"
    for entry in table["owner"]:
        for needed in entry.get("degraded_without", []) + entry.get("invalid_without", []):
            assert needed in inputs, f"{path.name}: owner {entry['name']}: no input {needed}"
    for entry in table["input"]:
        assert 0 <= entry["age"] <= AGE_MAX_S, f"{path.name}: {entry['name']}: age"
        assert entry["range"][0] <= entry["usual"] <= entry["range"][1], f"{path.name}: {entry['name']}: usual"


def input_list(owner, needs):
    return ", ".join(f"`{name}`" for name in owner.get(needs, [])) or "-"


def field(entry):
    name, suffix = entry["name"].replace(".", "_"), UNIT_SUFFIX[entry["unit"]]
    return name if suffix and name.endswith(suffix) else name + suffix


def constant(kind, entry):
    return f"SD_{kind}_" + entry["name"].replace(".", "_").upper()


def number(value):
    return f"{float(value):.9g}" + ("" if "." in f"{float(value):.9g}" or "e" in f"{float(value):.9g}" else ".0") + "f"


def header(table, signature):
    out = ["/* Generated from hal/signals.toml by tools/signals/generate.py: change the table, not this file. */",
           "/* SPDX-License-Identifier: MIT */",
           "/// sd_signals.h - every signal that leaves the ecu and every parameter that enters it.",
           "#ifndef SD_SIGNALS_H", "#define SD_SIGNALS_H", "#include <stddef.h>", "#include <stdint.h>", "",
           "#ifdef __cplusplus", 'extern "C" {', "#endif", "",
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
            *names_enum(table, "rate", "/// What is said together, and when."), "",
            *names_enum(table, "owner", "/// Whose health comes with a value."), "",
            "/// One row of the table. `value` is the default of a parameter.",
            "typedef struct sd_signal_info {", "    const char *name, *unit;", "    float low, high, value;",
            "    uint8_t rate, owner;",
            "    uint8_t at_start; ///< 1: a parameter that comes with the page and is not set later, since the host makes tables of it.",
            "} sd_signal_info_t;", "", *INFOS]
    return "\n".join(out)


INFOS = """/// What may come in.
typedef struct sd_input_info {
    const char *name, *unit;
    float low, high;
    float usual; ///< Stands in for a reading where none counts.
    float age_s; ///< For how long a reading counts, up to 10; 0: for ever.
} sd_input_info_t;

/// Who says values. Bit i of a mask is input i.
typedef struct sd_owner_info {
    const char *name;
    uint32_t degraded_without; ///< While one of these has no reading that counts, its values are no better than degraded,
    uint32_t invalid_without;  ///< and while one of these has none, invalid.
} sd_owner_info_t;

/// What is said together.
typedef struct sd_rate_info {
    const char *name;
    float period_s;           ///< 0: when the crank says so.
    const uint16_t *channels; ///< Of its signals, ascending,
    const uint8_t *owners;    ///< the sd_owner_t of each,
    uint32_t count;           ///< and how many; at least 1.
} sd_rate_info_t;

extern const sd_signal_info_t sd_signal_infos[SD_SIGNAL_COUNT];       ///< By channel; an array has a row an element.
extern const sd_signal_info_t sd_parameter_infos[SD_PARAMETER_COUNT]; ///< In the order of sd_parameters_t.
extern const sd_input_info_t  sd_input_infos[SD_INPUT_COUNT];         ///< By channel.
extern const sd_owner_info_t  sd_owner_infos[SD_OWNER_COUNT];
extern const sd_rate_info_t   sd_rate_infos[SD_RATE_COUNT];

#ifdef __cplusplus
}
#endif

#endif
""".split("\n")


def names_enum(table, kind, text):
    out = [text, f"typedef enum sd_{kind} {{"]
    for i, entry in enumerate(table[kind]):
        period = f" Every {1000 * entry['period']:g} ms." if "period" in entry and "ms" not in entry["text"] else ""
        out.append(f"    SD_{kind.upper()}_{entry['name'].upper()} = {i}, ///< {entry['text']}{period}")
    return out + [f"}} sd_{kind}_t;", f"#define SD_{kind.upper()}_COUNT {len(table[kind])}u"]


def source(table):
    out = ["/* Generated from hal/signals.toml by tools/signals/generate.py: change the table, not this file. */",
           "/* SPDX-License-Identifier: MIT */", '#include "sd_signals.h"', "",
           "const sd_signal_info_t sd_signal_infos[SD_SIGNAL_COUNT] = {"]
    for entry in table["signal"]:
        for i in range(entry.get("count", 1)):
            name = entry["name"] + (f"[{i + 1}]" if "count" in entry else "")
            out.append(f'    {{ "{name}", "{entry["unit"]}", {number(entry["range"][0])}, {number(entry["range"][1])}, 0.0f, '
                       f'SD_RATE_{entry["rate"].upper()}, SD_OWNER_{entry["owner"].upper()}, 0 }},')
    out += ["};", "", "const sd_input_info_t sd_input_infos[SD_INPUT_COUNT] = {"]
    for entry in table["input"]:
        out.append(f'    {{ "{entry["name"]}", "{entry["unit"]}", {number(entry["range"][0])}, {number(entry["range"][1])}, '
                   f'{number(entry["usual"])}, {number(entry["age"])} }},')
    out += ["};", "", *owner_infos(table), "", *rate_infos(table), "", "const sd_signal_info_t sd_parameter_infos[SD_PARAMETER_COUNT] = {"]
    for entry in table["parameter"]:
        out.append(f'    {{ "{entry["name"]}", "{entry["unit"]}", {number(entry["range"][0])}, {number(entry["range"][1])}, '
                   f'{number(entry["default"])}, SD_RATE_EDGE, SD_OWNER_{entry["owner"].upper()}, {int(entry.get("at_start", False))} }},')
    return "\n".join(out + ["};", ""])


def owner_infos(table):
    inputs = names_of(table, "input")
    out = ["const sd_owner_info_t sd_owner_infos[SD_OWNER_COUNT] = {"]
    for entry in table["owner"]:
        masks = [sum(1 << inputs.index(name) for name in entry.get(f"{how}_without", [])) for how in ("degraded", "invalid")]
        out.append(f'    {{ "{entry["name"]}", 0x{masks[0]:x}u, 0x{masks[1]:x}u }},')
    return out + ["};"]


def c_list(type_, name, values):
    rows = ["    " + ", ".join(values[i:i + 8]) + "," for i in range(0, len(values), 8)]
    return [f"static const {type_} {name}[] = {{"] + rows + ["};"]


def rate_infos(table):
    lists, infos = [], ["const sd_rate_info_t sd_rate_infos[SD_RATE_COUNT] = {"]
    for entry in table["rate"]:
        name = entry["name"]
        of_rate = [(str(channel), signal["owner"]) for channel, signal, _ in bus.channels(table) if signal["rate"] == name]
        lists += c_list("uint16_t", f"channels_{name}", [channel for channel, _ in of_rate])
        lists += c_list("uint8_t", f"owners_{name}", [f"SD_OWNER_{owner.upper()}" for _, owner in of_rate])
        infos.append(f'    {{ "{name}", {number(entry.get("period", 0))}, channels_{name}, owners_{name}, {len(of_rate)}u }},')
    return lists + infos + ["};"]


def renamed(table):
    """For the host's messages: the ecu knows no name of before."""
    out = ["// Generated from hal/signals.toml by tools/signals/generate.py: change the table, not this file.",
           "// SPDX-License-Identifier: MIT", "// Parameters that had another name before, for messages.", "#pragma once", "",
           "namespace sixdeg {", "", "struct Renamed {", "    const char *before, *now;", "};", "",
           "inline constexpr Renamed renamed_parameters[] = {"]
    out += [f'    {{"{entry["was"]}", "{entry["name"]}"}},' for entry in table["parameter"] if "was" in entry]
    return "\n".join(out + ["};", "", "} // namespace sixdeg", ""])


def page(table):
    out = ["<!-- Generated from hal/signals.toml by tools/signals/generate.py: change the table, not this file. -->",
           "# Signals and parameters", "", "## Signals", "",
           "Health comes with every value: valid, degraded or invalid, and why.", "",
           "| rate | said |", "|---|---|"] + [f"| {r['name']} | {r['text']} |" for r in table["rate"]] + ["",
           "| owner | what | degraded without | invalid without |", "|---|---|---|---|"] + [
               f"| {o['name']} | {o['text']} | {input_list(o, 'degraded_without')} | {input_list(o, 'invalid_without')} |"
               for o in table["owner"]] + ["",
           "| channel | name | unit | range | rate | what |", "|---|---|---|---|---|---|"]
    channel = 0
    for entry in table["signal"]:
        count = entry.get("count", 1)
        span = f"{channel}" if count == 1 else f"{channel}-{channel + count - 1}"
        out.append(f"| {span} | `{entry['name']}` | {entry['unit'] or '-'} | {entry['range'][0]:g} to {entry['range'][1]:g} "
                   f"| {entry['rate']} | {entry['text']} |")
        channel += count
    out += ["", "## Inputs", "", "Sampled sensors and the controller's own commands (`SD_EVENT_SAMPLE`). A value outside its range "
            "is ignored", "and counted. A reading counts for as long as it may be old; where none counts the usual value stands in, "
            "and the values of those",
            "owners that need it say so.", "",
            "| channel | name | unit | range | may be old | usual | what |", "|---|---|---|---|---|---|---|"]
    for i, entry in enumerate(table["input"]):
        out.append(f"| {i} | `{entry['name']}` | {entry['unit'] or '-'} | {entry['range'][0]:g} to {entry['range'][1]:g} "
                   f"| {'for ever' if entry['age'] == 0 else format(entry['age'], 'g') + ' s'} | {entry['usual']:g} | {entry['text']} |")
    out += ["", "## Parameters", "",
            "The fields of TUNE.toml and of `--set`. Those marked *start* are made into tables by the host: an ecu takes them with its",
            "page and refuses a change. All others can be set between two teeth.", "",
            "| name | unit | range | default | set | what |", "|---|---|---|---|---|---|"]
    for entry in table["parameter"]:
        out.append(f"| `{entry['name']}` | {entry['unit'] or '-'} | {entry['range'][0]:g} to {entry['range'][1]:g} "
                   f"| {entry['default']:g} | {'start' if entry.get('at_start') else ''} | {entry['text']} |")
    return "\n".join(out + [""])


def generated(path):
    """Path below hal/generated -> text, from the table at `path`."""
    table = load(path)
    return {"sd_signals.h": header(table, zlib.crc32(path.read_bytes())), "sd_signals.c": source(table),
            "renamed_parameters.hpp": renamed(table)} | bus.files(table)


def main():
    files = {ROOT / "hal/generated" / name: text for name, text in generated(TABLE).items()}
    files[ROOT / "docs/reference/signals.md"] = page(load())
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
