#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""stability_table.py STABILITY.json [DOC.md]: the table of docs/stability.md from what `haptic-player --scenario all
--out` wrote.

Prints it, or puts it into the document; scenarios that the file does not have keep their rows there. Bold: passes."""
import json
import sys
from pathlib import Path

HEAD = ["| | quantity | passes at | paper | constrained | turned |", "|---|---|---|---|---|---|"]


def number(value):
    if value is None:
        return "-"
    if abs(value) < 1e-12:
        return "0"
    digits = f"{value:.2g}"
    return digits if "e-" in digits or abs(value) < 100 else f"{value:.0f}"


def rows(scenario):
    for i, figure in enumerate(scenario["figures"]):
        reported = figure["verdict"] == "reported"

        def shown(value, passes):
            return f"**{number(value)}**" if not reported and passes else number(value)

        unit = "" if figure["unit"] == "1" else f" [{figure['unit']}]"
        turned = figure.get("turned")
        results = figure["results"]
        yield (f"| {scenario['id'] if i == 0 else ''} | {figure['quantity']}{unit} | "
               f"{'*reported*' if reported else format(figure['pass'], 'g')} | "
               f"{shown(results.get('paper'), figure['paper_verdict'] == 'holds')} | "
               f"{shown(results['constrained'], results['constrained'] is not None and results['constrained'] <= figure['pass'])} | "
               f"{shown(turned, turned is not None and turned <= figure['pass'])} |")


def groups(lines):
    """Rows of a table by scenario, in their order."""
    known = {}
    for line in lines:
        name = line.split("|")[1].strip()
        last = name or last
        known.setdefault(last, []).append(line)
    return known


def main():
    made = {s["id"]: list(rows(s)) for s in json.loads(Path(sys.argv[1]).read_text())["scenarios"]}
    if len(sys.argv) < 3:
        print("\n".join(HEAD + [row for group in made.values() for row in group]))
        return
    path = Path(sys.argv[2])
    lines = path.read_text().split("\n")
    first = lines.index(HEAD[0])
    last = first
    while lines[last].startswith("|"):
        last += 1
    table = groups(lines[first + 2:last])
    table.update(made)
    path.write_text("\n".join(lines[:first] + HEAD + [row for group in table.values() for row in group] + lines[last:]))


main()
