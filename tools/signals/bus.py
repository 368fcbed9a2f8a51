# SPDX-License-Identifier: MIT
"""What the table says of the two buses: sixdeg.dbc, sixdeg.lcm, and the C between a row of signals and their messages.

A row is all signals of one rate at one tick, with the health of their owners. LCM carries a row whole; CAN in as many
FD frames as it takes.
"""
from dataclasses import dataclass, field

NOTE = "Generated from hal/signals.toml by tools/signals/generate.py: change the table, not this file."
INPUTS = 0xA8  # identifier of the first
FD_LENGTHS = (8, 12, 16, 20, 24, 32, 48, 64)
TEETH_A_FRAME = 14
BYTES = {"u8": 1, "u16": 2, "u32": 4, "i32": 4, "f32": 4, "f64": 8}
TOP = {"u8": 2**8 - 1, "u16": 2**16 - 1, "u32": 2**32 - 1, "i32": 2**31 - 1}
LCM_TYPE = {"u8": "int8_t", "u16": "int16_t", "u32": "int32_t", "i32": "int32_t", "f32": "float", "f64": "double"}
HEALTH = dict(enumerate(("valid", "degraded", "invalid")))
COMMANDS = dict(enumerate(("read", "read_reference", "set", "restore")))
RESULTS = dict(enumerate(("ok", "unknown", "out_of_range", "refused", "at_start")))


@dataclass
class Field:
    name: str
    type: str
    unit: str = ""
    range: tuple = None
    text: str = ""
    choices: dict = field(default_factory=dict)  # value -> name


@dataclass
class Message:
    name: str
    id: int
    sender: str
    text: str
    fields: list
    fd: bool = True
    cycle_ms: int = 0
    channels: list = field(default_factory=list)  # of a row: channels and owners it carries
    owners: list = field(default_factory=list)
    rate: str = ""

    def length(self):
        used = sum(BYTES[f.type] for f in self.fields)
        return next(n for n in FD_LENGTHS if n >= used) if self.fd else 8


def channels(table):
    """(channel, entry, C name of the field on a bus) of every signal, arrays by element."""
    out = []
    for entry in table["signal"]:
        name = entry["name"].replace(".", "_")
        for i in range(entry.get("count", 1)):
            out.append((len(out), entry, f"{name}_{i + 1}" if "count" in entry else name))
    return out


def row(name, id, rate, part):
    owners = list(dict.fromkeys(entry["owner"] for _, entry, _ in part))
    fields = [Field("tick", "u32", "tick", text="Capture tick of the event that caused it.")]
    for owner in owners:
        fields += [Field(f"{owner}_health", "u8", "", (0, 2), f"How far the values of {owner} may be trusted.", HEALTH),
                   Field(f"{owner}_why", "u16", "", (0, 2**16 - 1), "Why not, bits: sd_why_t.")]
    for _, entry, c_name in part:
        text = entry["text"]
        fields.append(Field(c_name, "f32", entry["unit"], tuple(entry["range"]), text))
    return Message(name, id, "ecu", f"Signals of rate {rate}, one row a tick.", fields, channels=part, owners=owners, rate=rate)


def row_messages(table, room=64):
    """The rows of every rate, cut into messages of at most `room` bytes."""
    out = []
    for rate in dict.fromkeys(entry["rate"] for entry in table["signal"]):
        parts, part = [], []
        for channel in (c for c in channels(table) if c[1]["rate"] == rate):
            owners = {entry["owner"] for _, entry, _ in part + [channel]}
            if part and 4 + 3 * len(owners) + 4 * (len(part) + 1) > room:
                parts.append(part)
                part = []
            part.append(channel)
        parts.append(part)
        for i, part in enumerate(parts):
            out.append(row(f"{rate}_{i + 1}" if len(parts) > 1 else rate, 0xB0 + len(out), rate, part))
    assert len(out) <= 16
    return out


def truth_messages():
    edge = [Field("time_s", "f64", "s"), Field("angle_deg", "f64", "deg", (0, 720)),
            Field("crank_deg", "f64", "deg", text="The same, never wrapping."), Field("speed_radps", "f64", "rad/s"),
            Field("net_torque_nm", "f64", "Nm", text="Gas less load."), Field("tick", "u32", "tick"),
            Field("tooth", "u8", "", (0, 255), "Wheel position that passed; 255: none."),
            Field("flags", "u8", "", (0, 3), "1: stands for no tooth; 2: the crank turned backward.")]
    cycle = [Field("torque_nm", "f64", "Nm", text="Mean combustion torque over the 180 deg after TDC."),
             Field("imep_pa", "f64", "Pa"), Field("tdc_time_s", "f64", "s"), Field("exhaust_lambda", "f64"),
             Field("cycle", "i32"), Field("cylinder", "u8", "", (1, 8)),
             Field("misfire", "u8", "", (0, 1))]
    end = [Field("edges", "u32", text="Messages truth_edge sent."), Field("cycles", "u32", text="Messages truth_cycle sent.")]
    return [Message("truth_edge", 0xF0, "plant", "Truth of a crank edge, which no ecu reads.", edge),
            Message("truth_cycle", 0xF1, "plant", "Truth of one cylinder's cycle.", cycle),
            Message("truth_end", 0xF2, "plant", "The run is over.", end, fd=False)]


def can_messages(table):
    assert len(table["parameter"]) < 255
    names = {i: entry["name"].replace(".", "_") for i, entry in enumerate(table["parameter"])} | {255: "all"}
    order = [Field("sequence", "u16", "", text="Frames of teeth sent before, wraps."),
             Field("session", "u16", "", text="Drawn when the sender starts.")]
    teeth = order + [Field("count", "u8", "", (1, TEETH_A_FRAME), "Ticks that are meant."),
                     Field("cam", "u16", "", (0, 2**TEETH_A_FRAME - 1), "Bit i: tick i is a cam edge, else a crank edge.")]
    teeth += [Field(f"tick_{i}", "u32", "tick") for i in range(TEETH_A_FRAME)]
    request = [Field("command", "u8", "", (0, 3), "sd_parameter_command_t.", COMMANDS),
               Field("index", "u8", "", (0, 255), "Of the parameter; all: to restore.", names), Field("value", "f32")]
    answer = [Field("command", "u8", "", (0, 3), "Of the request.", COMMANDS),
              Field("index", "u8", "", (0, 255), "Of the parameter.", names), Field("value", "f32", text="What holds now."),
              Field("result", "u8", "", (0, 4), "sd_parameter_result_t.", RESULTS)]
    out = [Message("teeth", 0xA0, "plant", "Captured edges, in order.", teeth),
           Message("time", 0xA1, "plant", "All events up to tick have been sent.",
                   [Field("tick", "u32", "tick")] + order, fd=False, cycle_ms=10),
           Message("done", 0xC3, "ecu", "All events up to tick are handled, and what they caused is said.",
                   [Field("tick", "u32", "tick"), Field("session", "u16", text="Drawn when the ecu starts."),
                    Field("ignored", "u8", text="Events ignored since the start, wraps."),
                    Field("unsent", "u8", text="Signals without room since the start, wraps.")], fd=False, cycle_ms=10),
           Message("parameter_request", 0xC0, "tool", "Reads or sets a parameter.", request, fd=False),
           Message("parameter", 0xC1, "ecu", "Answer to a parameter_request.", answer, fd=False),
           Message("claim", 0xC2, "ecu", "An ecu is here, or asks whether one is.",
                   [Field("id", "u32", text="0: an ecu runs; 2^32 - 1: who is here?; else: wants to start."),
                    Field("signature", "u32", text="SD_SIGNALS_SIGNATURE of the sender.")], fd=False)]
    for i, entry in enumerate(table.get("input", [])):
        out.append(Message("input_" + entry["name"].replace(".", "_"), INPUTS + i, "plant", entry["text"],
                           [Field("tick", "u32", "tick"), Field("value", "f32", entry["unit"], tuple(entry["range"]), entry["text"])],
                           fd=False, cycle_ms=10))
    assert len(out) <= 6 + 8
    return sorted(out + row_messages(table) + truth_messages(), key=lambda m: m.id)


def dbc(table):
    messages = can_messages(table)
    out = ['VERSION "sixdeg"', "", "NS_ :", "", "BS_:", "", "BU_: plant ecu tool", ""]
    comments, attributes, types, values = [f'CM_ "{NOTE} SPDX-License-Identifier: MIT";'], [], [], []
    for m in messages:
        out.append(f"BO_ {m.id} {m.name}: {m.length()} {m.sender}")
        readers = {"plant": "tool" if m.name.startswith("truth") else "ecu,tool", "ecu": "plant,tool", "tool": "ecu"}[m.sender]
        comments.append(f'CM_ BO_ {m.id} "{m.text}";')
        attributes.append(f'BA_ "VFrameFormat" BO_ {m.id} {14 if m.fd else 0};')
        if m.cycle_ms:
            attributes.append(f'BA_ "GenMsgCycleTime" BO_ {m.id} {m.cycle_ms};')
        at = 0
        for f in m.fields:
            bits, real, signed = 8 * BYTES[f.type], f.type[0] == "f", f.type[0] != "u"
            low, high = f.range or ((0, 0) if real else (-TOP[f.type] - 1 if signed else 0, TOP[f.type]))
            out.append(f' SG_ {f.name} : {at}|{bits}@1{"-" if signed else "+"} (1,0) [{low:.10g}|{high:.10g}] "{f.unit}" {readers}')
            at += bits
            if f.text:
                comments.append(f'CM_ SG_ {m.id} {f.name} "{f.text}";')
            if real:
                types.append(f"SIG_VALTYPE_ {m.id} {f.name} : {1 if f.type == 'f32' else 2};")
            if f.choices:
                values.append(f"VAL_ {m.id} {f.name} " + " ".join(f'{i} "{c}"' for i, c in f.choices.items()) + " ;")
        out.append("")
    formats = ["StandardCAN", "ExtendedCAN"] + ["reserved"] * 12 + ["StandardCAN_FD", "ExtendedCAN_FD"]
    out += comments + ['BA_DEF_ BO_ "VFrameFormat" ENUM ' + ",".join(f'"{f}"' for f in formats) + ";",
                       'BA_DEF_ BO_ "GenMsgCycleTime" INT 0 65535;', 'BA_DEF_DEF_ "VFrameFormat" "StandardCAN";',
                       'BA_DEF_DEF_ "GenMsgCycleTime" 0;'] + attributes + values + types
    return "\n".join(out + [""])


def lcm_struct(name, fields, text):
    out = [f"// {text}", f"struct {name}", "{"]
    for f in fields:
        note = f"  // {f.text}{f' [{f.unit}]' if f.unit else ''}" if f.text or f.unit else ""
        out.append(f"    {LCM_TYPE.get(f.type, f.type)} {f.name};{note}")
    return out + ["}", ""]


def lcm(table):
    number = lambda name, text="", type="i32": Field(name, type, text=text)
    events = [number("tick", type="u32"), number("kind", "sd_event_kind_t", "u16"), number("channel", type="u16"),
              number("value", type="u32"), number("flags", type="u32")]
    inputs = [number("count"), number("sequence", "Messages sent before, wraps."),
              number("session", "Drawn when the sender starts."), Field("event[count]", "event_t")]
    outputs = [number(f"{m.rate}s") for m in row_messages(table, 10**6)]
    outputs += [number("done", "1: answers the clock event at tick; 0: there was no room to wait for it."), number("tick"),
                number("session", "Drawn when the ecu starts."), number("ignored"), number("unsent")]
    outputs += [Field(f"{m.rate}[{m.rate}s]", f"{m.rate}_t") for m in row_messages(table, 10**6)]
    truth = [number("edges"), number("cycles"), number("end", "1: the run is over."), number("sent_edges", "So far."), number("sent_cycles", "So far."),
             Field("edge[edges]", "truth_edge_t"), Field("cycle[cycles]", "truth_cycle_t")]
    parameter = [number("command", "sd_parameter_command_t"), number("index"), number("value", type="f32"),
                 number("result", "sd_parameter_result_t, in the answer.")]
    out = [f"// {NOTE}", "// SPDX-License-Identifier: MIT", "// Unsigned numbers travel in the signed types of the same size.",
           "package sixdeg;", ""]
    out += lcm_struct("event_t", events, "As in hal.h.") + lcm_struct("inputs_t", inputs, "SIXDEG_INPUTS: plant to ecu.")
    for m in row_messages(table, 10**6):
        out += lcm_struct(f"{m.rate}_t", m.fields, m.text)
    out += lcm_struct("outputs_t", outputs, "SIXDEG_OUTPUTS: what the ecu says, at the latest at each clock event.")
    edge, cycle, _ = truth_messages()
    out += lcm_struct("truth_edge_t", edge.fields, edge.text) + lcm_struct("truth_cycle_t", cycle.fields, cycle.text)
    out += lcm_struct("truth_t", truth, "SIXDEG_TRUTH: plant to whoever compares.")
    out += lcm_struct("parameter_t", parameter, "SIXDEG_PARAMETER_REQUEST and its answer, SIXDEG_PARAMETER.")
    out += lcm_struct("claim_t", [number("id"), number("signature")], "SIXDEG_CLAIM: as the CAN frame of that name.")
    return "\n".join(out)


def row_code(table, bus, include, type_of, room):
    """from and to a row, for every message of a bus: {bus}_{message}_from_row, _to_row."""
    out = [f"/* {NOTE} */", "/* SPDX-License-Identifier: MIT */", f"#ifndef {bus.upper()}_ROWS_H", f"#define {bus.upper()}_ROWS_H",
           f'#include "{include}"' if include else "", '#include "sd_row.h"', ""]
    for m in row_messages(table, room):
        if not include:
            out.insert(5, f'#include "sixdeg_{m.name}_t.h"')
        kind = type_of(m.name)
        out += [f"static inline void {bus}_{m.name}_from_row({kind} *m, const sd_row_t *row) {{",
                "    m->tick = (TICK)row->tick;".replace("TICK", "uint32_t" if include else "int32_t")]
        health, why = ("", "") if include else ("(int8_t)", "(int16_t)")
        for owner in m.owners:
            out += [f"    m->{owner}_health = {health}row->health[SD_OWNER_{owner.upper()}];",
                    f"    m->{owner}_why = {why}row->why[SD_OWNER_{owner.upper()}];"]
        out += [f"    m->{name} = row->value[{channel}];" for channel, _, name in m.channels] + ["}", ""]
        out += [f"static inline void {bus}_{m.name}_to_row(sd_row_t *row, const {kind} *m) {{",
                f"    sd_row_begin(row, (uint32_t)m->tick, SD_RATE_{m.rate.upper()});"]
        for owner in m.owners:
            out.append(f"    sd_row_status(row, SD_OWNER_{owner.upper()}, (uint8_t)m->{owner}_health, (uint16_t)m->{owner}_why);")
        out += [f"    sd_row_put(row, {channel}, m->{name});" for channel, _, name in m.channels] + ["}", ""]
    if include:  # CAN: by frame identifier
        rows = row_messages(table, room)
        out += [f"#define {bus.upper()}_INPUTS_FIRST {INPUTS:#x}u",
                f"#define {bus.upper()}_INPUTS_END   {INPUTS + len(table.get('input', [])):#x}u /* the identifier after the last input's */", ""]
        out += ["/* How many bytes frame `part` of a row of `rate` takes, its identifier in *id; 0 when there is no such part. */",
                f"static inline uint32_t {bus}_row_pack(const sd_row_t *row, uint32_t part, uint32_t *id, uint8_t bytes[64]) {{",
                "    uint32_t at = 0;"]
        for m in rows:
            out += [f"    if ((row->rate == SD_RATE_{m.rate.upper()}) && (at++ == part)) {{", f"        {type_of(m.name)} m;",
                    f"        {bus}_{m.name}_from_row(&m, row);", f"        *id = {bus.upper()}_{m.name.upper()}_FRAME_ID;",
                    f"        return (uint32_t){bus}_{m.name}_pack(bytes, &m, 64);", "    }"]
        out += ["    return 0;", "}", "", "/* 1: `id` is a row's and *row holds it; 0: it is not; -1: it is, and too short. */",
                f"static inline int {bus}_row_unpack(sd_row_t *row, uint32_t id, const uint8_t *bytes, size_t size) {{"]
        for m in rows:
            out += [f"    if (id == {bus.upper()}_{m.name.upper()}_FRAME_ID) {{", f"        {type_of(m.name)} m;",
                    f"        if ((size != {bus.upper()}_{m.name.upper()}_LENGTH) || ({bus}_{m.name}_unpack(&m, bytes, size) != 0)) {{ return -1; }}",
                    f"        {bus}_{m.name}_to_row(row, &m);", "        return 1;", "    }"]
        out += ["    return 0;", "}", ""]
    return "\n".join(out + ["#endif", ""])


def files(table):
    return {"sixdeg.dbc": dbc(table), "sixdeg.lcm": lcm(table),
            "can/sd_bus_rows.h": row_code(table, "sd_bus", "sd_bus.h", lambda name: f"struct sd_bus_{name}_t", 64),
            "lcm/sd_lcm_rows.h": row_code(table, "sd_lcm", "", lambda name: f"sixdeg_{name}_t", 10**6)}
