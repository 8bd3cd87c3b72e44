// SPDX-License-Identifier: Apache-2.0
// What a search has beside its pairs where objects are cut: pairs with the walls of what was removed, as balls; and the
// rows that what was removed no longer has. docs/algorithms/runtime/cutting.md
// Units: mm.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "cut/cut_work.h"
#include "state/cutting.h"

namespace spheretree::runtime {

class CutWalls {
 public:
  CutWalls(StepMemory& memory, std::vector<CutWork>& works, CutStorage& storage);

  const Sphere* balls() const { return walls_.data(); }
  std::size_t byteCount() const { return walls_.size() * sizeof(Sphere); }
  /// Cutting::addWalls().
  void add(const Configuration& pose, double margin, bool spins, PairSet& set);
  /// Cutting::dropRemoved().
  std::uint32_t dropRemoved(const PairSet& set, std::uint32_t first, const Configuration& pose, RowSet& rows) const;

 private:
  /// A leaf or a ball of the burr near what was cut.
  struct NearPart {
    std::uint32_t slot;
    Eigen::Vector3d at;  // axes of the object
    double reach;        // radius and margin
  };

  void addPairs(const PairSet& set, const PairRun& run, bool spins);
  void findNearParts(const CutWork& work, const Configuration& pose, double margin, bool spins);
  bool addWallsOf(CutWork& work, std::uint32_t& tests);

  StepMemory& memory_;
  const CompiledScene& scene_;
  std::vector<CutWork>& works_;
  CutStorage& storage_;
  std::vector<NearPart> near_parts_;
  std::vector<Sphere> walls_;  // of which wall_count_ are used
  std::size_t wall_count_ = 0;
  // Scratch of a block: of its points, then of its rim, the ball in walls_ or kNoItem.
  std::array<std::uint32_t, kBlockPoints + kMaxRimBalls> wall_of_{};
  std::vector<std::uint32_t> pairs_;
  std::vector<PairRun> runs_;
};

/// The cut object with this index in the scene, or null.
const CutWork* workOf(const std::vector<CutWork>& works, std::size_t object);

}  // namespace spheretree::runtime
