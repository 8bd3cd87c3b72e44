// SPDX-License-Identifier: Apache-2.0
// The leaves of soft tissue as they are now. Small motion: displacements are linear in the forces that press, by the
// compliance matrix of the surface (core's TissueResponse). A leaf keeps its radius and goes where its point goes.
// Large motion: the leaves count from a base that a solver outside of the step says, with its radii, not from rest.
// The base goes there within some 40 ms, evenly, and in the next steps with the load, as the solver says of its state;
// no faster than aimed leaves may go in a step. Between two states of
// which each is covered by its leaves, the leaves on the way cover the states on the way: a ball is convex.
//
// At the beginning of a step the leaves are put to where their points are. Within the step each gives way along the
// normal of its row by as much as its point has moved since; one that has moved by less than kRefitMm stays as it was
// put before. In one step no point moves by more than kTissueMotion: the search looks that much farther, so nothing is
// passed through.
// Units: mm, N; frame: axes of the object, about the centre of its shape. Deterministic; no allocation once it is made.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "compiled_scene.h"
#include "soft_tissue.h"

namespace spheretree::runtime {

/// How forces move the points of the leaves.
struct LinearModel : TissueModel {
  std::size_t node_count = 0;          // pressed nodes
  std::span<const PressPoint> points;  // (leaf) what a leaf goes with
  std::vector<float> most_give;        // (leaf) its point moves no farther along a normal [mm]
  std::span<const float> matrix;       // (column: pressed node, axis of the force) x (pressed node, axis) [mm/N]

  const float* column(std::size_t i) const { return matrix.data() + i * 3 * node_count; }
};
LinearModel linearModel(std::shared_ptr<const Tissue> tissue);

class SoftSurface {
 public:
  /// `model` and `shape`, which is that of its tree, outlive this. @throws std::bad_alloc.
  SoftSurface(const LinearModel& model, const CompiledShape& shape);

  const Block* bound() const { return bound_.data(); }
  const Sphere* spheres() const { return spheres_.data(); }
  double radius() const { return radius_; }  // of a ball about the centre that holds all leaves

  /// The base goes `part` of its way, but no leaf farther than `most` [mm]; then puts the leaves to where their points
  /// are. Cost: about 10 ns a leaf, 5 ns more while the base moves, 50 ns for each block in which a leaf was put anew.
  void beginStep(double part, double most);
  /// Where the base goes from now on: leaves as they are in the file. Held until the next call, as is the tangent.
  void aim(std::span<const Sphere> leaves, const TissueTangent& tangent);
  std::span<const float> forces() const { return force_; }
  /// At rest again.
  void reset();

  /// Of the point of a leaf: where it is, off its base and off its place at rest.
  Eigen::Vector3d displacement(std::uint32_t leaf) const { return model_.points[leaf].displacementIn(now_); }
  Eigen::Vector3d travelled(std::uint32_t leaf) const { return displacement(leaf) + base_[leaf].centre - restOf(leaf).centre; }
  /// Of the leaf: off where beginStep() had put it.
  Eigen::Vector3d sinceRefit(std::uint32_t leaf) const { return displacement(leaf) + base_[leaf].centre - put_[leaf].centre; }
  double grownSinceRefit(std::uint32_t leaf) const { return base_[leaf].radius - put_[leaf].radius; }
  double mostGive(std::uint32_t leaf) const { return static_cast<double>(model_.most_give[leaf]); }

  /// How the point of leaf `of` moves under `force` on the point of leaf `on`. Cost: 80 ns.
  Eigen::Vector3d response(std::uint32_t of, std::uint32_t on, const Eigen::Vector3d& force) const;

  /// Where points go under forces, without doing it; only the points of leaves that are near.
  void forgetNear();
  void addNear(std::uint32_t leaf);
  void predictNothing();
  void predict(std::uint32_t leaf, const Eigen::Vector3d& force);  // cost: about 0.1 us, and 5 ns for each node that is near
  Eigen::Vector3d predicted(std::uint32_t leaf) const;

  /// The forces that press in the piece to come: none, or those of now; then more on one leaf after the other.
  void aimAt(bool from_now);
  void press(std::uint32_t leaf, const Eigen::Vector3d& force);
  /// Goes `part` of the way there, from where aimAt() began; less, if a node would move too far for this step.
  /// Cost: about 5 us for 450 nodes and a few contacts.
  void giveWay(double part);

 private:
  using Field = std::vector<float>;  // (pressed node) x, y, z
  struct Ball {
    Eigen::Vector3d centre;
    double radius;
  };

  Ball restOf(std::uint32_t leaf) const;
  double loadOf(const Field& forces) const;
  Eigen::Vector4d rateOf(std::size_t leaf) const;
  Eigen::Vector4d leftOf(std::size_t leaf) const;
  void followAim(double part, double most);
  void respond(const Field& forces, Field& out) const;
  void putLeaf(std::uint32_t leaf);
  void encloseBlocks();

  const LinearModel& model_;
  const CompiledShape& shape_;
  const Eigen::Vector3d offset_;        // of the spheres of the file in the frame of the shape [mm]
  std::vector<std::uint32_t> slots_;    // (leaf) in the compiled tree
  std::vector<std::uint32_t> parents_;  // (block) slot of the node whose children stand in it
  double radius_ = 0;
  std::vector<Block> bound_;
  std::vector<Sphere> spheres_;
  Field force_, from_, to_;       // now; where the piece begins; where it leads
  Field now_;                     // displacements
  Field start_force_, start_;     // both when the step began
  std::vector<Ball> base_, put_;  // (leaf) without what the forces do; as it was put last
  std::span<const Sphere> aim_;   // where the base goes; empty: it stays
  std::span<const float> load_;   // of the TissueTangent, as
  std::span<const Sphere> rates_;
  double amount_ = 1;     // of the load, that the base has followed
  double left_ = 0;       // the farthest way of a leaf to its aim, change of its radius included [mm]
  double most_rate_ = 0;  // of all leaves, summed up likewise
  std::vector<char> block_marked_;
  bool has_moved_ = false;                     // since the leaves were put last, or has forces on it
  std::vector<std::uint32_t> near_, near_at_;  // pressed nodes that are near; (pressed node) its index among them, or ~0u
  std::vector<float> predicted_;               // (near) x, y, z
};

}  // namespace spheretree::runtime
