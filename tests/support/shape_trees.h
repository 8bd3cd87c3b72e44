// SPDX-License-Identifier: Apache-2.0
// Sphere-trees of simple shapes, made without the builders: balls on a grid or a curve, grouped by halving along the
// longest axis.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "spheretree/core/rigid.h"
#include "spheretree/core/sphere_tree.h"
#include "support/sample_trees.h"

namespace spheretree::test {

inline Sphere ball(double x, double y, double z, double radius) {
  return {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z), static_cast<float>(radius)};
}

inline float axisValue(const Sphere& s, int axis) { return axis == 0 ? s.x : axis == 1 ? s.y : s.z; }

/// The axis along which the centres extend farthest.
inline int longestAxis(std::span<const Sphere> balls) {
  int axis = 0;
  float widest = -1;
  for (int k = 0; k < 3; ++k) {
    const auto [low, high] = std::ranges::minmax(balls, {}, [&](const Sphere& s) { return axisValue(s, k); });
    if (axisValue(high, k) - axisValue(low, k) <= widest) continue;
    widest = axisValue(high, k) - axisValue(low, k);
    axis = k;
  }
  return axis;
}

/// Sound, at most `branching` children of a node; the leaves are `balls`. At most 8^5 of them.
inline SphereTree treeOfBalls(std::vector<Sphere> balls, std::size_t branching = 8) {
  struct Group {
    std::size_t begin, end;
  };
  // Halves the largest group until there are enough.
  const auto split = [&](Group whole) {
    std::vector<Group> groups{whole};
    if (whole.end - whole.begin <= branching) {
      groups.clear();
      for (std::size_t i = whole.begin; i < whole.end; ++i) groups.push_back({i, i + 1});
      return groups;
    }
    while (groups.size() < branching) {
      std::size_t largest = 0;
      for (std::size_t g = 1; g < groups.size(); ++g)
        if (groups[g].end - groups[g].begin > groups[largest].end - groups[largest].begin) largest = g;
      const Group g = groups[largest];
      const int axis = longestAxis(std::span(balls).subspan(g.begin, g.end - g.begin));
      const std::size_t middle = g.begin + (g.end - g.begin) / 2;
      std::stable_sort(balls.begin() + static_cast<std::ptrdiff_t>(g.begin), balls.begin() + static_cast<std::ptrdiff_t>(g.end),
                       [&](const Sphere& a, const Sphere& b) { return axisValue(a, axis) < axisValue(b, axis); });
      groups[largest] = {g.begin, middle};
      groups.insert(groups.begin() + static_cast<std::ptrdiff_t>(largest) + 1, {middle, g.end});
    }
    // Inner siblings come before leaves.
    std::stable_sort(groups.begin(), groups.end(), [](Group a, Group b) { return (a.end - a.begin > 1) > (b.end - b.begin > 1); });
    return groups;
  };
  SphereTree tree;
  tree.branching = static_cast<std::uint8_t>(branching);
  std::vector<Group> queue{{0, balls.size()}};
  for (std::size_t n = 0; n < queue.size(); ++n) {
    const Group g = queue[n];
    if (g.end - g.begin == 1) {
      tree.child_count.push_back(0);
      tree.cover.push_back(balls[g.begin]);
      continue;
    }
    const std::vector<Group> children = split(g);
    tree.child_count.push_back(static_cast<std::uint8_t>(children.size()));
    queue.insert(queue.end(), children.begin(), children.end());
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    for (std::size_t i = g.begin; i < g.end; ++i) centre += Eigen::Vector3d(balls[i].x, balls[i].y, balls[i].z);
    centre /= static_cast<double>(g.end - g.begin);
    double radius = 0;
    for (std::size_t i = g.begin; i < g.end; ++i)
      radius =
          std::max(radius, (Eigen::Vector3d(balls[i].x, balls[i].y, balls[i].z) - centre).norm() + static_cast<double>(balls[i].radius));
    tree.cover.push_back(ball(centre.x(), centre.y(), centre.z(), radius));
  }
  if (!linkNodes(tree)) return {};
  encloseDescendants(tree);
  countLevels(tree);
  return tree;
}

/// nx * ny * nz balls filling the box of these half sizes [mm], centres evenly spaced.
inline SphereTree boxTree(const Eigen::Vector3d& half, std::array<int, 3> n, double radius) {
  std::vector<Sphere> balls;
  const auto at = [&](int axis, int i) {
    const int count = n[static_cast<std::size_t>(axis)];
    return count == 1 ? 0.0 : -half[axis] + 2 * half[axis] * i / (count - 1);
  };
  for (int i = 0; i < n[0]; ++i)
    for (int j = 0; j < n[1]; ++j)
      for (int k = 0; k < n[2]; ++k) balls.push_back(ball(at(0, i), at(1, j), at(2, k), radius));
  return treeOfBalls(std::move(balls));
}

/// A rod along z from z = 0 up: `count` balls over `length` [mm].
inline SphereTree rodTree(double length, int count, double radius) {
  std::vector<Sphere> balls;
  for (int i = 0; i < count; ++i) balls.push_back(ball(0, 0, length * i / (count - 1), radius));
  return treeOfBalls(std::move(balls));
}

/// Balls of radius about `grain` whose centres lie `grain` inside an ellipsoid with these half axes [mm], evenly
/// distributed by a golden spiral.
inline SphereTree ellipsoidTree(const Eigen::Vector3d& half, int count, double grain) {
  std::vector<Sphere> balls;
  for (int i = 0; i < count; ++i) {
    const double z = 1 - (2 * i + 1.0) / count, rim = std::sqrt(1 - z * z), angle = 2.399963229728653 * i;
    balls.push_back(
        ball((half.x() - grain) * rim * std::cos(angle), (half.y() - grain) * rim * std::sin(angle), (half.z() - grain) * z, grain));
  }
  return treeOfBalls(std::move(balls));
}

/// A tree with one node.
inline SphereTree oneBallTree(double radius) { return treeOfBalls({ball(0, 0, 0, radius)}); }

inline Quaternion randomRotation(Random& random) {
  const double w = random.between(-1, 1), x = random.between(-1, 1), y = random.between(-1, 1), z = random.between(-1, 1);
  const Quaternion q(w, x, y, z);
  if (q.squaredNorm() < 1e-3) return {1, 0, 0, 0};
  return q.normalized();
}

inline Eigen::Vector3d randomPoint(Random& random, double half) {
  const double x = random.between(-half, half), y = random.between(-half, half), z = random.between(-half, half);
  return {x, y, z};
}

}  // namespace spheretree::test
