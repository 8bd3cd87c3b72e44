// SPDX-License-Identifier: GPL-3.0-or-later
// Branches of a tree for a tolerance end where their part is good enough: a leaf that can stand for a sphere of a level
// above moves up.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "spheretree/builder/progress.h"
#include "spheretree/core/sphere.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

/// `levels`: spheres of each level (centres relative to `origin`), each level a cover of `mesh`, the leaves last. Where
/// an inner level still covers every triangle with a leaf in place of one of its spheres, proven as in
/// redundant_spheres.h, the leaf ends there: its level then has it behind its other spheres, and the level of the
/// leaves has it no more, as it stands for its part on all levels below. The tree has a node less for each. No level
/// reaches out farther than before, and none lacks room for the children of the next. Returns how many spheres of each
/// level, its first, go on. Deterministic for any number of threads. @throws Cancelled.
std::vector<std::size_t> promoteLeaves(const TriangleMesh& mesh, const Eigen::Vector3d& origin, int branching, std::uint64_t seed,
                                       std::vector<std::vector<Sphere>>& levels, Progress& progress);

}  // namespace spheretree::builder
