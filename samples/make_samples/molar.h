// SPDX-License-Identifier: Apache-2.0
// A lower first molar as a closed mesh, from our own implicit solid.
#pragma once

#include <Eigen/Core>

#include "spheretree/core/triangle_mesh.h"

namespace spheretree::samples {

/// Five cusps around a branched fissure, a cervical line, a mesial and a distal root that separate at a furcation.
/// Closed, manifold, genus 0, about 4,000 triangles, 21 mm long. Frame [mm]: x to the front (mesial), y to the cheek
/// (buccal), z up to the chewing surface; z = 0 near the cervical line.
TriangleMesh makeMolar();

/// The implicit solid: negative inside, approximately a distance near its surface [mm].
double molarField(const Eigen::Vector3d& p);

}  // namespace spheretree::samples
