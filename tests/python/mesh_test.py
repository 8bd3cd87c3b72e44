# SPDX-License-Identifier: Apache-2.0
"""Meshes: from arrays and files, as arrays again, without copies that nobody asked for."""
import subprocess
import sys

import numpy as np
import pytest
from conftest import box, ellipsoid

import spheretree


@pytest.mark.parametrize("real", ["f8", "f4", ">f8", "i4", "i8", "i2"])
@pytest.mark.parametrize("whole", ["i8", "i4", "u4", "u8", "i2", ">i4"])
def test_every_kind_of_number_gives_the_same_mesh(real, whole):
    vertices, triangles = box()
    mesh = spheretree.Mesh(vertices.astype(real), triangles.astype(whole))
    assert np.array_equal(mesh.vertices, vertices) and mesh.vertices.dtype == np.float64
    assert np.array_equal(mesh.triangles, triangles) and mesh.triangles.dtype == np.uint32


def test_strides_do_not_matter():
    vertices, triangles = ellipsoid()
    for v, t in [(np.asfortranarray(vertices), np.asfortranarray(triangles)), (np.repeat(vertices, 2, 0)[::2], triangles),
                 (vertices[::-1], len(vertices) - 1 - triangles)]:
        mesh = spheretree.Mesh(v, t)
        assert np.array_equal(mesh.vertices, v) and np.array_equal(mesh.triangles, t)


def test_lists_are_fine_and_equal_vertices_become_one():
    corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [7, 7, 7]]
    mesh = spheretree.Mesh(corners, [[0, 1, 2], [3, 4, 5]])
    assert mesh.vertices.tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]]
    assert mesh.triangles.tolist() == [[0, 1, 2], [1, 3, 2]]


def test_views_are_read_only_and_keep_the_mesh_alive():
    vertices, triangles = ellipsoid()
    view = spheretree.Mesh(vertices, triangles).vertices
    assert view.tolist() == vertices.tolist()
    with pytest.raises(ValueError):
        view[0, 0] = 1
    mesh = spheretree.Mesh(vertices, triangles)
    assert np.shares_memory(mesh.vertices, mesh.vertices) and np.shares_memory(mesh.triangles, mesh.triangles)
    vertices[:] = 0  # the arrays given were read, not kept
    assert mesh.vertices.any()


@pytest.mark.parametrize("vertices, triangles, error, says", [
    (np.zeros((4, 2)), np.zeros((1, 3), int), ValueError, "(4, 2)"),
    (np.zeros(12), np.zeros((1, 3), int), ValueError, "(12,)"),
    (np.zeros((4, 3)), np.zeros((1, 4), int), ValueError, "quad"),
    (np.zeros((4, 3)), np.zeros((0, 3), int), ValueError, "empty"),
    (np.zeros((4, 3)), np.zeros((1, 3)), TypeError, "float64"),
    (np.zeros((4, 3), complex), np.zeros((1, 3), int), TypeError, "complex128"),
    (np.zeros((4, 3)), np.array([[0, 1, 2], [0, 1, 4]]), IndexError, "triangles[1] names vertex 4"),
    (np.zeros((4, 3)), np.array([[0, -1, 2]]), IndexError, "vertex -1"),
    (np.zeros((4, 3)), np.array([[0, 1, 2**32]]), IndexError, "4294967296"),
])
def test_refusals_say_what_and_where(vertices, triangles, error, says):
    with pytest.raises(error) as refusal:
        spheretree.Mesh(vertices, triangles)
    assert says in str(refusal.value)


def test_files_round_trip_without_loss(tmp_path):
    vertices, triangles = ellipsoid((1 / 3, 2 / 7, 0.1))
    mesh = spheretree.Mesh(vertices, triangles)
    for name in ["a.ply", "a.obj"]:
        mesh.save(tmp_path / name)
        again = spheretree.read(tmp_path / name)
        assert np.array_equal(again.vertices, mesh.vertices) and np.array_equal(again.triangles, mesh.triangles)
    in_metres = spheretree.read(tmp_path / "a.ply", unit="m")
    assert in_metres.unit_mm == 1000 and np.array_equal(in_metres.vertices, 1000 * mesh.vertices)
    with pytest.raises(spheretree.FileError) as missing:
        spheretree.read(tmp_path / "none.obj")
    assert isinstance(missing.value, OSError) and "none.obj" in str(missing.value)
    (tmp_path / "bad.obj").write_text("v 0 0 nothing\n")
    with pytest.raises(spheretree.FormatError):
        spheretree.read(tmp_path / "bad.obj")
    with pytest.raises(ValueError):
        spheretree.read(tmp_path / "a.ply", unit="ft")
    with pytest.raises(ValueError):
        mesh.save(tmp_path / "a.stl")


MEMORY = """
import sys
import numpy as np
import spheretree

def memory(field):
    with open("/proc/self/status") as status:
        return next(int(line.split()[1]) * 1024 for line in status if line.startswith(field))

side = 1000
i, j = np.meshgrid(np.arange(side), np.arange(side), indexing="ij")
vertices = np.stack([i, j, np.sin(i) * np.cos(j)], -1).reshape(-1, 3).astype(sys.argv[1])
a = (i * side + j)[:-1, :-1].ravel()
triangles = np.concatenate([np.stack([a, a + side, a + 1], -1), np.stack([a + 1, a + side, a + side + 1], -1)]).astype(sys.argv[2])
with open("/proc/self/clear_refs", "w") as peak:
    peak.write("5")  # the peak is what is in use now
before = memory("VmRSS")
mesh = spheretree.Mesh(vertices, triangles)
views = [mesh.vertices, mesh.triangles]
print(len(mesh.vertices), memory("VmHWM") - before, views[0].nbytes + views[1].nbytes)
"""


@pytest.mark.parametrize("kinds", [("f8", "i8"), ("f4", "i4"), ("f8", "u4")])
def test_a_million_vertices_are_copied_once(kinds):
    out = subprocess.run([sys.executable, "-c", MEMORY, *kinds], check=True, capture_output=True, text=True).stdout
    count, most, held = map(int, out.split())
    assert count == 10**6
    # The mesh itself; while equal vertices are looked for 4 bytes for each, and 4 for each slot of a table of 2**21.
    assert 0.9 * held < most < held + 4 * 10**6 + 4 * 2**21 + 2 * 10**6
