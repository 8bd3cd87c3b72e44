// SPDX-License-Identifier: GPL-3.0-or-later
#include "model/moved_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

namespace spheretree::view {
namespace {

using Eigen::Vector3f;

Vector3f placeOf(const TissueVertex& v) { return Eigen::Vector3d(v.rest.data()).cast<float>(); }

/// A vertex of the tissue at `p`, or the nearest one.
std::uint32_t nearestVertex(const Vector3f& p, const std::vector<TissueVertex>& surface) {
  std::uint32_t nearest = 0;
  float smallest = std::numeric_limits<float>::infinity();
  for (std::uint32_t v = 0; v < surface.size(); ++v)
    if (const float square = (placeOf(surface[v]) - p).squaredNorm(); square < smallest) smallest = square, nearest = v;
  return nearest;
}

}  // namespace

MovedSurface::MovedSurface(const Surface& rest, std::shared_ptr<const Tissue> tissue) : rest_(rest), tissue_(std::move(tissue)) {
  std::map<std::array<float, 3>, std::uint32_t> at;
  for (std::uint32_t v = 0; v < tissue_->surface.size(); ++v) {
    const Vector3f p = placeOf(tissue_->surface[v]);
    at.try_emplace({p.x(), p.y(), p.z()}, v);
  }
  for (const SurfaceCorner& corner : rest_.corners) {
    const std::array<float, 3> p{corner.position.x(), corner.position.y(), corner.position.z()};
    const auto [found, is_new] = at.try_emplace(p, 0);
    if (is_new) found->second = nearestVertex(corner.position, tissue_->surface);
    vertex_.push_back(found->second);
  }
}

TintedSurface MovedSurface::at(std::span<const Vector3f> displacements, Colour colour) const {
  TintedSurface out{rest_, {}};
  std::vector<Vector3f> ways;
  for (const TissueVertex& v : tissue_->surface) {
    const std::array<std::uint32_t, 4>& c = tissue_->tetrahedra[v.tetrahedron];
    const float last = 1 - v.weight[0] - v.weight[1] - v.weight[2];
    ways.emplace_back(v.weight[0] * displacements[c[0]] + v.weight[1] * displacements[c[1]] + v.weight[2] * displacements[c[2]] +
                      last * displacements[c[3]]);
  }
  std::vector<float> stretch(rest_.corners.size(), 0);
  for (std::size_t i = 0; i < rest_.corners.size(); ++i) {
    out.surface.corners[i].position += ways[vertex_[i]];
    out.surface.corners[i].normal.setZero();
  }
  for (std::size_t t = 0; t + 2 < rest_.indices.size(); t += 3) {
    const std::uint32_t* const c = rest_.indices.data() + t;
    const auto now = [&](std::size_t k) -> const Vector3f& { return out.surface.corners[c[k % 3]].position; };
    const auto before = [&](std::size_t k) -> const Vector3f& { return rest_.corners[c[k % 3]].position; };
    const Vector3f normal = (now(1) - now(0)).cross(now(2) - now(0));
    for (std::size_t k = 0; k < 3; ++k) {
      out.surface.corners[c[k]].normal += normal;
      const float length = (before(k + 1) - before(k)).norm();
      if (!(length > 0)) continue;
      const float change = std::abs((now(k + 1) - now(k)).norm() / length - 1);
      for (const std::size_t end : {k, (k + 1) % 3}) stretch[c[end]] = std::max(stretch[c[end]], change);
    }
  }
  for (std::size_t i = 0; i < rest_.corners.size(); ++i) {
    Vector3f& normal = out.surface.corners[i].normal;
    normal = normal.squaredNorm() > 0 ? normal.normalized() : rest_.corners[i].normal;
    const double share = std::min(1.0, static_cast<double>(stretch[i]) / kFullStretch);
    const Colour hot = heat(share);
    const double part = std::min(1.0, 4 * share);  // small stretches keep the colour of the body
    out.colours.push_back(mixed(colour, hot, part));
  }
  return out;
}

}  // namespace spheretree::view
