// SPDX-License-Identifier: Apache-2.0
// The surface of soft tissue as it is now. Small motion: displacements are linear in the forces that press, by the
// compliance matrix of the surface (core's TissueResponse). Large motion: they count from a base that a solver outside
// of the step says, not from rest. The base goes there within some 40 ms, no faster than kTissueMotion in a step.
//
// A force on a point of a triangle of the skin is shared by its corners, and by the nodes that they go with. In one
// step no point moves by more than kTissueMotion: the search looks that much farther, so nothing is passed through.
// Units: mm, N; frame: axes of the object, about the centre of its shape. Deterministic; no allocation once it is made.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "moved_skin.h"
#include "soft_model.h"

namespace spheretree::runtime {

/// A point of a triangle of the skin.
struct SkinPoint {
  std::uint32_t triangle = 0;
  std::array<double, 3> weight{};  // of the corners; >= 0, they add up to 1
};

class SoftSurface {
 public:
  /// `model` and `shape`, which is that of its tree, outlive this. @throws std::bad_alloc.
  SoftSurface(const SoftModel& model, const CompiledShape& shape);

  MovedSkin& skin() { return skin_; }
  const MovedSkin& skin() const { return skin_; }
  bool isAtRest() const;

  /// The base goes `part` of its way, but no node farther than `most` [mm]; then puts the balls of the search to where
  /// their triangles are. Cost: MovedSkin::refit().
  void beginStep(double part, double most);
  /// Where the base goes from now on: x, y, z of each pressed node. Held until the next call.
  void aim(std::span<const float> surface);
  std::span<const float> forces() const { return force_; }
  /// At rest again.
  void reset();

  /// Puts the patches of these pairs to where they are now.
  void putPatches(std::span<const std::uint32_t> pairs) { skin_.put(pairs, shift_); }
  /// The point of a triangle, whose patch was put, that is nearest to `p` up to how much the patch is curved.
  SkinPoint pointAt(std::uint32_t triangle, const Eigen::Vector3d& p) const;
  /// Of a point: what forces displace it by, and with the base.
  Eigen::Vector3d given(const SkinPoint& point) const { return fieldAt(point, now_); }
  Eigen::Vector3d travelled(const SkinPoint& point) const { return fieldAt(point, shift_); }
  double mostGive(const SkinPoint& point) const;

  /// What a force on a point is on the pressed nodes.
  struct Press {
    std::array<std::uint32_t, 9> node;
    std::array<double, 9> weight;
    std::size_t count = 0;
  };
  Press pressOn(const SkinPoint& point) const;

  // Where nodes go under forces, without doing it; only nodes that move points which are near.
  void forgetNear();
  void addNear(std::uint32_t triangle);
  std::size_t nearCount() const { return near_.size(); }
  /// How the near nodes move under `force` on a point: x, y, z of each. Cost: about 0.1 us for each node pressed, and
  /// for each ten that are near.
  void respond(const Press& press, const Eigen::Vector3d& force, std::span<double> near) const;
  /// The mean of such a field that `of` moves by.
  Eigen::Vector3d meanOf(const Press& of, std::span<const double> near) const;
  /// What predicted() answers from.
  void predict(std::span<const double> near);
  Eigen::Vector3d predicted(const SkinPoint& point) const;

  /// The forces that press in the piece to come: none, or those of now; then more on one point after the other.
  void aimAt(bool from_now);
  void press(const Press& on, const Eigen::Vector3d& force);
  /// Goes `part` of the way there, from where aimAt() began; less, if a node would move too far for this step.
  /// Cost: about 5 us for 450 nodes and a few contacts.
  void giveWay(double part);

 private:
  using Field = std::vector<float>;  // (pressed node) x, y, z

  Eigen::Vector3d fieldAt(const SkinPoint& point, const Field& field) const;
  void followAim(double part, double most);
  void findShift();
  void applyForces(const Field& forces, Field& out) const;

  const SoftModel& model_;
  MovedSkin skin_;
  std::vector<std::array<std::uint32_t, 3>> corners_;  // (triangle) vertices
  Field force_, from_, to_;                            // now; where the piece begins; where it leads
  Field now_, base_, shift_;                           // displacements by the forces; what they count from; both
  Field from_now_, to_now_;                            // what from_ and to_ do
  Field start_force_, start_;                          // forces and what they do when the step began
  bool knows_to_ = false;                              // to_now_ is that of to_
  std::span<const float> aim_;                         // where the base goes; empty: it stays
  double left_ = 0;                                    // the farthest way of a node to its aim [mm]
  bool has_moved_ = false;                             // since the last step began
  std::vector<std::uint32_t> near_, near_at_;          // pressed nodes that are near; (pressed node) its index among them, or ~0u
  std::vector<std::uint32_t> near_vertices_;
  std::vector<char> is_near_;               // (vertex)
  std::vector<Eigen::Vector3f> predicted_;  // (vertex)
};

}  // namespace spheretree::runtime
