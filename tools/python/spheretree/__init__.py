# SPDX-License-Identifier: Apache-2.0
"""Certified sphere-trees of triangle meshes, and the haptic runtime that renders them.

    mesh = spheretree.read("tooth.obj")
    tree = spheretree.build(mesh, tolerance=0.1)
    centres, radii = tree.level(3)
    print(tree.overhang_bound, spheretree.evaluate(mesh, tree).levels[-1].coverage.uncovered_fraction)

Lengths are in millimetres. Two extension modules stand behind it: `_core` (meshes, trees, the runtime; Apache-2.0), and
`_builder` (checks, builders, measures; GPL-3.0-or-later), which an installation for a simulator can leave out.
"""
from ._core import (Contact, Distance, Fault, FileError, FormatError, Mesh, Renderer, Scene, SphereTree, Step, __version__, read)

__all__ = ["Contact", "Distance", "Fault", "FileError", "FormatError", "Mesh", "Renderer", "Scene", "SphereTree", "Step", "read"]

try:
    from ._builder import (BuildError, Component, Coverage, CoverLimits, Defect, Evaluation, LevelEvaluation, LinkSpheres, MeshReport,
                           MeshWarning, Overhang, Place, RepairedMesh, RepairStep, RobotSpheres, UsageError, batch, build, check, evaluate, repair, robot)

    __all__ += ["BuildError", "Component", "Coverage", "CoverLimits", "Defect", "Evaluation", "LevelEvaluation", "LinkSpheres",
                "MeshReport", "MeshWarning", "Overhang", "Place", "RepairedMesh", "RepairStep", "RobotSpheres", "UsageError", "batch", "build", "check", "evaluate", "repair", "robot"]
except ModuleNotFoundError as error:  # installed without the builder
    if error.name != __name__ + "._builder":
        raise

for _name in __all__:  # help() and messages name what users import
    if getattr(globals()[_name], "__module__", None) in (__name__ + "._core", __name__ + "._builder"):
        globals()[_name].__module__ = __name__
