// SPDX-License-Identifier: Apache-2.0
// The current surface of soft tissue. For small deformations, displacements are linear in the forces, by the compliance
// matrix of the surface (core's TissueResponse). For large deformations they are relative to a base, which a solver
// outside of the step computes, instead of the shape at rest. The base moves there within about 40 ms, by at most
// kAimMotion in a step.
//
// In one step forces move no point by more than SoftTissue::motion(): the search adds this
// to its margin, so no contact is missed.
// Units: mm, N; frame: axes of the object, origin at the centre of its shape. Deterministic; no allocation after
// construction.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "tissue/moved_skin.h"
#include "tissue/soft_model.h"
#include "tissue/surface_response.h"
#include "tissue/tissue_base.h"

namespace spheretree::runtime {

class SoftSurface {
 public:
  /// `model` and `shape`, which is that of its tree, must outlive the object. @throws std::bad_alloc.
  SoftSurface(const SoftModel& model, const CompiledShape& shape);

  MovedSkin& skin() { return skin_; }
  const MovedSkin& skin() const { return skin_; }
  SurfaceResponse& response() { return response_; }
  bool isAtRest() const;

  /// Moves the base by `share` of its way, but no node by more than `max_motion` [mm]. In this step, forces move no
  /// node by more than `motion` [mm]. Then moves the balls of the search to their triangles. Cost: MovedSkin::refit().
  void beginStep(double share, double max_motion, double motion);
  /// Returns to the shape that the surface had before the last call of beginStep().
  void takeBack();
  /// Sets the target of the base: x, y, z of each pressed node. `surface` must stay valid until the next call.
  void aim(std::span<const float> surface) { base_.aim(surface); }
  std::span<const float> forces() const { return force_; }
  /// Returns to the shape at rest.
  void reset();

  /// Updates the flat triangles of these pairs to the current shape, but not their patches.
  void putTriangles(std::span<const std::uint32_t> pairs) { skin_.putTriangles(pairs, shift_); }
  /// Largest motion of a node by forces since the beginning of the step [mm].
  double motionSoFar() const { return motion_so_far_; }
  /// Updates the patches of these pairs to the current shape.
  void putPatches(std::span<const std::uint32_t> pairs) { skin_.put(pairs, shift_); }
  /// Displacement of a point by the forces; travelled() adds that of the base.
  Eigen::Vector3d given(const SkinPoint& point) const { return meanOf(point, &Moved::given); }
  Eigen::Vector3d travelled(const SkinPoint& point) const { return meanOf(point, &Moved::travelled); }
  double maxGive(const SkinPoint& point) const;
  /// Displacement of the point in this step: by the base, as far as the tool has not followed it; by base and forces.
  Eigen::Vector3d ahead(const SkinPoint& point) const;
  Eigen::Vector3d movedInStep(const SkinPoint& point) const;

  /// Sets the target forces of the next piece: none, or the current ones; press() then adds forces, one point after the
  /// other.
  void aimAt(bool from_now);
  void press(const SurfaceResponse::Press& on, const Eigen::Vector3d& force);
  /// Moves by `share` from the forces at the call of aimAt() towards the target forces, or by less if a node would move
  /// too far in this step.
  /// Cost: about 5 us for 450 nodes and a few contacts.
  void giveWay(double share);

 private:
  using Field = std::vector<float>;  // (pressed node) x, y, z

  /// Displacements of a vertex, computed once after each motion.
  struct Moved {
    Eigen::Vector3d given, travelled;
    std::uint32_t when = 0;  // the value of motions_
  };
  const Moved& movedVertex(std::uint32_t v) const;
  Eigen::Vector3d meanOf(const SkinPoint& point, Eigen::Vector3d Moved::*of) const;
  Eigen::Vector3d fieldAt(const SkinPoint& point, const Field& field) const;
  std::array<Field*, 11> fields() {
    return {&force_, &from_, &to_, &now_, &shift_, &from_now_, &to_now_, &start_force_, &start_, &bent_, &last_bent_};
  }
  void findShift();
  void applyForces(const Field& forces, Field& out) const;

  const SoftModel& model_;
  MovedSkin skin_;
  SurfaceResponse response_;
  Field force_, from_, to_;  // current forces; forces at the beginning of the piece; target forces
  TissueBase base_;
  Field now_, shift_;                  // displacements by the forces; by base and forces
  Field from_now_, to_now_;            // displacements by from_ and to_
  Field start_force_, start_;          // forces, and displacements by them, at the beginning of the step
  Field bent_, last_bent_;             // the shape is bent as for these displacements: now; in the last step
  double ahead_ = 0, from_ahead_ = 0;  // share of the way of the base that the tool has not followed: now; at the beginning of the piece
  bool is_pressed_ = false;            // otherwise all forces are zero, and the displacements by them
  bool knows_to_ = false;              // to_now_ is up to date with to_
  double motion_ = kTissueMotion;      // largest motion of a node in this step by forces [mm]
  double motion_so_far_ = 0;           // in this step
  bool has_moved_ = false;             // since the beginning of the last step
  mutable std::vector<Moved> moved_;   // (vertex)
  std::uint32_t motions_ = 1;
};

}  // namespace spheretree::runtime
