#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""robot_spheres.py BUILD [CHART.svg]: surface left uncovered and overhang against the number of spheres of a robot's
links.

The links are the STL links of both sample robots. Each way follows the rule that its authors publish for a number N:
  robot      spheretree robot --links '*=N'
  medial     a sphere-tree of the medial axis (Bradshaw, O'Sullivan 2004; what foam calls): build --builder merge
  octree     cells of an octree on the surface, each in a sphere: build --builder octree
  voxels     centres of a grid of pitch (V / N)^(1/3) inside the link, each with the largest ball within
             (cuRobo, VOXEL_VOLUME_INSIDE)
  samples    N points spread over the surface, balls of 5 mm (cuRobo, SAMPLE_SURFACE)
All are measured by `spheretree evaluate`. Prints the table of docs/robots.md, and draws its chart. Takes two
minutes."""
import json
import math
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

build = Path(sys.argv[1]).resolve()
sys.path.insert(0, str(build / "python"))
import spheretree  # noqa: E402

COUNTS = {8: (8, 1), 16: (4, 2), 27: (3, 3), 64: (8, 2), 125: (5, 3)}  # spheres: as children of a node, and how often
WAYS = {"robot": "#0072b2", "medial": "#d55e00", "octree": "#009e73", "voxels": "#cc79a7", "samples": "#e69f00"}
PROGRAM = build / "tools/spheretree/spheretree"
FLOOR = 1e-3  # of overhangs in a geometric mean [mm]
SAMPLE_RADIUS = 0.005  # [m], the default of cuRobo


def run(*words, codes=(0,)):
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True)
    if done.returncode not in codes:
        sys.exit(f"robot_spheres.py: {' '.join(map(str, words))}: exit code {done.returncode}\n{done.stderr}")
    return done.stdout


def surface_distance(points, corners):
    """Distance of each point from the nearest triangle (corners: (m, 3, 3))."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    ab, ac = b - a, c - a
    normal = np.cross(ab, ac)
    length = np.linalg.norm(normal, axis=1)
    keep = length > 0
    a, b, c, ab, ac, normal = a[keep], b[keep], c[keep], ab[keep], ac[keep], normal[keep] / length[keep, None]

    def to_side(p, from_, way):
        t = np.clip(np.einsum("ij,ij->i", p - from_, way) / np.einsum("ij,ij->i", way, way), 0, 1)
        return np.linalg.norm(p - from_ - t[:, None] * way, axis=1)

    out = np.empty(len(points))
    for i, p in enumerate(points):
        ap = p - a
        height = np.einsum("ij,ij->i", ap, normal)
        inside = np.ones(len(a), bool)
        for from_, way in ((a, ab), (b, c - b), (c, a - c)):
            inside &= np.einsum("ij,ij->i", np.cross(way, p - from_), normal) >= 0
        sides = np.minimum(np.minimum(to_side(p, a, ab), to_side(p, b, c - b)), to_side(p, c, a - c))
        out[i] = np.where(inside, np.abs(height), sides).min()
    return out


def is_inside(points, corners):
    """By the winding number: the solid angle of all triangles (van Oosterom, Strackee 1983)."""
    out = np.empty(len(points), bool)
    for i, p in enumerate(points):
        a, b, c = (corners[:, k] - p for k in range(3))
        la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
        over = np.einsum("ij,ij->i", a, np.cross(b, c))
        under = la * lb * lc + np.einsum("ij,ij->i", a, b) * lc + np.einsum("ij,ij->i", b, c) * la + np.einsum("ij,ij->i", c, a) * lb
        out[i] = abs(2 * np.arctan2(over, under).sum()) > 2 * math.pi
    return out


def voxels(mesh, corners, count):
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    volume = abs(np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum()) / 6
    pitch = (volume / count) ** (1 / 3)
    axes = [np.arange(l + pitch / 2, h, pitch) for l, h in zip(low, high)]
    centres = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    centres = centres[is_inside(centres, corners)]
    return centres, surface_distance(centres, corners)


def samples(corners, count):
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    random = np.random.default_rng(1)
    t = random.choice(len(corners), 20 * count, p=area / area.sum())
    u = random.random((20 * count, 2))
    u = np.where(u.sum(axis=1, keepdims=True) > 1, 1 - u, u)
    points = corners[t, 0] + u[:, :1] * (corners[t, 1] - corners[t, 0]) + u[:, 1:] * (corners[t, 2] - corners[t, 0])
    chosen, far = [0], np.linalg.norm(points - points[0], axis=1)
    while len(chosen) < count:  # the farthest point from those that are there
        chosen.append(int(far.argmax()))
        far = np.minimum(far, np.linalg.norm(points - points[chosen[-1]], axis=1))
    return points[chosen], np.full(count, SAMPLE_RADIUS)


def figures(mesh_file, spheres):
    """Spheres that have a volume, the part of the surface that is uncovered, and the overhang [mm]."""
    text = run(PROGRAM, "evaluate", mesh_file, spheres, "--unit", "m", "--no-limits", "--json", "-q")
    level = json.loads(text)["levels"][-1]
    return level["spheres"], level["uncovered_fraction"], level["overhang_mm"]["max"]


def of_way(way, mesh_file, count, folder):
    spheres = folder / "spheres.json"
    mesh = spheretree.read(mesh_file)  # its numbers, metres
    corners = np.asarray(mesh.vertices)[np.asarray(mesh.triangles)]
    if way == "robot":
        urdf = folder / "link.urdf"
        urdf.write_text(f'<robot name="link"><link name="a"><collision><geometry><mesh filename="{mesh_file}"/></geometry></collision></link></robot>')
        run(PROGRAM, "robot", urdf, "-o", folder / "out", "--links", f"*={count}", "-q")
        return figures(mesh_file, folder / "out/link.ballpark.json")
    if way in ("medial", "octree"):
        tree = folder / "link.stree"
        builder = {"medial": "merge", "octree": "octree"}[way]
        run(PROGRAM, "build", mesh_file, "-o", tree, "--unit", "m", "--builder", builder, "--branching", COUNTS[count][0], "--levels",
            COUNTS[count][1] + 1, "--skin", "off", "-q")
        run(PROGRAM, "convert", tree, spheres, "--level", len(json.loads(run(PROGRAM, "inspect", tree, "--json"))["levels"]) - 1, "--unit", "m", "-q")
        return figures(mesh_file, spheres)
    centres, radii = voxels(mesh, corners, count) if way == "voxels" else samples(corners, count)
    spheres.write_text(json.dumps({"a": {"centers": centres.tolist(), "radii": radii.tolist()}}))
    return figures(mesh_file, spheres)


def chart(path, bare, overhang):
    """Two panels over the number of spheres: per cent uncovered, and overhang on a logarithmic axis."""
    width, height, left, top, panel, gap = 890, 330, 60, 46, 300, 110
    shown = [v for values in overhang.values() for v in values if v > 1.01 * FLOOR]  # balls within the link have none
    low, high = 0.7 * min(shown), 1.3 * max(shown)
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" font-family="sans-serif" font-size="13">',
           f'<rect width="{width}" height="{height}" fill="#fff"/>']
    x_of = lambda k, n: left + k * (panel + gap) + panel * math.log(n / 8) / math.log(125 / 8)
    bottom = height - 50
    for k, (title, values) in enumerate((("surface left uncovered [%]", bare), ("overhang [mm]", overhang))):
        y_of = ((lambda v: bottom - (bottom - top) * v / 100) if k == 0 else
                (lambda v: bottom - (bottom - top) * math.log(v / low) / math.log(high / low)))
        out.append(f'<text x="{left + k * (panel + gap)}" y="{top - 22}" font-weight="bold" fill="#222">{title}</text>')
        ticks = (0, 25, 50, 75, 100) if k == 0 else [t for t in (1, 2, 5, 10, 20, 50, 100, 200) if low <= t <= high]
        for tick in ticks:
            out.append(f'<path d="M{left + k * (panel + gap)} {y_of(tick):.1f}h{panel}" stroke="#ddd"/>')
            out.append(f'<text x="{left + k * (panel + gap) - 8}" y="{y_of(tick) + 4:.1f}" text-anchor="end" fill="#444">{tick}</text>')
        for n in COUNTS:
            out.append(f'<text x="{x_of(k, n):.1f}" y="{bottom + 18}" text-anchor="middle" fill="#444">{n}</text>')
        out.append(f'<text x="{left + k * (panel + gap) + panel / 2}" y="{bottom + 38}" text-anchor="middle" fill="#444">spheres a link</text>')
        for way, colour in WAYS.items():
            points = " ".join(f"{x_of(k, n):.1f},{y_of(v):.1f}" for n, v in zip(COUNTS, values[way]) if k == 0 or v > 1.01 * FLOOR)
            out.append(f'<polyline points="{points}" fill="none" stroke="{colour}" stroke-width="{3 if way == "robot" else 1.8}"/>')
    for i, (way, colour) in enumerate(WAYS.items()):
        x, y = left + 2 * panel + gap + 12, top + 22 * i
        out.append(f'<path d="M{x} {y}h22" stroke="{colour}" stroke-width="{3 if way == "robot" else 1.8}"/><text x="{x + 28}" y="{y + 4}" fill="#222">{way}</text>')
    Path(path).write_text("\n".join(out) + "\n</svg>\n", encoding="utf-8")


with tempfile.TemporaryDirectory() as name:
    root = Path(name)
    run(build / "samples/make_samples/make_samples", "--robots", root / "robots")
    meshes = sorted((root / "robots").glob("*/meshes/*.stl"))
    bare, overhang, counts = ({way: [] for way in WAYS} for _ in range(3))
    for n in COUNTS:
        for way in WAYS:
            rows = [of_way(way, mesh, n, root) for mesh in meshes]
            counts[way].append(np.mean([row[0] for row in rows]))
            bare[way].append(100 * np.mean([row[1] for row in rows]))
            overhang[way].append(math.exp(np.mean([math.log(max(row[2], FLOOR)) for row in rows])))
        if sys.stderr.isatty():
            print(f"{n} spheres", file=sys.stderr)
print(f"| spheres of each of {len(meshes)} links | " + " | ".join(WAYS) + " |")
print("|---|" + "---|" * len(WAYS))
for i, n in enumerate(COUNTS):
    print(f"| {n} | " + " | ".join(f"{bare[way][i]:.0f} % uncovered, {float(f'{overhang[way][i]:.2g}') if overhang[way][i] > 1.01 * FLOOR else 0:g} mm" for way in WAYS) + " |")
print("\nspheres with a volume: " + "; ".join(way + " " + ", ".join(f"{c:.0f}" for c in counts[way]) for way in WAYS))
if len(sys.argv) > 2:
    chart(sys.argv[2], bare, overhang)
