#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""tools/vary_constants.py [--update] [PATTERN...]: what half and twice each constant of builder and runtime do. Writes
build/vary/figures.csv

Builds the programs once, in a copy of the checkout in which every numeric constant of libspheretree/src and
libruntime/runtime/src asks the environment for a factor, then runs them for each constant whose FILE:NAME matches a
PATTERN (default: all) with the factors 0.5, 1 and 2. A field of the efforts of the qualities counts as a constant, too.
Each number of a list is multiplied; a constant that sizes an array is compiled again for each factor. FILE is below
these folders; of the runtime it begins with runtime/. Figures of the builder: the error (bound of the overhang of the
leaves; of the skin, how far it is from the mesh), the bytes of the tree and processor time, each summed over the cases
of the constant's wing and divided by those of factor 1. Of a repair: one and the lengths [mm] by which its steps change
the surface (as the error), and the places that these steps mend, openings left out (in place of the bytes). Of a check:
the thickness below which a twentieth of the mesh is (as the error), and the leaves of the first estimate (in place of
the bytes). Of a split, on a noisy scan with jagged labels: one and the crossing pairs (as the error), the length of all
borders (in place of the bytes) and processor time. Of the runtime, along the teeth of the sample mouth: the largest
step of the force (as the error), the 99.9th percentile of a step's time (in place of the bytes) and processor time.
Rows of docs/constants.md of the kind `measured` come from here; --update puts figures of the overhang into those that
have some, in place of the text from "Half:" or "No effect" on."""
import csv
import fnmatch
import json
import math
import os
import re
import resource
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
WORK = ROOT / "build/vary"
SOURCE, BUILD = WORK / "source", WORK / "build"
DECLARATION = re.compile(r"^(\s*)((?:inline |static )*)constexpr (double|float|int|std::size_t|std::uint64_t|std::uint32_t) (k[A-Z][^;()]*);", re.MULTILINE)
ARRAY = re.compile(r"^(\s*)constexpr (std::array<double, \d+>) (k[A-Z]\w*)(\{[^;{}]*\});", re.MULTILINE)
EFFORT = re.compile(r"\.(\w+) = ([\d.']+)(?=[,}])")  # in the tables of the qualities
HEADER = """#pragma once
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <type_traits>
template <class T>
T varied(const char* name, T value) {
  const char* wanted = std::getenv("SPHERETREE_VARY");  // NAME=FACTOR
  const std::size_t size = std::strlen(name);
  if (!wanted || std::strncmp(wanted, name, size) != 0 || wanted[size] != '=') return value;
  const double product = static_cast<double>(value) * std::atof(wanted + size + 1);
  if constexpr (std::is_integral_v<T>) return static_cast<T>(product < 1 ? 1 : std::llround(product));
  return static_cast<T>(product);
}
template <class A>
A variedEach(const char* name, A values) {
  for (auto& value : values) value = varied(name, value);
  return values;
}
"""
# Wing, file or FILE:NAME: how it is driven. Mesh and options of `spheretree build`; "evaluate" measures the tree, too.
CASES = {"default": ["molar --quality quick", "probe --quality quick", "molar --tolerance 0.3 --quality quick"],
         "build_sphere_tree.cpp:kFar": ["near --quality quick", "distant --quality quick"],
         "level_search.cpp": ["molar --tolerance 0.3 --quality quick", "molar --tolerance 0.3", "molar --tolerance 1.2 --quality quick",
                              "probe --tolerance 1.2 --quality quick", "probe --builder merge --levels 3 --quality quick --tolerance 1"],
         "simplified_input.cpp": ["fine --quality quick --levels 3", "fine --quality quick --levels 3 --tolerance 1"],
         "simplified_input.cpp:kTrianglesALeaf": ["finest --quality quick"],
         "measure": ["evaluate molar --quality quick", "evaluate probe --quality quick"],
         "skin": ["molar --quality quick --levels 3", "fine --quality quick --levels 3"],
         "published": [f"probe --builder {b} --levels 3 --quality quick" for b in ("merge", "expand")]
                      + ["molar --builder merge --levels 3 --quality quick", "molar --builder merge --levels 3 --quality quick --tolerance 1"]}
CASES["efforts of cover"] = CASES["default"] + ["molar", "probe", "molar --tolerance 0.3"]
CASES["efforts of published"] = CASES["published"] + [f"{mesh} --builder {b} --levels 3" for mesh in ("molar", "probe")
                                                     for b in ("merge", "expand")]
CASES["mesh"] = CASES["skin"]
CASES["medial"] = CASES["published"]
CASES["medial/refit_ball.h"] = CASES["default"] + CASES["published"]
for reducer in ("burst", "expand", "grid", "hubbard", "merge", "octree", "spawn"):
    CASES[f"published/reduce_{reducer}.cpp"] = [f"{mesh} --builder {reducer} --levels 3 --quality quick" for mesh in ("molar", "probe")]
CASES["published/reduce_octree.cpp"] += [f"{mesh} --builder octree --quality quick --tolerance {mm}" for mesh in ("molar", "probe")
                                         for mm in (1, 0.5, 0.2)]
CASES["published/octree_cells.cpp"] = CASES["published/reduce_octree.cpp"]


def rewritten(text, name, keep, fixed):
    """The source with each constant asking for its factor; `keep`: FILE:NAME that have to stay constant expressions;
    `fixed`: one of these and the factor that it is compiled with, or None."""
    def declaration(found):
        indent, storage, kind, rest = found.groups()
        parts = [part.strip() for part in re.split(r",\s*(?=k[A-Z]\w*\s*=)", rest)]
        names = [part.split("=")[0].strip() for part in parts]
        if fixed and len(names) == 1 and f"{name}:{names[0]}" == fixed[0]:
            return f"{indent}{storage}constexpr {kind} {names[0]} = static_cast<{kind}>(({parts[0].split('=', 1)[1].strip()}) * {fixed[1]});"
        if any(f"{name}:{n}" in keep or not re.fullmatch(r"k\w+", n) for n in names) or re.search(r"numeric_limits|0xffff", rest):
            return found.group(0)
        storage = storage.replace("static", "inline static") if "inline" not in storage else storage
        values = (f'{n} = varied<{kind}>("{name}:{n}", {part.split("=", 1)[1].strip()})' for n, part in zip(names, parts))
        return f"{indent}{storage}const {kind} {', '.join(values)};"

    def array(found):
        indent, kind, constant, values = found.groups()
        return f'{indent}inline const {kind} {constant} = variedEach<{kind}>("{name}:{constant}", {kind}{values});'
    if "struct Effort {" in text:
        text = EFFORT.sub(lambda found: f'.{found[1]} = varied<decltype(Effort::{found[1]})>("{name}:{found[1]}", {found[2]})', text)
    return ARRAY.sub(array, DECLARATION.sub(declaration, text))


def shortened(name):
    for folder, prefix in (("libspheretree/src/", ""), ("libruntime/runtime/src/", "runtime/")):
        if name.startswith(folder):
            return prefix + name.removeprefix(folder)
    return None


def make_copy(keep, fixed=None):
    constants = []
    for name in subprocess.run(["git", "ls-files"], cwd=ROOT, check=True, capture_output=True, text=True).stdout.splitlines():
        target = SOURCE / name
        target.parent.mkdir(parents=True, exist_ok=True)
        data = (ROOT / name).read_bytes() if (ROOT / name).is_file() else b""
        short = shortened(name)
        if short and name.endswith((".h", ".cpp")):
            text = rewritten(data.decode(), short, keep, fixed)
            constants += dict.fromkeys(re.findall(r'varied(?:Each)?<[^"]*>\("([^"]+)"', text))
            data = text.encode()
        if not target.exists() or target.read_bytes() != data:
            target.write_bytes(data)
            shutil.copymode(ROOT / name, target) if (ROOT / name).is_file() else None
    return constants


def build(targets):
    """Builds; constants that have to be constant expressions are left alone, as the compiler names them."""
    keep = set()
    WORK.mkdir(parents=True, exist_ok=True)
    (WORK / "varied.h").write_text(HEADER)
    launcher = ["-DCMAKE_CXX_COMPILER_LAUNCHER=ccache"] if shutil.which("ccache") else []
    for _ in range(12):
        constants = make_copy(keep)
        subprocess.run(["cmake", "-S", SOURCE, "-B", BUILD, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release", "-DSPHERETREE_TESTS=OFF",
                        f"-DCMAKE_CXX_FLAGS=-w -include {WORK}/varied.h", *launcher], check=True, stdout=subprocess.DEVNULL)
        run = subprocess.run(["ninja", "-k0", "-C", BUILD, *targets], capture_output=True, text=True)
        if run.returncode == 0:
            return constants, sorted(keep)
        found = {f"{shortened(path)}:{name}" for path, name in re.findall(
            r"((?:libspheretree|libruntime/runtime)/src/[\w/.]+):\d+:\d+: (?:error|note):[^\n]*?‘(?:[\w:{}]*::)?(k[A-Z]\w*)’", run.stdout)}
        found |= {c for c in constants for path, name in [c.split(":")]
                  if re.search(rf"/{re.escape(path.removeprefix('runtime/'))}:\d+:\d+: [^\n]*\n[^\n]*\b{name}\b", run.stdout)}
        if not found - keep:
            sys.exit(run.stdout[-3000:])
        keep |= found
    sys.exit("vary_constants: the copy cannot be built")


def read(path):
    """Points and faces of an OBJ file."""
    lines = path.read_text().splitlines()
    return ([[float(x) for x in l.split()[1:4]] for l in lines if l.startswith("v ")],
            [[int(word.split("/")[0]) - 1 for word in l.split()[1:]] for l in lines if l.startswith("f ")])


def write(path, points, faces):
    path.write_text("".join(f"v {x:.6f} {y:.6f} {z:.6f}\n" for x, y, z in points)
                    + "".join(f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in faces))


def broken_molars(folder):
    """broken: a molar with holes, a flipped patch and a doubled face. cracked: each face of a part has corners of its
    own, off by up to 2 um; fins stand on some edges; the tip is cut off. crossing: two molars in each other."""
    points, faces = read(folder / "molar.obj")
    write(folder / "broken.obj", points, [f[::-1] if 500 <= i < 520 else f for i, f in enumerate(faces) if i % 400 > 5] + [faces[40]])
    low = min(z for _, _, z in points)
    kept = [f for f in faces if max(points[v][2] for v in f) > low + 2]
    cracked, own = [p[:] for p in points], []
    for i, f in enumerate(kept):
        corners = f
        if i % 3 == 0:
            corners = list(range(len(cracked), len(cracked) + 3))
            cracked += [[x + 0.002 * (i % 100) / 100 * math.sin(7.1 * i + 3 * k + axis) for axis, x in enumerate(points[v])]
                        for k, v in enumerate(f)]
        own.append(corners)
        if i % 500 == 250:
            middle = [sum(points[v][axis] for v in f) / 3 for axis in range(3)]
            cracked.append([1.2 * x for x in middle])
            own.append([corners[0], corners[1], len(cracked) - 1])
    write(folder / "cracked.obj", cracked, own)
    count = len(points)
    write(folder / "crossing.obj", points + [[x + 3, y + 1, z] for x, y, z in points], faces + [[v + count for v in f] for f in faces])


def moved_molars(folder):
    """near and distant: the molar 12 and 24 diagonals from the origin."""
    points, faces = read(folder / "molar.obj")
    for name, by in (("near", 12), ("distant", 24)):
        write(folder / f"{name}.obj", [[x + by * 26, y, z] for x, y, z in points], faces)


def fine_molar(folder, name, cuts):
    """The molar with each triangle cut into four, `cuts` times, and new vertices off the surface by up to 2 um: a scan
    in need of fewer triangles."""
    points, faces = read(folder / "molar.obj")
    for _ in range(cuts):
        middles = {}

        def middle(a, b):
            key = (min(a, b), max(a, b))
            if key not in middles:
                middles[key] = len(points)
                noise = [0.002 * math.sin(12.9898 * len(points) + 78.233 * axis) for axis in range(3)]
                points.append([(points[a][axis] + points[b][axis]) / 2 + noise[axis] for axis in range(3)])
            return middles[key]

        faces = [f for a, b, c in faces for ab, bc, ca in [(middle(a, b), middle(b, c), middle(c, a))]
                 for f in ([a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca])]
    write(folder / f"{name}.obj", points, faces)


def figures(cases, variation, wing):
    """Error, bytes and processor time, summed. Error: the bound of the overhang of the leaves, but of a skin that of
    its distance."""
    error = size = 0.0
    environment = os.environ | {"SPHERETREE_VARY": variation}
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    for case in cases:
        words = case.split()
        evaluates = words[0] == "evaluate"
        mesh, *options = words[1:] if evaluates else words
        program, tree = BUILD / "tools/spheretree/spheretree", WORK / "tree.stree"
        for old in (tree, WORK / "report.json"):
            old.unlink(missing_ok=True)
        try:
            subprocess.run([program, "build", WORK / f"{mesh}.obj", "-o", tree, "-q", "--threads", "1", "--report", WORK / "report.json", *options],
                           env=environment, capture_output=True, timeout=300)
            report = json.loads((WORK / "report.json").read_text())
            error += report["skin"]["tolerance_mm"] + report["skin"]["mesh_distance_mm"] if wing == "skin" else report["levels"][-1]["overhang_bound_mm"]
            size += tree.stat().st_size
            if evaluates:
                run = subprocess.run([program, "evaluate", WORK / f"{mesh}.obj", tree, "--json", "--threads", "1"], env=environment,
                                     capture_output=True, text=True, check=True, timeout=300)
                error += json.loads(run.stdout)["levels"][-1]["overhang_mm"]["max"]
        except (OSError, subprocess.SubprocessError, ValueError, KeyError):
            return None
    return error, size, resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before


def split_figures(variation):
    """One and the crossing pairs of parts, the length of all borders of teeth [mm] and processor time."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    pairs, length = 1, 0.0
    for jaw in ("upper", "lower"):
        subprocess.run([BUILD / "tools/spheretree/spheretree", "split", WORK / f"scans/{jaw}.obj", "--labels", WORK / f"scans/{jaw}.json", "-o",
                        WORK / "split", "-q"], env=os.environ | {"SPHERETREE_VARY": variation}, capture_output=True, timeout=600)
        report = json.loads((WORK / "split/split.json").read_text())["jaws"][0]
        pairs += report["crossing_pairs"]
        length += sum(part["rim_length_mm"] for part in report["parts"] if part["label"] != 0)
    return pairs, length, resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before


def step_figures(variation):
    """Largest step of the force [N], 99.9th percentile of a step's processor time [us], processor time of the run; the
    least of three."""
    runs = []
    for _ in range(3):
        before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        run = subprocess.run([BUILD / "tools/haptic_player/haptic-player", WORK / "trees/scene.json", "--trajectory", WORK / "inspection.csv",
                              "--clock", "stepped", "--json"], env=os.environ | {"SPHERETREE_VARY": variation}, capture_output=True, text=True)
        if run.returncode != 0:
            return None
        summary = json.loads(run.stdout)
        runs.append((summary["wrench_step"]["force_n"], summary["time_us"]["processor"]["p99_9"],
                     resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before))
    return tuple(map(min, zip(*runs)))


def reports(variation, *words):
    """What a verb of the program says as JSON, and its processor time."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    run = subprocess.run([BUILD / "tools/spheretree/spheretree", *words, "--json", "-q"], env=os.environ | {"SPHERETREE_VARY": variation},
                         capture_output=True, text=True, timeout=600)
    return json.loads(run.stdout), resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before


def repair_figures(variation):
    """One and the lengths by which the steps change the surface [mm], the places they mend, and processor time."""
    length, places, time = 1.0, 1, 0.0
    for mesh, *options in (["broken"], ["cracked"], ["crossing"], ["broken", "--repair", "wrap"]):
        try:
            report, taken = reports(variation, "repair", WORK / f"{mesh}.obj", "-o", WORK / "repaired.ply", *options)
        except (ValueError, subprocess.SubprocessError):
            return None
        time += taken
        length += sum(step["change_mm"] for step in report["repair"]["steps"])
        places += sum(step["count"] for step in report["repair"]["steps"] if step["step"] != "cap_openings")
    return length, places, time


def check_figures(variation):
    """Thickness below which a twentieth is [mm], leaves of the first estimate, and processor time."""
    found = [reports(variation, "check", WORK / f"{mesh}.obj") for mesh in ("molar", "probe")]
    surveys = [report["survey"] for report, _ in found]
    return (sum(s["thickness_mm"]["p05"] for s in surveys), sum(s["leaf_estimates"][0]["leaves"] for s in surveys),
            sum(taken for _, taken in found))


FIGURES = {"runtime": step_figures, "split": split_figures, "repair": repair_figures, "measure/mesh_survey.cpp": check_figures}


def key_of(constant):
    """The entry of FIGURES or CASES for FILE:NAME."""
    file, name = constant.split(":")
    candidates = (constant, file, file.split("/")[0])
    if not name.startswith("k"):
        return f"efforts of {candidates[-1]}"
    return next((key for key in candidates if key in FIGURES or key in CASES), "default")


def measured(variation, key):
    return FIGURES[key](variation) if key in FIGURES else figures(CASES[key], variation, key)


def sentence(half, twice):
    """What a row of docs/constants.md says: `half` and `twice` are rows of figures.csv."""
    if any("failed" in found for found in (half, twice)):
        return "; ".join(f"{name}: " + ("no tree" if "failed" in found else f"overhang {float(found['error']):.3f}, time {float(found['time']):.2f}")
                         for name, found in (("Half", half), ("twice", twice)))
    error, size, time = ([float(found[key]) for found in (half, twice)] for key in ("error", "bytes", "time"))
    if error == size == [1, 1]:
        return f"No effect on the overhang in these cases; time {time[0]:.2f} and {time[1]:.2f}"
    said = f"Half: overhang {error[0]:.3f}, time {time[0]:.2f}; twice: overhang {error[1]:.3f}, time {time[1]:.2f}"
    return said + (f"; bytes {size[0]:.3f} and {size[1]:.3f}" if any(abs(value - 1) >= 0.0005 for value in size) else "")


def update_rows():
    """Puts the figures of figures.csv into docs/constants.md."""
    page = ROOT / "docs/constants.md"
    lines = page.read_text(encoding="utf-8").split("\n")
    found = {}
    with (WORK / "figures.csv").open(encoding="utf-8") as file:
        for row in csv.DictReader(file):
            found.setdefault(row["constant"], []).append({"failed": 1} if row["error"] == "failed" else row)
    section = ""
    for number, line in enumerate(lines):
        if line.startswith("### `"):
            section = shortened(line.strip("# `"))
        cells = re.findall(r"`([^`]+)`", line) if line.startswith("| `") else []
        if not cells:
            continue
        key = f"{shortened(cells[0])}:{cells[1]}" if "/" in cells[0] else f"{section}:{cells[0]}"
        begin = re.search(r"(Half: (overhang|no tree)|No effect on the overhang)", line)
        if key in found and begin:
            lines[number] = f"{line[:begin.start()]}{sentence(*found.pop(key))} |"
    page.write_text("\n".join(lines), encoding="utf-8")
    print("without figures of the overhang in docs/constants.md:", ", ".join(found) or "none")


def main():
    patterns = [word for word in sys.argv[1:] if word != "--update"] or ["*"]
    player = ["haptic-player"] if any(p.startswith(("runtime/", "*")) for p in patterns) else []
    splits = ["make_scans"] if any(p.startswith(("split/", "*")) for p in patterns) else []
    asking, kept_all = build(["spheretree", "make_samples", *splits, *player])
    constants, kept = ([c for c in of if any(fnmatch.fnmatch(c, pattern) for pattern in patterns)] for of in (asking, kept_all))
    samples = BUILD / "samples/make_samples/make_samples"
    subprocess.run([samples, WORK], check=True, stdout=subprocess.DEVNULL)
    if splits:
        subprocess.run([BUILD / "samples/make_scans/make_scans", WORK / "scans", "edge=0.5", "noise=0.04", "seed=11", "jagged"], check=True,
                       stdout=subprocess.DEVNULL)
    if player:
        subprocess.run([samples, "--mouth", WORK], check=True, stdout=subprocess.DEVNULL)
        subprocess.run([BUILD / "tools/spheretree/spheretree", "batch", WORK / "mouth.scene.json", "-o", WORK / "trees", "-q", "--quality", "quick"],
                       check=True)
    broken_molars(WORK)
    moved_molars(WORK)
    fine_molar(WORK, "fine", 2)
    fine_molar(WORK, "finest", 3)
    base = {}
    with (WORK / "figures.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["constant", "factor", "error", "bytes", "time"])
        for constant in constants + kept:
            key = key_of(constant)
            if key not in base:
                base[key] = measured("", key)
            for factor in (0.5, 2):
                if constant in kept:  # it has to be compiled with its factor
                    make_copy(set(kept_all), (constant, factor))
                    subprocess.run(["ninja", "-C", BUILD, "spheretree", *player], check=True, stdout=subprocess.DEVNULL)
                found = measured(f"{constant}={factor}", key)
                row = [f"{a / b:.4f}" for a, b in zip(found, base[key])] if found and base[key] else ["failed"] * 3
                writer.writerow([constant, factor, *row])
                file.flush()
    print(f"{len(constants + kept)} constants: {WORK}/figures.csv")
    if "--update" in sys.argv:
        update_rows()


if __name__ == "__main__":
    main()
