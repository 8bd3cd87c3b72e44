// SPDX-License-Identifier: GPL-3.0-or-later
// Redundant spheres of a certified cover: without them every triangle is still covered.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "spheretree/builder/progress.h"
#include "spheretree/core/sphere.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

/// Marks spheres of a cover of `mesh` (centres relative to `origin`) such that the others cover every triangle without
/// growing, as proven by provenRedundant (certify_cover.h). Candidates are the spheres of which every sample of the
/// surface lies in another sphere, too. `group` (spheres): the last sphere of a group is kept. Spheres in `fixed` (may
/// be empty) are kept. At most `max_count` are marked. Deterministic for any number of threads. Cost: 40 samples a
/// sphere, then a proof near each candidate.
std::vector<char> findRedundantSpheres(const TriangleMesh& mesh, std::span<const Sphere> spheres, const Eigen::Vector3d& origin,
                                       std::span<const std::uint32_t> group, std::span<const char> fixed, std::size_t max_count,
                                       std::uint64_t seed, Progress& progress);

}  // namespace spheretree::builder
