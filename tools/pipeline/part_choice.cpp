// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/part_choice.h"

#include <algorithm>
#include <charconv>

#include "spheretree/builder/mesh_checks.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/mesh_file.h"

namespace spheretree::pipeline {

TriangleMesh choosePart(TriangleMesh mesh, const std::string& parts) {
  if (parts == "merge") return mesh;
  const bool is_name = std::find(mesh.part_names.begin(), mesh.part_names.end(), parts) != mesh.part_names.end();
  std::uint32_t number = 0;
  const auto [end, error] = std::from_chars(parts.data() + std::min<std::size_t>(1, parts.size()), parts.data() + parts.size(), number);
  const bool is_number = parts.size() > 1 && parts[0] == '#' && error == std::errc() && end == parts.data() + parts.size();
  if (is_name || !is_number) return formats::selectPart(mesh, parts);

  // The component as a part of that name.
  const builder::MeshReport report = builder::checkMesh(mesh);
  if (number >= report.components.size())
    throw formats::FormatError("the mesh has no component " + parts + "; it has " + std::to_string(report.components.size()) +
                               ", which are counted from #0.");
  mesh.part_names = {"", parts};
  mesh.part.resize(mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) mesh.part[t] = report.component_of[t] == number;
  return formats::selectPart(mesh, parts);
}

}  // namespace spheretree::pipeline
