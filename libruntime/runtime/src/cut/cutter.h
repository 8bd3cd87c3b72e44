// SPDX-License-Identifier: Apache-2.0
// The burr of the tool, and the objects that it cuts.
#pragma once

#include <array>
#include <vector>

#include "cut/cut_layers.h"
#include "cut/cutting_resistance.h"
#include "state/cutting.h"
#include "state/step_memory.h"

namespace spheretree::runtime {

class Cutter final : public Cutting {
 public:
  explicit Cutter(StepMemory& memory);

  void mend() override;
  CutState stateOf(std::size_t object) const override;
  std::size_t byteCount() const override { return storage_.byteCount() + walls_.size() * sizeof(Sphere); }
  Configuration resisted(const Configuration& aim, StepResult& result) override;
  void addWalls(const Configuration& pose, double margin, PairSet& set) override;
  const Sphere* walls() const override { return walls_.data(); }
  std::uint32_t dropRemoved(const PairSet& set, std::uint32_t first, const Configuration& pose, RowSet& rows) const override;
  bool isRemoved(std::size_t object, const Eigen::Vector3d& point) const override;
  void remove(StepResult& result) override;

 private:
  /// A ball of the burr near an object.
  struct Near {
    Eigen::Vector3d at{0, 0, 0};           // its centre at the beginning of the step, in the axes of the object
    bool is_near = false;                  // in this step
    Eigen::Vector3d known_about{0, 0, 0};  // all blocks within known_within of this point have been made
    double known_within = 0;               // [mm]
  };
  struct Work {
    std::uint32_t object;
    const CompiledShape& shape;
    const CutModel& model;
    CutLayers layers;
    CutLattice lattice;
    std::vector<double> removed;            // (layer) [mm^3]
    std::uint32_t layer = CutState::kNone;  // innermost that the burr met in the last step
    std::vector<Near> burr;                 // (ball)
  };
  /// A leaf or a ball of the burr near what was cut.
  struct NearPart {
    std::uint32_t slot;
    Eigen::Vector3d at;  // axes of the object
    double reach;        // radius and margin [mm]
  };
  /// What a facet belongs to.
  struct FacetOf {
    Work* work;
    std::uint8_t layer;
    Eigen::Vector3d arm;  // from the reference point to the centre of its ball, world axes
  };
  enum class Reach : std::uint8_t { Far, Near, Unknown };

  Work makeWork(std::uint32_t object);
  Work* workOf(std::size_t object);
  const Work* workOf(std::size_t object) const;
  Eigen::Vector3d localOf(const Work& work, const Eigen::Vector3d& world) const;
  Reach prepare(Work& work, std::size_t ball, double way, std::uint32_t max_work, StepResult& result);
  bool makeBlocks(Work& work, Near& near, double needed, double ahead, double free, std::uint32_t max_work, StepResult& result);
  void addFacets(Work& work, std::size_t ball);
  bool findFacets(const Displacement& to_aim, StepResult& result);
  void noteLayers(const Vector6& y);
  Vector6 rubbedTarget(const CutStep& step, const Vector6& target) const;
  double shareWithin(const Vector6& y) const;
  void addPairs(const PairSet& set, const PairRun& run);
  void findNearParts(const Work& work, const Configuration& pose, double margin);
  bool addWallsOf(Work& work, const Configuration& pose, double margin, std::uint32_t& tests);

  StepMemory& memory_;
  const CompiledScene& scene_;
  bool rubs_ = false;  // some material has a tangential force
  CutStorage storage_;
  std::vector<Work> works_;
  std::vector<Eigen::Vector3d> directions_;  // of the facets of a burr ball, axes of the object
  CutStep last_;                             // the guess of the next one
  std::vector<CutFacet> facets_;
  std::vector<FacetOf> facet_of_;  // (facet)
  std::vector<BlockPlace> ahead_;  // scratch
  std::vector<NearPart> near_parts_;
  std::vector<Sphere> walls_;  // of which wall_count_ are used
  std::size_t wall_count_ = 0;
  // Scratch of a block: of its points, then of its rim, the ball in walls_ or kNoItem.
  std::array<std::uint32_t, kBlockPoints + kMaxRimBalls> wall_of_{};
  std::vector<std::uint32_t> pairs_;
  std::vector<PairRun> runs_;
};

}  // namespace spheretree::runtime
