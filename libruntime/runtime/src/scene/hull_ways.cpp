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

using Place = std::uint32_t;  // 3 t + k: side or corner k of triangle t

// The places by what they are of.
struct Shared {
  std::vector<std::uint32_t> first, places;
  Shared(std::size_t count, const std::vector<std::uint32_t>& what) : first(count + 1), places(what.size()) {
    for (const std::uint32_t w : what) ++first[w];
    for (std::size_t i = 1; i < first.size(); ++i) first[i] += first[i - 1];
    for (std::size_t i = what.size(); i-- > 0;) places[--first[what[i]]] = static_cast<Place>(i);
  }
  std::span<const Place> of(std::size_t i) const { return {places.data() + first[i], first[i + 1] - first[i]}; }
};

class WaysFinder {
 public:
  WaysFinder(const Skin& skin, std::span<const CompiledPatch> patches)
      : ways(skin.triangles.size()), skin_(skin), patches_(patches), corner_(3 * ways.size()), side_(corner_.size()) {
    nameCorners();
    nameSides();
    const Shared sides(skin.edges.size(), side_), corners(skin.vertices.size(), corner_);
    has_inside_ = isClosed(sides) && volume() > 0;
    share(sides, 0, &WaysFinder::isHollowSide);
    share(corners, 3, &WaysFinder::isHollowCorner);
  }
  std::vector<std::uint8_t> ways;

 private:
  static Place next(Place p) { return p % 3 == 2 ? p - 2 : p + 1; }
  Vector3d at(Place p) const {  // integers: exact; the unit does not matter
    const SkinPosition& of = skin_.vertices[skin_.triangles[p / 3].vertex[p % 3]].position;
    return {double(of[0]), double(of[1]), double(of[2])};
  }
  Vector3d areaAt(Place p) const { return (at(next(p)) - at(p)).cross(at(next(next(p))) - at(p)); }
  bool isTurned(Place p) const { return corner_[p] > corner_[next(p)]; }

  // At a crease, the triangles on both sides have vertices and sides of their own. Those at one place get one name: the
  // number of the first of them.
  void nameCorners() {
    std::vector<std::uint32_t> name(skin_.vertices.size());
    std::vector<std::uint64_t> sharp;  // positions
    const auto positionOf = [this](std::size_t vertex) {
      const SkinPosition& p = skin_.vertices[vertex].position;
      return std::uint64_t{p[0]} << 42 | std::uint64_t{p[1]} << 21 | p[2];
    };
    for (Place p = 0; p < corner_.size(); ++p) {
      const SkinTriangle& t = skin_.triangles[p / 3];
      name[t.vertex[p % 3]] = t.vertex[p % 3];
      if (skin_.edges[t.edge[p % 3]].is_sharp)
        for (const Place end : {p, next(p)}) sharp.push_back(positionOf(t.vertex[end % 3]));
    }
    std::sort(sharp.begin(), sharp.end());
    std::vector<std::uint32_t> first(sharp.size());  // vertex there, plus 1
    for (std::uint32_t& n : name) {
      const auto found = std::lower_bound(sharp.begin(), sharp.end(), positionOf(n));
      if (found == sharp.end() || *found != positionOf(n)) continue;
      std::uint32_t& same = first[static_cast<std::size_t>(found - sharp.begin())];
      if (same == 0) same = n + 1;
      n = same - 1;
    }
    for (Place p = 0; p < corner_.size(); ++p) corner_[p] = name[skin_.triangles[p / 3].vertex[p % 3]];
  }
  void nameSides() {
    std::vector<std::uint64_t> sharp;  // corners, edge
    std::vector<std::uint32_t> name(skin_.edges.size());
    for (Place p = 0; p < side_.size(); ++p) {
      const std::uint16_t edge = skin_.triangles[p / 3].edge[p % 3];
      const auto [a, b] = std::minmax(corner_[p], corner_[next(p)]);
      name[edge] = edge;
      if (skin_.edges[edge].is_sharp) sharp.push_back(std::uint64_t{a} << 32 | std::uint64_t{b} << 16 | edge);
    }
    std::sort(sharp.begin(), sharp.end());
    for (std::size_t i = 1; i < sharp.size(); ++i)
      if (sharp[i] >> 16 == sharp[i - 1] >> 16) name[sharp[i] & 0xffff] = name[sharp[i - 1] & 0xffff];
    for (Place p = 0; p < side_.size(); ++p) side_[p] = name[skin_.triangles[p / 3].edge[p % 3]];
  }

  // Two triangles meet in each side, and go along it in opposite directions.
  bool isClosed(const Shared& sides) const {
    for (std::size_t i = 0; i + 1 < sides.first.size(); ++i)
      if (const std::span<const Place> same = sides.of(i); !same.empty() && (same.size() != 2 || isTurned(same[0]) == isTurned(same[1])))
        return false;
    return true;
  }
  double volume() const {
    double sum = 0;
    for (Place p = 0; p < corner_.size(); p += 3) sum += at(p).dot(at(p + 1).cross(at(p + 2)));
    return sum;
  }

  // Of the triangles that share a place, one answers for it, unless the place is hollow: a triangle with a sharp side
  // there, if there is one, since in its way the whole radius is felt.
  void share(const Shared& shared, std::uint32_t first_bit, bool (WaysFinder::*isHollow)(std::span<const Place>) const) {
    for (std::size_t i = 0; i + 1 < shared.first.size(); ++i) {
      const std::span<const Place> same = shared.of(i);
      if (same.empty() || (has_inside_ && (this->*isHollow)(same))) continue;
      Place answers = same[0];
      for (std::size_t k = same.size(); k-- > 0;)
        if (patches_[same[k] / 3].flags >> same[k] % 3 & 1) answers = same[k];
      ways[answers / 3] |= static_cast<std::uint8_t>(1u << (first_bit + answers % 3));
    }
  }

  // The one triangle is beyond the plane of the other. Rounding decides only for what is flat, at which nothing is
  // touched that is not touched beside it as well.
  bool isHollowSide(std::span<const Place> same) const { return areaAt(same[0]).dot(at(next(next(same[1]))) - at(same[0])) > 0; }

  // No plane through the corner has all of its sides on one side. If there are such planes, one of them contains two
  // sides. Sides in that plane count as on either side, whatever rounding says.
  bool isHollowCorner(std::span<const Place> same) const {
    if (same.size() > kMostSides) return false;
    std::array<Vector3d, kMostSides> side;
    double longest = 0;
    for (std::size_t i = 0; i < same.size(); ++i) {
      side[i] = at(next(same[i])) - at(same[i]);
      longest = std::max(longest, side[i].norm());
    }
    for (std::size_t i = 1; i < same.size(); ++i)
      for (std::size_t j = 0; j < i; ++j) {
        const Vector3d n = side[i].cross(side[j]);
        double least = 0, most = 0;
        for (std::size_t k = 0; k < same.size(); ++k) least = std::min(least, n.dot(side[k])), most = std::max(most, n.dot(side[k]));
        if (std::min(-least, most) <= kRounding * n.norm() * longest) return false;
      }
    return true;
  }

  const Skin& skin_;
  std::span<const CompiledPatch> patches_;
  std::vector<std::uint32_t> corner_, side_;  // (place) what it is: the same number for all that are at one place
  bool has_inside_ = false;
};

}  // namespace

std::vector<std::uint8_t> hullWays(const Skin& skin, std::vector<CompiledPatch>& patches) {
  std::vector<std::uint8_t> ways = WaysFinder(skin, patches).ways;
  for (std::size_t t = 0; t < ways.size(); ++t) {
    std::uint32_t& flags = patches[t].flags;
    // The patch is felt in a way to a smooth side, at best in one that the guarantee needs as well.
    const std::uint32_t smooth = (flags & kCurved) == 0 ? 0 : ~flags & 7u;
    const auto feltAmong = [smooth](std::uint32_t guarded) {
      return static_cast<std::uint32_t>(std::countr_zero(((smooth & guarded) != 0 ? smooth & guarded : smooth) | 1u << kNoFeltWay));
    };
    flags |= feltAmong(ways[t]) << kFeltConeShift | feltAmong(ways[t] >> 3) << kFeltSlabShift;
  }
  return ways;
}

}  // namespace spheretree::runtime
