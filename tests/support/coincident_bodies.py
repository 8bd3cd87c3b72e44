# SPDX-License-Identifier: Apache-2.0
"""Meshes of bodies that nearly coincide, which drive a repair to its bounds. Each function returns vertices and
triangles; `offset` is the size of the differences, as a share of the size of the bodies."""
import math
import random


def _joined(bodies):
    points, faces = [], []
    for own_points, own_faces in bodies:
        first = len(points)
        points += own_points
        faces += [tuple(first + v for v in face) for face in own_faces]
    return points, faces


def _ball(side):
    """A sphere of radius 1 with `side` points round it."""
    points = [(0, 0, 1), (0, 0, -1)]
    rings = side // 2 - 1
    for i in range(rings):
        v = math.pi * (i + 1) / (rings + 1)
        points += [(math.sin(v) * math.cos(2 * math.pi * j / side), math.sin(v) * math.sin(2 * math.pi * j / side), math.cos(v))
                   for j in range(side)]
    at = lambda i, j: 2 + i * side + j % side
    faces = [(0, at(0, j), at(0, j + 1)) for j in range(side)] + [(1, at(rings - 1, j + 1), at(rings - 1, j)) for j in range(side)]
    for i in range(rings - 1):
        for j in range(side):
            faces += [(at(i, j), at(i + 1, j), at(i + 1, j + 1)), (at(i, j), at(i + 1, j + 1), at(i, j + 1))]
    return points, faces


def _box(low, high):
    points = [tuple((low, high)[i >> k & 1][k] for k in range(3)) for i in range(8)]
    quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    return points, [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]


def _plate(side, height):
    """A plate of size 1, 0.1 thick, with side^2 squares above and below; `height(i, j)` raises its points."""
    top = [(i / side, j / side, 0.1 + height(i, j)) for i in range(side + 1) for j in range(side + 1)]
    points = top + [(x, y, z - 0.1) for x, y, z in top]
    at = lambda i, j: i * (side + 1) + j
    faces = []
    for i in range(side):
        for j in range(side):
            a, b, c, d = at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)
            faces += [(a, b, c), (a, c, d)]
    faces += [(len(top) + a, len(top) + c, len(top) + b) for a, b, c in faces]
    rim = [at(i, 0) for i in range(side)] + [at(side, j) for j in range(side)] + [at(side - i, side) for i in range(side)]
    rim += [at(0, side - j) for j in range(side)]
    for a, b in zip(rim, rim[1:] + rim[:1]):
        faces += [(a, len(top) + a, len(top) + b), (a, len(top) + b, b)]
    return points, faces


def plates(offset, side=16, count=2):
    """Plates in one place whose points are up to `offset` higher or lower."""
    source = random.Random(1)
    return _joined([_plate(side, lambda i, j: offset * source.uniform(-1, 1)) for _ in range(count)])


def balls(offset, count=10, side=16):
    """Balls in one place, shifted by up to `offset` and turned by as much."""
    source = random.Random(2)
    bodies = []
    for _ in range(count):
        points, faces = _ball(side)
        shift, turn = [offset * source.uniform(-1, 1) for _ in range(3)], offset * source.uniform(-1, 1)
        c, s = math.cos(turn), math.sin(turn)
        bodies.append(([(c * x - s * y + shift[0], s * x + c * y + shift[1], z + shift[2]) for x, y, z in points], faces))
    return _joined(bodies)


def stacked(offset, count=10):
    """Boxes whose sides lie in one plane up to `offset`."""
    source = random.Random(3)
    move = lambda x: x + offset * source.uniform(-1, 1)
    return _joined([_box((move(0), move(0), move(i / 2)), (move(1), move(1), move(i / 2 + 1))) for i in range(count)])


def strips(offset, count=150):
    """Long thin boxes through one middle, all in one plane up to `offset`."""
    source = random.Random(4)
    bodies = []
    for i in range(count):
        points, faces = _box((-1, -0.004, -0.002), (1, 0.004, 0.002))
        c, s = math.cos(math.pi * i / count), math.sin(math.pi * i / count)
        lift, tilt = offset * source.uniform(-1, 1), offset * source.uniform(-1, 1)
        bodies.append(([(c * x - s * y, s * x + c * y, z + lift + tilt * x) for x, y, z in points], faces))
    return _joined(bodies)


def grid(offset, count=120):
    """Long thin boxes, one half across the other, all in one plane up to `offset`."""
    source = random.Random(5)
    bodies = []
    for i in range(count):
        middle = (i // 2 + 0.5) / (count // 2)
        low, high = (0, middle - 0.002, -0.002), (1, middle + 0.002, 0.002)
        points, faces = _box(low, high)
        lift, tilt = offset * source.uniform(-1, 1), offset * source.uniform(-1, 1)
        points = [(x, y, z + lift + tilt * x) for x, y, z in points]
        if i % 2:
            points, faces = [(y, x, z) for x, y, z in points], [(a, c, b) for a, b, c in faces]
        bodies.append((points, faces))
    return _joined(bodies)


KINDS = {"plates": plates, "balls": balls, "stacked": stacked, "strips": strips, "grid": grid}


def write_obj(path, mesh, scale=20):
    points, faces = mesh
    lines = [f"v {scale * x!r} {scale * y!r} {scale * z!r}" for x, y, z in points]
    lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in faces]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
