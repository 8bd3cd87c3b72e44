// SPDX-License-Identifier: Apache-2.0
#include "cut/cut_lattice.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

namespace spheretree::runtime {
namespace {

using Eigen::Vector3d;

std::size_t hashOf(const BlockPlace& p) {
  const auto part = [](std::int32_t v, std::uint64_t by) { return static_cast<std::uint64_t>(static_cast<std::uint32_t>(v)) * by; };
  const std::uint64_t mixed = part(p[0], 0x9e3779b97f4a7c15u) ^ part(p[1], 0xc2b2ae3d27d4eb4fu) ^ part(p[2], 0x165667b19e3779f9u);
  return static_cast<std::size_t>(mixed ^ mixed >> 29);
}

}  // namespace

CutStorage::CutStorage(std::size_t max_blocks) : table_(4 * std::bit_ceil(max_blocks)), blocks_(max_blocks) {}

void CutStorage::clear() {
  std::fill(table_.begin(), table_.end(), Entry{});
  entry_count_ = count_ = 0;
}

std::size_t CutStorage::entryOf(std::uint32_t lattice, const BlockPlace& place) const {
  std::size_t at = (hashOf(place) + lattice) & (table_.size() - 1);
  for (;; at = (at + 1) & (table_.size() - 1)) {
    const Entry& entry = table_[at];
    if (entry.index == kUnknown) return at;
    if (entry.lattice == lattice && entry.place[0] == place[0] && entry.place[1] == place[1] && entry.place[2] == place[2]) return at;
  }
}

std::int32_t CutStorage::find(std::uint32_t lattice, const BlockPlace& place) const { return table_[entryOf(lattice, place)].index; }

CutBlock* CutStorage::add(std::uint32_t lattice, const BlockPlace& place) {
  if (count_ == blocks_.size()) return nullptr;
  table_[entryOf(lattice, place)] = {place, lattice, static_cast<std::int32_t>(count_)};
  ++entry_count_;
  CutBlock& block = blocks_[count_++];
  block.place = place;
  block.lattice = lattice;
  block.is_cut = false;
  return &block;
}

void CutStorage::addOutside(std::uint32_t lattice, const BlockPlace& place) {
  if (2 * entry_count_ > table_.size()) return;  // it is asked for again
  table_[entryOf(lattice, place)] = {place, lattice, kOutside};
  ++entry_count_;
}

CutLattice::CutLattice(double spacing, double reach, std::uint32_t number, CutStorage& storage, const CutKernel& kernel)
    : storage_(storage), kernel_(kernel), number_(number), spacing_(spacing), reach_(reach) {}

CutBlock* CutLattice::add(const BlockPlace& place) {
  CutBlock* const block = storage_.add(number_, place);
  if (!block) return nullptr;
  std::fill_n(block->clearance, kBlockPoints, static_cast<float>(reach_));
  std::fill_n(block->row_most, kBlockPoints / 8, static_cast<float>(reach_));
  std::fill_n(block->wall, kBlockPoints / 8, std::uint8_t{0});
  block->knows_rim = false;
  return block;
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

CutLattice::CellPlace CutLattice::cellOf(const Vector3d& point) const {
  CellPlace cell;
  for (int k = 0; k < 3; ++k) {
    const double q = point[k] / spacing_;
    const auto towards_zero = static_cast<std::int32_t>(q);  // std::floor is a call on machines without SSE4.1
    cell.low[k] = towards_zero - (q < towards_zero);
    cell.share[k] = static_cast<float>(q - cell.low[k]);
  }
  return cell;
}

Material CutLattice::at(const Vector3d& point) const {
  const CellPlace cell = cellOf(point);
  const std::int32_t(&low)[3] = cell.low;
  float share[3][2];
  unsigned crossed = 0;  // bits of the axes along which the eight points around it lie in two blocks
  for (int k = 0; k < 3; ++k) {
    share[k][1] = cell.share[k];
    share[k][0] = 1 - share[k][1];
    crossed |= static_cast<unsigned>((low[k] & 7) == 7) << k;
  }
  const CutBlock* blocks[8];
  for (unsigned set = crossed;; set = (set - 1) & crossed) {  // a block for each of its subsets; the shift rounds down
    blocks[set] = blockAt({(low[0] >> 3) + static_cast<int>(set & 1), (low[1] >> 3) + static_cast<int>(set >> 1 & 1),
                           (low[2] >> 3) + static_cast<int>(set >> 2)});
    if (set == 0) break;
  }
  Material sum{0, 0};
  const auto add = [&](unsigned corner, const CutBlock* block, std::size_t point_index) {
    const float weight = share[0][corner & 1] * share[1][corner >> 1 & 1] * share[2][corner >> 2];
    sum.depth += weight * (block ? block->depth[point_index] : -static_cast<float>(reach_));
    sum.clearance += weight * (block ? block->clearance[point_index] : static_cast<float>(reach_));
  };
  const std::size_t first = cell.first();
  if (crossed == 0 && blocks[0]) {  // two thirds of all points
    for (unsigned corner = 0; corner < 8; ++corner)
      add(corner, blocks[0], first + (corner & 1) + 8 * (corner >> 1 & 1) + 64 * (corner >> 2));
    return sum;
  }
  for (unsigned corner = 0; corner < 8; ++corner) {
    std::size_t point_index = 0;
    for (unsigned k = 0; k < 3; ++k) point_index |= ((static_cast<unsigned>(low[k]) + (corner >> k & 1)) & 7u) << 3 * k;
    add(corner, blocks[corner & crossed], point_index);
  }
  return sum;
}

bool CutLattice::isRemoved(const Vector3d& point) const {
  if (!isNearCut(point)) return false;
  const CellPlace cell = cellOf(point);
  const CutBlock* const block = blockAt({cell.low[0] >> 3, cell.low[1] >> 3, cell.low[2] >> 3});
  const double near = block ? static_cast<double>(block->clearance[cell.first()]) : reach_;
  // A distance changes by no more than its point moves: no corner of the cell differs by more than its diagonal.
  if (std::abs(near - kCutPlay) > 1.74 * spacing_) return near < kCutPlay;
  return static_cast<double>(at(point).clearance) < kCutPlay;
}

double CutLattice::distanceFromCut(const Vector3d& point) const {
  if (!is_cut_) return std::numeric_limits<double>::infinity();
  return (point - point.cwiseMax(cut_low_).cwiseMin(cut_high_)).norm();
}

std::uint8_t CutLattice::layerAt(const Vector3d& point) const {
  BlockPlace place;
  std::size_t point_index = 0;
  for (int k = 0; k < 3; ++k) {
    const auto at = static_cast<std::int32_t>(std::lround(point[k] / spacing_));
    place[static_cast<std::size_t>(k)] = at >> 3;
    point_index |= static_cast<std::size_t>(at & 7) << 3 * k;
  }
  const CutBlock* const block = blockAt(place);
  return block ? block->layer[point_index] : std::uint8_t{0};
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
  request.largest = static_cast<float>(kWallSpacings * spacing_);
  request.play = static_cast<float>(kCutPlay);
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
        CutBlock& block = storage_.blocks()[static_cast<std::size_t>(index)];
        block.is_cut = true;
        block.knows_rim = false;
        const Vector3d block_low = cornerOf(place), block_high = block_low.array() + 8 * spacing_;
        cut_low_ = is_cut_ ? cut_low_.cwiseMin(block_low).eval() : block_low;
        cut_high_ = is_cut_ ? cut_high_.cwiseMax(block_high).eval() : block_high;
        is_cut_ = true;
        const Vector3d corner = cornerOf(place) - from;  // small numbers, so that floats are exact enough
        for (int k = 0; k < 3; ++k) request.corner[k] = static_cast<float>(corner[k]);
        request.clearance = block.clearance;
        request.row_most = block.row_most;
        request.depth = block.depth;
        request.wall = block.wall;
        request.layer = block.layer;
        kernel_.cutBlock(request);
        work += kBlockPoints / 8;
      }
  return work;
}

}  // namespace spheretree::runtime
