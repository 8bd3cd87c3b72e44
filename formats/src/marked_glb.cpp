// SPDX-License-Identifier: Apache-2.0
#include "spheretree/formats/marked_glb.h"

#include <Eigen/Dense>
#include <algorithm>
#include <limits>

#include "glb_writer.h"

namespace spheretree::formats {
namespace {

constexpr double kMarkSize = 0.004;  // radius of an octahedron, of the diagonal
constexpr std::size_t kPlain = 0;    // the group of triangles without a mark

using Corners = std::array<Eigen::Vector3d, 3>;

class MarkedGlb {
 public:
  MarkedGlb() {
    document_["asset"] = {{"version", "2.0"}, {"generator", "spheretree"}};
    document_["scene"] = 0;
    document_["scenes"] = Json::array({{{"nodes", Json::array()}}});
  }

  /// Flat shaded: each triangle has its own corners and normal.
  void add(const std::string& name, const std::array<double, 3>& colour, const std::vector<Corners>& triangles) {
    if (triangles.empty()) return;
    const std::size_t positions_at = buffer_.size();
    std::array<float, 3> low, high;
    low.fill(std::numeric_limits<float>::infinity());
    high.fill(-std::numeric_limits<float>::infinity());
    for (const Corners& corners : triangles)
      for (const Eigen::Vector3d& p : corners) {
        const Eigen::Vector3f q = (p * kMetre).cast<float>();
        for (std::size_t axis = 0; axis < 3; ++axis) {
          const float x = q[static_cast<Eigen::Index>(axis)];
          low[axis] = std::min(low[axis], x), high[axis] = std::max(high[axis], x);
        }
        append(buffer_, std::array<float, 3>{q.x(), q.y(), q.z()});
      }
    const std::size_t normals_at = buffer_.size();
    for (const Corners& c : triangles) {
      const Eigen::Vector3d n = (c[1] - c[0]).cross(c[2] - c[0]).stableNormalized();
      const bool is_unit = std::abs(n.norm() - 1) < 1e-6;
      const Eigen::Vector3f f = (is_unit ? n : Eigen::Vector3d::UnitZ()).cast<float>();
      for (int k = 0; k < 3; ++k) append(buffer_, std::array<float, 3>{f.x(), f.y(), f.z()});
    }
    const std::size_t positions = addAccessor(document_, positions_at, normals_at, kArrayBuffer, kFloat, 3 * triangles.size(), "VEC3");
    document_["accessors"][positions]["min"] = low;
    document_["accessors"][positions]["max"] = high;
    const std::size_t normals = addAccessor(document_, normals_at, buffer_.size(), kArrayBuffer, kFloat, 3 * triangles.size(), "VEC3");
    Json primitive;
    primitive["attributes"] = {{"POSITION", positions}, {"NORMAL", normals}};
    primitive["material"] = count_;
    document_["materials"].push_back(
        {{"name", name},
         {"doubleSided", true},
         {"pbrMetallicRoughness",
          {{"baseColorFactor", {colour[0], colour[1], colour[2], 1.0}}, {"metallicFactor", 0.0}, {"roughnessFactor", 0.7}}}});
    document_["meshes"].push_back({{"name", name}, {"primitives", Json::array({primitive})}});
    document_["nodes"].push_back({{"name", name}, {"mesh", count_}});
    document_["scenes"][0]["nodes"].push_back(count_);
    ++count_;
  }

  std::vector<std::byte> finish() { return packGlb(document_, buffer_); }

 private:
  Json document_;
  std::vector<std::byte> buffer_;
  std::size_t count_ = 0;
};

void addOctahedron(const Eigen::Vector3d& at, double radius, std::vector<Corners>& triangles) {
  for (int octant = 0; octant < 8; ++octant) {
    const double x = octant & 1 ? -radius : radius, y = octant & 2 ? -radius : radius, z = octant & 4 ? -radius : radius;
    Corners c{at + Eigen::Vector3d(x, 0, 0), at + Eigen::Vector3d(0, y, 0), at + Eigen::Vector3d(0, 0, z)};
    if ((x > 0) != ((y > 0) == (z > 0))) std::swap(c[1], c[2]);
    triangles.push_back(c);
  }
}

}  // namespace

std::vector<std::byte> encodeMarkedGlb(const TriangleMesh& mesh, std::span<const Marks> marks) {
  const auto isWhole = [&](const Triangle& t) {
    return std::all_of(t.begin(), t.end(), [&](std::uint32_t v) { return v < mesh.positions.size() && mesh.positions[v].allFinite(); });
  };
  std::vector<std::size_t> group(mesh.triangles.size(), kPlain);
  for (std::size_t m = marks.size(); m-- > 0;)
    for (const std::uint32_t t : marks[m].triangles) group.at(t) = m + 1;
  std::vector<std::vector<Corners>> triangles(marks.size() + 1);
  Eigen::AlignedBox3d box;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (!isWhole(mesh.triangles[t])) continue;
    const Corners corners{mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2)};
    for (const Eigen::Vector3d& p : corners) box.extend(p);
    triangles[group[t]].push_back(corners);
  }
  const double radius = box.isEmpty() ? 1 : kMarkSize * box.diagonal().norm();
  MarkedGlb glb;
  glb.add("mesh", {0.72, 0.72, 0.70}, triangles[kPlain]);
  for (std::size_t m = 0; m < marks.size(); ++m) {
    for (std::size_t i = 0; i < std::min(marks[m].points.size(), kMostMarkedPoints); ++i)
      if (marks[m].points[i].allFinite()) addOctahedron(marks[m].points[i], radius, triangles[m + 1]);
    glb.add(marks[m].name, marks[m].colour, triangles[m + 1]);
  }
  return glb.finish();
}

}  // namespace spheretree::formats
