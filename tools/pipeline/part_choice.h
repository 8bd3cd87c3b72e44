// SPDX-License-Identifier: GPL-3.0-or-later
// --parts: which part of a mesh a verb works on.
#pragma once

#include <string>

#include "spheretree/core/triangle_mesh.h"

namespace spheretree::pipeline {

/// The whole mesh, a named part of it, or a connected component. @throws formats::FormatError with the choices if there is none such.
TriangleMesh choosePart(TriangleMesh mesh, const std::string& parts);

}  // namespace spheretree::pipeline
