// SPDX-License-Identifier: GPL-3.0-or-later
// From a mesh as read from a file to one that the builders accept.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "spheretree/builder/repair_mesh.h"
#include "spheretree/formats/mesh_file.h"

namespace spheretree::pipeline {

/// Reads a mesh in the given unit, which overrides that of the format; "": the unit of the format (glTF), or mm.
formats::MeshFile readMeshIn(const std::filesystem::path& path, const std::string& unit);

/// The value of the option --repair: "auto", "off" or "wrap".
builder::RepairKind repairKind(const std::string& option);

/// The mesh in the form that the builders need, with a note for each step that changed it. `name` is the prefix of
/// messages.
/// @throws builder::BuildError for a mesh that stays defective, with the reasons; builder::Cancelled.
builder::RepairedMesh soundMesh(const TriangleMesh& mesh, const std::string& name, builder::RepairKind kind,
                                std::vector<std::string>& notes, builder::Progress& progress);

/// The repair steps, for reports; keys: docs/mesh_input.md
nlohmann::ordered_json repairJson(const builder::RepairedMesh& repaired);

}  // namespace spheretree::pipeline
