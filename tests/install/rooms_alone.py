#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""rooms_alone.py SOURCE WORK [--build]: each room configures alone, with no library but its own; with --build it is
built, too.

Libraries that a room does not name are hidden from find_package, so that a room that starts to need one fails here."""
import subprocess
import sys
from pathlib import Path

source, work = Path(sys.argv[1]), Path(sys.argv[2])
builds = "--build" in sys.argv[3:]
LIBRARIES = {"CGAL", "TBB", "OpenMesh", "nlohmann_json", "meshoptimizer", "draco", "CLI11", "PNG", "ZLIB", "GTest", "Python3", "Threads"}
ROOMS = {  # option: libraries beside Eigen, target
    "runtime": (set(), "spheretree_runtime_c"),
    "formats": ({"nlohmann_json", "meshoptimizer", "draco"}, "spheretree_formats"),
    "device": ({"Threads"}, "spheretree_device"),
    "builder": ({"CGAL", "TBB", "OpenMesh", "Threads"}, "spheretree_builder"),
}
faults = []
for room, (needed, target) in ROOMS.items():
    options = [f"-DSPHERETREE_{other.upper()}={'ON' if other == room else 'OFF'}" for other in [*ROOMS, "tools", "python", "tests"] if other != "runtime"]
    hidden = [f"-DCMAKE_DISABLE_FIND_PACKAGE_{library}=ON" for library in sorted(LIBRARIES - needed)]
    run = subprocess.run(["cmake", "-S", source, "-B", work / room, *options, *hidden], capture_output=True, text=True)
    if run.returncode == 0 and builds:
        run = subprocess.run(["cmake", "--build", work / room, "--parallel", "--target", target], capture_output=True, text=True)
    if run.returncode != 0:
        faults.append(f"{room} alone: {' '.join(run.stderr.split())[:500] or run.stdout[-500:]}")
# The programs report the missing rooms rather than fail during the build.
run = subprocess.run(["cmake", "-S", source, "-B", work / "tools", "-DSPHERETREE_TOOLS=ON", "-DSPHERETREE_DEVICE=OFF", "-DSPHERETREE_TESTS=OFF"],
                     capture_output=True, text=True)
if run.returncode == 0 or "SPHERETREE_TOOLS needs" not in run.stderr:
    faults.append("the programs without the devices: no message that they need them")
print("\n".join(faults) if faults else f"rooms_alone: {', '.join(ROOMS)}: each {'builds' if builds else 'configures'} alone")
sys.exit(1 if faults else 0)
