// SPDX-License-Identifier: Apache-2.0
// The balls in which the search looks for triangles of soft tissue. They are updated, a block of eight at a time, when
// the nodes that move them have moved by kRefitMm.
// Units: mm; frame: axes of the object, origin at the centre of its shape. No allocation after construction.
#pragma once

#include <span>
#include <vector>

#include "scene/compiled_scene.h"
#include "tissue/soft_model.h"

namespace spheretree::runtime {

class MovedBalls {
 public:
  /// `model` and `shape` must outlive the object. `room`: how far the patch of each triangle may leave the flat
  /// triangle [mm]. @throws std::bad_alloc.
  MovedBalls(const SoftModel& model, const CompiledShape& shape, std::span<const float> room);

  const Block* bound() const { return bound_.data(); }
  double radius() const { return radius_; }  // of a ball about the centre that contains all triangles [mm]

  /// Returns to the shape at rest.
  void reset();
  /// Moves the balls to the current shape; `shift`: displacement of each pressed node. Cost: 5 ns a node, and 30 ns for
  /// each updated block of eight triangles.
  void refit(std::span<const float> shift);

 private:
  void shiftBlock(std::size_t block);
  void encloseBlocks();

  const SoftModel& model_;
  const CompiledShape& shape_;
  std::vector<std::uint32_t> parents_;  // (block) slot of the node whose children it contains
  std::vector<std::uint32_t> block_begin_,
      nodes_of_;  // (block + 1) index into nodes_of_: the nodes that move its triangles, possibly including kNone
  std::vector<std::uint32_t> node_begin_, blocks_of_;  // (pressed node + 1) index into blocks_of_: the blocks that it moves
  std::vector<float> put_shift_;                       // (pressed node) x, y, z: displacement at the last update of the balls
  std::vector<char> block_marked_;
  std::vector<Block> rest_;  // balls of the triangles at rest, with room for every bend
  std::vector<Block> bound_;
  double radius_ = 0;
};

}  // namespace spheretree::runtime
