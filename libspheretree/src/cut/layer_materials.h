// SPDX-License-Identifier: GPL-3.0-or-later
// The material of each layer of an object, as a closed mesh.
// Units: mm. Deterministic.
#pragma once

#include <span>
#include <vector>

#include "cut/cut_volumes.h"
#include "spheretree/builder/progress.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

struct LayerMaterial {
  TriangleMesh mesh;    // what is inside the layer's mesh and the first one, and outside of those after it
  VolumeBounds volume;  // of it [mm^3]
};

/// `layers`: sound meshes. Method: subtract_solid.h; where that fails, the material is the whole mesh of the layer, and
/// the lower bound of its volume is 0. @throws Cancelled
std::vector<LayerMaterial> layerMaterials(std::span<const TriangleMesh> layers, Progress& progress);

}  // namespace spheretree::builder
