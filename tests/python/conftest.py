# SPDX-License-Identifier: Apache-2.0
"""Meshes and programs that the tests of the package share."""
import os
import subprocess

import numpy as np
import pytest


def ellipsoid(semi_axes=(9.0, 6.0, 4.0), rings=24, dtype=np.float64):
    """Vertices and triangles of a closed ellipsoid about the origin, wound outward."""
    sides = 2 * rings
    polar, around = np.meshgrid(np.pi * np.arange(1, rings) / rings, 2 * np.pi * np.arange(sides) / sides, indexing="ij")
    points = np.stack([np.sin(polar) * np.cos(around), np.sin(polar) * np.sin(around), np.cos(polar)], -1).reshape(-1, 3)
    vertices = np.vstack([points, [[0, 0, 1], [0, 0, -1]]]) * semi_axes
    top, bottom, triangles = len(points), len(points) + 1, []
    for j in range(sides):
        k = (j + 1) % sides
        triangles.append((top, j, k))
        for i in range(rings - 2):
            a, b, c, d = i * sides + j, i * sides + k, (i + 1) * sides + k, (i + 1) * sides + j
            triangles += [(a, d, c), (a, c, b)]
        triangles.append((bottom, (rings - 2) * sides + k, (rings - 2) * sides + j))
    return np.ascontiguousarray(vertices, dtype), np.array(triangles, np.int64)


def box(size=(20.0, 20.0, 10.0)):
    """A box whose top is the plane z = 0."""
    x, y, z = np.array(size) / (2, 2, 1)
    vertices = np.array([[i, j, k] for k in (-z, 0) for j in (-y, y) for i in (-x, x)], float)
    triangles = np.array([[0, 2, 3], [0, 3, 1], [4, 5, 7], [4, 7, 6], [0, 1, 5], [0, 5, 4], [2, 6, 7], [2, 7, 3], [0, 4, 6], [0, 6, 2], [1, 3, 7], [1, 7, 5]])
    return vertices, triangles


def surface_points(vertices, triangles, count, seed=1):
    """Points at random on the surface, by area."""
    random = np.random.default_rng(seed)
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    chosen = random.choice(len(triangles), count, p=area / area.sum())
    u, v = random.random((2, count, 1))
    u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
    return a[chosen] + u * (b[chosen] - a[chosen]) + v * (c[chosen] - a[chosen])


@pytest.fixture(scope="session")
def program():
    return os.environ["SPHERETREE"]


@pytest.fixture(scope="session")
def molar(tmp_path_factory):
    """Path of the sample molar."""
    folder = tmp_path_factory.mktemp("samples")
    subprocess.run([os.environ["MAKE_SAMPLES"], folder], check=True)
    return folder / "molar.obj"
