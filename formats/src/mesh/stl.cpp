// SPDX-License-Identifier: Apache-2.0
#include "spheretree/formats/stl.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <optional>
#include <string_view>
#include <vector>

#include "mesh/mesh_assembly.h"
#include "text/little_endian.h"
#include "text/text_encoding.h"
#include "text/text_scan.h"

namespace spheretree::formats {
namespace {

constexpr std::size_t kHeaderBytes = 84;  // 80 arbitrary bytes, then the number of facets
constexpr std::size_t kFacetBytes = 50;   // normal and three corners as float32, then 16 bits of attributes

char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

bool isWord(std::string_view word, std::string_view keyword) {
  return std::equal(word.begin(), word.end(), keyword.begin(), keyword.end(), [](char a, char b) { return lower(a) == b; });
}

/// Text that begins with "solid" and goes on as an ASCII file does, in its first 4096 bytes.
bool looksAscii(std::span<const char> bytes) {
  const std::string_view start(bytes.data(), std::min<std::size_t>(bytes.size(), 4096));
  Lines lines(std::span<const char>(start.data(), start.size()));
  std::string_view line;
  bool first = true;
  while (lines.next(line)) {
    if (line.find('\0') != std::string_view::npos) return false;
    for (std::string_view word = takeWord(line); !word.empty(); word = takeWord(line)) {
      if (first && !isWord(word, "solid")) return false;
      if (!first && (isWord(word, "facet") || isWord(word, "endsolid") || isWord(word, "solid"))) return true;
      first = false;
    }
  }
  return !first && bytes.size() < kHeaderBytes;  // not longer than the first line
}

/// Where the facets of a binary file begin, each with its 50 bytes.
struct Facets {
  std::vector<std::size_t> at;
  std::string note;
};

/// Facets that are followed by as many bytes as their attribute says, or by `bytes_each`. Empty if the last one does
/// not end where the file does.
Facets facetsAlong(std::span<const char> bytes, std::size_t count, std::optional<std::size_t> bytes_each) {
  Facets out;
  std::size_t at = kHeaderBytes;
  for (std::size_t facet = 0; facet < count; ++facet) {
    if (bytes.size() - at < kFacetBytes) return {};
    out.at.push_back(at);
    const auto* attribute = reinterpret_cast<const unsigned char*>(bytes.data() + at + kFacetBytes - 2);
    const std::size_t more = bytes_each ? *bytes_each : attribute[0] + std::size_t{256} * attribute[1];
    if (bytes.size() - at - kFacetBytes < more) return {};
    at += kFacetBytes + more;
  }
  if (at != bytes.size()) return {};
  return out;
}

/// Whether more than half of these facets can be facets: finite, not all corners at one place, and the normal as long
/// as one, or zero.
bool areLikely(std::span<const char> bytes, const std::vector<std::size_t>& facets) {
  std::size_t likely = 0;
  for (const std::size_t at : facets) {
    std::array<double, 12> v;
    for (std::size_t k = 0; k < v.size(); ++k) v[k] = std::bit_cast<float>(littleUint32(bytes.data() + at + 4 * k));
    const bool finite = std::all_of(v.begin(), v.end(), [](double x) { return std::isfinite(x); });
    const double normal = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    const bool is_point =
        std::equal(v.begin() + 3, v.begin() + 6, v.begin() + 6) && std::equal(v.begin() + 3, v.begin() + 6, v.begin() + 9);
    likely += finite && !is_point && (normal == 0 || std::abs(normal - 1) < 0.1);
  }
  return 2 * likely > facets.size();
}

std::vector<std::size_t> tightFacets(std::size_t count) {
  std::vector<std::size_t> at(count);
  for (std::size_t facet = 0; facet < count; ++facet) at[facet] = kHeaderBytes + facet * kFacetBytes;
  return at;
}

/// Many programs write binary files that are not as the format says. An arrangement is taken if its last facet ends
/// where the file does; if nothing but the size speaks for it, its facets must be likely, too.
Facets findFacets(std::span<const char> bytes, const MeshAssembly& assembly) {
  const std::size_t announced = littleUint32(bytes.data() + 80), body = bytes.size() - kHeaderBytes;
  const std::size_t room = body / kFacetBytes, spare = body % kFacetBytes;
  const std::string count = std::to_string(announced);
  if (announced == room && spare == 0) return {tightFacets(room), ""};
  if (announced > 0 && announced <= room) {
    if (Facets found = facetsAlong(bytes, announced, std::nullopt); !found.at.empty()) {
      found.note = "The attributes after each facet, " + std::to_string(body - announced * kFacetBytes) + " bytes in all, were left out.";
      return found;
    }
    const std::size_t bytes_each = body / announced - kFacetBytes;
    if (Facets found = facetsAlong(bytes, announced, bytes_each); !found.at.empty() && areLikely(bytes, found.at)) {
      found.note = std::to_string(bytes_each) + " bytes after each facet were left out.";
      return found;
    }
  }
  if (spare == 0 && room > 0) {  // whole facets: the header is wrong, if they are facets
    std::vector<std::size_t> all = tightFacets(room);
    const std::vector<std::size_t> unannounced(all.begin() + static_cast<std::ptrdiff_t>(announced < room ? announced : 0), all.end());
    if (areLikely(bytes, unannounced))
      return {std::move(all), "The header announces " + count + " facets, the file holds " + std::to_string(room) + "; all " +
                                  std::to_string(room) + " were read."};
  }
  if (announced > room)
    assembly.refuse("ends in the middle of facet " + std::to_string(room + 1) + " of " + count +
                    ". The file is cut off: copy or export it again.");
  std::vector<std::size_t> all = tightFacets(announced);
  const std::size_t after = body - announced * kFacetBytes;
  if (announced > 0 && !areLikely(bytes, all))
    assembly.refuse("announces " + count + " facets and has " + std::to_string(after) +
                    " more bytes than these need, in an order that is not known. Export it again as a plain binary STL.");
  return {std::move(all), std::to_string(after) + " bytes after the last facet were ignored."};
}

MeshFile readBinary(std::span<const char> bytes, MeshAssembly& assembly) {
  if (bytes.size() < kHeaderBytes)
    assembly.refuse(
        "has " + std::to_string(bytes.size()) +
        " bytes: neither an ASCII STL (it does not begin with \"solid\") nor a binary one (at least 84 bytes). Export the mesh again.");
  const Facets facets = findFacets(bytes, assembly);
  if (!facets.note.empty()) assembly.note(facets.note);
  assembly.reserve(facets.at.size() * 3, facets.at.size());
  for (std::size_t facet = 0; facet < facets.at.size(); ++facet) {
    const char* at = bytes.data() + facets.at[facet] + 12;  // after the normal
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

/// The next word; "end" and the word after it are one, as some old programs wrote "end loop".
std::string_view takeKeyword(std::string_view& line) {
  const std::string_view word = takeWord(line);
  if (!isWord(word, "end")) return word;
  const std::string_view what = takeWord(line);
  return isWord(what, "loop") ? "endloop" : isWord(what, "facet") ? "endfacet" : isWord(what, "solid") ? "endsolid" : word;
}

/// Removes the words before the first of `keywords` from the front of `line` and returns them.
std::string_view skipTo(std::string_view& line, std::initializer_list<std::string_view> keywords) {
  const std::string_view whole = line;
  for (std::string_view rest = line; !rest.empty(); line = rest) {
    const std::string_view word = takeKeyword(rest);
    if (std::any_of(keywords.begin(), keywords.end(), [&](std::string_view keyword) { return isWord(word, keyword); })) break;
  }
  return whole.substr(0, whole.size() - line.size());
}

MeshFile readAscii(std::span<const char> bytes, MeshAssembly& assembly) {
  Lines lines(bytes);
  std::string_view line;
  std::size_t facet = 0, facet_line = 0, corners = 0;
  bool in_facet = false, in_solid = false, ended = true;
  const auto facetName = [&] { return "facet " + std::to_string(facet); };
  while (lines.next(line)) {
    for (std::string_view word = takeKeyword(line); !word.empty(); word = takeKeyword(line)) {
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
        skipTo(line, {"outer", "vertex", "endfacet"});  // ignores the normal, since the winding determines it better
      } else if (isWord(word, "endfacet")) {
        if (!in_facet) assembly.refuseLine(lines.number(), "endfacet without a facet. Export the mesh again.");
        if (corners != 3)
          assembly.refuseLine(lines.number(),
                              facetName() + " has " + std::to_string(corners) + " vertices instead of three. Export the mesh again.");
        const std::uint32_t last = assembly.vertexCount();
        assembly.addTriangle(last - 3, last - 2, last - 1);
        in_facet = false;
      } else if (isWord(word, "solid")) {
        assembly.beginPart(trimmed(skipTo(line, {"facet", "endsolid"})));
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
