// SPDX-License-Identifier: Apache-2.0
// The common part of the mesh readers: collects vertices, polygons and parts from a file, and makes a welded
// TriangleMesh.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "spheretree/formats/mesh_content.h"

namespace spheretree::formats {

class MeshAssembly {
 public:
  /// @throws std::invalid_argument for a unit that is not finite or not positive.
  MeshAssembly(std::string name, double unit_mm);

  const std::string& name() const { return name_; }
  [[noreturn]] void refuse(const std::string& what) const;                        // "NAME: what"
  [[noreturn]] void refuseLine(std::size_t line, const std::string& what) const;  // "NAME: line 12: what"

  /// Reads one coordinate in the file's own unit, which may be NaN or infinite; `line` for messages.
  double number(std::string_view word, std::size_t line) const;
  /// Reads three coordinates from the front of `text`, the rest of line `line`, removes them and adds the vertex.
  void takeVertex(std::string_view& text, std::size_t line);
  /// Coordinates in the file's unit; `line` for messages, 0 for a file without lines. Returns false if one is not
  /// finite, before or after the conversion to millimetres; finish() refuses such a vertex if a triangle uses it.
  bool addVertex(double x, double y, double z, std::size_t line = 0);
  std::uint32_t vertexCount() const { return static_cast<std::uint32_t>(positions_.size()); }
  void reserve(std::size_t vertices, std::size_t triangles);
  /// Later faces belong to this part; an already used name continues that part.
  void beginPart(std::string_view part_name);
  /// Later faces have this colour; white before the first call.
  void setColour(const std::array<std::uint8_t, 3>& colour);
  const std::string& partName() const { return part_name_; }
  const std::vector<std::string>& partNames() const { return part_names_; }  // of the parts with a face, in their order
  /// Gives part i the name names[i]; parts of equal names become one.
  void renameParts(std::span<const std::string> names);
  /// Vertex indices must be below vertexCount() when finish() is called. Polygons with fewer than three corners are
  /// counted and ignored. Polygons are cut into triangles here, so their vertices must have been added before.
  void addPolygon(std::span<const std::uint32_t> corners) { addPolygon(corners, newFace()); }
  void addTriangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) { addTriangle(a, b, c, newFace()); }
  /// The index of the next face of the file, for polygons that can only be added later.
  std::uint32_t newFace() { return faces_++; }
  void addPolygon(std::span<const std::uint32_t> corners, std::uint32_t face);
  void note(std::string sentence) { notes_.push_back(std::move(sentence)); }

  /// @throws FormatError if there is no triangle.
  MeshFile finish(std::string format);

 private:
  static constexpr std::array<std::uint8_t, 3> kWhite{255, 255, 255};
  void addTriangle(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t face);

  std::string name_;
  double unit_mm_;
  std::vector<Eigen::Vector3d> positions_;
  std::vector<Triangle> triangles_;
  std::vector<std::uint32_t> part_, face_of_triangle_;
  std::uint32_t faces_ = 0;
  std::vector<std::string> part_names_;
  std::map<std::string, std::uint32_t, std::less<>> part_index_;
  std::vector<std::array<std::uint8_t, 3>> colours_;  // (triangles); empty before the first setColour()
  std::array<std::uint8_t, 3> colour_{kWhite};        // of the following faces
  std::string part_name_;                             // of the following faces
  std::uint32_t current_part_ = 0;
  bool part_entered_ = false;  // part_name_ has an entry in part_names_
  std::size_t cut_polygons_ = 0, short_faces_ = 0;
  struct BadVertex {
    std::uint32_t vertex;
    std::size_t line;
    std::array<double, 3> place;  // in the file's unit
  };
  void refuseUsed(const BadVertex& bad) const;

  std::vector<BadVertex> bad_vertices_;  // those that are not finite
  std::vector<std::string> notes_;
};

}  // namespace spheretree::formats
