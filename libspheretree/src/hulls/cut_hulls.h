// SPDX-License-Identifier: GPL-3.0-or-later
// From hulls to what a file stores: parts that are not much longer than thick, of those faces, edges and corners that
// can touch something, and the search tree over them. docs/algorithms/hulls/cut_hulls.md
// Units: mm.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "geometry/hull.h"
#include "spheretree/core/hulls.h"

namespace spheretree::builder {

/// The parts of one or more `hulls` (frame of the mesh), relative to `origin` and rounded outward, with their search
/// tree. The bound of the overhang is not set. Empty if there are more balls or items than a file can number.
/// Deterministic.
Hulls cutHulls(std::span<const Hull> hulls, const Eigen::Vector3d& origin);

/// Part number `part`, in the frame of `hulls`.
Hull hullOf(const Hulls& hulls, const HullPart& part);

}  // namespace spheretree::builder
