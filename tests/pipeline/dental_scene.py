# SPDX-License-Identifier: Apache-2.0
"""A whole mouth of meshes as they come: 32 teeth in the groups of one file, gums with tongue, head with neck, the last
two open. One scene file, one command: every object is built and certified, the open ones after repair, and the player
plays the result.

Two teeth and both open meshes, coarse; with SPHERETREE_LONG=1 all 34 with 512 leaves each. Exit code 77, skipped: the
meshes are not there. Usage: dental_scene.py PROGRAM MAKE_SAMPLES PLAYER MESHES FOLDER"""
import json
import os
import pathlib
import shutil
import subprocess
import sys
import time

program, make_samples, player = sys.argv[1:4]
meshes, folder = pathlib.Path(sys.argv[4]) / "dental", pathlib.Path(sys.argv[5])
if not (meshes / "full_dentition_32.obj").exists():
    print(f"skipped: no meshes in {meshes}")
    sys.exit(77)
long = bool(os.environ.get("SPHERETREE_LONG"))

shutil.rmtree(folder, ignore_errors=True)
folder.mkdir(parents=True)
subprocess.run([make_samples, "--mouth", folder / "mouth"], check=True, stdout=subprocess.DEVNULL)
groups = [line.split()[1] for line in (meshes / "full_dentition_32.obj").read_text().splitlines() if line.startswith(("g ", "o "))]
assert len(set(groups)) == 32, groups
objects = [{"name": group, "mesh": str(meshes / "full_dentition_32.obj"), "part": group} for group in (groups if long else groups[:2])]
objects += [{"name": "gums_and_tongue", "mesh": str(meshes / "gums_and_tongue_open.obj")},
            {"name": "head_neck", "mesh": str(meshes / "head_neck_open.ply")}]
defaults = {"quality": "quick"} if long else {"quality": "quick", "levels": 3}
scene = folder / "dental.scene.json"
scene.write_text(json.dumps({"schema": "spheretree.scene/1", "defaults": defaults, "objects": objects,
                             "tool": {"name": "probe", "mesh": str(folder / "mouth" / "probe.obj")}}))

begun = time.monotonic()
subprocess.run([program, "batch", scene, "-o", folder / "compiled", "--progress", "none"], check=True)
seconds = time.monotonic() - begun
report = json.loads((folder / "compiled" / "report.json").read_text())
assert [o["name"] for o in report["objects"]] == ["probe"] + [o["name"] for o in objects]
for built in report["objects"]:
    assert built["status"] == "built" and built["certified"], built["name"]
    for level in built["levels"]:
        assert level["overhang_mm"]["bound"] >= level["overhang_mm"]["max"], built["name"]
for name in ("gums_and_tongue", "head_neck"):
    assert next(o for o in report["objects"] if o["name"] == name)["repair"], f"{name} is open, and yet nothing was repaired"

run = json.loads(subprocess.run([player, folder / "compiled" / "scene.json", "--device", "simulated", "--seconds", "3", "--clock", "stepped", "--json"],
                                check=True, capture_output=True, text=True).stdout)
assert run["steps"] == 3000 and run["end"] == "complete", run
assert run["largest_penetration_mm"] <= 0.001, run["largest_penetration_mm"]
print(f"{len(report['objects'])} trees in {seconds:.1f} s; {run['steps']} steps, largest force {run['largest_force_n']:.2f} N")
shutil.rmtree(folder)
