// SPDX-License-Identifier: Apache-2.0
#include "spheretree/scene/tissue_exchange.h"

#include <algorithm>
#include <span>
#include <utility>

namespace spheretree::scene {

std::unique_ptr<TissueExchange> TissueExchange::make(const runtime::Scene& scene, std::string& fault) {
  std::unique_ptr<TissueExchange> out(new TissueExchange);
  for (std::size_t object = 0; object < scene.objectCount(); ++object) {
    const Tissue* const tissue = scene.tissue(object);
    if (!tissue) continue;
    Body body{object, tissue::MovingTissue::make(*tissue, fault), std::vector<float>(3 * tissue->response.pressed.size()), {}, {}};
    if (!body.motion) {
      fault.insert(0, "object " + std::to_string(object) + ": ");
      return nullptr;
    }
    body.taken = body.solved = body.motion->restState();
    body.shape = std::vector<Eigen::Vector3f>(tissue->nodes.size(), Eigen::Vector3f::Zero());
    out->bodies_.push_back(std::move(body));
  }
  return out;
}

bool TissueExchange::exchange(runtime::Workspace& workspace) noexcept {
  bool has_work = false;
  for (Body& body : bodies_) {
    const std::span<const float> forces = runtime::tissueForces(body.object, workspace);
    const bool is_pressed = std::any_of(forces.begin(), forces.end(), [](float f) { return f != 0; });
    body.quiet = is_pressed ? 0 : std::min(body.quiet + 1, kQuiet);
    has_work = has_work || body.quiet < kQuiet;
  }
  if (!has_work) return false;
  for (Body& body : bodies_) {
    if (body.is_solved) {
      std::swap(body.taken, body.solved);
      runtime::aimTissue(body.object, body.taken.surface, body.taken.is_frozen, workspace);
    }
    body.is_solved = body.quiet < kQuiet;
    const std::span<const float> forces = runtime::tissueForces(body.object, workspace);
    std::copy(forces.begin(), forces.end(), body.forces.begin());
  }
  return true;
}

void TissueExchange::solve() noexcept {
  for (Body& body : bodies_) {
    if (!body.is_solved) continue;
    body.motion->advance(body.forces, body.solved);
    for (std::size_t i = 0; i < body.shape.size(); ++i) body.shape[i] = body.solved.displacements[i].cast<float>();
  }
}

void TissueExchange::restart() noexcept {
  for (Body& body : bodies_) {
    body.motion->reset();
    body.quiet = kQuiet;
    body.is_solved = false;
    std::fill(body.shape.begin(), body.shape.end(), Eigen::Vector3f::Zero());
  }
}

}  // namespace spheretree::scene
