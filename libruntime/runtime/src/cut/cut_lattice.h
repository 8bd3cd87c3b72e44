// SPDX-License-Identifier: Apache-2.0
// What a burr has left of an object, as two fields on a lattice: the depth below the object's surface, and the distance
// to what was removed. Both are exact at the points of the lattice, whatever the number of steps, and are interpolated
// between them. Blocks of 8 x 8 x 8 points are made where the burr comes; there is no other memory of its path.
// Units: mm; frame: axes of the object, origin at the centre of its shape.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "cut/cut_kernel.h"
#include "spheretree/core/sphere.h"

namespace spheretree::runtime {

using BlockPlace = std::array<std::int32_t, 3>;  // of a block in the lattice, in blocks

inline constexpr std::size_t kMaxRimBalls = 64;  // of a block
inline constexpr double kWallSpacings = 2.5;     // largest ball of a wall
// A burr that fits its hole exactly would be stuck in it by rounding: no spindle runs truer than this.
inline constexpr double kCutPlay = 0.005;  // [mm]

struct CutBlock {
  BlockPlace place{};
  std::uint32_t lattice = 0;            // that it belongs to
  float depth[kBlockPoints];            // below the surface, negative outside; within +-reach
  float clearance[kBlockPoints];        // distance to what was removed, negative within; at most reach
  float row_most[kBlockPoints / 8];     // largest clearance of each row of 8 points
  std::uint8_t layer[kBlockPoints];     // innermost layer that contains the point
  std::uint8_t wall[kBlockPoints / 8];  // (row) bits of the points about which the wall has balls
  bool is_cut = false;                  // something was removed within reach of a point
  bool meets_surface = false;           // some point is within a spacing of the object's surface
  bool knows_rim = false;               // since something was removed near it
  std::uint8_t rim_count = 0;
  Sphere rim[kMaxRimBalls];  // LatticeWall::rimOf
};

/// The blocks of the lattices of all objects, which are numbered. Allocated once.
class CutStorage {
 public:
  static constexpr std::int32_t kUnknown = -1, kOutside = -2;  // a block that was not made; one without material
  explicit CutStorage(std::size_t max_blocks);
  /// Forgets all blocks.
  void clear();

  /// The index of a block, or one of the constants above.
  std::int32_t find(std::uint32_t lattice, const BlockPlace& place) const;
  /// A new block; null if the memory is full.
  CutBlock* add(std::uint32_t lattice, const BlockPlace& place);
  void addOutside(std::uint32_t lattice, const BlockPlace& place);
  std::span<CutBlock> blocks() { return {blocks_.data(), count_}; }
  std::span<const CutBlock> blocks() const { return {blocks_.data(), count_}; }
  std::size_t byteCount() const { return table_.size() * sizeof(Entry) + blocks_.size() * sizeof(CutBlock); }

 private:
  struct Entry {
    BlockPlace place{};
    std::uint32_t lattice = 0;
    std::int32_t index = kUnknown;
  };
  std::size_t entryOf(std::uint32_t lattice, const BlockPlace& place) const;

  std::vector<Entry> table_;  // open addressing; its size is a power of two
  std::size_t entry_count_ = 0;
  std::vector<CutBlock> blocks_;
  std::size_t count_ = 0;
};

/// Depth and clearance at a point.
struct Material {
  float depth, clearance;
};

class CutLattice {
 public:
  /// `reach`: of the fields. `storage` must outlive the lattice, which is the only one of its number there.
  CutLattice(double spacing, double reach, std::uint32_t number, CutStorage& storage, const CutKernel& kernel);

  const CutKernel& kernel() const { return kernel_; }
  double spacing() const { return spacing_; }
  double reach() const { return reach_; }

  /// As in the storage.
  std::int32_t find(const BlockPlace& place) const { return storage_.find(number_, place); }
  /// A new block in this place, where nothing is removed; null if the memory is full.
  CutBlock* add(const BlockPlace& place);
  void addOutside(const BlockPlace& place) { storage_.addOutside(number_, place); }
  /// The block in this place; null if it was not made.
  const CutBlock* blockAt(const BlockPlace& place) const {
    const std::int32_t index = find(place);
    return index >= 0 ? &storage_.blocks()[static_cast<std::size_t>(index)] : nullptr;
  }
  /// Whether the block is of this lattice, with something removed near it.
  bool hasWall(const CutBlock& block) const { return block.is_cut && block.lattice == number_; }
  bool isCut() const { return is_cut_; }
  /// After the storage has forgotten its blocks.
  void mend() { is_cut_ = false; }

  /// Of the first point of a block.
  Eigen::Vector3d cornerOf(const BlockPlace& place) const;
  Eigen::Vector3d middleOf(const BlockPlace& place) const;
  double blockRadius() const;  // of a ball about its middle that contains its points
  BlockPlace placeOf(const Eigen::Vector3d& point) const;

  /// Both fields, interpolated. Where no block is, there is neither material nor anything removed.
  Material at(const Eigen::Vector3d& point) const;
  /// Whether it is in the box around all blocks that were cut; beyond it, nothing is removed.
  bool isNearCut(const Eigen::Vector3d& point) const {
    return is_cut_ && (point.array() >= cut_low_.array()).all() && (point.array() <= cut_high_.array()).all();
  }
  /// Whether it is where no ball of the wall may be: in what was removed, or within the play of it.
  bool isRemoved(const Eigen::Vector3d& point) const;
  std::uint8_t layerAt(const Eigen::Vector3d& point) const;

  /// Removes the points within `radius` of the segment. `volume`: (layer) what this takes off is added, by the share of
  /// each point's cell [mm^3]. Returns the work in tests of 8 points.
  std::uint32_t remove(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double radius, std::span<double> volume);
  /// The distance of a point from the box around all blocks that were cut; infinite if there is none.
  double distanceFromCut(const Eigen::Vector3d& point) const;

 private:
  /// The cell of eight points around a point.
  struct CellPlace {
    std::int32_t low[3];  // the first of them
    float share[3];       // of the way to the next along each axis
    std::size_t first() const { return static_cast<std::size_t>((low[0] & 7) | (low[1] & 7) << 3 | (low[2] & 7) << 6); }  // in its block
  };
  CellPlace cellOf(const Eigen::Vector3d& point) const;
  CutStorage& storage_;
  const CutKernel& kernel_;
  std::uint32_t number_;
  double spacing_, reach_;
  bool is_cut_ = false;
  Eigen::Vector3d cut_low_{0, 0, 0}, cut_high_{0, 0, 0};  // of the blocks that were cut
};

}  // namespace spheretree::runtime
