// SPDX-License-Identifier: GPL-3.0-or-later
#include "split/inward_steps.h"

#include <Eigen/Geometry>
#include <array>

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr double kStep = 0.5;      // length of the first straight part of a wall, in mean border edges
constexpr int kWayRounds = 4;      // rounds of smoothing the directions of these parts
constexpr double kMinShare = 0.5;  // smallest remaining share of the slope of the bisecting direction after smoothing

using PlanePair = std::array<Vector3d, 2>;  // normals of the planes at a vertex: the first one, and the one that differs most from it

/// The planes of the triangles at each step; `step_of` a vertex is the index of its step or kNone.
std::vector<PlanePair> planesAt(const TriangleMesh& mesh, const std::vector<std::uint32_t>& step_of, std::size_t count) {
  std::vector<PlanePair> planes(count, {Vector3d::Zero(), Vector3d::Zero()});
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t i = step_of[mesh.triangles[t][static_cast<std::size_t>(k)]];
      if (i == kNone) continue;
      const Vector3d a = mesh.corner(t, (k + 1) % 3) - mesh.corner(t, k), b = mesh.corner(t, (k + 2) % 3) - mesh.corner(t, k);
      const Vector3d normal = a.cross(b).normalized();
      if (!normal.allFinite()) continue;
      if (planes[i][0].isZero()) planes[i] = {normal, normal};
      if (normal.dot(planes[i][0]) < planes[i][1].dot(planes[i][0])) planes[i][1] = normal;
    }
  return planes;
}

/// Smooths the directions along `edges`, which join steps. Each keeps a share of its slope into both of its planes.
void smoothDirections(std::vector<InwardStep>& steps, const std::vector<std::array<std::uint32_t, 2>>& edges,
                      const std::vector<PlanePair>& planes) {
  const std::vector<InwardStep> straight = steps;
  std::vector<Vector3d> sum(steps.size());
  for (int round = 0; round < kWayRounds; ++round) {
    for (std::size_t i = 0; i < steps.size(); ++i) sum[i] = steps[i].direction;
    for (const auto& [a, b] : edges) sum[a] += steps[b].direction, sum[b] += steps[a].direction;
    for (std::size_t i = 0; i < steps.size(); ++i) {
      Vector3d& way = steps[i].direction;
      const double smallest = kMinShare * straight[i].direction.dot(planes[i][0]);
      for (const double share : {0.0, 0.25, 0.5, 0.75, 1.0}) {
        way = ((1 - share) * sum[i].normalized() + share * straight[i].direction).normalized();
        if (way.dot(planes[i][0]) <= smallest && way.dot(planes[i][1]) <= smallest) break;
      }
    }
  }
}

}  // namespace

std::vector<InwardStep> findInwardSteps(const TriangleMesh& mesh, const RegionBorders& borders, const Vector3d& up) {
  std::vector<InwardStep> steps;
  std::vector<std::uint32_t> step_of(mesh.positions.size(), kNone);
  const auto stepAt = [&](std::uint32_t v) {
    if (step_of[v] == kNone) {
      step_of[v] = static_cast<std::uint32_t>(steps.size());
      steps.push_back({v, 0, Vector3d::Zero()});
    }
    return step_of[v];
  };
  std::vector<std::array<std::uint32_t, 2>> edges;
  double length = 0;
  for (std::int32_t region = 1; region < borders.regionCount(); ++region)
    for (const BorderEdge& e : borders.edgesOf(region)) {
      const std::uint32_t from = stepAt(e.from), to = stepAt(e.to);
      edges.push_back({from, to});
      length += (mesh.positions[e.to] - mesh.positions[e.from]).norm();
    }
  const std::vector<PlanePair> planes = planesAt(mesh, step_of, steps.size());
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const Vector3d sum = planes[i][0] + planes[i][1];
    steps[i].length = kStep * length / static_cast<double>(edges.size());
    steps[i].direction = sum.norm() > 0 ? Vector3d(-sum.normalized()) : Vector3d(-up);
  }
  smoothDirections(steps, edges, planes);
  return steps;
}

}  // namespace spheretree::builder
