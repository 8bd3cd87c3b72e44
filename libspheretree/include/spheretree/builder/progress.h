// SPDX-License-Identifier: Apache-2.0
// Progress of a long computation and its cancellation: an argument, never a global.
#pragma once

#include <atomic>
#include <stdexcept>
#include <string_view>

namespace spheretree::builder {

struct Cancelled : std::runtime_error {
  Cancelled() : std::runtime_error("interrupted") {}
};

/// Receives the state of a computation. The base class does nothing; a program derives from it. `stage` and `advance`
/// are called from the computing thread only, `cancel` from any thread or signal handler.
class Progress {
 public:
  Progress() = default;
  /// Of a part of a longer computation: cancelling `whole`, which must outlive it, cancels the part.
  explicit Progress(const Progress* whole) : whole_(whole) {}
  virtual ~Progress() = default;
  virtual void stage(std::string_view /*name*/) {}
  virtual void advance(double /*fraction of the stage, 0..1*/) {}
  void cancel() noexcept { cancelled_.store(true, std::memory_order_relaxed); }
  bool cancelled() const noexcept { return cancelled_.load(std::memory_order_relaxed) || (whole_ && whole_->cancelled()); }
  /// Every loop that can take 0.1 s calls this. @throws Cancelled after cancel() was called.
  void check() const {
    if (cancelled()) throw Cancelled();
  }

 private:
  const Progress* whole_ = nullptr;
  std::atomic<bool> cancelled_{false};
};

}  // namespace spheretree::builder
