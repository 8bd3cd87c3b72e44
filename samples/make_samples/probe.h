// SPDX-License-Identifier: Apache-2.0
// A dental probe (explorer) as a closed mesh.
#pragma once

#include "spheretree/core/triangle_mesh.h"

namespace spheretree::samples {

/// A slender tapered shaft that ends in a curved hook with a fine tip: a tube of 34 rings with 16 corners, 1,088
/// triangles, 34 mm long. Closed, manifold, genus 0. Frame [mm]: the tip at the origin, the shaft along +z, the hook in
/// the plane y = 0.
TriangleMesh makeProbe();

}  // namespace spheretree::samples
