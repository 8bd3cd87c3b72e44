#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""schemas_test.py BUILD WORK: what the programs write is as docs/schemas say, each schema is tried on a file, and each
refuses what is not: another name of the schema, each key of the top missing, and a text in place of each number."""
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
             "burr": [{"centre_mm": [0, 0, 5.5], "radius_mm": 1}]},
    "bodies": [{"name": "jaw", "hinge": {"point_mm": [0, 60, 20], "axis": [1, 0, 0], "angle_deg": [[0, 0], [1, 20]]}}],
    "work": [{"name": "pocket", "sphere": {"centre_mm": [0, 0, 5], "radius_mm": 2}, "tolerance_mm": 0.5}],
    "objects": [{"name": "ball", "mesh": "ball.obj", "friction": 0.2, "tolerance_mm": 0.8},
                {"name": "moving", "mesh": "ball.obj", "position_mm": [0, 20, 0], "body": "jaw",
                 "cut": {"layers": [{"name": "all", "mesh": "ball.obj"}], "removal_mm_per_n_s": {"all": 2}, "tangential": 0.3}},
                {"name": "open", "mesh": "open.obj", "repair": "off"}]}  # is refused: reports have that case, too


SCHEMAS = ROOT / "docs/schemas"
checked = set()


def run(*command, codes=(0,)) -> str:
    done = subprocess.run([str(part) for part in command], stdout=subprocess.PIPE, text=True, check=False)
    assert done.returncode in codes, f"exit code {done.returncode}: {command}"
    return done.stdout


def numbers(value, path=()):
    """Paths of up to 200 numbers."""
    if isinstance(value, dict):
        return [found for key, part in value.items() for found in numbers(part, path + (key,))][:200]
    if isinstance(value, list):
        return [found for i, part in enumerate(value[:2]) for found in numbers(part, path + (i,))]
    return [path] if isinstance(value, (int, float)) and not isinstance(value, bool) else []


def check(name: str, written):
    """`written`: the JSON, as text or as it was read."""
    written = json.loads(written) if isinstance(written, str) else written
    schema = json.loads((SCHEMAS / f"{name}.schema.json").read_text(encoding="utf-8"))
    jsonschema.Draft202012Validator.check_schema(schema)
    validator = jsonschema.Draft202012Validator(schema, jsonschema.RefResolver(f"{SCHEMAS.as_uri()}/", schema))
    checked.add(name)
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


def trees(program: Path, work: Path):
    mesh, tree = work / "ball.obj", work / "b.stree"
    quick = ("--quality", "quick", "--levels", "2", "--quiet")
    run(program, "build", mesh, *quick, "-o", tree, "--report", work / "build.json")
    check("build", (work / "build.json").read_text())
    run(program, "build", work / "probe.obj", *quick, "--tolerance", "0.5", "--shape", "hulls", "--skin", "off", "-o", work / "h.stree", "--report", work / "build.json")
    check("build", (work / "build.json").read_text())
    (work / "cut.stree").write_bytes(tree.read_bytes()[:100])
    for one in json.loads(run(program, "inspect", tree, work / "h.stree", work / "cut.stree", "--json", codes=(4,)))[:2]:
        check("inspect", one)
    for one in json.loads(run(program, "check", mesh, work / "open.obj", "--list-parts", "--json", codes=(4,))):
        check("check", one)
    check("repair", run(program, "repair", work / "open.obj", "-o", work / "sound.ply", "--json"))
    check("evaluate", run(program, "evaluate", mesh, tree, "--json", "--quiet", "--lower-bound"))
    check("evaluate", run(program, "evaluate", work / "probe.obj", work / "h.stree", "--json", "--quiet", "--no-limits"))
    run(program, "convert", tree, work / "tree.json")
    check("tree", (work / "tree.json").read_text())
    run(program, "convert", work / "h.stree", work / "tree.json")
    check("tree", (work / "tree.json").read_text())


def tissue(program: Path, work: Path):
    softening = run(program, "soften", work / "ball.obj", work / "b.stree", "--young", "30", "--tets", "100", "--fix", "box:-9,-9,-9,9,9,0",
                    "-o", work / "b.soft", "--json")
    check("soften", softening)
    check("evaluate_states", run(program, "evaluate", work / "ball.obj", work / "b.soft", "--states", "5", "--samples", "100", "--json"))


def robots(program: Path, urdf: Path, folder: Path):
    run(program, "robot", urdf, "-o", folder, "--quality", "quick", "--budget", "20", "--quiet")
    check("robot", (folder / "robot.json").read_text())
    check("robot_report", run(program, "report", folder, "-o", folder / "page.html", "--json"))
    check("evaluate_robot", run(program, "evaluate", urdf, folder / f"{urdf.stem}.curobo.yml", "--json", "--quiet"))


def batches(program: Path, work: Path):
    check("scene", SCENE)
    (work / "s.scene.json").write_text(json.dumps(SCENE))
    run(program, "batch", work / "s.scene.json", "-o", work / "trees", "--budget", "60", "--chart", "--quiet", codes=(6,))
    check("scene", (work / "trees/scene.json").read_text())
    check("report", (work / "trees/report.json").read_text())
    (work / "list.jsonl").write_text('{"patient": "P1", "scene": "s.scene.json"}\n{"patient": "P2", "scene": "none.scene.json"}\n')
    run(program, "batch", "--cohort", work / "list.jsonl", "-o", work / "cohort", "--quiet", codes=(6,))
    for line in (work / "cohort/cohort.1-of-1.jsonl").read_text().splitlines():
        check("cohort", line)
    check("cohort_report", run(program, "report", work / "cohort", "--cohort", "-o", work / "cohort.html", "--json"))
    run(program, "compare", work / "ball.obj", work / "probe.obj", "--builders", "cover,octree,merge", "--qualities", "quick", "--levels", "2", "--quiet",
        "--sensitivity", "1", "-o", work / "comparison")
    check("compare", (work / "comparison/compare.json").read_text())


def player(build: Path, program: Path, work: Path):
    play = build / "tools/haptic_player/haptic-player"
    for modes in ("paper,constrained", "constrained"):
        run(play, "--scenario", "F17", "--quality", "quick", "--modes", modes, "--out", work / modes, "--quiet", codes=(0, 5))
        check("stability", (work / modes / "stability.json").read_text())
    check("run", run(play, work / "trees", "--clock", "stepped", "--seconds", "0.2", "--passivity-control", "--record", work / "played.csv", "--json"))
    check("recording_report", run(program, "report", work / "played.csv", "-o", work / "played.html", "--json"))
    check("cutting", run(play, "--compare-cutting", "--voxel-mm", "0.5", "--json"))
    tools = run(play, "--compare-tools", "ball,edge", "--json", "--chart", work / "tools.html")
    check("tools", tools)
    assert {"exact", "512 leaves"} <= {row["model"] for row in json.loads(tools)["rows"]}, "models are missing"
    assert "How much model a tool needs" in (work / "tools.html").read_text(), "the page has no chart"
    check("device", run(play, "--measure", "--json"))
    run(build / "samples/make_samples/make_samples", "--cavity", work / "cavity")
    check("grade", run(program, "grade", recording_of(work / "cavity", 6000), "--volume-tolerance", "1", "--json"))


def main():
    build, work = Path(sys.argv[1]), Path(sys.argv[2])
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir(parents=True)
    program = build / "tools/spheretree/spheretree"
    ball(work / "ball.obj", 2)
    ball(work / "probe.obj", 1)
    (work / "open.obj").write_text("\n".join((work / "ball.obj").read_text().splitlines()[:-1]) + "\n")
    trees(program, work)
    left_out = {"parts"}
    if (build / "tools/tetrahedra/spheretree-tetrahedra").exists():
        tissue(program, work)
    else:
        left_out |= {"soften", "evaluate_states"}
    run(build / "samples/make_samples/make_samples", "--robots", work / "robots")
    robots(program, work / "robots/sample_arm6/sample_arm6.urdf", work / "arm")
    batches(program, work)
    player(build, program, work)
    run(build / "samples/make_scans/make_scans", work / "scans", "edge=1.5")
    run(program, "split", work / "scans/upper.obj", "--labels", work / "scans/upper.json", "-o", work / "patient", "--quiet", codes=(0, 5))
    check("split", (work / "patient/split.json").read_text())
    check("scene", (work / "patient/mouth.scene.json").read_text())
    untried = {path.name.split(".")[0] for path in SCHEMAS.iterdir()} - checked - left_out
    assert not untried, f"schemas of nothing: {untried}"


main()
