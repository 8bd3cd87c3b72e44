// SPDX-License-Identifier: Apache-2.0
// The interface of soft tissue for a step. The implementation is reached only through a TissueModel, so that a program
// without tissue, such as the shared library for other languages, does not contain its code.
#pragma once

#include <span>
#include <vector>

#include "contact/contact_problem.h"
#include "spheretree/core/rigid.h"
#include "state/pair_set.h"

namespace spheretree::runtime {

// Largest motion of a point by forces in one step: kTissueMotion plus kHandShare times the way of the hand, at most
// kMaxTissueMotion [mm]. The rim of a dent then gives way to a tool that leaves it.
inline constexpr double kTissueMotion = 0.25, kHandShare = 2, kMaxTissueMotion = 1;
inline constexpr double kBehind = 0.4;  // a ball at most this far behind a triangle of tissue is pushed out in front of it [mm]
inline constexpr double kRefitMm =
    0.05;  // padding of the balls of the search: they stay valid while their content moves by at most this [mm]

struct RowRequest;
struct RowSet;

/// The contacts on tissue, for one QP after the other. `object` and `row` are indices in the scene and in the rows of
/// the QP.
class TissueContacts {
 public:
  virtual ~TissueContacts() = default;
  /// `rows` has right-hand sides without the displacement of tissue.
  virtual void begin(const PairSet& pairs, const PairSet& felt, const RowSet& rows, const Configuration& tool, bool is_carried) = 0;
  /// The right-hand side of a row on tissue that has reached its largest displacement.
  virtual float stop(std::uint32_t row) const = 0;
  /// Uses `row` as row `k` of the problem. That of a rigid object is on no surface.
  virtual void setRow(ContactProblem& qp, int k, std::uint32_t object, std::uint32_t row, bool is_stop) = 0;
  /// Disc `d` of the problem belongs to this row and has these two axes in the world: the surface moves with it.
  virtual void setDisc(ContactProblem& qp, int d, std::uint32_t object, std::uint32_t row, bool is_stop,
                       const std::array<Eigen::Vector3d, 2>& along) = 0;
  /// Of the rows and discs that setRow() and setDisc() have named.
  virtual const SurfaceCompliance& compliance() const = 0;
  /// Predicts the displacement of the surface by the multipliers; predictedBound() then gives the right-hand side of a
  /// row, which may be its stop.
  virtual void predict(const ContactProblem& qp) = 0;
  virtual float predictedBound(std::uint32_t row, bool& is_stop) const = 0;
  /// The forces of the solution become the target forces. Contact k of the step is then at the point of row
  /// contacts[k].
  virtual void press(const ContactProblem& qp, std::span<const std::uint32_t> contacts) = 0;
  /// Notes whether disc `d`, of this row, sticks: with a force below `limit` its ball stays at its point.
  virtual void setStuck(const ContactProblem& qp, std::size_t d, std::uint32_t row, double limit) = 0;
  /// Displacement of the point of contact `k` in this step, world axes [mm].
  virtual Eigen::Vector3d movedInStep(std::size_t object, std::size_t k) const = 0;
};

/// All tissue of a scene, in a StepMemory. `object` is an index in the scene.
class SoftTissue {
 public:
  virtual ~SoftTissue() = default;
  bool has(std::size_t object) const { return object < is_tissue_.size() && is_tissue_[object] != 0; }

  /// Returns to the shape at rest.
  virtual void reset() = 0;
  virtual bool isAtRest(std::size_t object) const = 0;
  /// Begins a step in which the hand moves to `hand`, and moves the surface towards its target. Returns StepFault bits.
  virtual std::uint32_t beginStep(const Configuration& hand) = 0;
  /// Returns to the surface at the end of the last step. In the next step it moves towards no target.
  virtual void takeBack() = 0;
  /// Updates the view of the object for the search and the rows, if it is tissue: its skin in its current shape.
  virtual void placeView(std::size_t object) = 0;
  /// Keeps the pairs of a search at `pose` that may come within `margin` in this step, wherever forces move the tissue.
  /// The search knows only balls around the triangles. A coarse set stays. Returns the work, in tests of 8 pairs.
  virtual std::uint32_t keepNear(const Configuration& pose, double margin, PairSet& set) = 0;
  /// Updates the patches of these pairs to the current shape.
  virtual void placePatches(const PairSet& set) = 0;
  /// Finds the balls that are in front of a triangle: before the kernel's flatRows().
  virtual void findFront(const RowRequest& request) const = 0;
  /// Like the kernel's feltRows(), for patches of tissue.
  virtual float patchRows(const RowRequest& request) const = 0;
  virtual TissueContacts& contacts() = 0;
  /// Moves by `share` towards the target of the last press().
  virtual void giveWay(double share) = 0;
  /// Sets all target forces to zero.
  virtual void letGo() = 0;

  // Large deformation: aimTissue() and tissueForces() of step.h.
  virtual bool aim(std::size_t object, std::span<const float> surface, bool is_frozen) = 0;
  virtual std::span<const float> forces(std::size_t object) const = 0;

 protected:
  std::vector<char> is_tissue_;  // (object)
};

}  // namespace spheretree::runtime
