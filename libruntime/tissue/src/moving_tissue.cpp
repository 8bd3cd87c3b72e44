// SPDX-License-Identifier: Apache-2.0
#include "spheretree/tissue/moving_tissue.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace spheretree::tissue {

using Eigen::Vector3d;

namespace {

constexpr double kMinShare = 0.05;  // smallest share of a way in one state

}  // namespace

MovingTissue::MovingTissue(const Tissue& tissue, std::unique_ptr<TissueSolver> solver)
    : tissue_(tissue),
      solver_(std::move(solver)),
      forces_(tissue.nodes.size(), Vector3d::Zero()),
      response_(3 * tissue.response.pressed.size()),
      last_(response_.size()),
      ways_(response_.size()) {}

std::unique_ptr<MovingTissue> MovingTissue::make(const Tissue& tissue, std::string& fault) {
  std::unique_ptr<TissueSolver> solver = TissueSolver::make(tissue, fault);
  if (fault.empty() && tissue.response.empty()) fault = "the tissue has no response to forces";
  if (!fault.empty()) return nullptr;
  return std::unique_ptr<MovingTissue>(new MovingTissue(tissue, std::move(solver)));
}

TissueState MovingTissue::restState() const {
  TissueState state;
  state.displacements.assign(tissue_.nodes.size(), Vector3d::Zero());
  state.surface.assign(response_.size(), 0.0f);
  return state;
}

void MovingTissue::reset() noexcept {
  solver_->reset();
  share_ = 1;
  for (std::vector<float>* field : {&response_, &last_, &ways_}) std::fill(field->begin(), field->end(), 0.0f);
}

void MovingTissue::advance(std::span<const float> forces, TissueState& state) noexcept {
  std::fill(forces_.begin(), forces_.end(), Vector3d::Zero());
  const std::vector<std::uint32_t>& pressed = tissue_.response.pressed;
  for (std::size_t i = 0; i < pressed.size(); ++i)
    forces_[pressed[i]] = Eigen::Map<const Eigen::Vector3f>(forces.data() + 3 * i).cast<double>();
  state.is_frozen = !solver_->advance(forces_, kIterations);
  makeState(forces, state);
}

void MovingTissue::takeSurface(std::span<const Vector3d> nodes, std::span<float> surface) const noexcept {
  const std::vector<std::uint32_t>& pressed = tissue_.response.pressed;
  for (std::size_t i = 0; i < pressed.size(); ++i)
    for (std::size_t axis = 0; axis < 3; ++axis)
      surface[3 * i + axis] = static_cast<float>(nodes[pressed[i]][static_cast<Eigen::Index>(axis)]);
}

void MovingTissue::makeState(std::span<const float> forces, TissueState& state) noexcept {
  const std::span<const Vector3d> nodes = solver_->displacements();
  std::copy(nodes.begin(), nodes.end(), state.displacements.begin());
  takeSurface(nodes, state.surface);
  if (!state.is_frozen) {  // otherwise it is not the state for these forces: their effect is left to the steps
    const TissueResponse& response = tissue_.response;
    std::fill(response_.begin(), response_.end(), 0.0f);
    for (std::size_t i = 0; i < forces.size(); ++i) {
      if (forces[i] == 0) continue;
      const std::span<const float> column = response.column(i / 3, i % 3);
      for (std::size_t k = 0; k < column.size(); ++k) response_[k] += forces[i] * column[k];
    }
    for (std::size_t i = 0; i < response_.size(); ++i) state.surface[i] -= response_[i];
    relax(state.surface);
  }
  std::copy(last_.begin(), last_.end(), state.surface.begin());
}

// Moves towards the new base by the share that the last two ways suggest: less if steps and solver would oscillate.
// Paper: U. Kuettler, W. Wall. Fixed-point fluid-structure interaction solvers with dynamic relaxation. Computational
//        Mechanics 43, 2008 (Aitken's factor).
void MovingTissue::relax(std::span<const float> surface) noexcept {
  double along = 0, square = 0;
  for (std::size_t i = 0; i < surface.size(); ++i) {
    const float way = surface[i] - last_[i], change = way - ways_[i];
    along += static_cast<double>(ways_[i]) * static_cast<double>(change);
    square += static_cast<double>(change) * static_cast<double>(change);
    ways_[i] = way;
  }
  if (square > 0) share_ = std::clamp(-share_ * along / square, kMinShare, 1.0);
  const auto share = static_cast<float>(share_);
  for (std::size_t i = 0; i < surface.size(); ++i) last_[i] += share * ways_[i];
}

}  // namespace spheretree::tissue
