// SPDX-License-Identifier: Apache-2.0
// The skin of soft tissue in its current shape: its vertices move with the pressed nodes, by TissueResponse::points.
//
// Flat triangles have their corners at the vertices. Normals rotate like those of the tetrahedra's surface, so that
// they stay continuous from patch to patch. Faces of the tetrahedra and sides of the skin bulge further out the more
// the angle between the normals at their ends increases, so that a dent is as round as its normals, without facets. The
// bulge is computed at the beginning of the step: within the step the surface moves linearly with the nodes, as the QP
// assumes.
//
// The balls of the search are updated, a block of eight at a time, when the nodes that move them have moved by
// kRefitMm; they have room for every bulge. The flat triangles that they find are then updated exactly, and the patches
// of those that are near.
// Units: mm; frame: axes of the object, origin at the centre of its shape. No allocation after construction.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "kernel/kernel.h"
#include "scene/compiled_scene.h"
#include "state/soft_tissue.h"
#include "tissue/soft_model.h"

namespace spheretree::runtime {

class MovedSkin {
 public:
  /// `model` and `shape` must outlive the object; `shape` has the skin of the model's tree. @throws std::bad_alloc.
  MovedSkin(const SoftModel& model, const CompiledShape& shape);

  const Block* bound() const { return bound_.data(); }
  const CompiledPatch* patches() const { return patches_.data(); }
  double radius() const { return radius_; }  // of a ball about the centre that contains all triangles [mm]
  /// Allowance of the triangles whose curved patches were updated in this step [mm].
  float allowance() const { return allowance_; }
  /// Bound of the distance between any patch and its flat triangle, however the tissue is bent [mm].
  float largestSwing() const { return largest_swing_; }

  /// Returns to the shape at rest.
  void reset();
  /// Moves the balls of the search to the current shape; `shift`: displacement of each pressed node. Cost: 5 ns a node,
  /// and 30 ns for each updated block of eight triangles.
  void refit(std::span<const float> shift);
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
  void forget() { ++version_; }
  /// Updates the corners of the flat triangles of these slots of the search tree.
  void putTriangles(std::span<const std::uint32_t> pairs, std::span<const float> shift);
  /// Updates the patches of these slots of the search tree: their positions, and once in a step how they are bent.
  void put(std::span<const std::uint32_t> pairs, std::span<const float> shift);

 private:
  // The shape of a step, with the value of bends_ for which it was computed. Together, as in SoftModel.
  struct Bent {
    Eigen::Vector3f moved, bulge, normal;  // moved: displacement at the last bend()
    PackedDirection packed;
    std::uint32_t bend = 0;
  };
  struct alignas(64) Vertex : Bent {
    Eigen::Vector3f place;
    std::uint32_t version = 0;  // of `place`
  };
  struct alignas(64) Middle : Bent {
    Eigen::Vector3f offset;  // from the middle of the flat edge
  };
  class Turn;
  struct Fan {
    Eigen::Vector3f normal;
    std::uint32_t bend = 0;
  };
  struct Patch {
    float swing = 0;  // out of its flat triangle [mm]
    std::uint32_t bend = 0, version = 0, corners_version = 0;
  };

  float bulgeOf(const SoftModel::Node& node) const;
  Turn bendNode(const SoftModel::Node& node, Bent& out);
  const Eigen::Vector3f& fanNormal(std::uint32_t fan);
  const Vertex& bentVertex(std::uint32_t vertex);
  const Middle& bentMiddle(std::uint32_t edge);
  const Eigen::Vector3f& placeOf(std::uint32_t vertex, std::span<const float> shift);
  void bendPatch(std::uint32_t triangle);
  void putPatch(std::uint32_t triangle, std::span<const float> shift);
  void shiftBlock(std::size_t block);
  void encloseBlocks();

  const SoftModel& model_;
  const CompiledShape& shape_;
  const Skin& skin_;
  const Eigen::Vector3f offset_;  // from the origin of the shape's frame to that of the file's frame [mm]
  const float rest_allowance_;
  float largest_swing_ = 0;

  std::vector<std::uint32_t> parents_;  // (block) slot of the node whose children it contains
  std::vector<std::uint32_t> block_begin_,
      nodes_of_;  // (block + 1) index into nodes_of_: the nodes that move its triangles, possibly including kNone
  std::vector<std::uint32_t> node_begin_, blocks_of_;  // (pressed node + 1) index into blocks_of_: the blocks that it moves
  std::vector<float> put_shift_;                       // (pressed node) x, y, z: displacement at the last update of the balls
  std::vector<char> block_marked_;
  std::vector<Block> rest_;  // balls of the triangles at rest, with room for every bend
  std::vector<Block> bound_;
  double radius_ = 0;

  std::vector<CompiledPatch> patches_;
  std::vector<Vertex> vertices_;
  std::vector<Middle> middles_;  // (edge)
  std::vector<Fan> fans_;
  std::vector<Patch> patch_states_;           // (triangle)
  std::vector<Eigen::Vector3f> node_places_;  // (node of the tetrahedra's surface) at the last bend()
  std::uint32_t bends_ = 1, version_ = 1;
  float allowance_ = 0;
  std::vector<SoftPoint> points_;
  std::uint32_t step_ = 1;
};

}  // namespace spheretree::runtime
