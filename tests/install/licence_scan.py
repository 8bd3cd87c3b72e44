#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""licence_scan.py SOURCE [--permissive LIBRARY...]: fails if a licence is missing, or copyleft code reaches a
permissive room.

1. Every source, build file and script names its licence in its first lines, and the one that its folder demands.
2. AGPL code stands in a folder of its own, and includes nothing of this project; nothing else includes TetGen.
3. A file of the permissive rooms includes no header of libspheretree and of no copyleft library; neither does an
   Apache-2.0 file of the tests and samples.
4. The LIBRARYs, built from the permissive rooms, neither need nor contain anything of those. """
import re
import subprocess
import sys
from pathlib import Path

CODE = {".cpp", ".h", ".hpp", ".c", ".py", ".sh", ".cmake", ".in", ".map", ".txt"}
NAMES = {"CMakeLists.txt", ".clang-tidy", ".editorconfig", ".ci/run"}
SKIPPED_FOLDERS = {".git", "build", "out", ".cache"}
PERMISSIVE = ("libruntime/", "formats/", "device/", "samples/make_samples/", "tools/python/core/", "tools/python/spheretree/")
COPYLEFT = ("libspheretree/", "tools/spheretree/", "tools/python/builder/", "tools/robot/")
NETWORK_COPYLEFT = ("tools/voronoi_oracle/", "tools/tetrahedra/")
INCLUDE = re.compile(r'#\s*include\s*[<"]([^">]+)[">]')
COPYLEFT_HEADER = re.compile(r"CGAL/|OpenMesh/|tetgen|spheretree/builder/|gmp|mpfr|libspheretree/", re.IGNORECASE)
PERMISSIVE_SOURCES = ("libruntime/runtime/src", "formats/src")  # with folders that may be named like those of libspheretree
COPYLEFT_BINARY = re.compile(r"CGAL|OpenMesh|tetgen|spheretree7builder|libgmp|libmpfr", re.IGNORECASE)


def sources(root: Path):
    for path in sorted(root.rglob("*")):
        name = path.relative_to(root)
        if any(part in SKIPPED_FOLDERS or part.startswith("build") for part in name.parts[:-1]) or not path.is_file():
            continue
        is_code = path.suffix in CODE and (path.suffix != ".txt" or path.name == "CMakeLists.txt")
        if is_code or str(name) in NAMES:
            yield str(name), path.read_text(encoding="utf-8")


def is_of_builder(root: Path, header: str) -> bool:
    """Whether it is a header of libspheretree, and of it alone."""
    return (root / "libspheretree/src" / header).is_file() and not any((root / folder / header).is_file() for folder in PERMISSIVE_SOURCES)


def scan_sources(root: Path):
    count = 0
    for name, text in sources(root):
        count += 1
        found = re.search(r"SPDX-License-Identifier: (\S+)", "\n".join(text.splitlines()[:2]))
        if not found:
            yield f"{name}: no SPDX-License-Identifier in its first two lines"
            continue
        licence = found.group(1)
        if name.startswith(NETWORK_COPYLEFT):
            if licence != "AGPL-3.0-only":
                yield f"{name}: licence {licence} is not AGPL-3.0-only"
            if re.search(r'#\s*include\s*[<"](spheretree/|CGAL/|OpenMesh/)', text):
                yield f"{name}: AGPL code includes what is not under the AGPL"
            continue
        if re.search(r'#\s*include\s*[<"]tetgen', text):
            yield f"{name}: includes TetGen outside {' and '.join(NETWORK_COPYLEFT)}"
        if licence not in ("Apache-2.0", "GPL-3.0-or-later"):
            yield f"{name}: licence {licence} is neither Apache-2.0 nor GPL-3.0-or-later"
        if name.startswith(PERMISSIVE) and licence != "Apache-2.0":
            yield f"{name}: {licence} in a permissive room"
        for header in INCLUDE.findall(text) if licence != "GPL-3.0-or-later" else []:
            if COPYLEFT_HEADER.match(header) or is_of_builder(root, header):
                yield f"{name}: includes {header} in a file under {licence}"
        if name.startswith(COPYLEFT) and name.endswith(".cpp") and licence != "GPL-3.0-or-later":
            yield f"{name}: {licence} in a GPL room"
    if count < 50:
        yield f"only {count} files found below {root}: the scan looks in the wrong place"


def scan_library(path: str):
    symbols = subprocess.run(["nm", "-C" if path.endswith(".so") else "-A", path], capture_output=True, text=True, check=True).stdout
    needed = "" if path.endswith(".a") else subprocess.run(["readelf", "-d", path], capture_output=True, text=True, check=True).stdout
    for line in (symbols + needed).splitlines():
        if COPYLEFT_BINARY.search(line.removeprefix(path)):
            yield f"{path}: {line.strip()}"


def main(arguments):
    if not arguments:
        sys.exit(__doc__)
    split = arguments.index("--permissive") if "--permissive" in arguments else len(arguments)
    faults = list(scan_sources(Path(arguments[0])))
    for library in arguments[split + 1 :]:
        faults += scan_library(library)
    print("\n".join(faults) if faults else "licences: nothing to complain about")
    sys.exit(1 if faults else 0)


main(sys.argv[1:])
