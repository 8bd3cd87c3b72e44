// SPDX-License-Identifier: Apache-2.0
#include "spheretree/formats/mesh_file.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <stdexcept>

#include "spheretree/core/mesh_edit.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/file_io.h"
#include "spheretree/formats/gltf.h"
#include "spheretree/formats/obj.h"
#include "spheretree/formats/off.h"
#include "spheretree/formats/path_name.h"
#include "spheretree/formats/ply.h"
#include "spheretree/formats/stl.h"
#include "text/content_kind.h"
#include "text/other_content.h"
#include "text/text_scan.h"

namespace spheretree::formats {
namespace {

using Kind = MeshKind;

std::optional<Kind> kindOfExtension(const std::filesystem::path& path) {
  std::string extension = toUtf8(path.extension());
  for (char& c : extension)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  if (extension == ".obj") return Kind::Obj;
  if (extension == ".stl") return Kind::Stl;
  if (extension == ".ply") return Kind::Ply;
  if (extension == ".off") return Kind::Off;
  if (extension == ".gltf" || extension == ".glb") return Kind::Gltf;
  return std::nullopt;
}

/// 3D Slicer and others write SPACE=LPS or SPACE=RAS into the header or the first comment.
std::string spaceOf(std::span<const char> bytes) {
  const std::string_view start(bytes.data(), std::min<std::size_t>(bytes.size(), 1024));
  for (const char* space : {"LPS", "RAS"})
    if (start.find(std::string("SPACE=") + space) != std::string_view::npos) return space;
  return {};
}

}  // namespace

MeshFile readMesh(const std::filesystem::path& path, double unit_mm, double gltf_unit_mm) {
  for (const double unit : {unit_mm, gltf_unit_mm})
    if (!(std::isfinite(unit) && unit > 0)) throw std::invalid_argument("the unit of a mesh must be a finite number of mm above 0");
  const std::string name = shownName(path);
  const std::vector<std::byte> file = readFile(path);
  const std::span<const char> bytes(reinterpret_cast<const char*>(file.data()), file.size());
  if (bytes.empty()) throw FormatError(name + ": is empty. Export the mesh again.");

  if (!hasSizeOfBinaryStl(bytes))
    if (const std::optional<OtherContent> other = otherContentOf(bytes, name))
      throw FormatError(name + ": is " + other->what + ". " + other->next);
  const std::optional<Kind> by_extension = kindOfExtension(path);
  std::optional<Kind> by_content = meshKindOf(bytes);
  if (!by_extension && !by_content && hasSizeOfBinaryStl(bytes)) by_content = Kind::Stl;
  if (!by_extension && !by_content) {
    const std::string kind = describedContent({bytes.data(), bytes.size()});
    throw FormatError(name + ": is " + (kind.empty() ? "of no supported format" : kind + ", not a mesh") +
                      ": .obj, .stl, .ply, .off, .gltf or .glb. Convert it to one of these; spheretree-import does so for 3DS, 3MF, "
                      "DAE, FBX and others.");
  }
  // A binary STL may begin with any text: its reader decides by the size.
  const Kind kind =
      by_extension == Kind::Stl && by_content != Kind::Ply && by_content != Kind::Gltf && by_content != Kind::Obj && by_content != Kind::Off
          ? Kind::Stl
          : by_content.value_or(by_extension.value_or(Kind::Obj));
  MeshFile result;
  switch (kind) {
    case Kind::Obj:
      result = readObj(bytes, name, unit_mm);
      break;
    case Kind::Stl:
      result = readStl(bytes, name, unit_mm);
      break;
    case Kind::Ply:
      result = readPly(bytes, name, unit_mm);
      break;
    case Kind::Off:
      result = readOff(bytes, name, unit_mm);
      break;
    case Kind::Gltf:
      result = readGltf(bytes, name, path.has_parent_path() ? path.parent_path() : std::filesystem::path("."), gltf_unit_mm);
      break;
  }
  result.space = spaceOf(bytes);
  if (by_extension && by_extension != kind)
    result.notes.push_back("Its name ends in " + inQuotes(toUtf8(path.extension())) + ", but it holds " + nameOf(kind) +
                           " and was read as such.");
  return result;
}

double unitInMm(std::string_view unit) {
  if (unit == "cm") return 10;
  if (unit == "m") return 1000;
  if (unit == "in") return 25.4;
  return 1;
}

TriangleMesh selectPart(const TriangleMesh& mesh, std::string_view name) {
  const auto found = std::find(mesh.part_names.begin(), mesh.part_names.end(), name);
  if (found == mesh.part_names.end()) {
    constexpr std::size_t kListed = 40;
    std::string known;
    for (std::size_t i = 0; i < std::min(mesh.part_names.size(), kListed); ++i) known += (i ? ", " : "") + inQuotes(mesh.part_names[i]);
    if (mesh.part_names.size() > kListed) known += " and " + std::to_string(mesh.part_names.size() - kListed) + " more";
    throw FormatError("the mesh has no part " + inQuotes(name) +
                      (known.empty() ? "; it has no named parts." : "; its parts are " + known + "."));
  }
  const auto wanted = static_cast<std::uint32_t>(found - mesh.part_names.begin());
  TriangleMesh result;
  result.positions = mesh.positions;
  result.part_names = {std::string(name)};
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    if (mesh.part[t] == wanted) result.triangles.push_back(mesh.triangles[t]);
  dropUnusedVertices(result);
  result.part.assign(result.triangles.size(), 0);
  return result;
}

}  // namespace spheretree::formats
