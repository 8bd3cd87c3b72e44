// SPDX-License-Identifier: Apache-2.0
#include "spheretree/formats/tree_glb.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <string>
#include <utility>

#include "gltf/glb_writer.h"

namespace spheretree::formats {
namespace {

struct Icosphere {
  std::vector<Eigen::Vector3d> points;  // on the unit sphere
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

/// The spheres of one level set: instances of one icosphere of radius 1 m. Returns their parent node.
int addLevel(GlbWriter& glb, const SphereTree& tree, int level, SphereKind kind) {
  constexpr std::array<std::array<double, 3>, kMaxLevels> kColours{
      {{0.60, 0.60, 0.60}, {0.85, 0.37, 0.10}, {0.90, 0.67, 0.12}, {0.20, 0.60, 0.35}, {0.15, 0.45, 0.75}, {0.50, 0.30, 0.65}}};
  const std::vector<std::uint32_t> nodes = levelSet(tree, level);
  const Icosphere shape = makeIcosphere(nodes.size() <= 1024 ? 3 : 2);
  const std::string name = "level_" + std::to_string(level);
  GlbWriter::Part ball{.name = name,
                       .colour = kColours[static_cast<std::size_t>(level)],
                       .is_double_sided = false,
                       .positions = {},
                       .normals = shape.points,
                       .triangles = shape.triangles};
  for (const Eigen::Vector3d& p : shape.points) ball.positions.push_back(p / kMetre);
  const int mesh = glb.addMesh(ball);
  std::vector<int> spheres;
  for (const std::uint32_t node : nodes) {
    const Sphere& s = sphereOf(tree, node, kind);
    spheres.push_back(glb.addInstance("sphere_" + std::to_string(node), mesh, double{s.radius} * kMetre, {s.x, s.y, s.z}));
  }
  return glb.addNode(name, std::move(spheres), {});
}

/// The patches of a skin: each side is divided into four, which gives 15 points and 16 triangles.
GlbWriter::Part partOf(const Skin& skin) {
  constexpr int kParts = 4;
  GlbWriter::Part mesh{
      .name = "skin", .colour = {0.93, 0.87, 0.76}, .is_double_sided = true, .positions = {}, .normals = {}, .triangles = {}};
  for (std::size_t t = 0; t < skin.triangles.size(); ++t) {
    const SkinPatch patch = patchOf(skin, t);
    std::uint32_t row = static_cast<std::uint32_t>(mesh.positions.size());  // first point of row i, which has kParts + 1 - i points
    for (int i = 0; i <= kParts; ++i) {
      const auto length = static_cast<std::uint32_t>(kParts + 1 - i);
      for (int j = 0; j <= kParts - i; ++j) {
        const Eigen::Vector3d w(static_cast<double>(kParts - i - j) / kParts, static_cast<double>(i) / kParts,
                                static_cast<double>(j) / kParts);
        Eigen::Vector3d position = Eigen::Vector3d::Zero(), normal = position;
        for (int k = 0; k < 3; ++k) {
          const auto corner = static_cast<std::size_t>(k);
          const double at_corner = w[k] * (2 * w[k] - 1), at_middle = 4 * w[k] * w[(k + 1) % 3];
          position += at_corner * patch.position[corner].cast<double>() + at_middle * patch.position[3 + corner].cast<double>();
          normal += at_corner * patch.normal[corner].cast<double>() + at_middle * patch.normal[3 + corner].cast<double>();
        }
        mesh.positions.push_back(position);
        mesh.normals.push_back(normal.norm() > 1e-6 ? normal.normalized() : patch.normal[0].cast<double>().normalized());
        const std::uint32_t here = row + static_cast<std::uint32_t>(j);
        if (i + j < kParts) mesh.triangles.push_back({here, here + length, here + 1});
        if (i + j < kParts - 1) mesh.triangles.push_back({here + 1, here + length, here + length + 1});
      }
      row += length;
    }
  }
  return mesh;
}

/// Adds points with their normals and triangles between them.
void append(GlbWriter::Part& mesh, const std::vector<Eigen::Vector3d>& points, const std::vector<Eigen::Vector3d>& normals,
            const std::vector<std::array<std::uint32_t, 3>>& triangles) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), points.begin(), points.end());
  mesh.normals.insert(mesh.normals.end(), normals.begin(), normals.end());
  for (const auto& [a, b, c] : triangles) mesh.triangles.push_back({first + a, first + b, first + c});
}

/// The side of a rounded cone: the lines along which it touches both balls, all of whose normals make the same angle
/// with the axis.
void appendCone(GlbWriter::Part& mesh, const Sphere& from, const Sphere& to) {
  constexpr std::uint32_t kLines = 32;
  const Eigen::Vector3d way = centreOf(to) - centreOf(from), along = way.normalized();
  const double sine = (double{to.radius} - double{from.radius}) / way.norm(), cosine = std::sqrt(std::max(0.0, 1 - sine * sine));
  const Eigen::Vector3d x = along.unitOrthogonal(), y = along.cross(x);
  std::vector<Eigen::Vector3d> points, normals;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  for (std::uint32_t i = 0; i < kLines; ++i) {
    const double angle = 2 * std::numbers::pi * i / kLines;
    const Eigen::Vector3d normal = cosine * (std::cos(angle) * x + std::sin(angle) * y) - sine * along;
    for (const Sphere& s : {from, to}) points.emplace_back(centreOf(s) + s.radius * normal), normals.push_back(normal);
    const std::uint32_t a = 2 * i, b = 2 * ((i + 1) % kLines);
    triangles.push_back({a, b, b + 1});
    triangles.push_back({a, b + 1, a + 1});
  }
  append(mesh, points, normals, triangles);
}

/// The two faces of a slab, which touch its three balls: their normals n satisfy n . (c_i - c_0) = r_0 - r_i.
void appendSlab(GlbWriter::Part& mesh, const std::array<Sphere, 3>& ball) {
  const Eigen::Vector3d e1 = centreOf(ball[1]) - centreOf(ball[0]), e2 = centreOf(ball[2]) - centreOf(ball[0]), across = e1.cross(e2);
  const double rise1 = double{ball[0].radius} - double{ball[1].radius}, rise2 = double{ball[0].radius} - double{ball[2].radius};
  const Eigen::Vector3d flat = (rise1 * e2.cross(across) + rise2 * across.cross(e1)) / across.squaredNorm();
  const Eigen::Vector3d upward = std::sqrt(std::max(0.0, 1 - flat.squaredNorm())) * across.normalized();
  for (const double side : {1.0, -1.0}) {
    const Eigen::Vector3d normal = flat + side * upward;
    std::vector<Eigen::Vector3d> points;
    for (const Sphere& s : ball) points.emplace_back(centreOf(s) + s.radius * normal);
    append(mesh, points, {normal, normal, normal}, {side > 0 ? std::array{0u, 1u, 2u} : std::array{0u, 2u, 1u}});
  }
}

/// The parts of hulls: balls, sides of cones, and faces of slabs, whose edges and corners are parts of their own.
GlbWriter::Part partOf(const Hulls& hulls) {
  GlbWriter::Part mesh{
      .name = "hulls", .colour = {0.25, 0.55, 0.75}, .is_double_sided = false, .positions = {}, .normals = {}, .triangles = {}};
  const Icosphere sphere = makeIcosphere(2);
  for (const HullPart& part : hulls.parts) {
    const std::size_t count = ballCount(part);
    const Sphere& first = hulls.balls[part[0]];
    if (count == 1) {
      std::vector<Eigen::Vector3d> points;
      for (const Eigen::Vector3d& p : sphere.points) points.emplace_back(centreOf(first) + first.radius * p);
      append(mesh, points, sphere.points, sphere.triangles);
    } else if (count == 2) {
      appendCone(mesh, first, hulls.balls[part[1]]);
    } else {
      appendSlab(mesh, {first, hulls.balls[part[1]], hulls.balls[part[2]]});
    }
  }
  return mesh;
}

}  // namespace

std::vector<std::byte> encodeGlb(const SphereTree& tree, SphereKind kind, std::optional<int> level) {
  GlbWriter glb;
  std::vector<int> levels;  // nodes
  const int last = tree.levelCount() - 1;
  for (int k = 0; k <= last; ++k)
    if (!level || k == *level) levels.push_back(addLevel(glb, tree, k, kind));
  std::vector<int> shown{levels.back()};
  if (!tree.skin.empty() && level.value_or(last) == last) shown.push_back(glb.add(partOf(tree.skin)));
  const auto addScene = [&](const std::string& name, const std::vector<int>& nodes) {
    glb.addScene(name, {glb.addNode(name, nodes, tree.origin_mm)});
  };
  addScene("sphere_tree", shown);
  if (!tree.hulls.empty() && level.value_or(last) == last) addScene("scene_of_hulls", {glb.add(partOf(tree.hulls))});
  for (std::size_t k = 0; k + 1 < levels.size(); ++k) addScene("scene_of_level_" + std::to_string(k), {levels[k]});
  return glb.finish();
}

}  // namespace spheretree::formats
