// SPDX-License-Identifier: GPL-3.0-or-later
// Fills a mesh with approximately the requested number of tetrahedra; a mesh with far more triangles is simplified
// first.
#pragma once

#include <cstddef>

#include "spheretree/builder/progress.h"
#include "spheretree/builder/soften_tree.h"

namespace spheretree::pipeline {

inline constexpr int kMinTetrahedra = 100, kMaxTetrahedra = 50'000, kUsualTetrahedra = 3000;

struct FilledBody {
  TriangleMesh boundary;  // the surface that the tetrahedra fill: the mesh, or a simplified form of it
  TetrahedronList tetrahedra;
  double boundary_distance_mm = 0;  // proven: no point of the mesh is farther than this from the boundary [mm]
};

/// `mesh` must be sound. The number is met within a factor of 1.5 if the shape allows it; thin walls and fine detail
/// that must not be simplified need more. `seconds`: time limit for each run of the child process; there are at most 6
/// runs.
/// @throws as runTetrahedra()
FilledBody fillBody(const TriangleMesh& mesh, int tetrahedra, double seconds, builder::Progress& progress);

}  // namespace spheretree::pipeline
