// SPDX-License-Identifier: GPL-3.0-or-later
// Collada (.dae) meshes, by the library Assimp: what many robot descriptions ship.
#pragma once

#include <filesystem>

#include "spheretree/core/triangle_mesh.h"

namespace spheretree::robot {

/// All triangles of the scene, in mm by the <unit> of the file (a metre without one), axes as in the file: like the
/// viewers of ROS, <up_axis> is not looked at. Equal vertices are welded.
/// @throws formats::FileError, formats::FormatError
TriangleMesh readDae(const std::filesystem::path& path);

}  // namespace spheretree::robot
