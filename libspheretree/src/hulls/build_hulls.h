// SPDX-License-Identifier: GPL-3.0-or-later
// The hulls of a tool: fitted to its mesh, cut to parts, and proven. docs/algorithms/hulls/fit_hulls.md
// Units: mm.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <string>

#include "geometry/distance_field.h"
#include "spheretree/builder/progress.h"
#include "spheretree/core/hulls.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

struct HullSettings {
  double tolerance = 0;       // > 0: of the overhang [mm]; 0: the smallest that max_hulls meet, to a tenth
  std::size_t max_hulls = 0;  // 1 or more
};

/// Hulls that cover `mesh` and reach out of `field` by at most the tolerance; empty if that takes more than max_hulls,
/// or if the tolerance is too small for float32. Their centres are relative to `origin`. Deterministic for any number
/// of threads. @throws Cancelled.
Hulls buildHulls(const TriangleMesh& mesh, const DistanceField& field, const Eigen::Vector3d& origin, const HullSettings& settings,
                 Progress& progress);

/// Returns which promise of decoded hulls does not hold, or an empty text: they cover the mesh, and none reaches out of
/// `field` by more than their bound.
std::string findUnproven(const TriangleMesh& mesh, const DistanceField& field, const Hulls& decoded, const Eigen::Vector3d& origin,
                         Progress& progress);

}  // namespace spheretree::builder
