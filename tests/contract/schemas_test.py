#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""schemas_test.py BUILD WORK: what the programs write is as docs/schemas say, and each schema refuses what is not:
another name of the schema, each key of the top missing, and a text in place of each number."""
import copy
import json
import shutil
import subprocess
import sys
from pathlib import Path

import jsonschema
from files_test import ball

ROOT = Path(__file__).resolve().parents[2]
SCENE = {
    "schema": "spheretree.scene/1", "unit": "mm", "defaults": {"quality": "quick", "levels": 2},
    "tool": {"name": "probe", "mesh": "probe.obj", "reference_point": "tip",
             "burr": [{"centre_mm": [0, 0, 0.5], "radius_mm": 0.5}]},
    "bodies": [{"name": "jaw", "hinge": {"point_mm": [0, 60, 20], "axis": [1, 0, 0], "angle_deg": [[0, 0], [1, 20]]}}],
    "work": [{"name": "pocket", "sphere": {"centre_mm": [0, 0, 5], "radius_mm": 2}, "tolerance_mm": 0.5}],
    "objects": [{"name": "ball", "mesh": "ball.obj", "friction": 0.2, "tolerance_mm": 0.8},
                {"name": "moving", "mesh": "ball.obj", "position_mm": [0, 20, 0], "body": "jaw",
                 "cut": {"layers": [{"name": "all", "mesh": "ball.obj"}], "removal_mm_per_n_s": {"all": 2}, "tangential": 0.3}},
                {"name": "open", "mesh": "open.obj", "repair": "off"}]}  # is refused: reports have that case, too


def run(*command, codes=(0,)):
    code = subprocess.run([str(part) for part in command], stdout=subprocess.DEVNULL, check=False).returncode
    assert code in codes, f"exit code {code}: {command}"


def numbers(value, path=()):
    """Paths of up to 200 numbers."""
    if isinstance(value, dict):
        return [found for key, part in value.items() for found in numbers(part, path + (key,))][:200]
    if isinstance(value, list):
        return [found for i, part in enumerate(value[:2]) for found in numbers(part, path + (i,))]
    return [path] if isinstance(value, (int, float)) and not isinstance(value, bool) else []


def check(name: str, written: dict):
    schema = json.loads((ROOT / f"docs/schemas/{name}.schema.json").read_text(encoding="utf-8"))
    jsonschema.Draft202012Validator.check_schema(schema)
    validator = jsonschema.Draft202012Validator(schema)
    for fault in validator.iter_errors(written):
        sys.exit(f"{name}: {'/'.join(map(str, fault.absolute_path))}: {fault.message[:300]}")
    taken = [key for key in schema["required"] if validator.is_valid({other: part for other, part in written.items() if other != key})]
    assert not taken, f"{name}: {taken} may be missing"
    assert not validator.is_valid({**written, "schema": "spheretree.other/1"}), f"{name}: takes another schema"
    paths = numbers(written)
    for path in paths:
        wrong = copy.deepcopy(written)
        place = wrong
        for key in path[:-1]:
            place = place[key]
        place[path[-1]] = "a text"
        assert not validator.is_valid(wrong), f"{name}: takes a text at {path}"
    print(f"{name}: {len(paths)} numbers checked")


def recording_of(folder: Path, steps: int) -> Path:
    """A recording of a tool that follows the path of the sample cavity exactly."""
    rows = [line.split(",") for line in (folder / "drill.csv").read_text().splitlines()[1:steps + 1]]
    lines = ["tick,t_s,gx_mm,gy_mm,gz_mm,gqw,gqx,gqy,gqz,scene,spin"]
    lines += [",".join([str(i), *row[:8], "cavity.scene.json" if i == 0 else "", row[8]]) for i, row in enumerate(rows)]
    (folder / "run.csv").write_text("\n".join(lines) + "\n")
    return folder / "run.csv"


def main():
    build, work = Path(sys.argv[1]), Path(sys.argv[2])
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir(parents=True)
    program = build / "tools/spheretree/spheretree"
    ball(work / "ball.obj", 2)
    ball(work / "probe.obj", 1)
    (work / "open.obj").write_text("\n".join((work / "ball.obj").read_text().splitlines()[:-1]) + "\n")
    (work / "s.scene.json").write_text(json.dumps(SCENE))
    run(program, "build", work / "ball.obj", "--quality", "quick", "--levels", "2", "--quiet", "-o", work / "b.stree", "--report", work / "build.json")
    run(program, "batch", work / "s.scene.json", "-o", work / "trees", "--quiet", codes=(6,))
    run(program, "compare", work / "ball.obj", work / "probe.obj", "--builders", "cover,octree,merge", "--qualities", "quick", "--levels", "2", "--quiet",
        "-o", work / "comparison")
    run(build / "tools/haptic_player/haptic-player", "--scenario", "F7", "--quality", "quick", "--out", work / "stability", "--quiet", codes=(0, 5))
    run(build / "samples/make_scans/make_scans", work / "scans", "edge=1.5")
    run(program, "split", work / "scans/upper.obj", "--labels", work / "scans/upper.json", "-o", work / "patient", "--quiet", codes=(0, 5))
    run(build / "samples/make_samples/make_samples", "--cavity", work / "cavity")
    graded = subprocess.run([program, "grade", recording_of(work / "cavity", 6000), "--volume-tolerance", "1", "--json"],
                            stdout=subprocess.PIPE, text=True, check=True).stdout
    check("grade", json.loads(graded))
    check("scene", SCENE)
    for name, file in (("scene", "trees/scene.json"), ("scene", "patient/mouth.scene.json"), ("build", "build.json"), ("report", "trees/report.json"),
                       ("compare", "comparison/compare.json"), ("stability", "stability/stability.json"), ("split", "patient/split.json")):
        check(name, json.loads((work / file).read_text(encoding="utf-8")))


main()
