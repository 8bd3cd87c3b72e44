// SPDX-License-Identifier: GPL-3.0-or-later
// `spheretree help scene`: a summary of the scene file for users without documentation. Complete reference:
// docs/scene_file.md
#pragma once

#include <string_view>

namespace spheretree::tool {

inline constexpr std::string_view kSceneHelp = R"(A scene (NAME.scene.json) names a tool and the objects that it touches:

{"schema": "spheretree.scene/1", "unit": "mm",
 "defaults": {"builder": "cover", "levels": 4, "tolerance_mm": 0.1},
 "coupling": {"translation_n_per_mm": 1.0, "rotation_n_mm_per_rad": 1000.0},
 "limits": {"force_n": 8.0, "torque_n_mm": [188, 188, 48]},
 "tool": {"name": "probe", "mesh": "probe.obj",
          "reference_point_mm": [0, 0, 0]},
 "objects": [{"name": "tooth_11", "mesh": "mouth.obj", "part": "tooth_11",
              "position_mm": [0, 0, 0], "quaternion_wxyz": [1, 0, 0, 0]}]}

schema        spheretree.scene/1; needed
unit          mm, cm, m or in: unit of the meshes whose files have none (glTF is
              in metres); default mm
defaults      settings of every tree that has no own value
coupling      spring between the hand and the tool; default 1 N/mm and
              1000 N mm/rad
limits        largest force, and largest component of the torque; default 8 N
              and 188, 188, 48 N mm
tool          needed; the object in the hand. reference_point_mm: point at which
              forces are rendered; default 0, 0, 0; or "reference_point": "tip"
              (the thinner end) or "centre" (of its box)
objects       needed; 1 to 4096
work          regions with a tolerance of their own:
              [{"name": "pocket", "tolerance_mm": 0.05,
                "sphere": {"centre_mm": [1, 2, 3], "radius_mm": 6}}]
reach         {"radius_mm": 0.2, "tolerance_mm": 0.5}: tolerance of surfaces
              that this ball cannot touch

The tool and each object:
name          needed; letters and digits of any script, _, - and .; unique,
              upper and lower case being the same
mesh or tree  one is needed: a path from the folder of the scene file, or an
              absolute one
unit          of this mesh, glTF included
part          a part of the mesh by its name, or #N as
              `spheretree check --list-parts` counts them; default the whole
              mesh
position_mm, quaternion_wxyz
              objects only: from the frame of the mesh to the world
soft          objects only: soft tissue, {"young_kpa": 15, "poisson": 0.45,
              "density_kg_m3": 1040, "share": 0.5, "tetrahedra": 3000,
              "fixed": [{"sphere": {...}}, {"box": {...}}, {"inside": "jaw"}]};
              fixed: regions that stay in place
builder, quality, repair, levels, branching, tolerance_mm, seed
              as the options of `spheretree build`

To make a scene from mesh files: spheretree scene --help
)";

}  // namespace spheretree::tool
