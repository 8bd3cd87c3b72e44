#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""layers.py SOURCE [COMPILER]: fails if an include goes against the layers of docs/architecture.md, or a header cannot stand alone.

1. Rooms: each room includes only the rooms and the third-party libraries that it may.
2. Wings of libspheretree: each wing includes only the wings before it, and neither wings nor files include each other in a circle.
3. The runtime includes nothing that reads files, prints or allocates by text: no <iostream>, <fstream>, <filesystem>, JSON.
4. Public headers are few: what only our own programs include stays in src/.
5. With COMPILER: every header compiles alone. One that its own source includes first is proven by
   `.ci/lane debug`, which compiles each source alone.
"""
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
    "formats": ("formats", ["core"], ["Eigen/", "nlohmann/", "tiny_gltf.h", "meshoptimizer", "draco/", "sys/", "unistd.h"]),
    "device": ("device", ["core"], ["Eigen/", "dlfcn.h", "pthread.h", "sched.h", "sys/", "time.h", "unistd.h", "signal.h"]),
    "builder": ("libspheretree", ["core", "tissue"], ["Eigen/", "CGAL/", "OpenMesh/", "tbb/", "oneapi/", "xxhash", "boost/"]),
}
PUBLIC_HEADERS = {"builder": 13, "runtime": 3}  # at most
# Each wing may include those named, and what they may include.
WINGS = {
    "base": [],
    "geometry": ["base"],
    "mesh": ["geometry"],
    "medial": ["geometry"],
    "repair": ["mesh"],
    "split": ["repair"],
    "measure": ["mesh"],
    "skin": ["mesh"],
    "certify": ["medial"],
    "tissue": ["certify", "mesh"],
    "tree": ["certify"],
    "cover": ["tree"],
    "published": ["cover"],
    "top": ["published", "mesh", "measure", "skin", "split", "tissue"],
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


def closure():
    whole = {}
    for wing, direct in WINGS.items():
        whole[wing] = {wing}.union(*(whole[other] for other in direct))
    return whole


def wing_faults(root):
    src, public = root / "libspheretree/src", root / "libspheretree/include/spheretree/builder"
    may = closure()
    home = {}  # include text -> wing; a public header lives where its source does, plain types in base
    for path in src.rglob("*.h"):
        name = path.relative_to(src)
        home[str(name)] = name.parts[0] if len(name.parts) > 1 else "top"
    for path in public.glob("*.h"):
        source = next(src.rglob(path.stem + ".cpp"), None)
        home[f"spheretree/builder/{path.name}"] = "base" if source is None else "top" if source.parent == src else source.parent.name
    graph = {}
    for path in sources(src) + sources(public):
        name = path.relative_to(src) if path.is_relative_to(src) else Path("spheretree/builder") / path.name
        own = home.get(str(name.with_suffix(".h"))) or (name.parts[0] if len(name.parts) > 1 else "top")
        if own not in WINGS:
            yield f"libspheretree/src/{name}: '{own}' is no wing of tests/install/layers.py"
            continue
        for header in includes(path):
            other = home.get(header)
            if other is None:
                continue
            if other not in may[own]:
                yield f"{name}: wing '{own}' includes {header} of wing '{other}'"
            here, there = str(name.with_suffix("")), str(Path(header).with_suffix(""))
            here = here.replace("spheretree/builder/", f"{own}/" if own != "top" else "")
            there = there.replace("spheretree/builder/", f"{other}/" if other != "top" else "")
            if here != there:
                graph.setdefault(here, set()).add(there)
    state = {}

    def circle(node, path):
        state[node] = 1
        for other in sorted(graph.get(node, ())):
            if state.get(other) == 1:
                return path + [node, other]
            if other not in state and (found := circle(other, path + [node])):
                return found
        state[node] = 2
        return None

    for node in sorted(graph):
        if node not in state and (found := circle(node, [])):
            yield "a circle of includes: " + " -> ".join(found)
            break


def header_faults(root, compiler):
    folders = {room: root / folder for room, (folder, _, _) in ROOMS.items()}
    flags = ["-std=c++20", "-fsyntax-only", "-isystem", "/usr/include/eigen3", "-I", str(root / "libspheretree/src")]
    for folder in folders.values():
        flags += ["-I", str(folder / "include")]
    alone = []
    for room, folder in folders.items():
        for path in sorted(folder.rglob("*.h")):
            own = next((p for p in folder.rglob(path.stem + ".cpp")), None)
            if own is not None and includes(own)[:1] and Path(includes(own)[0]).name == path.name:
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


main(sys.argv[1:])
