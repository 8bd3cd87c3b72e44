// SPDX-License-Identifier: GPL-3.0-or-later
// From a mesh as it was read to one that the builders take.
#pragma once

#include <string>
#include <vector>

#include "spheretree/core/triangle_mesh.h"

namespace spheretree::tool {

/// The mesh as the builders need it, with a note for each change. `name` stands in front of messages; `repair`: turn what is inside out.
/// @throws builder::BuildError for a mesh that stays defective, with the reasons.
TriangleMesh soundMesh(TriangleMesh mesh, const std::string& name, bool repair, std::vector<std::string>& notes);

}  // namespace spheretree::tool
