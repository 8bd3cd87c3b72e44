// SPDX-License-Identifier: Apache-2.0
// Large deformation of the soft tissue of a scene: forces go from the steps to solvers, and states of the surface come
// back. Two threads share it, without a lock: while one has called exchange() and the other not yet solve(), only
// solve() may be called, and the other way round. Who calls when is up to the caller.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "spheretree/runtime/step.h"
#include "spheretree/tissue/moving_tissue.h"

namespace spheretree::scene {

inline constexpr int kQuiet = 100;  // consecutive states without forces after which tissue is at rest

class TissueExchange {
 public:
  /// The tissue of `scene`, which must outlive the object. Returns null, with a sentence in `fault`, if a solver cannot
  /// handle the tissue of an object.
  static std::unique_ptr<TissueExchange> make(const runtime::Scene& scene, std::string& fault);

  /// True if the scene has no soft tissue.
  bool empty() const { return bodies_.empty(); }
  /// In the thread of the steps, between two of them: gives the last states to the workspace, and takes the forces for
  /// the next ones. Returns false if all tissue is at rest: then nothing changed, and solve() has nothing to do. No
  /// allocation, no waiting.
  bool exchange(runtime::Workspace& workspace) noexcept;
  /// In any thread, after exchange() returned true: computes the next states. No allocation. Cost: about 8 ms for 2,500
  /// tetrahedra.
  void solve() noexcept;
  /// Returns to the shape at rest, as after a reset of the workspace.
  void restart() noexcept;

  struct Body {
    std::size_t object;  // in the scene
    std::unique_ptr<tissue::MovingTissue> motion;
    std::vector<float> forces;
    tissue::TissueState taken, solved;        // used by the workspace; written by the solver
    int quiet = kQuiet;                       // consecutive states without forces
    std::vector<Eigen::Vector3f> shape = {};  // displacements of its nodes in the newest state [mm]
    bool is_solved = false;                   // whether `solved` will receive a new state
  };
  /// In the thread of solve().
  const std::vector<Body>& bodies() const { return bodies_; }

 private:
  TissueExchange() = default;
  std::vector<Body> bodies_;
};

}  // namespace spheretree::scene
