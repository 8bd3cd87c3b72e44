#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""tolerance_figures.py SPHERETREE MESH_OR_FOLDER... [--leaves N] [--seeds 10] [--quality standard] [--repeat 1] [--json
FILE]

What a tolerance costs. For each mesh the tolerance is the proven bound of a build with N leaves (150) and seed 1.
Prints
  time    processor time of `--tolerance` over that of `--leaves` with the number of leaves that the tolerance gave,
  leaves  leaves of `--tolerance` over the fewest `--leaves` that keep the tolerance with any of the seeds,
and the geometric mean of both over all meshes. A mesh that cannot be built is named and left out. Exit code 1: a
tolerance was not kept, or none of the meshes could be built. Times are of all threads, least of `--repeat` runs; take
them on an idle machine. """
import argparse
import json
import math
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

MESH_ENDINGS = {".obj", ".stl", ".ply", ".off", ".gltf", ".glb"}
NOT_MET = 5  # exit code of a build whose tolerance needs more leaves than the levels allow


class Refused(Exception):
    pass


class Builder:
    def __init__(self, program, quality, folder):
        self.program, self.quality, self.folder = program, quality, Path(folder)

    def build(self, mesh, *options, repeat=1):
        """Leaves, proven bound of their overhang [mm] and processor time [s]."""
        seconds = math.inf
        report = self.folder / "report.json"
        for _ in range(repeat):
            before = resource.getrusage(resource.RUSAGE_CHILDREN)
            run = subprocess.run([self.program, "build", mesh, "-o", self.folder / "tree.stree", "--report", report, "-q", "--quality",
                                  self.quality, *map(str, options)], capture_output=True, text=True)
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
            if run.returncode not in (0, NOT_MET):
                raise Refused(run.stderr.strip().splitlines()[-1] if run.stderr.strip() else f"exit code {run.returncode}")
            seconds = min(seconds, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
        leaves = json.loads(report.read_text(encoding="utf-8"))["levels"][-1]
        return leaves["spheres"], leaves["overhang_bound_mm"], seconds


def keeps(builder, mesh, count, tolerance, seeds):
    return any(builder.build(mesh, "--leaves", count, "--seed", seed)[1] <= tolerance for seed in range(1, seeds + 1))


def fewest_leaves(builder, mesh, tolerance, start, seeds):
    """The fewest leaves that keep the tolerance. Whether N do is a matter of luck near the limit: two numbers in a row
    must fail."""
    count = start
    while not keeps(builder, mesh, count, tolerance, seeds):
        count += max(1, count // 100)
    found = count
    while count > 1 and found - count < 2:
        count -= 1
        if keeps(builder, mesh, count, tolerance, seeds):
            found = count
    return found


def mean(ratios):
    return math.exp(sum(map(math.log, ratios)) / len(ratios)) if ratios else math.nan


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("meshes", nargs="+", type=Path)
    parser.add_argument("--leaves", type=int, default=150, help="of the build whose bound is the tolerance")
    parser.add_argument("--seeds", type=int, default=10, help="of the search for the fewest leaves; 0: only times")
    parser.add_argument("--quality", default="standard", choices=["quick", "standard", "best"])
    parser.add_argument("--repeat", type=int, default=1)
    parser.add_argument("--json", type=Path, help="also write the rows there")
    args = parser.parse_args()
    files = [file for path in args.meshes for file in (sorted(path.iterdir()) if path.is_dir() else [path]) if file.suffix.lower() in MESH_ENDINGS]
    rows, kept = [], True
    print(f"{'mesh':32} {'tolerance':>10} {'leaves':>6} {'fewest':>6} {'ratio':>6} {'seconds':>8} {'of N':>8} {'ratio':>6}")
    with tempfile.TemporaryDirectory() as folder:
        builder = Builder(args.program, args.quality, folder)
        for file in files:
            try:
                tolerance = builder.build(file, "--leaves", args.leaves)[1]
                leaves, bound, seconds = builder.build(file, "--tolerance", repr(tolerance), repeat=args.repeat)
                seconds_of_leaves = builder.build(file, "--leaves", leaves, repeat=args.repeat)[2]
                fewest = fewest_leaves(builder, file, tolerance, leaves, args.seeds) if args.seeds else math.nan
            except Refused as why:
                print(f"{file.name:32} left out: {why}")
                continue
            kept = kept and bound <= tolerance
            rows.append({"mesh": file.name, "tolerance_mm": tolerance, "bound_mm": bound, "leaves": leaves, "fewest_leaves": fewest,
                         "seconds": seconds, "seconds_of_leaves": seconds_of_leaves})
            print(f"{file.name:32} {tolerance:10.4g} {leaves:6} {fewest:6} {leaves / fewest:6.3f} {seconds:8.2f} {seconds_of_leaves:8.2f} "
                  f"{seconds / seconds_of_leaves:6.2f}", flush=True)
    print(f"geometric mean of {len(rows)}: leaves {mean([r['leaves'] / r['fewest_leaves'] for r in rows]):.3f}, "
          f"time {mean([r['seconds'] / r['seconds_of_leaves'] for r in rows]):.2f}")
    if args.json:
        args.json.write_text(json.dumps(rows, indent=1), encoding="utf-8")
    sys.exit(0 if rows and kept else 1)


main()
