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
#include "spheretree/formats/ply.h"
#include "spheretree/formats/stl.h"
#include "text_scan.h"

namespace spheretree::formats {
namespace {

enum class Kind { Obj, Stl, Ply, Off, Gltf };

std::optional<Kind> kindOfExtension(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  if (extension == ".obj") return Kind::Obj;
  if (extension == ".stl") return Kind::Stl;
  if (extension == ".ply") return Kind::Ply;
  if (extension == ".off") return Kind::Off;
  if (extension == ".gltf" || extension == ".glb") return Kind::Gltf;
  return std::nullopt;
}

/// What the content says without doubt; nothing for a binary STL.
std::optional<Kind> kindOfContent(std::span<const char> bytes) {
  std::string_view start(bytes.data(), std::min<std::size_t>(bytes.size(), 65536));
  if (start.starts_with("glTF")) return Kind::Gltf;
  if (start.starts_with("\xef\xbb\xbf")) start.remove_prefix(3);
  if (start.starts_with("ply\n") || start.starts_with("ply\r")) return Kind::Ply;
  Lines lines(std::span<const char>(start.data(), start.size()));
  std::string_view line, rest;
  bool begins_solid = false;
  while (lines.next(line)) {
    if (line.find('\0') != std::string_view::npos) return std::nullopt;
    rest = line;
    const std::string_view word = takeWord(rest);
    if (word.empty() || word.starts_with('#')) continue;
    if (begins_solid) return word == "facet" || word == "endsolid" ? std::optional(Kind::Stl) : std::nullopt;
    if (word.starts_with('{')) return Kind::Gltf;
    if (const std::size_t off = word.find("OFF"); off <= 4 && word.find_first_not_of("STCN4n") == off) return Kind::Off;
    if (word == "solid")
      begins_solid = true;
    else if (word == "v" || word == "vn" || word == "vt" || word == "mtllib")
      return Kind::Obj;
    else if (word != "o" && word != "g" && word != "s" && word != "usemtl")
      return std::nullopt;
  }
  return std::nullopt;
}

/// A binary STL has no mark, but says how many triangles follow: 80 bytes of anything, their number, 50 bytes each.
bool hasSizeOfBinaryStl(std::span<const char> bytes) {
  if (bytes.size() < 84) return false;
  std::uint32_t triangles = 0;
  for (int i = 3; i >= 0; --i) triangles = triangles << 8 | static_cast<unsigned char>(bytes[80 + static_cast<std::size_t>(i)]);
  return bytes.size() == 84 + std::uint64_t{50} * triangles;
}

const char* nameOf(Kind kind) {
  switch (kind) {
    case Kind::Obj:
      return "OBJ";
    case Kind::Stl:
      return "STL";
    case Kind::Ply:
      return "PLY";
    case Kind::Off:
      return "OFF";
    case Kind::Gltf:
      break;
  }
  return "glTF";
}

}  // namespace

MeshFile readMesh(const std::filesystem::path& path, double unit_mm) {
  if (!(std::isfinite(unit_mm) && unit_mm > 0)) throw std::invalid_argument("the unit of a mesh must be a finite number of mm above 0");
  const std::string name = shownName(path);
  const std::vector<std::byte> file = readFile(path);
  const std::span<const char> bytes(reinterpret_cast<const char*>(file.data()), file.size());
  if (bytes.empty()) throw FormatError(name + ": is empty. Export the mesh again.");

  const std::optional<Kind> by_extension = kindOfExtension(path);
  std::optional<Kind> by_content = kindOfContent(bytes);
  if (!by_extension && !by_content && hasSizeOfBinaryStl(bytes)) by_content = Kind::Stl;
  if (!by_extension && !by_content)
    throw FormatError(name + ": is of no format that is read here: .obj, .stl, .ply, .off, .gltf or .glb. Convert it to one of these.");
  // A binary STL may begin with any text: its reader tells by the size.
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
      result = readGltf(bytes, name, path.has_parent_path() ? path.parent_path() : std::filesystem::path("."));
      if (unit_mm != 1.0) result.notes.push_back("The unit given was not used: glTF is in metres.");
      break;
  }
  if (by_extension && by_extension != kind)
    result.notes.push_back("Its name ends in " + inQuotes(path.extension().string()) + ", but it holds " + nameOf(kind) +
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
