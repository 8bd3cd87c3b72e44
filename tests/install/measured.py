#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""measured.py SOURCE: fails if a document states a measured figure and not where it comes from, or names a test that
does not exist.

Read are README.md, CONTRIBUTING.md and docs/, but for code and the text between `<!-- table: NAME -->` and `<!-- end of
table -->`, which tools/doc_tables.py makes. A sentence is taken to state a measured figure if it has

- a time, a percentage or a number of bytes, and no word that makes it a setting, a limit or a definition (SETTING); or
- a number with any unit, and a word of measurement (MEASURED).

A table is taken to do so if its head has such a word. It has a source if its paragraph (of a table: the one before it,
too) names a test (`Suite.Case`, a file of tests, a benchmark) or a script of tools/ or benchmarks/, or has a link to a
page with figures that are made. A sentence that looks measured and is none is better written another way: it looks
measured to readers, too."""
import fnmatch
import re
import sys
from pathlib import Path

NUMBER = r"(?<![\w.`/-])\d[\d,]*(?:\.\d+)?(?:e-?\d+)?(?:(?:,| to| and| or| /) \d[\d,]*(?:\.\d+)?)* ?"
TIME = r"(?:s|ms|us|ns|seconds?|minutes?|hours?|milliseconds?|microseconds?|MB|MiB|GB|KB|KiB|fps)(?![\w`/])"
SAMPLED = re.compile(NUMBER + rf"(?:{TIME}|%|per cent)")
FIGURE = re.compile(NUMBER + rf"(?:{TIME}|%|per cent|(?:N|mN|mm|mJ|degrees?|times)(?![\w`/]))")
SETTING = re.compile(r"\b(at most|at least|up to|limit\w*|default|definition|above|below|within|targets?|more than|less than|fewer than|deeper|longer than|larger|"
                     r"smaller|nearly|beyond|each|every|fit into|tolerance|over|until|after|for [\d.]+ s)\b", re.IGNORECASE)
MEASURED = re.compile(rf"\b(median|average|geometric mean|p99|percentile|measured|gains?|gave|faster|slower|differ by|in practice)\b|"
                      rf"\b(takes?|took|costs?|saves?) (about |some |from )?{NUMBER}{TIME}|% (less|fewer|higher|lower|farther)\b")
HEAD = re.compile(r"\b(median|p99|measured|mean|times?|seconds|memory|uncovered)\b|\[(us|ms|s)\]|energy")
SOURCE = re.compile(r"`\w+\.[A-Z]\w+[*`]|\w+_(test|benchmark)\b|\btests/[\w/]+|\b(tools|benchmarks)/\w+\.(py|sh)\b|--gtest_filter|\bfeel\.\*")
TEST = re.compile(r"`([A-Z]\w+\.[A-Z*][\w*]*)`")
LINK = re.compile(r"\]\(([^)#\s]*)(#[^)]*)?\)")


def paragraphs(text):
    """Number of the first line of each paragraph, item of a list or table, and its lines; None where text is made."""
    made = fenced = False
    found, start = [], 0
    for number, line in enumerate([*text.split("\n"), ""], 1):
        is_row = line.lstrip().startswith("|")
        is_mark = line.startswith(("<!--", "```"))
        ends = not line.strip() or is_mark or re.match(r"\s*([-*]|\d+\.) |#", line) or found and is_row != found[-1].startswith("|")
        if ends and found:
            yield start, found
            found = []
        made = made and not line.startswith("<!-- end of table") or line.startswith("<!-- table:")
        fenced ^= line.startswith("```")
        if line.strip() and not (made or fenced or is_mark or line.startswith("    ") and not is_row and not found):
            start = start if found else number
            found.append(line.strip())


def sentences(text):
    return re.split(r"(?<=[.:;])\s+(?=[A-Z`*(])", text)


def figure_in(lines):
    """The sentence or head that states a measured figure, or None."""
    if lines[0].startswith("|"):
        return lines[0] if HEAD.search(lines[0]) and any(re.search(r"\d", cell) for row in lines[2:] for cell in row.split("|")[2:]) else None
    for sentence in sentences(" ".join(lines)):
        if SAMPLED.search(sentence) and not SETTING.search(sentence) or FIGURE.search(sentence) and MEASURED.search(sentence):
            return sentence
    return None


def has_source(page, lines):
    text = " ".join(lines)
    targets = [page if not target else page.parent / target for target, _ in LINK.findall(text) if not target.startswith("http")]
    return SOURCE.search(text) or any(target.suffix == ".md" and target.is_file() and "<!-- table:" in target.read_text(encoding="utf-8") for target in targets)


def tests_of(root):
    text = "\n".join(path.read_text(encoding="utf-8") for path in (root / "tests").rglob("*.cpp"))
    return [f"{suite}.{case}" for suite, case in re.findall(r"\bTEST(?:_F|_P)?\(\s*(\w+),\s*(\w+)\)", text)]


def faults_of(root, page, tests):
    text, before = page.read_text(encoding="utf-8"), []
    for name in TEST.findall(text):
        if not fnmatch.filter(tests, name):
            yield f"{page.relative_to(root)}: no test is called {name}"
    for number, lines in paragraphs(text):
        figure = figure_in(lines)
        if figure and not has_source(page, lines if not lines[0].startswith("|") else before + lines):
            yield f"{page.relative_to(root)}:{number}: a measured figure without a test or script that makes it: {figure[:160]}"
        before = lines


def main():
    root = Path(sys.argv[1]).resolve()
    pages = [root / "README.md", root / "CONTRIBUTING.md", *sorted((root / "docs").rglob("*.md"))]
    tests = tests_of(root)
    faults = [fault for page in pages for fault in faults_of(root, page, tests)]
    print("\n".join(faults) if faults else f"measured: {len(pages)} pages, every measured figure has a source")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
