#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""tissue_meshes.py BUILD MESH...: fills every object with tetrahedra by `spheretree soften` and prints a table: how
many there are, or the reason why there are none. MESH: a file, or FILE:PART for one of its parts; `mouth` stands for
every object of the sample mouth.

Every object is held in ten slabs that leave gaps of a tenth, so that each of its parts is. Exit code 1 if an object
gives neither tetrahedra nor a reason."""
import csv
import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path

SLABS = 10


def run(*command):
    return subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False)


def mouth(build, folder):
    """The objects of the sample mouth."""
    run(build / "samples/make_samples/make_samples", "--mouth", folder)
    scene = json.loads((folder / "mouth.scene.json").read_text(encoding="utf-8"))
    objects = [scene["tool"], *scene["objects"]]
    return [f'{folder / entry["mesh"]}:{entry["part"]}' if "part" in entry else str(folder / entry["mesh"]) for entry in objects]


def reason(result):
    """The sentence on standard error, without the names of program and file."""
    lines = [line for line in result.stderr.splitlines() if line.startswith("spheretree")]
    text = lines[-1] if lines else ""
    return re.sub(r"^spheretree[^:]*: (?:\S+: )?", "", text)


def box_of(path):
    """Of the leaves, as `convert` lists them: lower and upper corner."""
    with path.open(encoding="utf-8") as file:
        leaves = [{key.removesuffix("_mm"): float(value) for key, value in leaf.items()} for leaf in csv.DictReader(file)]
    return [min(leaf[axis] - leaf["radius"] for leaf in leaves) for axis in "xyz"], [max(leaf[axis] + leaf["radius"] for leaf in leaves) for axis in "xyz"]


def row(build, name, folder):
    """Of the table, and whether there are tetrahedra or a reason why not."""
    path, part = re.fullmatch(r"(.*?\.\w+)(?::(.*))?", name).groups()
    parts = ["--parts", part] if part else []
    tree, soft = folder / "object.stree", folder / "object.soft"
    spheretree = build / "tools/spheretree/spheretree"
    shown = part or Path(path).name
    made = run(spheretree, "build", path, *parts, "-o", tree, "--soft", "0.5", "--levels", "3", "--quality", "quick", "-q")
    if made.returncode not in (0, 5):
        return f"| {shown} | - | - | {reason(made)} |", made.returncode == 4 and reason(made) != ""
    run(spheretree, "convert", tree, folder / "object.csv")
    low, high = box_of(folder / "object.csv")
    height, held = (high[2] - low[2]) / SLABS, []
    for slab in range(SLABS):
        bottom = low[2] + slab * height
        held += ["--fix", "box:" + ",".join(f"{v:.6g}" for v in [low[0], low[1], bottom, high[0], high[1], bottom + 0.9 * height])]
    result = run(spheretree, "soften", path, *parts, tree, "-o", soft, "--young", "15", "--tets", "1000", "--json", *held)
    if result.returncode != 0:
        return f"| {shown} | - | - | {reason(result)} |", result.returncode == 4 and reason(result) != ""
    figures = json.loads(result.stdout)
    return f'| {shown} | {figures["tetrahedra"]} | {figures["boundary_distance_mm"]:.2g} | |', True


def main():
    build, names = Path(sys.argv[1]), []
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        for name in sys.argv[2:]:
            names += mouth(build, folder / "mouth") if name == "mouth" else [name]
        print("| object | tetrahedra | surface within [mm] | why there are none |\n|---|---|---|---|")
        is_whole = True
        for name in names:
            line, has_answer = row(build, name, folder)
            is_whole = is_whole and has_answer
            print(line if has_answer else line + " **no reason**", flush=True)
    return 0 if is_whole else 1


sys.exit(main())
