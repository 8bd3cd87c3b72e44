// SPDX-License-Identifier: GPL-3.0-or-later
// Large deformation of the soft tissue of a scene, in parallel with the servo loop: forces go to a solver in a separate
// thread, and states of the surface come back. The loop never waits: when a new state is available, it takes the state
// and passes the current forces on for the next one. Besides its poses, a run depends only on which steps took a state;
// a replay takes states in the same steps.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <thread>
#include <vector>

#include "spheretree/runtime/step.h"
#include "spheretree/scene/tissue_exchange.h"
#include "streams/triple_buffer.h"

namespace spheretree::player {

inline constexpr std::uint64_t kTissueTicks = 10;  // ticks of 1 ms between states in lock step

/// For a view: displacements of the nodes of each object, empty if it is rigid [mm].
using TissueShapes = std::vector<std::vector<Eigen::Vector3f>>;

class TissueMotion {
 public:
  enum class Clock {
    Real,     // a separate thread
    Stepped,  // in the thread of the steps, every kTissueTicks: the same bytes every time
    Replay,   // in the thread of the steps, when take() is called with is_due
  };
  /// `scene` must outlive the object. @throws formats::FormatError if the solver cannot handle the tissue of an object.
  TissueMotion(const runtime::Scene& scene, Clock clock);
  ~TissueMotion();
  TissueMotion(const TissueMotion&) = delete;
  TissueMotion& operator=(const TissueMotion&) = delete;

  /// True if the scene has no soft tissue.
  bool empty() const { return exchange_->empty(); }
  /// Call it before each step, in the thread of the steps. Returns the number of states taken so far. No allocation or
  /// lock; with Clock::Real it does not wait either. `is_due`: with Clock::Replay, whether this step takes a state.
  std::uint32_t take(std::uint64_t tick, runtime::Workspace& workspace, bool is_due = false) noexcept;
  /// Returns to the shape at rest, as after a reset of the workspace; with Clock::Real as soon as the solver is idle.
  /// Call it in the thread of the steps. No allocation; it does not wait.
  void restart() noexcept;

  /// The newest solved state. Call it from one thread, that of a view; with Clock::Replay from that of the steps.
  const TissueShapes& shapes() noexcept;

 private:
  enum Phase : int { kSolved, kAsked, kEnding };

  void solve() noexcept;
  void publish() noexcept;
  void rest() noexcept;
  void run() noexcept;

  const Clock clock_;
  const std::uint64_t ticks_per_state_;  // in lock step
  std::unique_ptr<scene::TissueExchange> exchange_;
  std::uint32_t taken_ = 0;
  bool rests_ = false;               // restart() waits for the solver
  std::atomic<int> phase_{kSolved};  // which thread may use the exchange
  view::TripleBuffer<TissueShapes> shapes_;
  std::thread thread_;
};

}  // namespace spheretree::player
