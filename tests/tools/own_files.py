#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""own_files.py SPHERETREE HAPTIC_PLAYER MAKE_SAMPLES MAKE_SCANS: no output replaces a file that was read for it,
or another output of the same run.

For every verb (and the player), every output is aimed at every input, named or read because another file names it:
under its own name where the ending fits, by another path, through a link, a hard link, a linked folder; a fifth of
these ways for each pair, in turn. Each time the program must refuse (exit code 2) and every input must have the bytes
that it had. Then every two outputs of a run are aimed at one name.

Outputs that the command line does not name replace only what an earlier run of the same command wrote and nobody
edited: for every verb and each such file. """
import itertools
import json
import os
import shutil
import struct
import subprocess
import sys
import tempfile
from pathlib import Path

spheretree, player, make_samples, make_scans = (str(Path(p).resolve()) for p in sys.argv[1:5])
failures, runs = [], 0

TETRAHEDRON = "v 0 0 0\nv 10 0 0\nv 0 10 0\nv 0 0 10\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
TREE = "2 2\n2.5 2.5 2.5 10 1\n2 2 2 8.9 1\n5 5 5 7.5 1\n"
QUICK = {"quality": "quick", "levels": 2}


def run(program, *words, cwd):
    return subprocess.run([program, *map(str, words)], cwd=cwd, capture_output=True, text=True, errors="replace", timeout=120)


def prepare(folder):
    """Everything that a verb may read: meshes, a glTF with a buffer of its own, trees, scenes, recordings, results."""
    import struct
    (folder / "m.obj").write_text(TETRAHEDRON)
    (folder / "open.obj").write_text(TETRAHEDRON.replace("f 2 3 4\n", ""))
    points = [(0, 0, 0), (.01, 0, 0), (0, .01, 0), (0, 0, .01)]
    faces = [0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3]
    data = b"".join(struct.pack("<3f", *p) for p in points) + struct.pack("<12H", *faces)
    (folder / "m.bin").write_bytes(data)
    (folder / "m.gltf").write_text(json.dumps({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "buffers": [{"uri": "m.bin", "byteLength": len(data)}],
        "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 24}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [.01, .01, .01]},
                      {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}]}))
    (folder / "t.sph").write_text(TREE)
    for name in ("t.stree", "t.json", "held.stree"):
        assert run(spheretree, "convert", "t.sph", name, cwd=folder).returncode == 0
    scene = {"schema": "spheretree.scene/1", "defaults": QUICK, "tool": {"name": "tool", "mesh": "m.obj"},
             "objects": [{"name": "a", "mesh": "m.gltf"}, {"name": "b", "tree": "held.stree", "position_mm": [40, 0, 0]}]}
    (folder / "mine.scene.json").write_text(json.dumps(scene))
    rows = "".join(f"{i / 1000:.3f},0,0,{30 - 0.3 * i:.3f},1,0,0,0\n" for i in range(60))
    (folder / "path.csv").write_text("t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz\n" + rows)
    assert run(spheretree, "batch", "mine.scene.json", "-o", "bc", cwd=folder).returncode == 0
    assert run(player, "bc/scene.json", "--trajectory", "path.csv", "--clock", "stepped", "--record", "run.csv", cwd=folder).returncode == 0
    (folder / "list.jsonl").write_text('{"patient": "p", "scene": "mine.scene.json"}\n{"patient": "q", "scene": "mine.scene.json"}\n')
    assert run(spheretree, "batch", "--cohort", "list.jsonl", "-o", "coh", cwd=folder).returncode == 0
    (folder / "labels.json").write_text('{"jaw": "lower", "labels": [0, 0, 0, 31]}')
    (folder / "r.urdf").write_text('<robot name="r"><link name="a"><collision><geometry><mesh filename="m.obj" scale="0.001 0.001 0.001"/>'
                                   "</geometry></collision></link></robot>")
    assert run(spheretree, "compare", "m.obj", "-o", "cmp", "--builders", "cover", "--qualities", "quick", "--levels", "2",
               cwd=folder).returncode == 0


def contents(folder):
    return {p.relative_to(folder): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file() and not p.is_symlink()}


def aliases(folder, target, ending, name="alias"):
    """Names, each of which is `target` in another way, with the ending that the output must have."""
    where = folder / target
    if where.suffix == ending:
        yield str(target)
        yield f"./{target}"
        yield str(where)
        yield f"bc/../{target}"
        (folder / "linked").symlink_to(where.parent)
        yield f"linked/{where.name}"
    (folder / f"{name}-link{ending}").symlink_to(where)
    yield f"{name}-link{ending}"
    (folder / f"{name}-relative{ending}").symlink_to(os.path.relpath(where, folder))
    yield f"{name}-relative{ending}"
    os.link(where, folder / f"{name}-hard{ending}")
    yield f"{name}-hard{ending}"


def trial(what, folder, before, program, *words, code=2):
    """One run that has to be refused."""
    global runs
    runs += 1
    result = run(program, *words, cwd=folder)
    said = " ".join(map(str, words))
    if result.returncode != code:
        failures.append(f"{what}: exit code {result.returncode}, not {code}: {said}\n    {result.stderr.strip()}")
    elif code == 2 and len(result.stderr.strip().splitlines()) != 1:
        failures.append(f"{what}: not one line: {result.stderr!r}")
    after = contents(folder)
    for path, old in before.items():
        if after.get(path) != old:
            failures.append(f"{what}: {path} was replaced: {said}")
            (folder / path).write_bytes(old)
    for path in after.keys() - before.keys():
        if path.suffix == ".tmp":
            failures.append(f"{what}: left behind: {path}")


def fresh(template):
    folder = Path(tempfile.mkdtemp(dir=template.parent))
    shutil.copytree(template, folder, dirs_exist_ok=True, symlinks=True)
    results = folder / "cmp/compare.json"  # names its meshes by absolute paths
    results.write_text(results.read_text().replace(str(template), str(folder)))
    return folder


def named_outputs(template):
    """Verbs whose outputs are named: (what, words with OUT for the output, its ending, inputs)."""
    mesh = ["m.gltf", "m.bin"]
    cases = [
        ("build -o", ["build", "m.gltf", "-o", "OUT", "--levels", 2], ".stree", mesh),
        ("build --report", ["build", "m.gltf", "-o", "new.stree", "--levels", 2, "--report", "OUT"], ".json", mesh),
        ("check -o", ["check", "m.gltf", "-o", "OUT"], ".glb", mesh),
        ("check -o, refused mesh", ["check", "open.obj", "-o", "OUT"], ".glb", ["open.obj"]),
        ("scene -o", ["scene", "m.gltf", "-o", "OUT", "-q"], ".json", mesh),
        ("soften -o", ["soften", "m.obj", "held.stree", "-o", "OUT"], ".soft", ["m.obj", "held.stree"]),
        ("repair -o", ["repair", "m.gltf", "-o", "OUT"], ".ply", mesh),
        ("repair -o, OBJ", ["repair", "open.obj", "-o", "OUT"], ".obj", ["open.obj"]),
        ("report of a batch", ["report", "bc", "-o", "OUT", "--recording", "run.csv"], ".html",
         ["bc/report.json", "bc/scene.json", "bc/tool.stree", "bc/a.stree", "bc/b.stree", "run.csv", "mine.scene.json", *mesh, "m.obj"]),
        ("report of a recording", ["report", "run.csv", "-o", "OUT", "--scene", "bc/scene.json"], ".html",
         ["run.csv", "bc/scene.json", "bc/tool.stree", "bc/a.stree", "bc/b.stree"]),
        ("report of a comparison", ["report", "cmp", "-o", "OUT"], ".html",
         ["cmp/compare.json", "cmp/trees/m.cover.quick.stree", "m.obj"]),
        ("report of a cohort", ["report", "--cohort", "coh", "-o", "OUT"], ".html", ["coh/cohort.1-of-1.jsonl"]),
        ("split --marked", ["split", "open.obj", "--labels", "labels.json", "-o", "patient", "--marked", "OUT"], ".glb", ["open.obj", "labels.json"]),
        ("view --picture", ["view", "m.gltf", "--picture", "OUT"], ".png", mesh),
        ("player --picture", [player, "bc/scene.json", "--trajectory", "path.csv", "--picture", "OUT", "--at", 1], ".png",
         ["bc/scene.json", "bc/tool.stree", "bc/a.stree", "bc/b.stree", "path.csv"]),
        ("player --replay --picture", [player, "bc/scene.json", "--replay", "run.csv", "--picture", "OUT", "--at", 1], ".png",
         ["bc/scene.json", "bc/tool.stree", "bc/a.stree", "bc/b.stree", "run.csv"]),
        ("player --record", [player, "bc/scene.json", "--trajectory", "path.csv", "--clock", "stepped", "--record", "OUT"], ".csv",
         ["bc/scene.json", "bc/tool.stree", "bc/a.stree", "bc/b.stree", "path.csv"]),
        ("player --record, simulated", [player, "bc/scene.json", "--seconds", 0.01, "--clock", "stepped", "--record", "OUT"], ".csv",
         ["bc/scene.json", "bc/tool.stree", "bc/a.stree", "bc/b.stree"]),
    ]
    for source in ("t.stree", "t.sph", "t.json"):
        for ending in (".stree", ".sph", ".json", ".csv", ".yaml", ".glb", ".png"):
            cases.append((f"convert {source} to {ending}", ["convert", source, "OUT"], ending, [source]))
    cases.append(("convert --mesh", ["convert", "t.stree", "OUT", "--mesh", "m.gltf"], ".png", ["t.stree", *mesh]))
    turn = 0
    for what, words, ending, inputs in cases:
        program, words = (words[0], words[1:]) if words[0] == player else (spheretree, words)
        for source in inputs:
            folder = fresh(template)
            before = contents(folder)
            turn += 1
            for alias in list(aliases(folder, Path(source), ending))[turn % 5::5]:
                trial(f"{what} over {source}", folder, before, program, *[alias if w == "OUT" else w for w in words])
            shutil.rmtree(folder)


def folder_outputs(template):
    """Verbs that write into a folder: each file that they write is an input by another name, or the input itself lies
    there."""
    inputs = ["mine.scene.json", "m.obj", "m.gltf", "m.bin", "held.stree", "path.csv"]
    batch = ["batch", "mine.scene.json", "-o", "out", "--chart", "--trajectory", "path.csv"]
    comparison = ["compare", "m.obj", "-o", "out", "--builders", "cover", "--qualities", "quick", "--levels", 2]
    written = ["compare.csv", "compare.json", "index.html", "comparison.svg", "comparison.pdf", "m.svg", "m.pdf",
               "trees/m.cover.quick.stree", "runs/m.json", "runs/m.cover.quick.json"]
    robot = ["robot", "r.urdf", "-o", "out", "--budget", 4, "--quality", "quick"]
    cohort = ["batch", "--cohort", "list.jsonl", "-o", "out"]
    cases = [("robot", robot, ["r.urdf", "m.obj"], ["r.urdf", "r.srdf", "r.xrdf", "r.curobo.yml", "foam/a.json", "morphit/a.json"]),
             ("split", ["split", "open.obj", "--labels", "labels.json", "-o", "out"], ["open.obj", "labels.json"], ["split.json", "mouth.scene.json"]),
             ("cohort", cohort, ["list.jsonl", "mine.scene.json", "m.obj", "m.bin", "held.stree"],
              ["cohort.1-of-1.jsonl", "p/scene.json", "q/report.json", "p/tool.stree", "q/a.stree"]),
             ("batch", batch, inputs, ["scene.json", "report.json", "tool.stree", "a.stree", "b.stree"]),
             ("compare", comparison, ["m.obj"], written)]
    for what, words, sources, outputs in cases:
        for i, (source, output) in enumerate(itertools.product(sources, outputs)):
            folder = fresh(template)
            before = contents(folder)
            where = folder / "out" / output
            where.parent.mkdir(parents=True)
            link = ("symbolic", "hard")[i % 2]
            if link == "hard":
                os.link(folder / source, where)
            else:
                where.symlink_to(folder / source)
            of_a_patient = what == "cohort" and "/" in output  # refused by itself; the others go on
            trial(f"{what}: {output} is {source} ({link})", folder, before, spheretree, *words, code=6 if of_a_patient else 2)
            shutil.rmtree(folder)
    # Several meshes into a folder: one of the trees would have the name of a mesh.
    for link in ("symbolic", "hard"):
        folder = fresh(template)
        before = contents(folder)
        (folder / "out").mkdir()
        (os.link if link == "hard" else lambda a, b: b.symlink_to(a))(folder / "m.obj", folder / "out/m.stree")
        trial(f"build of several: out/m.stree is m.obj ({link})", folder, before, spheretree, "build", "m.obj", "open.obj", "-o", "out", "--levels", 2)
        shutil.rmtree(folder)
    # The tree of an object would take the place of a tree that the scene names, or of the scene itself.
    for name, scene in (("a", "mine.scene.json"), ("a", "scene.json"), ("a", "report.json")):
        folder = fresh(template)
        text = {"schema": "spheretree.scene/1", "defaults": QUICK, "tool": {"name": "tool", "mesh": "m.obj"},
                "objects": [{"name": "b", "tree": "a.stree"}, {"name": name, "mesh": "m.obj"}]}
        shutil.copy(folder / "held.stree", folder / "a.stree")
        (folder / scene).write_text(json.dumps(text))
        trial(f"batch into the folder of {scene}", folder, contents(folder), spheretree, "batch", scene, "-o", ".")
        shutil.rmtree(folder)


def two_outputs(template):
    cases = [("build", ["build", "m.obj", "-o", "ONE", "--report", "TWO", "--levels", 2])]
    pairs = [("x.stree", "x.stree"), ("x.stree", "./x.stree"), ("old.stree", "link.json"), ("old.stree", "hard.json"),
             ("x.stree", "dangling.json"), ("-", "-")]
    for what, words in cases:
        for one, two in pairs:
            folder = fresh(template)
            shutil.copy(folder / "t.stree", folder / "old.stree")
            (folder / "link.json").symlink_to("old.stree")
            os.link(folder / "old.stree", folder / "hard.json")
            (folder / "dangling.json").symlink_to("x.stree")
            before = contents(folder)
            trial(f"{what}: outputs {one} and {two}", folder, before, spheretree, *[{"ONE": one, "TWO": two}.get(w, w) for w in words])
            if (folder / "x.stree").exists():
                failures.append(f"{what}: outputs {one} and {two}: one was written")
            shutil.rmtree(folder)


def allowed(template):
    """What must go on working: the same outputs again, over those of the run before."""
    folder = fresh(template)
    for words in (["build", "m.obj", "-o", "t2.stree", "--levels", 2, "--report", "r.json"], ["batch", "mine.scene.json", "-o", "bc"],
                  ["report", "bc", "-o", "p.html", "--recording", "run.csv"], ["convert", "t.stree", "c.sph"],
                  ["compare", "m.obj", "-o", "cmp2", "--builders", "cover", "--qualities", "quick", "--levels", 2]):
        for _ in range(2):
            result = run(spheretree, *words, cwd=folder)
            if result.returncode != 0:
                failures.append(f"{words}: exit code {result.returncode}: {result.stderr.strip()}")
    shutil.rmtree(folder)


def unnamed_outputs(template):
    """Each case: words that are run in a fresh folder, the folder of its outputs, and the options that replace all."""
    quick = ["--quality", "quick"]
    scenario = [player, "--scenario", "F17", "--out", "out", "--quality", "quick", "--share", "0.001", "--turned", "0", "--modes", "paper"]
    cases = [("scene", [spheretree, "scene", "m.obj", "-o", "out/s.scene.json"]),
             ("batch of meshes", [spheretree, "batch", "m.obj", "-o", "out", *quick]),
             ("batch", [spheretree, "batch", "mine.scene.json", "-o", "out"]),
             ("split", [spheretree, "split", "open.obj", "--labels", "labels.json", "-o", "out"]),
             ("build of several", [spheretree, "build", "m.obj", "m.gltf", "x.obj", "-o", "out", "--levels", "2"]),
             ("compare", [spheretree, "compare", "m.obj", "-o", "out", "--builders", "cover", "--qualities", "quick", "--levels", "2"]),
             ("robot", [spheretree, "robot", "r.urdf", "-o", "out", "--budget", "4", *quick]),
             ("cohort", [spheretree, "batch", "--cohort", "list.jsonl", "-o", "out"]),
             ("scenario", scenario),
             ("pictures", [player, "--replay", "run.csv", "--picture", "out/p.png", "--at", "0:50:25", "--size", "64x64"]),
             ("make_samples", [make_samples, "out"]),
             ("make_scans", [make_scans, "out", "edge=2"])]
    for what, words in cases:
        def attempt(folder, expected, file=None, kept=None, force=False):
            global runs
            runs += 1
            forced = [words[0], "--force", *words[1:]] if words[0] in (make_samples, make_scans) else [*words, "--force"]
            result = run(*(forced if force else words), cwd=folder)
            if result.returncode not in expected:
                failures.append(f"{what}, {file}: exit code {result.returncode}, not {expected}: {result.stderr.strip()}")
            if kept is not None and (folder / file).read_bytes() != kept:
                failures.append(f"{what}: {file} was replaced")
            if kept is not None and 2 in expected and str(file) not in result.stderr and Path(file).name not in result.stderr:
                failures.append(f"{what}: the message does not name {file}: {result.stderr.strip()}")

        done = fresh(template)
        if what == "build of several":  # three meshes, three names
            shutil.copy(done / "m.gltf", done / "g.gltf")
            shutil.copy(done / "m.obj", done / "x.obj")
            words[3] = "g.gltf"
        (done / "out").mkdir()
        start = Path(tempfile.mkdtemp(dir=template.parent))
        shutil.copytree(done, start, dirs_exist_ok=True)
        success = (0, 5)  # a quick scenario may fall short, and a split may need more levels
        attempt(done, success)
        attempt(done, success)  # again, over its own files
        files = [f for f in contents(done / "out") if "cache" not in f.parts and not f.name.startswith(".")]
        if not files:
            failures.append(f"{what}: wrote nothing")
        for name in files:
            file, mine = Path("out") / name, b"mine, and nobody else's"
            refused = (6,) if what == "cohort" and len(name.parts) > 1 else (2,)
            (start / file).parent.mkdir(parents=True, exist_ok=True)
            (start / file).write_bytes(mine)
            attempt(start, refused, file, mine)
            if refused == (2,):
                others = {p for p in contents(start / "out") if "cache" not in p.parts} - {name}
                if others:
                    failures.append(f"{what}: refused for {name}, but wrote {sorted(map(str, others))}")
            shutil.rmtree(start / "out")
            (start / "out").mkdir()
            written = (done / file).read_bytes()
            edited = written + b" "
            (done / file).write_bytes(edited)
            attempt(done, refused, file, edited)
            (done / file).write_bytes(written)
            if what == "cohort":
                attempt(done, success)  # its log tells of the refusal
        if files:
            (done / "out" / files[0]).write_bytes(b"edited")
            attempt(done, success, force=True)
            if (done / "out" / files[0]).read_bytes() == b"edited":
                failures.append(f"{what}: --force did not replace {files[0]}")
            attempt(done, success)
        shutil.rmtree(done)
        shutil.rmtree(start)


def main():
    with tempfile.TemporaryDirectory() as base:
        template = Path(base) / "template"
        template.mkdir()
        prepare(template)
        named_outputs(template)
        folder_outputs(template)
        two_outputs(template)
        unnamed_outputs(template)
        allowed(template)
    print(f"{runs} runs")
    for failure in failures:
        print("FAILED:", failure)
    return 1 if failures else 0


sys.exit(main())
