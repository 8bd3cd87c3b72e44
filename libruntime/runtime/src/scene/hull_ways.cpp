// SPDX-License-Identifier: Apache-2.0
#include "scene/hull_ways.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <span>

#include "spheretree/core/rounding.h"

namespace spheretree::runtime {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kMostSides = 32;  // of a corner that is tested; one with more is a way without a test

// A side or corner of a triangle, as a number: where it is, which is the same for all triangles that share it; whether
// it is no sharp side; the triangle, which of its sides or corners it is, and whether the side goes the other way.
using Place = std::uint64_t;
Place place(std::uint32_t a, std::uint32_t b, bool is_sharp, std::uint64_t t, std::uint32_t k) {
  return std::uint64_t{std::min(a, b)} << 36 | std::uint64_t{std::max(a, b)} << 20 | std::uint64_t{!is_sharp} << 19 | t << 3 | k << 1 |
         (a > b);
}
std::uint64_t whereOf(Place p) { return p >> 20; }
std::size_t triangleOf(Place p) { return p >> 3 & 0xffff; }
std::size_t numberOf(Place p) { return p >> 1 & 3; }
bool isTurned(Place p) { return (p & 1) != 0; }

class WaysFinder {
 public:
  WaysFinder(const Skin& skin, std::span<const CompiledPatch> patches)
      : ways(skin.triangles.size()), skin_(skin), sides_(3 * ways.size()), corners_(sides_.size()) {
    findPlaces(patches);
    has_inside_ = isClosed() && volume() > 0;
    share(sides_, 0, &WaysFinder::isHollowSide);
    share(corners_, 3, &WaysFinder::isHollowCorner);
  }
  std::vector<std::uint8_t> ways;

 private:
  Vector3d at(std::size_t t, std::size_t k) const {  // integers: exact; the unit does not matter
    const SkinPosition& p = skin_.vertices[skin_.triangles[t].vertex[k % 3]].position;
    return {double(p[0]), double(p[1]), double(p[2])};
  }
  Vector3d areaAt(Place p) const {
    const Vector3d corner = at(triangleOf(p), numberOf(p));
    return (at(triangleOf(p), numberOf(p) + 1) - corner).cross(at(triangleOf(p), numberOf(p) + 2) - corner);
  }

  // Vertices and sides at one place are the same: at a crease, the triangles on both sides have their own. A sharp side
  // comes first: in the ways of its triangle, the whole radius is felt there.
  void findPlaces(std::span<const CompiledPatch> patches) {
    const auto named = [](const SkinPosition& p) { return std::uint64_t{p[0]} << 42 | std::uint64_t{p[1]} << 21 | p[2]; };
    std::vector<std::uint64_t> positions(skin_.vertices.size());
    for (std::size_t i = 0; i < positions.size(); ++i) positions[i] = named(skin_.vertices[i].position);
    std::sort(positions.begin(), positions.end());
    for (std::size_t t = 0; t < skin_.triangles.size(); ++t) {
      std::array<std::uint32_t, 3> name;
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint64_t of = named(skin_.vertices[skin_.triangles[t].vertex[k]].position);
        name[k] = static_cast<std::uint32_t>(std::lower_bound(positions.begin(), positions.end(), of) - positions.begin());
      }
      for (std::uint32_t k = 0; k < 3; ++k) {
        const bool is_sharp = (patches[t].flags >> k & 1) != 0;
        sides_[3 * t + k] = place(name[k], name[(k + 1) % 3], is_sharp, t, k);
        corners_[3 * t + k] = place(name[k], name[k], is_sharp, t, k);
      }
    }
    std::sort(sides_.begin(), sides_.end());
    std::sort(corners_.begin(), corners_.end());
  }

  // Two triangles meet in each side, and go along it in opposite directions.
  bool isClosed() const {
    for (std::size_t i = 0; i < sides_.size(); i += 2)
      if (i + 1 == sides_.size() || whereOf(sides_[i]) != whereOf(sides_[i + 1]) || isTurned(sides_[i]) == isTurned(sides_[i + 1]) ||
          (i + 2 < sides_.size() && whereOf(sides_[i]) == whereOf(sides_[i + 2])))
        return false;
    return true;
  }
  double volume() const {
    double sum = 0;
    for (std::size_t t = 0; t < skin_.triangles.size(); ++t) sum += at(t, 0).dot(at(t, 1).cross(at(t, 2)));
    return sum;
  }

  // Of the triangles that share a place, the first one answers for it, unless the place is hollow.
  void share(std::span<const Place> places, std::size_t first_bit, bool (WaysFinder::*isHollow)(std::span<const Place>) const) {
    for (std::size_t i = 0, end; i < places.size(); i = end) {
      end = i + 1;
      while (end < places.size() && whereOf(places[end]) == whereOf(places[i])) ++end;
      if (has_inside_ && (this->*isHollow)(places.subspan(i, end - i))) continue;
      ways[triangleOf(places[i])] |= static_cast<std::uint8_t>(1u << (first_bit + numberOf(places[i])));
    }
  }

  // The one triangle is beyond the plane of the other.
  bool isHollowSide(std::span<const Place> same) const {
    const Vector3d n = areaAt(same[0]), way = at(triangleOf(same[1]), numberOf(same[1]) + 2) - at(triangleOf(same[0]), numberOf(same[0]));
    return n.dot(way) > kRounding * n.norm() * way.norm();
  }

  // No plane through the corner has all of its sides behind it. If there are such planes, one of them contains two
  // sides.
  bool isHollowCorner(std::span<const Place> same) const {
    if (same.size() > kMostSides) return false;
    std::array<Vector3d, kMostSides> side;
    Vector3d outward = Vector3d::Zero();
    for (std::size_t i = 0; i < same.size(); ++i) {
      side[i] = (at(triangleOf(same[i]), numberOf(same[i]) + 1) - at(triangleOf(same[i]), numberOf(same[i]))).normalized();
      outward += areaAt(same[i]).normalized();
    }
    for (std::size_t i = 1; i < same.size(); ++i)
      for (std::size_t j = 0; j < i; ++j) {
        Vector3d n = side[i].cross(side[j]);
        if (n.dot(outward) < 0) n = -n;
        std::size_t k = 0;
        while (k < same.size() && n.dot(side[k]) <= kRounding) ++k;
        if (k == same.size()) return false;
      }
    return true;
  }

  const Skin& skin_;
  std::vector<Place> sides_, corners_;  // sorted
  bool has_inside_ = false;
};

}  // namespace

std::vector<std::uint8_t> hullWays(const Skin& skin, std::vector<CompiledPatch>& patches) {
  std::vector<std::uint8_t> ways = WaysFinder(skin, patches).ways;
  for (std::size_t t = 0; t < ways.size(); ++t) {
    std::uint32_t& flags = patches[t].flags;
    for (const int first_bit : {0, 3}) {
      // The patch is felt in a way to a smooth side, at best in one that the guarantee needs as well.
      const std::uint32_t smooth = (flags & kCurved) == 0 ? 0 : ~flags & 7u,
                          both = smooth & static_cast<std::uint32_t>(ways[t] >> first_bit);
      const auto felt = static_cast<std::uint32_t>(std::countr_zero((both != 0 ? both : smooth) | 1u << kNoFeltWay));
      flags |= felt << (first_bit == 0 ? kFeltConeShift : kFeltSlabShift);
    }
  }
  return ways;
}

}  // namespace spheretree::runtime
