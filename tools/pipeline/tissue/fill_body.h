// SPDX-License-Identifier: GPL-3.0-or-later
// About as many tetrahedra as are asked for, whatever the mesh: one with far more triangles is simplified first.
#pragma once

#include <cstddef>

#include "spheretree/builder/progress.h"
#include "spheretree/builder/soften_tree.h"

namespace spheretree::pipeline {

inline constexpr int kMinTetrahedra = 100, kMaxTetrahedra = 50'000, kUsualTetrahedra = 3000;

struct FilledBody {
  TriangleMesh boundary;  // what the tetrahedra fill: the mesh, or a simplified form of it
  TetrahedronList tetrahedra;
  double boundary_distance_mm = 0;  // no point of the mesh is farther from the boundary; proven [mm]
};

/// `mesh` must be sound. The number is met within a factor of 1.5 where the shape allows it; thin walls and fine detail
/// that must not be simplified away need more. `seconds`: limit for each run of the child; there are at most 6.
/// @throws as runTetrahedra()
FilledBody fillBody(const TriangleMesh& mesh, int tetrahedra, double seconds, builder::Progress& progress);

}  // namespace spheretree::pipeline
