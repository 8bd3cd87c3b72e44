// SPDX-License-Identifier: Apache-2.0
#include "spheretree/runtime/bridge.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "spheretree/runtime/scene.h"

namespace spheretree::runtime {
namespace {

constexpr std::size_t kMostNeighbours = 256;

Eigen::Vector3d centre(const Sphere& s) { return {s.x, s.y, s.z}; }

struct Leaf {
  Eigen::Vector3d c;
  double r;
  std::uint16_t slot;
};

/// Unit normals of the two planes that touch three balls, and the triangle's own unit normal; false if there are none.
bool touchingPlanes(const std::array<Eigen::Vector3d, 3>& c, const std::array<double, 3>& r, std::array<Eigen::Vector3d, 2>& normals) {
  const Eigen::Vector3d u = c[1] - c[0], v = c[2] - c[0], up = u.cross(v);
  const double area2 = up.squaredNorm();
  if (!(area2 > 1e-12 * u.squaredNorm() * v.squaredNorm())) return false;
  // n in the plane of centres solves n.u = r0 - r1, n.v = r0 - r2.
  const Eigen::Vector3d in_plane = ((r[0] - r[1]) * v.cross(up) + (r[0] - r[2]) * up.cross(u)) / area2;
  const double rest = 1 - in_plane.squaredNorm();
  if (!(rest > 0)) return false;
  const Eigen::Vector3d out = up * std::sqrt(rest / area2);
  normals = {in_plane + out, in_plane - out};
  return true;
}

/// Where three spheres meet; false if they do not.
bool commonPoints(const Leaf& a, const Leaf& b, const Leaf& c, std::array<Eigen::Vector3d, 2>& points) {
  const Eigen::Vector3d u = b.c - a.c, v = c.c - a.c, up = u.cross(v);
  const double area2 = up.squaredNorm();
  if (!(area2 > 1e-12 * u.squaredNorm() * v.squaredNorm())) return false;
  const double du = 0.5 * (u.squaredNorm() + a.r * a.r - b.r * b.r), dv = 0.5 * (v.squaredNorm() + a.r * a.r - c.r * c.r);
  const Eigen::Vector3d in_plane = (du * v.cross(up) + dv * up.cross(u)) / area2;
  const double rest = a.r * a.r - in_plane.squaredNorm();
  if (!(rest > 0)) return false;
  const Eigen::Vector3d out = up * std::sqrt(rest / area2);
  points = {a.c + in_plane + out, a.c + in_plane - out};
  return true;
}

/// How high the cone about two overlapping balls stands above the circle in which they meet.
double pairDepth(const Leaf& a, const Leaf& b) {
  const double length = (b.c - a.c).norm(), slope = (a.r - b.r) / length;
  if (!(std::abs(slope) < 1)) return 1e30;
  const double along = 0.5 * (length + (a.r * a.r - b.r * b.r) / length), high = std::sqrt(std::max(0.0, a.r * a.r - along * along));
  return a.r - (slope * along + std::sqrt(1 - slope * slope) * high);
}

Bridge facet(const Leaf& a, const Leaf& b, const Leaf& c, const std::array<Eigen::Vector3d, 2>& normals, double depth) {
  Bridge bridge{};
  bridge.slot = {a.slot, b.slot, c.slot};
  bridge.depth = static_cast<float>(depth);
  bridge.a = a.c;
  bridge.radius = a.r;
  const Eigen::Vector3d u = b.c - a.c, v = c.c - a.c;
  bridge.up = u.cross(v);
  bridge.normal = normals;
  bridge.along_u = v.cross(bridge.up) / bridge.up.squaredNorm();
  bridge.along_v = bridge.up.cross(u) / bridge.up.squaredNorm();
  const double spread = 1 + bridge.up.norm() / std::abs(bridge.up.dot(normals[0]));
  bridge.spread_u = spread * bridge.along_u.norm();
  bridge.spread_v = spread * bridge.along_v.norm();
  return bridge;
}

Bridge cone(const Leaf& a, const Leaf& b) {
  Bridge bridge{};
  bridge.slot = {a.slot, b.slot, b.slot};
  bridge.depth = static_cast<float>(pairDepth(a, b));
  bridge.a = a.c;
  bridge.radius = a.r;
  bridge.length = (b.c - a.c).norm();
  bridge.up = (b.c - a.c) / bridge.length;
  bridge.slope = (a.r - b.r) / bridge.length;
  bridge.rise = std::sqrt(1 - bridge.slope * bridge.slope);
  bridge.spread_u = 1 + std::abs(bridge.slope) / bridge.rise;
  return bridge;
}

}  // namespace

Bridges makeBridges(const CompiledTree& tree, double most_depth) {
  Bridges bridges;
  if (!(most_depth > 0)) return bridges;
  std::vector<Leaf> leaves;
  for (std::size_t slot = 0; slot < tree.node.size(); ++slot)
    if (tree.node[slot] != kNoNode && !tree.isInner(slot))
      leaves.push_back(
          {centre(tree.cover_records[slot]), static_cast<double>(tree.cover_records[slot].radius), static_cast<std::uint16_t>(slot)});
  std::sort(leaves.begin(), leaves.end(),
            [](const Leaf& a, const Leaf& b) { return a.c.x() != b.c.x() ? a.c.x() < b.c.x() : a.slot < b.slot; });
  double widest = 0;
  for (const Leaf& leaf : leaves) widest = std::max(widest, leaf.r);
  std::vector<std::vector<std::uint32_t>> neighbours(leaves.size());
  for (std::uint32_t i = 0; i < leaves.size(); ++i)
    for (std::uint32_t j = i + 1; j < leaves.size() && leaves[j].c.x() - leaves[i].c.x() < leaves[i].r + widest; ++j) {
      const double touch = leaves[i].r + leaves[j].r, d2 = (leaves[i].c - leaves[j].c).squaredNorm(), inside = leaves[i].r - leaves[j].r;
      if (d2 >= touch * touch || d2 <= inside * inside) continue;
      neighbours[i].push_back(j);
      neighbours[j].push_back(i);
    }
  const auto exposed = [&](const Eigen::Vector3d& p, std::uint32_t i, std::uint32_t j, std::uint32_t k) {
    return std::none_of(neighbours[i].begin(), neighbours[i].end(), [&](std::uint32_t n) {
      return n != j && n != k && (leaves[n].c - p).squaredNorm() < leaves[n].r * leaves[n].r * (1 - 1e-9);
    });
  };
  std::vector<std::array<std::uint32_t, 2>> edges;
  std::vector<std::uint32_t> common;
  for (std::uint32_t i = 0; i < leaves.size(); ++i) {
    if (neighbours[i].size() > kMostNeighbours) continue;
    for (const std::uint32_t j : neighbours[i]) {
      if (j < i || neighbours[j].size() > kMostNeighbours || pairDepth(leaves[i], leaves[j]) > most_depth) continue;
      common.clear();
      std::set_intersection(neighbours[i].begin(), neighbours[i].end(), neighbours[j].begin(), neighbours[j].end(),
                            std::back_inserter(common));
      for (const std::uint32_t k : common) {
        if (k < j || neighbours[k].size() > kMostNeighbours) continue;
        const double slopes = std::max(pairDepth(leaves[i], leaves[k]), pairDepth(leaves[j], leaves[k]));
        std::array<Eigen::Vector3d, 2> points, normals;
        if (slopes > most_depth || !commonPoints(leaves[i], leaves[j], leaves[k], points)) continue;
        if (!touchingPlanes({leaves[i].c, leaves[j].c, leaves[k].c}, {leaves[i].r, leaves[j].r, leaves[k].r}, normals)) continue;
        double depth = std::max(slopes, pairDepth(leaves[i], leaves[j]));
        for (std::size_t side = 0; side < 2; ++side) depth = std::max(depth, leaves[i].r - normals[side].dot(points[side] - leaves[i].c));
        if (depth > most_depth || !(exposed(points[0], i, j, k) || exposed(points[1], i, j, k))) continue;
        bridges.all.push_back(facet(leaves[i], leaves[j], leaves[k], normals, depth));
        edges.insert(edges.end(), {{i, j}, {i, k}, {j, k}});
      }
    }
  }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  for (const auto& [i, j] : edges) bridges.all.push_back(cone(leaves[i], leaves[j]));
  if (bridges.all.empty()) return bridges;
  bridges.first.assign(tree.node.size() + 1, 0);
  const auto eachSlot = [&](const auto& visit) {
    for (std::uint32_t b = 0; b < bridges.all.size(); ++b)
      for (std::size_t k = 0; k < (bridges.all[b].isPair() ? 2u : 3u); ++k) visit(bridges.all[b].slot[k], b);
  };
  eachSlot([&](std::uint16_t slot, std::uint32_t) { ++bridges.first[slot + 1u]; });
  for (std::size_t s = 1; s < bridges.first.size(); ++s) bridges.first[s] += bridges.first[s - 1];
  bridges.of_slot.resize(bridges.first.back());
  std::vector<std::uint32_t> next(bridges.first.begin(), bridges.first.end() - 1);
  eachSlot([&](std::uint16_t slot, std::uint32_t b) { bridges.of_slot[next[slot]++] = b; });
  for (const Bridge& bridge : bridges.all) bridges.deepest = std::max(bridges.deepest, bridge.depth);
  return bridges;
}

namespace {

/// Weights of the second and third leaf at the foot of `t` (from the first centre), and the normal there.
Eigen::Vector2d footOnFacet(const Bridge& bridge, const Eigen::Vector3d& t, Eigen::Vector3d& normal) {
  const double height = bridge.up.dot(t);
  normal = bridge.normal[height < 0 ? 1 : 0];
  const Eigen::Vector3d foot = t - normal * (height / bridge.up.dot(normal));  // on the plane of centres
  return {foot.dot(bridge.along_u), foot.dot(bridge.along_v)};
}

/// Where the foot of `t` is on the line of two [mm], and the normal there. False on the line itself.
bool footOnCone(const Bridge& bridge, const Eigen::Vector3d& t, double& foot, Eigen::Vector3d& normal) {
  const double along = t.dot(bridge.up);
  const Eigen::Vector3d across = t - bridge.up * along;
  const double off = across.norm();
  if (!(off > 1e-9 * bridge.length)) return false;
  foot = along - off * bridge.slope / bridge.rise;
  normal = bridge.up * bridge.slope + across * (bridge.rise / off);
  return true;
}

}  // namespace

bool nearestOnBridge(const Bridge& bridge, const Eigen::Vector3d& p, BridgeContact& contact) noexcept {
  const Eigen::Vector3d t = p - bridge.a;
  if (bridge.isPair()) {
    double foot;
    if (!footOnCone(bridge, t, foot, contact.normal) || !(foot > 0 && foot < bridge.length)) return false;
  } else {
    const Eigen::Vector2d w = footOnFacet(bridge, t, contact.normal);
    if (!(w.x() > 0 && w.y() > 0 && w.x() + w.y() < 1)) return false;
  }
  contact.gap = contact.normal.dot(t) - bridge.radius;
  return true;
}

bool mayTouchBridge(const Bridge& bridge, const Eigen::Vector3d& p, double gap, double margin) noexcept {
  const Eigen::Vector3d t = p - bridge.a;
  Eigen::Vector3d normal;
  if (bridge.isPair()) {
    double foot;
    if (!footOnCone(bridge, t, foot, normal)) return true;
    const double off = margin * bridge.spread_u;
    return foot > -off && foot < bridge.length + off && normal.dot(t) - bridge.radius <= gap + margin;
  }
  const double u = margin * bridge.spread_u, v = margin * bridge.spread_v;
  if (std::abs(bridge.up.dot(t)) <= margin * bridge.up.norm()) return true;  // the other facet may be the near one
  const Eigen::Vector2d w = footOnFacet(bridge, t, normal);
  return w.x() > -u && w.y() > -v && w.x() + w.y() < 1 + u + v && normal.dot(t) - bridge.radius <= gap + margin;
}

}  // namespace spheretree::runtime
