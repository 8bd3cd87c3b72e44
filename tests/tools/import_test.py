#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""import_test.py IMPORT SPHERETREE: spheretree-import reads what the formats say of place, unit and names, and nothing
without --trusted.

The files are written here: a box of 20 x 10 x 5 mm in each format, so that volume and place are known. """
import json
import random
import struct
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

importer, spheretree = sys.argv[1:3]
failures = []
CORNERS = [(x, y, z) for x in (0, 20) for y in (0, 10) for z in (0, 5)]  # index 4 x + 2 y + z
FACES = [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1), (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)]


def dae(unit):
    """In a unit of `unit` metres; the second node is 0.1 m to the right."""
    scale = 0.001 / unit
    places = " ".join(f"{c * scale:.9g}" for corner in CORNERS for c in corner)
    indices = " ".join(str(k) for face in FACES for k in face)
    node = '<node id="{0}" name="{0}"><matrix>1 0 0 {1} 0 1 0 0 0 0 1 0 0 0 0 1</matrix><instance_geometry url="#g"/></node>'
    return f"""<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="u" meter="{unit}"/><up_axis>Z_UP</up_axis></asset><library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="a" count="24">{places}</float_array><technique_common><accessor source="#a" count="8" stride="3">
<param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices><triangles count="12"><input semantic="VERTEX" source="#v" offset="0"/>
<p>{indices}</p></triangles></mesh></geometry></library_geometries><library_visual_scenes><visual_scene id="s">
{node.format("left", 0)}{node.format("right", 100 * scale)}</visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>""".encode()


def write_3mf(path):
    vertices = "".join(f'<vertex x="{x}" y="{y}" z="{z}"/>' for x, y, z in CORNERS)
    triangles = "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in FACES)
    model = f"""<?xml version="1.0"?><model unit="millimeter" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"><resources>
<object id="1" type="model"><mesh><vertices>{vertices}</vertices><triangles>{triangles}</triangles></mesh></object></resources>
<build><item objectid="1"/></build></model>"""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        def write(name, text):
            archive.writestr(zipfile.ZipInfo(name, (2020, 1, 1, 0, 0, 0)), text, zipfile.ZIP_DEFLATED)  # the same bytes in every run
        write("[Content_Types].xml", '<?xml version="1.0"?><Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">'
                         '<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>'
                         '<Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>')
        write("_rels/.rels", '<?xml version="1.0"?><Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">'
                         '<Relationship Target="/3D/3dmodel.model" Id="r" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/>'
                         '</Relationships>')
        write("3D/3dmodel.model", model)


def max3ds():
    def chunk(kind, data):
        return struct.pack("<HI", kind, 6 + len(data)) + data
    vertices = struct.pack("<H", 8) + b"".join(struct.pack("<3f", *c) for c in CORNERS)
    faces = struct.pack("<H", 12) + b"".join(struct.pack("<4H", *f, 7) for f in FACES)
    mesh = chunk(0x4100, chunk(0x4110, vertices) + chunk(0x4120, faces))
    return chunk(0x4D4D, chunk(0x3D3D, chunk(0x4000, b"box\0" + mesh)))


def run(*words):
    return subprocess.run([str(w) for w in words], capture_output=True, text=True, errors="replace", timeout=120)


def expect(condition, what):
    if not condition:
        failures.append(what)


def parts_of(path):
    """Volume and lowest corner of each part, from the OBJ itself."""
    places, parts, name = [], {}, ""
    for line in path.read_text().splitlines():
        words = line.split()
        if words[:1] == ["v"]:
            places.append(tuple(map(float, words[1:4])))
        elif words[:1] in (["g"], ["o"]):
            name = words[1]
        elif words[:1] == ["f"]:
            parts.setdefault(name, []).append([places[int(w) - 1] for w in words[1:4]])
    out = {}
    for name, triangles in parts.items():
        volume = sum(a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0])
                     for a, b, c in triangles) / 6
        out[name] = (volume, tuple(min(p[axis] for t in triangles for p in t) for axis in range(3)))
    return out


def near(a, b):
    return abs(a - b) < 1e-3 * max(1, abs(b))


def main(folder):
    files = {"metres.dae": dae(1), "inches.dae": dae(0.0254), "box.3ds": max3ds()}
    for name, content in files.items():
        (folder / name).write_bytes(content)
    write_3mf(folder / "box.3mf")
    for name in [*files, "box.3mf"]:
        out = folder / (name + ".obj")
        refused = run(importer, folder / name, "-o", out)
        expect(refused.returncode == 2 and "--trusted" in refused.stderr and not out.exists(), f"{name} without --trusted: {refused.stderr}")
        done = run(importer, folder / name, "-o", out, "--trusted")
        expect(done.returncode == 0, f"{name}: {done.stderr}")
        if done.returncode:
            continue
        parts = parts_of(out)
        count = 2 if name.endswith(".dae") else 1
        expect(len(parts) == count and all(near(v, 1000) for v, _ in parts.values()), f"{name}: parts are {parts}")
        if count == 2:
            expect(set(parts) == {"left", "right"} and near(parts["right"][1][0], 100) and near(parts["left"][1][0], 0), f"{name}: {parts}")
        checked = run(spheretree, "check", out, "--json")
        expect(checked.returncode == 0 and json.loads(checked.stdout), f"{name}: check says {checked.stdout[:300]}")
    done = run(importer, folder / "box.3ds", "-o", folder / "cm.ply", "--trusted", "--unit", "cm")
    expect(done.returncode == 0 and "10 mm" in done.stdout, f"--unit cm: {done.stdout} {done.stderr}")

    # An invalid or damaged file leaves no output behind; an input is not replaced.
    (folder / "none.fbx").write_bytes(b"no such thing")
    done = run(importer, folder / "none.fbx", "-o", folder / "none.obj", "--trusted")
    expect(done.returncode == 4 and "Assimp cannot read it" in done.stderr and not (folder / "none.obj").exists(), f"none.fbx: {done.stderr}")
    done = run(importer, folder / "missing.fbx", "-o", folder / "none.obj", "--trusted")
    expect(done.returncode == 3, f"missing.fbx: {done.returncode}")
    done = run(importer, folder / "metres.dae.obj", "-o", folder / "metres.dae.obj", "--trusted")
    expect(done.returncode == 2, f"its own input: {done.returncode} {done.stderr}")
    chance = random.Random(5)
    for k in range(18):
        name = ("box.3ds", "box.3mf", "metres.dae")[k % 3]
        content = bytearray((folder / name).read_bytes())
        for _ in range(chance.randint(1, 4)):
            content[chance.randrange(len(content))] = chance.randrange(256)
        if k % 5 == 0:
            del content[chance.randrange(len(content)):]
        damaged, out = folder / ("damaged" + Path(name).suffix), folder / "damaged.obj"
        damaged.write_bytes(content)
        out.unlink(missing_ok=True)
        done = run(importer, damaged, "-o", out, "--trusted")
        expect((done.returncode == 0) == out.exists(), f"damage {k} of {name}: exit code {done.returncode}, output {out.exists()}")
        expect(not list(folder.glob(".spheretree-*")), f"damage {k} of {name}: a temporary file is left")


with tempfile.TemporaryDirectory() as base:
    main(Path(base))
for failure in failures:
    print("FAILED:", failure)
sys.exit(1 if failures else 0)
