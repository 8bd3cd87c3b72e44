#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""measure.py BUILD: appends a row to history.csv: figures of the commit that BUILD was made from, on this machine.

Compare rows of one machine only, taken while nothing else runs. Build times are processor time of one thread; times of
a step and of loading are those that the benchmark programs print."""
import csv
import json
import platform
import re
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

COLUMNS = ["commit", "date", "processor", "cores", "kernel", "compiler", "build_quick_s", "build_standard_s", "leaf_overhang_mm",
           "load_33_trees_ms", "step_median_us", "step_p999_us"]
build = Path(sys.argv[1])
root = Path(__file__).resolve().parents[1]


def output(*command):
    return subprocess.run([str(word) for word in command], check=True, capture_output=True, text=True, cwd=root).stdout


def processor():
    names = re.findall(r"model name\s*:\s*(.*)", Path("/proc/cpuinfo").read_text(encoding="utf-8"))
    return (names[0] if names else platform.machine()), len(names)


def build_molar(folder, quality):
    """Processor time of a build on one thread, the least of three, and the bound of the leaves' overhang."""
    times = []
    for _ in range(3):
        before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        output(build / "tools/spheretree/spheretree", "build", folder / "molar.obj", "-o", folder / "molar.stree", "--quality", quality,
               "--threads", "1", "-q", "--report", folder / "report.json")
        times.append(resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before)
    report = json.loads((folder / "report.json").read_text())
    return min(times), report["levels"][-1]["overhang_bound_mm"]


def steps():
    """Of all cases, the slowest: median and 99.9th percentile of a servo step."""
    rows = [re.findall(r"[\d.]+", line.split("|")[1]) for line in output(build / "tests/step_benchmark", "2000").splitlines() if line.count("|") == 2]
    figures = [[float(value) for value in row] for row in rows if len(row) == 4]
    return max(row[0] for row in figures), max(row[2] for row in figures)


row = dict.fromkeys(COLUMNS, "")
row["commit"] = output("git", "rev-parse", "--short=12", "HEAD").strip() + ("+" if output("git", "status", "--porcelain", "-uno") else "")
row["date"] = output("git", "log", "-1", "--format=%cs").strip()
row["processor"], row["cores"] = processor()
row["kernel"] = platform.release()
row["compiler"] = output("c++", "--version").splitlines()[0]
with tempfile.TemporaryDirectory() as name:
    folder = Path(name)
    output(build / "samples/make_samples/make_samples", folder)
    quick, _ = build_molar(folder, "quick")
    standard, overhang = build_molar(folder, "standard")
row["build_quick_s"], row["build_standard_s"], row["leaf_overhang_mm"] = f"{quick:.2f}", f"{standard:.2f}", f"{overhang:.5f}"
row["load_33_trees_ms"] = re.search(r"^all\s+median +([\d.]+) ms", output(build / "tests/load_benchmark"), re.MULTILINE).group(1)
median, tail = steps()
row["step_median_us"], row["step_p999_us"] = f"{median:.1f}", f"{tail:.1f}"

history = root / "benchmarks/history.csv"
is_new = not history.exists()
with history.open("a", newline="", encoding="utf-8") as file:
    writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
    if is_new:
        writer.writeheader()
    writer.writerow(row)
print(", ".join(f"{key} {value}" for key, value in row.items()))
