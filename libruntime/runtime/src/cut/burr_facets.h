// SPDX-License-Identifier: Apache-2.0
// The facets of the burr that are near material in a step, and how far the material lets the burr come.
// docs/algorithms/runtime/cutting.md
// Units: mm; vectors of six numbers are steps of the tool, scaled as in qp6.h.
#pragma once

#include <cstdint>
#include <vector>

#include "cut/cut_work.h"
#include "cut/cutting_resistance.h"

namespace spheretree::runtime {

class BurrFacets {
 public:
  BurrFacets(const StepMemory& memory, std::vector<CutWork>& works);

  void forget() { last_ = {}; }
  /// Finds the facets of a burr that may go `to_aim` in this step, and makes what it needs of the lattices. Returns
  /// false if there was not the time: the burr must not move.
  bool find(const Displacement& to_aim, bool spins, StepResult& result);
  bool empty() const { return facets_.empty(); }
  /// Where a spring with this target takes the tool against the resistance of the material.
  Vector6 step(const Vector6& target, StepResult& result);
  /// The share of a step after which no facet is too deep, and no ball has come to where blocks may be missing.
  double shareWithin(const Vector6& y) const;

 private:
  /// What a facet belongs to.
  struct FacetOf {
    CutWork* work;
    std::uint8_t layer;
    Eigen::Vector3d arm;  // from the reference point to the centre of its ball, world axes
  };
  enum class Reach : std::uint8_t { Far, Near, Unknown };

  Reach prepare(CutWork& work, std::size_t ball, double way, std::uint32_t max_work, StepResult& result);
  bool makeBlocks(CutWork& work, NearBall& near, double needed, double ahead, double free, std::uint32_t max_work, StepResult& result);
  void add(CutWork& work, std::size_t ball);
  void noteLayers(const Vector6& y);
  Vector6 rubbedTarget(const CutStep& step, const Vector6& target) const;

  const StepMemory& memory_;
  const CompiledScene& scene_;
  std::vector<CutWork>& works_;
  bool rubs_ = false;                        // some material has a tangential force
  std::vector<Eigen::Vector3d> directions_;  // of the facets of a burr ball, axes of the object
  CutStep last_;                             // the guess of the next one
  std::vector<CutFacet> facets_;
  std::vector<FacetOf> facet_of_;  // (facet)
  std::vector<BlockPlace> ahead_;  // scratch
};

}  // namespace spheretree::runtime
