#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""conformance.py make FOLDER TREE...    writes the set: good files, made of the TREEs, and bad ones
conformance.py check FOLDER [--stree|--soft] COMMAND...    runs COMMAND FILE for each file, or for those of one ending:
its exit code has to be 0 for the good ones alone

The name of a file says what it is about. A bad file has one fault, and the right checksum unless that is the fault."""
import struct
import subprocess
import sys
from pathlib import Path

from stree_reader import crc64, sections_of


def sealed(data: bytes) -> bytes:
    return data[:24] + struct.pack("<Q", crc64(data[:24] + bytes(8) + data[32:])) + data[32:]


def joined(sections, minor=0) -> bytes:
    """A file of (name, flags, bytes)."""
    table, body, at = b"", b"", 32 + 24 * len(sections)
    for name, flags, content in sections:
        gap = -at % 64
        table += struct.pack("<4sIQQ", name.encode(), flags, at + gap, len(content))
        body, at = body + bytes(gap) + content, at + gap + len(content)
    return sealed(struct.pack("<8sHHIQQ", b"\x89STREE\r\n", 1, minor, len(sections), at, 0) + table + body)


def apart(data: bytes) -> list:
    flags = {data[32 + 24 * i:36 + 24 * i].decode(): data[36 + 24 * i] for i in range(struct.unpack_from("<I", data, 12)[0])}
    return [(name, flags[name], content) for name, content in sections_of(data).items()]


def edited(data: bytes, name: str, at: int, layout: str, *values) -> bytes:
    """The file with other numbers at a place of a section, counted from its end if below 0."""
    out = []
    for own, flags, content in apart(data):
        if own == name:
            content = bytearray(content)
            struct.pack_into("<" + layout, content, at % len(content), *values)
        out.append((own, flags, bytes(content)))
    return joined(out)


def resized(data: bytes, name: str, change) -> bytes:
    return joined([(own, flags, change(content) if own == name else content) for own, flags, content in apart(data)])


def raw(data: bytes, at: int, layout: str, *values) -> bytes:
    out = bytearray(data)
    struct.pack_into("<" + layout, out, at, *values)
    return sealed(bytes(out))


def of_file(tree: bytes):
    """Faults of the file around the sections."""
    parts = apart(tree)
    yield "good/as_written", joined(parts)
    yield "good/newer_minor_version", joined(parts, minor=7)
    yield "good/unknown_optional_section_first", joined([("XTRA", 1, b"anything")] + parts)
    yield "good/unknown_optional_section_last", joined(parts + [("XTRA", 1, b"anything")])
    yield "good/required_sections_alone", joined([part for part in parts if not part[1]])
    yield "bad/empty", b""
    yield "bad/magic", raw(tree, 0, "B", 0x88)
    yield "bad/major_version", raw(tree, 8, "H", 2)
    yield "bad/size_in_header", raw(tree, 16, "Q", len(tree) + 1)
    yield "bad/checksum", tree[:-1] + bytes([tree[-1] ^ 1])
    yield "bad/cut_short", tree[:-1]
    yield "bad/cut_in_header", tree[:31]
    yield "bad/bytes_after_end", tree + b"\0"
    yield "bad/too_many_sections", raw(tree, 12, "I", 65)
    yield "bad/unknown_flag", raw(tree, 36, "I", 2)
    yield "bad/offset_not_aligned", raw(tree, 40, "Q", struct.unpack_from("<Q", tree, 40)[0] + 1)
    yield "bad/section_beyond_end", raw(tree, 48, "Q", 2**40)
    yield "bad/unknown_required_section", joined(parts + [("XTRA", 0, b"anything")])
    yield "bad/section_twice", joined(parts + [parts[0]])
    for name in ("TOPO", "COVR", "BNDS", "LEVL", "PROV"):
        yield f"bad/without_{name}", joined([part for part in parts if part[0] != name])


def of_tree(tree: bytes):
    held = sections_of(tree)
    smallest = min(struct.unpack_from("<f", held["COVR"], at)[0] for at in range(12, len(held["COVR"]), 16))
    yield "bad/cover_not_finite", edited(tree, "COVR", 0, "f", float("nan"))
    yield "bad/cover_infinite", edited(tree, "COVR", 4, "f", float("inf"))
    yield "bad/radius_zero", edited(tree, "COVR", 12, "f", 0)
    yield "bad/radius_negative", edited(tree, "COVR", 12, "f", -smallest)
    yield "bad/bound_too_small", edited(tree, "BNDS", 12, "f", smallest / 2)
    yield "bad/more_inner_than_children", edited(tree, "TOPO", 0, "B", 0x80)
    yield "bad/more_children_than_nodes", edited(tree, "TOPO", -1, "B", 0x07 if held["TOPO"][-1] != 7 else 0x06)
    yield "bad/cover_one_too_many", resized(tree, "COVR", lambda content: content + content[-16:])
    yield "bad/cover_one_missing", resized(tree, "COVR", lambda content: content[:-16])
    yield "bad/cover_cut", resized(tree, "COVR", lambda content: content[:-1])
    yield "bad/level_count", edited(tree, "LEVL", 0, "I", 2)
    yield "bad/level_radius", edited(tree, "LEVL", 12, "f", smallest)
    yield "bad/level_overhang", edited(tree, "LEVL", 4, "f", -2)
    yield "bad/level_missing", resized(tree, "LEVL", lambda content: content[:-16])
    yield "bad/origin_not_finite", edited(tree, "PROV", 0, "d", float("nan"))
    yield "bad/branching_below_children", edited(tree, "PROV", 180, "B", 2)
    yield "bad/branching_too_large", edited(tree, "PROV", 180, "B", 9)
    yield "bad/reserved_of_provenance", edited(tree, "PROV", 181, "B", 1)
    yield "bad/provenance_cut", resized(tree, "PROV", lambda content: content[:-1])


def of_search(tree: bytes):
    yield "bad/search_no_nodes", edited(tree, "SRCH", 0, "I", 0)
    yield "bad/search_reserved", edited(tree, "SRCH", 8, "I", 1)
    yield "bad/search_sphere_too_small", edited(tree, "SRCH", 28, "f", 1e-6)
    yield "bad/search_children", edited(tree, "SRCH", -1, "B", 0x87)
    yield "bad/search_cut", resized(tree, "SRCH", lambda content: content[:-1])


def of_skin(tree: bytes):
    inner, triangles, vertices, edges = struct.unpack_from("<4I", sections_of(tree)["SKIN"], 32)
    triangle, vertex = 48 + 16 * inner, 48 + 16 * inner + 12 * triangles
    edge = vertex + 12 * vertices
    yield "bad/skin_step_zero", edited(tree, "SKIN", 12, "f", 0)
    yield "bad/skin_tolerance_negative", edited(tree, "SKIN", 20, "f", -1)
    yield "bad/skin_far_away", edited(tree, "SKIN", 0, "f", 2e7)
    yield "bad/skin_vertex_out_of_range", edited(tree, "SKIN", triangle, "H", 65535)
    yield "bad/skin_edge_out_of_range", edited(tree, "SKIN", triangle + 6, "H", 65535)
    yield "bad/skin_corner_twice", edited(tree, "SKIN", triangle, "3H", 0, 0, 1)
    yield "bad/skin_position_bit_63", edited(tree, "SKIN", vertex + 7, "B", 0x80)
    yield "bad/skin_normal_unused_value", edited(tree, "SKIN", vertex + 8, "h", -32768)
    yield "bad/skin_offset_unused_value", edited(tree, "SKIN", edge, "b", -128)
    yield "bad/skin_sharp_edge_with_offset", edited(tree, "SKIN", edge, "3bB", 1, 0, 0, 1)
    yield "bad/skin_sharp_neither_0_nor_1", edited(tree, "SKIN", edge + 3, "B", 2)
    yield "bad/skin_offset_beyond_tolerance", edited(edited(tree, "SKIN", 20, "f", 0), "SKIN", edge, "3bB", 127, 0, 0, 0)
    yield "bad/skin_sphere_too_small", edited(tree, "SKIN", 60, "f", 1e-6)
    yield "bad/skin_cut", resized(tree, "SKIN", lambda content: content[:-1])


def of_hulls(tree: bytes):
    balls, parts, inner = struct.unpack_from("<3I", sections_of(tree)["HULL"], 8)
    part = 32 + 16 * balls + 16 * inner
    yield "bad/hull_overhang_negative", edited(tree, "HULL", 0, "f", -1)
    yield "bad/hull_radius_zero", edited(tree, "HULL", 44, "f", 0)
    yield "bad/hull_no_balls_in_a_part", edited(tree, "HULL", part, "3H", 65535, 65535, 65535)
    yield "bad/hull_ball_out_of_range", edited(tree, "HULL", part, "H", 65534)
    yield "bad/hull_sphere_too_small", edited(tree, "HULL", 32 + 16 * balls + 12, "f", 1e-6)
    yield "bad/hull_reserved", edited(tree, "HULL", 24, "I", 1)
    yield "bad/hull_cut", resized(tree, "HULL", lambda content: content[:-1])


def of_tissue(tree: bytes):
    held = sections_of(tree)
    nodes, tetrahedra, fixed, vertices = struct.unpack_from("<4I", held["TISS"], 24)
    vertex, tetrahedron = 40 + 24 * nodes, 40 + 24 * nodes + 40 * vertices
    a, b = struct.unpack_from("<2I", held["TISS"], tetrahedron)
    yield "good/tissue", joined(apart(tree))
    yield "bad/tissue_poisson_half", edited(tree, "TISS", 8, "d", 0.5)
    yield "bad/tissue_stiffness_zero", edited(tree, "TISS", 0, "d", 0)
    yield "bad/tissue_node_not_finite", edited(tree, "TISS", 40, "d", float("nan"))
    yield "bad/tissue_vertex_in_no_tetrahedron", edited(tree, "TISS", vertex + 24, "I", tetrahedra)
    yield "bad/tissue_tetrahedron_inside_out", edited(tree, "TISS", tetrahedron, "2I", b, a)
    yield "bad/tissue_tetrahedron_out_of_range", edited(tree, "TISS", tetrahedron, "I", nodes)
    yield "bad/tissue_cut", resized(tree, "TISS", lambda content: content[:-4])
    if fixed:
        yield "bad/tissue_fixed_out_of_range", edited(tree, "TISS", -4, "I", nodes)
    yield "bad/leaf_on_no_vertex", edited(tree, "TLEA", -4, "I", 2**31)
    yield "bad/leaves_cut", resized(tree, "TLEA", lambda content: content[:-4])
    yield "bad/response_cut", resized(tree, "TRES", lambda content: content[:-4])
    yield "bad/without_leaves_of_tissue", joined([part for part in apart(tree) if part[0] != "TLEA"])


def make(folder: Path, trees: list):
    """Each kind of fault once, from the first tree that has what it is about."""
    folder.mkdir(parents=True, exist_ok=True)
    done = set()
    for path in trees:
        tree = Path(path).read_bytes()
        held = sections_of(tree)
        kinds = [of_file, of_tree] + [kind for name, kind in (("SRCH", of_search), ("SKIN", of_skin), ("HULL", of_hulls)) if name in held]
        ending = ".soft" if "TISS" in held else ".stree"
        for kind in [of_tissue] if ending == ".soft" else kinds:
            for name, data in kind(tree) if kind not in done else ():
                target = folder / (name + ending)
                target.parent.mkdir(exist_ok=True)
                target.write_bytes(data)
            done.add(kind)


def check(folder: Path, endings: list, command: list):
    faults, count = [], 0
    for path in sorted(path for ending in endings for path in folder.glob(f"*/*{ending}")):
        count += 1
        run = subprocess.run([*command, str(path)], capture_output=True, text=True, check=False)
        if (run.returncode == 0) != (path.parent.name == "good") or run.returncode < 0 or "Traceback" in run.stderr:
            faults.append(f"{path.relative_to(folder)}: exit code {run.returncode} {(run.stdout + run.stderr).strip()[-200:]}")
    if count < 10:
        faults.append(f"only {count} files in {folder}")
    print("\n".join(faults) if faults else f"{count} files: the good ones are taken, the bad ones are refused")
    sys.exit(1 if faults else 0)


if len(sys.argv) > 3 and sys.argv[1] == "make":
    make(Path(sys.argv[2]), sys.argv[3:])
elif len(sys.argv) > 3 and sys.argv[1] == "check":
    kind = {"--stree": [".stree"], "--soft": [".soft"]}.get(sys.argv[3])
    check(Path(sys.argv[2]), kind or [".stree", ".soft"], sys.argv[4 if kind else 3:])
else:
    sys.exit(__doc__)
