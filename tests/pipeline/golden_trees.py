#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""golden_trees.py BUILD [--update]: the trees of the sample meshes are the bytes of golden_trees.txt.

BUILD is a build folder with make_samples and write_golden_trees. Whatever the compiler, its options and the number of
threads, the bytes must be those that are recorded. A change of bytes is not forbidden, but it has to be meant: --update
records the new ones, and the commit says why."""
import hashlib
import subprocess
import sys
import tempfile
from pathlib import Path

build = Path(sys.argv[1])
record = Path(__file__).with_suffix(".txt")
found = {}
with tempfile.TemporaryDirectory() as name:
    for program in ("samples/make_samples/make_samples", "tests/write_golden_trees"):
        subprocess.run([build / program, name], check=True, stdout=subprocess.DEVNULL)
    for path in sorted(Path(name).glob("[a-z]*")):
        found[path.name.removesuffix(".stree")] = hashlib.sha256(path.read_bytes()).hexdigest()
for case in [case for case in found if case.endswith(", two threads")]:
    one, two = found[case.removesuffix(", two threads")], found.pop(case)
    if one != two:
        sys.exit(f"golden_trees: {case}: {two}; on one thread: {one}")

if "--update" in sys.argv[2:]:
    record.write_text("".join(f"{value}  {case}\n" for case, value in found.items()), encoding="utf-8")
golden = {line[66:]: line[:64] for line in record.read_text(encoding="utf-8").splitlines()}
faults = [f"{case}: {found.get(case, 'not built')}, recorded: {golden.get(case, 'none')}"
          for case in sorted(found.keys() | golden.keys()) if found.get(case) != golden.get(case)]
for fault in faults:
    print(f"golden_trees: {fault}")
print(f"golden_trees: {len(found)} files, {len(found) - len(faults)} as recorded")
sys.exit(1 if faults else 0)
