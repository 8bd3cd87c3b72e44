// SPDX-License-Identifier: Apache-2.0
#include "cut/cut_lattice.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "kernel/lanes.h"

namespace spheretree::runtime {
namespace {

using Eigen::Vector3d;

std::size_t hashOf(const BlockPlace& p) {
  const auto part = [](std::int32_t v, std::uint64_t by) { return static_cast<std::uint64_t>(static_cast<std::uint32_t>(v)) * by; };
  const std::uint64_t mixed = part(p[0], 0x9e3779b97f4a7c15u) ^ part(p[1], 0xc2b2ae3d27d4eb4fu) ^ part(p[2], 0x165667b19e3779f9u);
  return static_cast<std::size_t>(mixed ^ mixed >> 29);
}

}  // namespace

CutLattice::CutLattice(double spacing, double reach, std::size_t max_blocks, const CutKernel& kernel)
    : kernel_(kernel), spacing_(spacing), reach_(reach), table_(4 * std::bit_ceil(max_blocks)), blocks_(max_blocks) {
  for (CutBlock& block : blocks_) block.wall.reserve(kBlockPoints);
}

std::size_t CutLattice::byteCount() const {
  return table_.size() * sizeof(Entry) + blocks_.size() * (sizeof(CutBlock) + kBlockPoints * sizeof(Sphere));
}

CutLattice::Entry& CutLattice::entryOf(const BlockPlace& place) {
  return const_cast<Entry&>(static_cast<const CutLattice*>(this)->entryOf(place));
}

const CutLattice::Entry& CutLattice::entryOf(const BlockPlace& place) const {
  std::size_t at = hashOf(place) & (table_.size() - 1);
  for (;; at = (at + 1) & (table_.size() - 1)) {
    const Entry& entry = table_[at];
    if (entry.index == kUnknown || (entry.place[0] == place[0] && entry.place[1] == place[1] && entry.place[2] == place[2])) return entry;
  }
}

std::int32_t CutLattice::find(const BlockPlace& place) const { return entryOf(place).index; }

CutBlock* CutLattice::add(const BlockPlace& place) {
  if (count_ == blocks_.size()) return nullptr;
  Entry& entry = entryOf(place);
  entry = {place, static_cast<std::int32_t>(count_)};
  ++entry_count_;
  CutBlock& block = blocks_[count_++];
  block.place = place;
  block.is_cut = false;
  block.wall_sum = -1;
  block.wall.clear();
  std::fill_n(block.clearance, kBlockPoints, static_cast<float>(reach_));
  std::fill_n(block.row_most, kBlockPoints / 8, static_cast<float>(reach_));
  return &block;
}

void CutLattice::addOutside(const BlockPlace& place) {
  if (2 * entry_count_ > table_.size()) return;  // it is asked for again
  entryOf(place) = {place, kOutside};
  ++entry_count_;
}

void CutLattice::clear() {
  std::fill(table_.begin(), table_.end(), Entry{});
  entry_count_ = count_ = 0;
  is_cut_ = false;
}

Vector3d CutLattice::cornerOf(const BlockPlace& place) const {
  return 8 * spacing_ * Vector3d(static_cast<double>(place[0]), static_cast<double>(place[1]), static_cast<double>(place[2]));
}

Vector3d CutLattice::middleOf(const BlockPlace& place) const { return cornerOf(place) + Vector3d::Constant(3.5 * spacing_); }

double CutLattice::blockRadius() const { return 3.5 * std::sqrt(3.0) * spacing_ * (1 + 1e-6); }

BlockPlace CutLattice::placeOf(const Vector3d& point) const {
  BlockPlace place;
  for (std::size_t k = 0; k < 3; ++k)
    place[k] = static_cast<std::int32_t>(std::floor(point[static_cast<Eigen::Index>(k)] / (8 * spacing_)));
  return place;
}

Material CutLattice::at(const Vector3d& point) const {
  std::int32_t low[3];
  float share[3];
  for (int k = 0; k < 3; ++k) {
    const double q = point[k] / spacing_, floor = std::floor(q);
    low[k] = static_cast<std::int32_t>(floor);
    share[k] = static_cast<float>(q - floor);
  }
  const float x[2] = {1 - share[0], share[0]}, y[2] = {1 - share[1], share[1]}, z[2] = {1 - share[2], share[2]};
  const bool is_in_one = (low[0] & 7) < 7 && (low[1] & 7) < 7 && (low[2] & 7) < 7;  // of two thirds of all points
  Material sum{0, 0};
  const CutBlock* block = nullptr;
  for (int corner = 0; corner < 8; ++corner) {
    const std::int32_t at[3] = {low[0] + (corner & 1), low[1] + (corner >> 1 & 1), low[2] + (corner >> 2)};
    if (corner == 0 || !is_in_one) {
      const std::int32_t index = find({at[0] >> 3, at[1] >> 3, at[2] >> 3});  // rounds down
      block = index >= 0 ? &blocks_[static_cast<std::size_t>(index)] : nullptr;
    }
    const float weight = x[corner & 1] * y[corner >> 1 & 1] * z[corner >> 2];
    const auto point_index = static_cast<std::size_t>((at[0] & 7) | (at[1] & 7) << 3 | (at[2] & 7) << 6);
    sum.depth += weight * (block ? block->depth[point_index] : -static_cast<float>(reach_));
    sum.clearance += weight * (block ? block->clearance[point_index] : static_cast<float>(reach_));
  }
  return sum;
}

double CutLattice::distanceFromCut(const Vector3d& point) const {
  if (!is_cut_) return std::numeric_limits<double>::infinity();
  const Vector3d low = cornerOf(cut_low_), high = cornerOf(cut_high_) + Vector3d::Constant(8 * spacing_);
  return (point - point.cwiseMax(low).cwiseMin(high)).norm();
}

std::uint8_t CutLattice::layerAt(const Vector3d& point) const {
  BlockPlace place;
  std::size_t point_index = 0;
  for (int k = 0; k < 3; ++k) {
    const auto at = static_cast<std::int32_t>(std::lround(point[k] / spacing_));
    place[static_cast<std::size_t>(k)] = at >> 3;
    point_index |= static_cast<std::size_t>(at & 7) << 3 * k;
  }
  const std::int32_t index = find(place);
  return index >= 0 ? blocks_[static_cast<std::size_t>(index)].layer[point_index] : std::uint8_t{0};
}

std::uint32_t CutLattice::remove(const Vector3d& from, const Vector3d& to, double radius, std::span<double> volume) {
  const double far = radius + reach_;
  const BlockPlace low = placeOf(from.cwiseMin(to) - Vector3d::Constant(far)), high = placeOf(from.cwiseMax(to) + Vector3d::Constant(far));
  const Vector3d way = to - from;
  const double square = way.squaredNorm();
  CutRequest request{};
  for (int k = 0; k < 3; ++k) request.way[k] = static_cast<float>(way[k]);
  request.inverse_square = square > 1e-30 ? static_cast<float>(1 / square) : 0.0f;
  request.radius = static_cast<float>(radius);
  request.spacing = static_cast<float>(spacing_);
  request.volume = volume.data();
  std::uint32_t work = 0;
  BlockPlace place;
  for (place[2] = low[2]; place[2] <= high[2]; ++place[2])
    for (place[1] = low[1]; place[1] <= high[1]; ++place[1])
      for (place[0] = low[0]; place[0] <= high[0]; ++place[0]) {
        const std::int32_t index = find(place);
        if (index < 0) continue;
        const Vector3d middle = middleOf(place) - from;
        const double along = square > 0 ? std::clamp(middle.dot(way) / square, 0.0, 1.0) : 0;
        if ((middle - along * way).norm() > far + blockRadius()) continue;
        CutBlock& block = blocks_[static_cast<std::size_t>(index)];
        block.is_cut = true;
        for (std::size_t k = 0; k < 3; ++k) {
          cut_low_[k] = is_cut_ ? std::min(cut_low_[k], place[k]) : place[k];
          cut_high_[k] = is_cut_ ? std::max(cut_high_[k], place[k]) : place[k];
        }
        is_cut_ = true;
        const Vector3d corner = cornerOf(place) - from;  // small numbers, so that floats are exact enough
        for (int k = 0; k < 3; ++k) request.corner[k] = static_cast<float>(corner[k]);
        request.clearance = block.clearance;
        request.row_most = block.row_most;
        request.depth = block.depth;
        request.layer = block.layer;
        kernel_.cutBlock(request);
        work += kBlockPoints / 8;
      }
  return work;
}

const std::vector<Sphere>& CutLattice::wallOf(std::size_t index) {
  CutBlock& block = blocks_[index];
  F8 sums = splat(0);
  for (std::size_t first = 0; first < kBlockPoints; first += 8) sums += load(block.clearance + first);
  float sum = 0;
  for (unsigned k = 0; k < 8; ++k) sum += sums[k];
  if (sum == block.wall_sum) return block.wall;  // clearances only become smaller
  block.wall_sum = sum;
  block.wall.clear();
  const F8 zero = splat(0), largest = splat(static_cast<float>(largestWallBall()));
  const Vector3d corner = cornerOf(block.place);
  for (std::size_t first = 0; first < kBlockPoints; first += 8) {
    const F8 clearance = load(block.clearance + first),
             radius = minOf(clearance, load(block.depth + first)) - splat(static_cast<float>(kPlay));
    for (unsigned lanes = maskOf((radius > zero) & (clearance <= largest)); lanes; lanes &= lanes - 1) {
      const auto lane = static_cast<unsigned>(__builtin_ctz(lanes));
      block.wall.push_back({static_cast<float>(corner[0] + spacing_ * lane),
                            static_cast<float>(corner[1] + spacing_ * static_cast<double>(first >> 3 & 7)),
                            static_cast<float>(corner[2] + spacing_ * static_cast<double>(first >> 6)), radius[lane]});
    }
  }
  return block.wall;
}

}  // namespace spheretree::runtime
