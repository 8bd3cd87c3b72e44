// SPDX-License-Identifier: GPL-3.0-or-later
#include "page/model.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "mesh/simplify_mesh.h"
#include "spheretree/core/mesh_edit.h"

namespace spheretree::tool {
namespace {

constexpr double kSteps = 65535;

/// Differences of neighbours, with negative ones as odd numbers: small values, which compress well.
template <class Unsigned>
std::vector<Unsigned> differences(const std::vector<std::uint32_t>& values) {
  std::vector<Unsigned> out;
  out.reserve(values.size());
  std::uint32_t last = 0;
  for (const std::uint32_t value : values) {
    const auto delta = static_cast<std::int32_t>(value - last);
    out.push_back(static_cast<Unsigned>(static_cast<std::uint32_t>(delta) << 1 ^ static_cast<std::uint32_t>(delta >> 31)));
    last = value;
  }
  return out;
}

/// Reorders vertices by their first use, so that neighbours are close together.
TriangleMesh inOrderOfUse(const TriangleMesh& mesh) {
  constexpr std::uint32_t kUnused = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> place(mesh.positions.size(), kUnused);
  TriangleMesh out;
  for (Triangle t : mesh.triangles) {
    for (std::uint32_t& v : t) {
      if (place[v] == kUnused) {
        place[v] = static_cast<std::uint32_t>(out.positions.size());
        out.positions.push_back(mesh.positions[v]);
      }
      v = place[v];
    }
    out.triangles.push_back(t);
  }
  return out;
}

/// A mesh that cannot be simplified is shown unchanged.
TriangleMesh thinned(const TriangleMesh& mesh, std::size_t triangles) {
  if (mesh.triangles.size() <= triangles) return mesh;
  builder::Progress silent;
  try {
    return builder::simplifyMesh(mesh, triangles, silent);
  } catch (const std::invalid_argument&) {
    return mesh;
  }
}

}  // namespace

Json packMesh(PageData& data, const TriangleMesh& mesh, const builder::SurfaceWithSheets& surface, std::size_t triangles) {
  const TriangleMesh coarse = inOrderOfUse(joined(thinned(mesh, triangles), surface.sheets));
  const Eigen::AlignedBox3d& box = surface.field.box();
  const Eigen::Vector3d low = box.min();
  const double step = std::max(box.sizes().maxCoeff() / (kSteps / 2), 1e-30);  // half of the range, since differences need a sign
  std::vector<std::uint16_t> positions;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    std::vector<std::uint32_t> values;
    for (const Eigen::Vector3d& p : coarse.positions)
      values.push_back(
          static_cast<std::uint32_t>(std::clamp(std::lround((p[axis] - low[axis]) / step), 0L, static_cast<long>(kSteps / 2))));
    const auto packed = differences<std::uint16_t>(values);
    positions.insert(positions.end(), packed.begin(), packed.end());
  }
  std::vector<std::uint32_t> indices;
  for (const Triangle& t : coarse.triangles) indices.insert(indices.end(), t.begin(), t.end());
  return {{"low", {low.x(), low.y(), low.z()}},
          {"step", step},
          {"triangles", mesh.triangles.size() + surface.sheets.triangles.size()},
          {"positions", data.add(std::span<const std::uint16_t>(positions))},
          {"indices", data.add(std::span<const std::uint32_t>(differences<std::uint32_t>(indices)))}};
}

Json packTree(PageData& data, const SphereTree& tree, const builder::DistanceField* field) {
  const Eigen::Vector3d origin(tree.origin_mm[0], tree.origin_mm[1], tree.origin_mm[2]);
  Eigen::AlignedBox3d box;
  double largest = 0;
  for (const Sphere& s : tree.cover) {
    box.extend(origin + centreOf(s));
    largest = std::max<double>(largest, s.radius);
  }
  const double step = std::max(box.sizes().maxCoeff(), largest) / kSteps;
  std::vector<std::uint16_t> spheres;  // x, y, z, radius of each node, consecutively
  std::vector<double> overhang;
  for (const Sphere& s : tree.cover) {
    const Eigen::Vector3d c = origin + centreOf(s), q = (c - box.min()) / step;
    for (const double value : {q.x(), q.y(), q.z(), s.radius / step})
      spheres.push_back(static_cast<std::uint16_t>(std::clamp(std::lround(value), 0L, static_cast<long>(kSteps))));
    if (field) overhang.push_back(std::max(0.0, s.radius + field->signedDistance(c)));
  }
  std::vector<std::uint8_t> ends;  // 1: a leaf
  for (std::size_t node = 0; node < tree.nodeCount(); ++node) ends.push_back(tree.isLeaf(node));
  std::vector<std::uint8_t> branch(tree.nodeCount(), 0);  // the child of the root from which a node descends
  for (std::size_t node = 0; node < tree.nodeCount(); ++node)
    for (std::uint8_t k = 0; k < tree.child_count[node]; ++k) branch[tree.first_child[node] + k] = node == 0 ? k : branch[node];
  Json out{{"low", {box.min().x(), box.min().y(), box.min().z()}},
           {"step", step},
           {"levels", tree.level_begin},
           {"spheres", data.add(std::span<const std::uint16_t>(spheres))},
           {"ends", data.add(std::span<const std::uint8_t>(ends))},
           {"branch", data.add(std::span<const std::uint8_t>(branch))}};
  if (!field) return out;
  // Relative to each level, since the root's overhang would dwarf that of the leaves: 255 is the largest of its level.
  std::vector<std::uint8_t> shares;
  Json overhang_max = Json::array();
  for (std::size_t level = 0; level + 1 < tree.level_begin.size(); ++level) {
    const auto begin = overhang.begin() + tree.level_begin[level], end = overhang.begin() + tree.level_begin[level + 1];
    const double top = begin == end ? 0 : *std::max_element(begin, end);
    overhang_max.push_back(top);
    for (auto at = begin; at != end; ++at) shares.push_back(static_cast<std::uint8_t>(top > 0 ? std::lround(*at / top * 255) : 0));
  }
  out["overhang"] = data.add(std::span<const std::uint8_t>(shares));
  out["overhang_max"] = overhang_max;
  return out;
}

}  // namespace spheretree::tool
