// SPDX-License-Identifier: GPL-3.0-or-later
#include "measure/evaluate_skin.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "geometry/farthest_point.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

constexpr double kOfStated = 0.25;   // share of the distance that a skin states: absolute accuracy of the bounds
constexpr double kMinGap = 1e-7;     // as a share of the diagonal, if the skin states no distance
constexpr std::size_t kRecord = 48;  // bytes of a section SKIN without its arrays
constexpr std::size_t kVertex = 12;  // bytes of a vertex there

double angleBetween(const Vector3d& a, const Vector3d& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

// The angles between flat triangles over each shared side that is not sharp; sorted.
std::vector<double> facetAngles(const Skin& skin, const TriangleMesh& flat) {
  std::vector<Vector3d> first(skin.edges.size(), Vector3d::Zero());
  std::vector<double> angles;
  for (std::size_t t = 0; t < skin.triangles.size(); ++t) {
    const Vector3d n = (flat.corner(t, 1) - flat.corner(t, 0)).cross(flat.corner(t, 2) - flat.corner(t, 0));
    for (const std::uint16_t e : skin.triangles[t].edge) {
      if (skin.edges[e].is_sharp != 0 || n.isZero(0)) continue;
      if (first[e].isZero(0))
        first[e] = n;
      else
        angles.push_back(angleBetween(first[e], n));
    }
  }
  std::sort(angles.begin(), angles.end());
  return angles;
}

}  // namespace

TriangleMesh flatTriangles(const Skin& skin, const Vector3d& origin) {
  TriangleMesh flat;
  flat.positions.resize(skin.vertices.size());
  for (std::size_t t = 0; t < skin.triangles.size(); ++t) {
    const SkinPatch patch = patchOf(skin, t);
    Triangle triangle{};
    for (std::size_t k = 0; k < 3; ++k) {
      triangle[k] = skin.triangles[t].vertex[k];
      flat.positions[triangle[k]] = patch.position[k].cast<double>() + origin;
    }
    flat.triangles.push_back(triangle);
  }
  return flat;
}

SkinEvaluation skinFigures(const Skin& skin) {
  SkinEvaluation out;
  out.triangles = skin.triangles.size();
  out.vertices = skin.vertices.size();
  out.edges = skin.edges.size();
  out.sharp_edges =
      static_cast<std::size_t>(std::count_if(skin.edges.begin(), skin.edges.end(), [](const SkinEdge& e) { return e.is_sharp != 0; }));
  out.bytes = kRecord + skin.triangles.size() * sizeof(SkinTriangle) + skin.vertices.size() * kVertex +
              skin.edges.size() * sizeof(SkinEdge) + skin.search.inner.size() * (sizeof(Sphere) + 1);
  out.tolerance = static_cast<double>(skin.tolerance);
  out.mesh_distance = static_cast<double>(skin.mesh_distance);
  out.crease_angle = static_cast<double>(skin.crease_angle);
  for (std::size_t t = 0; t < skin.triangles.size(); ++t)
    if (allowanceOf(patchOf(skin, t), 1) == 0) ++out.flat_triangles;
  const std::vector<double> angles = facetAngles(skin, flatTriangles(skin, Vector3d::Zero()));
  if (angles.empty()) return out;
  const auto at = [&](double share) { return angles[static_cast<std::size_t>(share * static_cast<double>(angles.size() - 1))]; };
  out.edge_angle_median = at(0.5), out.edge_angle_p99 = at(0.99), out.edge_angle_max = angles.back();
  return out;
}

SkinEvaluation evaluateSkin(const Skin& skin, const Vector3d& origin, const TriangleMesh& mesh, const DistanceField& field,
                            Progress& progress) {
  SkinEvaluation out = skinFigures(skin);
  const TriangleMesh flat = flatTriangles(skin, origin);
  const double target = std::max(kOfStated * out.mesh_distance, kMinGap * field.diagonal());
  const auto all = [](const TriangleMesh& m) {
    std::vector<std::uint32_t> list(m.triangles.size());
    std::iota(list.begin(), list.end(), 0u);
    return list;
  };
  out.from_mesh = farthestFrom(field, flat, all(flat), target, progress);
  out.of_mesh = farthestFrom(DistanceField(flat), mesh, all(mesh), target, progress);
  return out;
}

}  // namespace spheretree::builder
