# SPDX-License-Identifier: Apache-2.0
"""A mesh that any number of tests can have in any size."""
import math


def write_torus(path, radius, side=24):
    """A torus as OBJ, with `side` points both ways round; its tube is 3 mm thick."""
    lines = []
    for i in range(side):
        for j in range(side):
            u, v = 2 * math.pi * i / side, 2 * math.pi * j / side
            r = radius + 3 * math.cos(v)
            lines.append(f"v {r * math.cos(u):.9f} {r * math.sin(u):.9f} {3 * math.sin(v):.9f}")
    for i in range(side):
        for j in range(side):
            a, b = i * side + j + 1, (i + 1) % side * side + j + 1
            c, d = (i + 1) % side * side + (j + 1) % side + 1, i * side + (j + 1) % side + 1
            lines += [f"f {a} {b} {c}", f"f {a} {c} {d}"]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
