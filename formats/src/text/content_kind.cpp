// SPDX-License-Identifier: Apache-2.0
#include "text/content_kind.h"

#include <algorithm>

#include "text/other_content.h"
#include "text/text_scan.h"

namespace spheretree::formats {

std::optional<MeshKind> meshKindOf(std::span<const char> bytes) {
  std::string_view start(bytes.data(), std::min<std::size_t>(bytes.size(), 65536));
  if (start.starts_with("glTF")) return MeshKind::Gltf;
  if (start.starts_with("\xef\xbb\xbf")) start.remove_prefix(3);
  if (start.starts_with("ply\n") || start.starts_with("ply\r")) return MeshKind::Ply;
  Lines lines(std::span<const char>(start.data(), start.size()));
  std::string_view line, rest;
  bool begins_solid = false;
  while (lines.next(line)) {
    if (line.find('\0') != std::string_view::npos) return std::nullopt;
    rest = line;
    const std::string_view word = takeWord(rest);
    if (word.empty() || word.starts_with('#')) continue;
    if (begins_solid) return word == "facet" || word == "endsolid" ? std::optional(MeshKind::Stl) : std::nullopt;
    if (word.starts_with('{')) return MeshKind::Gltf;
    if (const std::size_t off = word.find("OFF"); off <= 6 && word.find_first_not_of("STCN4n") == off) return MeshKind::Off;
    if (word == "solid")
      begins_solid = true;
    else if (word == "v" || word == "vn" || word == "vt" || word == "mtllib")
      return MeshKind::Obj;
    else if (word != "o" && word != "g" && word != "s" && word != "usemtl")
      return std::nullopt;
  }
  return std::nullopt;
}

bool hasSizeOfBinaryStl(std::span<const char> bytes) {
  if (bytes.size() < 84) return false;
  std::uint32_t triangles = 0;
  for (int i = 3; i >= 0; --i) triangles = triangles << 8 | static_cast<unsigned char>(bytes[80 + static_cast<std::size_t>(i)]);
  return bytes.size() == 84 + std::uint64_t{50} * triangles;
}

const char* nameOf(MeshKind kind) {
  switch (kind) {
    case MeshKind::Obj:
      return "OBJ";
    case MeshKind::Stl:
      return "STL";
    case MeshKind::Ply:
      return "PLY";
    case MeshKind::Off:
      return "OFF";
    case MeshKind::Gltf:
      break;
  }
  return "glTF";
}

std::string describedContent(std::string_view bytes) {
  if (bytes.empty()) return "empty";
  if (bytes.starts_with("\x89STREE")) return "a sphere-tree (.stree)";
  const std::span<const char> content(bytes.data(), bytes.size());
  const std::optional<MeshKind> kind = meshKindOf(content);
  if (kind && (*kind != MeshKind::Gltf || bytes.starts_with("glTF"))) return std::string("a mesh (") + nameOf(*kind) + ")";
  if (hasSizeOfBinaryStl(content)) return "a mesh (STL)";
  if (const std::optional<OtherContent> other = otherContentOf(content, "")) return other->what;
  const std::size_t first = bytes.find_first_not_of(" \t\r\n");
  if (first != std::string_view::npos && (bytes[first] == '{' || bytes[first] == '[')) return "JSON";
  const std::string_view line = bytes.substr(0, bytes.find('\n'));
  if (std::count(line.begin(), line.end(), ',') >= 6) return "a table (CSV)";
  return "";
}

}  // namespace spheretree::formats
