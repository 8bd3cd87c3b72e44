// SPDX-License-Identifier: Apache-2.0
#include "flat_faces.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

namespace spheretree::runtime {
namespace {

using Eigen::Vector4d;

constexpr std::size_t kFewest = 8;   // tops of a flat face: on a round one four or five may happen to lie in a plane
constexpr double kOtherFace = 0.87;  // cosine of the least angle between two faces of one ball
constexpr int kMostRounds = 200;     // until a ball is level with all of its faces
constexpr double kRest = 1e-4;       // of the tolerance, that may be left

/// Centre and radius.
Vector4d vectorOf(const Sphere& s) { return {s.x, s.y, s.z, s.radius}; }
double topOver(const Plane& p, const Vector4d& ball) { return p.normal.dot(ball.head<3>()) + ball[3] - p.height; }

/// The faces, at the height of the highest top that is near, and those that each ball is near to; first those with most tops.
struct FlatFaces {
  std::vector<Plane> faces;
  std::vector<std::vector<std::uint32_t>> of_ball;

  FlatFaces(std::span<const Vector4d> balls, std::span<const Plane> planes, double tolerance) : of_ball(balls.size()) {
    std::vector<std::pair<double, std::uint32_t>> order;  // the less, the more tops are near and the nearer
    for (std::uint32_t k = 0; k < planes.size(); ++k) {
      double score = 0;
      for (const Vector4d& ball : balls) score -= std::max(0.0, tolerance - std::abs(topOver(planes[k], ball)));
      if (score < -3 * tolerance) order.push_back({score, k});  // three tops are always in it
    }
    std::sort(order.begin(), order.end());
    std::vector<std::uint32_t> near;
    for (const auto& [score, k] : order) {
      const Plane& plane = planes[k];
      const auto isOther = [&](std::uint32_t f) { return faces[f].normal.dot(plane.normal) < kOtherFace; };
      double highest = 0;
      std::size_t taken = 0;
      near.clear();
      for (std::uint32_t i = 0; i < balls.size(); ++i) {
        const double top = topOver(plane, balls[i]);
        if (std::abs(top) > tolerance) continue;
        if (!std::all_of(of_ball[i].begin(), of_ball[i].end(), isOther)) {
          ++taken;
          continue;
        }
        near.push_back(i);
        highest = std::max(highest, top);
      }
      if (near.size() < std::max(kFewest, taken)) continue;  // what is left of a face is not another one
      for (const std::uint32_t i : near) of_ball[i].push_back(static_cast<std::uint32_t>(faces.size()));
      faces.push_back({plane.normal, plane.height + highest});
    }
  }

  /// Moves a ball until its top is in all of these, and makes it larger by `growth` of each move. By the method of Kaczmarz.
  Vector4d levelledTo(std::span<const std::uint32_t> these, Vector4d ball, double growth, double rest) const {
    double off = 2 * rest;
    for (int round = 0; round < kMostRounds && off > rest; ++round) {
      off = 0;
      for (const std::uint32_t f : these) {
        const Eigen::Vector3d& n = faces[f].normal;
        const double rise = -topOver(faces[f], ball);
        ball += rise / (1 + growth) * Vector4d(n.x(), n.y(), n.z(), growth);
        off = std::max(off, std::abs(rise));
      }
    }
    return ball;
  }
};

}  // namespace

std::vector<Sphere> levelled(std::span<const Sphere> balls, std::span<const Plane> planes, double tolerance) {
  std::vector<Vector4d> before;
  for (const Sphere& s : balls) before.push_back(vectorOf(s));
  const FlatFaces flat(before, planes, tolerance);
  if (flat.faces.empty()) return {};
  const double rest = kRest * tolerance;
  std::vector<Sphere> out(balls.begin(), balls.end());
  std::vector<std::uint32_t> level;
  for (std::size_t i = 0; i < balls.size(); ++i) {
    const std::vector<std::uint32_t>& near = flat.of_ball[i];
    const auto isGood = [&](const Vector4d& ball) {
      const Vector4d way = ball - before[i];
      const auto isIn = [&](std::uint32_t f) { return std::abs(topOver(flat.faces[f], ball)) <= rest; };
      const auto isBelow = [&](std::uint32_t f) { return topOver(flat.faces[f], ball) <= rest; };
      return way.head<3>().norm() + std::abs(way[3]) <= kFarthestMove * tolerance && std::all_of(level.begin(), level.end(), isIn) &&
             std::all_of(near.begin(), near.end(), isBelow);
    };
    level.clear();
    for (const std::uint32_t face : near) {
      level.push_back(face);
      // Where faces meet at an edge it is enough to move; between two that are opposite it has to grow.
      Vector4d ball = flat.levelledTo(level, before[i], 0, rest);
      if (!isGood(ball)) ball = flat.levelledTo(level, before[i], 1, rest);
      if (isGood(ball))
        out[i] = {static_cast<float>(ball[0]), static_cast<float>(ball[1]), static_cast<float>(ball[2]), static_cast<float>(ball[3])};
      else
        level.pop_back();
    }
  }
  return out;
}

}  // namespace spheretree::runtime
