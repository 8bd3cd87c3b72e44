// SPDX-License-Identifier: Apache-2.0
#include "spheretree/formats/off.h"

#include <cstdint>
#include <string_view>
#include <vector>

#include "mesh_assembly.h"
#include "text_scan.h"

namespace spheretree::formats {
namespace {

/// The next line that is not blank and not a comment. False at the end.
bool nextRow(Lines& lines, std::string_view& row) {
  while (lines.next(row)) {
    row = trimmed(row.substr(0, row.find('#')));
    if (!row.empty()) return true;
  }
  return false;
}

struct Counts {
  std::uint64_t vertices, faces;
};

/// Reads the header and the counts, for which `assembly` reserves memory.
Counts readHeader(Lines& lines, MeshAssembly& assembly, std::size_t bytes) {
  std::string_view row;
  if (!nextRow(lines, row)) assembly.refuse("is empty. Export the mesh again.");

  // The keyword, [ST][C][N][4][n]OFF, may be missing, or on the same line as the counts.
  if (const std::size_t keyword = row.find("OFF"); keyword != std::string_view::npos) {
    const std::string_view prefix = row.substr(0, keyword);
    if (prefix.find_first_not_of("STCN4n") != std::string_view::npos)
      assembly.refuseLine(lines.number(), inQuotes(row) + " is no OFF header. Export the mesh again.");
    if (prefix.find_first_of("4n") != std::string_view::npos)
      assembly.refuseLine(lines.number(),
                          inQuotes(prefix) + "OFF has vertices of more than three coordinates. Export the mesh as plain OFF.");
    row = trimmed(row.substr(keyword + 3));
    if (row.starts_with("BINARY")) assembly.refuseLine(lines.number(), "binary OFF is not read. Export the mesh as text OFF, PLY or STL.");
    if (row.empty() && !nextRow(lines, row)) assembly.refuse("ends after its header. It is cut off: copy or export it again.");
  }
  std::int64_t counts[2];
  for (std::int64_t& count : counts) {
    const std::string_view word = takeWord(row);
    if (!parseInteger(word, count) || count < 0)
      assembly.refuseLine(lines.number(),
                          inQuotes(word) + " is not a count; here stand the numbers of vertices, faces and edges. Export the mesh again.");
  }
  const Counts out{static_cast<std::uint64_t>(counts[0]), static_cast<std::uint64_t>(counts[1])};
  // The shortest vertex is "0 0 0", the shortest face "0", each with a line end, which the last may lack.
  if (out.vertices > (lines.remaining() + 1) / 6 || out.faces > (lines.remaining() + 1) / 2)
    assembly.refuse("announces " + std::to_string(out.vertices) + " vertices and " + std::to_string(out.faces) + " faces, more than its " +
                    std::to_string(bytes) + " bytes can hold. It is cut off or damaged: copy or export it again.");
  assembly.reserve(out.vertices, out.faces);
  return out;
}

/// Reads the corners of a face; a colour may follow.
void readFace(std::string_view row, const std::string& name, std::uint64_t vertices, const Lines& lines, MeshAssembly& assembly,
              std::vector<std::uint32_t>& corners) {
  std::int64_t count = 0;
  if (const std::string_view word = takeWord(row); !parseInteger(word, count) || count < 0)
    assembly.refuseLine(lines.number(),
                        name + " begins with " + inQuotes(word) + " instead of its number of corners. Export the mesh again.");
  corners.clear();
  for (std::int64_t k = 0; k < count; ++k) {
    const std::string_view word = takeWord(row);
    std::int64_t index = 0;
    if (word.empty())
      assembly.refuseLine(lines.number(), name + " announces " + std::to_string(count) + " corners, but its line has " + std::to_string(k) +
                                              ". The file is cut off or damaged: copy or export it again.");
    if (!parseInteger(word, index) || index < 0 || static_cast<std::uint64_t>(index) >= vertices)
      assembly.refuseLine(lines.number(), name + " names vertex " + inQuotes(word) + "; valid are 0 to " +
                                              std::to_string(static_cast<std::int64_t>(vertices) - 1) + ". Export the mesh again.");
    corners.push_back(static_cast<std::uint32_t>(index));
  }
}

}  // namespace

MeshFile readOff(std::span<const char> text, const std::string& name, double unit_mm) {
  MeshAssembly assembly(name, unit_mm);
  Lines lines(asText(text, name));
  const Counts counts = readHeader(lines, assembly, text.size());
  std::string_view row;
  for (std::uint64_t vertex = 0; vertex < counts.vertices; ++vertex) {
    if (!nextRow(lines, row))
      assembly.refuse("ends after " + std::to_string(vertex) + " of " + std::to_string(counts.vertices) +
                      " vertices. It is cut off: copy or export it again.");
    assembly.takeVertex(row, lines.number());  // a normal, a colour or a texture coordinate may follow
  }
  std::vector<std::uint32_t> corners;
  for (std::uint64_t face = 0; face < counts.faces; ++face) {
    if (!nextRow(lines, row))
      assembly.refuse("ends after " + std::to_string(face) + " of " + std::to_string(counts.faces) +
                      " faces. It is cut off: copy or export it again.");
    readFace(row, "face " + std::to_string(face), counts.vertices, lines, assembly, corners);
    assembly.addPolygon(corners);
  }
  if (nextRow(lines, row)) assembly.note("Text after the last face (line " + std::to_string(lines.number()) + ") was ignored.");
  return assembly.finish("OFF");
}

}  // namespace spheretree::formats
