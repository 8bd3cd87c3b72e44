// SPDX-License-Identifier: GPL-3.0-or-later
#include "run/tissue_motion.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "spheretree/formats/errors.h"

namespace spheretree::player {

TissueMotion::TissueMotion(const runtime::Scene& scene, Clock clock)
    : clock_(clock), ticks_per_state_(std::max<std::uint64_t>(1, std::llround(1e-3 * kTissueTicks / scene.compiled().step_time))) {
  std::string fault;
  exchange_ = scene::TissueExchange::make(scene, fault);
  if (!exchange_) throw formats::FormatError(fault + ". Soften it again, or play it with --tissue small.");
  TissueShapes rest(scene.objectCount());
  for (const auto& body : exchange_->bodies()) rest[body.object] = body.shape;
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
                     : clock_ == Clock::Stepped ? tick % ticks_per_state_ == 0
                                                : is_due;
  if (!takes || empty()) return taken_;
  if (rests_) rest();
  if (!exchange_->exchange(workspace)) return taken_;
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
  exchange_->solve();
  publish();
}

void TissueMotion::publish() noexcept {
  TissueShapes& shapes = shapes_.back();
  for (const auto& body : exchange_->bodies()) std::copy(body.shape.begin(), body.shape.end(), shapes[body.object].begin());
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
  exchange_->restart();
  publish();
}

const TissueShapes& TissueMotion::shapes() noexcept {
  (void)shapes_.refresh();
  return shapes_.front();
}

}  // namespace spheretree::player
