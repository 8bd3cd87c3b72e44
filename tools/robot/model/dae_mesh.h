// SPDX-License-Identifier: GPL-3.0-or-later
// Collada (.dae) meshes, which many robot descriptions use, read with the library Assimp.
#pragma once

#include <filesystem>

#include "spheretree/core/triangle_mesh.h"

namespace spheretree::robot {

/// All triangles of the scene, in mm according to the <unit> of the file (default: metre), with the axes of the file:
/// like the viewers of ROS, it ignores <up_axis>. Equal vertices are welded. `unit_mm` is the length that the file
/// calls a metre [mm].
/// @throws formats::FileError, formats::FormatError
TriangleMesh readDae(const std::filesystem::path& path, double unit_mm = 1000);

}  // namespace spheretree::robot
