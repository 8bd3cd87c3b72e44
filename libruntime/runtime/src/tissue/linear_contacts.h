// SPDX-License-Identifier: Apache-2.0
// The contacts on soft tissue whose surface yields linearly to forces.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "state/soft_tissue.h"
#include "state/step_memory.h"
#include "tissue/soft_surface.h"

namespace spheretree::runtime {

class LinearContacts final : public TissueContacts {
 public:
  /// `surfaces`: (object) null: rigid. Both must outlive the object. @throws std::bad_alloc.
  LinearContacts(StepMemory& memory, const std::vector<std::unique_ptr<SoftSurface>>& surfaces);

  void begin(const PairSet& pairs, const PairSet& felt, const RowSet& rows, const Configuration& tool, bool is_carried) override;
  float stop(std::uint32_t row) const override { return rows_[row].stop; }
  void setRow(ContactProblem& qp, int k, std::uint32_t object, std::uint32_t row, bool is_stop) override;
  void setDisc(ContactProblem& qp, int d, std::uint32_t object, std::uint32_t row, bool is_stop,
               const std::array<Eigen::Vector3d, 2>& along) override;
  void predict(const ContactProblem& qp) override;
  float predictedBound(std::uint32_t row, bool& is_stop) const override;
  void press(const ContactProblem& qp, std::span<const std::uint32_t> contacts) override;
  void setStuck(const ContactProblem& qp, std::size_t d, std::uint32_t row, double limit) override;
  Eigen::Vector3d movedInStep(std::size_t object, std::size_t k) const override {
    return memory_.objects[object].rotation * surfaces_[object]->movedInStep(contacts_[k]);
  }
  const SurfaceCompliance& compliance() const override { return compliance_; }

 private:
  /// For each row that the QP may use.
  struct Row {
    SoftSurface* surface;
    SkinPoint point;         // the point of contact
    Eigen::Vector3d normal;  // axes of the object
    double given;            // current displacement along the normal [mm]
    double weight;
    float b, stop;  // current right-hand side; and that at which the tissue has reached its largest displacement
    std::uint32_t pair;
    bool is_felt;  // the row of the patch, not of the flat triangle
  };
  // A force of the problem.
  struct Pressed {
    SoftSurface* surface = nullptr;  // null: rigid, or a stop
    SurfaceResponse::Press on;
    Eigen::Vector3d pull{0, 0, 0};  // its force for a multiplier of 1, axes of the object [N]
  };

  void addRows(const PairRun& run, const PairSet& set, std::uint32_t first, const RowSet& rows, const Configuration& tool);
  void addForce(const ContactProblem& qp, std::size_t force, std::size_t row);
  /// Calls `work` with each force and its multiplier.
  template <class Work>
  void forForces(const ContactProblem& qp, const Work& work) const {
    for (std::size_t k = 0; k < static_cast<std::size_t>(qp.row_count); ++k) work(k, qp.rows[k].multiplier);
    for (std::size_t d = 0; d < static_cast<std::size_t>(qp.disc_count); ++d)
      for (std::size_t axis = 0; axis < 2; ++axis) work(forceOf(d, axis), qp.discs[d].force[axis]);
  }

  StepMemory& memory_;
  const CompiledScene& scene_;
  const std::vector<std::unique_ptr<SoftSurface>>& surfaces_;
  std::vector<Row> rows_;                            // (row) of the rows on tissue
  std::array<SkinPoint, kMaxContactRows> contacts_;  // of the step
  bool is_carried_ = false;
  std::array<Pressed, kMaxForces> pressed_;
  std::array<std::vector<Eigen::Matrix3d>, kMaxContactRows> responses_;  // (row) of the near nodes, to a force at its point
  std::array<std::vector<double>, kMaxForces> fields_;                   // (force) displacements of the near nodes for a multiplier of 1
  SurfaceCompliance compliance_{};
  std::vector<double> sum_;  // scratch
};

}  // namespace spheretree::runtime
