// SPDX-License-Identifier: GPL-3.0-or-later
// Large motion of the soft tissue of a scene, beside the servo loop: forces go to a solver in a thread of its own, and
// leaves come back. The loop never waits: it takes a state when there is one, and hands the forces of that moment over
// for the next. So which steps took a state is all that a run depends on beside its poses, and a replay does the same.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <thread>
#include <vector>

#include "spheretree/runtime/step.h"
#include "spheretree/tissue/moving_tissue.h"
#include "streams/triple_buffer.h"

namespace spheretree::player {

inline constexpr int kQuiet = 100;                 // states under no force, after which tissue is at rest
inline constexpr std::uint64_t kTissueTicks = 10;  // from state to state in lock step

/// What a view shows: displacements of the nodes of each object, empty if it is rigid [mm].
using TissueShapes = std::vector<std::vector<Eigen::Vector3f>>;

class TissueMotion {
 public:
  enum class Clock {
    Real,     // a thread of its own
    Stepped,  // in the thread of the steps, at every kTissueTicks: the same bytes every time
    Replay,   // in the thread of the steps, when take() is told so
  };
  /// `scene` must outlive it. @throws formats::FormatError if the tissue of an object cannot be solved for.
  TissueMotion(const runtime::Scene& scene, Clock clock);
  ~TissueMotion();
  TissueMotion(const TissueMotion&) = delete;
  TissueMotion& operator=(const TissueMotion&) = delete;

  /// Whether there is any soft tissue.
  bool empty() const { return bodies_.empty(); }
  /// Before each step, in its thread. No allocation or lock; with Clock::Real it does not wait either. How many states
  /// were taken so far. `is_due`: with Clock::Replay, whether this step takes one.
  std::uint32_t take(std::uint64_t tick, runtime::Workspace& workspace, bool is_due = false) noexcept;
  /// At rest again, as after a reset of the workspace. Not with Clock::Real.
  void restart() noexcept;

  /// The newest state that was solved. From one thread, that of a view; with Clock::Replay that of the steps.
  const TissueShapes& shapes() noexcept;

 private:
  struct Body {
    std::size_t object;
    std::unique_ptr<tissue::MovingTissue> motion;
    std::vector<float> forces;
    tissue::TissueState taken, solved;        // held by the workspace; of the solver
    int quiet = kQuiet;                       // states in a row under no force
    std::vector<Eigen::Vector3f> shape = {};  // the newest
    bool is_solved = false;                   // there will be a new one in `solved`
  };
  enum Phase : int { kSolved, kAsked, kEnding };

  void solve() noexcept;
  void run() noexcept;

  const Clock clock_;
  std::vector<Body> bodies_;
  std::uint32_t taken_ = 0;
  std::atomic<int> phase_{kSolved};  // whose turn it is with the bodies
  view::TripleBuffer<TissueShapes> shapes_;
  std::thread thread_;
};

}  // namespace spheretree::player
