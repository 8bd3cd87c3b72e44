#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""judged_trees.py JUDGE SPHERETREE MAKE_SAMPLES FOLDER: an outside opinion on trees of whole meshes.

Builds the molar by the default builder and the probe by a published one, writes the trees as .sph, and has an
independent program measure them. Every level must cover the surface, and no cover sphere may reach out of the bounding
sphere of any node above it. Exit code 77: the other program is missing. """
import json
import subprocess
import sys
from pathlib import Path

judge, spheretree, make_samples, folder = sys.argv[1:]
if not Path(judge).is_file():
    sys.exit(77)
work = Path(folder)
work.mkdir(parents=True, exist_ok=True)


def run(*command):
    return subprocess.run([str(part) for part in command], check=True, capture_output=True, text=True).stdout


def nodes(path):
    """Spheres of a .sph file by slot, None where unused; branching."""
    lines = path.read_text().splitlines()
    branching = int(lines[0].split()[1])
    spheres = [[float(word) for word in line.split()[:4]] for line in lines[1:]]
    return [s if s[3] > 0 else None for s in spheres], branching


faults = []
run(make_samples, work)
for name, builder in (("molar", "cover"), ("probe", "merge")):
    mesh, tree = work / f"{name}.obj", work / f"{name}.{builder}.stree"
    cover, bound = work / f"{name}.{builder}.cover.sph", work / f"{name}.{builder}.bound.sph"
    run(spheretree, "build", mesh, "-o", tree, "--builder", builder, "--quality", "quick", "-q")
    run(spheretree, "convert", tree, cover, "--spheres", "cover")
    run(spheretree, "convert", tree, bound, "--spheres", "bound")

    verdict = json.loads(run(judge, mesh, cover, "--json", "--no-reference"))
    levels = verdict["level"]
    if len(levels) != 4:
        faults.append(f"{name}: {len(levels)} levels judged, not 4")
    for level in levels:
        uncovered, gap = level["coverage"]["uncovered_fraction"], level["coverage"]["max_gap"]
        print(f"{name} level {level['level']}: {level['spheres']} spheres, uncovered {uncovered}, gap {gap} mm, "
              f"overhang {level['protrusion']['outside']['max']} mm")
        if uncovered != 0 or gap != 0:
            faults.append(f"{name}: level {level['level']} leaves {uncovered} of the surface uncovered, gap {gap} mm")
    if verdict["hierarchy"]["not_finite"] or verdict["hierarchy"]["zero_radius"] or verdict["hierarchy"]["children_of_unused"]:
        faults.append(f"{name}: not a tree: {verdict['hierarchy']}")

    # Every bounding sphere holds every cover sphere below it; 9 digits are written, hence the tolerance.
    inner, branching = nodes(bound)
    covers, _ = nodes(cover)
    for child, sphere in enumerate(covers):
        node = child
        while sphere and node > 0:
            node = (node - 1) // branching
            x, y, z, r = inner[node]
            reach = ((sphere[0] - x) ** 2 + (sphere[1] - y) ** 2 + (sphere[2] - z) ** 2) ** 0.5 + sphere[3] - r
            if reach > 1e-6:
                faults.append(f"{name}: cover sphere {child} reaches {reach} mm out of the bounding sphere of {node}")

print("\n".join(faults) if faults else "nothing to complain about")
sys.exit(1 if faults else 0)
