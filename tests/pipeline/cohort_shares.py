#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""cohort_shares.py PROGRAM: shards of `batch --cohort` share many patients of very different sizes. Every patient is in
one log, the bytes are those of one run, and the work that was done is shared evenly. With SPHERETREE_LONG=1: 1,000
patients, 8 shards."""
import filecmp
import json
import os
import random
import subprocess
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))
from torus import write_torus  # noqa: E402

IS_LONG = os.environ.get("SPHERETREE_LONG") == "1"
PATIENTS, SHARDS = (1000, 8) if IS_LONG else (8, 2)


def cohort(folder):
    """Patients of 1 to 4 objects of 72 to 800 triangles, each with a tool of its own: none shares a tree with
    another."""
    chance, lines = random.Random(1), []
    for p in range(PATIENTS):
        patient = folder / f"P{p:04}"
        patient.mkdir()
        write_torus(patient / "tool.obj", 6 + 0.001 * p, 6)
        objects = []
        for k in range(chance.randint(1, 4)):
            write_torus(patient / f"r{k}.obj", 10 + 0.001 * p + 0.1 * k, chance.randint(6, 20))
            objects.append({"name": f"r{k}", "mesh": f"r{k}.obj"})
        scene = {"schema": "spheretree.scene/1", "defaults": {"quality": "quick", "levels": 2, "branching": 2},
                 "tool": {"name": "tool", "mesh": "tool.obj"}, "objects": objects}
        (patient / "s.scene.json").write_text(json.dumps(scene), encoding="utf-8")
        lines.append(json.dumps({"patient": patient.name, "scene": f"{patient.name}/s.scene.json"}))
    (folder / "list.jsonl").write_text("\n".join(lines) + "\n", encoding="utf-8")


def main():
    """Shards one after another, then one run, and compares."""
    program = str(Path(sys.argv[1]).resolve())
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        cohort(folder)
        line = [program, "batch", "--cohort", "list.jsonl", "--threads", "1", "-q", "-o"]
        done, seconds, patients = [], [], []
        for i in range(1, SHARDS + 1):
            subprocess.run([*line, "out", "--shard", f"{i}/{SHARDS}"], cwd=folder, check=True, capture_output=True)
            log = [json.loads(text) for text in (folder / "out" / f"cohort.{i}-of-{SHARDS}.jsonl").read_text(encoding="utf-8").splitlines()]
            patients += [entry["patient"] for entry in log]
            done.append(sum(entry["built"] for entry in log))
            seconds.append(sum(entry["seconds"] for entry in log))
        subprocess.run([*line, "whole"], cwd=folder, check=True, capture_output=True)
        trees = sorted(path.relative_to(folder / "whole") for path in (folder / "whole").glob("P*/*.stree"))
        differ = [str(tree) for tree in trees if not filecmp.cmp(folder / "whole" / tree, folder / "out" / tree, False)]
        balance = sum(done) / (SHARDS * max(done))
        print(f"{len(patients)} patients, {len(trees)} trees; trees of each shard: {done}, {balance:.3f} of perfect balance; "
              f"seconds: {[round(s, 1) for s in seconds]}, {sum(seconds) / (SHARDS * max(seconds)):.3f}; differ: {differ}")
        is_whole = sorted(patients) == [f"P{p:04}" for p in range(PATIENTS)]
        return 0 if is_whole and trees and not differ and balance >= 0.9 else 1


if __name__ == "__main__":
    sys.exit(main())
