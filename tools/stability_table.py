#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""stability_table.py STABILITY.json [DOC.md]: the table of docs/stability.md from what `haptic-player --scenario all --out` wrote.

Prints it, or puts it into the document in place of the one that is there. Bold: passes."""
import json
import sys
from pathlib import Path

HEAD = ["| | quantity | passes at | paper | constrained |", "|---|---|---|---|---|"]


def number(value):
    if value is None:
        return "-"
    if abs(value) < 1e-12:
        return "0"
    digits = f"{value:.2g}"
    return digits if "e-" in digits or abs(value) < 100 else f"{value:.0f}"


def rows(data):
    for scenario in data["scenarios"]:
        for i, figure in enumerate(scenario["figures"]):
            reported = figure.get("reported", False) or figure["verdict"] == "reported"

            def shown(mode, verdict):
                text = number(figure["results"].get(mode))
                return f"**{text}**" if not reported and verdict == "holds" else text

            unit = "" if figure["unit"] == "1" else f" [{figure['unit']}]"
            name = scenario["id"] if i == 0 else ""
            passes = "*reported*" if reported else f"{figure['pass']:g}"
            yield (f"| {name} | {figure['quantity']}{unit} | {passes} | {shown('paper', figure['paper_verdict'])} | "
                   f"{shown('constrained', figure['verdict'])} |")


def main():
    table = HEAD + list(rows(json.loads(Path(sys.argv[1]).read_text())))
    if len(sys.argv) < 3:
        print("\n".join(table))
        return
    path = Path(sys.argv[2])
    lines = path.read_text().split("\n")
    first = lines.index(HEAD[0])
    last = first
    while lines[last].startswith("|"):
        last += 1
    path.write_text("\n".join(lines[:first] + table + lines[last:]))


main()
