#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""invocations.py SPHERETREE HAPTIC_PLAYER: odd command lines, each with the exit code that it must have.

Every run that fails must say so in one line on stderr that begins with the program's name and ends a sentence, in words
of our own and without control characters, and must leave nothing behind: no new file, no temporary file. The list is at
the end of each section. """
import json
import os
import re
import resource
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

SPHERETREE, PLAYER = (str(Path(p).resolve()) for p in sys.argv[1:3])
TETRAHEDRON = "v 0 0 0\nv 10 0 0\nv 0 10 0\nv 0 0 10\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
TREE = "2 2\n2.5 2.5 2.5 10 1\n2 2 2 8.9 1\n5 5 5 7.5 1\n"
QUICK = ["--levels", "2", "--quality", "quick"]
OK, INTERNAL, USAGE, FILE, REFUSED, MISSED, PARTLY, INTERRUPTED = 0, 1, 2, 3, 4, 5, 6, 130
FOREIGN_WORDS = re.compile(r"exception|\[json|std::|basic_string|CLI|what\(\)|terminate|Aborted|vector::|At Most|required but received")
cases = []  # (what, words, code)


def case(code, *words):
    cases.append((" ".join(map(str, words)), list(words), code))


def verbs():
    """Command lines that are wrong in themselves."""
    verbs_of = ["batch", "build", "check", "compare", "convert", "evaluate", "grade", "inspect", "repair", "report", "robot", "scene", "soften",
                "split"]
    for verb in verbs_of:
        case(USAGE, verb)
        case(OK, verb, "--help")
        case(OK, verb, "-h")
        case(OK, "help", verb)
        case(USAGE, verb, "--no-such-option")
        case(USAGE, verb, "m.obj", "--progress", "loud")
        case(USAGE, verb, "--progress")
        case(USAGE, verb, "-Z")
        case(USAGE, verb[:-1] + "zz")
        case(USAGE, "--verbose", verb)
        case(USAGE, "word", verb)
        case(USAGE, verb, "a", "b", "c", "d", "--", "-e") if verb not in ("check", "inspect", "compare", "build") else None
    for words in ([], ["--"], ["-"], [""], ["help", "nothing"], ["--version", "--no"], ["-q"], ["--progress", "none"], ["--help", "--no"]):
        case(USAGE, *words) if words[:1] != ["--version"] else None
    for words in (["--version"], ["--help"], ["-h"], ["help"], ["help", "scene"]):
        case(OK, *words)


def inputs():
    """Every verb that reads, on everything that is no such file."""
    readers = {
        "check": (["check", "IN"], {}), "build": (["build", "IN", "-o", "out.stree", *QUICK], {}),
        "repair": (["repair", "IN", "-o", "out.ply"], {}), "compare": (["compare", "IN", "-o", "out", "--builders", "cover"], {}),
        "inspect": (["inspect", "IN"], {"tree"}), "convert": (["convert", "IN", "out.json"], {"tree"}),
        "evaluate mesh": (["evaluate", "IN", "t.stree"], {}), "evaluate tree": (["evaluate", "m.obj", "IN"], {"tree"}),
        "batch": (["batch", "IN", "-o", "out"], {"scene"}), "report": (["report", "IN", "-o", "out.html"], {"recording"}),
        "grade": (["grade", "IN"], {"recording"}),
        "robot": (["robot", "IN", "-o", "out"], {"robot"})}
    files = {"missing": FILE, "folder": FILE, "loop": FILE, "dangling": FILE, "missing/file": FILE, "m.obj/file": FILE, "empty": REFUSED,
             "noise": REFUSED, "new\nline": FILE, "esc\x1b[31m": FILE, "n" * 300: FILE, "": USAGE, "zeros": REFUSED, "text": REFUSED,
             "picture.png": REFUSED}
    for name, (words, kinds) in readers.items():
        for file, code in files.items():
            ending = "" if not kinds or "/" in file else {"tree": ".stree", "scene": ".json", "recording": ".csv", "robot": ".urdf"}[next(iter(kinds))]
            if name == "report" and file == "folder":
                ending = ""
            target = file + ending if file and not file.endswith(".png") else file
            if name in ("convert", "evaluate tree") and not target.endswith(".stree"):
                code = USAGE
            case(code, *[target if w == "IN" else w for w in words])


def outputs():
    """Every verb that writes one file, to every place where none can be."""
    writers = {"build": (["build", "m.obj", *QUICK, "-o", "OUT"], ".stree"), "repair": (["repair", "m.obj", "-o", "OUT"], ".ply"),
               "convert": (["convert", "t.stree", "OUT"], ".sph"), "convert -o": (["convert", "t.stree", "-o", "OUT"], ".csv"),
               "glb": (["convert", "t.stree", "OUT"], ".glb"), "png": (["convert", "t.stree", "OUT", "--width", "100"], ".png"),
               "check": (["check", "m.obj", "-o", "OUT"], ".glb"), "report": (["report", "run.csv", "-o", "OUT"], ".html"),
               "build report": (["build", "m.obj", *QUICK, "-o", "out.stree", "--report", "OUT"], ".json")}
    for name, (words, ending) in writers.items():
        for place, code in (("missing/out" + ending, FILE), ("folder" + ending, FILE), ("loop" + ending, FILE), ("m.obj/out" + ending, FILE),
                            ("out.wrong", USAGE), ("out", USAGE), ("n" * 300 + ending, FILE), ("full" + ending, FILE), ("", USAGE)):
            if place.startswith("full") and name == "build report":
                continue  # the tree, which is whole, stays
            case(code, *[place if w == "OUT" else w for w in words])


def values():
    """Options with values that they do not take."""
    numbers = ["x", "", "-1", "nan", "-nan", "inf", "1e999", "0x10", "1,5", "99999999999999999999", "1.5.2"]
    for value in numbers:
        case(USAGE, "build", "m.obj", "-o", "out.stree", f"--levels={value}")
        case(USAGE, "build", "m.obj", "-o", "out.stree", f"--tolerance={value}") if not value.startswith("999") else None
        case(USAGE, "build", "m.obj", "-o", "out.stree", f"--seed={value}") if value != "99999999999999999999" else None
        case(USAGE, "convert", "t.stree", "out.png", f"--width={value}")
        case(USAGE, "batch", "s.json", "-o", "out", f"--budget={value}")
        case(USAGE, "batch", "s.json", "-o", "out", f"--tolerance={value}")
    for words in (["--quality", "good"], ["--builder", "best"], ["--unit", "km"], ["--repair", "maybe"], ["--combine", "merge"], ["--threads", "-1"],
                  ["--branching", "9"], ["--leaves", "0"], ["--quality", "quick", "--quality", "best"], ["--tolerance"],
                  ["--builder", "octree", "--leaves", "9"], ["--search"], ["--medial-axis", "static"],
                  ["--builder", "grid", "--medial-axis", "static"], ["--uncertified", "bare.sph"],
                  ["--builder", "merge", "--search", "--uncertified", "bare.sph"], ["--builder", "merge", "--uncertified", "bare.txt"], ["--report", "out.stree"], ["--seed", "1", "--seed", "2"]):
        case(USAGE, "build", "m.obj", "-o", "out.stree", *words)
    for words in (["--view", "0,0,0"], ["--view", "1,2"], ["--view", "nan,0,1"], ["--mesh"], ["--level", "1"], ["--unit", "m"]):
        case(USAGE, "convert", "t.stree", "out.png", *words)
    for words in (["out.stree", "--level", "1"], ["out.csv", "--level", "7"], ["out.csv", "--level", "2"], ["out.json", "--unit", "m"],
                  ["out.sph", "--unit", "m"], ["out.json", "--spheres", "bound"], ["-"], ["-", "--to", "obj"], ["out.csv", "--to", "sph"],
                  ["out.glb", "--unit", "m"]):
        case(USAGE, "convert", "t.stree", *words)
    for words in (["--fail-on", "all"], ["--json", "-o", "-"], ["--parts"]):
        case(USAGE, "check", "m.obj", *words)
    for parts in ("#1", "nothing", "#x", "#-1"):
        case(REFUSED, "check", "m.obj", "--parts", parts)
    for words in (["--shard", "0/2"], ["--shard", "3/2"], ["--shard", "1"], ["--shard", "1/2", "--budget", "9"], ["--trajectory", "run.csv"]):
        case(USAGE, "batch", "s.json", "-o", "out", *words)
    case(OK, "batch", "s.json", "-o", "out", "--dry-run")
    case(USAGE, "batch", "s.json", "-o", "out", "--dry-run", "--chart")
    case(USAGE, "report", "run.csv", "-o", "out.html", "--recording", "run.csv")
    case(USAGE, "report", "folder", "-o", "out.html", "--scene", "s.json")
    case(REFUSED, "report", "m.obj", "-o", "out.html")
    case(REFUSED, "check", "open.obj")
    case(REFUSED, "check", "m.obj", "open.obj")
    case(OK, "check", "open.obj", "--fail-on", "unfixable")
    case(OK, "check", "flat.obj", "--fail-on", "nothing")
    case(REFUSED, "check", "flat.obj", "--fail-on", "unfixable")
    case(REFUSED, "repair", "flat.obj", "-o", "out.ply")
    case(REFUSED, "build", "open.obj", "-o", "out.stree", "--repair", "off")
    case(USAGE, "build", "m.obj", "open.obj", "-o", "out.stree")
    case(USAGE, "build", "m.obj", "open.obj", "-o", "out", "--report", "r.json")


def scenes():
    """Scenes that are wrong in one place: (what replaces what)."""
    for number, text in enumerate(bad_scenes()):
        case(REFUSED, "batch", f"bad{number}.json", "-o", "out")
        case(REFUSED, "PLAYER", f"bad{number}.json", "--seconds", "0.01", "--clock", "stepped")


def bad_scenes():
    good = scene_text()
    for old, new in (('"mm"', '"km"'), ('"unit"', '"units"'), ('scene/1', 'scene/9'), ('"tool"', '"tools"'), ('[{', '[['), ('}]', '}'),
                     ('"name": "a"', '"name": "../a"'), ('"name": "a"', '"name": "tool"'), ('"name": "a"', '"name": "TOOL"'), ('"name": "a"', '"name": ""'),
                     ('"mesh": "m.obj"}]', '"mesh": "m.obj", "tree": 3}]'), ('"mesh": "m.obj"}]', '"mash": "m.obj"}]'),
                     ('"mesh": "m.obj"}]', '"mesh": "m.obj", "position_mm": [1, 2]}]'),
                     ('"mesh": "m.obj"}]', '"mesh": "m.obj", "position_mm": [1, 2, 1e7]}]'),
                     ('"mesh": "m.obj"}]', '"mesh": "m.obj", "quaternion_wxyz": [0, 0, 0, 0]}]'),
                     ('"mesh": "m.obj"}]', '"mesh": "m.obj", "tolerance_mm": 0}]'), ('"mesh": "m.obj"}]', '"mesh": "m.obj", "levels": 9}]'),
                     ('"mesh": "m.obj"}]', '"mesh": "m.obj", "unit": "furlong"}]'), ('"mesh": "m.obj"}]', '"mesh": "m.obj", "mesh": "m.obj"}]'),
                     ('"levels": 2', '"levels": "2"'), ('"levels": 2', '"levels": NaN'), ('"levels": 2', '"levels": 2,'), ('"levels": 2', '"level": 2'),
                     ('"levels": 2', '// two\n"levels": 2'), ('"levels": 2', '"levels": 1e999'), ('"levels": 2', "'levels': 2"),
                     ('{"schema"', '["schema"'), ('"schema"', '"\\ud800"'), (good, ''), (good, '[]'), (good, 'null'), (good, '{}'), (good, '[' * 5000),
                     ('"mesh": "m.obj"}]', '"mesh": "m.obj\\u0000"}]')):
        yield good.replace(old, new, 1)


def scene_text():
    return json.dumps({"schema": "spheretree.scene/1", "unit": "mm", "defaults": {"quality": "quick", "levels": 2}, "tool": {"name": "tool", "mesh": "m.obj"},
                       "objects": [{"name": "a", "mesh": "m.obj"}]})


def players():
    stepped = ["--clock", "stepped"]
    for words in (["--seconds", "nan"], ["--seconds", "0"], ["--seconds", "-1"], ["--seconds", "x"], ["--seconds"], ["--clock", "fast"], ["--mode", "best"],
                  ["--device", "hand"], ["--device", "replay"], ["--device", "phantom", *stepped], ["--hand", "big"], ["--share", "0.1"],
                  ["--out", "out"], ["--scenario", "F17"], ["--record", "run.txt"], ["--record"], ["--trajectory"], ["--trajectry", "run.csv"],
                  ["again.json"], ["--hd-calibrate"], ["--", "--seconds"], ["--modes", "paper"], ["--chart", "page.html"],
                  ["--cache", "trees"], ["--voxel-mm", "0.1"], ["--compare-cutting"]):
        case(USAGE, "PLAYER", "b/scene.json", *words)
    for words in (["--voxel-mm", "0"], ["--chart", "page.txt"], ["--record", "run.csv"], ["--scenario", "F17"], ["--trajectory", "path.csv"]):
        case(USAGE, "PLAYER", "--compare-cutting", *words)
    for words in (["--share", "nan"], ["--share", "2"], ["--record", "out.csv"], ["--scenario", "F17"], ["--modes", "best"], ["--modes", "paper,"],
                  ["--modes"], ["--chart", "page.txt"], ["--chart"]):
        case(USAGE, "PLAYER", "--scenario", "F17", *words)
    case(USAGE, "PLAYER", "--scenario", "F99")
    for file, code in (("missing.json", FILE), ("folder", FILE), ("m.obj", REFUSED), ("t.stree", REFUSED), ("empty", REFUSED), ("noise", REFUSED),
                       ("s.json", REFUSED), ("loop", FILE), ("new\nline", FILE)):
        case(code, "PLAYER", file, "--seconds", "0.01", *stepped)
    for file, code in (("missing.csv", FILE), ("folder", FILE), ("empty", REFUSED), ("noise", REFUSED), ("m.obj", REFUSED), ("nan.csv", REFUSED),
                       ("late.csv", REFUSED), ("long.csv", REFUSED)):
        case(code, "PLAYER", "b/scene.json", "--trajectory", file, *stepped)
    for place, code in (("missing/out.csv", FILE), ("folder.csv", FILE), ("loop.csv", FILE), ("full.csv", FILE), ("b/scene.json", USAGE)):
        case(code, "PLAYER", "b/scene.json", "--seconds", "0.01", *stepped, "--record", place)
    for words in (["b/scene.json"], ["b"], ["./b"], ["b/"]):
        case(OK, "PLAYER", *words, "--seconds", "0.01", *stepped)
    case(OK, "PLAYER", "--list")
    case(OK, "PLAYER", "--help")
    case(OK, "PLAYER", "--version")


def prepare(folder):
    (folder / "m.obj").write_text(TETRAHEDRON)
    (folder / "open.obj").write_text(TETRAHEDRON.replace("f 2 3 4\n", ""))
    (folder / "flat.obj").write_text("v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n")
    (folder / "t.sph").write_text(TREE)
    (folder / "text").write_text("Dear reader,\nthis is no file of any kind.\n")
    for name in ("text.stree", "text.json", "text.csv", "text.urdf"):
        (folder / name).write_text("Dear reader,\n")
    for ending in ("", ".stree", ".json", ".csv", ".urdf"):
        (folder / ("empty" + ending)).write_text("")
        (folder / ("noise" + ending)).write_bytes(bytes(i * 37 % 251 for i in range(5000)))
        (folder / ("zeros" + ending)).write_bytes(bytes(4096))
    for ending in ("", ".stree", ".json", ".csv", ".urdf", ".sph", ".ply", ".glb", ".png", ".html"):
        (folder / ("folder" + ending)).mkdir()
        (folder / ("loop" + ending)).symlink_to("loop" + ending)
        (folder / ("dangling" + ending)).symlink_to("nowhere" + ending)
        (folder / ("full" + ending)).symlink_to("/dev/full")
    (folder / "picture.png").write_bytes(b"\x89PNG\r\n\x1a\n" + bytes(100))
    (folder / "s.json").write_text(scene_text())
    for number, text in enumerate(bad_scenes()):
        (folder / f"bad{number}.json").write_text(text)
    head = "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz\n"
    rows = [f"{i / 1000:.3f},0,0,{30 - 0.3 * i:.3f},1,0,0,0\n" for i in range(60)]
    (folder / "path.csv").write_text(head + "".join(rows))
    (folder / "nan.csv").write_text(head + "0.000,0,nan,0,1,0,0,0\n")
    (folder / "late.csv").write_text(head + rows[0] + "0.500" + rows[5][5:])
    (folder / "long.csv").write_text(head + "0.000,0,0,0,9,0,0,0\n")
    for program, *words in ((SPHERETREE, "convert", "t.sph", "t.stree"), (SPHERETREE, "batch", "s.json", "-o", "b"),
                            (PLAYER, "b/scene.json", "--trajectory", "path.csv", "--clock", "stepped", "--record", "run.csv")):
        done = subprocess.run([program, *words], cwd=folder, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr


def names_in(folder):
    return {str(p.relative_to(folder)) for p in folder.rglob("*")}


def faults_of(done, code, program, before, folder):
    """What is wrong with a run, or nothing."""
    said = done.stderr.decode(errors="replace")
    if done.returncode != code:
        yield f"exit code {done.returncode}, not {code}; it says: {said!r}"
    if code in (OK, MISSED):
        return
    name = Path(program).name
    lines = said.splitlines()
    if not lines and done.stdout and code == REFUSED:
        return  # what check found is its result
    if code != PARTLY and (len(lines) != 1 or not lines[0].startswith(name + ": ")):
        yield f"not one line of {name}: {said!r}"
    if FOREIGN_WORDS.search(said):
        yield f"words of a library: {said!r}"
    if re.search(r"[\x00-\x09\x0b-\x1f\x7f]", said):
        yield f"control characters: {said!r}"
    if lines and lines[-1][-1] not in ".!?":
        yield f"no end of a sentence: {said!r}"
    left = {n for n in names_in(folder) - before if not n.startswith("out/cache")} - {"out"}
    if left:
        yield f"left behind: {left}"


def run_listed(folder):
    failures = []
    before = names_in(folder)
    for what, words, code in cases:
        program = PLAYER if words and words[0] == "PLAYER" else SPHERETREE
        words = words[1:] if words and words[0] == "PLAYER" else words
        done = subprocess.run([program, *words], cwd=folder, capture_output=True, stdin=subprocess.DEVNULL, timeout=120)
        failures += [f"{what!r}: {fault}" for fault in faults_of(done, code, program, before, folder)]
        for name in sorted(names_in(folder) - before, reverse=True):  # of runs that are meant to write
            path = folder / name
            path.rmdir() if path.is_dir() and not path.is_symlink() else path.unlink()
    return failures


def run_with(folder, words, code, program=SPHERETREE, **how):
    before = names_in(folder)
    done = subprocess.run([program, *words], cwd=folder, **{"stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE, **how},
                          timeout=120)
    done.stderr = done.stderr or b""
    said = "" if done.returncode == code else f"exit code {done.returncode}, not {code}: {done.stderr!r}"
    left = names_in(folder) - before if code not in (OK,) else set()
    return [f"{' '.join(words)} {sorted(how)}: {said or f'left behind: {left}'}"] if said or left else []


def surroundings(folder):
    """Full disks, closed descriptors, small limits, pipes without a reader."""
    failures, count = [], 0
    reading = (["inspect", "t.stree"], ["inspect", "t.stree", "--json"], ["check", "m.obj"], ["check", "m.obj", "--json"], ["--help"], ["help", "scene"],
               ["convert", "t.stree", "-", "--to", "json"], ["evaluate", "m.obj", "t.stree", "--no-limits"], ["build", "--help"], ["--version"])
    for words in reading:
        with open("/dev/full", "wb") as full:
            failures += run_with(folder, words, FILE, stdout=full)
        read, write = os.pipe()
        os.close(read)
        failures += run_with(folder, words, FILE, stdout=write)
        os.close(write)
        failures += run_with(folder, words, OK, preexec_fn=lambda: os.close(0))
        count += 3

    def small_files():
        resource.setrlimit(resource.RLIMIT_FSIZE, (100, 100))

    for words in (["build", "m.obj", "-o", "x.stree", *QUICK], ["repair", "m.obj", "-o", "x.ply"], ["convert", "t.stree", "x.json"], ["convert", "t.stree", "x.glb"],
                  ["report", "run.csv", "-o", "x.html"], ["check", "open.obj", "-o", "x.glb"]):
        failures += run_with(folder, words, FILE, preexec_fn=small_files)
        count += 1
    for words, text in ((["check", "-"], TETRAHEDRON), (["build", "-", "-o", "x.stree", *QUICK], TETRAHEDRON), (["convert", "-", "x.csv"], TREE),
                        (["repair", "-", "-o", "-"], TETRAHEDRON)):
        done = subprocess.run([SPHERETREE, *words], cwd=folder, input=text.encode(), capture_output=True, timeout=60)
        if done.returncode != 0:
            failures.append(f"{words} from a pipe: {done.stderr!r}")
        for name in ("x.stree", "x.csv"):
            (folder / name).unlink(missing_ok=True)
        count += 1
    return failures, count


def wait_until_it_waits(running):
    """Until the process handles SIGINT and sleeps, as it does at a pipe; or for 60 s, or until it ends."""
    for _ in range(6000):
        fields = dict(line.split(":", 1) for line in Path(f"/proc/{running.pid}/status").read_text().splitlines() if ":" in line)
        handles = int(fields.get("SigCgt", "0"), 16) & 1 << signal.SIGINT - 1
        if running.poll() is not None or handles and fields["State"].strip().startswith("S"):
            return
        time.sleep(0.01)


def signals(folder):
    """A stop while the program waits for a pipe, and while it builds."""
    failures, count = [], 0
    for ending in (".stl", ".obj"):
        pipe = "fifo" + ending
        os.mkfifo(folder / pipe)
        for words in (["check", pipe], ["split", pipe, "--parts", "-o", "made/inside"]):
            for number, times in ((signal.SIGINT, 1), (signal.SIGTERM, 1), (signal.SIGHUP, 1), (signal.SIGINT, 2), (signal.SIGTERM, 3)):
                before = names_in(folder)
                running = subprocess.Popen([SPHERETREE, *words], cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
                wait_until_it_waits(running)
                for _ in range(times):  # a wrapper may send it to the program and to its group
                    running.send_signal(number)
                said = running.communicate(timeout=20)[1].decode()
                if running.returncode != INTERRUPTED or len(said.splitlines()) != 1 or names_in(folder) != before:
                    failures.append(f"{times} x signal {number} at a pipe, {words[0]}: exit code {running.returncode}: {said!r}")
                count += 1
    return failures, count


def main():
    for section in (verbs, inputs, outputs, values, scenes, players):
        section()
    with tempfile.TemporaryDirectory() as base:
        folder = Path(base)
        prepare(folder)
        failures = run_listed(folder)
        more, count = surroundings(folder)
        stopped, stops = signals(folder)
    failures += more + stopped
    print(f"{len(cases) + count + stops} invocations, {len(failures)} with faults")
    for failure in failures:
        print("FAILED:", failure)
    return 1 if failures else 0


sys.exit(main())
