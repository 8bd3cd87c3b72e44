#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""soft_reader.py FILE: as stree_reader.py, for .soft files: also reads and checks the sections of the tissue."""
import math
import sys

from stree_reader import Refused, demand, read, records

def tissue(tiss, leaf, response):
    (young, poisson, density, nodes, tetrahedra, fixed, vertices), = records("3d4I", 1, tiss, 0)[0]
    demand(0.1 <= young <= 1e5 and 0 <= poisson <= 0.495 and 100 <= density <= 5000, "a material")
    demand(4 <= nodes <= 2**20 and tetrahedra and vertices and len(tiss) == 40 + 24 * nodes + 40 * vertices + 16 * tetrahedra + 4 * fixed, "TISS")
    node, at = records("3d", nodes, tiss, 40)
    vertex, at = records("3dI3f", vertices, tiss, at)
    corner, at = records("4I", tetrahedra, tiss, at)
    held = [i for i, in records("I", fixed, tiss, at)[0]]
    demand(all(math.isfinite(x) for row in node + vertex for x in row) and all(v[3] < tetrahedra for v in vertex), "a node or a vertex")
    demand(all(max(c) < nodes and volume(*(node[i] for i in c)) > 0 for c in corner), "a tetrahedron")
    demand(held == sorted(set(held)) and all(i < nodes for i in held), "fixed nodes")
    (leaves, cuts, corners, reserved), = records("4I", 1, leaf, 0)[0]
    demand(not reserved and len(leaf) == 20 + 32 * cuts + 44 * leaves + 4 * corners, "TLEA")
    cut, at = records("4I2d", cuts, leaf, 16)
    anchor, at = records("3I2fI4f", leaves, leaf, at)
    begin, at = records("I", leaves + 1, leaf, at)
    demand(all(max(c[:3]) < vertices and not c[3] for c in cut) and all(max(a[:3]) < vertices and a[5] < tetrahedra for a in anchor), "a cut or an anchor")
    demand([0] + sorted(begin[1:] and [b for b, in begin[1:]]) == [b for b, in begin] and begin[-1] == [corners], "where corners begin")
    demand(all(c < vertices + cuts for c, in records("I", corners, leaf, at)[0]), "a corner")
    (pressed, points), = records("2I", 1, response, 0)[0]
    demand(len(response) == 8 + 4 * pressed + 24 * points + 36 * pressed**2, "TRES")
    press = [i for i, in records("I", pressed, response, 8)[0]]
    demand(press == sorted(set(press)) and all(i < nodes and i not in held for i in press), "nodes that are pressed")
    demand(all(i < pressed or i == 2**32 - 1 for p in records("3I3f", points, response, 8 + 4 * pressed)[0] for i in p[:3]), "a point that is pressed")

def volume(a, b, c, d):
    (x, y, z), u, v = ([q - p for p, q in zip(a, e)] for e in (b, c, d))
    return x * (u[1] * v[2] - u[2] * v[1]) + y * (u[2] * v[0] - u[0] * v[2]) + z * (u[0] * v[1] - u[1] * v[0])

if __name__ == "__main__":
    try:
        held = read(open(sys.argv[1], "rb").read())[0]
        demand(all(name in held for name in ("TISS", "TLEA", "TRES")), "no tissue")
        tissue(held["TISS"], held["TLEA"], held["TRES"])
        print(len(held["TISS"]), "bytes of tissue")
    except Refused as reason:
        sys.exit(f"{sys.argv[1]}: {reason}")
