// SPDX-License-Identifier: Apache-2.0
// The skin of soft tissue in its current shape: its vertices move with the pressed nodes, by TissueResponse::points.
//
// The flat triangles that a search finds among the balls are updated exactly, and the patches of those that are near.
// Units: mm; frame: axes of the object, origin at the centre of its shape. No allocation after construction.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "kernel/kernel.h"
#include "scene/compiled_scene.h"
#include "state/soft_tissue.h"
#include "tissue/bent_surface.h"
#include "tissue/moved_balls.h"
#include "tissue/soft_model.h"

namespace spheretree::runtime {

class MovedSkin {
 public:
  /// `model` and `shape` must outlive the object; `shape` has the skin of the model's tree. @throws std::bad_alloc.
  MovedSkin(const SoftModel& model, const CompiledShape& shape);

  const Block* bound() const { return balls_.bound(); }
  const CompiledPatch* patches() const { return patches_.data(); }
  double radius() const { return balls_.radius(); }  // of a ball about the centre that contains all triangles [mm]
  /// Allowance of the triangles whose curved patches were updated in this step [mm].
  float allowance() const { return allowance_; }
  /// Bound of the distance between any patch and its flat triangle, however the tissue is bent [mm].
  float largestSwing() const { return largest_swing_; }

  /// Returns to the shape at rest.
  void reset();
  /// Moves the balls of the search to the current shape; `shift`: displacement of each pressed node.
  void refit(std::span<const float> shift) { balls_.refit(shift); }
  /// Begins a step, in which points of contact are found again.
  void beginStep() { ++step_; }
  SoftPoint* points() { return points_.data(); }
  std::uint32_t step() const { return step_; }
  void setStuck(std::uint32_t pair, bool is_stuck) {
    if (SoftPoint& point = pointOf(points_.data(), pair); point.pair == pair) point.stuck = is_stuck ? step_ : 0;
  }
  /// Sets the shape of the patches for a step that begins with this displacement of the pressed nodes.
  void bend(std::span<const float> shift);
  /// Marks the positions of all patches as outdated.
  void forget() { bent_.forget(); }
  /// Updates the corners of the flat triangles of these slots of the search tree.
  void putTriangles(std::span<const std::uint32_t> pairs, std::span<const float> shift);
  /// Updates the patches of these slots of the search tree: their positions, and once in a step how they are bent.
  void put(std::span<const std::uint32_t> pairs, std::span<const float> shift);

  /// The point of a triangle that is nearest to `p`, approximately if its patch is curved. The patch must be up to
  /// date.
  SkinPoint pointAt(std::uint32_t triangle, const Eigen::Vector3d& p) const;

 private:
  struct Patch {
    float swing = 0;  // out of its flat triangle [mm]
    std::uint32_t bend = 0, version = 0, corners_version = 0;
  };

  void bendPatch(std::uint32_t triangle);
  void putPatch(std::uint32_t triangle, std::span<const float> shift);

  const SoftModel& model_;
  const CompiledShape& shape_;
  const Skin& skin_;
  const float rest_allowance_;
  float largest_swing_ = 0;

  BentSurface bent_;
  MovedBalls balls_;
  std::vector<CompiledPatch> patches_;
  std::vector<Patch> patch_states_;  // (triangle)
  float allowance_ = 0;
  std::vector<SoftPoint> points_;
  std::uint32_t step_ = 1;
};

}  // namespace spheretree::runtime
