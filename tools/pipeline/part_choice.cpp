// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/part_choice.h"

#include <algorithm>
#include <charconv>
#include <optional>

#include "spheretree/builder/mesh_checks.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/mesh_file.h"

namespace spheretree::pipeline {
namespace {

/// The number of "#N", unless a part has that name.
std::optional<std::uint32_t> componentNumber(const TriangleMesh& mesh, const std::string& part) {
  if (std::find(mesh.part_names.begin(), mesh.part_names.end(), part) != mesh.part_names.end()) return std::nullopt;
  if (part.size() < 2 || part[0] != '#') return std::nullopt;
  std::uint32_t number = 0;
  const auto [end, error] = std::from_chars(part.data() + 1, part.data() + part.size(), number);
  return error == std::errc() && end == part.data() + part.size() ? std::optional(number) : std::nullopt;
}

/// The component of each triangle. @throws formats::FormatError if there are not that many components.
const std::vector<std::uint32_t>& searched(const TriangleMesh& mesh, std::uint32_t number, const Components& components) {
  const std::vector<std::uint32_t>& of = components.of(mesh);
  const std::size_t count = of.empty() ? 0 : std::size_t{1} + *std::max_element(of.begin(), of.end());
  if (number >= count)
    throw formats::FormatError("the mesh has no component #" + std::to_string(number) + "; it has " + std::to_string(count) +
                               ", which are counted from #0.");
  return of;
}

}  // namespace

const std::vector<std::uint32_t>& Components::of(const TriangleMesh& mesh) const {
  std::call_once(searched_, [&] { of_ = builder::checkMesh(mesh).component_of; });
  return of_;
}

TriangleMesh partOf(const TriangleMesh& mesh, const std::string& part, const Components& components) {
  const std::optional<std::uint32_t> number = componentNumber(mesh, part);
  if (!number) return formats::selectPart(mesh, part);
  const std::vector<std::uint32_t>& component_of = searched(mesh, *number, components);
  TriangleMesh marked = mesh;  // the component as a part with that name
  marked.part_names = {"", part};
  marked.part.resize(mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) marked.part[t] = component_of[t] == *number;
  return formats::selectPart(marked, part);
}

std::size_t trianglesOf(const TriangleMesh& mesh, const std::string& part, const Components& components) {
  if (part.empty()) return mesh.triangles.size();
  if (const std::optional<std::uint32_t> number = componentNumber(mesh, part)) {
    const std::vector<std::uint32_t>& component_of = searched(mesh, *number, components);
    return static_cast<std::size_t>(std::count(component_of.begin(), component_of.end(), *number));
  }
  const auto name = std::find(mesh.part_names.begin(), mesh.part_names.end(), part);
  if (name == mesh.part_names.end()) return formats::selectPart(mesh, part).triangles.size();  // throws with the existing names
  const auto index = static_cast<std::uint32_t>(name - mesh.part_names.begin());
  return static_cast<std::size_t>(std::count(mesh.part.begin(), mesh.part.end(), index));
}

TriangleMesh choosePart(TriangleMesh mesh, const std::string& parts) { return parts == "merge" ? mesh : partOf(mesh, parts); }

}  // namespace spheretree::pipeline
