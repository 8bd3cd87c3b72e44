// SPDX-License-Identifier: GPL-3.0-or-later
// The point of a tool about which forces are rendered, where a scene names it by its shape. Units: mm, frame of the
// tool's mesh.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "pipeline/batch/batch_items.h"

namespace spheretree::pipeline {

/// "centre": the middle of the box of `points`; "tip": along their longest axis the end whose last tenth is the thinner
/// one.
Eigen::Vector3d namedPoint(const std::string& name, const std::vector<Eigen::Vector3d>& points);

/// Gives `tool` the reference_point_mm that its reference_point names, from its mesh or its tree, as `item` has it.
void resolveReferencePoint(formats::SceneItem& tool, const BatchItem& item);

/// Distance from `point` to the nearest vertex of the mesh, or leaf sphere of the tree, of `item`.
double distanceFrom(const Eigen::Vector3d& point, const BatchItem& item);

}  // namespace spheretree::pipeline
