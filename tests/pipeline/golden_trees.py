#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""golden_trees.py SPHERETREE MAKE_SAMPLES [--update]: the trees of the sample meshes are the bytes of golden_trees.txt.

Each tree is built on one and on two threads; whatever the compiler and its options, the bytes must be those that are
recorded. A change of bytes is not forbidden, but it has to be meant: --update records the new ones, and the commit says
why. """
import hashlib
import subprocess
import sys
import tempfile
from pathlib import Path

program, make_samples = sys.argv[1:3]
update = "--update" in sys.argv[3:]
record = Path(__file__).with_suffix(".txt")

PUBLISHED = ["combined", "merge", "burst", "expand", "spawn", "grid", "hubbard", "octree"]
CASES = {"molar quick": "--quality quick", "molar standard, 3 levels": "--levels 3", "molar, 0.3 mm": "--tolerance 0.3 --quality quick",
         "probe quick": "--quality quick", "probe wrapped": "--quality quick --levels 3 --repair wrap"}
CASES |= {f"probe {builder}": f"--builder {builder} --quality quick --levels 3" for builder in PUBLISHED}
CASES["probe merge, search"] = "--builder merge --search --quality quick --levels 3"


def hash_of(path):
    return hashlib.sha256(path.read_bytes()).hexdigest()


found = {}
with tempfile.TemporaryDirectory() as name:
    folder = Path(name)
    subprocess.run([make_samples, folder], check=True, stdout=subprocess.DEVNULL)
    for mesh in ("molar", "probe"):
        found[f"{mesh}.obj"] = hash_of(folder / f"{mesh}.obj")
    for case, options in CASES.items():
        mesh = case.split()[0].rstrip(",")
        hashes = set()
        for threads in ("1", "2"):
            tree = folder / f"{threads}.stree"
            subprocess.run([program, "build", folder / f"{mesh}.obj", "-o", tree, "-q", "--threads", threads, *options.split()],
                           check=True, stdout=subprocess.DEVNULL)
            hashes.add(hash_of(tree))
        found[case] = " or ".join(sorted(hashes))
        if case == "molar quick":
            picture = folder / "molar.png"
            subprocess.run([program, "convert", tree, picture, "--mesh", folder / "molar.obj", "--width", "300"], check=True)
            found["molar quick, picture"] = hash_of(picture)
        if len(hashes) > 1:
            sys.exit(f"golden_trees: {case}: one thread and two threads give different bytes")

if update:
    record.write_text("".join(f"{value}  {case}\n" for case, value in found.items()), encoding="utf-8")
golden = {line[66:]: line[:64] for line in record.read_text(encoding="utf-8").splitlines()}
faults = [f"{case}: {found.get(case, 'not built')}, recorded: {golden.get(case, 'none')}"
          for case in sorted(found.keys() | golden.keys()) if found.get(case) != golden.get(case)]
for fault in faults:
    print(f"golden_trees: {fault}")
print(f"golden_trees: {len(found)} files, {len(found) - len(faults)} as recorded")
sys.exit(1 if faults else 0)
