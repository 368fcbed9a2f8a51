# SPDX-License-Identifier: MIT
"""The calibration page and events in the other byte order. Which bytes belong together the compiler says: the layout of
sd_calibration_t is read from the debugging information of an object that holds one."""
import pathlib
import re
import struct
import subprocess
import tempfile
import zlib

ROOT = pathlib.Path(__file__).resolve().parents[2]
HEAD = struct.Struct("4I")  # sd_page_head_t: magic, bytes, signature, checksum


def entries(text):
    """Every entry of readelf's listing: (offset, depth, tag, attributes)."""
    found = []
    for line in text.splitlines():
        if start := re.match(r" <(\w+)><(\w+)>: Abbrev Number: \d+ \((\w+)\)", line):
            found.append((int(start[2], 16), int(start[1], 16), start[3], {}))
        elif found and (attribute := re.match(r"\s+<\w+>\s+(DW_AT_\w+)\s*: (?:\([^)]*\): )?(.*)", line)):
            found[-1][3][attribute[1]] = attribute[2].strip()
    return found


def number(text):
    return int(re.match(r"<?(0x[0-9a-f]+|\d+)", text)[1], 0)


class Types:
    """Where the numbers of a type lie. `named`: (offset, width) of each member of a struct, by "STRUCT.MEMBER" of the outermost two."""

    def __init__(self, text):
        self.all = entries(text)
        self.named = {}
        self.at = {offset: i for i, (offset, *_) in enumerate(self.all)}

    def children(self, i):
        depth = self.all[i][1]
        for j in range(i + 1, len(self.all)):
            if self.all[j][1] <= depth:
                return
            if self.all[j][1] == depth + 1:
                yield j

    def named_type(self, name):
        return next(i for i, (_, _, tag, names) in enumerate(self.all)
                    if tag == "DW_TAG_typedef" and names.get("DW_AT_name", "").split()[-1:] == [name])

    def of(self, i):
        return self.at[number(self.all[i][3]["DW_AT_type"])]

    def numbers(self, i, start, into, path=()):
        """Adds (offset, width) of every number of the type at entry i."""
        _, _, tag, attributes = self.all[i]
        if tag in ("DW_TAG_typedef", "DW_TAG_const_type", "DW_TAG_volatile_type"):
            return self.numbers(self.of(i), start, into, path)
        if path:
            self.named.setdefault(".".join(path[:2]), start)
        if tag == "DW_TAG_union_type":  # only the pool's words are unions: pool_numbers says what each is
            return number(attributes["DW_AT_byte_size"])
        if tag in ("DW_TAG_base_type", "DW_TAG_enumeration_type"):
            into.append((start, number(attributes["DW_AT_byte_size"])))
            return number(attributes["DW_AT_byte_size"])
        if tag == "DW_TAG_array_type":
            count, step = 1, 0
            for child in self.children(i):
                count *= number(self.all[child][3]["DW_AT_upper_bound"]) + 1
            for n in range(count):
                step = self.numbers(self.of(i), start + n * step, into, path)
            return count * step
        if tag != "DW_TAG_structure_type":
            raise SystemExit(f"other_order: a page holds no {tag}")
        for child in self.children(i):
            names = self.all[child][3]
            name = names["DW_AT_name"].split()[-1]
            self.numbers(self.of(child), start + number(names.get("DW_AT_data_member_location", "0")), into, (*path, name))
        return number(attributes["DW_AT_byte_size"])


def pool_numbers(page, named, driveline):
    """Of kalman.pool, whose words are unions (sd_motion.h): a row begins with four bytes, floats follow, then pairs of gains. Behind the
    rows pairs of entries, one for each part of each tooth; then floats, and where the page has one, the driveline, whose numbers are
    given."""
    def said(name, form="B"):
        return struct.unpack_from(f"<{form}", page, named[name])[0]
    row, gains, first = said("kalman.row_words", "H"), said("kalman.gains_at", "H"), named["kalman.pool"]
    rows = 2 * said("kalman.positions") * row
    columns, driveline_at = rows + said("kalman.parts") * said("kalman.positions"), said("driveline_at", "I")
    words = driveline_at or (len(page) - first) // 4
    for i in range(words):
        start = first + 4 * i
        if rows <= i < columns or (i < rows and i % row >= gains):
            yield from ((start, 2), (start + 2, 2))
        elif i >= columns or i % row > 0:
            yield start, 4
    if driveline_at:
        behind = first + 4 * driveline_at
        yield from ((behind + start, width) for start, width in driveline if behind + start + width <= len(page))


def page_numbers():
    """(offset, width) of every number of sd_calibration_t outside its pool, offsets of its members by name, and the numbers of
    sd_page_driveline_t, which may stand in the pool."""
    folders = [f"-I{path.parent}" for path in (ROOT / "firmware").glob("*/*.h")] + [f"-I{ROOT}/hal/generated", f"-I{ROOT}/hal"]
    with tempfile.TemporaryDirectory() as folder:
        source, built = pathlib.Path(folder, "page.c"), pathlib.Path(folder, "page.o")
        source.write_text('#include "sd_calibration.h"\nsd_calibration_t page;\nsd_page_driveline_t driveline;\n')
        subprocess.run(["gcc", "-g", "-gdwarf-4", "-c", source, "-o", built, *sorted(set(folders))], check=True)
        text = subprocess.run(["readelf", "--debug-dump=info", built], capture_output=True, text=True, check=True).stdout
    types, page, driveline = Types(text), [], []
    types.numbers(types.named_type("sd_page_driveline_t"), 0, driveline)
    types.named.clear()
    types.numbers(types.named_type("sd_calibration_t"), 0, page)
    return page, types.named, driveline


def swapped(data, numbers):
    out = bytearray(data)
    for start, width in numbers:
        out[start:start + width] = data[start:start + width][::-1]
    return bytes(out[:len(data)])


def other_page(page, layout):
    """A sealed page for a processor of the other byte order. layout: of page_numbers()."""
    numbers, named, driveline = layout
    body = swapped(page, [(start, width) for start, width in numbers if start + width <= len(page)] +
                   list(pool_numbers(page, named, driveline)))
    magic, size, signature, _ = struct.unpack("<4I", page[:HEAD.size])
    return struct.pack(">4I", magic, size, signature, zlib.crc32(body[HEAD.size:])) + body[HEAD.size:]


def other_events(events):
    """Events with their header, whose words and fields are 4, 2, 2, 4 and 4 bytes."""
    count = len(events) // 16 - 1
    out = struct.pack(">4I", *struct.unpack("<4I", events[:16]))
    return out + b"".join(struct.pack(">IHHII", *fields) for fields in struct.iter_unpack("<IHHII", events[16:16 + 16 * count]))
