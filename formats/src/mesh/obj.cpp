// SPDX-License-Identifier: Apache-2.0
#include "spheretree/formats/obj.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <set>
#include <string_view>
#include <vector>

#include "mesh/mesh_assembly.h"
#include "text/text_encoding.h"
#include "text/text_scan.h"

namespace spheretree::formats {
namespace {

struct ForwardReference {  // to a vertex that has not been read yet
  std::int64_t number;
  std::size_t line, face;
};

class ObjReader {
 public:
  ObjReader(std::span<const char> text, const std::string& name, double unit_mm) : assembly_(name, unit_mm), lines_(text) {}

  MeshFile read() {
    std::string_view line;
    while (nextStatement(line)) {
      const std::string_view keyword = takeWord(line);
      if (keyword == "v")
        assembly_.takeVertex(line, line_);  // a weight or a colour may follow
      else if (keyword == "f" || keyword == "fo")
        readFace(line);
      else if (keyword == "o" || keyword == "g" || keyword == "usemtl")
        beginPart(keyword == "o" ? 0 : keyword == "g" ? 1 : 2, trimmed(line));
      else if (keyword == "curv" || keyword == "surf")
        ++free_forms_;
      else if (keyword.find('\0') != std::string_view::npos)
        assembly_.refuseLine(line_, "holds a zero byte: not an OBJ text. Export the mesh again.");
    }
    for (const ForwardReference& reference : forward_)
      if (reference.number > assembly_.vertexCount()) refuseIndex(reference);
    // Polygons wait for the vertices that they refer to.
    std::size_t from = 0;
    for (const Polygon& polygon : waiting_) {
      assembly_.beginPart(polygon.part);
      assembly_.addPolygon(std::span<const std::uint32_t>(waiting_corners_).subspan(from, polygon.corners), polygon.face);
      from += polygon.corners;
    }
    nameParts();
    if (free_forms_) assembly_.note(std::to_string(free_forms_) + " free-form curves or surfaces were left out; only polygons are read.");
    return assembly_.finish("OBJ");
  }

 private:
  struct Polygon {
    std::size_t corners;
    std::uint32_t face;
    std::string part;
  };

  using Division = std::array<std::string, 3>;  // the names of object, group and material

  void beginPart(std::size_t place, std::string_view name) {
    division_[place] = name;
    const auto [entry, is_new] = divisions_.try_emplace(division_, std::to_string(divisions_.size()));
    if (is_new) division_of_.emplace(entry->second, division_);
    assembly_.beginPart(entry->second);
  }

  /// A part is an object and a group; a material is one only in a file that is divided by nothing else. A part is named
  /// by its group, by its object if groups of several objects have the same name, or by both.
  void nameParts() {
    std::vector<Division> parts;
    for (const std::string& key : assembly_.partNames()) parts.push_back(key.empty() ? Division{} : division_of_.at(key));
    std::map<std::string, std::set<std::string>> groups_of, objects_of;
    for (const auto& [object, group, material] : parts) groups_of[object].insert(group), objects_of[group].insert(object);
    const auto isUnique = [](const auto& of) {
      return std::all_of(of.begin(), of.end(), [](const auto& entry) { return entry.second.size() == 1; });
    };
    const bool by_material = groups_of.size() == 1 && objects_of.size() == 1;
    std::vector<std::string> names;
    for (const auto& [object, group, material] : parts) {
      if (by_material)
        names.push_back(parts.size() > 1 ? material : group.empty() ? object : group);
      else if (group.empty() || object.empty())
        names.push_back(object + group);
      else
        names.push_back(isUnique(objects_of) ? group : isUnique(groups_of) ? object : object + "_" + group);
    }
    assembly_.renameParts(names);
  }

  /// One line, including lines that a backslash continues.
  bool nextStatement(std::string_view& line) {
    if (!lines_.next(line)) return false;
    line_ = lines_.number();
    if (line.starts_with('#')) line = {};  // even if it ends in the backslash of a Windows path
    if (!line.empty() && line.back() == '\\') {
      joined_.assign(line.substr(0, line.size() - 1));
      while (lines_.next(line)) {
        const bool goes_on = !line.empty() && line.back() == '\\';
        joined_ += ' ';
        joined_ += goes_on ? line.substr(0, line.size() - 1) : line;
        if (!goes_on) break;
      }
      line = joined_;
    }
    for (std::size_t at = line.find('#'); at != std::string_view::npos; at = line.find('#', at + 1)) {
      if (at > 0 && !isBlank(line[at - 1])) continue;  // part of a name
      line = line.substr(0, at);
      break;
    }
    return true;
  }

  void readFace(std::string_view line) {
    ++face_;
    corners_.clear();
    const std::int64_t count = assembly_.vertexCount();
    bool is_forward = false;
    for (std::string_view word = takeWord(line); !word.empty(); word = takeWord(line)) {
      std::int64_t number = 0;
      if (!parseInteger(word.substr(0, word.find('/')), number))
        assembly_.refuseLine(
            line_, faceName() + " has the corner " + inQuotes(word) + ", which names no vertex. A corner is written 7, 7/2 or 7/2/5.");
      if (number == 0)
        assembly_.refuseLine(
            line_, faceName() + " names vertex 0; OBJ counts vertices from 1. Export the mesh again with a program that writes valid OBJ.");
      if (number < -count)
        assembly_.refuseLine(line_, faceName() + " names vertex " + std::to_string(number) + " (counted backwards), but there are only " +
                                        std::to_string(count) + " vertices so far. Export the mesh again.");
      if (number < 0) number += count + 1;
      if (number > count) {
        const ForwardReference reference{number, line_, face_};
        if (number > std::int64_t{0xffffffff}) refuseIndex(reference);
        forward_.push_back(reference);
        is_forward = true;
      }
      corners_.push_back(static_cast<std::uint32_t>(number - 1));
    }
    if (!is_forward) return assembly_.addPolygon(corners_);
    waiting_.push_back({corners_.size(), assembly_.newFace(), assembly_.partName()});
    waiting_corners_.insert(waiting_corners_.end(), corners_.begin(), corners_.end());
  }

  std::string faceName() const { return "face " + std::to_string(face_); }

  [[noreturn]] void refuseIndex(const ForwardReference& reference) const {
    assembly_.refuseLine(reference.line, "face " + std::to_string(reference.face) + " names vertex " + std::to_string(reference.number) +
                                             ", but the file has " + std::to_string(assembly_.vertexCount()) +
                                             " vertices. The file is cut off or damaged: export the mesh again.");
  }

  MeshAssembly assembly_;
  Lines lines_;
  std::size_t line_ = 0, face_ = 0, free_forms_ = 0;  // face_: number of the current face, from 1
  std::string joined_;
  Division division_;                            // of the following faces
  std::map<Division, std::string> divisions_;    // the key of each as a part of `assembly_`
  std::map<std::string, Division> division_of_;  // the inverse
  std::vector<std::uint32_t> corners_;
  std::vector<ForwardReference> forward_;
  std::vector<Polygon> waiting_;
  std::vector<std::uint32_t> waiting_corners_;
};

}  // namespace

MeshFile readObj(std::span<const char> text, const std::string& name, double unit_mm) {
  return ObjReader(asText(text, name), name, unit_mm).read();
}

}  // namespace spheretree::formats
