#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""layers.py SOURCE [COMPILER]: fails if an include goes against the layers of docs/architecture.md, or a header cannot
stand alone.

1. Rooms: each room includes only the rooms and the third-party libraries that it may.
2. Wings: in rooms that have them, each wing includes only the wings below it. In no room do files include each other in
   a circle. No folder of sources holds more than 15 units; a unit is a header and its source.
3. The runtime includes nothing that reads files, prints or allocates by text: no <iostream>, <fstream>, <filesystem>,
   JSON.
4. Public headers are few: what only our own programs include stays in src/.
5. With COMPILER: every public header compiles alone; with SPHERETREE_LONG=1, as in `.ci/lane debug`, every header.
   One that a source or a test includes first is proven by that lane, which compiles each of them alone. """
import os
import re
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

# Room: folder, rooms that it may include, prefixes of third-party headers that it may include in src/.
ROOMS = {
    "core": ("libruntime/core", [], ["Eigen/", "immintrin.h", "cpuid.h"]),
    "runtime": ("libruntime/runtime", ["core"], ["Eigen/", "immintrin.h", "cpuid.h"]),
    "tissue": ("libruntime/tissue", ["core"], ["Eigen/"]),
    "formats": ("formats", ["core"], ["Eigen/", "nlohmann/", "tiny_gltf.h", "meshoptimizer", "draco/", "sys/", "unistd.h", "io.h", "windows.h"]),
    # Both shared libraries export the C interface: scene.cpp reaches what is behind its handles.
    "scene": ("libruntime/scene", ["core", "runtime", "tissue", "formats"], ["Eigen/", "c_handles.h"]),
    "device": ("device", ["core"], ["Eigen/", "dlfcn.h", "pthread.h", "sched.h", "sys/", "time.h", "unistd.h", "signal.h", "netinet/", "arpa/", "netdb.h", "poll.h", "windows.h", "winsock2.h", "ws2tcpip.h", "mswsock.h"]),
    "servo": ("libruntime/servo", ["core", "runtime", "device"], ["Eigen/"]),
    "builder": ("libspheretree", ["core", "tissue"], ["Eigen/", "CGAL/", "OpenMesh/", "tbb/", "oneapi/", "xxhash", "boost/"]),
}
PUBLIC_HEADERS = {"builder": 13, "runtime": 3}  # at most
MOST_UNITS = 15


def in_order(*wings):
    return {wing: list(wings[:i]) for i, wing in enumerate(wings)}


# Folder of a room: its wings, the lowest first. Each may include the named ones, and what these may include. A wing is
# a folder; "." stands for the files in the room's own folder.
WINGS = {
    "libruntime/runtime": {
        "scene": [],
        "kernel": ["scene"],
        "contact": ["kernel"],
        "state": ["contact"],
        "search": ["state"],
        "rows": ["state"],
        "tissue": ["search", "rows"],
        "piece": ["contact"],
        "cut": ["rows", "piece"],
        "step": ["search", "rows", "piece"],
        ".": ["step"],
    },
    "formats": {
        "text": [],
        "mesh": ["text"],
        "gltf": ["mesh"],
        "tree": ["gltf"],
        "scene": ["text"],
        ".": ["gltf"],
    },
    "libspheretree": {
        "base": [],
        "geometry": ["base"],
        "mesh": ["geometry"],
        "medial": ["geometry"],
        "repair": ["mesh"],
        "split": ["repair"],
        "skin": ["mesh"],
        "certify": ["medial"],
        "hulls": ["certify", "skin"],
        "cut": ["repair"],
        "measure": ["mesh", "hulls"],
        "tissue": ["certify", "mesh"],
        "tree": ["certify"],
        "cover": ["tree"],
        "published": ["cover"],
        ".": ["published", "mesh", "measure", "hulls", "cut", "split", "tissue"],
    },
    "tools/pipeline": in_order(".", "tissue", "split", "cut", "batch", "comparison"),
    "tools/spheretree": in_order("page", "input", "view", "options", "commands", "."),
    "tools/robot": in_order("text", "model", "cover", "files", "."),
    "tools/haptic_view": in_order("streams", "model", "draw", "hand", "replay", "panel", "window"),
    "tools/haptic_player": in_order("run", "bodies", "published", "scenarios", "comparison", "view", "."),
}
FORBIDDEN_IN_RUNTIME = re.compile(r"<(iostream|fstream|sstream|filesystem|regex|locale|thread|mutex)>")
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]', re.MULTILINE)
STANDARD = re.compile(r"^[a-z_0-9]+$")  # <vector>


def sources(folder):
    return sorted(p for p in folder.rglob("*") if p.suffix in (".h", ".cpp", ".c"))


def includes(path):
    return [found.group(2) for found in INCLUDE.finditer(path.read_text(encoding="utf-8"))]


def room_faults(root):
    for room, (folder, may, third_party) in ROOMS.items():
        for path in sources(root / folder):
            name = path.relative_to(root)
            is_public = "include" in name.parts
            for header in includes(path):
                if header.startswith("spheretree/"):
                    other = header.split("/")[1]
                    if other != room and other not in may:
                        yield f"{name}: {room} includes {header}"
                elif STANDARD.match(header) or (path.parent / header).exists() or (root / folder / "src" / header).exists():
                    continue
                elif is_public and not header.startswith("Eigen/") and not header.endswith(".h"):
                    yield f"{name}: a public header includes {header}"
                elif not any(header.startswith(prefix) for prefix in third_party) and not re.fullmatch(r"std[a-z]+\.h|errno\.h|math\.h|fcntl\.h", header):
                    yield f"{name}: {room} includes {header}"
            if room in ("core", "runtime", "tissue"):
                found = FORBIDDEN_IN_RUNTIME.search(path.read_text(encoding="utf-8"))
                if found:
                    yield f"{name}: includes {found.group(0)}"
        public = [p for p in (root / folder / "include").rglob("*.h")]
        if room in PUBLIC_HEADERS and len(public) > PUBLIC_HEADERS[room]:
            yield f"{folder}/include: {len(public)} public headers, at most {PUBLIC_HEADERS[room]}"


def included_units(root, folder):
    """Unit -> the units of the same room that it includes, each with the place. A header and its source are one unit,
    named by its path below src/ or the room's folder. A public header belongs to its source; without one, to the lowest
    wing."""
    room, src = root / folder, root / folder / "src"
    if not src.is_dir():
        src = room
    lowest = next(iter(WINGS.get(folder, ["."])))
    unit = {}
    for path in sources(room):
        if path.is_relative_to(src):
            unit[path] = str(path.relative_to(src).with_suffix(""))
        else:
            source = next(src.rglob(path.stem + ".cpp"), src / lowest / path.name)
            unit[path] = str(source.relative_to(src).with_suffix(""))
    graph = {name: {} for name in unit.values()}
    for path, name in unit.items():
        for header in includes(path):
            candidates = [path.parent / header] + [other for other in unit if str(other).endswith("/" + header)]
            other = next((unit[candidate] for candidate in candidates if candidate in unit), name)
            if other != name:
                graph[name].setdefault(other, f"{path.relative_to(root)} includes {header}")
    return graph


def wing_of(unit):
    return unit.split("/")[0] if "/" in unit else "."


def arrow_faults(folder, graph):
    """Includes that run against the order of the wings."""
    may = {}
    for wing, direct in WINGS[folder].items():
        may[wing] = {wing}.union(*(may[other] for other in direct))
    for unit, others in graph.items():
        if wing_of(unit) not in may:
            yield f"{folder}/{unit}: '{wing_of(unit)}' is no wing of tests/install/layers.py"
            continue
        for other, place in others.items():
            if wing_of(other) not in may[wing_of(unit)]:
                yield f"{place}: wing '{wing_of(unit)}' is not above wing '{wing_of(other)}'"


def circle_faults(folder, graph):
    """The first circle of includes between units."""
    done = set()

    def circle(unit, path):
        if unit in path:
            return path[path.index(unit):] + [unit]
        if unit in done:
            return None
        found = next(filter(None, (circle(other, path + [unit]) for other in sorted(graph[unit]))), None)
        done.add(unit)
        return found

    found = next(filter(None, (circle(unit, []) for unit in sorted(graph))), None)
    if found:
        yield f"{folder}: a circle of includes: " + " -> ".join(found)


def size_faults(root, folder):
    """Folders with more units than one looks through at a glance."""
    units = {}
    for path in sources(root / folder):
        if "include" not in path.relative_to(root).parts:
            units.setdefault(path.parent, set()).add(re.sub("_(posix|windows)$", "", path.stem))
    for place, names in units.items():
        if len(names) > MOST_UNITS:
            yield f"{place.relative_to(root)}: {len(names)} units, at most {MOST_UNITS}: divide it"


def wing_faults(root):
    others = [path for path in (root / "tools").iterdir() if any(path.glob("**/*.h"))]
    folders = [folder for folder, _, _ in ROOMS.values()] + sorted(str(path.relative_to(root)) for path in others) + ["samples", "tests"]
    for folder in folders:
        graph = included_units(root, folder)
        yield from circle_faults(folder, graph)
        if folder in WINGS:
            yield from arrow_faults(folder, graph)
        if folder != "tests":
            yield from size_faults(root, folder)


def header_faults(root, compiler):
    folders = {room: root / folder for room, (folder, _, _) in ROOMS.items()}
    flags = ["-std=c++20", "-fsyntax-only", "-isystem", "/usr/include/eigen3", "-I", str(root / "libspheretree/src")]
    for folder in folders.values():
        flags += ["-I", str(folder / "include")]
    alone, is_long = [], os.environ.get("SPHERETREE_LONG") == "1"
    first = {found[0] for folder in [*folders.values(), root / "tests"] for path in folder.rglob("*.cpp") if (found := includes(path))}
    for room, folder in folders.items():
        for path in sorted((folder if is_long else folder / "include").rglob("*.h")):
            if any(str(path).endswith("/" + name) for name in first):
                continue
            alone.append((path, ["-I", str(folder / "src")]))

    def compile_one(job):
        path, more = job
        run = subprocess.run([compiler, *flags, *more, "-x", "c++", str(path)], capture_output=True, text=True)
        return None if run.returncode == 0 else f"{path.relative_to(root)} cannot stand alone: {run.stderr.strip().splitlines()[0]}"

    with ThreadPoolExecutor(2) as pool:
        yield from (fault for fault in pool.map(compile_one, alone) if fault)


def main(arguments):
    if not arguments:
        sys.exit(__doc__)
    root = Path(arguments[0])
    faults = list(room_faults(root)) + list(wing_faults(root))
    if len(arguments) > 1:
        faults += list(header_faults(root, arguments[1]))
    print("\n".join(faults) if faults else "layers: nothing to complain about")
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main(sys.argv[1:])
