// SPDX-License-Identifier: GPL-3.0-or-later
#include "spheretree/builder/reachable_space.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "geometry/distance_field.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr double kCellsAcross = 400;  // number of cells along the scene's diagonal
constexpr int kBlock = 32;            // number of cells along a side of the block that one task fills

// Signed distance to the union of solids: exact outside; inside at most that of the solid in which the point is
// deepest.
class Union {
 public:
  explicit Union(std::span<const TriangleMesh> solids) {
    for (const TriangleMesh& mesh : solids) fields_.emplace_back(mesh);
  }
  double signedDistance(const Vector3d& p) const {
    double smallest = std::numeric_limits<double>::infinity();
    for (const DistanceField& field : fields_)
      if (field.box().exteriorDistance(p) <= std::max(smallest, 0.0)) smallest = std::min(smallest, field.signedDistance(p));
    return smallest;
  }
  Eigen::AlignedBox3d box() const {
    Eigen::AlignedBox3d all;
    for (const DistanceField& field : fields_) all.extend(field.box());
    return all;
  }

 private:
  std::vector<DistanceField> fields_;
};

}  // namespace

ReachableSpace::ReachableSpace(std::span<const TriangleMesh> solids, double radius, Progress& progress) : radius_(radius) {
  if (solids.empty() || !(radius > 0)) throw std::invalid_argument("reachable space: no solids, or a radius that is not above 0");
  const Union all(solids);
  const Eigen::AlignedBox3d box = all.box();
  cell_ = std::max(radius / 2, box.diagonal().norm() / kCellsAcross);
  const double half_diagonal = cell_ * std::sqrt(3.0) / 2;
  low_ = box.min() - Vector3d::Constant(radius + 2 * cell_);
  for (std::size_t axis = 0; axis < 3; ++axis)
    cells_[axis] =
        static_cast<int>(std::ceil((box.max()[static_cast<Eigen::Index>(axis)] - low_[static_cast<Eigen::Index>(axis)] + radius) / cell_)) +
        2;
  state_.assign(index(0, 0, cells_[2]), kBlocked);

  // A cell is free if the ball's centre may be anywhere in it. The distance to the solids is 1-Lipschitz, so one query
  // at the middle decides most cubes of cells.
  const auto fill = [&](auto&& self, std::array<int, 3> at, int size) -> void {
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (at[axis] >= cells_[axis]) return;
    const Vector3d middle = low_ + cell_ * (Vector3d(at[0], at[1], at[2]) + Vector3d::Constant(0.5 * size));
    const double distance = all.signedDistance(middle), reach = half_diagonal * size;
    const bool is_free = distance - reach >= radius_, is_blocked = distance + reach < radius_;
    if (!is_free && !is_blocked && size > 1) {
      for (int part = 0; part < 8; ++part)
        self(self, {at[0] + (part & 1) * size / 2, at[1] + (part >> 1 & 1) * size / 2, at[2] + (part >> 2) * size / 2}, size / 2);
      return;
    }
    if (is_blocked) return;
    for (int z = at[2]; z < std::min(at[2] + size, cells_[2]); ++z)
      for (int y = at[1]; y < std::min(at[1] + size, cells_[1]); ++y)
        for (int x = at[0]; x < std::min(at[0] + size, cells_[0]); ++x) state_[index(x, y, z)] = kFree;
  };
  std::vector<std::array<int, 3>> blocks;
  for (int z = 0; z < cells_[2]; z += kBlock)
    for (int y = 0; y < cells_[1]; y += kBlock)
      for (int x = 0; x < cells_[0]; x += kBlock) blocks.push_back({x, y, z});
  tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t i) {
    if (!progress.cancelled()) fill(fill, blocks[i], kBlock);
  });
  progress.check();
  flood();
}

// From the corner cell, which is outside the box of the solids, to every free cell that touches a reached cell.
void ReachableSpace::flood() {
  std::vector<std::array<int, 3>> open{{0, 0, 0}};
  state_[0] = kReached;
  while (!open.empty()) {
    const std::array<int, 3> at = open.back();
    open.pop_back();
    for (int z = std::max(at[2] - 1, 0); z <= std::min(at[2] + 1, cells_[2] - 1); ++z)
      for (int y = std::max(at[1] - 1, 0); y <= std::min(at[1] + 1, cells_[1] - 1); ++y)
        for (int x = std::max(at[0] - 1, 0); x <= std::min(at[0] + 1, cells_[0] - 1); ++x) {
          std::uint8_t& state = state_[index(x, y, z)];
          if (state != kFree) continue;
          state = kReached;
          open.push_back({x, y, z});
        }
  }
}

std::vector<char> ReachableSpace::reached(const TriangleMesh& mesh) const {
  const double reach = radius_ + cell_ * std::sqrt(3.0) / 2;
  std::vector<char> out(mesh.triangles.size(), 0);
  tbb::parallel_for(std::size_t{0}, out.size(), [&](std::size_t t) {
    const Vector3d &a = mesh.corner(t, 0), &b = mesh.corner(t, 1), &c = mesh.corner(t, 2);
    const Vector3d low = a.cwiseMin(b).cwiseMin(c) - Vector3d::Constant(reach),
                   high = a.cwiseMax(b).cwiseMax(c) + Vector3d::Constant(reach);
    std::array<int, 3> first, last;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto i = static_cast<Eigen::Index>(axis);
      first[axis] = std::clamp(static_cast<int>(std::floor((low[i] - low_[i]) / cell_)), 0, cells_[axis] - 1);
      last[axis] = std::clamp(static_cast<int>(std::floor((high[i] - low_[i]) / cell_)), 0, cells_[axis] - 1);
    }
    for (int z = first[2]; z <= last[2]; ++z)
      for (int y = first[1]; y <= last[1]; ++y)
        for (int x = first[0]; x <= last[0]; ++x)
          if (state_[index(x, y, z)] == kReached && nearestOnTriangle(centre(x, y, z), a, b, c).distance <= reach) {
            out[t] = 1;
            return;
          }
  });
  return out;
}

}  // namespace spheretree::builder
