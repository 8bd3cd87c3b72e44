#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""files_test.py SPHERETREE WORK [PYTHONPATH]: makes the conformance set of trees of small meshes, and has it read by
the readers of this folder, by the program, and, with PYTHONPATH, by the Python package, which also reads tissue."""
import math
import os
import shutil
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
LOAD = """import sys, spheretree
try:
    spheretree.Scene(spheretree.SphereTree.load(sys.argv[1]), [{"tree": sys.argv[2]}])
except spheretree.FormatError as reason:
    sys.exit(str(reason))"""


def ball(path: Path, times: int):
    """An octahedron, divided, on a sphere of radius 5."""
    faces = [[(x, 0, 0), (0, y, 0), (0, 0, z)][::x * y * z] for x in (1, -1) for y in (1, -1) for z in (1, -1)]
    for _ in range(times):
        middle = lambda a, b: tuple((p + q) / 2 for p, q in zip(a, b))
        faces = [face for a, b, c in faces for ab, bc, ca in [(middle(a, b), middle(b, c), middle(c, a))]
                 for face in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))]
    with path.open("w") as out:
        for i, face in enumerate(faces):
            for p in face:
                out.write("v " + " ".join(f"{5 * x / math.hypot(*p):.9f}" for x in p) + "\n")
            out.write(f"f {3 * i + 1} {3 * i + 2} {3 * i + 3}\n")


def run(*command, **options):
    subprocess.run([str(part) for part in command], check=True, **options)


def main():
    program, work = sys.argv[1], Path(sys.argv[2])
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir(parents=True)
    ball(work / "ball.obj", 2)
    common = ("--quality", "quick", "--levels", "2", "--quiet")
    run(program, "build", work / "ball.obj", *common, "--skin", "0.2", "-o", work / "ball.stree", stdout=subprocess.DEVNULL)
    run(program, "build", work / "ball.obj", *common, "--shape", "hulls", "--leaves", "8", "-o", work / "hulls.stree", stdout=subprocess.DEVNULL)
    trees = [work / "ball.stree", work / "hulls.stree"]
    if (Path(program).parent / "spheretree-tetrahedra").exists():
        run(program, "soften", work / "ball.obj", trees[0], "--young", "15", "--fix", "box:-6,-6,-6,6,6,-3", "--quiet", "-o", work / "ball.soft",
            stdout=subprocess.DEVNULL)
        trees.append(work / "ball.soft")
    run(sys.executable, HERE / "conformance.py", "make", work / "set", *trees)
    check = (sys.executable, HERE / "conformance.py", "check", work / "set")
    run(*check, "--stree", sys.executable, HERE / "stree_reader.py")
    run(*check, "--stree", program, "inspect")
    if len(trees) == 3:
        run(*check, "--soft", sys.executable, HERE / "soft_reader.py")
        if len(sys.argv) > 3:
            run(*check, "--soft", "/usr/bin/python3", "-c", LOAD, trees[0], env={**os.environ, "PYTHONPATH": sys.argv[3]})
    lines = len((HERE / "stree_reader.py").read_text(encoding="utf-8").splitlines())
    assert lines <= 150, f"stree_reader.py has {lines} lines"


if __name__ == "__main__":
    main()
