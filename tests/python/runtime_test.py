# SPDX-License-Identifier: Apache-2.0
"""Scenes and steps: forces against closed forms, poses in every form."""
import json

import numpy as np
import pytest
from conftest import box, ellipsoid

import spheretree


@pytest.fixture(scope="module")
def ball():
    return spheretree.build(*ellipsoid((2, 2, 2)), quality="quick", levels=2)


@pytest.fixture(scope="module")
def plate():
    return spheretree.build(*box(), quality="quick", levels=3)


def lowest(tree):
    centres, radii = tree.level(-1)
    return float((centres[:, 2] - radii).min())


def pressed(renderer, depth, ball, steps=50):
    """Down to `depth` below the plane z = 0, by its lowest leaf."""
    height = -lowest(ball)
    for z in np.linspace(height + 1, height - depth, steps):
        step = renderer.step([0, 0, z])
    return step


def test_a_plane_pushes_back_by_the_spring(ball, plate):
    renderer = spheretree.Renderer(spheretree.Scene(ball, [plate], stiffness=2.5))
    assert np.array_equal(renderer.step([0, 0, 30]).force, [0, 0, 0])
    renderer.reset()
    step = pressed(renderer, 0.8, ball)
    assert step.faults == 0
    assert step.force == pytest.approx([0, 0, 2.5 * 0.8], abs=0.02)
    assert step.graphic_tool[:3] == pytest.approx([0, 0, -lowest(ball)], abs=0.01)
    assert sum(c.force * c.normal for c in step.contacts) == pytest.approx(step.spring_force, abs=1e-5)  # normals are floats
    for contact in step.contacts:
        assert contact.object == 0 and contact.on_skin and abs(contact.point[2]) < 0.01 and contact.normal == pytest.approx([0, 0, 1], abs=1e-3)


def test_the_force_is_limited(ball, plate):
    step = pressed(spheretree.Renderer(spheretree.Scene(ball, [plate], force_limit=0.5)), 3, ball)
    assert np.linalg.norm(step.force) == pytest.approx(0.5) and np.linalg.norm(step.spring_force) > 2.9


def test_objects_stand_in_their_places_and_move(ball, plate):
    scene = spheretree.Scene(ball, [(plate, [0, 0, -5]), (plate, [100, 0, 0])], contact="leaves")
    assert len(scene) == 2 and scene.byte_count > 0
    renderer = spheretree.Renderer(scene)
    at_plane = [0, 0, -lowest(ball) - 0.5]
    assert not renderer.step([0, 0, 9]).contacts and not renderer.step(at_plane).force.any()
    renderer.move_object(0, [0, 0, -0.25])
    assert renderer.step(at_plane).force[2] > 0.2
    for object, pose in [(2, [0, 0, 0]), (0, [np.nan, 0, 0])]:
        with pytest.raises(ValueError, match="cannot be moved"):
            renderer.move_object(object, pose)


def test_poses_in_every_form_give_the_same_step(ball, plate):
    angle = 0.3
    matrix = np.eye(4)
    matrix[:3, :3] = [[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]]
    matrix[:3, 3] = [1, 2, 1.5]
    row = [1, 2, 1.5, np.cos(angle / 2), 0, 0, np.sin(angle / 2)]
    steps = [spheretree.Renderer(spheretree.Scene(ball, [plate])).step(pose) for pose in (matrix, row, np.float32(matrix), tuple(row))]
    for step in steps:
        assert step.graphic_tool == pytest.approx(steps[0].graphic_tool, abs=1e-6)
    assert steps[0].graphic_tool[3:] == pytest.approx(row[3:], abs=1e-7)
    renderer = spheretree.Renderer(spheretree.Scene(ball, [plate]))
    for bad in ([1, 2], np.eye(3), 2 * np.eye(4), np.diag([1, 1, -1, 1]), np.ones((4, 4))):
        with pytest.raises(ValueError, match="pose"):
            renderer.step(bad)
    with pytest.raises(TypeError, match="pose"):
        renderer.step("here")


def test_a_pose_that_is_not_finite_is_a_fault_and_no_error(ball, plate):
    renderer = spheretree.Renderer(spheretree.Scene(ball, [plate]))
    before = pressed(renderer, 0.5, ball)
    for bad in ([np.nan, 0, 0], [np.inf, 0, 0, 1, 0, 0, 0], np.full((4, 4), np.nan), [1e9, 0, 0]):
        step = renderer.step(bad)
        assert step.faults == spheretree.Fault.BAD_INPUT and np.isfinite(step.force).all()
    assert np.linalg.norm(step.force) == pytest.approx(0.9**4 * np.linalg.norm(before.force))


def test_the_same_poses_give_the_same_bits(ball, plate):
    scene = spheretree.Scene(ball, [plate])
    runs = []
    for _ in range(2):
        renderer = spheretree.Renderer(scene)
        runs.append([renderer.step([0.1 * k, 0, 2 - 0.05 * k]).force.tobytes() for k in range(60)])
    assert runs[0] == runs[1]


def test_scenes_that_cannot_be_are_refused(ball, plate, tmp_path):
    for settings, says in [({"stiffness": 0}, "translation|stiffness|coupling"), ({"contact": "bones"}, "skin or leaves"), ({"torque_limit": [1, 2]}, r"\(3,\)")]:
        with pytest.raises(ValueError, match=says):
            spheretree.Scene(ball, [plate], **settings)
    with pytest.raises(TypeError, match=r"objects\[1\]"):
        spheretree.Scene(ball, [plate, 3])
    with pytest.raises(ValueError, match="constrained or paper"):
        spheretree.Renderer(spheretree.Scene(ball, [plate]), mode="free")
    with pytest.raises(spheretree.FileError):
        spheretree.Scene.load(tmp_path / "none.json")
    for entry, says in [({"pose": [0, 0, 0]}, r"objects\[0\] has no tree"), ({"tree": plate, "colour": 1}, "key colour")]:
        with pytest.raises(ValueError, match=says):
            spheretree.Scene(ball, [entry])
    with pytest.raises(TypeError, match=r'objects\[0\]\["friction"\] must be a number'):
        spheretree.Scene(ball, [{"tree": plate, "friction": "much"}])
    with pytest.raises(TypeError, match="SphereTree, or the path"):
        spheretree.Scene(ball, [{"tree": 7}])
    with pytest.raises(spheretree.FormatError, match="the scene"):
        spheretree.Scene.load({"schema": "spheretree.scene/1"})


def test_a_scene_file_keeps_friction_and_bodies(ball, plate, tmp_path, monkeypatch):
    ball.save(tmp_path / "ball.stree")
    plate.save(tmp_path / "plate.stree")
    (tmp_path / "scene.json").write_text(json.dumps({
        "schema": "spheretree.scene/1", "tool": {"name": "ball", "tree": "ball.stree"}, "coupling": {"translation_n_per_mm": 1, "rotation_n_mm_per_rad": 1000},
        "bodies": [{"name": "lift", "hinge": {"point_mm": [0, 0, 0], "axis": [1, 0, 0], "angle_deg": [[0, 0]]}}],
        "objects": [{"name": "plate", "tree": "plate.stree", "body": "lift", "friction": 0.3}]}))
    text = json.loads((tmp_path / "scene.json").read_text())
    monkeypatch.chdir(tmp_path)
    dragged = {"tree": plate, "friction": 0.3, "body": 1}
    for scene in (spheretree.Scene.load(tmp_path / "scene.json"), spheretree.Scene.load(tmp_path), spheretree.Scene.load(text),
                  spheretree.Scene(ball, [dragged]), spheretree.Scene(ball, [dragged | {"tree": tmp_path / "plate.stree"}]),
                  spheretree.Scene(ball, [{"tree": plate, "body": 1}], tool_friction=0.3)):
        drag_and_lift(spheretree.Renderer(scene), ball)


def drag_and_lift(renderer, ball):
    pressed(renderer, 1, ball)
    for x in np.linspace(0, 3, 300):  # dragged: mu N against it
        step = renderer.step([x, 0, -lowest(ball) - 1])
    assert sum(c.friction for c in step.contacts) == pytest.approx([-0.3 * step.force[2], 0, 0], rel=0.02, abs=1e-3)
    assert max(np.linalg.norm(c.slip) for c in step.contacts) == pytest.approx(10, rel=0.05)
    renderer.move_body(1, [0, 0, 0.5])  # it lifts the ball
    assert renderer.step([3, 0, -lowest(ball) - 1]).force[2] == pytest.approx(1.5, abs=0.03)
    with pytest.raises(ValueError, match="body 2"):
        renderer.move_body(2, [0, 0, 0])


def test_objects_that_yield_and_a_damper(ball, plate):
    step = pressed(spheretree.Renderer(spheretree.Scene(ball, [{"tree": plate, "stiffness": 1.0}])), 0.8, ball)
    assert step.force[2] == pytest.approx(0.4, abs=0.02)  # two springs of 1 N/mm in series
    damped = spheretree.Renderer(spheretree.Scene(ball, [plate], damping=0.01))
    pressed(damped, 0.5, ball)
    # A motion of 0.1 mm in 1 ms: 0.01 N s/mm times 100 mm/s.
    assert damped.step([0, 0, -lowest(ball) - 0.6]).force[2] == pytest.approx(0.6 + 1, abs=0.03)


def test_an_object_is_switched_off_and_on(ball, plate):
    renderer = spheretree.Renderer(spheretree.Scene(ball, [plate]))
    at = [0, 0, -lowest(ball) - 0.8]
    pressed(renderer, 0.8, ball)
    renderer.set_active(0, False)
    for _ in range(50):
        off = renderer.step(at)  # the force ends gradually
    assert not off.force.any() and not off.contacts and off.pairs == 0
    renderer.reset()
    renderer.step([0, 0, 9])
    renderer.set_active(0, True)
    assert pressed(renderer, 0.8, ball).force[2] > 0.7
    with pytest.raises(IndexError, match="no object 1"):
        renderer.set_active(1, False)


def test_a_burr_cuts(ball, plate, tmp_path):
    ball.save(tmp_path / "ball.stree")
    plate.save(tmp_path / "plate.stree")
    scene = {
        "schema": "spheretree.scene/1",
        "tool": {"name": "burr", "tree": str(tmp_path / "ball.stree"), "burr": [{"centre_mm": [0, 0, 0], "radius_mm": 2}]},
        "objects": [{"name": "plate", "tree": str(tmp_path / "plate.stree"),
                     "cut": {"layers": [{"name": "all", "mesh": "plate.obj"}], "removal_mm_per_n_s": {"all": 5}}}],
    }
    renderer = spheretree.Renderer(spheretree.Scene.load(scene))
    pressed(renderer, 0.5, ball)
    assert renderer.removed(0) == [0]
    renderer.set_spindle(True)
    pressed(renderer, 0.5, ball, 500)
    assert renderer.removed(0)[0] > 0.1
    renderer.mend()
    assert renderer.removed(0) == [0]
    with pytest.raises(IndexError, match="no object 1"):
        renderer.removed(1)
    with pytest.raises(ValueError, match="no burr"):
        spheretree.Renderer(spheretree.Scene(ball, [plate])).set_spindle(True)


def test_distances_have_bounds(ball, plate):
    renderer = spheretree.Renderer(spheretree.Scene(ball, [(plate, [0, 0, -5])]))
    found = renderer.distance(0, [0, 0, 9])
    gap = 9 + lowest(ball) + 5  # from the lowest leaf to the plane z = -5
    assert gap - 0.2 < found.lower <= gap and gap <= found.upper < gap + 2
    assert found.on_tool[2] == pytest.approx(9 + lowest(ball), abs=1e-3) and found.on_object[2] == pytest.approx(-5, abs=1e-3)
    assert renderer.distance(0, [0, 0, 9], limit=2).lower == 2
    assert np.array_equal(renderer.object_pose(0), [0, 0, -5, 1, 0, 0, 0])
    for ask in (lambda: renderer.distance(1, [0, 0, 9]), lambda: renderer.object_pose(1)):
        with pytest.raises(IndexError, match="no object 1"):
            ask()
    with pytest.raises(ValueError, match="finite"):
        renderer.distance(0, [np.nan, 0, 0])


def test_results_describe_themselves(ball, plate):
    step = pressed(spheretree.Renderer(spheretree.Scene(ball, [plate])), 0.8, ball)
    assert repr(step).startswith("<spheretree.Step: tool at (") and "contact" in repr(step) and " N" in repr(step)
    assert repr(step.contacts[0]).startswith("<spheretree.Contact: object 0, triangle ")
