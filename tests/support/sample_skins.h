// SPDX-License-Identifier: Apache-2.0
// Sound skins and search trees for tests, made without the builder: spheres, boxes and flat grids; search trees by
// halving.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "spheretree/core/skin.h"
#include "spheretree/core/sphere_tree.h"
#include "support/sample_trees.h"

namespace spheretree::test {

/// A sphere around all of `spheres`: not the smallest one, but rounded outward.
inline Sphere sphereAbout(std::span<const Sphere> spheres) {
  Eigen::AlignedBox3f box;
  for (const Sphere& s : spheres) box.extend(Eigen::Vector3f(s.x, s.y, s.z));
  const Eigen::Vector3f centre = box.center();
  double radius = 0;
  for (const Sphere& s : spheres) {
    const double dx = double{s.x} - double{centre.x()}, dy = double{s.y} - double{centre.y()}, dz = double{s.z} - double{centre.z()};
    radius = std::max(radius, std::sqrt(dx * dx + dy * dy + dz * dz) + double{s.radius});
  }
  return {centre.x(), centre.y(), centre.z(), std::nextafter(static_cast<float>(radius), std::numeric_limits<float>::infinity())};
}

/// Halves along the longest axis until a node has at most `branching` (2 to 8) items or inner children; `item` holds
/// the order. Sound.
inline SearchTree searchTreeOf(std::span<const Sphere> items, std::size_t branching = kSearchBranching) {
  std::vector<std::uint16_t> order(items.size());
  std::iota(order.begin(), order.end(), std::uint16_t{0});
  const auto axisOf = [](const Sphere& s, int axis) { return axis == 0 ? s.x : axis == 1 ? s.y : s.z; };
  const auto halve = [&](std::span<std::uint16_t> part) {
    int longest = 0;
    float length = -1;
    for (int axis = 0; axis < 3; ++axis) {
      const auto [low, high] =
          std::minmax_element(part.begin(), part.end(), [&](auto a, auto b) { return axisOf(items[a], axis) < axisOf(items[b], axis); });
      if (const float extent = axisOf(items[*high], axis) - axisOf(items[*low], axis); extent > length) length = extent, longest = axis;
    }
    std::stable_sort(part.begin(), part.end(), [&](auto a, auto b) { return axisOf(items[a], longest) < axisOf(items[b], longest); });
    return part.size() / 2;
  };
  SearchTree tree;
  std::vector<std::span<std::uint16_t>> queue{order};
  for (std::size_t i = 0; i < queue.size(); ++i) {
    std::vector<Sphere> below;
    for (const std::uint16_t item : queue[i]) below.push_back(items[item]);
    tree.inner.push_back(sphereAbout(below));
    std::vector<std::span<std::uint16_t>> parts;
    if (queue[i].size() > branching) parts.push_back(queue[i]);
    while (!parts.empty() && parts.size() < branching) {
      const auto largest = std::max_element(parts.begin(), parts.end(), [](auto a, auto b) { return a.size() < b.size(); });
      if (largest->size() <= 1) break;
      const std::span<std::uint16_t> part = *largest;
      const std::size_t half = halve(part);
      *largest = part.first(half);
      parts.insert(largest + 1, part.subspan(half));
    }
    if (parts.empty())
      for (std::size_t k = 0; k < queue[i].size(); ++k) parts.push_back(queue[i].subspan(k, 1));
    std::uint8_t inner = 0, single = 0;
    for (const std::span<std::uint16_t> part : parts) {
      if (part.size() > 1) {
        queue.push_back(part);
        ++inner;
      } else {
        tree.item.push_back(part[0]);
        ++single;
      }
    }
    tree.inner_children.push_back(inner);
    tree.item_children.push_back(single);
  }
  return tree;
}

/// Builds a new search tree over the triangles and puts the triangles into its order.
inline void sortForSearch(Skin& skin, std::size_t branching = kSearchBranching) {
  std::vector<Sphere> about;
  for (std::size_t t = 0; t < skin.triangles.size(); ++t) about.push_back(enclose(patchOf(skin, t)));
  skin.search = searchTreeOf(about, branching);
  std::vector<SkinTriangle> sorted;
  for (const std::uint16_t t : skin.search.item) sorted.push_back(skin.triangles[t]);
  skin.triangles = std::move(sorted);
  skin.search.item.clear();
}

/// The surface that a sample skin approximates.
struct SmoothMesh {
  std::vector<Eigen::Vector3d> positions, normals;
  std::vector<std::array<std::uint16_t, 3>> triangles;
  std::function<Eigen::Vector3d(const Eigen::Vector3d&)> project;  // the middle of a chord to the surface
};

/// No patch is farther from its flat triangle than this: the sum of 4 w_i w_j offset_ij is at most 4/3 of the largest
/// possible offset.
inline float largestSwing(const Skin& skin) { return 1.3334f * std::sqrt(3.0f) * 127 * skin.offset_step; }

/// Sides with a triangle on one side only are sharp and straight; the others follow the surface.
inline Skin skinOf(const SmoothMesh& mesh) {
  Skin skin;
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : mesh.positions) box.extend(p);
  skin.step = static_cast<float>(box.sizes().maxCoeff() / kMaxSkinCoordinate * (1 + 1e-6));
  for (std::size_t axis = 0; axis < 3; ++axis) skin.low[axis] = static_cast<float>(box.min()[static_cast<Eigen::Index>(axis)]);
  skin.mesh_distance = 0.125f, skin.crease_angle = 0.5f;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    SkinVertex vertex{{}, packNormal(mesh.normals[v])};
    for (std::size_t axis = 0; axis < 3; ++axis)
      vertex.position[axis] = static_cast<std::uint32_t>(
          std::clamp(std::lround((mesh.positions[v][static_cast<Eigen::Index>(axis)] - double{skin.low[axis]}) / double{skin.step}), 0L,
                     long{kMaxSkinCoordinate}));
    skin.vertices.push_back(vertex);
  }
  struct Side {
    std::uint16_t edge;
    int uses;
    Eigen::Vector3d offset;
  };
  std::map<std::pair<std::uint16_t, std::uint16_t>, Side> sides;
  double farthest = 0;
  for (const auto& corners : mesh.triangles) {
    SkinTriangle triangle{corners, {}};
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint16_t a = corners[k], b = corners[(k + 1) % 3];
      const Eigen::Vector3d chord = 0.5 * (mesh.positions[a] + mesh.positions[b]);
      const auto [side, is_new] =
          sides.try_emplace(std::minmax(a, b), Side{static_cast<std::uint16_t>(skin.edges.size()), 0, mesh.project(chord) - chord});
      if (is_new) skin.edges.push_back({{}, 0, packNormal((mesh.normals[a] + mesh.normals[b]).normalized())});
      ++side->second.uses;
      farthest = std::max(farthest, side->second.offset.cwiseAbs().maxCoeff());
      triangle.edge[k] = side->second.edge;
    }
    skin.triangles.push_back(triangle);
  }
  skin.offset_step = static_cast<float>(farthest / 127 * (1 + 1e-6));
  skin.tolerance = largestSwing(skin);
  for (const auto& [ends, side] : sides) {
    SkinEdge& edge = skin.edges[side.edge];
    edge.is_sharp = side.uses == 1;
    if (edge.is_sharp || farthest == 0) continue;
    for (std::size_t axis = 0; axis < 3; ++axis)
      edge.offset[axis] = static_cast<std::int8_t>(std::lround(side.offset[static_cast<Eigen::Index>(axis)] / double{skin.offset_step}));
  }
  sortForSearch(skin);
  return skin;
}

/// Directions of the corners of an octahedron, divided `times` times, as `normals`, with 8 * 4^times triangles (at most
/// 6 times).
inline SmoothMesh dividedOctahedron(int times) {
  SmoothMesh mesh;
  for (int axis = 0; axis < 3; ++axis)
    for (const double sign : {1.0, -1.0}) mesh.normals.push_back(sign * Eigen::Vector3d::Unit(axis));
  for (std::uint16_t octant = 0; octant < 8; ++octant) {
    const auto x = static_cast<std::uint16_t>(octant & 1), y = static_cast<std::uint16_t>(2 + (octant >> 1 & 1)),
               z = static_cast<std::uint16_t>(4 + (octant >> 2));
    const bool turns = (octant & 1) ^ (octant >> 1 & 1) ^ (octant >> 2);
    mesh.triangles.push_back(turns ? std::array{x, z, y} : std::array{x, y, z});
  }
  for (int i = 0; i < times; ++i) {
    std::map<std::pair<std::uint16_t, std::uint16_t>, std::uint16_t> middles;
    const auto middle = [&](std::uint16_t a, std::uint16_t b) {
      const auto [found, is_new] = middles.try_emplace(std::minmax(a, b), static_cast<std::uint16_t>(mesh.normals.size()));
      if (is_new) mesh.normals.push_back((mesh.normals[a] + mesh.normals[b]).normalized());
      return found->second;
    };
    std::vector<std::array<std::uint16_t, 3>> finer;
    for (const auto& [a, b, c] : mesh.triangles) {
      const std::uint16_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    mesh.triangles = std::move(finer);
  }
  return mesh;
}

/// A sphere about the origin, from an octahedron that is divided `times` times.
inline Skin roundSkin(int times, double radius = 5) {
  SmoothMesh mesh = dividedOctahedron(times);
  for (const Eigen::Vector3d& n : mesh.normals) mesh.positions.push_back(radius * n);
  mesh.project = [=](const Eigen::Vector3d& p) -> Eigen::Vector3d { return radius * p.normalized(); };
  return skinOf(mesh);
}

/// An ellipsoid about the origin with these half axes, from an octahedron that is divided `times` times.
inline Skin ellipsoidSkin(const Eigen::Vector3d& half, int times) {
  SmoothMesh mesh = dividedOctahedron(times);
  for (Eigen::Vector3d& n : mesh.normals) {
    mesh.positions.push_back(n.cwiseProduct(half));
    n = n.cwiseQuotient(half).normalized();
  }
  mesh.project = [=](const Eigen::Vector3d& p) -> Eigen::Vector3d { return p / p.cwiseQuotient(half).norm(); };
  return skinOf(mesh);
}

/// Approximately the crown of a tooth: distance of a surface with cusps and pits from the origin in this direction (of
/// unit length), 4 to 6 mm.
inline double cuspedRadius(const Eigen::Vector3d& u) {
  return 5 + 0.6 * std::sin(4 * u.x()) * std::sin(4 * u.y()) + 0.4 * std::cos(5 * u.z());
}

/// That surface as a skin, from an octahedron that is divided `times` times.
inline Skin cuspedSkin(int times) {
  SmoothMesh mesh = dividedOctahedron(times);
  const auto on_surface = [](const Eigen::Vector3d& p) -> Eigen::Vector3d { return cuspedRadius(p.normalized()) * p.normalized(); };
  for (Eigen::Vector3d& n : mesh.normals) {
    const Eigen::Vector3d across = n.unitOrthogonal(), along = n.cross(across);
    constexpr double h = 1e-5;
    mesh.positions.push_back(on_surface(n));
    const Eigen::Vector3d side = on_surface(n + h * across) - on_surface(n - h * across),
                          other = on_surface(n + h * along) - on_surface(n - h * along);
    n = side.cross(other).normalized();
  }
  mesh.project = on_surface;
  return skinOf(mesh);
}

/// That surface with flat triangles and sharp sides, which have their own corners: it has ridges, hollows and saddles.
inline Skin facetedSkin(int times) {
  const SmoothMesh smooth = dividedOctahedron(times);
  SmoothMesh mesh;
  for (const auto& corners : smooth.triangles) {
    const auto first = static_cast<std::uint16_t>(mesh.positions.size());
    for (const std::uint16_t c : corners) mesh.positions.push_back(cuspedRadius(smooth.normals[c]) * smooth.normals[c]);
    const auto* p = &mesh.positions[first];
    mesh.normals.insert(mesh.normals.end(), 3, (p[1] - p[0]).cross(p[2] - p[0]).normalized());
    mesh.triangles.push_back({first, static_cast<std::uint16_t>(first + 1), static_cast<std::uint16_t>(first + 2)});
  }
  mesh.project = [](const Eigen::Vector3d& p) { return p; };
  return skinOf(mesh);
}

/// Two curved strips that meet along the y axis, from y = -2 to 2, at an angle; the common edge is sharp: a ridge.
inline Skin ridgeSkin() {
  SmoothMesh mesh;
  for (int side = 0; side < 2; ++side) {
    const double sign = side == 0 ? -1 : 1;
    const auto first = static_cast<std::uint16_t>(mesh.positions.size());
    for (const double y : {-2.0, 2.0})
      for (const double x : {0.0, 2.0}) {
        mesh.positions.emplace_back(sign * x, y, -0.7 * x);
        mesh.normals.push_back(Eigen::Vector3d(sign * (0.7 + 0.1 * (x - 1)), 0, 1).normalized());  // bends a little away from the ridge
      }
    const auto corner = [first](int k) { return static_cast<std::uint16_t>(first + k); };
    if (side == 1) {
      mesh.triangles.push_back({corner(0), corner(1), corner(3)});
      mesh.triangles.push_back({corner(0), corner(3), corner(2)});
    } else {
      mesh.triangles.push_back({corner(0), corner(3), corner(1)});
      mesh.triangles.push_back({corner(0), corner(2), corner(3)});
    }
  }
  mesh.project = [](const Eigen::Vector3d& p) -> Eigen::Vector3d {
    return p + Eigen::Vector3d(0, 0, 0.01 * std::abs(p.x()) * (2 - std::abs(p.x())));
  };
  return skinOf(mesh);
}

/// A flat square of 2 n * n triangles at z = 1, `side` mm long, seen from above.
inline Skin gridSkin(int n, double side = 8) {
  SmoothMesh mesh;
  const auto at = [n](int i, int j) { return static_cast<std::uint16_t>(i * (n + 1) + j); };
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= n; ++j) mesh.positions.emplace_back(side * i / n, side * j / n, 1);
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  mesh.normals.assign(mesh.positions.size(), Eigen::Vector3d::UnitZ());
  mesh.project = [](const Eigen::Vector3d& p) { return p; };
  return skinOf(mesh);
}

/// A box with these half sizes about the origin: 12 triangles, and sharp edges with separate vertices and edges on
/// either side.
inline Skin boxSkin(const Eigen::Vector3d& half) {
  SmoothMesh mesh;
  for (int axis = 0; axis < 3; ++axis)
    for (const double sign : {1.0, -1.0}) {
      const auto first = static_cast<std::uint16_t>(mesh.positions.size());
      for (const auto& [u, v] : {std::pair(-1.0, -1.0), std::pair(1.0, -1.0), std::pair(1.0, 1.0), std::pair(-1.0, 1.0)}) {
        Eigen::Vector3d p;
        p[axis] = sign, p[(axis + 1) % 3] = sign * u, p[(axis + 2) % 3] = v;
        mesh.positions.push_back(p.cwiseProduct(half));
        mesh.normals.push_back(sign * Eigen::Vector3d::Unit(axis));
      }
      const auto corner = [first](int k) { return static_cast<std::uint16_t>(first + k); };
      mesh.triangles.push_back({corner(0), corner(1), corner(2)});
      mesh.triangles.push_back({corner(0), corner(2), corner(3)});
    }
  mesh.project = [](const Eigen::Vector3d& p) { return p; };
  return skinOf(mesh);
}

/// One of the shapes above, with random offsets, normals and creases, and a search tree of random branching. Sound.
inline Skin randomSkin(std::uint64_t seed) {
  Random random(seed);
  const auto shape = random.below(3);
  Skin skin = shape == 0   ? roundSkin(static_cast<int>(random.below(3)))
              : shape == 1 ? gridSkin(1 + static_cast<int>(random.below(6)))
                           : boxSkin(Eigen::Vector3d(1, 2, 0.5));
  const auto normal = [&] {
    const auto coordinate = [&] { return static_cast<std::int16_t>(static_cast<int>(random.below(65535)) - 32767); };
    const std::int16_t u = coordinate(), v = coordinate();
    return PackedNormal{u, v};
  };
  skin.offset_step = 0.001f;
  skin.tolerance = largestSwing(skin);
  for (SkinVertex& vertex : skin.vertices) vertex.normal = normal();
  for (SkinEdge& edge : skin.edges) {
    edge.normal = normal();
    edge.is_sharp = random.below(4) == 0;
    for (std::int8_t& x : edge.offset)
      x = edge.is_sharp ? std::int8_t{0} : static_cast<std::int8_t>(static_cast<int>(random.below(255)) - 127);
  }
  sortForSearch(skin, 2 + random.below(7));
  return skin;
}

/// The same tree with a search tree over its leaves.
inline SphereTree withSearch(SphereTree tree, std::size_t branching = kSearchBranching) {
  tree.search = searchTreeOf(leavesOf(tree), branching);
  return tree;
}

/// The same tree with a skin.
inline SphereTree withSkin(SphereTree tree, Skin skin) {
  tree.skin = std::move(skin);
  return tree;
}

}  // namespace spheretree::test
