// SPDX-License-Identifier: Apache-2.0
#include "spheretree/formats/tree_glb.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <utility>

#include "glb_writer.h"

namespace spheretree::formats {
namespace {

struct Icosphere {
  std::vector<Eigen::Vector3d> points;  // unit
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

Icosphere makeIcosphere(int subdivisions) {
  const double g = (1 + std::sqrt(5.0)) / 2;
  Icosphere s;
  s.points = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
              {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  for (Eigen::Vector3d& p : s.points) p.normalize();
  s.triangles = {{0, 11, 5}, {0, 5, 1}, {0, 1, 7}, {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                 {3, 9, 4},  {3, 4, 2}, {3, 2, 6}, {3, 6, 8},  {3, 8, 9},   {4, 9, 5}, {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
  for (int i = 0; i < subdivisions; ++i) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middle_of;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [found, is_new] = middle_of.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(s.points.size()));
      if (is_new) s.points.push_back((s.points[a] + s.points[b]).normalized());
      return found->second;
    };
    std::vector<std::array<std::uint32_t, 3>> finer;
    for (const auto& [a, b, c] : s.triangles) {
      const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    s.triangles = std::move(finer);
  }
  return s;
}

}  // namespace

std::vector<std::byte> encodeGlb(const SphereTree& tree, SphereKind kind) {
  constexpr double kMetre = 0.001;  // [m/mm]
  constexpr std::array<std::array<double, 3>, kMaxLevels> kColours{
      {{0.60, 0.60, 0.60}, {0.85, 0.37, 0.10}, {0.90, 0.67, 0.12}, {0.20, 0.60, 0.35}, {0.15, 0.45, 0.75}, {0.50, 0.30, 0.65}}};

  Json document;
  document["asset"] = {{"version", "2.0"}, {"generator", "spheretree"}};
  document["scene"] = 0;
  document["scenes"] = Json::array({{{"nodes", {0}}}});
  document["nodes"] = Json::array({{{"name", "sphere_tree"}}});
  std::vector<std::byte> buffer;
  for (int level = 0; level < tree.levelCount(); ++level) {
    const std::vector<std::uint32_t> nodes = levelSet(tree, level);
    const Icosphere shape = makeIcosphere(nodes.size() <= 64 ? 3 : nodes.size() <= 1024 ? 2 : 1);
    const std::string name = "level_" + std::to_string(level);

    const std::size_t positions_at = buffer.size();
    std::array<float, 3> low, high;
    low.fill(std::numeric_limits<float>::infinity());
    high.fill(-std::numeric_limits<float>::infinity());
    for (const std::uint32_t node : nodes) {
      const Sphere& s = sphereOf(tree, node, kind);
      for (const Eigen::Vector3d& n : shape.points) {
        const std::array<float, 3> point{static_cast<float>((s.x + s.radius * n.x()) * kMetre),
                                         static_cast<float>((s.y + s.radius * n.y()) * kMetre),
                                         static_cast<float>((s.z + s.radius * n.z()) * kMetre)};
        for (std::size_t axis = 0; axis < 3; ++axis)
          low[axis] = std::min(low[axis], point[axis]), high[axis] = std::max(high[axis], point[axis]);
        append(buffer, point);
      }
    }
    const std::size_t normals_at = buffer.size();
    for (std::size_t i = 0; i < nodes.size(); ++i)
      for (const Eigen::Vector3d& n : shape.points)
        append(buffer, std::array<float, 3>{static_cast<float>(n.x()), static_cast<float>(n.y()), static_cast<float>(n.z())});
    const std::size_t indices_at = buffer.size();
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const auto base = static_cast<std::uint32_t>(i * shape.points.size());
      for (const auto& [a, b, c] : shape.triangles) append(buffer, std::array<std::uint32_t, 3>{base + a, base + b, base + c});
    }

    const std::size_t vertices = nodes.size() * shape.points.size(), corners = nodes.size() * shape.triangles.size() * 3;
    const std::size_t positions = addAccessor(document, positions_at, normals_at, kArrayBuffer, kFloat, vertices, "VEC3");
    document["accessors"][positions]["min"] = low;
    document["accessors"][positions]["max"] = high;
    const std::size_t normals = addAccessor(document, normals_at, indices_at, kArrayBuffer, kFloat, vertices, "VEC3");
    const std::size_t indices = addAccessor(document, indices_at, buffer.size(), kElementArrayBuffer, kUnsignedInt, corners, "SCALAR");

    const auto& colour = kColours[static_cast<std::size_t>(level)];
    document["materials"].push_back(
        {{"name", name},
         {"pbrMetallicRoughness",
          {{"baseColorFactor", {colour[0], colour[1], colour[2], 1.0}}, {"metallicFactor", 0.0}, {"roughnessFactor", 0.6}}}});
    Json primitive;
    primitive["attributes"] = {{"POSITION", positions}, {"NORMAL", normals}};
    primitive["indices"] = indices;
    primitive["material"] = level;
    document["meshes"].push_back({{"name", name}, {"primitives", Json::array({primitive})}});
    document["nodes"].push_back({{"name", name}, {"mesh", level}});
    document["nodes"][0]["children"].push_back(level + 1);
  }
  if (tree.origin_mm != std::array<double, 3>{})
    document["nodes"][0]["translation"] = {tree.origin_mm[0] * kMetre, tree.origin_mm[1] * kMetre, tree.origin_mm[2] * kMetre};
  return packGlb(document, buffer);
}

}  // namespace spheretree::formats
