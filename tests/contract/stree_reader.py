#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""stree_reader.py FILE: reads a .stree file by docs/file_format.md alone, and checks what a reader may rely on. Exit
code 1, with the reason, for a file that breaks it. Of a .soft file it reads the tree; soft_reader.py reads the rest."""
import math
import struct
import sys

KNOWN = ("TOPO", "COVR", "BNDS", "LEVL", "PROV", "SRCH", "SKIN", "HULL")

class Refused(Exception): pass
def demand(is_right, reason):
    if not is_right: raise Refused(reason)

def crc64(data):
    table = list(range(256))
    for _ in range(8):
        table = [crc >> 1 ^ (0xC96C5795D7870F42 if crc & 1 else 0) for crc in table]
    crc = 2**64 - 1
    for byte in data:
        crc = crc >> 8 ^ table[(crc ^ byte) & 255]
    return crc ^ 2**64 - 1

def sections_of(data):
    demand(len(data) >= 32 and data[:8] == b"\x89STREE\r\n", "not a sphere-tree")
    major, _, count, size, crc = struct.unpack_from("<HHIQQ", data, 8)
    demand(major == 1, "another major version")
    demand(size == len(data), "cut short, or with bytes after its end")
    demand(crc == crc64(data[:24] + bytes(8) + data[32:]), "checksum")
    demand(count <= 64 and 32 + 24 * count <= size, "table of sections")
    sections, end = {}, 32 + 24 * count
    for i in range(count):
        name, flags, offset, size = struct.unpack_from("<4sIQQ", data, 32 + 24 * i)
        name = name.decode("latin-1")
        demand(offset == (end + 63) // 64 * 64 and offset + size <= len(data) and not any(data[end:offset]), f"place of {name}")
        demand(name not in sections and flags in (0, 1), f"{name} twice, or unknown flags")
        demand(flags == 1 or name in KNOWN, f"required section {name}, which is unknown")
        sections[name], end = data[offset:offset + size], offset + size
    demand(end == len(data), "bytes behind the last section")
    demand(all(name in sections for name in KNOWN[:5]), "a required section is missing")
    return sections

def records(layout, count, data, at):
    size = struct.calcsize("<" + layout)
    demand(at + count * size <= len(data), "section too short")
    return [list(struct.unpack_from("<" + layout, data, at + i * size)) for i in range(count)], at + count * size

def spheres(count, data, at):
    found, at = records("4f", count, data, at)
    demand(all(all(map(math.isfinite, s)) and s[3] > 0 for s in found), "a sphere that is not finite, or without a radius")
    return found, at

def encloses(outer, inner): return math.sqrt(sum((a - b) ** 2 for a, b in zip(outer[:3], inner[:3]))) + inner[3] <= outer[3]

def holds(outer, point): return sum((a - b) ** 2 for a, b in zip(outer[:3], point)) <= outer[3] * outer[3]

def nodes_of(sections, branching):
    codes, count = sections["TOPO"], len(sections["COVR"]) // 16
    demand(1 <= count <= 37449 and len(sections["COVR"]) == 16 * count and len(sections["BNDS"]) == 16 * len(codes), "numbers of spheres")
    cover, bound = spheres(count, sections["COVR"], 0)[0], spheres(len(codes), sections["BNDS"], 0)[0]
    level, is_inner, first, used, children = [0] * count, [bool(codes)] + [False] * (count - 1), 1, 0, [range(0)] * count
    for i in range(count):
        if is_inner[i]:
            demand(used < len(codes), "more inner nodes than numbers of children")
            number, inner = (codes[used] & 15) + 1, codes[used] >> 4
            demand(inner <= number <= branching and first + number <= count and level[i] < 5, "numbers of children")
            children[i], used = range(first, first + number), used + 1
            is_inner[first:first + inner] = [True] * inner
            level[first:first + number], first = [level[i] + 1] * number, first + number
    demand(first == count and used == len(codes), "numbers of children that make no tree")
    below = [[c] for c in cover]
    for i in reversed(range(count)):
        below[i] += [s for k in children[i] for s in below[k]]
        demand(not children[i] or all(encloses(bound[sum(is_inner[:i])], s) for s in below[i]), "a bounding sphere that does not enclose")
    demand(len(sections["LEVL"]) == 16 * (max(level) + 1), "number of levels")
    for k, (number, overhang, smallest, largest) in enumerate(struct.iter_unpack("<I3f", sections["LEVL"])):
        radii = [cover[i][3] for i in range(count) if level[i] == k or level[i] < k and not children[i]]
        demand((number, smallest, largest) == (len(radii), min(radii), max(radii)) and (overhang >= 0 or overhang == -1), f"level {k}")
    return cover, [cover[i] for i in range(count) if not children[i]]

def search(found, codes, order, inside):
    """A search tree; `inside(sphere, item)` holds for all items below each node."""
    demand(len(codes) == len(found) and 1 <= len(found) <= 8191 and sorted(order) == list(range(len(order))), "search tree")
    taken, node, item = [], 1, 0
    for i, code in enumerate(codes):
        inner, items = code >> 4, (code & 15) + 1 - (code >> 4)
        demand(items >= 0 and item + items <= len(order) and node + inner <= len(found) and (not inner or node > i), "children in a search tree")
        taken.append((range(node, node + inner), order[item:item + items]))
        node, item = node + inner, item + items
    demand(node == len(found) and item == len(order), "a search tree that does not take all")
    below = [list(items) for _, items in taken]
    for i in reversed(range(len(found))):
        below[i] += [item for k in taken[i][0] for item in below[k]]
        demand(all(inside(found[i], item) for item in below[i]), "a node of a search tree that does not enclose")

def leaf_search(data, leaves):
    (inner, items, reserved), = records("IIQ", 1, data, 0)[0]
    found, at = spheres(inner, data, 16)
    order, at = records("H", items, data, at)
    demand(items in (0, len(leaves)) and not reserved, "SRCH")
    search(found, data[at:], [i for i, in order] or list(range(len(leaves))), lambda s, i: encloses(s, leaves[i]))

def float32(x): return struct.unpack("<f", struct.pack("<f", x))[0]

def skin(data):
    (*low, step, offset, tolerance, distance, crease, inner, triangles, vertices, edges), = records("8f4I", 1, data, 0)[0]
    demand(all(abs(x) <= 1e7 for x in low) and 0 < step < math.inf and all(0 <= x < math.inf for x in (offset, tolerance, distance, crease)), "SKIN")
    demand(1 <= triangles <= 32768 and vertices <= 65536 and edges <= 65536, "numbers of the skin")
    found, at = spheres(inner, data, 48)
    triangle, at = records("6H", triangles, data, at)
    vertex, at = records("Q2h", vertices, data, at)
    edge, at = records("3bB2h", edges, data, at)
    demand(all(p < 2**63 and -32768 not in n for p, *n in vertex), "a vertex of the skin")
    demand(all(-128 not in e[:3] and -32768 not in e[4:] and e[3] in (0, 1) and not (e[3] and any(e[:3])) for e in edge), "an edge of the skin")
    demand(all(4 / 3 * math.hypot(*(offset * o for o in e[:3])) <= tolerance * (1 + 1e-6) for e in edge), "an edge beyond the tolerance")
    demand(all(len(set(t[:3])) == len(set(t[3:])) == 3 and max(t[:3]) < vertices and max(t[3:]) < edges for t in triangle), "a triangle of the skin")
    place = [[float32(a + float32(step * (p >> shift & 0x1FFFFF))) for a, shift in zip(low, (0, 21, 42))] for p, *_ in vertex]
    def inside(sphere, t):
        a = [place[v] for v in triangle[t][:3]]
        ends = [(a[k], a[(k + 1) % 3], edge[triangle[t][3 + k]]) for k in range(3)]
        return all(holds(sphere, p) for p in a + [[(x + y) / 2 + float32(2 * float32(offset * o)) for x, y, o in zip(*side)] for side in ends])
    search(found, data[at:], list(range(triangles)), inside)

def hulls(data):
    (overhang, count, balls, parts, inner, items, reserved), = records("f5IQ", 1, data, 0)[0]
    demand(0 <= overhang < math.inf and count >= 1 and 1 <= balls <= 65535 and parts >= 1 and items in (0, parts) and not reserved, "HULL")
    ball, at = spheres(balls, data, 32)
    found, at = spheres(inner, data, at)
    part, at = records("3H", parts, data, at)
    order, at = records("H", items, data, at)
    of = [[b for b in p if b != 65535] for p in part]
    demand(all(b and p == b + [65535] * (3 - len(b)) and len(set(b)) == len(b) and max(b) < balls for p, b in zip(part, of)), "a part of a hull")
    demand([len(b) for b in of] == sorted(len(b) for b in of), "parts of hulls out of order")
    demand(all(abs(ball[i][3] - ball[j][3]) <= 0.999 * math.dist(ball[i][:3], ball[j][:3]) for b in of for i in b for j in b if i < j), "a cone")
    search(found, data[at:], [i for i, in order] or list(range(parts)), lambda s, p: all(encloses(s, ball[b]) for b in of[p]))

def read(data):
    sections = sections_of(data)
    demand(len(sections["PROV"]) == 184 and 2 <= sections["PROV"][180] <= 8 and not any(sections["PROV"][181:]), "PROV")
    demand(all(map(math.isfinite, struct.unpack_from("<8d", sections["PROV"]))), "a number of PROV")
    cover, leaves = nodes_of(sections, sections["PROV"][180])
    for name, check in (("SRCH", lambda data: leaf_search(data, leaves)), ("SKIN", skin), ("HULL", hulls)):
        check(sections[name]) if name in sections else None
    return sections, cover

if __name__ == "__main__":
    try:
        print(len(read(open(sys.argv[1], "rb").read())[1]), "nodes")
    except Refused as reason:
        sys.exit(f"{sys.argv[1]}: {reason}")
