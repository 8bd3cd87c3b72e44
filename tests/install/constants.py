#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""constants.py SOURCE [--update]: every named constant of libspheretree and libruntime has a row in docs/constants.md,
with its value.

So have the efforts of the qualities and the defaults of settings within libspheretree/src, in tables of their own.
--update writes the values that the sources have now, adds rows for new constants, whose kind has to be filled in, and
drops old ones."""
import re
import subprocess
import sys
from pathlib import Path

KINDS = {"paper", "rounding", "format", "sentinel", "requirement", "measured", "guard", "derived"}
NAMED = {"paper": (re.compile(r"\b(?:19|20)\d\d\b"), "the year of a publication"),
         "requirement": (re.compile(r"\b(docs/[\w/]+\.md|[\w/]+\.(?:h|cpp))\b"), "a document or a source file")}  # what a row of the kind names
DECLARATION = re.compile(r"^\s*(?:(?:inline|static)\s+)*constexpr\s+(?:auto|[\w:]+(?:<[^;=]*>)?)\s+(k[A-Z][^;]*?);[ \t]*(?://[ \t]*(.*))?$", re.MULTILINE)
PAGE_HEAD = "| constant | value | kind | why this value |\n|---|---|---|---|\n"


def constants(root):
    """FILE -> NAME -> (value, comment), in the order of the sources."""
    found = {}
    for folder in ("libspheretree", "libruntime"):
        for path in sorted((root / folder).rglob("*")):
            if path.suffix not in (".h", ".cpp"):
                continue
            for declaration in DECLARATION.finditer(path.read_text(encoding="utf-8")):
                text, comment = declaration.groups()
                for part in re.split(r",\s*(?:\n\s*)?(?=k[A-Z]\w*\s*[={])", text):
                    part = " ".join(re.sub(r"//[^\n]*", "", part).split())
                    name = re.match(r"k\w+", part).group(0)
                    value = part[len(name):].strip().removeprefix("=").strip()
                    found.setdefault(str(path.relative_to(root)), {})[name] = (value, (comment or "").strip())
    return found


def settings(root):
    """(FILE, FIELD) -> values: of each quality in the tables of efforts; the default of each setting that is neither 0
    nor a seed."""
    found = {}
    for path in sorted((root / "libspheretree/src").rglob("*")):
        if path.suffix not in (".h", ".cpp"):
            continue
        text, file = path.read_text(encoding="utf-8"), str(path.relative_to(root))
        for quality in ("Quick", "Standard", "Best"):
            for body in re.findall(r"case Quality::" + quality + r":\s*return \{(.*?)\};", text, re.DOTALL):
                for field, value in re.findall(r"\.(\w+) = ([^,}]+)", body):
                    found[file, field] = found.get((file, field), ()) + (value,)
        for name, body in re.findall(r"^struct (\w+Settings|SearchStart) \{\n(.*?)^\};", text, re.DOTALL | re.MULTILINE):
            for field, value in re.findall(r"^  [\w:]+ (\w+) =\s*([-\d][^;]*);", body, re.MULTILINE):
                if value != "0" and field != "seed":
                    found[file, f"{name}.{field}"] = (value,)
    return found


def setting_rows(page):
    """(FILE, FIELD) -> values, of these tables in docs/constants.md."""
    found = re.findall(r"^\| `([\w.]+/[\w/.]+)` \| `([\w.]+)` \| (.*) \| [^|]{6,} \|$", page, re.MULTILINE)
    return {(file, field): tuple(value.strip("`") for value in values.split(" | ")) for file, field, values in found}


def rows(page):
    """FILE -> NAME -> (value, kind, why), of docs/constants.md."""
    found, file = {}, ""
    for line in page.splitlines():
        if heading := re.match(r"### `(.+)`", line):
            file = heading.group(1)
        elif row := re.match(r"\| `(k\w+)` \| (.*?) \| (\w*) \| (.*) \|$", line):
            found.setdefault(file, {})[row.group(1)] = (row.group(2).strip("`"), row.group(3), row.group(4))
    return found


def shown(value):
    return value.replace("|", "\\|") if len(value) <= 60 else value[:57].replace("|", "\\|") + "..."


def updated(page, code, old):
    body = []
    for file, names in code.items():
        body.append(f"### `{file}`\n\n{PAGE_HEAD}")
        for name, (value, comment) in names.items():
            _, kind, why = old.get(file, {}).get(name, ("", "", comment))
            body.append(f"| `{name}` | `{shown(value)}` | {kind} | {why} |\n")
        body.append("\n")
    return page.split("### `")[0] + "".join(body).rstrip() + "\n"


def main():
    root = Path(sys.argv[1])
    path = root / "docs/constants.md"
    page, code = path.read_text(encoding="utf-8"), constants(root)
    if "--update" in sys.argv[2:]:
        path.write_text(updated(page, code, rows(page)), encoding="utf-8")
        page = path.read_text(encoding="utf-8")
    table, faults = rows(page), []
    headings = re.findall(r"^### `(.+)`", page, re.MULTILINE)
    faults += [f"docs/constants.md: {file} has two tables" for file in sorted(set(headings)) if headings.count(file) > 1]
    for file, names in code.items():
        for name, (value, _) in names.items():
            row = table.get(file, {}).get(name)
            if row is None:
                faults.append(f"{file}: {name} has no row in docs/constants.md; tests/install/constants.py . --update adds one")
            elif row[0] != shown(value):
                faults.append(f"{file}: {name} is {value}, docs/constants.md says {row[0]}; its figures may be out of date")
            elif row[1] not in KINDS:
                faults.append(f"docs/constants.md: the kind of {name} ({file}) is '{row[1]}', none of {', '.join(sorted(KINDS))}")
            elif len(row[2]) < 6:
                faults.append(f"docs/constants.md: {name} ({file}) has no reason")
            elif row[1] in NAMED and not NAMED[row[1]][0].search(row[2]):
                faults.append(f"docs/constants.md: {name} ({file}) is of the kind {row[1]}, but does not name {NAMED[row[1]][1]}")
    faults += [f"docs/constants.md: {file} has no constant {name}" for file, names in table.items() for name in names if name not in code.get(file, {})]
    set_in_code, in_tables = settings(root), setting_rows(page)
    faults += [f"{file}: {field} is {set_in_code.get((file, field))}, docs/constants.md says {in_tables.get((file, field))}"
               for file, field in sorted(set_in_code.keys() | in_tables.keys()) if set_in_code.get((file, field)) != in_tables.get((file, field))]
    count = sum(map(len, code.values()))
    if count < 100 or len(set_in_code) < 20:
        faults.append(f"only {count} constants and {len(set_in_code)} settings found: the test looks in the wrong place")
    print("\n".join(faults) if faults else f"constants: {count}, settings: {len(set_in_code)}, each with its row")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
