# SPDX-License-Identifier: Apache-2.0
"""`spheretree robot` on the sample robots: covered, exact in every format, pairs that hold, refusals. The program
builds on two threads and Python on one: that their files are equal shows that the number of threads changes nothing."""
import json
import os
import re
import subprocess
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
import yaml
from conftest import surface_points

import spheretree

LINKS = {"sample_arm7": ["base"] + [f"link{k}" for k in range(1, 8)] + ["hand", "finger_left", "finger_right"],
         "sample_arm6": ["base_link"] + [f"link_{k}" for k in range(1, 7)]}

BUDGET = 40  # spheres of a robot


@pytest.fixture(scope="session")
def robots(tmp_path_factory):
    folder = tmp_path_factory.mktemp("robots")
    subprocess.run([os.environ["MAKE_SAMPLES"], "--robots", folder], check=True)
    return folder


@pytest.fixture(scope="session", params=list(LINKS))
def covered(request, robots, program, tmp_path_factory):
    """Name, URDF, folder of the results."""
    name, out = request.param, tmp_path_factory.mktemp("covered")
    urdf = robots / name / f"{name}.urdf"
    subprocess.run([program, "robot", urdf, "-o", out, "--budget", str(BUDGET), "--quality", "quick", "-j", "2", "-q"], check=True, capture_output=True)
    return name, urdf, out


def numbers(text):
    return [float(word) for word in text.split()]


def curobo_spheres(out, name):
    kinematics = yaml.safe_load((out / f"{name}.curobo.yml").read_text())["robot_cfg"]["kinematics"]
    return {link: np.array([s["center"] + [s["radius"]] for s in spheres]) for link, spheres in kinematics["collision_spheres"].items()}


def frame(element):
    """<origin> as a matrix [m]."""
    matrix = np.eye(4)
    origin = element.find("origin") if element is not None else None
    if origin is not None:
        r, p, y = numbers(origin.get("rpy", "0 0 0"))
        cr, sr, cp, sp, cy, sy = np.cos(r), np.sin(r), np.cos(p), np.sin(p), np.cos(y), np.sin(y)
        matrix[:3, :3] = (np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]]) @ np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
                          @ np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]]))
        matrix[:3, 3] = numbers(origin.get("xyz", "0 0 0"))
    return matrix


def shape_points(urdf, collision, count):
    """Points on the true surface of a collision element [m], by a reader of our own."""
    geometry, random = collision.find("geometry")[0], np.random.default_rng(3)
    if geometry.tag == "mesh":
        path = urdf.parent / re.sub(r"^package://[^/]*/", "", geometry.get("filename"))
        scale = np.array(numbers(geometry.get("scale", "1 1 1")))
        if path.suffix == ".dae":
            root = ElementTree.parse(path).getroot()
            space = {"c": "http://www.collada.org/2005/11/COLLADASchema"}
            unit = float(root.find(".//c:unit", space).get("meter"))
            vertices = unit * np.array(numbers(root.find(".//c:float_array", space).text)).reshape(-1, 3)
            triangles = np.array(numbers(root.find(".//c:p", space).text), int).reshape(-1, 3)
        else:
            mesh = spheretree.read(path)  # its numbers as they stand
            vertices, triangles = mesh.vertices * scale, mesh.triangles
        return surface_points(np.asarray(vertices), np.asarray(triangles), count)
    if geometry.tag == "sphere":
        points = random.normal(size=(count, 3))
        return float(geometry.get("radius")) * points / np.linalg.norm(points, axis=1, keepdims=True)
    if geometry.tag == "box":
        points, axis = random.uniform(-0.5, 0.5, (count, 3)), random.integers(0, 3, count)
        points[np.arange(count), axis] = np.where(random.random(count) < 0.5, -0.5, 0.5)
        return points * numbers(geometry.get("size"))
    radius, length = float(geometry.get("radius")), float(geometry.get("length"))
    angle, on_side = random.uniform(0, 2 * np.pi, count), random.random(count) < 0.5
    distance = np.where(on_side, radius, radius * np.sqrt(random.random(count)))
    z = np.where(on_side, random.uniform(-0.5, 0.5, count), np.where(random.random(count) < 0.5, -0.5, 0.5)) * length
    return np.stack([distance * np.cos(angle), distance * np.sin(angle), z], -1)


def gaps(points, spheres):
    best = np.full(len(points), np.inf)
    for x, y, z, r in spheres:
        best = np.minimum(best, np.linalg.norm(points - (x, y, z), axis=1) - r)
    return best


def test_no_surface_is_bare(covered):
    """200,000 samples over the robot, by the spheres as planners read them, in double and in single precision."""
    name, urdf, out = covered
    spheres, links = curobo_spheres(out, name), ElementTree.parse(urdf).getroot().findall("link")
    elements = [(link.get("name"), c) for link in links for c in link.findall("collision")]
    assert list(spheres) == LINKS[name] and sum(map(len, spheres.values())) <= BUDGET
    for link, collision in elements:
        place = frame(collision)
        points = shape_points(urdf, collision, 200_000 // len(elements)) @ place[:3, :3].T + place[:3, 3]
        assert gaps(points, spheres[link]).max() <= 1e-12
        assert gaps(points, spheres[link].astype(np.float32).astype(float)).max() <= 1e-12


def test_every_format_holds_the_same_spheres(covered):
    name, _, out = covered
    expected = curobo_spheres(out, name)
    assert all((s[:, 3] > 0).all() for s in expected.values())
    xrdf = yaml.safe_load((out / f"{name}.xrdf").read_text())
    geometry = xrdf["collision"]["geometry"]
    found = {"xrdf": {l: [s["center"] + [s["radius"]] for s in v] for l, v in xrdf["geometry"][geometry]["spheres"].items()}}
    root = ElementTree.parse(out / f"{name}.urdf").getroot()
    found["urdf"] = {l.get("name"): [numbers(c.find("origin").get("xyz")) + [float(c.find("geometry/sphere").get("radius"))] for c in l.findall("collision")]
                     for l in root.findall("link") if l.findall("collision")}
    root = ElementTree.parse(out / f"{name}.srdf").getroot()
    found["srdf"] = {l.get("link"): [numbers(s.get("center")) + [float(s.get("radius"))] for s in l] for l in root.findall("link_sphere_approximation")}
    ballpark = json.loads((out / f"{name}.ballpark.json").read_text())
    found["ballpark"] = {l: np.column_stack([v["centers"], v["radii"]]) for l, v in ballpark.items()}
    found["foam"] = {l: [s["origin"] + [s["radius"]] for s in json.loads((out / f"foam/{l}.json").read_text())[-1]["spheres"]] for l in expected}
    morphit = {l: json.loads((out / f"morphit/{l}.json").read_text()) for l in expected}
    found["morphit"] = {l: np.column_stack([v["centers"], v["radii"]]) for l, v in morphit.items()}
    root = ElementTree.parse(out / f"{name}.mjcf.xml").getroot()
    found["mjcf"] = {b.get("name"): [numbers(g.get("pos")) + [float(g.get("size"))] for g in b.findall("geom")] for b in root.iter("body") if b.findall("geom")}
    for form, spheres in found.items():
        assert sorted(spheres) == sorted(expected), form
        for link in expected:
            assert np.array_equal(np.array(spheres[link]), expected[link]), f"{form}: {link}"


def read_by(reader, path):
    lines = [line.split() for line in subprocess.run([os.environ[reader], path], check=True, capture_output=True, text=True).stdout.splitlines()]
    spheres = {}
    for line in lines:
        if len(line) == 5:
            spheres.setdefault(line[0], []).append(list(map(float, line[1:])))
    return spheres, lines[-1]


def test_urdfdom_and_mujoco_read_them_to_the_last_bit(covered):
    name, urdf, out = covered
    expected = curobo_spheres(out, name)
    root = ElementTree.parse(urdf).getroot()
    joints = [j for j in root.findall("joint") if j.get("type") != "fixed"]
    for reader, file in [("READ_BY_URDFDOM", f"{name}.urdf"), ("READ_BY_MUJOCO", f"{name}.mjcf.xml")]:
        spheres, last = read_by(reader, out / file)
        assert {link: np.array(s).tolist() for link, s in spheres.items()} == {link: s.tolist() for link, s in expected.items()}, reader
    pairs = ElementTree.parse(out / f"{name}.srdf").getroot().findall("disable_collisions")
    assert list(map(int, last[:3])) == [len(joints), len(pairs), sum(j.find("mimic") is not None for j in joints)]
    # The masses are those of the URDF; spheres add nothing, and links that move without an <inertial> have a gramme.
    masses = [float(m.get("value")) for m in root.iter("mass")]
    moved = {j.find("child").get("link") for j in joints}
    without = sum(l.get("name") in moved and l.find("inertial") is None for l in root.findall("link"))
    assert float(last[3]) == pytest.approx(sum(masses) + 0.001 * without, rel=1e-9)


def test_the_keys_are_those_that_programs_read(covered):
    name, urdf, out = covered
    kinematics = yaml.safe_load((out / f"{name}.curobo.yml").read_text())["robot_cfg"]["kinematics"]
    assert {"format_version", "base_link", "tool_frames", "urdf_path", "asset_root_path", "collision_link_names", "mesh_link_names",
            "collision_sphere_buffer", "self_collision_buffer", "self_collision_ignore", "collision_spheres", "cspace"} == set(kinematics)
    assert kinematics["format_version"] == 2.0 and kinematics["base_link"] == LINKS[name][0] and kinematics["collision_sphere_buffer"] == 0.0
    assert kinematics["self_collision_buffer"] == {link: 0.0 for link in LINKS[name]} and kinematics["urdf_path"] == str(urdf)
    joints = [j.get("name") for j in ElementTree.parse(urdf).getroot().findall("joint") if j.get("type") != "fixed" and j.find("mimic") is None]
    assert kinematics["cspace"]["joint_names"] == joints and len(kinematics["cspace"]["default_joint_position"]) == len(joints)
    xrdf = yaml.safe_load((out / f"{name}.xrdf").read_text())
    assert xrdf["format"] == "xrdf" and xrdf["format_version"] == 1.0 and xrdf["modifiers"] == [{"set_base_frame": LINKS[name][0]}]
    assert xrdf["collision"]["geometry"] == xrdf["self_collision"]["geometry"] and list(xrdf["default_joint_positions"]) == joints
    assert set(xrdf["collision"]) == {"geometry", "buffer_distance"} and set(xrdf["self_collision"]) == {"geometry", "buffer_distance", "ignore"}
    vamp = json.loads((out / f"{name}.vamp.json").read_text())
    assert list(vamp) == ["name", "urdf", "srdf", "end_effector", "resolution", "template", "subtemplates", "output"] and vamp["resolution"] == 32
    assert (out / vamp["urdf"]).exists() and (out / vamp["srdf"]).exists()
    foam = json.loads((out / f"foam/{LINKS[name][0]}.json").read_text())
    assert all(list(level) == ["mean", "best", "worst", "spheres"] for level in foam) and len(foam[0]["spheres"]) == 1
    morphit = json.loads((out / f"morphit/{LINKS[name][0]}.json").read_text())
    assert list(morphit) == ["centers", "radii", "masses", "mesh_path", "num_spheres", "per_sphere_mass", "config"]
    assert all(g.get("mass") == "0" for g in ElementTree.parse(out / f"{name}.mjcf.xml").getroot().iter("geom"))


def joint_frames(urdf, positions):
    """Frames of all links, by a forward kinematics of our own [m]."""
    root = ElementTree.parse(urdf).getroot()
    joints = root.findall("joint")
    frames = {(set(l.get("name") for l in root.findall("link")) - set(j.find("child").get("link") for j in joints)).pop(): np.eye(4)}
    while len(frames) < len(joints) + 1:
        for joint in joints:
            parent, child = joint.find("parent").get("link"), joint.find("child").get("link")
            if parent not in frames or child in frames:
                continue
            mimic = joint.find("mimic")
            value = positions[joint.get("name") if mimic is None else mimic.get("joint")] if joint.get("type") != "fixed" else 0
            motion = np.eye(4)
            if joint.get("type") in ("revolute", "continuous"):
                x, y, z = numbers(joint.find("axis").get("xyz"))
                skew = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
                motion[:3, :3] += np.sin(value) * skew + (1 - np.cos(value)) * skew @ skew
            elif joint.get("type") == "prismatic":
                motion[:3, 3] = value * np.array(numbers(joint.find("axis").get("xyz")))
            frames[child] = frames[parent] @ frame(joint) @ motion
    return frames


def test_pairs_to_ignore_hold_in_every_configuration(covered):
    """2,000 configurations, corners of the joint limits among them: pairs that never touch do not, pairs that always
    do, do."""
    name, urdf, out = covered
    pairs = {(e.get("link1"), e.get("link2")): e.get("reason") for e in ElementTree.parse(out / f"{name}.srdf").getroot().findall("disable_collisions")}
    assert set(pairs.values()) <= {"Adjacent", "Never", "Default"} and "Never" in pairs.values()
    children = {j.find("child").get("link"): j.find("parent").get("link") for j in ElementTree.parse(urdf).getroot().findall("joint")}
    adjacent = {frozenset(pair) for pair, reason in pairs.items() if reason == "Adjacent"}
    assert adjacent == {frozenset((c, p)) for c, p in children.items() if c in LINKS[name] and p in LINKS[name]}
    kinematics = yaml.safe_load((out / f"{name}.curobo.yml").read_text())["robot_cfg"]["kinematics"]
    assert {frozenset((a, b)) for a, others in kinematics["self_collision_ignore"].items() for b in others} == set(map(frozenset, pairs))
    spheres, random = curobo_spheres(out, name), np.random.default_rng(7)
    limits = {j.get("name"): (-np.pi, np.pi) if j.get("type") == "continuous" else (float(j.find("limit").get("lower")), float(j.find("limit").get("upper")))
              for j in ElementTree.parse(urdf).getroot().findall("joint") if j.get("type") != "fixed"}
    touching = {pair: set() for pair in pairs}
    for trial in range(2000):
        share = random.random(len(limits)) if trial % 2 else random.integers(0, 2, len(limits))
        frames = joint_frames(urdf, {j: lo + s * (hi - lo) for (j, (lo, hi)), s in zip(limits.items(), share)})
        world = {l: (s[:, :3] @ frames[l][:3, :3].T + frames[l][:3, 3], s[:, 3]) for l, s in spheres.items()}
        for (a, b), reason in pairs.items():
            if reason != "Adjacent":
                (ca, ra), (cb, rb) = world[a], world[b]
                touching[a, b].add(bool((np.linalg.norm(ca[:, None] - cb[None], axis=2) <= ra[:, None] + rb).any()))
    for pair, reason in pairs.items():
        if reason == "Never":
            assert touching[pair] == {False}, pair
        if reason == "Default":
            assert touching[pair] == {True}, pair


def run(program, *words):
    return subprocess.run([program, *map(str, words)], capture_output=True, text=True)


def test_counts_tolerances_and_clips(robots, program, tmp_path):
    urdf = robots / "sample_arm6/sample_arm6.urdf"
    assert run(program, "robot", urdf, "-o", tmp_path / "a", "--tolerance", "40", "--links", "link_6=1,base*=9", "--clip", "base_link", "z", "0", "--quality", "quick", "-q").returncode == 0
    spheres = curobo_spheres(tmp_path / "a", "sample_arm6")
    assert len(spheres["link_6"]) == 1 and len(spheres["base_link"]) <= 9
    assert (spheres["base_link"][:, 2] - spheres["base_link"][:, 3]).min() >= 0
    shown = run(program, "evaluate", urdf, tmp_path / "a/sample_arm6.xrdf", "--json", "-q")
    rows = {row["link"]: row["level"] for row in json.loads(shown.stdout)["links"]}
    for link, level in rows.items():
        if link != "base_link":
            assert level["uncovered_fraction"] == 0 and (link == "link_6" or level["overhang_mm"]["max"] <= 40)


def test_what_a_file_knows_is_kept(robots, program, tmp_path):
    urdf = robots / "sample_arm6/sample_arm6.urdf"
    names = [f"joint_{k}" for k in range(1, 7)]
    (tmp_path / "own.xrdf").write_text(yaml.safe_dump({"format": "xrdf", "format_version": 1.0, "tool_frames": ["tool0"], "custom": {"kept": "1.0"},
                                                       "cspace": {"joint_names": names, "acceleration_limits": [9.5] * 6, "jerk_limits": [400.0] * 6}}))
    (tmp_path / "own.srdf").write_text('<robot name="r"><group name="arm"><chain base_link="base_link" tip_link="tool0"/></group>'
                                       '<disable_collisions link1="link_2" link2="link_1" reason="User"/></robot>')
    assert run(program, "robot", urdf, "-o", tmp_path / "a", "--budget", "10", "--quality", "quick", "--merge", tmp_path / "own.xrdf", "--srdf", tmp_path / "own.srdf", "-q").returncode == 0
    xrdf = yaml.safe_load((tmp_path / "a/sample_arm6.xrdf").read_text())
    assert xrdf["custom"] == {"kept": "1.0"} and xrdf["cspace"] == {"joint_names": names, "acceleration_limits": [9.5] * 6, "jerk_limits": [400.0] * 6}
    assert xrdf["tool_frames"] == ["tool0"] and "geometry" in xrdf
    cspace = yaml.safe_load((tmp_path / "a/sample_arm6.curobo.yml").read_text())["robot_cfg"]["kinematics"]["cspace"]
    assert cspace["max_acceleration"] == [9.5] * 6 and cspace["max_jerk"] == [400.0] * 6
    root = ElementTree.parse(tmp_path / "a/sample_arm6.srdf").getroot()
    assert root.find("group").get("name") == "arm"
    assert [e.get("reason") for e in root.findall("disable_collisions") if {e.get("link1"), e.get("link2")} == {"link_1", "link_2"}] == ["User"]


def test_evaluate_reads_every_format(covered, program):
    name, urdf, out = covered
    mesh = urdf.parent / f"meshes/{LINKS[name][1]}.stl"
    seen = []
    for file in (f"{name}.curobo.yml", f"{name}.xrdf", f"{name}.ballpark.json", f"{name}.urdf", f"{name}.srdf", f"{name}.mjcf.xml", f"foam/{LINKS[name][1]}.json",
                 f"morphit/{LINKS[name][1]}.json"):
        link = [] if "/" in file else ["--link", LINKS[name][1]]
        shown = run(program, "evaluate", mesh, out / file, "--unit", "m", "--no-limits", "--json", "-q", *link)
        assert shown.returncode == 0, shown.stderr
        seen.append(json.loads(shown.stdout)["levels"][0])
        assert seen[-1] == seen[0] and seen[-1]["uncovered_fraction"] == 0
    shown = run(program, "evaluate", mesh, out / f"{name}.xrdf", "--unit", "m")
    assert shown.returncode == 4 and "--link" in shown.stderr


@pytest.mark.parametrize("text, code, says", [
    ("<robot", 4, "XML"),
    ("<sdf/>", 4, "URDF"),
    ('<robot name="r"/>', 4, "<link>"),
    ('<robot name="r"><link name="a"/><link name="a"/></robot>', 4, "two links"),
    ('<robot name="r"><link name="a"/><link name="b"/></robot>', 4, "neither this link nor the link a has a parent"),
    ('<robot name="r"><link name="a"/></robot>', 4, "collision"),
    ('<robot name="r"><link name="a"><collision><geometry><sphere radius="-1"/></geometry></collision></link></robot>', 4, "negative"),
    ('<robot name="r"><link name="a"><visual><geometry><sphere radius="1"/></geometry></visual></link></robot>', 4, "--visual"),
    ('<robot name="r"><link name="a"><collision><geometry><box size="1 nan 1"/></geometry></collision></link></robot>', 4, "finite"),
    ('<robot name="r"><link name="a"><collision><geometry><mesh filename="none.stl"/></geometry></collision></link></robot>', 3, "none.stl"),
    ('<robot name="r"><link name="a"><collision><geometry><mesh filename="package://p/none.stl"/></geometry></collision></link></robot>', 3, "--package"),
    ('<robot name="r"><link name="a"/><link name="b"/><joint name="j" type="revolute"><parent link="a"/><child link="b"/></joint></robot>', 4, "<limit>"),
    ('<robot name="r"><link name="a"/><joint name="j" type="fixed"><parent link="a"/><child link="c"/></joint></robot>', 4, "no link named c"),
    ('<robot name="r" xmlns:xacro="http://x"><xacro:include filename="a"/></robot>', 4, "xacro"),
])
def test_refusals_name_the_place(text, code, says, program, tmp_path):
    (tmp_path / "a.urdf").write_text(text)
    refused = run(program, "robot", tmp_path / "a.urdf", "-o", tmp_path / "out", "-q")
    assert refused.returncode == code and says in refused.stderr and "a.urdf" in refused.stderr, refused.stderr
    assert not any(path.is_file() for path in (tmp_path / "out").rglob("*"))


def test_options_that_do_not_fit_are_refused(robots, program, tmp_path):
    urdf = robots / "sample_arm6/sample_arm6.urdf"
    for words, says in [(["--budget", "3"], "less than one"), (["--links", "none=3"], "names no link"), (["--links", "a"], "PATTERN"),
                        (["--clip", "none", "z", "0"], "no link"), (["--clip", "base_link", "w", "0"], "axis"), (["--budget", "9", "--tolerance", "3"], "tolerance"),
                        (["--clip", "base_link", "z", "100000"], "every sphere")]:
        refused = run(program, "robot", urdf, "-o", tmp_path / "out", "--quality", "quick", "-q", *words)
        assert refused.returncode == 2 and says in refused.stderr, (words, refused.stderr)
    (tmp_path / "wrong.xrdf").write_text("format: xrdf\ncspace: 7\n")
    for words, code, says in [(["--srdf", tmp_path / "none.srdf"], 3, "none.srdf"), (["--srdf", urdf], 4, "Is this a URDF?"), (["--merge", urdf], 4, "sample_arm6.urdf"),
                              (["--merge", tmp_path / "wrong.xrdf"], 4, "wrong.xrdf"), (["--package", tmp_path / "nodir"], 3, "nodir"), (["--unit", "none=mm"], 2, "names no link")]:
        # Within the time that reading takes: `best` would take minutes.
        refused = subprocess.run([program, "robot", urdf, "-o", tmp_path / "out", "--quality", "best", "--budget", "4000", "-q", *words], capture_output=True, text=True, timeout=60)
        assert refused.returncode == code and says in refused.stderr, (words, refused.stderr)
        assert not any(path.is_file() for path in (tmp_path / "out").rglob("*"))
    refused = run(program, "robot", urdf, "-o", urdf.parent, "-q", "--budget", "20", "--quality", "quick")
    assert refused.returncode == 2 and "sample_arm6.urdf" in refused.stderr  # the output would replace the input


def test_capsules_placeholders_and_visuals(program, tmp_path):
    """The exact overhang of two spheres on a capsule; a link without a shape; the shapes of <visual>."""
    shape = '<geometry><capsule radius="0.03" length="0.12"/></geometry>'
    text = ('<robot name="r"><link name="a"><{0}>' + shape + '</{0}></link>\n<link name="b"><{0}><geometry><box size="0 0 0"/></geometry></{0}></link>'
            '<joint name="j" type="continuous"><parent link="a"/><child link="b"/></joint></robot>')
    for element, options in [("collision", []), ("visual", ["--visual"])]:
        (tmp_path / "r.urdf").write_text(text.format(element))
        shown = run(program, "robot", tmp_path / "r.urdf", "-o", tmp_path / element, "--budget", "2", *options)
        assert shown.returncode == 0, shown.stderr
        assert "r.urdf:2: <box> of link b" in shown.stderr and "link b is left without any shape" in shown.stderr
        spheres = curobo_spheres(tmp_path / element, "r")
        assert list(spheres) == ["a"] and len(spheres["a"]) == 2
        np.testing.assert_allclose(np.abs(spheres["a"]), [[0, 0, 0.04, 0.05]] * 2, rtol=1e-6)  # h = 20 mm
        read_by("READ_BY_MUJOCO", tmp_path / element / "r.mjcf.xml")
        shown = run(program, "evaluate", tmp_path / "r.urdf", tmp_path / element / "r.xrdf", "--json", "-q", *options)
        assert json.loads(shown.stdout)["links"][0]["level"]["uncovered_fraction"] == 0


def test_python_gives_the_files_of_the_program_for_any_number_of_threads(covered, tmp_path):
    name, urdf, out = covered
    arm = spheretree.robot(urdf, budget=BUDGET, quality="quick", threads=1)
    assert arm.name == name and list(arm.links) == [link for link in LINKS[name] if link in arm.links]
    for link, spheres in curobo_spheres(out, name).items():
        found = arm.links[link]
        assert found.centres.dtype == np.float32 and not found.centres.flags.writeable
        np.testing.assert_array_equal(np.column_stack([found.centres, found.radii]), spheres.astype(np.float32))
        assert 0 < found.overhang_bound < 0.2 and found.name == link
    assert {reason for _, _, reason in arm.pairs} <= {"adjacent", "always", "never"} and arm.pairs
    names = arm.write(tmp_path / "made")
    written = [path for path in out.rglob("*") if path.is_file() and path.name != ".spheretree-files"]
    assert sorted(names) == sorted(str(path.relative_to(out)) for path in written)
    for file in names:
        if not file.endswith(".urdf") and file != "robot.json":  # which name files from where they lie
            assert (tmp_path / "made" / file).read_bytes() == (out / file).read_bytes(), file
    manifests = [json.loads((folder / "robot.json").read_text()) for folder in (tmp_path / "made", out)]
    assert all((folder / manifest.pop("urdf")).samefile(urdf) for folder, manifest in zip((tmp_path / "made", out), manifests))
    assert manifests[0] == manifests[1]
    first = next(iter(arm.links.values())).radii
    del arm
    assert first.sum() > 0  # views keep it alive


def test_python_refuses_what_the_program_refuses(robots, tmp_path):
    urdf = robots / "sample_arm6/sample_arm6.urdf"
    for words, says in [({"budget": 3}, "less than one"), ({"links": {"none": 3}}, "names no link"), ({"budget": 9, "tolerance": 3.0}, "tolerance"),
                        ({"links": {"link_1": 0}}, "1 to 4096"), ({"tolerance": float("nan")}, "above 0")]:
        with pytest.raises(spheretree.UsageError, match=says):
            spheretree.robot(urdf, **words)
    with pytest.raises(spheretree.FileError, match="none.urdf"):
        spheretree.robot(tmp_path / "none.urdf")
    arm = spheretree.robot(urdf, budget=7, quality="quick")
    with pytest.raises(spheretree.UsageError, match="sample_arm6.urdf"):
        arm.write(urdf.parent)  # it would replace the URDF that it was made from

    def stop(stage, fraction):
        raise KeyboardInterrupt
    with pytest.raises(KeyboardInterrupt):
        spheretree.robot(urdf, budget=60, progress=stop)
