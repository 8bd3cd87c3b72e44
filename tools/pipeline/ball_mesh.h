// SPDX-License-Identifier: GPL-3.0-or-later
// The mesh of a ball, used as tool in a scene that names none.
#pragma once

#include "spheretree/core/triangle_mesh.h"

namespace spheretree::pipeline {

/// 512 triangles, centred at the origin, with vertices on the sphere of `radius` [mm].
TriangleMesh ballMesh(double radius);

}  // namespace spheretree::pipeline
