// SPDX-License-Identifier: Apache-2.0
// A circle from which arcs are taken away, and angles on it without trigonometry.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

namespace spheretree::runtime {

inline constexpr std::uint32_t kNone = 0xffffffffu;  // no leaf: the end of an arc that has none
inline constexpr double kWholeTurn = 2 * M_PI;

/// Grows with the angle of (x, y) from 0 to 4; no trigonometry.
inline double pseudoAngle(double x, double y) {
  const double part = y / (std::abs(x) + std::abs(y));
  return x < 0 ? 2 - part : part < 0 ? 4 + part : part;
}
inline std::array<double, 2> unitVector(double square) {
  const double s = square, x = s < 2 ? 1 - s : s - 3, y = s < 1 ? s : s < 3 ? 2 - s : s - 4, length = std::sqrt(x * x + y * y);
  return {x / length, y / length};
}
inline double trueAngle(double square) {
  const double turns = std::floor(square / 4), s = square - 4 * turns, x = s < 2 ? 1 - s : s - 3, y = s < 1 ? s : s < 3 ? 2 - s : s - 4;
  const double angle = std::atan2(y, x);
  return angle + (angle < 0 ? turns + 1 : turns) * kWholeTurn;
}

/// A part of a circle, between two square angles.
struct CirclePart {
  double low, high;
  std::array<double, 2> from = unitVector(low), to = unitVector(high);

  /// False if u . (x, y) < most, by more than rounding, for every unit vector u in it. True in doubt.
  bool reaches(double x, double y, double most) const {
    if (high - low > 2) return true;  // more than half of the circle
    const double slack = 1e-9 * (std::abs(x) + std::abs(y) + std::abs(most));
    return from[0] * x + from[1] * y > most - slack || to[0] * x + to[1] * y > most - slack ||
           (from[0] * y - from[1] * x > -slack && x * to[1] - y * to[0] > -slack);  // (x, y) points between the ends
  }
};

/// What is left of a circle after others have been taken away, in square angles.
class FreeArcs {
 public:
  struct Piece : CirclePart {
    std::uint32_t low_end, high_end;
  };
  void start() {
    pieces_.assign(1, {{0, 4}, kNone, kNone});
    at_0_ = at_4_ = kNone;
  }
  void clear() { pieces_.clear(); }
  bool empty() const { return pieces_.empty(); }

  /// Takes away what is from `low` on to `high`, by leaf `k`.
  void take(double low, double high, std::uint32_t k) {
    if (low <= high) return cut(low, high, k);
    cut(low, 4, k);
    cut(0, high, k);
  }

  bool reaches(double x, double y, double most) const {
    for (const Piece& p : pieces_)
      if (p.reaches(x, y, most)) return true;
    return false;
  }

  const std::vector<Piece>& pieces() const { return pieces_; }
  /// The same when all is done: a piece that runs over 0 in one. Both ends of a piece name a leaf, or it is the whole circle.
  const std::vector<Piece>& whole() {
    if (pieces_.empty()) return pieces_;
    Piece &first = pieces_.front(), &last = pieces_.back();
    if (first.low_end == kNone && last.high_end == kNone) {
      if (pieces_.size() > 1) {
        first.low = last.low - 4;
        first.low_end = last.low_end;
        pieces_.pop_back();
      }
    } else if (first.low_end == kNone) {  // what was taken away ends at 0 exactly
      first.low_end = at_4_;
    } else if (last.high_end == kNone) {
      last.high_end = at_0_;
    }
    return pieces_;
  }

 private:
  void cut(double low, double high, std::uint32_t k) {
    if (low <= 0) at_0_ = k;
    if (high >= 4) at_4_ = k;
    next_.clear();
    for (const Piece& p : pieces_) {
      if (high <= p.low || low >= p.high) {
        next_.push_back(p);
        continue;
      }
      if (low > p.low) next_.push_back({{p.low, low, p.from}, p.low_end, k});
      if (high < p.high) next_.push_back({{high, p.high, unitVector(high), p.to}, k, p.high_end});
    }
    pieces_.swap(next_);
  }
  std::vector<Piece> pieces_, next_;
  std::uint32_t at_0_ = kNone, at_4_ = kNone;  // leaves that took from 0 on and up to 4
};

}  // namespace spheretree::runtime
