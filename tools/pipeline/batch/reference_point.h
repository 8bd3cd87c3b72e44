// SPDX-License-Identifier: GPL-3.0-or-later
// The point of a tool about which forces are rendered, if a scene defines it by the shape of the tool. Units: mm, frame
// of the tool's mesh.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "pipeline/batch/batch_items.h"

namespace spheretree::pipeline {

/// "centre": the middle of the bounding box of `points`; "tip": the end, along their longest axis, whose last tenth is
/// thinner.
Eigen::Vector3d namedPoint(const std::string& name, const std::vector<Eigen::Vector3d>& points);

/// Sets the reference_point_mm of `tool` from its reference_point and its mesh or tree in `item`.
void resolveReferencePoint(formats::SceneItem& tool, const BatchItem& item);

/// Distance from `point` to the nearest vertex of the item's mesh, or to the nearest leaf of its tree.
double distanceFrom(const Eigen::Vector3d& point, const BatchItem& item);

}  // namespace spheretree::pipeline
