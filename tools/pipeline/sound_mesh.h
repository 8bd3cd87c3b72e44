// SPDX-License-Identifier: GPL-3.0-or-later
// From a mesh as it was read to one that the builders take.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "spheretree/builder/repair_mesh.h"
#include "spheretree/formats/mesh_file.h"

namespace spheretree::pipeline {

/// A mesh in the unit that a user gave, whatever the format says; "": in its own (glTF), or mm.
formats::MeshFile readMeshIn(const std::filesystem::path& path, const std::string& unit);

/// Of the option --repair: "auto", "off" or "wrap".
builder::RepairKind repairKind(const std::string& option);

/// The mesh as the builders need it, with a note for each step that changed it. `name` stands in front of messages.
/// @throws builder::BuildError for a mesh that stays defective, with the reasons; builder::Cancelled.
builder::RepairedMesh soundMesh(const TriangleMesh& mesh, const std::string& name, builder::RepairKind kind,
                                std::vector<std::string>& notes, builder::Progress& progress);

/// What was done, for reports; keys: docs/mesh_input.md
nlohmann::ordered_json repairJson(const builder::RepairedMesh& repaired);

}  // namespace spheretree::pipeline
