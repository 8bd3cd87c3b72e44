#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""large_meshes.py BUILD [TRIANGLES [KIND...]]: builds trees of six kinds of large meshes, as scanners, CT and CAD make
them, and prints a table of times, memory and bounds.

Each is built at standard quality with 512 leaves and a skin, from a binary STL file, with one thread and with two. Both
trees must have the same bytes. On a machine that does other work, too, compare processor times only."""
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

KINDS = {"flat": "tooth, each triangle divided, flat", "smooth": "tooth, divided and smooth", "scan": "tooth, marching cubes of voxels",
         "cad": "turned part, slivers of 1:1000", "noise": "tooth, divided, noise of 0.02 mm", "bodies": "separate bodies of 800 triangles"}
build = Path(sys.argv[1]).resolve()
triangles = sys.argv[2] if len(sys.argv) > 2 else "1000000"
chosen = sys.argv[3:] or list(KINDS)


def built(mesh, tree, threads):
    """Seconds, seconds of processor time, peak memory [GB]."""
    begun = time.monotonic()
    child = subprocess.Popen([build / "tools/spheretree/spheretree", "build", mesh, "-o", tree, "--report", tree.with_suffix(".json"),
                              "--leaves", "512", "--threads", str(threads), "-q"])
    _, status, used = os.wait4(child.pid, 0)
    if status:
        sys.exit(f"large_meshes: the build of {mesh.name} failed")
    return time.monotonic() - begun, used.ru_utime + used.ru_stime, used.ru_maxrss / 1e6


print("| mesh | triangles | one thread: processor, wall | two threads: processor, wall | memory | leaves: overhang [mm] | skin: triangles, distance [mm] |")
print("|---|---|---|---|---|---|---|")
with tempfile.TemporaryDirectory() as name:
    folder = Path(name)
    for kind in chosen:
        mesh = folder / f"{kind}.stl"
        subprocess.run([build / "tests/large_mesh", kind, triangles, mesh], check=True, stdout=subprocess.DEVNULL)
        one, two = folder / "one.stree", folder / "two.stree"
        alone, alone_processor, _ = built(mesh, one, 1)
        together, processor, memory = built(mesh, two, 2)
        if one.read_bytes() != two.read_bytes():
            sys.exit(f"large_meshes: {kind}: one and two threads make different trees")
        report = json.loads(two.with_suffix(".json").read_text())
        skin = report["skin"] or {"triangles": 0, "mesh_distance_mm": 0}
        print(f"| {KINDS[kind]} | {report['mesh']['triangles']:,} | {alone_processor:.1f} s, {alone:.1f} s | "
              f"{processor:.1f} s, {together:.1f} s | {memory:.2f} GB | "
              f"{report['levels'][-1]['overhang_bound_mm']:.3f} | {skin['triangles']:,}, {skin['mesh_distance_mm']:.2g} |", flush=True)
        mesh.unlink()
