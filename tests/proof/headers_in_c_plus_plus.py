#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Every header of firmware/ and hal/ can be included from C++ alone, and says there that its functions are C's."""
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
folders = sorted({path.parent for part in ("firmware", "hal") for path in (ROOT / part).rglob("*.h")})
headers = [path for folder in folders for path in sorted(folder.glob("*.h"))]
lcm = subprocess.run(["pkg-config", "--cflags", "lcm"], capture_output=True, text=True, check=True).stdout.split()
fixed = [path for path in headers if path.parent.name == "ecu_fixed"]  # of the other kind of ecu, which has the same names
wrong = []


def look(headers, flags, folder):
    """Compiles them together, and a table of their functions."""
    source = pathlib.Path(folder) / "all.cpp"
    for path in headers:
        if not re.search(r'^#ifdef __cplusplus\nextern "C" \{\n#endif$.*^#ifdef __cplusplus\n\}\n#endif$', path.read_text(), re.M | re.S):
            wrong.append(f'{path.relative_to(ROOT)}: no extern "C" for C++')
    source.write_text("".join(f'#include "{path}"\n' for path in headers))
    done = subprocess.run(["c++", "-std=c++17", "-fsyntax-only", *flags, *(f"-I{f}" for f in folders), source],
                          capture_output=True, text=True)
    if done.returncode:
        wrong.append(done.stderr)
    names = r"^(?:[a-z]\w*[ *]+)+(sd_\w+)\((?=.*\);)"  # one function of each header that has any must have a C name
    declared = [m[1] for path in headers if (m := re.search(names, path.read_text(), re.M)) and "static" not in m[0]]
    source.write_text(source.read_text() + "void *all[] = {" + ", ".join(f"(void *){name}" for name in declared) + "};\n")
    subprocess.run(["c++", "-std=c++17", "-c", *flags, *(f"-I{f}" for f in folders), source, "-o", pathlib.Path(folder) / "all.o"],
                   check=not wrong)
    if not wrong:
        symbols = subprocess.run(["nm", "-u", pathlib.Path(folder) / "all.o"], capture_output=True, text=True, check=True).stdout
        wrong.extend(f"{line.split()[-1]} is mangled" for line in symbols.splitlines() if line.split()[-1].startswith("_Z"))
        assert len(declared) > (20 if len(headers) > 20 else 3), declared


with tempfile.TemporaryDirectory() as here:
    look([path for path in headers if path not in fixed], lcm, here)
    look(fixed, ["-DSD_ECU_FIXED=1"], here)
sys.exit("\n".join(wrong) or 0)
