// SPDX-License-Identifier: GPL-3.0-or-later
// The figures of the hulls of a tool: what they leave bare of a mesh, and how far they reach out.
// docs/measures.md
// Units: mm.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "geometry/distance_field.h"
#include "spheretree/builder/evaluation.h"
#include "spheretree/builder/progress.h"
#include "spheretree/core/hulls.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

struct HullSamples {
  std::size_t count = 1'000'000;  // of the surface, by area; > 0
  std::uint64_t seed = 1;
};

/// Measures sound, non-empty hulls, whose centres are relative to `origin`, against `mesh` and its distance field.
/// Deterministic for any number of threads. Cost: 1 to 3 s on one core for some hundred parts. @throws Cancelled,
/// std::invalid_argument for a mesh without area.
HullEvaluation evaluateHulls(const TriangleMesh& mesh, const DistanceField& field, const Hulls& hulls, const Eigen::Vector3d& origin,
                             const HullSamples& samples, Progress& progress);

}  // namespace spheretree::builder
