#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""other_machine.py BUILD OTHER EMULATOR...: the programs in OTHER, made for another machine, give the results of BUILD.

1. The golden trees, read and written there, keep their bytes.
2. Replayed runs, on two samples, along the paths of the sample mouth and of the sample cavity, where a burr cuts (their
   trees are kept in BUILD/sample_mouth and BUILD/sample_cavity): the same bytes, or poses, wrenches and volumes that
   differ by less than 1e-9 mm, N and mm^3. Left out are times, and the counts of what a step looked at.
3. A program in C that loads the shared library prints the same."""
import csv
import json
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

build, other, emulator = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve(), sys.argv[3:]
player = [build / "tools/haptic_player/haptic-player"]
LARGEST = 1e-9  # [mm, N, N mm, mm^3, 1]
STEPPED = ["--clock", "stepped", "--quiet", "--record"]
WHOLE = {"tick", "active", "faults", "spin"}
# What a step looked at to find its result: where a distance is at a limit, its last bit decides.
LOOKED_AT = {"pairs", "rows", "qp_iterations"}

def program(name):
    """The command that runs a program of the other machine."""
    return [*emulator, next(path for path in (other / name, other / f"{name}.exe") if path.exists())]


def run(command, folder):
    done = subprocess.run([str(word) for word in command], cwd=folder, capture_output=True, check=False)
    if done.returncode != 0:
        sys.exit(f"other_machine: {' '.join(map(str, command))}: exit code {done.returncode}: {done.stderr.decode(errors='replace')}")
    return done.stdout.replace(b"\r\n", b"\n")


def check_trees(folder):
    (folder / "copies").mkdir()
    run([*program("tests/copy_trees"), ".", "copies"], folder)
    trees = sorted(path.name for path in folder.glob("*.stree"))
    faults = [name for name in trees if (folder / name).read_bytes() != (folder / "copies" / name).read_bytes()]
    print(f"other_machine: {len(trees)} golden trees, {len(trees) - len(faults)} with the same bytes")
    return faults


def rows(path):
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def compare(here, there):
    """What differs by too much; the largest difference; the number of steps that differ."""
    faults = [] if len(here) == len(there) else [f"{len(there)} rows, not {len(here)}"]
    largest, steps = 0.0, 0
    for a, b in zip(here, there):
        differing = [key for key in a if not key.endswith("_us") and a[key] != b[key]]
        steps += bool(differing)
        for key in set(differing) - LOOKED_AT:
            try:
                difference = float("inf") if key in WHOLE else abs(float(a[key]) - float(b[key]))
            except ValueError:
                difference = float("inf")
            largest = max(largest, difference)
            if not difference < LARGEST:
                faults.append(f"tick {a['tick']}: {key} {b[key]}, not {a[key]}")
    return faults, largest, steps


def check_run(folder, name, scene, path, *options):
    recordings = []
    for machine, command in (("here", player), ("there", program("tools/haptic_player/haptic-player"))):
        recording = folder / f"{machine}.csv"
        run([*command, scene, *STEPPED, recording.name, "--trajectory", path, *options], folder)
        recordings.append(rows(recording))
    faults, largest, steps = compare(*recordings)
    touching = sum(row["active"] != "0" for row in recordings[0])
    cut = recordings[0][-1].get("removed_mm3")
    print(f"other_machine: {name}: {len(recordings[0])} steps, {touching} of them in contact, " +
          (f"{float(cut):.1f} mm^3 cut, " if cut else "") +
          (f"{steps} differ, by at most {largest:.1e}" if steps else "the same bytes"), flush=True)
    if not touching:
        faults.append("no step touches anything")
    return [f"{name}: {fault}" for fault in faults]


def check_samples(folder):
    scene = {"schema": "spheretree.scene/1", "unit": "mm", "tool": {"name": "probe", "tree": "probe quick.stree"},
             "objects": [{"name": "molar", "tree": "molar quick.stree", "friction": 0.2}]}
    (folder / "scene.json").write_text(json.dumps(scene), encoding="utf-8")
    run([*player, "scene.json", *STEPPED, "hand.csv", "--seconds", "5"], folder)
    return check_run(folder, "molar with friction", "scene.json", "hand.csv")


def sample(folder, name):
    """A folder with a copy of a sample and its trees: a recording names its scene, the same for each machine."""
    place = build / f"sample_{name}"
    run([build / "samples/make_samples/make_samples", f"--{name}", place], folder)
    run([build / "tools/spheretree/spheretree", "batch", place / f"{name}.scene.json", "-o", place / "trees", "--quality", "quick"], folder)
    return Path(shutil.copytree(place, folder / name))


def check_mouth(folder):
    mouth, faults = sample(folder, "mouth"), []
    for options in ([], ["--contact", "leaves"], ["--mode", "paper"]):
        for path in ("pocket", "inspection"):
            faults += check_run(mouth, " ".join(["mouth:", path, *options]), "trees/scene.json", f"{path}.csv", *options)
    return faults


def check_cavity(folder):
    return check_run(sample(folder, "cavity"), "cavity", "trees/scene.json", "drill.csv")


def check_library(folder):
    trees = ["probe quick.stree", "molar quick.stree"]
    library = next(path for path in (other / "libruntime/runtime").iterdir() if path.suffix in (".so", ".dll"))
    here = run([build / "samples/02_haptic_step_in_c/haptic_step_in_c", build / "libruntime/runtime/libspheretree_runtime.so", *trees], folder)
    there = run([*program("samples/02_haptic_step_in_c/haptic_step_in_c"), library, *trees], folder)
    print(f"other_machine: {library.name} from C: {len(here.splitlines())} lines, {'the same' if here == there else 'others'}")
    return [] if here == there else [f"the program in C printed\n{there.decode()}, not\n{here.decode()}"]


def main():
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for tool in ("samples/make_samples/make_samples", "tests/write_golden_trees"):
            run([build / tool, folder], folder)
        faults = check_trees(folder) + check_library(folder) + check_samples(folder) + check_mouth(folder) + check_cavity(folder)
    for fault in faults[:20]:
        print(f"other_machine: {fault}")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
