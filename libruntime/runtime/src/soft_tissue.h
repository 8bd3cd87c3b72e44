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
inline constexpr double kRefitMm = 0.02;       // a leaf is put anew once its point has moved by this [mm]

/// All tissue of a scene, in a StepMemory. `object`, `row`: as in the scene and in the rows of a QP.
class SoftTissue {
 public:
  virtual ~SoftTissue() = default;
  bool has(std::uint32_t object) const { return is_tissue_[object] != 0; }

  /// At rest again.
  virtual void reset() = 0;
  /// Puts the leaves to where the forces of the last step have moved them. StepFault bits.
  virtual std::uint32_t beginStep() = 0;
  /// What the search and the rows see of the object, if it is tissue: the leaves where they are.
  virtual void placeView(std::size_t object) = 0;
  /// Moves the rows of this run by what its leaves have given way since.
  virtual void shiftRows(const PairRun& run, const PairSet& set, RowSet& rows) const = 0;
  /// Goes `part` of the way to where the forces of the last press() lead.
  virtual void giveWay(double part) = 0;
  /// Nothing presses any more.
  virtual void letGo() = 0;

  // One QP after the other. Right-hand sides without what tissue gives way are in StepMemory::soft_b.
  virtual void begin(const PairSet& pairs, const RowSet& rows, bool is_carried) = 0;
  /// The right-hand side of a row on tissue that gives way no farther.
  virtual float stop(std::uint32_t object, std::uint32_t row) const = 0;
  /// Row `k` of the problem is this one. Does nothing but forget the one before if it is rigid.
  virtual void setRow(ContactQp& qp, int k, std::uint32_t object, std::uint32_t row, bool is_stop) = 0;
  /// Where the leaves of all rows go by the multipliers; then the right-hand side of one, which may be its stop.
  virtual void predict(const ContactQp& qp) = 0;
  virtual float predictedBound(std::uint32_t object, std::uint32_t row, bool& is_stop) const = 0;
  /// The forces of the answer are what presses from now on.
  virtual void press(const ContactQp& qp) = 0;

  // Large motion: aimTissue() and tissueForces() of step.h.
  virtual void aim(std::size_t object, std::span<const Sphere> leaves, const TissueTangent& tangent, bool is_frozen) = 0;
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
