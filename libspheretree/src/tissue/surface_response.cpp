// SPDX-License-Identifier: GPL-3.0-or-later
#include "tissue/surface_response.h"

#include <tbb/parallel_for.h>

#include <Eigen/QR>
#include <algorithm>

#include "geometry/distance_field.h"
#include "spheretree/core/rounding.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr std::size_t kNodesAtATime = 8;  // three right-hand sides each: a row of them fills three cache lines

using Columns = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

}  // namespace

TissueResponse surfaceResponse(const Elasticity& body, const TriangleMesh& boundary, Progress& progress) {
  TissueResponse response;
  for (const Triangle& t : boundary.triangles)
    for (const std::uint32_t node : t)
      if (!body.isFixed(node)) response.pressed.push_back(node);
  std::sort(response.pressed.begin(), response.pressed.end());
  response.pressed.erase(std::unique(response.pressed.begin(), response.pressed.end()), response.pressed.end());
  const std::vector<std::uint32_t>& pressed = response.pressed;
  const std::size_t rows = 3 * pressed.size();
  if (rows * rows * sizeof(float) > kMaxResponseBytes) return {};
  response.matrix.assign(rows * rows, 0);
  tbb::parallel_for(std::size_t{0}, (pressed.size() + kNodesAtATime - 1) / kNodesAtATime, [&](std::size_t batch) {
    progress.check();
    const std::size_t first = batch * kNodesAtATime, count = std::min(kNodesAtATime, pressed.size() - first);
    Columns columns = Columns::Zero(static_cast<Eigen::Index>(body.unknowns()), static_cast<Eigen::Index>(3 * count));
    for (std::size_t j = 0; j < 3 * count; ++j)
      columns(body.unknown(pressed[first + j / 3]) + static_cast<Eigen::Index>(j % 3), static_cast<Eigen::Index>(j)) = 1;
    body.solve(columns);
    for (std::size_t row = 0; row < rows; ++row)
      for (std::size_t j = 0; j < 3 * count; ++j)
        response.matrix[(3 * first + j) * rows + row] =
            roundToFloat(columns(body.unknown(pressed[row / 3]) + static_cast<Eigen::Index>(row % 3), static_cast<Eigen::Index>(j)));
  });
  return response;
}

std::vector<PressPoint> pressPoints(const TriangleMesh& boundary, const Skin& skin, const Vector3d& origin,
                                    std::span<const std::uint32_t> pressed) {
  const DistanceField field(boundary);
  std::vector<PressPoint> points;
  points.reserve(skin.vertices.size() + skin.edges.size());
  const SkinNodes nodes(skin);
  std::vector<Eigen::Vector3f> places;
  for (const SkinNode& vertex : nodes.ofVertices()) places.push_back(vertex.position);
  places.resize(places.size() + skin.edges.size());
  for (const SkinTriangle& t : skin.triangles)
    for (std::size_t k = 0; k < 3; ++k)
      places[skin.vertices.size() + t.edge[k]] =
          0.5f * (places[t.vertex[k]] + places[t.vertex[(k + 1) % 3]]) + nodes.ofEdges()[t.edge[k]].position;
  for (const Eigen::Vector3f& place : places) {
    const NearestPoint nearest = field.nearest(place.cast<double>() + origin);
    const Triangle& c = boundary.triangles[nearest.triangle];
    Eigen::Matrix<double, 3, 2> edges;
    edges << boundary.positions[c[1]] - boundary.positions[c[0]], boundary.positions[c[2]] - boundary.positions[c[0]];
    const Eigen::Vector2d w = edges.colPivHouseholderQr().solve(nearest.point - boundary.positions[c[0]]);
    const Vector3d weight = Vector3d(1 - w.sum(), w.x(), w.y()).cwiseMax(0).cwiseMin(1);
    PressPoint point{};
    for (std::size_t k = 0; k < 3; ++k) {
      const auto found = std::lower_bound(pressed.begin(), pressed.end(), c[k]);
      point.node[k] = found != pressed.end() && *found == c[k] ? static_cast<std::uint32_t>(found - pressed.begin()) : kNone;
      point.weight[k] = roundToFloat(weight[static_cast<Eigen::Index>(k)] / weight.sum());
    }
    points.push_back(point);
  }
  return points;
}

}  // namespace spheretree::builder
