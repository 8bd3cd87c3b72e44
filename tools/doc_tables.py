#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""tools/doc_tables.py BUILD [--update] [--slow] [NAME...]: figures of the documentation, made by the programs of BUILD.

Between the lines `<!-- table: NAME -->` and `<!-- end of table -->` of README.md and docs/ stands what a function of
this file prints. They are made anew and compared; a difference ends with exit code 1. Times, and numbers of steps that
were late, are not compared. With --update they are written into the pages, times too. Tables that take minutes are left
out unless --slow is given or they are named, and so are those of meshes that are not there. The test
`install.doc_tables` runs the others. A table that cannot be made does not stop the others. The table of
docs/stability.md has a script of its own, stability_table.py, since `haptic-player --scenario all` takes long."""
import argparse
import csv
import difflib
import functools
import json
import math
import os
import re
import resource
import statistics
import struct
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from vary_constants import fine_molar

ROOT = Path(__file__).resolve().parents[1]
BEGIN, END = re.compile(r"<!-- table: (\w+) -->"), "<!-- end of table -->"
TIME = re.compile(r"\b\d+(\.\d+)?((, | to | / )\d+(\.\d+)?)* (s|us|ms|Hz|steps|times)\b")


MODES = ["paper", "constrained", "points", "volume", "continuous"]


class Failure(Exception):
    """A table cannot be made; why."""


def output(*command, codes=(0,), **more):
    """What a command prints."""
    words = [str(word) for word in command]
    done = subprocess.run(words, capture_output=True, text=True, **more)
    if done.returncode not in codes:
        raise Failure(f"{' '.join(words)}: exit code {done.returncode}\n{done.stderr}")
    return done.stdout


class Programs:
    """The programs of a build, and one folder that the tables share."""

    def __init__(self, build, folder):
        self.build, self.folder = Path(build).resolve(), Path(folder)

    def run(self, name, *arguments, codes=(0,)):
        places = {"spheretree": "tools/spheretree", "haptic-player": "tools/haptic_player", "load_benchmark": "tests",
                  "node_pairs": "tests", "qp_benchmark": "tests", "step_benchmark": "tests",
                  "make_samples": "samples/make_samples", "make_scans": "samples/make_scans"}
        return output(self.build / places[name] / name, *arguments, codes=codes, cwd=self.folder)

    def foreign(self):
        """The folder of meshes that are not part of the repository."""
        found = re.search(r"^SPHERETREE_SHARED_DIR:PATH=(.*)$", (self.build / "CMakeCache.txt").read_text(), re.MULTILINE)
        return Path(found.group(1)) / "meshes" if found else ROOT.parent / "shared/meshes"

    def samples(self):
        if not (self.folder / "molar.obj").exists():
            self.run("make_samples", ".")

    def mouth(self):
        if not (self.folder / "mouth").exists():
            self.run("make_samples", "--mouth", "mouth")

    def batch(self, scene, out, *arguments):
        self.run("spheretree", "batch", scene, "-o", out, "--cache", "cache", "-q", *arguments, codes=(0, 5))
        return json.loads((self.folder / out / "report.json").read_text())


def processor_time():
    """Of the programs that have run so far [s]."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def short(value):
    """Two significant digits, without an exponent above 1."""
    rounded = float(f"{value:.2g}")
    return f"{rounded:,.0f}" if abs(rounded) >= 10 else f"{rounded:g}"


def molar_build(programs):
    """What `build` prints for the sample molar."""
    programs.samples()
    text = programs.run("spheretree", "build", "molar.obj", "-o", "tooth.stree")
    text = re.sub(r"( s): .*", r"\1", text)  # which stages are named depends on the machine
    return ["    " + line for line in text.rstrip().splitlines()]


def readme_times(programs):
    """What takes how long."""
    programs.samples()
    programs.mouth()

    def seconds(*arguments):
        begin = time.perf_counter()
        programs.run("spheretree", *arguments, "-q", codes=(0, 5))
        return f"{time.perf_counter() - begin:.2g} s"

    one = {quality: seconds("build", "molar.obj", "-o", "timed.stree", "--quality", quality, "--threads", "1") for quality in ("quick", "standard", "best")}
    fine_molar(programs.folder, "fine", 4)
    count = json.loads(programs.run("spheretree", "check", "fine.obj", "--json"))["triangles"]
    mouth = ["batch", "mouth/mouth.scene.json", "-o", "timed_mouth", "--quality", "standard"]
    clock = real_time_run(programs)["time_us"]["total"]
    return ["| what | time |", "|---|---|",
            "| this molar, 512 leaves, one processor | " + ", ".join(f"`{quality}` {found}" for quality, found in one.items()) + " |",
            f"| {count:,} triangles (the molar, divided like a fine scan), 512 leaves | {seconds('build', 'fine.obj', '-o', 'timed.stree')} |",
            f"| a mouth of 33 objects, 512 leaves each, `standard` | {seconds(*mouth)}; {seconds(*mouth)} if nothing has changed |",
            f"| a haptic step along all teeth of that mouth: median, 99th percentile | {clock['median']:.1f}, {clock['p99']:.0f} us |"]


def mouth_parts(programs):
    """Triangles of the parts of the sample mouth."""
    programs.mouth()
    parts = json.loads(programs.run("spheretree", "check", "mouth/mouth.obj", "--list-parts", "--json", codes=(0, 4)))["part_list"]
    count = {part["name"]: part["triangles"] for part in parts}
    probe = json.loads(programs.run("spheretree", "check", "mouth/probe.obj", "--json"))["triangles"]
    teeth = sorted(name for name in count if name.startswith("tooth_"))
    sizes = sorted({count[name] for name in teeth})
    rows = [(f"{len(teeth)} teeth, `{teeth[0]}` .. `{teeth[-1]}` (FDI): incisors, canines, premolars, molars, upper and lower in their sizes",
             f"{sizes[0]:,} each" if len(sizes) == 1 else f"{sizes[0]:,} to {sizes[-1]:,}"),
            ("`lower_jaw`, `upper_jaw`: ridge and gum, the gum higher between the teeth", f"{count['lower_jaw']:,} each"),
            ("`tongue`", f"{count['tongue']:,}"), ("`face`, with the open mouth", f"{count['face']:,}"), ("`probe`, the tool", f"{probe:,}")]
    return ["| part | triangles |", "|---|---|", *(f"| {part} | {triangles} |" for part, triangles in rows)]


def graded_scene(programs, quality, graded):
    """The sample mouth with the tolerances of docs/batch.md, or without any, at a quality."""
    scene = json.loads((programs.folder / "mouth/mouth.scene.json").read_text())
    scene.setdefault("defaults", {})["quality"] = quality
    if graded:
        scene["defaults"]["tolerance_mm"] = 0.2
        scene["work"] = [{"name": "pocket 46", "sphere": {"centre_mm": [-26.07, 15.96, -2.3], "radius_mm": 3}, "tolerance_mm": 0.05}]
        scene["reach"] = {"radius_mm": 0.1, "tolerance_mm": 1.0}
    name = f"mouth/{quality}_{'graded' if graded else 'whole'}.scene.json"
    (programs.folder / name).write_text(json.dumps(scene))
    return name


def mouth_leaves(programs):
    """Leaves of the sample mouth with the whole budget and with tolerances; the overhang at the site, the gum and
    everywhere."""
    programs.mouth()
    lines = ["| | leaves | largest overhang bound: tooth 46 | gum | whole mouth |", "|---|---|---|---|---|"]
    for quality in ("standard", "quick"):
        whole = None
        for graded in (False, True):
            report = programs.batch(graded_scene(programs, quality, graded), f"out_{quality}_{graded}")
            objects = {entry["name"]: entry for entry in report["objects"]}
            bound = {name: entry["levels"][-1]["overhang_mm"]["bound"] for name, entry in objects.items()}
            site = {name: {w["name"]: w["overhang_bound_mm"] for w in objects[name].get("work", [])} for name in ("tooth_46", "lower_jaw")}
            leaves = sum(entry["leaves"] for entry in objects.values())
            whole = whole or leaves
            less = f" ({100 * (whole - leaves) / whole:.0f} % fewer)" if graded else ""
            at = [min([*site[name].values(), bound[name]]) for name in ("tooth_46", "lower_jaw")]
            title = f"`{quality}`, with the tolerances above" if graded else f"`{quality}`, the whole budget"
            lines.append(f"| {title} | {leaves:,}{less} | {at[0]:.3f} mm | {at[1]:.3f} mm | {max(bound.values()):.2f} mm |")
    return lines


def mouth_budget(programs):
    """The sample mouth at `quick` with the whole budget and with 6,000 leaves."""
    programs.mouth()
    lines = ["| | leaves | largest overhang bound |", "|---|---|---|"]
    for title, arguments in (("512 leaves for each object", []), ("`--budget 6000`", ["--budget", "6000"])):
        report = programs.batch(graded_scene(programs, "quick", False), f"out_budget_{len(arguments)}", *arguments)
        worst = max(report["objects"], key=lambda entry: entry["levels"][-1]["overhang_mm"]["bound"])
        leaves = sum(entry["leaves"] for entry in report["objects"])
        lines.append(f"| {title} | {leaves:,} | {worst['levels'][-1]['overhang_mm']['bound']:.2f} mm, at `{worst['name']}` |")
    return lines


SCANS = [("edge=0.2",), ("edge=0.3", "noise=0.02"), ("edge=0.3", "noise=0.05"), ("edge=0.25", "noise=0.03", "crowding=0.6", "supernumerary", "seed=21"),
         ("edge=0.3", "noise=0.05", "seed=7"), ("edge=0.3", "noise=0.02", "seed=3", "jagged", "holes=6"), ("edge=0.4", "noise=0.06", "jagged", "holes=6"),
         ("edge=0.5", "noise=0.05", "jagged")]


def split_scans(programs):
    """What `split` makes of synthetic scans: area kept, parts that cross another, vertices moved, processor time."""
    lines = ["| scan | triangles | processor time | area kept | moved at most | parts that cross another | pairs |", "|---|---|---|---|---|---|---|"]
    for number, settings in enumerate(SCANS):
        programs.run("make_scans", f"scans{number}", *settings)
        for side in ("lower", "upper"):
            scan, out = f"scans{number}/{side}.obj", f"split{number}_{side}"
            begin = processor_time()
            programs.run("spheretree", "split", scan, "--labels", f"scans{number}/{side}.json", "-o", out, "-q", codes=(0, 5))
            seconds = processor_time() - begin
            jaw = json.loads((programs.folder / out / "split.json").read_text())["jaws"][0]
            with (programs.folder / scan).open() as file:
                triangles = sum(line.startswith("f ") for line in file)
            crossing = sum(part["crossing_pairs"] > 0 for part in jaw["parts"])
            lines.append(f"| `{' '.join(settings)}`, {side} | {triangles:,} | {seconds:.0f} s | "
                         f"{100 * (1 - jaw['lost_area_mm2'] / jaw['scan_area_mm2']):.3f} % | {jaw['largest_move_mm']:.2f} mm | "
                         f"{crossing} of {len(jaw['parts'])} | {jaw['crossing_pairs']} |")
    return lines


def split_margin(programs):
    """Distances of the cut from the true margin, over both jaws and three seeds, as the test of the cut prints them."""
    rows = {}
    for edge, labels in printed_by(programs, "split_test", "CutLabels.Is*", r"^margin, edge ([\d.]+), (.*)$", SPHERETREE_LONG="1"):
        for name, *found in re.findall(r"; ([a-z ]+) ([\d.]+) ([\d.]+) ([\d.]+) ([\d.]+) ([\d.]+)", labels):
            rows.setdefault((name, edge), []).append([float(value) for value in found])
    lines = ["| labels | mean edge | within half of the edge | mean | 99 % | at most | in space, at most |", "|---|---|---|---|---|---|---|"]
    for (name, edge), found in sorted(rows.items()):
        within, *distances = zip(*found)
        lines.append(f"| {name} | {edge} mm | {100 * min(within):.1f} % | " + " | ".join(f"{max(values):.2f} mm" for values in distances) + " |")
    return lines


def tissue(programs, *meshes):
    """What benchmarks/tissue.py prints: a table of overhangs for each mesh, and one of forces and times."""
    text = output(ROOT / "benchmarks/tissue.py", programs.build, *meshes, cwd=programs.folder)
    return [table.strip().split("\n") for table in text.split("\n\n")]


def tissue_overhang(programs):
    programs.mouth()
    return tissue(programs, "mouth/mouth.obj:tongue")[0]


def tissue_figures(programs):
    return tissue(programs)[-1]


def play(programs, scene, path, *arguments):
    """Summary of a run of the player, and the rows of its recording."""
    text = programs.run("haptic-player", scene, "--trajectory", path, "--json", "--record", "run.csv", *arguments)
    with open(programs.folder / "run.csv", encoding="utf-8") as file:
        return json.loads(text), list(csv.DictReader(file))


@functools.cache
def real_time_run(programs):
    """Summary of a run in the sample mouth on the real clock, along the inspection and back."""
    programs.mouth()
    programs.batch("mouth/mouth.scene.json", "mouth_trees", "--quality", "standard")
    header, *poses = (programs.folder / "mouth/inspection.csv").read_text().splitlines()
    there_and_back = [pose.split(",", 1)[1] for pose in poses + poses[::-1]]
    timed = [f"{step / 1000:.3f},{pose}" for step, pose in enumerate(there_and_back)]
    (programs.folder / "minute.csv").write_text("\n".join([header, *timed]) + "\n")
    return play(programs, "mouth_trees/scene.json", "minute.csv", "--clock", "real")[0]


def mouth_real_time(programs):
    run = real_time_run(programs)
    clock, over = run["time_us"]["total"], run["steps_over_ms"]
    return ["| what | found |", "|---|---|",
            f"| steps | {run['steps']:,} |",
            f"| time of a step: median, p99, p99.9 | {clock['median']:.1f}, {clock['p99']:.0f}, {clock['p99_9']:.0f} us |",
            f"| longest step | {clock['max']:.0f} us |",
            f"| steps over 1 ms by processor time | {over['processor']} |",
            f"| steps over 1 ms by the clock, and steps that began more than a period late | {over['clock']}, {run['missed_deadlines']} steps |",
            f"| rows of the recording that were lost | {run['recording']['rows_lost']} |",
            f"| largest penetration | below {10.0 ** math.ceil(math.log10(max(run['largest_penetration_mm'], 1e-9))):.0e} mm |"]


def mouth_load(programs):
    """Time to load the trees of the sample mouth, and the memory of the compiled scene."""
    programs.mouth()
    programs.batch("mouth/mouth.scene.json", "mouth_trees", "--quality", "standard")
    text = programs.run("load_benchmark", 20, *sorted((programs.folder / "mouth_trees").glob("*.stree")))
    files, size, scene = re.match(r"(\d+) files of (\d+) bytes, a scene of (\d+) bytes", text).groups()
    median = {part: re.search(rf"^{part} +median +([\d.]+) ms", text, re.MULTILINE).group(1) for part in ("read", "decode", "compile", "all")}
    return ["| files | size of all files | compiled scene | reading | checks and decoding | compiling | all |", "|---|---|---|---|---|---|---|",
            f"| {files} | {int(size) / 1e6:.1f} MB | {int(scene) / 1e6:.0f} MB | {median['read']} ms | {median['decode']} ms | {median['compile']} ms | {median['all']} ms |"]


def soft_mouth(programs):
    """The probe presses the tongue of the sample mouth, with large and with small motion."""
    programs.mouth()
    programs.batch("mouth/soft.scene.json", "soft_trees", "--quality", "standard")
    columns = []
    for motion in ("large", "small"):
        run, steps = play(programs, "soft_trees/scene.json", "mouth/press.csv", "--clock", "stepped", "--seconds", "2.7", "--tissue", motion)
        force = [math.hypot(*(float(step[axis]) for axis in ("fx_n", "fy_n", "fz_n"))) for step in steps]
        held = statistics.mean(force[1000:1500])  # the hand holds still from 0.6 to 1.5 s
        times = sorted(float(step["total_us"]) for step in steps if step["touched"])
        columns.append((f"{held:.3f} N", f"{max(force):.3f} N", f"{run['wrench_step']['force_n']:.3f} N", f"{run['largest_penetration_mm']:.4f} mm",
                        f"{times[len(times) // 2]:.0f}, {times[len(times) * 99 // 100]:.0f} us"))
    names = ("force once the hand holds still", "largest force", "largest step of the force", "largest penetration", "step in contact: median, p99")
    return ["| | `--tissue large` | `--tissue small` |", "|---|---|---|", *(f"| {name} | {large} | {small} |" for name, large, small in zip(names, *columns))]


def simplified_molar(programs):
    """The molar with a million triangles, built on a simplified mesh and on all of them."""
    programs.samples()
    fine_molar(programs.folder, "fine", 4)
    lines = ["| | processor time | memory | triangles | distance [mm] | overhang of the leaves [mm] |", "|---|---|---|---|---|---|"]
    for title, option in (("simplified", []), ("every triangle", ["--no-simplify"])):
        command = [programs.build / "tools/spheretree/spheretree", "build", "fine.obj", "-o", "fine.stree", "--report", "fine.json", "-q", *option]
        child = subprocess.Popen(command, cwd=programs.folder, stdout=subprocess.DEVNULL)
        _, status, used = os.wait4(child.pid, 0)
        if status:
            raise Failure(f"{' '.join(map(str, command))} failed")
        report = json.loads((programs.folder / "fine.json").read_text())
        mesh = report["simplification"] or {"triangles": report["mesh"]["triangles"], "distance_bound_mm": 0}
        lines.append(f"| {title} | {used.ru_utime + used.ru_stime:.0f} s | {used.ru_maxrss / 1e6:.2f} GB | {mesh['triangles']:,} | "
                     f"{mesh['distance_bound_mm']:.2g} | {report['levels'][-1]['overhang_bound_mm']:.3f} |")
    return lines


def step_times(programs):
    """Times of steps in the mouth of the benchmark, paced at 1 kHz [us]."""
    text = programs.run("step_benchmark")
    found = {(case, pairs): [float(word) for word in times.split()]
             for case, pairs, times in re.findall(r"^(\w+) (\d+) paced [^|]*\|([^|]*)\|", text, re.MULTILINE)}
    lines = ["| pairs at the haptic pose | paper: median / p99 | constrained, on leaves: median / p99 / max |", "|---|---|---|"]
    for pairs in ("150", "2000", "5000"):
        paper, leaves = found["paper", pairs], found["leaves", pairs]
        lines.append(f"| {pairs} | {' / '.join(map(short, paper[:2]))} us | {' / '.join(short(leaves[column]) for column in (0, 1, 3))} us |")
    return lines


def qp_times(programs):
    """Times of the QP alone, median / p99 [us]."""
    text = programs.run("qp_benchmark")
    cell = r"([\d.]+ / [\d.]+) / [\d.]+"
    found = {(family, rows): times for family, rows, *times in
             re.findall(rf"^(slide|slot) +(\d+) [^|]*\| {cell} +{cell} +(?:{cell}|-)", text, re.MULTILINE)}
    lines = ["| rows | slide, warm | slide, cold | slot, warm | slot, cold | quadprog, slide | quadprog, slot |", "|---|---|---|---|---|---|---|"]
    for rows in ("150", "500", "2000"):
        slide, slot = found["slide", rows], found["slot", rows]
        times = [" / ".join(short(float(value)) for value in pair.split(" / ")) + " us" if pair else "" for pair in (*slide[:2], *slot[:2], slide[2], slot[2])]
        lines.append(f"| {rows} | {' | '.join(times)} |")
    return lines


@functools.cache
def renderer_rows(programs):
    """The table of the page that compares the renderers: name, body, leaves, and the figures from the time of a step to
    the stand-off, as the head of that table names them."""
    programs.run("haptic-player", "--scenario", "F7", "--modes", ",".join(MODES), "--share", "0.01", "--quality", "quick", "--cache", "player_trees",
                 "--chart", "renderers.html", codes=(0, 5))
    rows = [re.findall(r"([^<>]+)</t[hd]>", row)
            for row in re.findall(r"<tr><th scope=\"row\">(.*)</tr>", (programs.folder / "renderers.html").read_text(encoding="utf-8"))]
    names = ("memory", "step", "step_p99", "force", "force_p99", "angle", "angle_p99", "penetration", "stand_off")
    return [(row[0], row[1], int(row[2]), dict(zip(names, map(float, row[3:])))) for row in rows if len(row) == 12]


def renderer_means(programs):
    """Geometric means over the bodies of the 99th percentiles of all renderers."""
    sizes = (64, 512, 4096)
    lines = [f"| memory of our trees of | {sizes[0]} leaves | " + " | ".join(f"{size:,}" for size in sizes[1:]) + " |", "|---|---|---|---|"]
    for mode in MODES:
        cells = []
        for size in sizes:
            found = [row for name, _, leaves, row in renderer_rows(programs) if name.split()[0] == mode and "leaves" not in name and leaves == size]
            time, force, depth = (short(statistics.geometric_mean(max(row[figure], 1e-5) for row in found)) for figure in ("step_p99", "force_p99", "penetration"))
            cells.append(f"{time} us, {force} N, {depth} mm")
        lines.append(f"| `{mode}` | {' | '.join(cells)} |")
    return lines


def cutting_renderers(programs):
    """Cutting beside drilling in voxels: on a block, and in the sample cavity."""
    if not (programs.folder / "cavity_trees").exists():
        programs.run("make_samples", "--cavity", "cavity")
        programs.run("spheretree", "batch", "cavity/cavity.scene.json", "-o", "cavity_trees", "-q")
    rows = []
    for words in ([], ["cavity_trees", "--trajectory", "cavity/drill.csv"]):
        rows += json.loads(programs.run("haptic-player", *words, "--compare-cutting", "--json"))["rows"]
    lines = ["| course, renderer | largest force | its change in a step: largest, p99, beyond the hand | removed, swept | torque | step: median / p99 | memory |",
             "|---" * 7 + "|"]
    for row in rows:
        changes, swept, times = row["force_change_n"], row["swept_mm3"], row["time_us"]
        lines.append(f"| {row['course'].replace('drill.csv', 'cavity')}, `{row['renderer']}` | {short(row['largest_force_n'])} N | "
                     + ", ".join(short(1000 * changes[name]) for name in ("largest", "p99", "beyond_hand"))
                     + f" mN | {row['removed_mm3']:.3g}, {(swept['low'] + swept['high']) / 2:.3g} mm³ | "
                     + (f"{short(row['largest_torque_nmm'])} N mm" if row["largest_torque_nmm"] > 1e-6 else "none")
                     + f" | {short(times['median'])} / {short(times['p99'])} us | {short(row['memory_bytes'] / 1e6)} MB |")
    return lines


def tool_models(programs):
    """Tools of leaves and of hulls beside the exact answer for their meshes."""
    lines = ["| tool, body | model | parts | step: median / p99 | angle [degree] | torque [N mm] | stand-off [mm] | L-ratio: p99, largest |", "|---" * 8 + "|"]
    for row in json.loads(programs.run("haptic-player", "--compare-tools", "mirror,bur,sphere,groove,side", "--cache", "tool_trees", "--json"))["rows"]:
        cells = [f"{row['tool']}, {row['body']}", row["model"]]
        if "parts" in row:
            times, angle = row["time_us"], row["angle_deg"]
            cells += [f"{row['parts']:,}", f"{short(times['median'])} / {short(times['p99'])} us", f"{short(angle['median'])} / {short(angle['p99'])}",
                      short(row["torque_error_nmm"]), short(row["stand_off_mm"])]
        else:
            cells += [""] * 5
        lines.append("| " + " | ".join(cells + [f"{short(row['l_ratio']['p99'])}, {short(row['l_ratio']['largest'])}"]) + " |")
    return lines


def molar_felt(programs):
    """What a ball feels around the crown of a molar, on leaves and on the skin."""
    found = {(name, leaves): row for name, body, leaves, row in renderer_rows(programs) if "molar" in body and name.startswith("constrained")}

    def cell(name, leaves):
        row = found[name, leaves]
        return f"{short(row['angle'])} / {short(row['angle_p99'])}, {short(row['stand_off'])}"

    lines = ["| leaves | on leaves: angle, median / p99 [degree], stand-off, p99 [mm] | on the skin |", "|---|---|---|"]
    return lines + [f"| {leaves} | {cell('constrained, on leaves', leaves)} | {cell('constrained', leaves)} |" for leaves in (8, 64, 512, 4096)]


def molar_leaves(programs):
    """Leaves of a molar against overhang and the time of a step, on leaves and on the skin."""
    figures = []
    for contact in ("leaves", "skin"):
        programs.run("haptic-player", "--scenario", "F22", "--modes", "constrained", "--quality", "quick", "--cache", "player_trees", "--contact", contact,
                     "--turned", "0", "--threads", "1", "--out", f"stability_{contact}", codes=(0, 5))
        scenario = json.loads((programs.folder / f"stability_{contact}/stability.json").read_text())["scenarios"][0]
        figures.append({figure["quantity"]: figure["results"]["constrained"] for figure in scenario["figures"]})
    leaves = figures[0]
    lines = ["| leaves | overhang [mm] | by leaves: pairs, median | by leaves: step, median / p99 | on the skin: step, median / p99 |", "|---|---|---|---|---|"]
    for count in (8, 64, 512, 4096):
        of = f" on a molar of {count} leaves"
        times = [" / ".join(short(found[f"processor time of a step, {part},{of}"]) for part in ("median", "p99")) + " us" for found in figures]
        lines.append(f"| {count} | {leaves['overhang' + of]:.2g} | {leaves['pairs, median,' + of]:.0f} | {' | '.join(times)} |")
    return lines


def renderer_scenarios(programs):
    """How many scenarios each renderer holds: of all in which it takes part, with a hundredth of the repetitions."""
    programs.run("haptic-player", "--scenario", "all", "--modes", ",".join(MODES), "--share", "0.01", "--quality", "quick", "--turned", "0",
                 "--cache", "player_trees", "--out", "renderers", codes=(0, 5))
    scenarios = json.loads((programs.folder / "renderers/stability.json").read_text())["scenarios"]
    lines = ["| scenarios that hold, of those that a renderer takes part in | " + " | ".join(MODES) + " |", "|---" * (len(MODES) + 1) + "|"]
    for letter, title in (("F", "along a path"), ("S", "a hand in closed loop")):
        verdicts = [scenario["verdicts"] for scenario in scenarios if scenario["id"].startswith(letter)]
        found = [[verdict[mode] for verdict in verdicts if mode in verdict] for mode in MODES]
        lines.append(f"| {letter}1 to {letter}{len(verdicts)}, {title} | " + " | ".join(f"{row.count('holds')} of {len(row)}" for row in found) + " |")
    return lines


def printed_by(programs, test, cases, pattern, **environment):
    """What a test program prints that matches the pattern."""
    printed = output(programs.build / "tests" / test, f"--gtest_filter={cases}", env=os.environ | environment)
    found = re.findall(pattern, printed, re.MULTILINE)
    if not found:
        raise Failure(f"{test} --gtest_filter={cases} prints no line as {pattern}")
    return found


def skin_errors(programs):
    """Errors of flat triangles and of patches, as the test of the skin prints them."""
    found = printed_by(programs, "builder_test", "BuildSkin.*Round*", r"^skin of a (.*); (\d+); (\S+) mm flat, (\S+) mm, (\S+) degrees$")
    lines = ["| mesh | flat triangles: position [mm] | patches: position [mm] | normal [degrees] |", "|---|---|---|---|"]
    for what, triangles, *errors in sorted(found, key=lambda row: (row[0], int(row[1]))):
        lines.append(f"| {what}, {int(triangles):,} triangles | " + " | ".join(short(float(error)) for error in errors) + " |")
    return lines


def passivity(programs):
    """Walls without and with passivity control, as the test of the controller prints them."""
    found = printed_by(programs, "device_test", "PassivityControl.TakesSwing*",
                       r"^wall of (\d) N/mm, (\d) late, (\w+) +off: +(\S+) N +(\S+) mJ, on: +(\S+) N +(\S+) mJ$")
    lines = ["| wall, delay | hand | off: swing, energy | on: swing, energy |", "|---|---|---|---|"]
    for stiffness, late, hand, *figures in found:
        off, on = (f"{float(swing):.2g} N, {round(float(energy))} mJ" for swing, energy in (figures[:2], figures[2:]))
        lines.append(f"| {stiffness} N/mm, {late} step{'s' if late != '1' else ''} | {hand} | {off} | {on} |")
    return lines


def quiet_walls(programs):
    """The stiffest quiet walls at each delay, stated and measured, as the tests of the simulated device print them."""
    found = {}
    for hand, friction, measured, unit, stated in printed_by(
            programs, "device_test", "SimulatedDevice.*Restless*",
            r"^quiet up to (?:(\w+) +)?d=\d(?: (with\w*) Coulomb friction)?: +(\S+) (N/mm|N m/rad), stated +(\S+)$"):
        found.setdefault(f"{hand or 'about an axis, ' + friction + ' Coulomb friction'} [{unit}]", []).append(f"{float(stated):g} | {float(measured):.3g}")
    lines = ["| hand | " + " | ".join(f"d = {late}: stated | measured" for late in range(3)) + " |", "|---" * 7 + "|"]
    return lines + [f"| {name} | {' | '.join(cells)} |" for name, cells in found.items()]


FELT = [("molar of 1,680 triangles", "dental/tooth_FDI36_molar.stl", ["--smooth"]), ("the same, irregular triangles",
         "dental/tooth_FDI36_molar.stl", ["--smooth", "--irregular", "0.3"]),
        ("canine of 752", "dental/tooth_FDI23_canine.stl", ["--smooth"]), ("molar of 15,680", "toolkit/tooth.obj", ["--smooth"]),
        ("the sample molar, 16,656", "molar.obj", ["--smooth"]), ("cow of 11,712", "bench/organic_spot.obj", ["--smooth"]),
        ("CAD fandisk, against the mesh", "bench/cad_fandisk.obj", [])]


def as_obj(stl, obj):
    """A binary STL as OBJ, corners in one place joined."""
    data = stl.read_bytes()
    corners = [struct.unpack_from("<3f", data, 84 + 50 * triangle + 12 * corner) for triangle in range((len(data) - 84) // 50) for corner in (1, 2, 3)]
    index = {corner: number for number, corner in enumerate(dict.fromkeys(corners), 1)}
    faces = [[index[corner] for corner in corners[first:first + 3]] for first in range(0, len(corners), 3)]
    obj.write_text("".join(f"v {x:.9g} {y:.9g} {z:.9g}\n" for x, y, z in index) + "".join(f"f {a} {b} {c}\n" for a, b, c in faces))
    return obj


def felt_meshes(programs):
    """What is felt on real meshes, by the independent program that measures it."""
    programs.samples()
    feel = programs.foreign().parent / "feel/feel.py"
    if not feel.is_file():
        raise Failure(f"no {feel}, the program that measures what is felt")
    lines = ["| mesh | angle, median / p99 [degree] | stand-off, p1 to p99 [mm] | jump [N] |", "|---|---|---|---|"]
    for title, name, options in FELT:
        mesh = programs.folder / name if name == "molar.obj" else programs.foreign() / name
        mesh = as_obj(mesh, programs.folder / "felt.obj") if mesh.suffix == ".stl" else mesh
        command = ["/usr/bin/python3", feel, programs.build / "tools/spheretree/spheretree", programs.build / "tools/haptic_player/haptic-player", mesh,
                   programs.folder / "felt", "--modes", "--mode constrained", *options]  # the python of the system has its packages
        row = json.loads(output(*command).splitlines()[-1])
        angle, stand_off = row["angle_deg"], row["stand_off_mm"]
        lines.append(f"| {title} | {angle['median']:.2g} / {angle['p99']:.2g} | {stand_off['p1']:.4f} to {stand_off['p99']:.4f} | {row['force_jump_N']['max']:.3f} |")
    return lines


def node_pairs(programs):
    """Node pairs that a query tests, with the bounding spheres of the files and with the runtime's search trees."""
    programs.samples()
    trees = [f"{builder}_{mesh}.stree" for builder in ("merge", "cover") for mesh in ("probe", "molar")]
    for tree in trees:
        builder, mesh = tree.removesuffix(".stree").split("_")
        programs.run("spheretree", "build", f"{mesh}.obj", "-o", tree, "--builder", builder, "--skin", "off", "-q")
    found = re.findall(r": (\S+) node pairs tested \(\S+ opened\), (\S+) leaf pairs", programs.run("node_pairs", 10000, *trees))
    lines = ["| builder | leaf pairs found | pairs tested by the files' bounding spheres | by the runtime's search trees |", "|---|---|---|---|"]
    for builder, (of_file, leaves), (searched, _) in zip(("merge", "cover"), found[::2], found[1::2]):
        lines.append(f"| `{builder}` | {leaves} | {float(of_file):.0f} | {float(searched):.0f} |")
    return lines


def robots(programs):
    """Uncovered surface and overhang of the spheres of several rules, by the script that makes them."""
    return output("/usr/bin/python3", ROOT / "benchmarks/robot_spheres.py", programs.build).split("\n\n")[0].splitlines()


def view_times(programs):
    """What the window costs the servo loop."""
    return output(sys.executable, ROOT / "benchmarks/view.py", programs.build).splitlines()


def built(programs, mesh, *options):
    """Report of a build of a mesh at quick."""
    programs.run("spheretree", "build", mesh, "-o", "built.stree", "--quality", "quick", "-q", "--report", "built.json", *options, codes=(0, 5))
    return json.loads((programs.folder / "built.json").read_text())


DAMAGED = [("skull from CT, with inner walls", "skull_ct.ply"), ("maxilla from CT, porous", "maxilla_ct_porous.ply"),
           ("gums with tongue, open below", "gums_and_tongue_open.obj"), ("head and neck, open below", "head_neck_open.ply"),
           ("plaster cast of an upper jaw", "upper_cast.obj"), ("upper arch, 16 teeth sunk into the gum", "upper_arch_with_gum.obj"),
           ("endoscope in pieces with cracks", "endoscope_tool_open.obj")]


def damaged_meshes(programs):
    """What the repair does to damaged scans and models, and the overhang of their trees."""
    lines = ["| mesh | triangles | border edges | steps | `bound_mm` | overhang bound, % of D | processor time |", "|---|---|---|---|---|---|---|"]
    for title, name in DAMAGED:
        checked = json.loads(programs.run("spheretree", "check", programs.foreign() / f"dental/{name}", "--json", codes=(0, 4)))
        border = sum(defect["count"] for defect in checked["defects"] if defect["kind"] == "border")
        begin = processor_time()
        report = built(programs, programs.foreign() / f"dental/{name}")
        seconds = processor_time() - begin
        steps = ", ".join(f"`{step['step']}`" for step in report["repair"]["steps"])
        share = 100 * report["levels"][-1]["overhang_bound_mm"] / report["mesh"]["diagonal_mm"]
        lines.append(f"| {title} | {checked['triangles']:,} | {border:,} | {steps} | {report['repair']['bound_mm']:.2g} | {share:.2f} | {seconds:.1f} s |")
    return lines


def proven_limits(programs):
    """What no 64 spheres can go below, and how far above it the tree is."""
    lines = ["| mesh | overhang bound, % of D | proven limit, % of D | ratio | processor time |", "|---|---|---|---|---|"]
    for mesh in sorted((programs.foreign() / "bench").iterdir()):
        programs.run("spheretree", "build", mesh, "-o", "limited.stree", "--leaves", "64", "--skin", "off", "--force", "-q", codes=(0, 5))
        begin = processor_time()
        found = json.loads(programs.run("spheretree", "evaluate", mesh, "limited.stree", "--lower-bound", "--no-limits", "--json", "-q"))
        seconds = processor_time() - begin
        best, ratio = found["proven_limit"]["overhang_mm"], found["proven_limit"]["ratio"]
        lines.append(f"| `{mesh.name}` | {100 * best * ratio / found['diagonal_mm']:.3f} | {100 * best / found['diagonal_mm']:.3f} | {ratio:.2f} | {seconds:.1f} s |")
    return lines


TOOLKIT_MESHES = {"tooth": "tooth", "bunny-2000": "bunny", "probe": "probe", "cube": "cube", "plate": "plate"}
TOOLKIT_BUILDERS = ["expand", "combined", "burst", "merge", "hubbard", "grid", "spawn", "octree"]


@functools.cache
def toolkit_rows(programs, *options):
    """Our trees beside those of the reference program, by the script that compares them: (mesh, builder) to a row."""
    judge = programs.build / "tests/judge/judge"
    if not judge.is_file():
        raise Failure(f"no {judge}, which measures the trees; the tests build it (ctest -R judge_build)")
    output(sys.executable, ROOT / "tests/pipeline/toolkit_comparison.py", judge, programs.build / "tools/spheretree/spheretree",
           programs.foreign() / "toolkit", "toolkit", "--json", "toolkit.json", *options, cwd=programs.folder)
    return {(row["mesh"], row["builder"]): row for row in json.loads((programs.folder / "toolkit.json").read_text())["rows"]}


def toolkit_trees(programs):
    """Worst overhang of each published method, its ratio to the authors' program, certified, and after the search."""
    own, searched = toolkit_rows(programs), toolkit_rows(programs, "--search")
    lines = ["| method | " + " | ".join(TOOLKIT_MESHES.values()) + " | certified, geometric mean | with `--search` |", "|---" * 8 + "|"]
    for builder in TOOLKIT_BUILDERS:
        cells = [f"{own[mesh, builder]['max_pct']:.2f} ({own[mesh, builder]['ratio']:.2f})" for mesh in TOOLKIT_MESHES]
        means = [statistics.geometric_mean(rows[mesh, builder]["certified_max_pct"] for mesh in TOOLKIT_MESHES) for rows in (own, searched)]
        lines.append(f"| {builder} | " + " | ".join(cells + [f"{mean:.2f}" for mean in means]) + " |")
    return lines


def toolkit_times(programs):
    """Processor time of a tooth, and how often it fits into that of the authors' program."""
    rows = [toolkit_rows(programs)["tooth", builder] for builder in TOOLKIT_BUILDERS]
    return ["| | " + " | ".join(builder.capitalize() for builder in TOOLKIT_BUILDERS) + " |", "|---" * 9 + "|",
            "| ours | " + " | ".join(f"{row['processor_s']:.2f} s" for row in rows) + " |",
            "| theirs | " + " | ".join(f"{row['toolkit_processor_s']:.3g} s" for row in rows) + " |",
            "| as fast | " + " | ".join(f"{short(row['toolkit_processor_s'] / row['processor_s'])} times" for row in rows) + " |"]


def sensitivity(programs):
    """Largest change of the overhang bound, in per cent, when the tooth of the toolkit is given in another form."""
    programs.run("spheretree", "compare", programs.foreign() / "toolkit/tooth.obj", "-o", "sensitivity", "--qualities", "standard", "--sensitivity", "8", "-q")
    found = json.loads((programs.folder / "sensitivity/compare.json").read_text())["stability"]
    lines = ["| builder | rotations | noise | scale 1.7 | subdivision |", "|---|---|---|---|---|"]
    for entry in found:
        change = {row["change"]: max(100 * row["largest_change"], 0.001) for row in entry["rows"]}
        lines.append(f"| `{entry['builder']}` | " + " | ".join(short(change[name]) for name in ("rotation", "noise", "scale 1.7", "subdivision")) + " |")
    return lines


def tolerance_leaves(programs):
    """Leaves of a tolerance over the fewest of some seeds, and the time of --tolerance over that of --leaves."""
    few = [f"dental/tooth_FDI{name}.stl" for name in ("14_premolar", "48_wisdom_tooth")] + ["bench/cad_fandisk.obj", "bench/organic_hyoid_bone.obj"]
    many = few + [f"dental/tooth_FDI{name}.stl" for name in ("11_incisor", "26_molar")] + [
        f"bench/{name}" for name in ("cad_metacarpal_link.obj", "elongated_cylinder.stl", "organic_spot.obj", "cad_thin_plate.obj")]
    lines = ["| meshes, quality, leaves | leaves, relative to the fewest of some seeds: geometric mean, largest | time, relative to `--leaves`: geometric mean, largest |",
             "|---|---|---|"]
    for meshes, quality, leaves, seeds in ((many, "quick", 150, 10), (many, "standard", 150, 10), (few, "standard", 440, 5)):
        output(sys.executable, ROOT / "tests/pipeline/tolerance_figures.py", programs.build / "tools/spheretree/spheretree",
               *(programs.foreign() / mesh for mesh in meshes), "--leaves", leaves, "--seeds", seeds, "--quality", quality, "--json", "tolerance.json",
               cwd=programs.folder)
        rows = json.loads((programs.folder / "tolerance.json").read_text())
        cells = [f"{statistics.geometric_mean(ratios):.3f}, {max(ratios):.3f}" for ratios in (
            [row[ours] / row[theirs] for row in rows] for ours, theirs in (("leaves", "fewest_leaves"), ("seconds", "seconds_of_leaves")))]
        teeth = sum("tooth" in mesh for mesh in meshes)
        lines.append(f"| {len(meshes)} ({teeth} teeth), `{quality}`, {leaves} | {cells[0]} ({seeds} seeds) | {cells[1]} times |")
    return lines


FOREIGN = {"felt_meshes", "proven_limits", "sensitivity", "toolkit_trees", "toolkit_times", "tolerance_leaves", "damaged_meshes"}  # tables of meshes of others
QUICK = {"molar_build", "mouth_parts", "skin_errors"}
TABLES = {function.__name__: function for function in (
    molar_build, mouth_parts, skin_errors, passivity, quiet_walls, mouth_budget, mouth_leaves, node_pairs, split_scans, split_margin, soft_mouth, tissue_overhang, robots, damaged_meshes,
    sensitivity, felt_meshes, renderer_scenarios, renderer_means, cutting_renderers, tool_models, molar_felt, molar_leaves, toolkit_trees, tolerance_leaves, proven_limits,
    # Of times: the machine should have nothing else to do.
    readme_times, mouth_real_time, mouth_load, tissue_figures, simplified_molar, step_times, qp_times, toolkit_times, view_times)}


def tables_of(page):
    """Name, first and last line (of the text between the marks) of each table of a page."""
    lines = page.read_text(encoding="utf-8").split("\n")
    for number, line in enumerate(lines):
        found = BEGIN.fullmatch(line)
        if found:
            yield found.group(1), number + 1, lines.index(END, number)


def pages_of_tables():
    """The page that shows each table."""
    pages = {name: page for page in [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))] for name, _, _ in tables_of(page)}
    if pages.keys() != TABLES.keys():
        sys.exit(f"doc_tables: on one side only, a page or TABLES: {', '.join(sorted(pages.keys() ^ TABLES.keys()))}")
    return pages


def is_as_made(page, name, made, update):
    """Whether the page shows what was made, but for times; if not, prints what differs. Reads the page anew, since a
    table may take long to make."""
    lines = page.read_text(encoding="utf-8").split("\n")
    first, last = next((first, last) for found, first, last in tables_of(page) if found == name)
    is_same = [TIME.sub("", line) for line in lines[first:last]] == [TIME.sub("", line) for line in made]
    if not is_same:
        print("\n".join(difflib.unified_diff(lines[first:last], made, f"{page.relative_to(ROOT)}, {name}", "as the programs make it", lineterm="")))
    if update:
        page.write_text("\n".join(lines[:first] + made + lines[last:]), encoding="utf-8")
    return is_same


def main():
    parser = argparse.ArgumentParser(usage=__doc__.split("\n", 1)[0])
    parser.add_argument("build")
    parser.add_argument("--update", action="store_true")
    parser.add_argument("--slow", action="store_true")
    parser.add_argument("names", nargs="*")
    options = parser.parse_intermixed_args()
    pages = pages_of_tables()
    names = options.names or [name for name in TABLES if options.slow or name in QUICK]
    if set(names) - pages.keys():
        parser.error(f"no table {', '.join(sorted(set(names) - pages.keys()))}; there are {', '.join(TABLES)}")
    different, failed = [], []
    with tempfile.TemporaryDirectory() as folder:
        programs = Programs(options.build, folder)
        for number, name in enumerate(names, 1):
            print(f"doc_tables: {number} of {len(names)}, {name}", flush=True)
            try:
                if name in FOREIGN and not programs.foreign().is_dir():
                    print(f"doc_tables: {name}: left out, without {programs.foreign()}")
                elif not is_as_made(pages[name], name, TABLES[name](programs), options.update):
                    different.append(name)
            except (Failure, OSError) as failure:
                print(f"doc_tables: {name}: {failure}")
                failed.append(name)
    for what, found in (("differ", different), ("could not be made", failed)):
        if found:
            print(f"doc_tables: {what}: {', '.join(found)}")
    return 1 if failed or different and not options.update else 0


if __name__ == "__main__":
    sys.exit(main())
