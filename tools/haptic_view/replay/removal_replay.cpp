// SPDX-License-Identifier: GPL-3.0-or-later
#include "replay/removal_replay.h"

#include <utility>

namespace spheretree::view {

RemovalReplay::RemovalReplay(const Stage& stage, std::span<const player::RecordedStep> steps, Carriers carriers)
    : steps_(steps), carriers_(std::move(carriers)), kept_{{0, Removal(stage)}}, now_(kept_[0]) {}

const Removal* RemovalReplay::at(std::size_t step) {
  if (now_.removal.empty()) return nullptr;
  auto from = kept_.rbegin();
  while (from->next > step + 1) ++from;
  if (now_.next > step + 1 || now_.next < from->next) now_ = *from;
  for (; now_.next <= step; ++now_.next) {
    if (now_.next == kept_.back().next + every_) kept_.push_back(now_);
    now_.removal.add(steps_[now_.next], carriers_(steps_[now_.next]));
  }
  constexpr std::size_t kMost = 24;
  while (kept_.size() > kMost) {
    for (std::size_t k = 1; 2 * k < kept_.size(); ++k) kept_[k] = std::move(kept_[2 * k]);
    kept_.erase(kept_.begin() + static_cast<std::ptrdiff_t>((kept_.size() + 1) / 2), kept_.end());
    every_ *= 2;
  }
  return &now_.removal;
}

}  // namespace spheretree::view
