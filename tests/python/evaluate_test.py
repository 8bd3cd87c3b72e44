# SPDX-License-Identifier: Apache-2.0
"""Measures: the figures of the program."""
import json
import subprocess

import pytest
from conftest import ellipsoid

import spheretree


def test_the_figures_of_the_program(molar, program, tmp_path):
    mesh = spheretree.read(molar)
    tree = spheretree.build(mesh, quality="quick", levels=3)
    tree.save(tmp_path / "molar.stree")
    shown = subprocess.run([program, "evaluate", molar, tmp_path / "molar.stree", "--json"], check=True, capture_output=True, text=True).stdout
    evaluation = spheretree.evaluate(mesh, tree)
    assert evaluation.to_dict() == json.loads(shown)
    assert [level.spheres for level in evaluation.levels] == [1, 8, 64]
    for level, bound in zip(evaluation.levels, tree.overhang_bounds):
        assert level.coverage.uncovered_fraction == 0 and level.missing_volume_fraction < 1e-3
        assert 0 < level.overhang.mean < level.overhang.p99 < level.overhang.max <= min(level.overhang.bound, bound)
    assert 0 < evaluation.limits.h_low <= evaluation.limits.h_fin


def test_another_mesh_is_a_warning_and_shows():
    vertices, triangles = ellipsoid()
    tree = spheretree.build(vertices, triangles, quality="quick", levels=2)
    with pytest.warns(spheretree.MeshWarning, match="another mesh"):
        level = spheretree.evaluate(vertices + [5, 0, 0], tree, triangles, limits=False, effort=0.2).levels[-1]
    assert level.coverage.uncovered_fraction > 0.05 and level.coverage.max_gap > 1
    assert spheretree.evaluate(vertices, tree, triangles, limits=False, effort=0.1).limits is None
    with pytest.raises(ValueError, match="effort"):
        spheretree.evaluate(vertices, tree, triangles, effort=0)
