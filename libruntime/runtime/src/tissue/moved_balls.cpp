// SPDX-License-Identifier: Apache-2.0
#include "tissue/moved_balls.h"

#include <algorithm>
#include <limits>

#include "spheretree/core/float_vector.h"
#include "state/soft_tissue.h"

namespace spheretree::runtime {
namespace {

using Eigen::Vector3d;

// Inverts a list of lists of indices.
void invert(const std::vector<std::uint32_t>& begin, const std::vector<std::uint32_t>& members, std::size_t count,
            std::vector<std::uint32_t>& out_begin, std::vector<std::uint32_t>& out) {
  out_begin.assign(count + 1, 0);
  for (const std::uint32_t m : members)
    if (m != kNone) ++out_begin[m + 1];
  for (std::size_t i = 0; i < count; ++i) out_begin[i + 1] += out_begin[i];
  out.resize(out_begin.back());
  std::vector<std::uint32_t> next = out_begin;
  for (std::uint32_t list = 0; list + 1 < begin.size(); ++list)
    for (std::uint32_t i = begin[list]; i < begin[list + 1]; ++i)
      if (members[i] != kNone) out[next[members[i]]++] = list;
}

}  // namespace

MovedBalls::MovedBalls(const SoftModel& model, const CompiledShape& shape, std::span<const float> room)
    : model_(model),
      shape_(shape),
      parents_(shape.skin.tree.bound.size(), kNoItem),
      put_shift_(3 * model.node_count),
      block_marked_(shape.skin.tree.bound.size(), 0) {
  const CompiledTree& tree = shape.skin.tree;
  rest_ = tree.bound;
  block_begin_.push_back(0);
  for (std::size_t b = 0; b < tree.bound.size(); ++b) {
    std::vector<std::uint32_t> nodes;
    for (std::size_t slot = 8 * b; slot < 8 * b + 8; ++slot) {
      if (slot % 8 < tree.links[b].inner) parents_[tree.links[b].first_child + slot % 8] = static_cast<std::uint32_t>(slot);
      if (tree.item[slot] == kNoItem) continue;
      const SkinTriangle& triangle = model.tree->skin.triangles[tree.item[slot]];
      for (const std::uint32_t v : triangle.vertex)
        for (std::size_t k = 0; k < 3; ++k)
          if (const PressPoint& point = model.vertices[v].point; point.weight[k] > 0) nodes.push_back(point.node[k]);
      rest_[b].r[slot % 8] += room[tree.item[slot]];
    }
    std::sort(nodes.begin(), nodes.end());
    nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
    nodes_of_.insert(nodes_of_.end(), nodes.begin(), nodes.end());
    block_begin_.push_back(static_cast<std::uint32_t>(nodes_of_.size()));
  }
  invert(block_begin_, nodes_of_, model.node_count, node_begin_, blocks_of_);
}

void MovedBalls::reset() {
  std::fill(put_shift_.begin(), put_shift_.end(), 0.0f);
  bound_ = rest_;
  std::fill(block_marked_.begin(), block_marked_.end(), 1);
  encloseBlocks();
}

void MovedBalls::refit(std::span<const float> shift) {
  bool any = false;
  for (std::uint32_t node = 0; node < model_.node_count; ++node) {
    const float* const now = shift.data() + 3 * node;
    float* const was = put_shift_.data() + 3 * node;
    const float x = now[0] - was[0], y = now[1] - was[1], z = now[2] - was[2];
    if (!(x * x + y * y + z * z > static_cast<float>(kRefitMm * kRefitMm))) continue;
    std::copy_n(now, 3, was);
    for (std::uint32_t i = node_begin_[node]; i < node_begin_[node + 1]; ++i) block_marked_[blocks_of_[i]] = 1;
    any = true;
  }
  if (any) encloseBlocks();
}

// A point of a triangle moves by a weighted mean of the displacements of the nodes that move the block. None of these
// is farther from the centre of their bounding box than half of its diagonal.
void MovedBalls::shiftBlock(std::size_t b) {
  Eigen::Array3f low = Eigen::Array3f::Constant(std::numeric_limits<float>::infinity()), high = -low;
  for (std::uint32_t i = block_begin_[b]; i < block_begin_[b + 1]; ++i) {
    Eigen::Array3f u = Eigen::Array3f::Zero();
    if (nodes_of_[i] != kNone) u = Eigen::Map<const Eigen::Array3f>(put_shift_.data() + 3 * std::size_t{nodes_of_[i]});
    low = low.min(u), high = high.max(u);
  }
  const Eigen::Array3f middle = 0.5f * (low + high);
  const float more = lengthOf((high - middle).matrix());
  const Block& rest = rest_[b];
  Block& block = bound_[b];
  for (std::size_t lane = shape_.skin.tree.links[b].inner; lane < 8; ++lane) {
    if (rest.x[lane] == kFarAway) continue;
    block.x[lane] = rest.x[lane] + middle.x();
    block.y[lane] = rest.y[lane] + middle.y();
    block.z[lane] = rest.z[lane] + middle.z();
    block.r[lane] = (rest.r[lane] + more) * (1 + 1e-6f);
  }
}

// Encloses everything below inner nodes in balls; the blocks of children follow that of their parent.
void MovedBalls::encloseBlocks() {
  for (std::size_t b = bound_.size(); b-- > 1;) {
    if (!block_marked_[b]) continue;
    block_marked_[b] = 0;
    if (block_begin_[b + 1] > block_begin_[b]) shiftBlock(b);
    const Block& block = bound_[b];
    Eigen::Array3f low = Eigen::Array3f::Constant(std::numeric_limits<float>::infinity()), high = -low;
    for (std::size_t lane = 0; lane < 8; ++lane) {
      if (block.x[lane] == kFarAway) continue;
      const Eigen::Array3f c(block.x[lane], block.y[lane], block.z[lane]);
      low = low.min(c), high = high.max(c);
    }
    const Vector3d centre = (0.5f * (low + high)).matrix().cast<double>();
    double radius = 0;
    for (std::size_t lane = 0; lane < 8; ++lane)
      if (block.x[lane] != kFarAway)
        radius =
            std::max(radius, (Vector3d(block.x[lane], block.y[lane], block.z[lane]) - centre).norm() + static_cast<double>(block.r[lane]));
    const std::uint32_t parent = parents_[b];
    runtime::put(bound_[parent / 8], parent % 8, centre, static_cast<float>(radius * (1 + 1e-6)));
    block_marked_[parent / 8] = 1;
  }
  block_marked_[0] = 0;
  const Block& root = bound_[0];
  radius_ = std::max(shape_.radius, Vector3d(root.x[0], root.y[0], root.z[0]).norm() + static_cast<double>(root.r[0]));
}

}  // namespace spheretree::runtime
