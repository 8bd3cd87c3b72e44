// SPDX-License-Identifier: GPL-3.0-or-later
// How much a tree changes under changes of its mesh that should not matter: rotation, scale, order, subdivision, slight
// noise.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "spheretree/builder/build_sphere_tree.h"
#include "spheretree/builder/progress.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

struct SensitivityRow {
  std::string change;         // "rotation", "noise", "vertex order", "face order", "scale 2^k", "scale 1.7", "subdivision"
  int cases = 0;              // meshes tried
  double largest_change = 0;  // largest relative change of the leaf level's overhang bound against the unchanged mesh, after scaling back
  bool same_spheres = false;  // in all cases, bit for bit (orders) or bit for bit up to the exponent (scale 2^k)
};

struct SensitivitySettings {
  int rotations = 24;   // random rotations about the middle of the box; >= 0
  int others = 4;       // cases of noise, and of each order; >= 0
  double noise = 5e-4;  // largest shift of a vertex along each axis, as a share of the diagonal; >= 0
  std::uint64_t seed = 1;
};

/// One row for each kind of change. Builds `1 + rotations + 3 * others + 6` trees with `build`, one after the other. If
/// noise breaks the mesh (checkMesh finds a fault), it is halved until the mesh is sound.
/// @throws what buildSphereTree throws.
std::vector<SensitivityRow> measureSensitivity(const TriangleMesh& mesh, const BuildSettings& build, const SensitivitySettings& settings,
                                               Progress& progress);

}  // namespace spheretree::builder
