// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/farthest_point.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr double kRelativeGap = 0.05;
constexpr double kLarge = 0.02;                // as a share of the diagonal
constexpr std::size_t kMaxHalved = 1'000'000;  // number of halved pieces at which the bound is returned as it is, still proven

struct Piece {
  std::array<Vector3d, 3> corner;
  std::uint32_t origin;  // index in the list of given triangles
  Vector3d middle() const { return (corner[0] + corner[1] + corner[2]) / 3; }
  double spread() const {
    const Vector3d m = middle();
    return std::sqrt(std::max({(corner[0] - m).squaredNorm(), (corner[1] - m).squaredNorm(), (corner[2] - m).squaredNorm()}));
  }
  /// Halves the piece across its longest side.
  std::array<Piece, 2> halves() const {
    std::size_t k = 0;
    double longest = -1;
    for (std::size_t j = 0; j < 3; ++j)
      if (const double length = (corner[(j + 1) % 3] - corner[(j + 2) % 3]).squaredNorm(); length > longest) longest = length, k = j;
    const Vector3d half = 0.5 * (corner[(k + 1) % 3] + corner[(k + 2) % 3]);
    return {Piece{{corner[k], corner[(k + 1) % 3], half}, origin}, Piece{{corner[k], half, corner[(k + 2) % 3]}, origin}};
  }
};

std::vector<Piece> piecesOf(const TriangleMesh& mesh, std::span<const std::uint32_t> triangles) {
  std::vector<Piece> pieces;
  pieces.reserve(triangles.size());
  for (const std::uint32_t t : triangles)
    pieces.push_back({{mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2)}, static_cast<std::uint32_t>(pieces.size())});
  return pieces;
}

/// Works in rounds: `judge(piece)` in parallel, then `decide(piece, judgement)` in order, which returns true to halve
/// the piece.
template <class Judge, class Decide>
void refine(std::vector<Piece> pieces, Progress& progress, Judge judge, Decide decide) {
  std::vector<decltype(judge(pieces[0]))> judgement;
  std::vector<Piece> next;
  while (!pieces.empty()) {
    judgement.resize(pieces.size());
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, pieces.size(), 256), [&](const tbb::blocked_range<std::size_t>& range) {
      if (progress.cancelled()) return;
      for (std::size_t i = range.begin(); i < range.end(); ++i) judgement[i] = judge(pieces[i]);
    });
    progress.check();
    next.clear();
    for (std::size_t i = 0; i < pieces.size(); ++i)
      if (decide(pieces[i], judgement[i]))
        for (const Piece& half : pieces[i].halves()) next.push_back(half);
    pieces.swap(next);
  }
}

/// Distance over a piece: at its middle, and an upper bound.
struct Reach {
  double found, largest;
};

Reach reachOf(const DistanceField& field, const Piece& piece) {
  const NearestPoint nearest = field.nearest(piece.middle());
  // The distance to one triangle is convex, so that over the piece it is largest at a corner.
  const auto [a, b, c] = field.corners(nearest.triangle);
  double to_triangle = 0;
  for (const Vector3d& p : piece.corner) to_triangle = std::max(to_triangle, nearestOnTriangle(p, a, b, c).distance);
  return {nearest.distance, std::min(to_triangle, nearest.distance + piece.spread())};
}

}  // namespace

double farthestFrom(const DistanceField& field, const TriangleMesh& mesh, std::span<const std::uint32_t> triangles, double sufficient_bound,
                    Progress& progress) {
  double found = 0, bound = 0;
  for (const std::uint32_t t : triangles)
    for (int k = 0; k < 3; ++k) found = std::max(found, field.distance(mesh.corner(t, k)));
  std::size_t judged = 0;
  refine(
      piecesOf(mesh, triangles), progress, [&](const Piece& piece) { return reachOf(field, piece); },
      [&](const Piece&, const Reach& reach) {
        found = std::max(found, reach.found);
        if (reach.largest > found * (1 + kRelativeGap) + sufficient_bound && ++judged < kMaxHalved) return true;
        bound = std::max(bound, reach.largest);
        return false;
      });
  return std::max(found, bound);
}

PartsNearSurface clipToDepth(const DistanceField& solid, const TriangleMesh& mesh, std::span<const std::uint32_t> triangles, double depth,
                             Progress& progress) {
  PartsNearSurface result;
  std::vector<char> is_kept(triangles.size(), 0), is_cut(triangles.size(), 0);
  refine(
      piecesOf(mesh, triangles), progress, [&](const Piece& piece) { return solid.signedDistance(piece.middle()); },
      [&](const Piece& piece, double distance) {
        const double spread = piece.spread();
        if (distance + spread < -depth) {
          is_cut[piece.origin] = 1;
          return false;
        }
        const bool is_large = spread > kLarge * solid.diagonal() && distance - spread < -depth;  // may be deep away from its middle
        if (is_large || (distance < -depth && spread > 0.25 * depth)) return true;
        is_kept[piece.origin] = 1;
        const auto first = static_cast<std::uint32_t>(result.pieces.positions.size());
        for (const Vector3d& p : piece.corner) result.pieces.positions.push_back(p);
        result.pieces.triangles.push_back({first, first + 1, first + 2});
        return false;
      });
  for (std::size_t i = 0; i < triangles.size(); ++i)
    if (is_cut[i]) (is_kept[i] ? result.partly : result.removed).push_back(triangles[i]);
  return result;
}

}  // namespace spheretree::builder
