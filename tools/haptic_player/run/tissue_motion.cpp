// SPDX-License-Identifier: GPL-3.0-or-later
#include "run/tissue_motion.h"

#include <algorithm>
#include <utility>

#include "spheretree/formats/errors.h"

namespace spheretree::player {

TissueMotion::TissueMotion(const runtime::Scene& scene, Clock clock) : clock_(clock) {
  TissueShapes rest(scene.objectCount());
  for (std::size_t object = 0; object < scene.objectCount(); ++object) {
    const Tissue* const tissue = scene.tissue(object);
    if (!tissue) continue;
    std::string fault;
    Body body{object, tissue::MovingTissue::make(*tissue, fault), std::vector<float>(3 * tissue->response.pressed.size()), {}, {}};
    if (!body.motion)
      throw formats::FormatError("object " + std::to_string(object) + ": " + fault + ". Soften it again, or play it with --tissue small.");
    body.taken = body.solved = body.motion->restState();
    rest[object] = body.shape = std::vector<Eigen::Vector3f>(tissue->nodes.size(), Eigen::Vector3f::Zero());
    bodies_.push_back(std::move(body));
  }
  for (int slot = 0; slot < 3; ++slot) shapes_.publish(rest), (void)shapes_.refresh();
  if (clock_ == Clock::Real && !empty()) thread_ = std::thread([this] { run(); });
}

TissueMotion::~TissueMotion() {
  if (!thread_.joinable()) return;
  while (phase_.load(std::memory_order_acquire) == kAsked) phase_.wait(kAsked);
  phase_.store(kEnding, std::memory_order_release);
  phase_.notify_all();
  thread_.join();
}

std::uint32_t TissueMotion::take(std::uint64_t tick, runtime::Workspace& workspace, bool is_due) noexcept {
  const bool takes = clock_ == Clock::Real      ? phase_.load(std::memory_order_acquire) == kSolved
                     : clock_ == Clock::Stepped ? tick % kTissueTicks == 0
                                                : is_due;
  if (!takes || empty()) return taken_;
  if (rests_) rest();
  bool has_work = false;
  for (Body& body : bodies_) {
    const std::span<const float> forces = runtime::tissueForces(body.object, workspace);
    const bool is_pressed = std::any_of(forces.begin(), forces.end(), [](float f) { return f != 0; });
    body.quiet = is_pressed ? 0 : std::min(body.quiet + 1, kQuiet);
    has_work = has_work || body.quiet < kQuiet;
  }
  if (!has_work) return taken_;
  for (Body& body : bodies_) {
    if (body.is_solved) {
      std::swap(body.taken, body.solved);
      runtime::aimTissue(body.object, body.taken.surface, body.taken.is_frozen, workspace);
    }
    body.is_solved = body.quiet < kQuiet;
    const std::span<const float> forces = runtime::tissueForces(body.object, workspace);
    std::copy(forces.begin(), forces.end(), body.forces.begin());
  }
  ++taken_;
  if (clock_ == Clock::Real) {
    phase_.store(kAsked, std::memory_order_release);
    phase_.notify_one();
  } else {
    solve();
  }
  return taken_;
}

void TissueMotion::solve() noexcept {
  TissueShapes& shapes = shapes_.back();
  for (Body& body : bodies_) {
    if (body.is_solved) {
      body.motion->advance(body.forces, body.solved);
      for (std::size_t i = 0; i < body.shape.size(); ++i) body.shape[i] = body.solved.displacements[i].cast<float>();
    }
    std::copy(body.shape.begin(), body.shape.end(), shapes[body.object].begin());
  }
  shapes_.publish();
}

void TissueMotion::run() noexcept {
  for (;;) {
    phase_.wait(kSolved);
    const int phase = phase_.load(std::memory_order_acquire);
    if (phase == kEnding) return;
    if (phase != kAsked) continue;
    solve();
    phase_.store(kSolved, std::memory_order_release);
    phase_.notify_all();
  }
}

void TissueMotion::restart() noexcept {
  rests_ = true;
  if (clock_ != Clock::Real) rest();
}

/// The solver must be idle.
void TissueMotion::rest() noexcept {
  rests_ = false;
  TissueShapes& shapes = shapes_.back();
  for (Body& body : bodies_) {
    body.motion->reset();
    body.quiet = kQuiet;
    body.is_solved = false;
    std::fill(body.shape.begin(), body.shape.end(), Eigen::Vector3f::Zero());
    std::copy(body.shape.begin(), body.shape.end(), shapes[body.object].begin());
  }
  shapes_.publish();
}

const TissueShapes& TissueMotion::shapes() noexcept {
  (void)shapes_.refresh();
  return shapes_.front();
}

}  // namespace spheretree::player
