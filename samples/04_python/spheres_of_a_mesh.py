# SPDX-License-Identifier: Apache-2.0
# %% [markdown]
# Sphere-trees from Python: build, measure, chart speed against accuracy, and look at a level. Editors that know cells
# (# %%) run this step by step; `python3 spheres_of_a_mesh.py MESH FOLDER` runs all of it and writes its pictures into
# FOLDER.

# %%
import sys
import time
from pathlib import Path

import numpy as np

import spheretree

mesh = spheretree.read(sys.argv[1] if len(sys.argv) > 1 else "tooth.obj")
folder = Path(sys.argv[2] if len(sys.argv) > 2 else ".")
report = spheretree.check(mesh)
print(mesh, "clean" if report else report.summary())

# %% The fewest spheres whose leaves reach out at most 2 % of the diagonal.
diagonal = float(np.linalg.norm(report.high - report.low))
tree = spheretree.build(mesh, tolerance=0.02 * diagonal)
centres, radii = tree.level(-1)  # float32, (n, 3) and (n,): views, no copies
print(f"{len(radii)} spheres reach out at most {tree.overhang_bound:.4g} mm, proven; radii {radii.min():.4g} to {radii.max():.4g} mm")

# %% How good is it? The same figures as those of `spheretree evaluate`.
for level in spheretree.evaluate(mesh, tree, limits=False).levels:
    print(f"level {level.level}: {level.spheres} spheres, {100 * level.coverage.uncovered_fraction:.2g} % bare, reaches out {level.overhang.max:.4g} mm")

# %% Speed against accuracy: the time of a build and the proven overhang, for each quality and number of leaves.
rows = []
for quality in ("quick", "standard"):
    for leaves in (8, 32, 128):
        begin = time.perf_counter()
        built = spheretree.build(mesh, leaves=leaves, quality=quality, skin=None)
        rows.append((quality, leaves, time.perf_counter() - begin, built.overhang_bound))
        print("{:9s} {:4d} leaves  {:6.2f} s  {:8.4f} mm".format(*rows[-1]))

# %% Pictures, where matplotlib is there (Debian: python3-matplotlib).
try:
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
except ModuleNotFoundError:
    sys.exit("No pictures without matplotlib.")

figure, axes = plt.subplots(figsize=(6, 4))
for quality in ("quick", "standard"):
    of_quality = [row for row in rows if row[0] == quality]
    axes.plot([row[2] for row in of_quality], [row[3] for row in of_quality], "o-", label=quality)
    for _, leaves, seconds, bound in of_quality:
        axes.annotate(f"{leaves}", (seconds, bound), textcoords="offset points", xytext=(4, 4))
axes.set(xscale="log", yscale="log", xlabel="build [s]", ylabel="overhang bound of the leaves [mm]", title="Speed against accuracy")
axes.legend()
figure.savefig(folder / "speed.png", dpi=120)

# %% The spheres of the last level.
figure = plt.figure(figsize=(6, 6))
axes = figure.add_subplot(projection="3d")
u, v = np.mgrid[0:2 * np.pi:13j, 0:np.pi:7j]
unit = np.stack([np.cos(u) * np.sin(v), np.sin(u) * np.sin(v), np.cos(v)])
for (x, y, z), radius in zip(centres, radii):
    axes.plot_surface(x + radius * unit[0], y + radius * unit[1], z + radius * unit[2], alpha=0.3, linewidth=0)
axes.set_box_aspect(report.high - report.low)
axes.set(xlabel="x [mm]", ylabel="y [mm]", zlabel="z [mm]", title=f"{len(radii)} spheres")
figure.savefig(folder / "level.png", dpi=120)
