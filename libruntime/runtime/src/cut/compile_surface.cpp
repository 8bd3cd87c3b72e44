// SPDX-License-Identifier: Apache-2.0
#include "cut/compile_surface.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>

namespace spheretree::runtime {
namespace {

using Eigen::Vector3f;
using Part = std::span<std::uint16_t>;  // items

// A ball around items, rounded outward.
Sphere about(std::span<const Sphere> items, Part part) {
  Vector3f low = Vector3f::Constant(std::numeric_limits<float>::infinity()), high = -low;
  for (const std::uint16_t i : part) {
    const Vector3f c(items[i].x, items[i].y, items[i].z);
    low = low.cwiseMin(c), high = high.cwiseMax(c);
  }
  const Vector3f middle = 0.5f * (low + high);
  double radius = 0;
  for (const std::uint16_t i : part)
    radius = std::max(radius, (centreOf(items[i]) - middle.cast<double>()).norm() + static_cast<double>(items[i].radius));
  return {middle[0], middle[1], middle[2], static_cast<float>(radius * (1 + 1e-6))};
}

// Orders the items along the longest axis of the box of their centres. Ties keep the order of the mesh.
void sortAlong(std::span<const Sphere> items, Part part) {
  Vector3f low = Vector3f::Constant(std::numeric_limits<float>::infinity()), high = -low;
  for (const std::uint16_t i : part) {
    const Vector3f c(items[i].x, items[i].y, items[i].z);
    low = low.cwiseMin(c), high = high.cwiseMax(c);
  }
  Eigen::Index axis = 0;
  (high - low).maxCoeff(&axis);
  const auto along = [&](std::uint16_t i) { return axis == 0 ? items[i].x : axis == 1 ? items[i].y : items[i].z; };
  std::sort(part.begin(), part.end(), [&](auto a, auto b) { return along(a) != along(b) ? along(a) < along(b) : a < b; });
}

// Halves until a node has eight children.
SearchTree halved(std::span<const Sphere> items, std::vector<std::uint16_t>& order) {
  SearchTree tree;
  std::vector<Part> queue{order};
  for (std::size_t n = 0; n < queue.size(); ++n) {
    std::vector<Part> parts{queue[n]};
    tree.inner.push_back(about(items, queue[n]));
    while (parts.size() < kSearchBranching) {
      const auto largest = std::max_element(parts.begin(), parts.end(), [](Part a, Part b) { return a.size() < b.size(); });
      if (largest->size() == 1) break;
      const Part whole = *largest;
      sortAlong(items, whole);
      *largest = whole.first(whole.size() / 2);
      parts.insert(largest + 1, whole.subspan(whole.size() / 2));
    }
    std::uint8_t inner = 0, single = 0;
    for (const Part part : parts) {
      if (part.size() > 1)
        queue.push_back(part), ++inner;
      else
        tree.item.push_back(part[0]), ++single;
    }
    tree.inner_children.push_back(inner);
    tree.item_children.push_back(single);
  }
  return tree;
}

}  // namespace

CompiledSkin compileSurface(const TriangleMesh& mesh, const Eigen::Vector3d& origin) {
  CompiledSkin out;
  std::vector<Sphere> balls;
  out.patch.resize(mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (int k = 0; k < 3; ++k) {
      middle += mesh.corner(t, k) / 3;
      const Vector3f p = (mesh.corner(t, k) + origin).cast<float>();
      for (int axis = 0; axis < 3; ++axis) out.patch[t].position[k][axis] = p[axis];
    }
    double radius = 0;
    for (int k = 0; k < 3; ++k) radius = std::max(radius, (mesh.corner(t, k) - middle).norm());
    const Vector3f c = middle.cast<float>();
    balls.push_back({c[0], c[1], c[2], static_cast<float>((radius + 1e-6 * middle.norm()) * (1 + 1e-6))});
  }
  std::vector<std::uint16_t> order(balls.size());
  std::iota(order.begin(), order.end(), std::uint16_t{0});
  out.tree = compileTree(halved(balls, order), balls, origin, TreeOver::Triangles);
  out.far = farFaces(out.tree, out.patch);
  return out;
}

}  // namespace spheretree::runtime
