// SPDX-License-Identifier: Apache-2.0
#include "tissue/surface_response.h"

namespace spheretree::runtime {

using Eigen::Vector3d;

using Pair [[gnu::vector_size(16)]] = double;

SurfaceResponse::SurfaceResponse(const SoftModel& model)
    : model_(model),
      near_at_(model.node_count, ~0u),
      is_near_(model.vertices.size(), 0),
      predicted_(model.vertices.size(), Eigen::Vector3f::Zero()) {
  for (const SkinTriangle& t : model.tree->skin.triangles) corners_.push_back({t.vertex[0], t.vertex[1], t.vertex[2]});
  near_.reserve(model.node_count);
  near_vertices_.reserve(model.vertices.size());
}

SurfaceResponse::Press SurfaceResponse::pressOn(const SkinPoint& point) const {
  Press out;
  for (std::size_t k = 0; k < 3; ++k) {
    const PressPoint& vertex = model_.vertices[corners_[point.triangle][k]].point;
    for (std::size_t i = 0; i < 3; ++i) {
      const double weight = point.weight[k] * static_cast<double>(vertex.weight[i]);
      if (vertex.node[i] == kNone || !(weight > 0)) continue;
      std::size_t at = 0;
      while (at < out.count && out.node[at] != vertex.node[i]) ++at;
      if (at == out.count) {
        out.node[at] = vertex.node[i];
        out.weight[at] = 0;
        ++out.count;
      }
      out.weight[at] += weight;
    }
  }
  return out;
}

void SurfaceResponse::forgetNear() {
  for (const std::uint32_t node : near_) near_at_[node] = ~0u;
  for (const std::uint32_t v : near_vertices_) is_near_[v] = 0;
  near_.clear();
  near_vertices_.clear();
}

void SurfaceResponse::addNear(std::uint32_t triangle) {
  for (const std::uint32_t v : corners_[triangle]) {
    if (is_near_[v]) continue;
    is_near_[v] = 1;
    near_vertices_.push_back(v);
    for (const std::uint32_t node : model_.vertices[v].point.node) {
      if (node == kNone || near_at_[node] != ~0u) continue;
      near_at_[node] = static_cast<std::uint32_t>(near_.size());
      near_.push_back(node);
    }
  }
}

void SurfaceResponse::respond(const Press& press, std::span<Eigen::Matrix3d> near) const {
  for (std::size_t i = 0; i < near_.size(); ++i) {
    Pair xy[3] = {};
    double z[3] = {};
    for (std::size_t p = 0; p < press.count; ++p) {
      const Pair weight{press.weight[p], press.weight[p]};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const float* const u = model_.column(3 * std::size_t{press.node[p]} + axis) + 3 * std::size_t{near_[i]};
        xy[axis] += weight * Pair{static_cast<double>(u[0]), static_cast<double>(u[1])};
        z[axis] += weight[0] * static_cast<double>(u[2]);
      }
    }
    for (std::size_t axis = 0; axis < 3; ++axis) near[i].col(static_cast<Eigen::Index>(axis)) << xy[axis][0], xy[axis][1], z[axis];
  }
}

Vector3d SurfaceResponse::meanOf(const Press& of, std::span<const double> near) const {
  Vector3d sum = Vector3d::Zero();
  for (std::size_t p = 0; p < of.count; ++p) sum += of.weight[p] * Vector3d(near.data() + 3 * std::size_t{near_at_[of.node[p]]});
  return sum;
}

void SurfaceResponse::predict(std::span<const double> near) {
  for (const std::uint32_t v : near_vertices_) {
    const PressPoint& point = model_.vertices[v].point;
    Vector3d sum = Vector3d::Zero();
    for (std::size_t k = 0; k < 3; ++k)
      if (point.node[k] != kNone)
        sum += static_cast<double>(point.weight[k]) * Vector3d(near.data() + 3 * std::size_t{near_at_[point.node[k]]});
    predicted_[v] = sum.cast<float>();
  }
}

Vector3d SurfaceResponse::predicted(const SkinPoint& point) const {
  Vector3d sum = Vector3d::Zero();
  for (std::size_t k = 0; k < 3; ++k) sum += point.weight[k] * predicted_[corners_[point.triangle][k]].cast<double>();
  return sum;
}

}  // namespace spheretree::runtime
