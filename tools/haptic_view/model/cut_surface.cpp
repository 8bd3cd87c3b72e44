// SPDX-License-Identifier: GPL-3.0-or-later
#include "model/cut_surface.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace spheretree::view {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr int kSide = CutBlock::kSide;
constexpr std::array<int, 3> kStride{1, kSide, kSide* kSide};  // from a point to the next along an axis

}  // namespace

/// A capsule.
struct CutSurface::Way {
  Vector3d from, along;
  double square, radius;
  /// From the nearest point of the way.
  Vector3d away(const Vector3d& p) const {
    const Vector3d from_begin = p - from;
    return from_begin - (square > 0 ? std::clamp(from_begin.dot(along) / square, 0.0, 1.0) : 0.0) * along;
  }
};

CutSurface::CutSurface(std::shared_ptr<const CutMaterial> material, double radius)
    // The spacing is near that of the runtime (docs/algorithms/runtime/cutting.md), whose burr waits when it has too
    // many blocks. It has more of them than this, so that this memory is bounded as well.
    : material_(std::move(material)), spacing_(std::clamp(radius / 10, 0.03, 0.1)), reach_(2 * spacing_) {}

double CutSurface::halfDiagonal() const { return std::sqrt(3.0) / 2 * (kSide - 1) * spacing_; }

Vector3d CutSurface::middleOf(const BlockPlace& place) const {
  return spacing_ * (CutBlock::kCells * Vector3d(place[0], place[1], place[2]).array() + 0.5 * (kSide - 1));
}

CutSurface::Entry CutSurface::entryAt(const BlockPlace& place) const {
  const double half_diagonal = halfDiagonal();
  const Vector3d middle = middleOf(place);
  if (material_->layers.front().depth(middle) < -half_diagonal) return {State::Outside};
  auto block = std::make_shared<CutBlock>();
  for (const CutMaterial::Layer& layer : material_->layers) {
    const double depth = layer.depth(middle);
    block->inside.push_back(depth > 0);
    block->met.push_back(std::abs(depth) <= half_diagonal);
  }
  block->meets_skin = block->met.front() != 0;
  block->distance.fill(static_cast<float>(reach_));
  block->most = static_cast<float>(reach_);
  for (auto& axis : block->away) axis.fill(0);
  return {State::Open, std::move(block)};
}

void CutSurface::remove(const Vector3d& from, const Vector3d& to, double radius) {
  const Way way{from, to - from, (to - from).squaredNorm(), radius};
  const double side = blockSide(), bound = radius + reach_, half_diagonal = halfDiagonal();
  // Far from the object, no block is asked for.
  if (material_->layers.front().depth((from + to) / 2) < -(bound + std::sqrt(way.square) / 2 + 2 * half_diagonal)) return;
  BlockPlace low, high;
  for (int k = 0; k < 3; ++k) {
    low[static_cast<std::size_t>(k)] = static_cast<std::int32_t>(std::floor((std::min(from[k], to[k]) - bound - spacing_) / side));
    high[static_cast<std::size_t>(k)] = static_cast<std::int32_t>(std::floor((std::max(from[k], to[k]) + bound) / side));
  }
  BlockPlace at;
  for (at[2] = low[2]; at[2] <= high[2]; ++at[2])
    for (at[1] = low[1]; at[1] <= high[1]; ++at[1])
      for (at[0] = low[0]; at[0] <= high[0]; ++at[0]) {
        const double distance = way.away(middleOf(at)).norm() - radius;
        if (distance - half_diagonal >= reach_) continue;
        auto found = blocks_.find(at);
        if (found == blocks_.end()) found = blocks_.emplace(at, entryAt(at)).first;
        Entry& entry = found->second;
        if (entry.state != State::Open) continue;
        if (distance + half_diagonal <= 0)
          entry = {State::Removed};
        else if (distance - half_diagonal < static_cast<double>(entry.block->most))
          removeFrom(entry, at, way);
      }
}

void CutSurface::removeFrom(Entry& entry, const BlockPlace& place, const Way& way) {
  CutBlock* block = entry.block.get();
  const float h = static_cast<float>(spacing_), radius = static_cast<float>(way.radius);
  // Relative to the first point of the block, where float has all its digits.
  const Vector3f from = (way.from - blockSide() * Vector3d(place[0], place[1], place[2])).cast<float>();
  const Vector3f along = way.along.cast<float>();
  const float share_of = way.square > 0 ? 1 / static_cast<float>(way.square) : 0;
  bool is_changed = false;
  std::size_t i = 0;
  for (int z = 0; z < kSide; ++z)
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x, ++i) {
        const float px = h * static_cast<float>(x) - from.x(), py = h * static_cast<float>(y) - from.y(),
                    pz = h * static_cast<float>(z) - from.z();
        const float share = std::clamp((px * along.x() + py * along.y() + pz * along.z()) * share_of, 0.0f, 1.0f);
        const float ax = px - share * along.x(), ay = py - share * along.y(), az = pz - share * along.z();
        const float square = ax * ax + ay * ay + az * az, limit = block->distance[i] + radius;
        if (!(limit > 0) || square >= limit * limit) continue;
        const float distance = std::sqrt(square) - radius;
        if (!(distance < block->distance[i])) continue;  // equal but for rounding
        if (!is_changed && entry.block.use_count() > 1) {
          entry.block = std::make_shared<CutBlock>(*block);
          block = entry.block.get();
        }
        is_changed = true;
        block->distance[i] = distance;
        block->away[0][i] = ax, block->away[1][i] = ay, block->away[2][i] = az;
      }
  if (!is_changed) return;
  block->is_stale = true;
  block->most = *std::max_element(block->distance.begin(), block->distance.end());
  if (block->most <= 0) entry = {State::Removed};
}

CutCorner CutSurface::cornerAt(const CutBlock& block, const Vector3d& position, const Vector3f& normal) const {
  CutCorner out{position.cast<float>(), normal, static_cast<float>(reach_), {}};
  // The surface of the object ends within the error of the interpolation, which this overlaps.
  const double overlap = spacing_ / 8;
  if (block.meets_skin) out.depth = static_cast<float>(material_->layers.front().depth(position) + overlap);
  if (out.depth < -static_cast<float>(reach_)) return out;  // never drawn
  for (std::size_t k = 0; k < material_->layers.size(); ++k) {
    const CutMaterial::Layer& layer = material_->layers[k];
    // The border of two layers is as wide as a cell, so that it is no staircase.
    double share = k == 0 || block.inside[k] ? 1 : 0;
    if (k > 0 && block.met[k]) share = std::clamp(0.5 + layer.depth(position) / spacing_, 0.0, 1.0);
    if (share > 0) out.colour = mixed(out.colour, layer.colour, share);
  }
  return out;
}

void CutSurface::makeWall(CutBlock& block, const BlockPlace& place) const {
  constexpr std::uint16_t kNone = 0xffff;
  block.is_stale = false;
  block.corners.clear();
  block.triangles.clear();
  const auto isRemoved = [&](int point) { return block.distance[static_cast<std::size_t>(point)] < 0; };
  std::array<std::uint16_t, CutBlock::kPoints> made;  // (first point of a cell) its corner of the wall
  made.fill(kNone);
  const auto addCorner = [&](int x, int y, int z) {
    const int first = x + kStride[1] * y + kStride[2] * z;
    Vector3d sum = Vector3d::Zero();
    Vector3f away = Vector3f::Zero();
    int crossings = 0;
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (int k = 0; k < 4; ++k) {  // the edges along this axis
        const std::size_t second = (axis + 1) % 3, third = (axis + 2) % 3;
        const int from = first + (k & 1) * kStride[second] + (k >> 1) * kStride[third], to = from + kStride[axis];
        if (isRemoved(from) == isRemoved(to)) continue;
        const auto i = static_cast<std::size_t>(from), j = static_cast<std::size_t>(to);
        const float share = block.distance[i] / (block.distance[i] - block.distance[j]);
        sum[static_cast<Eigen::Index>(axis)] += static_cast<double>(share);
        sum[static_cast<Eigen::Index>(second)] += k & 1;
        sum[static_cast<Eigen::Index>(third)] += k >> 1;
        for (Eigen::Index d = 0; d < 3; ++d) {
          const auto& all = block.away[static_cast<std::size_t>(d)];
          away[d] += (1 - share) * all[i] + share * all[j];
        }
        ++crossings;
      }
    if (crossings == 0) return;
    made[static_cast<std::size_t>(first)] = static_cast<std::uint16_t>(block.corners.size());
    const Vector3d in_block = Vector3d(x, y, z) + sum / crossings;
    block.corners.push_back(
        cornerAt(block, spacing_ * (in_block + CutBlock::kCells * Vector3d(place[0], place[1], place[2])), -away.normalized()));
  };
  for (int z = 0; z + 1 < kSide; ++z)
    for (int y = 0; y + 1 < kSide; ++y)
      for (int x = 0; x + 1 < kSide; ++x) addCorner(x, y, z);
  const auto addTriangle = [&](std::array<std::uint16_t, 3> t) {
    const CutCorner &a = block.corners[t[0]], &b = block.corners[t[1]], &c = block.corners[t[2]];
    if (std::max({a.depth, b.depth, c.depth}) < 0) return;
    if ((b.position - a.position).cross(c.position - a.position).dot(a.normal + b.normal + c.normal) < 0) std::swap(t[1], t[2]);
    block.triangles.insert(block.triangles.end(), t.begin(), t.end());
  };
  // About each edge that the wall crosses lie four cells; each edge of the lattice is in one block only.
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t second = (axis + 1) % 3, third = (axis + 2) % 3;
    for (int u = 0; u < CutBlock::kCells; ++u)
      for (int v = 1; v <= CutBlock::kCells; ++v)
        for (int w = 1; w <= CutBlock::kCells; ++w) {
          const int point = u * kStride[axis] + v * kStride[second] + w * kStride[third];
          if (isRemoved(point) == isRemoved(point + kStride[axis])) continue;
          const auto cornerOf = [&](int before, int below) {
            return made[static_cast<std::size_t>(point - before * kStride[second] - below * kStride[third])];
          };
          addTriangle({cornerOf(0, 0), cornerOf(1, 0), cornerOf(1, 1)});
          addTriangle({cornerOf(0, 0), cornerOf(1, 1), cornerOf(0, 1)});
        }
  }
}

const CutSurface::Blocks& CutSurface::blocks() const {
  for (const auto& [place, entry] : blocks_)
    if (entry.block && entry.block->is_stale) makeWall(*entry.block, place);
  return blocks_;
}

}  // namespace spheretree::view
