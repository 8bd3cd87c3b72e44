// SPDX-License-Identifier: Apache-2.0
// The skin of soft tissue where it is now: its vertices go with the pressed nodes, by TissueResponse::points.
//
// Flat triangles have their corners where the vertices are. Normals turn as those of the tetrahedra's surface do, so
// that they stay continuous from patch to patch; and faces of the tetrahedra and sides of the skin bulge out by as much
// more as the normals at their ends lean apart more. So a dent that is pressed in is as round as its normals say, not
// made of facets. How much they bulge is that of the beginning of the step: within it the surface moves linearly with
// the nodes, as the QP takes for granted.
//
// The balls of the search are put anew, a block of eight at a time, once what moves them has moved by kRefitMm; patches
// are put to the very place before rows are made of them, those alone.
// Units: mm; frame: axes of the object, about the centre of its shape. No allocation once it is made.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "compiled_scene.h"
#include "kernel.h"
#include "soft_model.h"

namespace spheretree::runtime {

class MovedSkin {
 public:
  /// `model` and `shape`, which has the skin of its tree, outlive this. @throws std::bad_alloc.
  MovedSkin(const SoftModel& model, const CompiledShape& shape);

  const Block* bound() const { return bound_.data(); }
  const CompiledPatch* patches() const { return patches_.data(); }
  double radius() const { return radius_; }  // of a ball about the centre that holds all triangles [mm]
  /// Of the curved patches that were put in this step: what their triangles give way [mm].
  float allowance() const { return allowance_; }

  /// At rest.
  void reset();
  /// Puts the balls of the search to where the pressed nodes have gone, `shift` of each. Cost: 5 ns a node, and 30 ns
  /// for each block of eight triangles that is put anew.
  void refit(std::span<const float> shift);
  /// A step begins: points of contact are looked for anew, and stay once rows were made kFreeRows times.
  void beginStep() { ++step_, rows_made_ = 0; }
  SoftPoint* points() { return points_.data(); }
  std::uint32_t step() const { return step_; }
  bool pointsStay() const { return rows_made_ > kFreeRows; }
  /// The shape that patches have in a step which begins with this displacement of the pressed nodes.
  void bend(std::span<const float> shift);
  /// The places of patches that were put before are no longer true.
  void forget() { ++version_; }
  /// Puts the patches of these slots of the search tree. Cost: about 60 ns a patch that was not put since forget(),
  /// 200 ns one that was not put in this step.
  void put(std::span<const std::uint32_t> pairs, std::span<const float> shift);

 private:
  static constexpr int kFreeRows = 1;  // of a step, whose points are those of their own pose

  struct Vertex {
    Eigen::Vector3f bulge, normal, node_normal;
  };
  struct Middle {
    Eigen::Vector3f offset, normal;
  };

  float bulgeAt(std::uint32_t vertex) const;
  const Eigen::Vector3f& fanNormal(std::uint32_t fan);
  const Vertex& bentVertex(std::uint32_t vertex);
  const Middle& bentMiddle(std::uint32_t edge);
  const Eigen::Vector3f& placeOf(std::uint32_t vertex, std::span<const float> shift);
  void putPatch(std::uint32_t triangle, std::span<const float> shift);
  void shiftBlock(std::size_t block);
  void encloseBlocks();

  const SoftModel& model_;
  const CompiledShape& shape_;
  const Skin& skin_;
  const Eigen::Vector3f offset_;  // of the frame of the file in that of the shape [mm]
  const float rest_allowance_;
  float slack_ = 0;  // how much farther than at rest a patch can reach beyond its flat triangle [mm]

  std::vector<std::uint32_t> parents_;                 // (block) slot of the node whose children stand in it
  std::vector<std::uint32_t> block_begin_, nodes_of_;  // (block + 1) into the other: what moves its triangles; kHeldNode among them
  std::vector<std::uint32_t> node_begin_, blocks_of_;  // (pressed node + 1) into the other: the blocks that it moves
  std::vector<float> put_shift_;                       // (pressed node) x, y, z: as the balls were put
  std::vector<char> block_marked_;
  std::vector<Block> bound_;
  double radius_ = 0;

  std::vector<CompiledPatch> patches_;
  std::vector<Vertex> vertices_;
  std::vector<Middle> middles_;
  std::vector<Eigen::Vector3f> fan_normals_;
  std::vector<Eigen::Vector3f> places_;                              // (vertex)
  std::vector<float> bent_;                                          // (pressed node) x, y, z: of bend()
  std::vector<std::uint32_t> vertex_when_, middle_when_, fan_when_;  // the bend that they are of
  std::vector<std::uint32_t> place_when_, patch_when_;               // the version that they are of
  std::uint32_t bends_ = 1, version_ = 1;
  float allowance_ = 0;
  std::vector<SoftPoint> points_;  // (slot)
  std::uint32_t step_ = 1;
  int rows_made_ = 0;
};

}  // namespace spheretree::runtime
