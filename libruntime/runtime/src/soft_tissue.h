// SPDX-License-Identifier: Apache-2.0
// Soft tissue as a step sees it. What implements it is reached through a TissueModel alone, so that a program which has
// no tissue, such as the shared library for other languages, does not hold the code.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "contact_qp.h"
#include "rows.h"
#include "spheretree/core/tissue.h"
#include "spheretree/runtime/scene.h"

namespace spheretree::runtime {

inline constexpr double kTissueMotion = 0.25;  // of any point in one step, at most [mm]
inline constexpr double kBehind = 0.4;         // so far behind a triangle of tissue a ball is still pushed out in front of it [mm]
inline constexpr double kRefitMm = 0.05;       // a ball of the search holds what it is about although that has moved by this [mm]

struct RowRequest;

/// All tissue of a scene, in a StepMemory. `object`, `row`: as in the scene and in the rows of a QP.
class SoftTissue {
 public:
  virtual ~SoftTissue() = default;
  bool has(std::size_t object) const { return object < is_tissue_.size() && is_tissue_[object] != 0; }

  /// At rest again.
  virtual void reset() = 0;
  virtual bool isAtRest(std::size_t object) const = 0;
  /// Puts the surface to where the forces of the last step have moved it. StepFault bits.
  virtual std::uint32_t beginStep() = 0;
  /// What the search and the rows see of the object, if it is tissue: its skin where it is.
  virtual void placeView(std::size_t object) = 0;
  /// Puts the patches of these pairs to where they are now.
  virtual void placePatches(const PairRun& run, const PairSet& set) = 0;
  /// As the kernel's feltRows(), of patches of tissue.
  virtual float patchRows(const RowRequest& request) const = 0;
  /// solveRowsAlone(), which only tissue needs: without it few rows hold the tool.
  virtual bool solveRows(ContactQp& qp) const = 0;
  /// Goes `part` of the way to where the forces of the last press() lead.
  virtual void giveWay(double part) = 0;
  /// Nothing presses any more.
  virtual void letGo() = 0;

  // One QP after the other. Right-hand sides without what tissue gives way are in `rows` as it begins.
  virtual void begin(const PairSet& pairs, const PairSet& felt, const RowSet& rows, const Configuration& tool, bool is_carried) = 0;
  /// The right-hand side of a row on tissue that gives way no farther.
  virtual float stop(std::uint32_t row) const = 0;
  /// Row `k` of the problem is this one. Does nothing but forget the one before if it is rigid.
  virtual void setRow(ContactQp& qp, int k, std::uint32_t object, std::uint32_t row, bool is_stop) = 0;
  /// Where the surface goes by the multipliers; then the right-hand side of a row, which may be its stop.
  virtual void predict(const ContactQp& qp) = 0;
  virtual float predictedBound(std::uint32_t row, bool& is_stop) const = 0;
  /// The forces of the answer are what presses from now on.
  virtual void press(const ContactQp& qp) = 0;

  // Large motion: aimTissue() and tissueForces() of step.h.
  virtual bool aim(std::size_t object, std::span<const float> surface, bool is_frozen) = 0;
  virtual std::span<const float> forces(std::size_t object) const = 0;

 protected:
  std::vector<char> is_tissue_;  // (object)
};

/// Tissue for a scene, and what makes it move.
struct TissueModel {
  SharedTree tree;
  std::shared_ptr<const Tissue> tissue;
  std::size_t bytes = 0;
  std::unique_ptr<SoftTissue> (*make)(StepMemory& memory) = nullptr;
};

}  // namespace spheretree::runtime
