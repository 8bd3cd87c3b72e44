// SPDX-License-Identifier: GPL-3.0-or-later
#include "cut/cut_distance.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <queue>
#include <tuple>

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

constexpr double kAccuracy = 1e-4;  // of the result, and length of a piece of a step that is not divided [mm]

/// The distance of a ball, negative where it reaches into the layer; and its point that is nearest to the layer.
struct BallDistance {
  double distance;
  Vector3d nearest;
};

BallDistance ballDistance(const DistanceField& layer, const Vector3d& centre, double radius) {
  NearestPoint at;
  const double distance = layer.signedDistance(centre, &at);
  const Vector3d way = at.point - centre;
  const double share = distance > radius ? radius / distance : 1;  // a ball that reaches into the layer has the surface point itself
  return {distance - radius, distance > 0 ? Vector3d(centre + share * way) : centre};
}

struct Piece {
  double least;  // no ball on the piece is nearer [mm]
  std::uint64_t order;
  Vector3d from, to;
  double radius, at_from, at_to;  // distances of the balls at its ends
  bool operator<(const Piece& other) const { return std::tie(least, order) > std::tie(other.least, other.order); }
};

}  // namespace

std::optional<CutDistance> distanceOfCut(const DistanceField& object, const DistanceField& layer, std::span<const BurrPath> paths) {
  std::priority_queue<Piece> open;
  std::uint64_t order = 0;
  CutDistance out{std::numeric_limits<double>::infinity(), std::nullopt};
  const auto look = [&](const Vector3d& centre, double radius) {
    const BallDistance ball = ballDistance(layer, centre, radius);
    if ((!out.high || ball.distance < *out.high) && object.signedDistance(ball.nearest) <= 0) out.high = ball.distance;
    return ball.distance;
  };
  const auto add = [&](const Vector3d& from, const Vector3d& to, double radius, double at_from, double at_to) {
    const double length = (to - from).norm();
    const Piece piece{(at_from + at_to - length) / 2, order++, from, to, radius, at_from, at_to};
    if (length <= kAccuracy)
      out.low = std::min(out.low, piece.least);
    else
      open.push(piece);
  };
  for (const BurrPath& path : paths) {
    double at_from = look(path.centres[0], path.radius);
    for (std::size_t k = 1; k < path.centres.size(); ++k) {
      const double at_to = look(path.centres[k], path.radius);
      add(path.centres[k - 1], path.centres[k], path.radius, at_from, at_to);
      at_from = at_to;
    }
  }
  if (order == 0) return std::nullopt;
  while (!open.empty()) {
    const Piece piece = open.top();
    if (piece.least >= std::min(out.low, out.high ? *out.high - kAccuracy : out.low) || (out.high && *out.high <= 0)) {
      out.low = std::min(out.low, piece.least);
      break;
    }
    open.pop();
    const Vector3d middle = (piece.from + piece.to) / 2;
    const double at = look(middle, piece.radius);
    add(piece.from, middle, piece.radius, piece.at_from, at);
    add(middle, piece.to, piece.radius, at, piece.at_to);
  }
  out.low = std::max(0.0, out.high ? std::min(out.low, *out.high) : out.low);
  if (out.high) out.high = std::max(0.0, *out.high);
  return out;
}

}  // namespace spheretree::builder
