// SPDX-License-Identifier: Apache-2.0
#include "spheretree/formats/off.h"

#include <cstdint>
#include <exception>
#include <string_view>
#include <vector>

#include "mesh/mesh_assembly.h"
#include "spheretree/formats/errors.h"
#include "text/text_encoding.h"
#include "text/text_scan.h"

namespace spheretree::formats {
namespace {

/// Programs write each vertex and each face on a line of its own, where colours may follow. The format itself only
/// counts words, and some old programs break lines anywhere.
enum class Layout { Lines, Words };

class OffReader {
 public:
  OffReader(std::span<const char> text, const std::string& name, double unit_mm, Layout layout)
      : assembly_(name, unit_mm), lines_(text), layout_(layout) {}

  MeshFile read() {
    readHeader();
    for (std::uint64_t vertex = 0; vertex < vertices_; ++vertex) {
      beginRow("ends after " + std::to_string(vertex) + " of " + std::to_string(vertices_) + " vertices");
      double p[3];
      for (double& coordinate : p) {
        const std::string_view word = takeNext();
        if (word.empty())
          assembly_.refuseLine(lines_.number(),
                               "a vertex needs three coordinates on its line. The file is cut off or damaged: copy or export it again.");
        coordinate = assembly_.number(word, lines_.number());
      }
      assembly_.addVertex(p[0], p[1], p[2], lines_.number());
      if (layout_ == Layout::Words)
        for (std::size_t k = 0; k < words_after_vertex_; ++k) takeNext();  // on a line of its own, all that follows is skipped
    }
    for (std::uint64_t face = 0; face < faces_; ++face) readFace(face);
    const std::string_view beyond = layout_ == Layout::Words ? takeNext() : nextRow() ? row_ : std::string_view{};
    if (!beyond.empty()) {
      const std::string what = "Text after the last face (line " + std::to_string(lines_.number()) + ")";
      if (layout_ == Layout::Words) assembly_.refuse(what + " does not belong to the file. Export the mesh again.");
      assembly_.note(what + " was ignored.");
    }
    return assembly_.finish("OFF");
  }

 private:
  /// The next line that is not blank and not a comment. False at the end.
  bool nextRow() {
    while (lines_.next(row_)) {
      row_ = trimmed(row_.substr(0, row_.find('#')));
      if (!row_.empty()) return true;
    }
    row_ = {};
    return false;
  }

  void beginRow(const std::string& fault) {
    if (layout_ == Layout::Lines && !nextRow()) assembly_.refuse(fault + ". It is cut off: copy or export it again.");
  }

  /// The next word, of the line or of the file; empty at its end.
  std::string_view takeNext() {
    std::string_view word = takeWord(row_);
    while (word.empty() && layout_ == Layout::Words && nextRow()) word = takeWord(row_);
    return word;
  }

  /// Reads the header and the counts, for which it reserves memory.
  void readHeader() {
    if (!nextRow()) assembly_.refuse("is empty. Export the mesh again.");
    // The keyword, [ST][C][N][4][n]OFF, may be missing, or on the same line as the counts.
    if (const std::size_t keyword = row_.find("OFF"); keyword != std::string_view::npos) {
      const std::string_view prefix = row_.substr(0, keyword);
      if (prefix.find_first_not_of("STCN4n") != std::string_view::npos)
        assembly_.refuseLine(lines_.number(), inQuotes(row_) + " is no OFF header. Export the mesh again.");
      if (prefix.find_first_of("4n") != std::string_view::npos)
        assembly_.refuseLine(lines_.number(),
                             inQuotes(prefix) + "OFF has vertices of more than three coordinates. Export the mesh as plain OFF.");
      const auto isOf = [&](const char* letter) { return prefix.find(letter) != std::string_view::npos; };
      words_after_vertex_ = (isOf("N") ? 3 : 0) + (isOf("C") ? 4 : 0) + (isOf("ST") ? 2 : 0);
      row_ = trimmed(row_.substr(keyword + 3));
      if (row_.starts_with("BINARY"))
        assembly_.refuseLine(lines_.number(), "binary OFF is not read. Export the mesh as text OFF, PLY or STL.");
      if (row_.empty() && !nextRow()) assembly_.refuse("ends after its header. It is cut off: copy or export it again.");
    }
    for (std::uint64_t* count : {&vertices_, &faces_}) {
      const std::string_view word = takeNext();
      std::int64_t number = 0;
      if (!parseInteger(word, number) || number < 0)
        assembly_.refuseLine(
            lines_.number(),
            inQuotes(word) + " is not a count; here stand the numbers of vertices, faces and edges. Export the mesh again.");
      *count = static_cast<std::uint64_t>(number);
    }
    if (layout_ == Layout::Words) takeNext();  // the number of edges
    // The shortest vertex is "0 0 0", the shortest face "0", each with a separator, which the last may lack.
    const std::size_t remaining = lines_.remaining() + row_.size() + 1;
    if (vertices_ > remaining / 6 || faces_ > remaining / 2)
      assembly_.refuse("announces " + std::to_string(vertices_) + " vertices and " + std::to_string(faces_) +
                       " faces, more than its bytes can hold. It is cut off or damaged: copy or export it again.");
    assembly_.reserve(vertices_, faces_);
  }

  /// Reads the corners of a face; on a line of its own, a colour may follow.
  void readFace(std::uint64_t face) {
    beginRow("ends after " + std::to_string(face) + " of " + std::to_string(faces_) + " faces");
    const std::string name = "face " + std::to_string(face);
    std::int64_t count = 0;
    if (const std::string_view word = takeNext(); !parseInteger(word, count) || count < 0)
      assembly_.refuseLine(lines_.number(),
                           name + " begins with " + inQuotes(word) + " instead of its number of corners. Export the mesh again.");
    corners_.clear();
    for (std::int64_t k = 0; k < count; ++k) {
      const std::string_view word = takeNext();
      std::int64_t index = 0;
      if (word.empty())
        assembly_.refuseLine(lines_.number(), name + " announces " + std::to_string(count) + " corners, but its line has " +
                                                  std::to_string(k) + ". The file is cut off or damaged: copy or export it again.");
      if (!parseInteger(word, index) || index < 0 || static_cast<std::uint64_t>(index) >= vertices_)
        assembly_.refuseLine(lines_.number(), name + " names vertex " + inQuotes(word) + "; valid are 0 to " +
                                                  std::to_string(static_cast<std::int64_t>(vertices_) - 1) + ". Export the mesh again.");
      corners_.push_back(static_cast<std::uint32_t>(index));
    }
    assembly_.addPolygon(corners_);
  }

  MeshAssembly assembly_;
  Lines lines_;
  Layout layout_;
  std::string_view row_;  // the rest of the current line
  std::uint64_t vertices_ = 0, faces_ = 0;
  std::size_t words_after_vertex_ = 0;
  std::vector<std::uint32_t> corners_;
};

}  // namespace

MeshFile readOff(std::span<const char> text, const std::string& name, double unit_mm) {
  const std::span<const char> content = asText(text, name);
  try {
    return OffReader(content, name, unit_mm, Layout::Lines).read();
  } catch (const FormatError&) {
    const std::exception_ptr first = std::current_exception();
    try {
      return OffReader(content, name, unit_mm, Layout::Words).read();
    } catch (const FormatError&) {
      std::rethrow_exception(first);  // names the line that differs from the usual layout
    }
  }
}

}  // namespace spheretree::formats
