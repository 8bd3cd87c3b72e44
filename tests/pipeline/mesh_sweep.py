#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""mesh_sweep.py SPHERETREE MESHES FOLDER [TABLE.md]: whatever the mesh, a certified tree or a refusal that says why.

Checks and builds (--repair auto, quick) the meshes of others in MESHES/failure and MESHES/dental, and measures that
every level covers the repaired surface and what of the input is left beside it. A program that crashes, hangs for five
minutes, leaves a file behind where it refuses, or ends with a code that docs/mesh_input.md does not promise is a fault.
Default: a subset of some 30 files with three levels, half a minute. SPHERETREE_LONG=1: every file with four levels, ten
minutes. TABLE.md: a row for each file. Exit code 77: no meshes. """
import json
import os
import subprocess
import sys
import time
from pathlib import Path

program, meshes, folder = sys.argv[1], Path(sys.argv[2]), Path(sys.argv[3])
is_long = os.environ.get("SPHERETREE_LONG") == "1"
if not (meshes / "failure").is_dir():
    sys.exit(77)
folder.mkdir(parents=True, exist_ok=True)

TIMEOUT_S = 300
SUBSET = """dental/maxilla_ct_porous.ply dental/gums_and_tongue_open.obj dental/upper_cast.obj dental/tooth_FDI36_molar.stl
failure/gltf/RecursiveNodes.gltf failure/gltf/missing_bin/BoxTextured.gltf failure/gltf/Mesh_PrimitiveMode_00.gltf
failure/gltf/badNumber.gltf failure/gltf/khronos/glb__truncated_chunk_data.glb failure/mesh/boxNotManifold.obj failure/mesh/multibody.stl
failure/mesh/hourglass_ico.obj failure/mesh/featuretype.STL failure/obj/malformed.obj failure/obj/box_UTF16BE.obj failure/obj/negative_indices.obj
failure/off/OutOfMemory.off failure/off/whitespace.off failure/ply/empty.ply failure/ply/issue623.ply failure/stl/quad.ascii.stl
failure/stl/missingFace.ascii.stl failure/stl/incorrectFaceCounter.bin.stl failure/tooth/hostile_accessor_count.glb
failure/tooth/hostile_path_escape.gltf failure/tooth/tooth_nan_inf.obj failure/tooth/tooth_zero_thickness.obj
failure/tooth/tooth_open_crown_scan.stl failure/tooth/tooth_scattered_holes.stl failure/tooth/teeth_overlapping.stl
failure/tooth/tooth_sparse.gltf""".split()
MEASURED = {"dental/maxilla_ct_porous.ply", "dental/gums_and_tongue_open.obj", "failure/mesh/hourglass_ico.obj"}
# Files that are not trustworthy triangle meshes; all others must become a tree.
UNREADABLE = {"failure/gltf/missing_bin/BoxTextured.gltf"}
REFUSED = """gltf/AllIndicesOutOfRange.gltf gltf/Mesh_PrimitiveMode_00.gltf gltf/Mesh_PrimitiveMode_02.gltf gltf/RecursiveNodes.gltf
gltf/SceneWithoutNodes.gltf gltf/badArray.gltf gltf/empty_nodes.glb gltf/sceneWrongType.gltf obj/box_UTF16BE.obj obj/malformed.obj
obj/number_formats.obj obj/obj_points.obj obj/obj_wireframe.obj obj/point_cloud.obj off/OutOfMemory.off off/invalid.off ply/empty.ply
ply/issue623.ply ply/ply_empty_bin.ply ply/ply_empty_header.ply ply/points_emptyface.ply stl/empty.stl stl/faceless.ascii.stl
stl/fourVertices.ascii.stl stl/quad.ascii.stl stl/twoVertices.ascii.stl tooth/tooth_index_out_of_range.obj
tooth/tooth_index_zero.obj tooth/tooth_nan_inf.obj tooth/tooth_truncated.stl""".split()

faults, rows = [], []


def expected(name):
    if name in UNREADABLE:
        return 3
    short = name.removeprefix("failure/")
    hostile = Path(name).name.startswith("hostile_") and "deep_nodes" not in name
    return 4 if short in REFUSED or short.startswith("gltf/khronos/") or hostile else 0


def run(*arguments):
    """Exit code, stdout, stderr; the code is None after the time limit."""
    try:
        done = subprocess.run([program, *map(str, arguments), "--progress", "none"], capture_output=True, timeout=TIMEOUT_S)
    except subprocess.TimeoutExpired:
        return None, "", ""
    return done.returncode, done.stdout.decode(), done.stderr.decode(errors="replace")


def sweep(name):
    def fault(what):
        faults.append(f"{name}: {what}")

    path, tree, report = meshes / name, folder / "mesh.stree", folder / "mesh.json"
    for output in (tree, report):
        output.unlink(missing_ok=True)
    check, checked, _ = run("check", path, "--json")
    begun = time.monotonic()
    levels = "4" if is_long else "3"
    build, _, talk = run("build", path, "-o", tree, "--report", report, "--quality", "quick", "--levels", levels, "--repair", "auto", "-q")
    seconds = time.monotonic() - begun
    want = expected(name)
    row = [name, "" if check is None else check, "" if build is None else build, f"{seconds:.1f}", "", "", ""]
    rows.append(row)
    if build != want:
        fault(f"build ends with {build} in place of {want}: {talk.strip()[:200]}")
    if want != 0:
        if check != want:
            fault(f"check ends with {check} in place of {want}")
        first = talk.strip().split("\n")[0]
        row[6] = first.removeprefix("spheretree: ").replace(str(meshes) + "/", "")
        if path.stem not in first and "BoxTextured0" not in first:
            fault(f"the refusal does not name the file: {first}")
        if tree.exists() or report.exists():
            fault("a refused build left a file")
        return
    if build != 0:
        return
    if check not in (0, 4):
        fault(f"check ends with {check}")
    if run("inspect", tree)[0] != 0:
        fault("inspect refuses the tree")
    facts = json.loads(report.read_text())
    overhang, repair = facts["levels"][-1]["overhang_bound_mm"], facts["repair"]
    if not 0 < overhang < facts["mesh"]["diagonal_mm"] or not facts["mesh"]["volume_mm3"] > 0:
        fault("overhang or volume make no sense")
    if is_long or name in MEASURED:
        evaluated = run("evaluate", path, tree, "--json", "--no-limits", "-q")
        if evaluated[0] != 0:
            fault(f"evaluate ends with {evaluated[0]}")
        elif any(level["uncovered_fraction"] > 0 or level["max_gap_mm"] > 0 for level in json.loads(evaluated[1])["levels"]):
            fault("a level does not cover the surface")
    if bool(repair["steps"]) != (check == 4) and json.loads(checked)["clean"] != (not repair["steps"]):
        if [s["step"] for s in repair["steps"]] != ["drop_buried"]:  # no defect
            fault("check and build disagree on whether there is anything to repair")
    row[4:7] = f"{100 * overhang / facts['mesh']['diagonal_mm']:.2f}", f"{repair['bound_mm']:.2g}", ", ".join(s["step"] for s in repair["steps"])


every = sorted(str(p.relative_to(meshes)) for room in ("failure", "dental") for p in (meshes / room).rglob("*")
               if p.is_file() and p.suffix != ".bin")
chosen = every if is_long else SUBSET
for name in chosen:
    sweep(name)
if len(sys.argv) > 4:
    head = "| file | check | build | seconds | overhang bound, % of diagonal | repair moved by, mm | steps, or the refusal |\n|---|---|---|---|---|---|---|\n"
    Path(sys.argv[4]).write_text(head + "".join("| " + " | ".join(str(cell).replace("|", "\\|") for cell in row) + " |\n" for row in rows))
print(f"{len(chosen)} files: {sum(r[2] == 0 for r in rows)} trees, {sum(r[2] in (3, 4) for r in rows)} refusals")
for line in faults:
    print("fault:", line)
sys.exit(1 if faults else 0)
