# SPDX-License-Identifier: Apache-2.0
"""Batches: a scene to trees, its report, and the compiled scene in the runtime."""
import json

import numpy as np
import pytest
from conftest import box, ellipsoid

import spheretree


@pytest.fixture
def scene(tmp_path):
    spheretree.Mesh(*ellipsoid((2, 2, 2))).save(tmp_path / "ball.ply")
    spheretree.Mesh(*box()).save(tmp_path / "plate.ply")
    path = tmp_path / "a.scene.json"
    path.write_text(json.dumps({
        "schema": "spheretree.scene/1", "defaults": {"quality": "quick", "levels": 3}, "tool": {"name": "ball", "mesh": "ball.ply"},
        "objects": [{"name": "plate", "mesh": "plate.ply"}, {"name": "again", "mesh": "plate.ply", "position_mm": [0, 0, -30]}]}))
    return path


def test_a_scene_to_trees_and_into_the_runtime(scene, tmp_path):
    stages = []
    result = spheretree.batch(scene, tmp_path / "out", progress=lambda stage, fraction: stages.append(stage))
    assert [o["status"] for o in result["objects"]] == ["built"] * 3 and stages
    assert {k: v for k, v in result.items() if "seconds" not in k} == {
        k: v for k, v in json.loads((tmp_path / "out/report.json").read_text()).items() if "seconds" not in k}
    assert {o["status"] for o in spheretree.batch(scene, tmp_path / "out")["objects"]} == {"cached"}
    plate, ball = (spheretree.SphereTree.load(tmp_path / "out" / f"{name}.stree") for name in ("plate", "ball"))
    loaded = spheretree.Renderer(spheretree.Scene.load(tmp_path / "out/scene.json"))
    made = spheretree.Renderer(spheretree.Scene(ball, [plate, (plate, [0, 0, -30])]))
    for z in np.linspace(4, 1, 30):
        assert loaded.step([0, 0, z]).force.tobytes() == made.step([0, 0, z]).force.tobytes()
    assert made.step([0, 0, 1]).force[2] > 0.5


def test_budgets_and_dry_runs(scene, tmp_path):
    assert {o["status"] for o in spheretree.batch(scene, tmp_path / "out", dry_run=True)["objects"]} == {"skipped"}
    assert not (tmp_path / "out").exists()
    result = spheretree.batch(scene, tmp_path / "out", budget=40)
    assert sum(spheretree.SphereTree.load(p).leaf_count * (2 if p.stem == "plate" else 1)
               for p in (tmp_path / "out").glob("*.stree") if p.stem != "again") <= 40 and result["budget"]["met"]


def test_what_cannot_be_done_is_said(scene, tmp_path):
    with pytest.raises(spheretree.FileError):
        spheretree.batch(tmp_path / "none.scene.json", tmp_path / "out")
    (tmp_path / "bad.scene.json").write_text("{}")
    with pytest.raises(spheretree.FormatError):
        spheretree.batch(tmp_path / "bad.scene.json", tmp_path / "out")
    with pytest.raises(spheretree.UsageError):
        spheretree.batch(scene, tmp_path / "out", dry_run=True, budget=40)
    for settings, error in [({"budget": 0}, ValueError), ({"budget": 2.5}, TypeError), ({"budget": "xus"}, ValueError), ({"quality": "fine"}, ValueError),
                            ({"tolerance": -1}, ValueError)]:
        with pytest.raises(error):
            spheretree.batch(scene, tmp_path / "out", **settings)
    (tmp_path / "plate.ply").write_text("ply\n")
    result = spheretree.batch(scene, tmp_path / "out")
    assert [o["status"] for o in result["objects"]] == ["built", "failed", "failed"] and "plate.ply" in result["objects"][1]["error"]
