# SPDX-License-Identifier: Apache-2.0
"""Trees: levels without a copy, files and bytes."""
import pickle

import numpy as np
import pytest
from conftest import ellipsoid

import spheretree


@pytest.fixture(scope="module")
def tree():
    return spheretree.build(*ellipsoid(), quality="quick", levels=4)


@pytest.fixture(scope="module")
def uneven():
    """A tree with leaves that end before the last level."""
    tree = spheretree.build(*ellipsoid((20, 3, 2)), quality="quick", builder="merge", tolerance=0.5)
    begin = tree.level_begin
    assert (tree.child_count[:begin[-2]] == 0).any()
    return tree


def test_levels_are_views_of_the_tree(tree):
    for level in range(tree.level_count):
        centres, radii = tree.level(level)
        assert centres.dtype == radii.dtype == np.float32 and centres.shape == (len(radii), 3)
        rows = tree.cover[tree.level_begin[level]:tree.level_begin[level + 1]]
        assert np.array_equal(centres, rows[:, :3]) and np.array_equal(radii, rows[:, 3])
        assert np.shares_memory(centres, tree.cover) and np.shares_memory(radii, tree.cover)
        assert not centres.flags.writeable and not radii.flags.writeable and not centres.flags.owndata
    assert np.array_equal(tree.level(-1)[1], tree.level(3)[1])
    for level in (4, -5):
        with pytest.raises(IndexError, match="0 to 3"):
            tree.level(level)


def test_levels_hold_the_leaves_that_ended_early(uneven):
    begin, is_leaf = uneven.level_begin, uneven.child_count == 0
    for level in range(uneven.level_count):
        nodes = np.arange(begin[level + 1])
        nodes = nodes[(nodes >= begin[level]) | is_leaf[nodes]]
        centres, radii = uneven.level(level)
        assert np.array_equal(np.column_stack([centres, radii]), uneven.cover[nodes])
        assert np.shares_memory(centres, uneven.level(level)[0]) and not centres.flags.owndata


def test_arrays_outlive_the_tree():
    centres, radii = spheretree.build(*ellipsoid(), quality="quick", levels=2).level(1)
    copies = centres.copy(), radii.copy()
    for _ in range(3):
        spheretree.build(*ellipsoid((5, 5, 5)), quality="quick", levels=2)
    assert np.array_equal(centres, copies[0]) and np.array_equal(radii, copies[1])


def test_nodes_are_a_tree(uneven):
    first, count, begin = uneven.first_child.astype(int), uneven.child_count.astype(int), uneven.level_begin
    assert begin[0] == 0 and begin[-1] == uneven.node_count and len(begin) == uneven.level_count + 1
    children = np.concatenate([np.arange(f, f + c) for f, c in zip(first, count) if c])
    assert sorted(children) == list(range(1, uneven.node_count))
    assert uneven.leaf_count == (count == 0).sum() == len(uneven.level(-1)[1]) and count.max() <= uneven.branching
    inner = np.flatnonzero(count)
    assert np.array_equal(uneven.bound_index[inner], np.arange(len(inner))) and (uneven.bound_index[count == 0] == 2**32 - 1).all()
    for node in inner:  # every child lies within the bounding sphere
        bound = uneven.bound[uneven.bound_index[node]].astype(float)
        below = uneven.cover[first[node]:first[node] + count[node]].astype(float)
        assert (np.linalg.norm(below[:, :3] - bound[:3], axis=1) + below[:, 3] <= bound[3] * (1 + 1e-6)).all()


def test_bytes_files_and_pickles_are_the_same_tree(tree, tmp_path):
    content = tree.to_bytes()
    assert spheretree.SphereTree.from_bytes(content).to_bytes() == content
    assert pickle.loads(pickle.dumps(tree)).to_bytes() == content
    tree.save(tmp_path / "a.stree")
    assert (tmp_path / "a.stree").read_bytes() == content
    loaded = spheretree.SphereTree.load(tmp_path / "a.stree")
    assert loaded.to_bytes() == content and loaded.statistics is None
    assert np.array_equal(loaded.overhang_bounds, tree.overhang_bounds)
    assert loaded.provenance == tree.provenance and tree.provenance["builder"] == "cover" and len(tree.provenance["mesh_hash"]) == 32


def test_damaged_trees_are_refused(tree, tmp_path):
    content = tree.to_bytes()
    for damaged in (b"", content[:-1], content + b"x", content[:100] + bytes([content[100] ^ 1]) + content[101:]):
        with pytest.raises(spheretree.FormatError):
            spheretree.SphereTree.from_bytes(damaged)
    with pytest.raises(spheretree.FileError):
        spheretree.SphereTree.load(tmp_path / "none.stree")
    with pytest.raises(spheretree.FileError):
        tree.save(tmp_path / "no folder" / "a.stree")
    with pytest.raises(TypeError):
        spheretree.SphereTree()


def test_far_meshes_keep_their_digits():
    vertices, triangles = ellipsoid()
    tree = spheretree.build(vertices + [1e6, 0, 0], triangles, quality="quick", levels=2)
    centres, radii = tree.level(1)
    assert tree.origin[0] != 0
    assert np.abs(centres + tree.origin - [1e6, 0, 0]).max() < 10
