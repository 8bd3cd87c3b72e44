// SPDX-License-Identifier: Apache-2.0
// Material that a burr removes, in a StepMemory; cut/ implements it. docs/algorithms/runtime/cutting.md
#pragma once

#include <span>

#include "spheretree/core/sphere.h"
#include "spheretree/runtime/step.h"
#include "state/pair_set.h"

namespace spheretree::runtime {

struct RowSet;

/// All objects of a scene that the burr of the tool cuts. `object` is an index in the scene.
class Cutting {
 public:
  virtual ~Cutting() = default;

  bool spins() const { return spins_; }
  void setSpindle(bool spins) { spins_ = spins; }
  /// All material is whole again.
  virtual void mend() = 0;
  virtual CutState stateOf(std::size_t object) const = 0;
  /// Memory of the fields, allocated at once [bytes].
  virtual std::size_t byteCount() const = 0;

  // In a step, in this order.
  /// Where the spring takes the tool at the beginning of a step if the material ahead of the burr resists: `aim`,
  /// unless the spindle turns.
  virtual Configuration resisted(const Configuration& aim, StepResult& result) = 0;
  /// Completes the pairs of a search at `pose`: adds the walls of what was removed, and puts the burr's balls in place
  /// of the leaves that cover them, or leaves these out while the spindle turns.
  virtual void addWalls(const Configuration& pose, double margin, PairSet& set) = 0;
  /// The balls of the walls of the last search.
  virtual const Sphere* walls() const = 0;
  /// Makes rows, those of `set` from `first` on, hold always if they touch the object where it was removed. Returns the
  /// work, in the unit of StepLimits::max_work.
  virtual std::uint32_t dropRemoved(const PairSet& set, std::uint32_t first, const Configuration& pose, RowSet& rows) const = 0;
  /// `point`: in the axes of the object, from its anchor [mm].
  virtual bool isRemoved(std::size_t object, const Eigen::Vector3d& point) const = 0;
  /// Removes what the burr swept in this step, if it turns.
  virtual void remove(StepResult& result) = 0;

 protected:
  bool spins_ = false;
};

}  // namespace spheretree::runtime
