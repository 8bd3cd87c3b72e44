// SPDX-License-Identifier: Apache-2.0
#include "spheretree/formats/marked_glb.h"

#include <Eigen/Dense>
#include <algorithm>
#include <limits>

#include "gltf/glb_writer.h"

namespace spheretree::formats {
namespace {

constexpr double kMarkSize = 0.004;  // radius of an octahedron, as a share of the diagonal
constexpr std::size_t kPlain = 0;    // the group of unmarked triangles

using Corners = std::array<Eigen::Vector3d, 3>;

/// Flat shaded: each triangle has corners and a normal of its own.
void add(GlbWriter& glb, std::vector<int>& nodes, const std::string& name, const std::array<double, 3>& colour,
         const std::vector<Corners>& triangles) {
  if (triangles.empty()) return;
  GlbWriter::Part part{
      .name = name, .colour = colour, .roughness = 0.7, .is_double_sided = true, .positions = {}, .normals = {}, .triangles = {}};
  for (const Corners& c : triangles) {
    part.positions.insert(part.positions.end(), c.begin(), c.end());
    const Eigen::Vector3d n = (c[1] - c[0]).cross(c[2] - c[0]).stableNormalized();
    part.normals.insert(part.normals.end(), 3, std::abs(n.norm() - 1) < 1e-6 ? n : Eigen::Vector3d::UnitZ());
  }
  nodes.push_back(glb.add(part));
}

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
  GlbWriter glb;
  std::vector<int> nodes;
  add(glb, nodes, "mesh", {0.72, 0.72, 0.70}, triangles[kPlain]);
  for (std::size_t m = 0; m < marks.size(); ++m) {
    for (std::size_t i = 0; i < std::min(marks[m].points.size(), kMaxMarkedPoints); ++i)
      if (marks[m].points[i].allFinite()) addOctahedron(marks[m].points[i], radius, triangles[m + 1]);
    add(glb, nodes, marks[m].name, marks[m].colour, triangles[m + 1]);
  }
  glb.addScene("", nodes);
  return glb.finish();
}

}  // namespace spheretree::formats
