// SPDX-License-Identifier: Apache-2.0
#include "cut/cut_layers.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "kernel/vector_lanes.h"
#include "scene/winding_number.h"

namespace spheretree::runtime {
namespace {

using Eigen::Vector3d;

constexpr std::uint32_t kTriangleWork = 3;  // cost of the distances of 8 points from a triangle, in tests of 8 points

// Calls take(triangle, squared distance) for the triangles within `limit` of the point, which may become smaller.
template <class Take>
void forNear(const CompiledSkin& skin, const Vector3d& point, const float& limit, std::uint32_t& work, const Take& take) {
  std::array<std::uint32_t, 128> open{};  // blocks; each level of the tree adds at most 7
  std::size_t count = 1;
  const F8 x = splat(static_cast<float>(point[0])), y = splat(static_cast<float>(point[1])), z = splat(static_cast<float>(point[2]));
  while (count > 0) {
    const std::uint32_t at = open[--count];
    const Block& b = skin.tree.bound[at];
    const F8 dx = load(b.x) - x, dy = load(b.y) - y, dz = load(b.z) - z, sum = load(b.r) + splat(limit);
    ++work;
    Vector8 corner[3] = {splat(0, 0, 0), splat(0, 0, 0), splat(0, 0, 0)};
    std::uint32_t items[8], item_count = 0;
    for (unsigned lanes = maskOf(dx * dx + dy * dy + dz * dz <= sum * sum); lanes; lanes &= lanes - 1) {
      const auto lane = static_cast<std::uint32_t>(__builtin_ctz(lanes));
      if (lane < skin.tree.links[at].inner && count < open.size()) {
        open[count++] = skin.tree.links[at].first_child + lane;
      } else if (const std::uint32_t item = skin.tree.item[8 * at + lane]; item != kNoItem) {
        for (unsigned k = 0; k < 3; ++k) {
          const float(&p)[3] = skin.patch[item].position[k];
          corner[k].x[item_count] = static_cast<float>(double{p[0]} - point[0]);
          corner[k].y[item_count] = static_cast<float>(double{p[1]} - point[1]);
          corner[k].z[item_count] = static_cast<float>(double{p[2]} - point[2]);
        }
        items[item_count++] = item;
      }
    }
    if (item_count == 0) continue;
    work += kTriangleWork;
    const F8 square = squareToTriangle(corner[0], corner[1], corner[2], splat(0, 0, 0));
    for (unsigned k = 0; k < item_count; ++k)
      if (square[k] <= limit * limit) take(items[k], square[k]);
  }
}

}  // namespace

void CutLayers::add(CompiledSkin skin) {
  inner_.push_back(std::make_unique<const CompiledSkin>(std::move(skin)));
  skins_.push_back(inner_.back().get());
  near_.reserve(std::max(near_.capacity(), skins_.back()->patch.size()));
}

// The triangles within `reach` of the point.
void CutLayers::findNear(const CompiledSkin& skin, const Vector3d& middle, double reach, std::uint32_t& work) {
  near_.clear();
  const auto limit = static_cast<float>(reach * (1 + 1e-5));
  forNear(skin, middle, limit, work, [&](std::uint32_t triangle, float) { near_.push_back(triangle); });
}

double CutLayers::distanceFrom(const Vector3d& point, double limit, std::uint32_t& work) const {
  auto nearest = static_cast<float>(limit);
  forNear(*skins_[0], point, nearest, work, [&](std::uint32_t, float square) { nearest = std::min(nearest, std::sqrt(square)); });
  return double{nearest};
}

bool CutLayers::isWithin(const CompiledSkin& skin, const Vector3d& point, std::uint32_t& work) const {
  return windingNumber(skin, point, work) > 0.5;
}

bool CutLayers::make(const BlockPlace& place, CutLattice& lattice, std::uint32_t& work) {
  const Vector3d middle = lattice.middleOf(place), corner = lattice.cornerOf(place);
  const double reach = lattice.reach();
  CutBlock* block = nullptr;
  for (std::size_t layer = 0; layer < skins_.size(); ++layer) {
    const CompiledSkin& skin = *skins_[layer];
    findNear(skin, middle, lattice.blockRadius() + (layer == 0 ? reach : 0), work);
    float distance[kBlockPoints];
    if (near_.empty()) {
      const bool is_within = isWithin(skin, middle, work);
      if (!is_within && layer == 0) {
        lattice.addOutside(place);
        return true;
      }
      std::fill_n(distance, kBlockPoints, static_cast<float>(is_within ? reach : -reach));
    } else {
      lattice.kernel().signedDistances({{corner[0], corner[1], corner[2]},
                                        static_cast<float>(lattice.spacing()),
                                        static_cast<float>(reach),
                                        skin.patch.data(),
                                        near_.data(),
                                        static_cast<std::uint32_t>(near_.size()),
                                        distance});
      work += kTriangleWork * static_cast<std::uint32_t>(near_.size()) * static_cast<std::uint32_t>(kBlockPoints / 8);
    }
    if (layer == 0) {
      block = lattice.add(place);
      if (!block) return false;
      std::copy_n(distance, kBlockPoints, block->depth);
      const auto near = static_cast<float>(lattice.spacing());
      block->meets_surface = std::any_of(std::begin(distance), std::end(distance), [near](float d) { return std::abs(d) < near; });
      std::fill_n(block->layer, kBlockPoints, std::uint8_t{0});
      continue;
    }
    for (std::size_t i = 0; i < kBlockPoints; ++i)
      if (distance[i] > 0) block->layer[i] = static_cast<std::uint8_t>(layer);
  }
  return true;
}

}  // namespace spheretree::runtime
