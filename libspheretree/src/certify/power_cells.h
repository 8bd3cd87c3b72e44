// SPDX-License-Identifier: GPL-3.0-or-later
// Decides whether a union of balls covers a triangle, and finds the uncovered parts: exactly, up to rounding, and
// without a subdivision to some finest size. The power diagram of the balls cuts the triangle into convex cells, and a
// cell is covered if and only if its own ball contains its corners. Paper: F. Aurenhammer. Power diagrams: properties,
// algorithms and applications. SIAM Journal on Computing 16(1), 1987.
//
// The power |p - c|^2 - r^2 of a point is negative inside the ball. A point lies in the union if and only if its
// smallest power is not positive. The power of one ball is convex, so that over a cell it is largest at a corner.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "geometry/ball_index.h"

namespace spheretree::builder {

class PowerCells {
 public:
  /// Balls whose slot is marked in `absent` are treated as absent; the marks may change between calls.
  explicit PowerCells(const BallIndex& index, const std::vector<char>* absent = nullptr) : index_(index), absent_(absent) {}

  /// Returns true if the triangle is covered. Otherwise calls hole(point, slot of the ball of its cell) for every
  /// corner of a cell that is outside all balls. No point of a cell is farther from the cell's ball than one of those
  /// corners. If no ball touches the triangle, calls it for the corners of the triangle, with slot kNone. Adjacent
  /// cells share their corners as the same doubles, so that they cover the triangle without a crack.
  template <class Hole>
  bool holes(const std::array<Eigen::Vector3d, 3>& triangle, Hole hole) {
    if (holds(last_, triangle)) {  // consecutive triangles are often neighbours
      held_by_.assign(1, last_);
      return true;
    }
    corners_.assign(triangle.begin(), triangle.end());
    near_.clear();
    const Eigen::Vector3d middle = (triangle[0] + triangle[1] + triangle[2]) / 3;
    double extent2 = 0;
    for (const Eigen::Vector3d& p : triangle) extent2 = std::max(extent2, (p - middle).squaredNorm());
    std::uint32_t first = kNone;
    double smallest = std::numeric_limits<double>::infinity();
    index_.tree.searchWithin(middle, extent2 * (1 + 1e-12), [&](std::size_t begin, std::size_t count) {
      for (auto slot = static_cast<std::uint32_t>(begin); slot < begin + count; ++slot) {
        if (isAbsent(slot)) continue;
        near_.push_back(slot);
        if (const double p = power(slot, middle); p < smallest) smallest = p, first = slot;
      }
    });
    if (first == kNone) {
      for (const Eigen::Vector3d& p : triangle) hole(p, kNone);
      return false;
    }
    covered_ = true;
    held_by_.clear();
    part(0, 0, first, hole);
    return covered_;
  }

  /// The balls whose cells the triangle of the last call consists of, if it is covered.
  std::span<const std::uint32_t> heldBy() const { return held_by_; }

  /// Whether the balls of these slots cover the triangle. If not, calls hole(point, slot of the ball of its cell) for
  /// every corner of a cell that is outside the ball of the cell; for none if there are no slots.
  template <class Hole>
  bool suffice(const std::array<Eigen::Vector3d, 3>& triangle, std::span<const std::uint32_t> slots, Hole hole) {
    if (slots.empty()) return false;
    corners_.assign(triangle.begin(), triangle.end());
    near_.assign(slots.begin(), slots.end());
    const Eigen::Vector3d middle = (triangle[0] + triangle[1] + triangle[2]) / 3;
    const auto first = std::ranges::min_element(slots, {}, [&](std::uint32_t slot) { return power(slot, middle); });
    covered_ = true;
    held_by_.clear();
    part(0, 0, *first, hole);
    return covered_;
  }
  bool suffice(const std::array<Eigen::Vector3d, 3>& triangle, std::span<const std::uint32_t> slots) {
    if (slots.size() != 1) return suffice(triangle, slots, [](const Eigen::Vector3d&, std::uint32_t) {});
    held_by_.assign(1, slots[0]);
    return holds(slots[0], triangle);
  }

  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

 private:
  bool isAbsent(std::uint32_t slot) const { return absent_ && (*absent_)[slot]; }
  double power(std::uint32_t slot, const Eigen::Vector3d& p) const {
    const Ball& ball = index_.balls[slot];
    return (p - ball.centre).squaredNorm() - ball.radius * std::abs(ball.radius);
  }
  bool isOut(std::uint32_t slot, const Eigen::Vector3d& p) const {
    const Ball& ball = index_.balls[slot];
    return !(ball.radius >= 0) || (p - ball.centre).squaredNorm() > ball.radius * ball.radius;
  }
  bool holds(std::uint32_t slot, const std::array<Eigen::Vector3d, 3>& triangle) const {
    if (slot >= index_.balls.size() || isAbsent(slot)) return false;
    return std::ranges::none_of(triangle, [&](const Eigen::Vector3d& p) { return isOut(slot, p); });
  }

  // Handles the part with the corners from `corner` to the end of corners_ and the balls from `near` to the end of
  // near_. `ball` has the smallest power somewhere in it. Removes both ranges from the stacks.
  template <class Hole>
  void part(std::size_t corner, std::size_t near, std::uint32_t ball, Hole& hole) {
    while (corners_.size() - corner >= 3) {
      own_.clear();
      for (std::size_t v = corner; v < corners_.size(); ++v) own_.push_back(power(ball, corners_[v]));
      if (std::ranges::all_of(own_, [](double p) { return p <= 0; })) {
        last_ = ball;
        held_by_.push_back(ball);
        break;
      }
      const std::uint32_t other = sortOut(corner, near);
      if (other == kNone) {
        covered_ = false;
        for (std::size_t v = corner; v < corners_.size(); ++v)
          if (isOut(ball, corners_[v])) hole(corners_[v], ball);
        break;
      }
      // Cut by the plane of equal power. Neither side needs the other side's ball again, so the recursion ends.
      const std::size_t end = corners_.size(), near_end = near_.size();
      const std::size_t there = cut(corner, ball, other);
      for (std::size_t i = near; i < near_end; ++i)
        if (near_[i] != ball && near_[i] != other) near_.push_back(near_[i]);
      part(there, near_end, other, hole);
      corners_.erase(corners_.begin() + static_cast<std::ptrdiff_t>(corner), corners_.begin() + static_cast<std::ptrdiff_t>(end));
      near_.erase(std::find(near_.begin() + static_cast<std::ptrdiff_t>(near), near_.end(), other));
    }
    corners_.resize(corner);
    near_.resize(near);
  }

  // Removes the balls from `near` on that have nowhere less power than the part's own ball (own_). It suffices to
  // compare corners, since the difference of two powers is linear. Returns the ball of least power at the farthest
  // corner that is outside the own ball and where another ball has less power; kNone if there is no such corner.
  std::uint32_t sortOut(std::size_t corner, std::size_t near) {
    min_ = own_;
    deepest_.assign(own_.size(), kNone);
    std::size_t kept = near;
    for (std::size_t i = near; i < near_.size(); ++i) {
      const std::uint32_t slot = near_[i];
      bool is_needed = false;
      for (std::size_t v = 0; v < own_.size(); ++v) {
        const double p = power(slot, corners_[corner + v]);
        is_needed = is_needed || p < own_[v];
        if (p < min_[v]) min_[v] = p, deepest_[v] = slot;
      }
      if (is_needed) near_[kept++] = slot;
    }
    near_.resize(kept);
    double farthest = 0;
    std::uint32_t other = kNone;
    for (std::size_t v = 0; v < own_.size(); ++v)
      if (own_[v] > farthest && deepest_[v] != kNone) farthest = own_[v], other = deepest_[v];
    return other;
  }

  // Appends the part of the polygon from `corner` on where `a` has at most the power of `b`, then the part where `b`
  // has at most the power of `a`. Returns where the second begins. They share their new corners.
  std::size_t cut(std::size_t corner, std::uint32_t a, std::uint32_t b) {
    const std::size_t count = corners_.size() - corner;
    difference_.clear();  // always in the same order, so that neighbours of this triangle compute the same corners
    for (std::size_t v = 0; v < count; ++v) {
      const Eigen::Vector3d& p = corners_[corner + v];
      difference_.push_back(power(std::min(a, b), p) - power(std::max(a, b), p));
    }
    std::size_t second = 0;
    for (const double sign : {a < b ? 1.0 : -1.0, a < b ? -1.0 : 1.0}) {
      second = corners_.size();
      for (std::size_t v = 0, before = count - 1; v < count; before = v++) {
        const double here = difference_[v], there = difference_[before];
        const Eigen::Vector3d to = corners_[corner + v], from = corners_[corner + before];
        if ((here < 0 && there > 0) || (here > 0 && there < 0)) corners_.push_back(from + (there / (there - here)) * (to - from));
        if (sign * here <= 0) corners_.push_back(to);
      }
    }
    return second;
  }

  const BallIndex& index_;
  const std::vector<char>* absent_;
  std::uint32_t last_ = 0;
  bool covered_ = true;
  std::vector<std::uint32_t> held_by_;
  std::vector<Eigen::Vector3d> corners_;  // stack: the corners of the current part and of the parts that wait
  std::vector<std::uint32_t> near_;       // stack: the balls of each of these parts
  // By corner of the current part: the power of its own ball, the least power of all balls, the ball of that power, and
  // the difference of two powers.
  std::vector<double> own_, min_, difference_;
  std::vector<std::uint32_t> deepest_;
};

}  // namespace spheretree::builder
