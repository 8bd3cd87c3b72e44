# SPDX-License-Identifier: Apache-2.0
"""Reads a .stree file by docs/file_format.md alone. Usage: read_stree.py TREE.stree [TREE.json to compare with]"""
import json
import struct
import sys


def crc64(data):
    crc = 2**64 - 1
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ (0xC96C5795D7870F42 if crc & 1 else 0)
    return crc ^ 2**64 - 1


def read(data):
    assert data[:8] == b"\x89STREE\r\n", "not a sphere-tree"
    major, _, header, size, crc, nodes, inner = struct.unpack_from("<HHIQQII", data, 8)
    assert major == 1 and size == len(data)
    assert crc == crc64(data[:24] + bytes(8) + data[32:]), "damaged"
    bound_at = (header + 16 * nodes + 63) // 64 * 64
    cover = [list(struct.unpack_from("<4f", data, header + 16 * i)) for i in range(nodes)]
    bound = [list(struct.unpack_from("<4f", data, bound_at + 16 * i)) for i in range(inner)]
    tags = [data[bound_at + 16 * i + 12] for i in range(inner)]  # low 8 bits of the radius
    tree = {"origin_mm": list(struct.unpack_from("<3d", data, 48)), "nodes": [{"cover": c, "child_count": 0} for c in cover]}
    is_inner = [inner > 0] + [False] * (nodes - 1)
    first_child, used = 1, 0
    for i, node in enumerate(tree["nodes"]):
        if is_inner[i]:
            count, inner_children = (tags[used] & 15) + 1, tags[used] >> 4
            node.update(child_count=count, first_child=first_child, bound=bound[used])
            is_inner[first_child:first_child + inner_children] = [True] * inner_children
            first_child, used = first_child + count, used + 1
    assert first_child == nodes and used == inner
    return tree


if __name__ == "__main__":
    found = read(open(sys.argv[1], "rb").read())
    print(len(found["nodes"]), "nodes")
    if len(sys.argv) > 2:
        expected = json.load(open(sys.argv[2]))
        assert all(found[key] == expected[key] for key in found), "differs from the JSON"
