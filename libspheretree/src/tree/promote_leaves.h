// SPDX-License-Identifier: GPL-3.0-or-later
// Ends branches of a tree for a tolerance early where the cover is good enough: a leaf that can replace a sphere of a
// level above moves up.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "spheretree/builder/progress.h"
#include "spheretree/core/sphere.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

/// `levels`: spheres of each level (centres relative to `origin`), each level a cover of `mesh`, the leaves last. If an
/// inner level still covers every triangle with a leaf in place of one of its spheres, as proven by
/// redundant_spheres.h, the leaf moves up: it is appended to that level and removed from the last one, since it
/// represents its part of the surface on all levels below. Each promotion saves a node. No level's overhang increases,
/// and no level has too few spheres for the children of the next. Returns, for each level, how many of its leading
/// spheres may still have children. Deterministic for any number of threads. @throws Cancelled.
std::vector<std::size_t> promoteLeaves(const TriangleMesh& mesh, const Eigen::Vector3d& origin, int branching, std::uint64_t seed,
                                       std::vector<std::vector<Sphere>>& levels, Progress& progress);

}  // namespace spheretree::builder
