#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Published builders against the reference toolkit: worst leaf overhang and processor time, judged by the independent
program.

toolkit_comparison.py JUDGE SPHERETREE TOOLKIT_FOLDER WORK_FOLDER [--builders merge,expand,...] [--meshes
tooth,plate,...] [--json FILE]

TOOLKIT_FOLDER holds NAME.obj and results.csv, the toolkit's own figures. A row fails if the tree reaches out farther
than the toolkit's, takes more than a thirtieth of its processor time and more than FLOOR_S (process start and proof),
leaves surface open or has an empty level. Processor time goes into the table and only into the verdict with --time: it
depends on the machine. Exit 1: a row failed; 77: no judge or no meshes. All rows take about five minutes of one core.
"""
import argparse
import csv
import json
import resource
import subprocess
import sys
from pathlib import Path

FASTER = 30   # times
FLOOR_S = 1   # s: below this nobody waits, and the toolkit's own figure for a 12-triangle mesh is a few tenths

parser = argparse.ArgumentParser()
parser.add_argument("judge")
parser.add_argument("spheretree")
parser.add_argument("toolkit", type=Path)
parser.add_argument("work", type=Path)
parser.add_argument("--builders", default="merge,burst,expand,spawn,grid,combined,hubbard,octree")
parser.add_argument("--meshes", default="tooth,bunny-2000,probe,cube,plate")
parser.add_argument("--json", type=Path)
parser.add_argument("--time", action="store_true", help="processor time counts in the verdict")
parser.add_argument("--quality", default="standard")
options = parser.parse_args()
if not Path(options.judge).is_file() or not (options.toolkit / "results.csv").is_file():
    sys.exit(77)
options.work.mkdir(parents=True, exist_ok=True)


def run(*command):
    """Output and processor seconds."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode:
        raise RuntimeError(f"{' '.join(map(str, command))}: exit {done.returncode}: {done.stderr.strip()}")
    return done.stdout, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def measure(mesh, builder):
    tree, text = options.work / f"{mesh}.{builder}.stree", options.work / f"{mesh}.{builder}.sph"
    obj = options.toolkit / f"{mesh}.obj"
    _, seconds = run(options.spheretree, "build", obj, "-o", tree, "--builder", builder, "--quality", options.quality, "-q")
    run(options.spheretree, "convert", tree, text, "-q")
    verdict = json.loads(run(options.judge, obj, text, "--json", "--no-reference")[0])
    percent = 100 / verdict["mesh"]["diagonal"]
    return seconds, [{"spheres": level["spheres"], "max_pct": level["protrusion"]["outside"]["max"] * percent,
                      "uncovered": level["coverage"]["uncovered_fraction"]} for level in verdict["level"]]


with open(options.toolkit / "results.csv", newline="") as file:
    theirs = {(row["mesh"], row["builder"]): row for row in csv.DictReader(file)}
rows = []
for builder in options.builders.split(","):
    for mesh in options.meshes.split(","):
        toolkit = theirs.get((mesh, builder))
        seconds, levels = measure(mesh, builder)
        row = {"mesh": mesh, "builder": builder, "leaves": levels[-1]["spheres"], "max_pct": [level["max_pct"] for level in levels],
               "processor_s": seconds, "faults": []}
        if toolkit:
            row["toolkit_max_pct"] = float(toolkit["l3_max_pct"])
            row["toolkit_uncovered_pct"] = float(toolkit["l3_uncovered_pct"])
            row["toolkit_processor_s"] = float(toolkit["processor_s"])
            if row["max_pct"][-1] > row["toolkit_max_pct"]:
                row["faults"].append("overhang")
            if options.time and seconds > max(FLOOR_S, row["toolkit_processor_s"] / FASTER):
                row["faults"].append("time")
        if any(level["uncovered"] for level in levels):
            row["faults"].append("uncovered")
        if len(levels) != 4 or any(level["spheres"] == 0 for level in levels):
            row["faults"].append("levels")
        rows.append(row)
        print(f"{builder:9} {mesh:11} {row['leaves']:4} leaves  {row['max_pct'][1]:7.3f} {row['max_pct'][2]:6.3f} {row['max_pct'][-1]:6.3f} % in {seconds:6.2f} s"
              + (f"  (toolkit {row['toolkit_max_pct']:6.3f} %, {row['toolkit_uncovered_pct']:6.3f} % open, in {row['toolkit_processor_s']:6.2f} s)"
                 if toolkit else "") + ("  FAILS: " + ", ".join(row["faults"]) if row["faults"] else ""), flush=True)
if options.json:
    options.json.write_text(json.dumps({"schema": "spheretree.toolkit_comparison/1", "rows": rows}, indent=1) + "\n")
sys.exit(any(row["faults"] for row in rows))
