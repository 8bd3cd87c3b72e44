#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""c_interface.py SOURCE [--cc CC] [--library LIBRARY...] [--update]: the interface in C is that of c_interface.txt.

The record has a line for each constant with its value, each struct with its size, each member with its place and type,
and each function with its types, as a compiler of C sees the three headers on a machine with 64 bits. Lines may be
added (docs/interfaces.md): functions, constants, structs, and members at the end of structs that begin with
`struct_size`. Nothing may change or go, unless SPHERETREE_ABI in CMakeLists.txt was raised. Each LIBRARY exports every
function of its header, and nothing else. --update writes the record anew, if it keeps to these rules."""
import argparse
import re
import subprocess
import sys
import tempfile
from pathlib import Path

HEADERS = {"runtime": "runtime/runtime.h", "scene": "scene/scene.h", "servo": "servo/servo.h"}


def plain(text: str) -> str:
    text = re.sub(r"/\*.*?\*/", " ", text, flags=re.DOTALL)
    return re.sub(r"^\s*#.*?(?<!\\)$", " ", text, flags=re.DOTALL | re.MULTILINE)


def squeezed(text: str) -> str:
    return re.sub(r"\s*([*(),\[\]])\s*", r"\1", " ".join(text.split()))


def members(body: str):
    """(type, name) of each member; `double a, b[3]` has two."""
    for declaration in filter(None, (squeezed(part) for part in body.split(";"))):
        kind, names = re.fullmatch(r"(.*?[\s*])(\w+(?:\[\w+\])*(?:,\w+(?:\[\w+\])*)*)", declaration).groups()
        for name in names.split(","):
            bounds = name[len(re.match(r"\w+", name).group()):]
            yield kind.strip() + bounds, re.match(r"\w+", name).group()


def described(header: Path):
    """Functions as lines, and the lines of a program in C that prints the rest."""
    raw = header.read_text(encoding="utf-8")
    text = plain(raw)
    functions = [squeezed(f"{kind} {name}({arguments})") for kind, name, arguments in re.findall(r"\bST_API\s+([^;()]*?[\s*])(st_\w+)\s*\(([^;]*?)\)\s*;", text)]
    prints = []
    for body in re.findall(r"\benum\b[^{;]*\{(.*?)\}", text, re.DOTALL):
        prints += [f'printf("constant {name} %lld\\n", (long long){name});' for name in re.findall(r"\b(ST_\w+)\s*(?:=|,|$)", body.strip())]
    prints += [f'printf("constant {name} %lld\\n", (long long){name});' for name in re.findall(r"^#define (ST_MAX\w+) ", raw, re.MULTILINE)]
    for name, body in re.findall(r"typedef\s+struct\s+(st_\w+)\s*\{(.*?)\}\s*\1\s*;", text, re.DOTALL):
        prints.append(f'printf("struct {name} %zu\\n", sizeof({name}));')
        prints += [f'printf("member {name}.{member} %zu {kind}\\n", offsetof({name}, {member}));' for kind, member in members(body)]
    return functions, prints


def interface(root: Path, cc: str) -> list:
    lines = []
    with tempfile.TemporaryDirectory() as work:
        for header in HEADERS.values():
            found = next(root.glob(f"libruntime/*/include/spheretree/{header}"))
            functions, prints = described(found)
            program = Path(work) / "program.c"
            program.write_text(f"#include <stddef.h>\n#include <stdio.h>\n#include <spheretree/{header}>\nint main(void) {{\n" + "\n".join(prints) + "\nreturn 0; }\n")
            includes = [f"-I{folder}" for folder in root.glob("libruntime/*/include")]
            subprocess.run([*cc.split(), *includes, str(program), "-o", f"{work}/program"], check=True)
            output = subprocess.run([f"{work}/program"], capture_output=True, text=True, check=True).stdout.splitlines()
            lines += [f"# spheretree/{header}"] + output + [f"function {function}" for function in functions]
    return lines


def broken(old: list, new: list) -> list:
    """What a program that was compiled with `old` would miss in `new`."""
    def sized(lines):
        return {line.split()[1].split(".")[0] for line in lines if line.startswith("member") and ".struct_size 0 " in line}

    present, faults = set(new), []
    for line in old:
        grows = line.startswith("struct ") and line.split()[1] in sized(old)
        if grows:
            now = next((other for other in new if other.startswith(f"struct {line.split()[1]} ")), None)
            if now is None or int(now.split()[2]) < int(line.split()[2]):
                faults.append(line)
        elif not line.startswith("#") and line not in present:
            faults.append(line)
    return faults


def exported(library: str) -> set:
    output = subprocess.run(["nm", "--dynamic", "--defined-only", library], capture_output=True, text=True, check=True).stdout
    return {line.split()[-1] for line in output.splitlines()}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("source", type=Path)
    parser.add_argument("--cc", default="cc")
    parser.add_argument("--library", nargs="*", default=[])
    parser.add_argument("--update", action="store_true")
    options = parser.parse_args()
    root = options.source.resolve()
    record = root / "tests/contract/c_interface.txt"
    abi = re.search(r"^set\(SPHERETREE_ABI (\d+)\)", (root / "CMakeLists.txt").read_text(), re.MULTILINE).group(1)
    new = [f"abi {abi}"] + interface(root, options.cc)
    old = record.read_text(encoding="utf-8").splitlines() if record.exists() else [f"abi {abi}"]
    faults = [f"changed or gone: {line}" for line in broken(old[1:], new)] if old[0] == new[0] else []
    for library in options.library:
        room = next(name for name in HEADERS if f"spheretree_{name}." in Path(library).name)
        headers = [HEADERS[room]] + ([HEADERS["runtime"]] if room == "scene" else [])  # that library holds the runtime, too
        wanted = {re.search(r"(st_\w+)\(", line).group(1) for header in headers for line in section(new, header) if line.startswith("function")}
        faults += [f"{library} does not export {name}" for name in sorted(wanted - exported(library))]
        faults += [f"{library} exports {name}, which is in no header" for name in sorted(exported(library) - wanted)]
    if faults:
        sys.exit("\n".join(faults) + "\nA program that was linked before would not run any more. Keep the old form beside the new one, or raise "
                 "SPHERETREE_ABI in CMakeLists.txt (docs/interfaces.md).")
    if options.update:
        record.write_text("\n".join(new) + "\n", encoding="utf-8")
    elif new != old:
        sys.exit("The interface in C has grown. Record it: python3 tests/contract/c_interface.py . --update")
    print(f"{len(new)} lines, {len(options.library)} libraries: as recorded")


def section(lines: list, header: str) -> list:
    start = lines.index(f"# spheretree/{header}") + 1
    end = next((i for i in range(start, len(lines)) if lines[i].startswith("#")), len(lines))
    return lines[start:end]


main()
