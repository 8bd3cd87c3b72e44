// SPDX-License-Identifier: GPL-3.0-or-later
// Is a triangle covered by a union of balls, and where not? Exactly, up to rounding, and without a subdivision to some size: the power
// diagram of the balls cuts the triangle into convex cells, and a cell is covered iff its own ball holds its corners. Paper: F.
// Aurenhammer. Power diagrams: properties, algorithms and applications. SIAM Journal on Computing 16(1), 1987.
//
// The power |p - c|^2 - r^2 of a point is negative in the ball. A point lies in the union iff its least power is not positive, and
// the power of one ball is convex, so that over a cell it is largest at a corner.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "ball_index.h"

namespace spheretree::builder {

class PowerCells {
 public:
  /// Balls whose slot is marked in `gone` do not count; the marks may change between calls.
  explicit PowerCells(const BallIndex& index, const std::vector<char>* gone = nullptr) : index_(index), gone_(gone) {}

  /// hole(point, slot of the ball of its cell) for every corner of a cell that the balls leave uncovered. Of the points of a cell, none is
  /// farther from the cell's ball than one of those corners. If no ball touches the triangle: its corners, with slot kNone. True if
  /// there is none. The parts that the triangle is cut into share their corners, the same doubles, so that they cover it without a crack.
  template <class Hole>
  bool holes(const std::array<Eigen::Vector3d, 3>& triangle, Hole hole) {
    if (holds(last_, triangle)) return true;  // neighbours follow each other in a mesh
    corners_.assign(triangle.begin(), triangle.end());
    near_.clear();
    const Eigen::Vector3d middle = (triangle[0] + triangle[1] + triangle[2]) / 3;
    double extent2 = 0;
    for (const Eigen::Vector3d& p : triangle) extent2 = std::max(extent2, (p - middle).squaredNorm());
    std::uint32_t first = kNone;
    double least = std::numeric_limits<double>::infinity();
    index_.tree.searchWithin(middle, extent2 * (1 + 1e-12), [&](std::size_t begin, std::size_t count) {
      for (auto slot = static_cast<std::uint32_t>(begin); slot < begin + count; ++slot) {
        if (isGone(slot)) continue;
        near_.push_back(slot);
        if (const double p = power(slot, middle); p < least) least = p, first = slot;
      }
    });
    if (first == kNone) {
      for (const Eigen::Vector3d& p : triangle) hole(p, kNone);
      return false;
    }
    covered_ = true;
    part(0, 0, first, hole);
    return covered_;
  }

  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

 private:
  static constexpr std::size_t kMany = 8;  // balls, from which on it pays to sort out those that miss a part

  bool isGone(std::uint32_t slot) const { return gone_ && (*gone_)[slot]; }
  double power(std::uint32_t slot, const Eigen::Vector3d& p) const {
    const Ball& ball = index_.balls[slot];
    return (p - ball.centre).squaredNorm() - ball.radius * std::max(ball.radius, 0.0);
  }
  bool isOut(std::uint32_t slot, const Eigen::Vector3d& p) const {
    const Ball& ball = index_.balls[slot];
    return !(ball.radius >= 0) || (p - ball.centre).squaredNorm() > ball.radius * ball.radius;
  }
  bool holds(std::uint32_t slot, const std::array<Eigen::Vector3d, 3>& triangle) const {
    if (slot >= index_.balls.size() || isGone(slot)) return false;
    return std::ranges::none_of(triangle, [&](const Eigen::Vector3d& p) { return isOut(slot, p); });
  }

  // The part with the corners from `corner` to the end of corners_ and the balls from `near` to the end of near_, of which `ball` is one.
  // Takes both off the stacks.
  template <class Hole>
  void part(std::size_t corner, std::size_t near, std::uint32_t ball, Hole& hole) {
    while (corners_.size() - corner >= 3) {
      // A corner that `ball` does not hold and another ball has less power at: the farthest.
      double farthest = -std::numeric_limits<double>::infinity();
      std::uint32_t other = kNone;
      bool is_held = true;
      for (std::size_t v = corner; v < corners_.size(); ++v) {
        if (!isOut(ball, corners_[v])) continue;
        is_held = false;
        const double here = power(ball, corners_[v]);
        if (here <= farthest) continue;
        double least = here;
        std::uint32_t better = kNone;
        for (std::size_t i = near; i < near_.size(); ++i)
          if (const double p = power(near_[i], corners_[v]); p < least) least = p, better = near_[i];
        if (better != kNone) farthest = here, other = better;
      }
      if (is_held) {
        last_ = ball;
        break;
      }
      if (other == kNone) {
        covered_ = false;
        for (std::size_t v = corner; v < corners_.size(); ++v)
          if (isOut(ball, corners_[v])) hole(corners_[v], ball);
        break;
      }
      // Cut by the plane of equal power. On neither side is the other side's ball needed again, whence it ends.
      const std::size_t end = corners_.size(), near_end = near_.size();
      cut(corner, end, other, ball);
      const bool sorts_out = near_end - near >= kMany;
      const Eigen::AlignedBox3d box = sorts_out ? boxFrom(end) : Eigen::AlignedBox3d();
      for (std::size_t i = near; i < near_end; ++i)
        if (near_[i] != ball && (!sorts_out || touches(near_[i], box))) near_.push_back(near_[i]);
      part(end, near_end, other, hole);
      cut(corner, end, ball, other);
      corners_.erase(corners_.begin() + static_cast<std::ptrdiff_t>(corner), corners_.begin() + static_cast<std::ptrdiff_t>(end));
      *std::find(near_.begin() + static_cast<std::ptrdiff_t>(near), near_.end(), other) = near_.back();
      near_.pop_back();
    }
    corners_.resize(corner);
    near_.resize(near);
  }

  // Appends the part of the polygon from `begin` to `end` where `a` has no more power than `b`. The new corners are computed alike from
  // both sides.
  void cut(std::size_t begin, std::size_t end, std::uint32_t a, std::uint32_t b) {
    const bool turned = a > b;
    const auto difference = [&](const Eigen::Vector3d& p) { return turned ? power(b, p) - power(a, p) : power(a, p) - power(b, p); };
    const double sign = turned ? -1 : 1;
    double there = difference(corners_[end - 1]);
    for (std::size_t v = begin, before = end - 1; v < end; before = v++) {
      const double here = difference(corners_[v]);
      if ((here < 0 && there > 0) || (here > 0 && there < 0)) {
        const Eigen::Vector3d p = corners_[before] + (there / (there - here)) * (corners_[v] - corners_[before]);
        corners_.push_back(p);
      }
      if (sign * here <= 0) corners_.push_back(Eigen::Vector3d(corners_[v]));
      there = here;
    }
  }

  Eigen::AlignedBox3d boxFrom(std::size_t begin) const {
    Eigen::AlignedBox3d box;
    for (std::size_t v = begin; v < corners_.size(); ++v) box.extend(corners_[v]);
    return box;
  }
  bool touches(std::uint32_t slot, const Eigen::AlignedBox3d& box) const {
    const Ball& ball = index_.balls[slot];
    return box.squaredExteriorDistance(ball.centre) <= ball.radius * ball.radius * (1 + 1e-12);
  }

  const BallIndex& index_;
  const std::vector<char>* gone_;
  std::uint32_t last_ = 0;
  bool covered_ = true;
  std::vector<Eigen::Vector3d> corners_;  // of the part at hand and of those that wait, which is a stack
  std::vector<std::uint32_t> near_;       // the balls for each, likewise
};

}  // namespace spheretree::builder
