// SPDX-License-Identifier: Apache-2.0
// The burr of the tool, and the objects that it cuts.
#pragma once

#include <vector>

#include "cut/burr_facets.h"
#include "cut/cut_walls.h"

namespace spheretree::runtime {

class Cutter final : public Cutting {
 public:
  explicit Cutter(StepMemory& memory);

  void mend() override;
  CutState stateOf(std::size_t object) const override;
  std::size_t byteCount() const override { return storage_.byteCount() + walls_.byteCount(); }
  Configuration resisted(const Configuration& aim, StepResult& result) override;
  void addWalls(const Configuration& pose, double margin, PairSet& set) override { walls_.add(pose, margin, spins_, set); }
  const Sphere* walls() const override { return walls_.balls(); }
  std::uint32_t dropRemoved(const PairSet& set, std::uint32_t first, const Configuration& pose, RowSet& rows) const override {
    return walls_.dropRemoved(set, first, pose, rows);
  }
  bool isRemoved(std::size_t object, const Eigen::Vector3d& point) const override;
  void remove(StepResult& result) override;

 private:
  std::vector<CutWork> makeWorks();

  StepMemory& memory_;
  const CompiledScene& scene_;
  CutStorage storage_;
  std::vector<CutWork> works_;
  BurrFacets facets_;
  CutWalls walls_;
};

}  // namespace spheretree::runtime
