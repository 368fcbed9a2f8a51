# SPDX-License-Identifier: MIT
"""What the table says of the two buses: sixdeg.dbc, sixdeg.lcm, and the C between a row of signals and their messages.

A row is all signals of one rate at one tick, with the health of their owners. LCM carries a row whole; CAN in as many
FD frames as it takes.
"""
from dataclasses import dataclass, field

NOTE = "Generated from hal/signals.toml by tools/signals/generate.py: change the table, not this file."
INPUTS, INPUTS_END = 0xD0, 0xF0  # identifiers: one for each input there may be, below those of truth
FD_LENGTHS = (8, 12, 16, 20, 24, 32, 48, 64)
TEETH_A_FRAME = 13
WHEELS = 14  # what four bits have room for beside crank and cam
LCM_ROWS = 512
BITS = {"u4": 4, "u8": 8, "u16": 16, "u32": 32, "i32": 32, "f32": 32, "f64": 64}
TOP = {"u4": 2**4 - 1, "u8": 2**8 - 1, "u16": 2**16 - 1, "u32": 2**32 - 1, "i32": 2**31 - 1}
LCM_TYPE = {"u8": "int8_t", "u16": "int16_t", "u32": "int32_t", "i32": "int32_t", "f32": "float", "f64": "double"}
HEALTH = dict(enumerate(("valid", "degraded", "invalid")))
COMMANDS = dict(enumerate(("read", "read_reference", "set", "restore")))
EDGES = dict(enumerate(["crank", "cam"] + [f"wheel_{i}" for i in range(WHEELS)]))
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
        used = -(-sum(BITS[f.type] for f in self.fields) // 8)
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
    teeth = order + [Field("count", "u8", "", (1, TEETH_A_FRAME), "Ticks that are meant.")]
    teeth += [Field(f"tick_{i}", "u32", "tick") for i in range(TEETH_A_FRAME)]
    teeth += [Field(f"edge_{i}", "u4", "", (0, 15), f"Of which wheel tick {i} is an edge.", EDGES) for i in range(TEETH_A_FRAME)]
    request = [Field("command", "u8", "", (0, 3), "sd_parameter_command_t.", COMMANDS),
               Field("index", "u8", "", (0, 255), "Of the parameter; all: to restore.", names), Field("value", "f32")]
    answer = [Field("command", "u8", "", (0, 3), "Of the request.", COMMANDS),
              Field("index", "u8", "", (0, 255), "Of the parameter.", names), Field("value", "f32", text="What holds now."),
              Field("result", "u8", "", (0, 4), "sd_parameter_result_t.", RESULTS)]
    out = [Message("teeth", 0xA0, "plant", "Captured edges of all toothed wheels, in order.", teeth),
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
    assert INPUTS + len(table.get("input", [])) <= INPUTS_END
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
            bits, real, signed = BITS[f.type], f.type[0] == "f", f.type[0] != "u"
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
    truth = [number("edges"), number("cycles"), number("end", "1: the run is over."), number("sent_edges", "So far."),
             number("sent_cycles", "So far."),
             Field("edge[edges]", "truth_edge_t"), Field("cycle[cycles]", "truth_cycle_t")]
    parameter = [number("command", "sd_parameter_command_t"), number("index"), number("value", type="f32"),
                 number("result", "sd_parameter_result_t, in the answer.")]
    out = [f"// {NOTE}", "// SPDX-License-Identifier: MIT", "// Unsigned numbers travel in the signed types of the same size.",
           "package sixdeg;", ""]
    out += lcm_struct("event_t", events, "As in hal.h.") + lcm_struct("inputs_t", inputs, "SIXDEG_INPUTS: plant to ecu.")
    for m in row_messages(table, 10**6):
        place = number("place", "Among the rows of its message: the order in which the ecu said them.")
        out += lcm_struct(f"{m.rate}_t", [m.fields[0], place] + m.fields[1:], m.text)
    out += lcm_struct("outputs_t", outputs, "SIXDEG_OUTPUTS: what the ecu says, at the latest at each clock event.")
    edge, cycle, _ = truth_messages()
    out += lcm_struct("truth_edge_t", edge.fields, edge.text) + lcm_struct("truth_cycle_t", cycle.fields, cycle.text)
    out += lcm_struct("truth_t", truth, "SIXDEG_TRUTH: plant to whoever compares.")
    out += lcm_struct("parameter_t", parameter, "SIXDEG_PARAMETER_REQUEST and its answer, SIXDEG_PARAMETER.")
    out += lcm_struct("claim_t", [number("id"), number("signature")], "SIXDEG_CLAIM: as the CAN frame of that name.")
    return "\n".join(out)


def row_code(table, bus, includes, type_of, room, cast):
    """from and to a row, for every message of a bus: {bus}_{message}_from_row, _to_row. `cast`: to the types of that bus."""
    out = [f"/* {NOTE} */", "/* SPDX-License-Identifier: MIT */", f"#ifndef {bus.upper()}_ROWS_H", f"#define {bus.upper()}_ROWS_H",
           *[f'#include "{name}"' for name in includes], '#include "sd_row.h"', "", "#ifdef __cplusplus", 'extern "C" {', "#endif", ""]
    for m in row_messages(table, room):
        kind = type_of(m.name)
        out += [f"static inline void {bus}_{m.name}_from_row({kind} *m, const sd_row_t *row) {{",
                f"    m->tick = ({cast['u32']})row->tick;"]
        for owner in m.owners:
            out += [f"    m->{owner}_health = ({cast['u8']})row->health[SD_OWNER_{owner.upper()}];",
                    f"    m->{owner}_why = ({cast['u16']})row->why[SD_OWNER_{owner.upper()}];"]
        out += [f"    m->{name} = row->value[{channel}];" for channel, _, name in m.channels] + ["}", ""]
        out += [f"static inline void {bus}_{m.name}_to_row(sd_row_t *row, const {kind} *m) {{",
                f"    sd_row_begin(row, (uint32_t)m->tick, SD_RATE_{m.rate.upper()});"]
        for owner in m.owners:
            out.append(f"    sd_row_status(row, SD_OWNER_{owner.upper()}, (uint8_t)m->{owner}_health, (uint16_t)m->{owner}_why);")
        out += [f"    sd_row_put(row, {channel}, m->{name});" for channel, _, name in m.channels] + ["}", ""]
    return out


END = ["#ifdef __cplusplus", "}", "#endif", "#endif", ""]


def can_rows(table):
    """Rows by frame identifier."""
    rows = row_messages(table)
    out = row_code(table, "sd_bus", ["sd_bus.h"], lambda name: f"struct sd_bus_{name}_t", 64,
                   {"u8": "uint8_t", "u16": "uint16_t", "u32": "uint32_t"})
    out += [f"#define SD_BUS_INPUTS_FIRST {INPUTS:#x}u",
            f"#define SD_BUS_INPUTS_END   {INPUTS + len(table.get('input', [])):#x}u /* the identifier after the last input's */",
            f"#define SD_BUS_ROW_FRAMES   {max(sum(m.rate == of.rate for m in rows) for of in rows)}u /* of the longest row */",
            f"#define SD_BUS_WHEELS       {WHEELS}u /* whose edges a teeth frame can carry */", "",
            "/* How many bytes frame `part` of a row of `rate` takes, its identifier in *id; 0 when there is no such part. */",
            "static inline uint32_t sd_bus_row_pack(const sd_row_t *row, uint32_t part, uint32_t *id, uint8_t bytes[64]) {",
            "    uint32_t at = 0;"]
    for m in rows:
        out += [f"    if ((row->rate == SD_RATE_{m.rate.upper()}) && (at++ == part)) {{", f"        struct sd_bus_{m.name}_t m;",
                f"        sd_bus_{m.name}_from_row(&m, row);", f"        *id = SD_BUS_{m.name.upper()}_FRAME_ID;",
                f"        return (uint32_t)sd_bus_{m.name}_pack(bytes, &m, 64);", "    }"]
    out += ["    return 0;", "}", "", "/* 1: `id` is a row's and *row holds it; 0: it is not; -1: it is, and too short. */",
            "static inline int sd_bus_row_unpack(sd_row_t *row, uint32_t id, const uint8_t *bytes, size_t size) {"]
    for m in rows:
        out += [f"    if (id == SD_BUS_{m.name.upper()}_FRAME_ID) {{", f"        struct sd_bus_{m.name}_t m;",
                f"        if ((size != SD_BUS_{m.name.upper()}_LENGTH) || (sd_bus_{m.name}_unpack(&m, bytes, size) != 0)) {{ return -1; }}",
                f"        sd_bus_{m.name}_to_row(row, &m);", "        return 1;", "    }"]
    return "\n".join(out + ["    return 0;", "}", ""] + END)


def lcm_rows(table):
    """The rows of an outputs message, of every rate."""
    rows = row_messages(table, 10**6)
    names = [f"sixdeg_{m.name}_t.h" for m in rows] + ["sixdeg_outputs_t.h"]
    out = row_code(table, "sd_lcm", names, lambda name: f"sixdeg_{name}_t", 10**6, {"u8": "int8_t", "u16": "int16_t", "u32": "int32_t"})
    out += [f"#define SD_LCM_ROWS {LCM_ROWS} /* of a rate in one message; beyond it a message goes early */", "",
            "/* What goes out with the next message. */", "typedef struct sd_lcm_rows {"]
    out += [f"    sixdeg_{m.name}_t {m.name}[SD_LCM_ROWS];" for m in rows]
    out += ["    int32_t count[SD_RATE_COUNT];", "    int32_t places; /* Rows in all. */", "} sd_lcm_rows_t;", "",
            "/* 1: the row has joined the others; 0: there is no room. */",
            "static inline int sd_lcm_rows_add(sd_lcm_rows_t *self, const sd_row_t *row) {",
            "    if ((row->rate >= SD_RATE_COUNT) || (self->count[row->rate] >= SD_LCM_ROWS)) { return 0; }",
            "    const int32_t at = self->count[row->rate]++;"]
    for m in rows:
        out += [f"    if (row->rate == SD_RATE_{m.rate.upper()}) {{", f"        sd_lcm_{m.name}_from_row(&self->{m.name}[at], row);",
                f"        self->{m.name}[at].place = self->places;", "    }"]
    out += ["    self->places++;", "    return 1;", "}", "", "/* 1: of some rate there is no room for another row. */",
            "static inline int sd_lcm_rows_full(const sd_lcm_rows_t *self) {",
            "    for (uint32_t rate = 0; rate < SD_RATE_COUNT; ++rate) {", "        if (self->count[rate] >= SD_LCM_ROWS) { return 1; }",
            "    }", "    return 0;", "}", "", "static inline void sd_lcm_rows_clear(sd_lcm_rows_t *self) {",
            "    memset(self->count, 0, sizeof self->count);", "    self->places = 0;", "}", "",
            "/* The message points into *self. */", "static inline void sd_lcm_rows_to_message(sixdeg_outputs_t *m, sd_lcm_rows_t *self) {"]
    for m in rows:
        out += [f"    m->{m.rate}s = self->count[SD_RATE_{m.rate.upper()}];", f"    m->{m.rate} = self->{m.name};"]
    out += ["}", "",
            "/* 1: *row is the next one of the message by its place; taken[], zero to begin, counts those handed out of each rate. "
            "0: that was all. */",
            "static inline int sd_lcm_rows_next(sd_row_t *row, const sixdeg_outputs_t *m, int32_t taken[SD_RATE_COUNT]) {",
            "    int32_t place = 0;", "    uint32_t next = SD_RATE_COUNT;"]
    for m in rows:
        rate = f"SD_RATE_{m.rate.upper()}"
        out += [f"    if ((taken[{rate}] < m->{m.rate}s) && ((next == SD_RATE_COUNT) || (m->{m.rate}[taken[{rate}]].place < place))) {{",
                f"        place = m->{m.rate}[taken[{rate}]].place;", f"        next = {rate};", "    }"]
    for m in rows:
        rate = f"SD_RATE_{m.rate.upper()}"
        out.append(f"    if (next == {rate}) {{ sd_lcm_{m.name}_to_row(row, &m->{m.rate}[taken[{rate}]]); }}")
    out += ["    if (next == SD_RATE_COUNT) { return 0; }", "    taken[next]++;", "    return 1;", "}", ""]
    return "\n".join(out + END)


def files(table):
    return {"sixdeg.dbc": dbc(table), "sixdeg.lcm": lcm(table),
            "can/sd_bus_rows.h": can_rows(table), "lcm/sd_lcm_rows.h": lcm_rows(table)}
