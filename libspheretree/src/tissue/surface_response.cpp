// SPDX-License-Identifier: GPL-3.0-or-later
#include "tissue/surface_response.h"

#include <tbb/parallel_for.h>

#include <Eigen/QR>
#include <algorithm>
#include <map>

#include "geometry/distance_field.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr std::size_t kNodesAtATime = 8;  // three right-hand sides each: a row of them is three lines of the cache

// Over one triangle of area 1: integral of the linear hat of corner a times the quadratic shape function of a node, by
// the formula for monomials of barycentric coordinates, 2 i! j! k! / (i + j + k + 2)!.
constexpr double kOwnCorner = 1.0 / 30, kOtherCorner = -1.0 / 60, kNearMiddle = 2.0 / 15, kFarMiddle = 1.0 / 15;

/// Shares of the quadratic nodes, those that are not fixed, in a force on a node of the boundary.
using Shares = std::vector<std::pair<std::uint32_t, double>>;

/// One entry for each node of the boundary that is not fixed, ascending.
std::vector<std::pair<std::uint32_t, Shares>> tractions(const Elasticity& body, const TriangleMesh& boundary) {
  std::map<std::uint32_t, std::map<std::uint32_t, double>> sums;
  std::map<std::uint32_t, double> area;
  for (std::size_t t = 0; t < boundary.triangles.size(); ++t) {
    const Triangle& c = boundary.triangles[t];
    const double size = (boundary.corner(t, 1) - boundary.corner(t, 0)).cross(boundary.corner(t, 2) - boundary.corner(t, 0)).norm() / 2;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t own = c[k], b = c[(k + 1) % 3], d = c[(k + 2) % 3];
      if (body.isFixed(own)) continue;
      area[own] += size;
      std::map<std::uint32_t, double>& sum = sums[own];
      sum[own] += size * kOwnCorner;
      sum[b] += size * kOtherCorner;
      sum[d] += size * kOtherCorner;
      sum[body.nodes().middle(own, b)] += size * kNearMiddle;
      sum[body.nodes().middle(own, d)] += size * kNearMiddle;
      sum[body.nodes().middle(b, d)] += size * kFarMiddle;
    }
  }
  std::vector<std::pair<std::uint32_t, Shares>> all;
  for (const auto& [own, sum] : sums) {
    Shares& shares = all.emplace_back(own, Shares{}).second;
    for (const auto& [node, weight] : sum)
      if (!body.isFixed(node)) shares.emplace_back(node, weight / (area[own] / 3));
  }
  return all;
}

using Columns = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

}  // namespace

TissueResponse surfaceResponse(const Elasticity& body, const TriangleMesh& boundary, Progress& progress) {
  TissueResponse response;
  const std::vector<std::pair<std::uint32_t, Shares>> forces = tractions(body, boundary);
  const std::size_t rows = 3 * forces.size();
  if (rows * rows * sizeof(float) > kMostResponseBytes) return response;
  for (const auto& [node, shares] : forces) response.pressed.push_back(node);
  response.matrix.assign(rows * rows, 0);
  tbb::parallel_for(std::size_t{0}, (forces.size() + kNodesAtATime - 1) / kNodesAtATime, [&](std::size_t batch) {
    progress.check();
    const std::size_t first = batch * kNodesAtATime, count = std::min(kNodesAtATime, forces.size() - first);
    Columns columns = Columns::Zero(static_cast<Eigen::Index>(body.unknowns()), static_cast<Eigen::Index>(3 * count));
    for (std::size_t i = 0; i < count; ++i)
      for (const auto& [node, share] : forces[first + i].second)
        for (int axis = 0; axis < 3; ++axis) columns(body.unknown(node) + axis, static_cast<Eigen::Index>(3 * i) + axis) += share;
    body.solve(columns);
    for (std::size_t row = 0; row < rows; ++row)
      for (std::size_t j = 0; j < 3 * count; ++j) {
        double sum = 0;
        for (const auto& [node, share] : forces[row / 3].second)
          sum += share * columns(body.unknown(node) + static_cast<Eigen::Index>(row % 3), static_cast<Eigen::Index>(j));
        response.matrix[(3 * first + j) * rows + row] = static_cast<float>(sum);
      }
  });
  return response;
}

std::vector<PressPoint> pressPoints(const TriangleMesh& boundary, std::span<const LeafAnchor> anchors,
                                    std::span<const TissueVertex> surface, const Vector3d& origin, std::span<const std::uint32_t> pressed) {
  const DistanceField field(boundary);
  std::vector<PressPoint> points;
  for (const LeafAnchor& anchor : anchors) {
    const auto at = [&](std::size_t k) {
      const auto& p = surface[anchor.vertex[k]].rest;
      return Vector3d(Vector3d(p[0], p[1], p[2]) + origin);
    };
    const double u = static_cast<double>(anchor.weight[0]), v = static_cast<double>(anchor.weight[1]);
    const NearestPoint nearest = field.nearest((1 - u - v) * at(0) + u * at(1) + v * at(2));
    const Triangle& c = boundary.triangles[nearest.triangle];
    Eigen::Matrix<double, 3, 2> edges;
    edges << boundary.positions[c[1]] - boundary.positions[c[0]], boundary.positions[c[2]] - boundary.positions[c[0]];
    const Eigen::Vector2d w = edges.colPivHouseholderQr().solve(nearest.point - boundary.positions[c[0]]);
    const Vector3d weight = Vector3d(1 - w.sum(), w.x(), w.y()).cwiseMax(0).cwiseMin(1);
    PressPoint point{};
    for (std::size_t k = 0; k < 3; ++k) {
      const auto found = std::lower_bound(pressed.begin(), pressed.end(), c[k]);
      point.node[k] = found != pressed.end() && *found == c[k] ? static_cast<std::uint32_t>(found - pressed.begin()) : kHeldNode;
      point.weight[k] = static_cast<float>(weight[static_cast<Eigen::Index>(k)] / weight.sum());
    }
    points.push_back(point);
  }
  return points;
}

}  // namespace spheretree::builder
