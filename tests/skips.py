#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""skips.py JUNIT.xml [MESHES]: fails if a test was skipped that tests/allowed_skips.txt does not allow on this machine.

JUNIT.xml is what `ctest --output-junit` writes; MESHES is the folder of the mesh collection, if there is one."""
import os
import re
import shutil
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

CONDITIONS = {
    "always": lambda meshes: True,
    "no-collection": lambda meshes: not meshes.is_dir(),
    "no-judge": lambda meshes: not (meshes.parent / "judge").is_dir(),
    "short": lambda meshes: os.environ.get("SPHERETREE_LONG") != "1",
    "root": lambda meshes: os.geteuid() == 0,
    "no-avx2": lambda meshes: not re.search(r"\bavx2\b", Path("/proc/cpuinfo").read_text(encoding="utf-8")),
    "other-machine": lambda meshes: "SPHERETREE_MACHINE" in os.environ,  # .ci/lane windows and arm64
    "no-browser": lambda meshes: not (shutil.which("chromium") and shutil.which("chromedriver")),
    "no-display": lambda meshes: not (shutil.which("Xvfb") and shutil.which("xdotool")),
    "no-slurm": lambda meshes: not shutil.which("slurmctld"),
    "no-snakemake": lambda meshes: not shutil.which("snakemake"),
    "no-mono": lambda meshes: not (shutil.which("mcs") and shutil.which("mono")),
    "no-parallel": lambda meshes: not shutil.which("parallel"),
}


def allowed_here(path, meshes):
    """Names of tests, as patterns, that may be skipped on this machine."""
    patterns = []
    for line in path.read_text(encoding="utf-8").splitlines():
        if line.strip() and not line.startswith("#"):
            condition, pattern = line.split()[:2]
            if any(CONDITIONS[one](meshes) for one in condition.split("|")):
                patterns.append(re.compile(pattern.replace(".", r"\.").replace("*", ".*")))
    return patterns


def main():
    """Prints nothing if all is well, so that the summary of CTest stays the last line."""
    meshes = Path(sys.argv[2] if len(sys.argv) > 2 else Path(__file__).resolve().parents[2] / "shared/meshes")
    skipped = [case.get("name") for case in ElementTree.parse(sys.argv[1]).iter("testcase") if case.find("skipped") is not None]
    patterns = allowed_here(Path(__file__).with_name("allowed_skips.txt"), meshes)
    unexpected = [name for name in skipped if not any(pattern.fullmatch(name) for pattern in patterns)]
    for name in unexpected:
        print(f"skips: {name} was skipped; tests/allowed_skips.txt does not allow it on this machine")
    return 1 if unexpected else 0


if __name__ == "__main__":
    sys.exit(main())
