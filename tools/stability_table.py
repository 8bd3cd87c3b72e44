#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""stability_table.py STABILITY.json [DOC.md]: the table of docs/stability.md from what `haptic-player --scenario all
--out` wrote. stability_table.py --nearest DOC.md [--check]: the last column of the table of failures in the same page,
from the table of figures.

Prints the table, or puts it into the document; scenarios that the file does not have keep their rows there. Bold:
passes. The last column of the table of failures has the figure nearest to its limit, of the constrained mode, on turned
bodies too. With --check, a difference there ends with exit code 1."""
import json
import math
import sys
from pathlib import Path

FAILURES = "| | failure | what our runtime does | shown by, beside the scenario | the figure nearest to its limit |"
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


def block(lines, head):
    """First and last line of the table that begins with `head`, without it."""
    first = lines.index(head) + 2
    last = first
    while lines[last].startswith("|"):
        last += 1
    return first, last


def nearest(table):
    """Of the rows of a scenario: the figure that takes the largest share of its limit, and both. A figure of 0 with the
    limit 0 counts as at its limit."""
    def share(value, limit):
        if limit > 0:
            return value / limit
        return 1 if value <= 0 else math.inf

    found = []
    for row in table:
        quantity, limit, _, *shown = [cell.strip() for cell in row.split(" | ")[1:]]
        values = [cell.strip("*| ") for cell in shown]
        if limit != "*reported*":
            found += [(share(float(value), float(limit)), quantity, value, limit) for value in values if value != "-"]
    if not found:
        return ""
    part, quantity, value, limit = max(found, key=lambda figure: figure[0])
    return f"{quantity}: {value}, {'limit ' if part <= 1 else '**missed**; limit '}{limit}"


def with_nearest(lines):
    """The document with the last column of the table of failures made anew."""
    first, last = block(lines, HEAD[0])
    figures = groups(lines[first:last])
    first, last = block(lines, FAILURES)
    made = [row.rsplit(" | ", 1)[0] + f" | {nearest(figures[row.split('|')[1].strip()])} |" for row in lines[first:last]]
    return lines[:first] + made + lines[last:]


def main():
    if sys.argv[1] == "--nearest":
        path = Path(sys.argv[2])
        text = path.read_text()
        made = "\n".join(with_nearest(text.split("\n")))
        if "--check" in sys.argv[3:]:
            sys.exit(f"{path}: the table of failures has other figures than the table of scenarios: run {sys.argv[0]} --nearest {path}"
                     if made != text else 0)
        path.write_text(made)
        return
    made = {s["id"]: list(rows(s)) for s in json.loads(Path(sys.argv[1]).read_text())["scenarios"]}
    if len(sys.argv) < 3:
        print("\n".join(HEAD + [row for group in made.values() for row in group]))
        return
    path = Path(sys.argv[2])
    lines = path.read_text().split("\n")
    first, last = block(lines, HEAD[0])
    table = groups(lines[first:last])
    table.update(made)
    path.write_text("\n".join(with_nearest(lines[:first] + [row for group in table.values() for row in group] + lines[last:])))


main()
