// SPDX-License-Identifier: Apache-2.0
// The rows of a step that are in its contact problem, with the friction of their contacts and the objects that yield
// evenly; and back: what the solution says of the contacts.
#pragma once

#include <array>

#include "contact/contact_problem.h"
#include "step/step_parts.h"

namespace spheretree::runtime {

class ContactRows {
 public:
  struct Tangents {
    Eigen::Vector3d first, second;
  };

  /// `tissue`: null if the scene has none. All of it must outlive the object.
  ContactRows(StepParts& parts, const PairSet& pairs, const RowSet& rows, const CarriedPiece* carried, TissueContacts* tissue)
      : parts_(parts),
        scene_(parts.scene),
        memory_(parts.memory),
        pairs_(pairs),
        rows_(rows),
        carried_(carried),
        tissue_(tissue),
        rotation_(parts.contact_pose.orientation.toRotationMatrix()),
        problem_(*parts.memory.contact_problem) {}

  void clear() { problem_.row_count = problem_.disc_count = problem_.group_count = 0; }
  /// The index of a row in the problem; -1: it is not in it. `is_stop`: of tissue at its largest displacement.
  [[gnu::noinline]] int placeOf(std::uint32_t row, bool is_stop) const;
  /// Adds a row to the problem and returns its index; -1: the problem is full.
  int takeIn(std::uint32_t row, double multiplier, bool is_stop = false);
  /// How far an object yields evenly in the solution [mm].
  double giveOf(std::uint32_t object) const;
  /// Stores the solution as the answer of the step, with the friction of its contacts and how far objects will yield.
  void keep();

 private:
  int groupOf(std::uint32_t object);
  void addDisc(int k, const RowName& name);

  StepParts& parts_;
  const CompiledScene& scene_;
  StepMemory& memory_;
  const PairSet& pairs_;
  const RowSet& rows_;
  const CarriedPiece* carried_;
  TissueContacts* const tissue_;
  const Eigen::Matrix3d rotation_;  // of the tool, where the rows were made
  ContactProblem& problem_;
  std::array<std::uint32_t, kMaxContactRows> row_;  // index in the scan, of each row of the problem
  std::array<double, kMaxContactRows> pressed_;     // initial multipliers
  std::array<int, kMaxContactRows> disc_;           // of each row, or -1
  std::array<double, kMaxContactRows> friction_;    // coefficient times weight, for each disc's row
  std::array<Tangents, kMaxContactRows> tangents_;  // of each disc
  std::array<std::uint32_t, kMaxGroups> group_object_{};
  std::array<double, kMaxGroups> group_scale_{};  // [mm] of the object for each mm of the coordinate
  std::array<bool, kMaxContactRows> is_stop_;     // for each row: of tissue that has reached its largest displacement
};

}  // namespace spheretree::runtime
