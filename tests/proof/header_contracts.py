#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The headers of firmware/ and hal/ are their manual: every public declaration has a comment, every quantity its unit, every setting its
range.

What a rule can decide, and no more:
- A header begins with what it is. A struct, an enum, a function, a macro has a comment above or behind it; functions that stand together
  without a blank line may share one. So has an enumerator, and a field unless it is a struct, whose type says it.
- A comment behind a field is a sentence of its own: it ends with a full stop and does not go on from the field above.
- A real number (field, parameter, result) has a unit in its name or in its comment, or is said to be a share, a factor or the like.
- A field of a *_config, *_choice or *_tables has its range there, for that is what init refuses by.
- The comment of a function that returns sd_result_t says when it is not SD_OK.
- A paper comes with its equation, section, figure or table.
"""
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
REAL = r"float|double|sd_q31_t|sd_gain_\w+|T"
NUMBER = re.compile(rf"^(?:const |volatile )*(?:{REAL}|u?int\d+_t|bool|size_t|char|unsigned)\b")
UNIT_NAME = re.compile(
    r"(?:_|^)(nm|nmps?|nm2|rad|rad2|radps|radps2|radpnm|nmprad|nmpkg|deg|bar|kpa|pa|s|s2|ms|us|hz|rpm|kgm2|j|mg|kg|g|gps|kgps|k|m|m2|m3|"
    r"mm|jpmg|ticks?|teeth|percent|rthz|pu|spacings|share|ratio|factor|fraction|ratios|shares|factors|exponent|lambda|gain|square|variance|"
    r"per_\w+)$")
UNIT_WORD = re.compile(
    r"\b(rad|deg|s|ms|us|Nm|N m|bar|kPa|Pa|K|J|kg|mg|g|m|m2|m3|Hz|rpm|Q\d+|pu|lambda)\b|1/|/s\b|\^|"
    r"[\[(]-?[\d.]+e?-?\d*, ?-?[\w.]+[\])]|\bsd_\w+_t\b|"
    r"(?i:\b(degrees|seconds|ticks?|percent|shares?|ratio|fraction|factor|times|over|per|exponent|probability|gains?|squared?|deviations|"
    r"weight|cosine|sine|variances?|covariances?|likelihood|units?|coefficients?|number of|count|rms|mean of|sum of|the same)\b)")
RANGE = re.compile(
    r"[\[(]\s*-?[\w.^*/ +-]+,\s*-?[\w.^*/ +-]+[\])]|\bto\b|[<>]=?\s*-?\d|\b[01]:|\bsd_\w+_t\b|\bbits?\b|\bup to\b|\bbelow\b|\bat least\b|"
    r"\bat most\b|\bany\b|\bNULL\b|\bascending\b|\beach once\b|\bpositive\b|\bpower of\b|\beven\b|\bor\b \d|\bas \w+ says\b", re.I)
SETTINGS = re.compile(r"_(config|choice|tables|settings)$")
PAPER = re.compile(r"\bdocument 00\d|\bpaper 00\d", re.I)
PLACE = re.compile(r"equation|\([0-9]+[a-z]?\)|section|figure|table|block|lemma|theorem|algorithm|docs/theory/", re.I)


class Header:
    """Reads a header from top to bottom and notes what is missing."""

    def __init__(self, name, text):
        self.name, self.wrong = name, []
        self.doc, self.shared, self.last = "", "", None  # comment above; that of the function before; the item a comment may go on for
        self.items, self.stack, self.code, self.behind, self.body = [], [], "", "", 0
        self.arithmetic = "/num/" in name  # on numbers of any unit
        self.read(text)
        self.judge_items()
        self.judge_head(text)

    def fault(self, line, what):
        self.wrong.append(f"{self.name}:{line}: {what}")

    def judge_head(self, text):
        head = re.search(r"^///.*(?:\n///.*)*", text, re.M)
        if not head or pathlib.Path(self.name).stem not in head[0].splitlines()[0]:
            self.fault(1, "does not begin with '/// NAME.h - what it is'")
        if PAPER.search(text) and not PLACE.search(text):
            self.fault(1, "names a paper without equation, section, figure or table")

    def read(self, text):
        text = re.sub(r'#ifdef __cplusplus\n(?:extern "C" \{|\})\n#endif', "\n\n", text)
        text = re.sub(r"^/\* SPDX.*", "", text)
        text = re.sub(r"^[ \t]*/\*(.*?)\*/[ \t]*$", lambda m: "\n".join("///" + line.lstrip(" *") for line in m[1].split("\n")), text,
                      flags=re.M | re.S)
        text = re.sub(r"/\*(.*?)\*/[ \t]*$", r"///<\1", text, flags=re.M)
        macro = False
        for number, line in enumerate(text.splitlines(), 1):
            code, _, comment = line.partition("///")
            if macro or code.startswith("#"):
                if not macro:
                    self.macro(number, code, comment)
                macro = code.rstrip().endswith("\\")
            elif not code.strip() and comment.startswith("<"):
                self.go_on(comment[1:])
            elif not code.strip() and comment:
                self.doc += " " + comment.strip()
            elif not code.strip() and not line.strip():
                self.doc = self.doc if self.code else ""
                self.shared = self.shared if self.arithmetic else ""  # one comment for the verbs of a group
            else:
                self.take(number, code, comment[1:] if comment.startswith("<") else "")

    def go_on(self, comment):
        if self.code:
            self.behind += " " + comment.strip()
        elif self.last:
            self.last["behind"] += " " + comment.strip()

    def macro(self, number, code, comment):
        if re.match(r"#ifndef \w+_H\b", code):
            self.doc = ""
        found = re.match(r"#define (\w+)(\([^)]*\))?(.*)", code)
        if not found or (found[3].strip() == "" and not found[2]) or len(found[1]) == 1:  # a guard; a letter that ends with its header
            return
        self.item(number, "macro", found[1], "", comment[1:] if comment.startswith("<") else "")
        self.doc = ""

    def item(self, number, kind, name, code, behind):
        self.last = {"line": number, "kind": kind, "name": name, "code": code, "behind": behind.strip(), "above": self.doc.strip(),
                     "of": self.stack[-1]["name"] if self.stack else "", "shared": self.shared}
        self.items.append(self.last)
        if kind in ("function", "macro"):
            self.shared = self.doc.strip() or self.shared
        return self.last

    def take(self, number, code, behind):
        if self.body:  # of an inline function
            self.body += code.count("{") - code.count("}")
            return
        self.code += " " + code.strip()
        self.behind += " " + behind.strip()
        opened = re.match(r"\s*(?:typedef )?(struct|union|enum)(?: (\w+))? ?\{", self.code)
        if opened:
            kind, name = opened[1], opened[2] or ""
            if name or not self.stack:
                self.item(number, kind, name or "(nameless)", self.code, self.behind)
            self.stack.append({"kind": kind, "name": name})
            rest = self.code[self.code.index("{") + 1:]
            self.code = self.behind = self.doc = ""
            if rest.strip():
                self.take(number, rest, behind)
            return
        if self.stack and re.match(r"\s*\}", self.code):
            self.stack.pop()
            self.code = self.behind = self.doc = ""
            return
        if self.stack and self.stack[-1]["kind"] == "enum":
            for one in filter(None, (part.strip() for part in re.sub(r"\}.*", "", self.code).split(","))):
                self.item(number, "enumerator", one.split()[0], one, self.behind)
            closed = "}" in self.code
            self.code = self.behind = self.doc = ""
            if closed:
                self.stack.pop()
            return
        self.statement(number)

    def statement(self, number):
        code = self.code.strip()
        if code.endswith("{") or re.search(r"\)\s*\{.*\}$", code):
            self.item(number, "function", re.search(r"(\w+)\(", code)[1], code.split("{")[0], self.behind)
            self.body = code.count("{") - code.count("}")
        elif not code.endswith(";"):
            return  # goes on in the next line
        elif self.stack and self.arithmetic and not self.stack[-1]["name"]:
            pass  # parts of a number
        elif self.stack:
            self.item(number, "field", ", ".join(re.findall(r"(\w+)(?:\[[^;]*?\])?\s*(?=[,;])", code)), code, self.behind)
        elif re.match(r"(?:typedef )?(?:struct|union|enum) \w+(?: \w+)?;|_Static_assert", code):
            pass
        elif "(" in code and not code.startswith("typedef"):
            self.item(number, "function", re.search(r"(\w+)\(", code)[1], code, self.behind)
        else:
            self.item(number, "declaration", code.rstrip(";").split()[-1], code, self.behind)
        self.code = self.behind = self.doc = ""

    def judge_items(self):
        for item in self.items:
            comment = " ".join(filter(None, (item["behind"], item["above"])))
            if item["kind"] in ("function", "macro"):
                comment = comment or item["shared"]
            if not comment and not (item["kind"] == "field" and not NUMBER.match(item["code"]) and "*" not in item["code"]):
                self.fault(item["line"], f"{item['kind']} {item['name']} has no comment")
            elif comment:
                getattr(self, "judge_" + item["kind"], lambda *_: None)(item, comment)
            behind = item["behind"]
            goes_on = not behind.endswith((".", ")")) or re.match(r"(and|or|but|for|of|with) ", behind)
            if item["kind"] in ("field", "enumerator") and behind and goes_on:
                self.fault(item["line"], f"{item['kind']} {item['name']}: its comment is no sentence of its own")

    def judge_field(self, item, comment):
        numeric = NUMBER.match(item["code"])
        if numeric and re.match(rf"(?:const |volatile )*(?:{REAL})\b", item["code"]):
            for name in item["name"].split(", "):
                if not self.arithmetic and not UNIT_NAME.search(name) and not UNIT_WORD.search(comment):
                    self.fault(item["line"], f"field {name} has no unit")
        if numeric and SETTINGS.search(item["of"]) and not RANGE.search(comment):
            self.fault(item["line"], f"field {item['name']} of {item['of']} has no range")

    def judge_function(self, item, comment):
        head = item["code"].replace("static inline ", "")
        if head.startswith("sd_result_t") and not re.search(r"SD_OK|SD_ERR|as sd_\w+", comment):
            self.fault(item["line"], f"function {item['name']} does not say when it is not SD_OK")
        if self.arithmetic:
            return
        if re.match(rf"(?:{REAL}) ", head) and not UNIT_NAME.search(item["name"]) and not UNIT_WORD.search(comment):
            self.fault(item["line"], f"result of {item['name']} has no unit")
        inside = head[head.index("(") + 1:head.rindex(")")]
        for kind, name in re.findall(r"(?:^|, )(?:const )?(float|double|sd_q31_t) \*?(?:const )?(\w+)", inside):
            del kind
            if not UNIT_NAME.search(name) and not re.search(rf"\b{name}\b", comment) and not UNIT_WORD.search(comment):
                self.fault(item["line"], f"parameter {name} of {item['name']} has no unit")


def headers():
    """The public ones: not what is generated, nor what a block's own files share among them."""
    return [path for part in ("firmware", "hal") for path in sorted((ROOT / part).rglob("*.h"))
            if "generated" not in path.parts and not path.stem.endswith(("_parts", "_inline"))]


BARE = '''/// bare.h - what the check must find.
#ifndef BARE_H
#define BARE_H
#define BARE_MOST 4
typedef struct bare_config {
    float speed; ///< How fast it goes.
    uint8_t teeth; ///< Of the wheel,
    uint8_t marks;
} bare_config_t;
/// Whether it works.
sd_result_t bare_init(void);

float bare_step(float x);
/// Speed of the wheel.
float bare_speed(void);
/// After document 000.
void bare_paper(void);
#endif
'''
FOUND = ("macro BARE_MOST has no comment", "struct bare_config has no comment", "field speed has no unit",
         "field speed of bare_config has no range",
         "field teeth: its comment is no sentence", "field teeth of bare_config has no range", "field marks has no comment",
         "function bare_init does not say when", "function bare_step has no comment", "result of bare_speed has no unit",
         "names a paper without")


def control():
    """What a header without contracts should be blamed for, and is not; or the other way round."""
    said = Header("bare.h", BARE).wrong
    missing = [f"control: '{what}' was not found" for what in FOUND if not any(what in line for line in said)]
    return missing + [f"control: {line} is no fault" for line in said if not any(what in line for what in FOUND)]


if __name__ == "__main__":
    faults, counted = control(), 0
    for path in headers():
        header = Header(str(path.relative_to(ROOT)), path.read_text())
        faults += header.wrong
        counted += len(header.items)
    print("\n".join(faults) or f"{counted} declarations have their contract")
    sys.exit(1 if faults or counted < 1000 else 0)
