# SPDX-License-Identifier: Apache-2.0
"""Reads a .stree file by docs/file_format.md alone.

Usage: read_stree.py TREE.stree [TREE.json [PATCHES.json]] TREE.json: the same tree as `spheretree convert` writes it;
it must be the same. PATCHES.json: [positions, normals] of the six nodes of each patch of the skin, [x, y, z] each; they
must agree to 1e-5. """
import json
import math
import struct
import sys


def crc64(data):
    crc = 2**64 - 1
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ (0xC96C5795D7870F42 if crc & 1 else 0)
    return crc ^ 2**64 - 1


def sections_of(data):
    magic, major, _, count, size, crc = struct.unpack_from("<8sHHIQQ", data)
    assert magic == b"\x89STREE\r\n" and major == 1, "not a sphere-tree of version 1"
    assert size == len(data) and crc == crc64(data[:24] + bytes(8) + data[32:]), "damaged"
    sections, end = {}, 32 + 24 * count
    for i in range(count):
        name, flags, offset, size = struct.unpack_from("<4sIQQ", data, 32 + 24 * i)
        assert offset == (end + 63) // 64 * 64 and offset + size <= len(data) and not any(data[end:offset]), "bad table"
        assert name not in sections and flags in (0, 1), "bad table"
        sections[name.decode()] = data[offset:offset + size]
        end = offset + size
        assert flags == 1 or name in (b"TOPO", b"COVR", b"BNDS", b"LEVL", b"PROV"), "a section that must be known and is not"
    assert end == len(data)
    return sections


def records(layout, count, data, at):
    """`count` records at `at`, and what is behind them."""
    size = struct.calcsize("<" + layout)
    return [list(struct.unpack_from("<" + layout, data, at + i * size)) for i in range(count)], at + count * size


def children(code):
    return (code & 15) + 1, code >> 4  # all, those with children


def nodes_of(topology, cover, bound):
    nodes = [{"cover": list(c), "child_count": 0} for c in struct.iter_unpack("<4f", cover)]
    bounds = [list(b) for b in struct.iter_unpack("<4f", bound)]
    is_inner = [len(topology) > 0] + [False] * (len(nodes) - 1)
    first_child, used = 1, 0
    for node, inner in zip(nodes, is_inner):  # the list grows true ahead of the loop
        if inner:
            count, inner_children = children(topology[used])
            node.update(child_count=count, first_child=first_child, bound=bounds[used])
            is_inner[first_child:first_child + inner_children] = [True] * inner_children
            first_child, used = first_child + count, used + 1
    assert first_child == len(nodes) and used == len(bounds) == len(topology)
    return nodes


def search_nodes(spheres, codes):
    return [s + [inner, count - inner] for s, (count, inner) in zip(spheres, map(children, codes))]


def search_of(data):
    inner, items = struct.unpack_from("<II8x", data)
    spheres, at = records("4f", inner, data, 16)
    item, at = records("H", items, data, at)
    assert len(data) == at + inner
    return {"inner": search_nodes(spheres, data[at:]), "item": [i for i, in item]}


def skin_of(data):
    names = ("step_mm", "offset_step_mm", "tolerance_mm", "mesh_distance_mm", "crease_angle_rad")
    numbers = struct.unpack_from("<8f", data)
    skin = {"low_mm": list(numbers[:3]), **dict(zip(names, numbers[3:]))}
    inner, triangles, vertices, edges = struct.unpack_from("<4I", data, 32)
    spheres, at = records("4f", inner, data, 48)
    skin["triangles"], at = records("6H", triangles, data, at)
    packed, at = records("Q2h", vertices, data, at)
    skin["vertices"] = [[p & 0x1FFFFF, p >> 21 & 0x1FFFFF, p >> 42, u, v] for p, u, v in packed]
    skin["edges"], at = records("3bB2h", edges, data, at)
    assert len(data) == at + inner
    skin["inner"] = search_nodes(spheres, data[at:])
    return skin


def unit_vector(u, v):
    x, y = u / 32767, v / 32767
    z = 1 - abs(x) - abs(y)
    fold = max(-z, 0)
    x, y = x - math.copysign(fold, x), y - math.copysign(fold, y)
    length = math.sqrt(x * x + y * y + z * z)
    return [x / length, y / length, z / length]


def patches_of(skin):
    """Positions and normals of the six nodes of each patch."""
    corners = [[low + skin["step_mm"] * p for low, p in zip(skin["low_mm"], v)] for v in skin["vertices"]]
    patches = []
    for triangle in skin["triangles"]:
        vertex, edge = triangle[:3], triangle[3:]
        positions = [corners[v] for v in vertex]
        for k in range(3):
            offset = [skin["offset_step_mm"] * o for o in skin["edges"][edge[k]][:3]]
            positions.append([(a + b) / 2 + o for a, b, o in zip(positions[k], positions[(k + 1) % 3], offset)])
        normals = [unit_vector(*skin["vertices"][v][3:]) for v in vertex] + [unit_vector(*skin["edges"][e][4:]) for e in edge]
        patches.append([positions, normals])
    return patches


def read(data):
    sections = sections_of(data)
    provenance = sections["PROV"]
    tree = {"origin_mm": list(struct.unpack_from("<3d", provenance)),
            "branching": provenance[180],
            "nodes": nodes_of(sections["TOPO"], sections["COVR"], sections["BNDS"])}
    spheres = [count for count, in struct.iter_unpack("<I12x", sections["LEVL"])]
    if "SRCH" in sections:
        tree["search"] = search_of(sections["SRCH"])
    if "SKIN" in sections:
        tree["skin"] = skin_of(sections["SKIN"])
    return tree, spheres


if __name__ == "__main__":
    found, level_spheres = read(open(sys.argv[1], "rb").read())
    print(len(found["nodes"]), "nodes,", len(found.get("skin", {}).get("triangles", [])), "triangles")
    if len(sys.argv) > 2:
        expected = json.load(open(sys.argv[2]))
        for key in found:
            assert found[key] == expected[key], f"{key} differs from the JSON"
        assert found.keys() >= expected.keys() & {"search", "skin"}, "the JSON has more"
        assert level_spheres == [level["spheres"] for level in expected["levels"]], "levels differ from the JSON"
    if len(sys.argv) > 3:
        own, theirs = patches_of(found["skin"]), json.load(open(sys.argv[3]))
        assert len(own) == len(theirs) > 0
        for mine, other in zip(own, theirs):
            for a, b in zip(sum(mine, []), sum(other, [])):
                assert max(abs(x - y) for x, y in zip(a, b)) < 1e-5, "a patch differs"
