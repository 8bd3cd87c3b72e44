// SPDX-License-Identifier: GPL-3.0-or-later
#include "hulls/cut_hulls.h"

#include <algorithm>
#include <array>
#include <bit>
#include <initializer_list>
#include <map>
#include <set>

#include "skin/build_search_tree.h"
#include "spheretree/core/rounding.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr double kLongest = 4;      // longest side of a part, as a multiple of its mean radius
constexpr double kAcrossASlab = 8;  // pieces along the longest side of a slab, at most: a thin one would have thousands

Ball between(const Ball& a, const Ball& b) { return {0.5 * (a.centre + b.centre), 0.5 * (a.radius + b.radius)}; }

// The pieces of a hull, halved at their longest sides until they are short.
std::vector<Hull> piecesOf(const Hull& hull) {
  double shortest = 0;
  for (std::size_t k = 0; k < 3 && hull.count == 3; ++k)
    shortest = std::max(shortest, (hull.ball[k].centre - hull.ball[(k + 1) % 3].centre).norm() / kAcrossASlab);
  std::vector<Hull> pieces, open{hull};
  while (!open.empty()) {
    Hull piece = open.back();
    open.pop_back();
    double longest = 0, radius = 0;
    std::size_t first = 0;
    for (std::size_t k = 0; k < piece.count; ++k) {
      const double length = (piece.ball[k].centre - piece.ball[(k + 1) % piece.count].centre).norm();
      if (length > longest) longest = length, first = k;
      radius += piece.ball[k].radius / static_cast<double>(piece.count);
    }
    if (longest <= std::max(shortest, kLongest * radius)) {
      pieces.push_back(piece);
      continue;
    }
    const std::size_t second = (first + 1) % piece.count;
    const Ball halfway = between(piece.ball[first], piece.ball[second]);
    for (const std::size_t k : {second, first}) {
      Hull half = piece;
      half.ball[k] = halfway;
      open.push_back(half);
    }
  }
  return pieces;
}

class HullCutter {
 public:
  HullCutter(std::span<const Hull> hulls, const Vector3d& origin) : hulls_(hulls), origin_(origin) {
    for (const Hull& hull : hulls) distance_.emplace_back(hull), box_.push_back(boxOf(hull));
  }

  Hulls run() {
    for (std::size_t i = 0; i < hulls_.size(); ++i) addPieces(i);
    Hulls& out = out_;
    out.count = static_cast<std::uint32_t>(hulls_.size());
    if (balls_.size() > kNoHullBall) return {};
    std::ranges::stable_sort(out.parts, {}, ballCount);
    std::vector<Sphere> items;
    for (const HullPart& part : out.parts)
      for (std::size_t k = 0; k < 3; ++k) items.push_back(out.balls[part[k < ballCount(part) ? k : 0]]);
    if (items.size() / 3 > kMaxSearchItems) return {};
    out.search = buildSearchTree(items, 3);
    return out;
  }

 private:
  // The pieces of hull `i`, of its sides if it has three balls, and its corners.
  void addPieces(std::size_t i) {
    const Hull& hull = hulls_[i];
    const auto addFace = [&](std::initializer_list<std::size_t> corners) {
      Hull face;
      face.count = 0;
      for (const std::size_t k : corners) face.ball[face.count++] = hull.ball[k];
      for (const Hull& piece : piecesOf(face))
        if (!isHidden(i, piece, face.count == hull.count)) add(piece);
    };
    if (hull.count == 3) {
      addFace({0, 1, 2});
      for (std::size_t k = 0; k < 3; ++k) addFace({k, (k + 1) % 3});
    } else if (hull.count == 2) {
      addFace({0, 1});
    }
    for (std::size_t k = 0; k < hull.count; ++k) addFace({k});
  }

  // Whether another hull holds the piece, so that it cannot touch anything. Of a hull's own kind, a piece is left out
  // only for an earlier hull: two hulls may hold the same place, and one of them has to stay.
  bool isHidden(std::size_t i, const Hull& piece, bool is_whole) const {
    const Eigen::AlignedBox3d box = boxOf(piece);
    for (std::size_t j = 0; j < (is_whole ? i : hulls_.size()); ++j) {
      if (j == i || !box_[j].intersects(box)) continue;
      const double share = j < i ? 1 : 1 + kRounding;
      if (std::all_of(piece.ball.begin(), piece.ball.begin() + static_cast<std::ptrdiff_t>(piece.count), [&](const Ball& b) {
            return distance_[j].holds({b.centre, share * b.radius});
          }))
        return true;
    }
    return false;
  }

  // A side that two slabs share is added once. A part that is too steep after rounding is left out: its sides and
  // corners hold it but for rounding.
  void add(const Hull& piece) {
    HullPart part{kNoHullBall, kNoHullBall, kNoHullBall};
    for (std::size_t k = 0; k < piece.count; ++k) {
      const Eigen::Vector3f c = roundToFloat(Vector3d(piece.ball[k].centre - origin_));
      const Sphere ball{c.x(), c.y(), c.z(), roundUp(piece.ball[k].radius)};
      const auto [at, is_new] =
          balls_.try_emplace(std::array{std::bit_cast<std::uint32_t>(ball.x), std::bit_cast<std::uint32_t>(ball.y),
                                        std::bit_cast<std::uint32_t>(ball.z), std::bit_cast<std::uint32_t>(ball.radius)},
                             static_cast<std::uint32_t>(out_.balls.size()));
      if (is_new) out_.balls.push_back(ball);
      part[k] = static_cast<std::uint16_t>(at->second);
    }
    if (balls_.size() > kNoHullBall) return;
    HullPart sorted = part;
    std::ranges::sort(sorted);
    if (piece.count > 1 && (steepness(out_, part) > kSteepestHull || !added_.insert(sorted).second)) return;
    out_.parts.push_back(part);
  }

  std::span<const Hull> hulls_;
  const Vector3d& origin_;
  std::vector<HullDistance> distance_;
  std::vector<Eigen::AlignedBox3d> box_;
  std::map<std::array<std::uint32_t, 4>, std::uint32_t> balls_;
  std::set<HullPart> added_;
  Hulls out_;
};

}  // namespace

Hulls cutHulls(std::span<const Hull> hulls, const Vector3d& origin) { return HullCutter(hulls, origin).run(); }

Hull hullOf(const Hulls& hulls, const HullPart& part) {
  Hull hull;
  hull.count = ballCount(part);
  for (std::size_t k = 0; k < hull.count; ++k) hull.ball[k] = {centreOf(hulls.balls[part[k]]), double{hulls.balls[part[k]].radius}};
  return hull;
}

}  // namespace spheretree::builder
