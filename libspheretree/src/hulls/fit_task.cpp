// SPDX-License-Identifier: GPL-3.0-or-later
#include "hulls/fit_task.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "hulls/inscribed_ball.h"
#include "spheretree/core/none.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr std::size_t kMaxSamples = 40000;       // of the surface
constexpr double kSampleArea = 2;                // for each of them, as a multiple of the tolerance times the radius of the ball below it
constexpr double kPlastic = 0.7548776662466927;  // its multiples and those of its square fill a square evenly

Vector3d doubleAreaOf(const Piece& piece) { return (piece.corner[1] - piece.corner[0]).cross(piece.corner[2] - piece.corner[0]); }

double areaOf(const Piece& piece) { return 0.5 * doubleAreaOf(piece).norm(); }

Vector3d normalOf(const Piece& piece) { return doubleAreaOf(piece).normalized(); }

// Strips parallel to the shortest side. Halving alone would cut a sliver into many more pieces, each thinner than it.
std::vector<Piece> stripsOf(const Piece& piece, double width) {
  const std::size_t k = shortestSide(piece);
  const Vector3d &apex = piece.corner[k], &b = piece.corner[(k + 1) % 3], &c = piece.corner[(k + 2) % 3];
  const double count = std::ceil(std::sqrt(side2(piece, longestSide(piece))) / width);
  std::vector<Piece> strips;
  Vector3d b_before = apex, c_before = apex;
  for (double i = 1; i <= count; ++i) {
    const Vector3d b_here = i < count ? Vector3d(apex + i / count * (b - apex)) : b,
                   c_here = i < count ? Vector3d(apex + i / count * (c - apex)) : c;
    strips.push_back({{b_before, b_here, c_here}});
    if (i > 1) strips.push_back({{b_before, c_here, c_before}});
    b_before = b_here, c_before = c_here;
  }
  return strips;
}

// Place number `n` of a sequence that is even on the piece.
Vector3d placeIn(const Piece& piece, std::size_t n) {
  const auto& [a, b, c] = piece.corner;
  double u = std::fmod(static_cast<double>(n) * kPlastic, 1.0), v = std::fmod(static_cast<double>(n) * kPlastic * kPlastic, 1.0);
  if (u + v > 1) u = 1 - u, v = 1 - v;
  return a + u * (b - a) + v * (c - a);
}

}  // namespace

FitTask::FitTask(const TriangleMesh& covered, const DistanceField& of_solid, const FitSettings& given, Progress& reported)
    : mesh(covered), field(of_solid), settings(given), progress(reported) {
  std::vector<std::vector<CutPiece>> cut(mesh.triangles.size());
  tbb::parallel_for(std::size_t{0}, cut.size(), [&](std::size_t t) { cut[t] = cutTriangle(pieceOf(mesh, t, Vector3d::Zero())); });
  for (const auto& of_triangle : cut) pieces_.insert(pieces_.end(), of_triangle.begin(), of_triangle.end());
}

// Pieces that are no longer than the balls below them are wide.
std::vector<FitTask::CutPiece> FitTask::cutTriangle(const Piece& triangle) const {
  std::vector<CutPiece> cut;
  if (!(areaOf(triangle) > 0)) return cut;
  const auto radiusOf = [&](const Piece& p) { return std::max(ballBelowPiece(p, 0.5 * settings.tolerance).radius, settings.tolerance); };
  double radius = radiusOf(triangle);
  std::vector<Piece> stack = stripsOf(triangle, 2 * radius);
  for (const bool is_whole = stack.size() == 1; !stack.empty();) {
    const Piece piece = stack.back();
    stack.pop_back();
    const std::size_t k = longestSide(piece);
    if (!is_whole) radius = radiusOf(piece);
    if (side2(piece, k) > 4 * radius * radius)
      for (const Piece& half : halvesOf(piece, k)) stack.push_back(half);
    else
      cut.push_back({piece, areaOf(piece) / (kSampleArea * radius * settings.tolerance)});
  }
  return cut;
}

std::vector<FitSample> FitTask::samples() const {
  double wanted = 0;
  for (const CutPiece& cut : pieces_) wanted += cut.samples;
  const double share = std::min(1.0, kMaxSamples / wanted);
  double sum = 0.5;
  std::vector<FitSample> out;
  for (const auto& [piece, samples] : pieces_) {
    sum += share * samples;
    for (; sum >= 1; --sum) {
      const std::size_t n = out.size();
      out.push_back({n % 2 == 0 ? piece.corner[n / 2 % 3] : placeIn(piece, n), normalOf(piece)});
    }
  }
  return out;
}

FitTask::Bare FitTask::bareOf(const HullCover& cover) const {
  std::vector<char> held(pieces_.size(), 0);
  std::vector<Vector3d> place(pieces_.size());
  tbb::parallel_for(std::size_t{0}, held.size(), [&](std::size_t i) { held[i] = cover.holds(pieces_[i].piece, kNone, &place[i]); });
  Bare bare;
  for (std::size_t i = 0; i < held.size(); ++i)
    if (!held[i]) {
      bare.samples.push_back({place[i], normalOf(pieces_[i].piece)});
      bare.pieces.push_back(pieces_[i].piece);
    }
  return bare;
}

Ball FitTask::ballBelowPiece(const Piece& piece, double gap) const { return ballBelow(field, centroidOf(piece), normalOf(piece), gap); }

}  // namespace spheretree::builder
