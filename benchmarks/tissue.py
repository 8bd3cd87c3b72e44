#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""tissue.py BUILD [--long] [--share S]... MESH...: prints the tables of figures of docs/tissue.md.

MESH: a file, or FILE:PART for one of its parts; held in the lower quarter of its height. --share: of `build --soft`,
0.5 unless given. --long: 10,000 states of 100,000 samples for every mesh, rather than 200 of 2,000; that takes hours.
Times are processor time of one thread."""
import argparse
import csv
import json
import math
import re
import subprocess
import tempfile
from pathlib import Path


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=Path)
    parser.add_argument("meshes", nargs="*")
    parser.add_argument("--long", action="store_true")
    parser.add_argument("--share", action="append", type=float)
    parser.add_argument("--levels", type=int, default=5)
    return parser.parse_args()


def output(*command):
    return subprocess.run([str(word) for word in command], check=True, capture_output=True, text=True).stdout


class Object:
    """A mesh with its soft tree."""

    def __init__(self, options, name, share, folder):
        self.spheretree = options.build / "tools/spheretree/spheretree"
        self.path, part = re.fullmatch(r"(.*?\.\w+)(?::(.*))?", name).groups()
        self.parts = ["--parts", part] if part else []
        self.name, self.share, self.folder = part or Path(self.path).name, share, folder
        tree, self.soft = folder / "object.stree", folder / "object.soft"
        output(self.spheretree, "build", self.path, *self.parts, "-o", tree, "--soft", share, "--levels", options.levels, "-q")
        self.leaves = self.leaves_of(tree)
        low = [min(leaf[axis] - leaf["radius"] for leaf in self.leaves) for axis in "xyz"]
        high = [max(leaf[axis] + leaf["radius"] for leaf in self.leaves) for axis in "xyz"]
        held = [*low, high[0], high[1], low[2] + 0.25 * (high[2] - low[2])]
        box = "box:" + ",".join(f"{value:.6g}" for value in held)
        output(self.spheretree, "soften", self.path, *self.parts, tree, "-o", self.soft, "--young", "15", "--fix", box)

    def leaves_of(self, tree):
        listed = self.folder / "leaves.csv"
        output(self.spheretree, "convert", tree, listed)
        with listed.open(encoding="utf-8") as file:
            return [{key.removesuffix("_mm"): float(value) for key, value in leaf.items()} for leaf in csv.DictReader(file)]

    def states(self, count, samples):
        return json.loads(output(self.spheretree, "evaluate", self.path, self.soft, *self.parts, "--states", count, "--samples", samples, "--json"))

    def rigid_leaves(self, overhang):
        """Of a rigid tree that reaches out by no more."""
        tree = self.folder / "rigid.stree"
        output(self.spheretree, "build", self.path, *self.parts, "-o", tree, "--levels", "5", "--tolerance", overhang, "-q")
        return len(self.leaves_of(tree))


def overhangs(options):
    print("| object | share | leaves | over those of a rigid tree of that overhang | overhang at rest [mm] | squeeze 20 % | 30 % | bend 60 degrees | states x samples | uncovered |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    count, samples = (10_000, 100_000) if options.long else (200, 2_000)
    for name in options.meshes:
        for share in options.share or [0.5]:
            with tempfile.TemporaryDirectory() as folder:
                body = Object(options, name, share, Path(folder))
                found = body.states(count, samples)
                rest = found["rest_overhang_mm"]

                def worst(kind, amount):
                    values = [s["overhang_mm"] for s in found["states"] if s["kind"] == kind and s["amount"] <= amount * 1.0001 and s["overhang_mm"]]
                    return max(values) / rest

                rigid = body.rigid_leaves(rest)
                bare = sum(s["bare_samples"] for s in found["states"])
                print(f'| {body.name} | {share} | {len(body.leaves)} | {len(body.leaves) / rigid:.1f} | {rest:.3f} | '
                      f'{worst("squeeze", 0.2):.2f} | {worst("squeeze", 0.3):.2f} | {worst("bend", math.pi / 3):.2f} | {count} x {samples} | {bare} |',
                      flush=True)


def others(options):
    f = json.loads(output(options.build / "tests/tissue_benchmark"))
    reference = f["reference_force_n"]
    rows = [
        ("ball of 8 mm, 5 mm deep in a block: force of a player's tissue over the reference", f'{f["felt_force_n"]:.3f} / {reference:.3f} N'),
        ("the same, solver alone, with the nodes of the player's", f'{f["faces_force_n"]:.3f} / {reference:.3f} N'),
        ("the same, multipliers at the nodes alone: with the player's nodes, with those of the reference",
         f'{f["nodes_force_n"]:.3f}, {f["nodes_reference_force_n"]:.3f} N'),
        ("volume of the block then, player's tissue and reference", f'{f["felt_volume"]:.4f}, {f["reference_volume"]:.4f}'),
        (f'refit of {f["leaves"]} leaves: median, p99', f'{f["refit"]["median_us"]:.0f}, {f["refit"]["p99_us"]:.0f} us'),
        ("step in free space, tissue at rest: median, p99", f'{f["step_free_at_rest"]["median_us"]:.1f}, {f["step_free_at_rest"]["p99_us"]:.1f} us'),
        ("the same, its surface on its way: median, p99", f'{f["step_free_on_the_way"]["median_us"]:.1f}, {f["step_free_on_the_way"]["p99_us"]:.1f} us'),
        *((what, f'{f[key]["median_us"]:.0f}, {f[key]["p99_us"]:.0f}, {f[key]["p999_us"]:.0f} us')
          for what, key in (("step in contact with tissue: median, p99, p99.9", "step_in_contact"), ("the same, friction 0.3", "step_with_friction"))),
    ]
    rows += [(f'a state of {s["nodes"]} nodes, {s["tetrahedra"]} tetrahedra', f'{s["median_ms"]:.1f} ms ({1000 / s["median_ms"]:.0f} Hz)') for s in f["states"]]
    print("\n| what | found |\n|---|---|")
    for what, found in rows:
        print(f"| {what} | {found} |")


options = arguments()
if options.meshes:
    overhangs(options)
others(options)
