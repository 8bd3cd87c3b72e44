// SPDX-License-Identifier: Apache-2.0
#include "spheretree/formats/stl.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <string_view>

#include "little_endian.h"
#include "mesh_assembly.h"
#include "text_scan.h"

namespace spheretree::formats {
namespace {

constexpr std::size_t kHeaderBytes = 84;  // 80 arbitrary bytes, then the number of facets
constexpr std::size_t kFacetBytes = 50;   // normal and three corners as float32, then 16 bits of attributes

char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

bool isWord(std::string_view word, std::string_view keyword) {
  return std::equal(word.begin(), word.end(), keyword.begin(), keyword.end(), [](char a, char b) { return lower(a) == b; });
}

/// Text that begins with "solid", followed by a line end and a keyword of an ASCII file near the beginning.
bool looksAscii(std::span<const char> bytes) {
  const std::string_view start(bytes.data(), std::min<std::size_t>(bytes.size(), 4096));
  Lines lines(std::span<const char>(start.data(), start.size()));
  std::string_view line;
  bool first = true;
  while (lines.next(line)) {
    if (line.find('\0') != std::string_view::npos) return false;
    std::string_view rest = line;
    const std::string_view word = takeWord(rest);
    if (word.empty()) continue;
    if (first && !isWord(word, "solid")) return false;
    if (!first && (isWord(word, "facet") || isWord(word, "endsolid") || isWord(word, "solid"))) return true;
    first = false;
  }
  return !first && bytes.size() < kHeaderBytes;  // not longer than the first line
}

MeshFile readBinary(std::span<const char> bytes, MeshAssembly& assembly) {
  if (bytes.size() < kHeaderBytes)
    assembly.refuse(
        "has " + std::to_string(bytes.size()) +
        " bytes: neither an ASCII STL (it does not begin with \"solid\") nor a binary one (at least 84 bytes). Export the mesh again.");
  const std::uint32_t announced = littleUint32(bytes.data() + 80);
  const std::size_t room = (bytes.size() - kHeaderBytes) / kFacetBytes, spare = (bytes.size() - kHeaderBytes) % kFacetBytes;
  std::size_t count = announced;
  if (announced > room && spare != 0)
    assembly.refuse("ends in the middle of facet " + std::to_string(room + 1) + " of " + std::to_string(announced) +
                    ". The file is cut off: copy or export it again.");
  if (announced != room && spare == 0) {  // the rest is whole facets: the size is right, the header is wrong
    assembly.note("The header announces " + std::to_string(announced) + " facets, the file holds " + std::to_string(room) + "; all " +
                  std::to_string(room) + " were read.");
    count = room;
  } else if (bytes.size() > kHeaderBytes + count * kFacetBytes) {
    assembly.note(std::to_string(bytes.size() - kHeaderBytes - count * kFacetBytes) + " bytes after the last facet were ignored.");
  }
  assembly.reserve(count * 3, count);
  for (std::size_t facet = 0; facet < count; ++facet) {
    const char* at = bytes.data() + kHeaderBytes + facet * kFacetBytes + 12;  // after the normal
    for (int corner = 0; corner < 3; ++corner, at += 12) {
      std::array<double, 3> p;
      for (std::size_t axis = 0; axis < 3; ++axis) p[axis] = std::bit_cast<float>(littleUint32(at + 4 * axis));
      if (!assembly.addVertex(p[0], p[1], p[2]))
        assembly.refuse("facet " + std::to_string(facet + 1) + ", corner " + std::to_string(corner + 1) + ": (" + std::to_string(p[0]) +
                        ", " + std::to_string(p[1]) + ", " + std::to_string(p[2]) + ") is not a finite point. Export the mesh again.");
    }
    const std::uint32_t last = assembly.vertexCount();
    assembly.addTriangle(last - 3, last - 2, last - 1);
  }
  return assembly.finish("STL (binary)");
}

MeshFile readAscii(std::span<const char> bytes, MeshAssembly& assembly) {
  Lines lines(bytes);
  std::string_view line;
  std::size_t facet = 0, facet_line = 0, corners = 0;
  bool in_facet = false, in_solid = false, ended = true;
  const auto facetName = [&] { return "facet " + std::to_string(facet); };
  while (lines.next(line)) {
    for (std::string_view word = takeWord(line); !word.empty(); word = takeWord(line)) {
      if (in_facet && (isWord(word, "facet") || isWord(word, "solid") || isWord(word, "endsolid")))
        assembly.refuseLine(lines.number(),
                            facetName() + " (line " + std::to_string(facet_line) + ") has no endfacet. Export the mesh again.");
      if (isWord(word, "vertex")) {
        if (!in_facet) assembly.refuseLine(lines.number(), "a vertex outside a facet. Export the mesh again.");
        if (++corners > 3)
          assembly.refuseLine(
              lines.number(),
              facetName() + " has more than three vertices; a facet of an STL file is a triangle. Export the mesh as triangles.");
        assembly.takeVertex(line, lines.number());
      } else if (isWord(word, "facet")) {
        if (!in_solid) assembly.refuseLine(lines.number(), "a facet outside a solid. Export the mesh again.");
        ++facet;
        facet_line = lines.number();
        in_facet = true;
        corners = 0;
        line = {};  // ignores the normal, since the winding determines it better
      } else if (isWord(word, "endfacet")) {
        if (!in_facet) assembly.refuseLine(lines.number(), "endfacet without a facet. Export the mesh again.");
        if (corners != 3)
          assembly.refuseLine(lines.number(),
                              facetName() + " has " + std::to_string(corners) + " vertices instead of three. Export the mesh again.");
        const std::uint32_t last = assembly.vertexCount();
        assembly.addTriangle(last - 3, last - 2, last - 1);
        in_facet = false;
      } else if (isWord(word, "solid")) {
        assembly.beginPart(trimmed(line));
        line = {};
        in_solid = true;
        ended = false;
      } else if (isWord(word, "endsolid")) {
        line = {};
        in_solid = false;
        ended = true;
      } else if (!in_facet || !(isWord(word, "outer") || isWord(word, "loop") || isWord(word, "endloop"))) {
        assembly.refuseLine(lines.number(), inQuotes(word) + " is no word of an STL file here. Export the mesh again.");
      }
    }
  }
  if (in_facet) assembly.refuseLine(lines.number(), "the file ends within " + facetName() + ". It is cut off: copy or export it again.");
  if (!ended) assembly.note("The last solid has no endsolid; the file may be cut off.");
  return assembly.finish("STL (ASCII)");
}

}  // namespace

MeshFile readStl(std::span<const char> bytes, const std::string& name, double unit_mm) {
  MeshAssembly assembly(name, unit_mm);
  if (bytes.empty()) assembly.refuse("is empty. Export the mesh again.");
  const bool sized_as_binary =
      bytes.size() >= kHeaderBytes && bytes.size() == kHeaderBytes + std::uint64_t{littleUint32(bytes.data() + 80)} * kFacetBytes;
  if (sized_as_binary) return readBinary(bytes, assembly);
  if (bytes.size() >= 2 && static_cast<unsigned char>(bytes[0]) >= 0xef) {
    const std::span<const char> text = asText(bytes, name);
    if (looksAscii(text)) return readAscii(text, assembly);
  }
  return looksAscii(bytes) ? readAscii(bytes, assembly) : readBinary(bytes, assembly);
}

}  // namespace spheretree::formats
