// SPDX-License-Identifier: GPL-3.0-or-later
#include "tissue/cut_pieces.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "geometry/ball_index.h"
#include "spheretree/builder/build_settings.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

using Weights = Eigen::Vector3d;  // barycentric coordinates of a corner of a piece

struct Piece {
  std::uint32_t leaf;
  std::uint32_t triangle;
  std::vector<Weights> corners;
};

// Cuts triangles, one after the other.
class Cutter {
 public:
  Cutter(const BallIndex& index, double allowed) : index_(index), allowed_(allowed) {}

  void cut(const std::array<Vector3d, 3>& triangle, std::uint32_t number, std::vector<Piece>& pieces) {
    triangle_ = triangle, number_ = number, pieces_ = &pieces;
    const Vector3d middle = (triangle[0] + triangle[1] + triangle[2]) / 3;
    double extent2 = 0;
    for (const Vector3d& p : triangle) extent2 = std::max(extent2, (p - middle).squaredNorm());
    std::vector<std::uint32_t> near;
    index_.tree.searchWithin(middle, extent2 * (1 + kRounding), [&](std::size_t first, std::size_t count) {
      for (std::size_t slot = first; slot < first + count; ++slot) near.push_back(static_cast<std::uint32_t>(slot));
    });
    std::sort(near.begin(), near.end(), [&](std::uint32_t a, std::uint32_t b) { return index_.original(a) < index_.original(b); });
    divide({Weights(1, 0, 0), Weights(0, 1, 0), Weights(0, 0, 1)}, near);
  }

 private:
  Vector3d place(const Weights& w) const { return w[0] * triangle_[0] + w[1] * triangle_[1] + w[2] * triangle_[2]; }
  double power(std::uint32_t slot, const Vector3d& p) const {
    const Ball& ball = index_.balls[slot];
    return (p - ball.centre).squaredNorm() - ball.radius * ball.radius;
  }

  void divide(std::vector<Weights> polygon, std::vector<std::uint32_t> near) {
    while (polygon.size() >= 3) {
      std::vector<Vector3d> corners;
      for (const Weights& w : polygon) corners.push_back(place(w));
      const std::uint32_t holder = bestHolder(corners, near);
      std::size_t worst = 0;
      for (std::size_t v = 0; v < corners.size(); ++v)
        if (power(holder, corners[v]) > power(holder, corners[worst])) worst = v;
      const auto other = std::min_element(
          near.begin(), near.end(), [&](std::uint32_t a, std::uint32_t b) { return power(a, corners[worst]) < power(b, corners[worst]); });
      const bool is_held = power(holder, corners[worst]) <= 0;
      if (is_held || *other == holder) {
        if (!is_held) refuseHole(holder, corners[worst]);
        pieces_->push_back({index_.original(holder), number_, std::move(polygon)});
        return;
      }
      // Neither side of the plane of equal power needs the leaf of the other side again, so the recursion ends.
      const std::uint32_t a = std::min(holder, *other), b = std::max(holder, *other);
      std::vector<double> difference;
      for (const Vector3d& p : corners) difference.push_back(power(a, p) - power(b, p));
      std::vector<Weights> low = side(polygon, difference, 1), high = side(polygon, difference, -1);
      std::vector<std::uint32_t> without_b = near;
      std::erase(without_b, b);
      divide(std::move(low), std::move(without_b));
      std::erase(near, a);
      polygon = std::move(high);
    }
  }

  // The leaf for which the polygon's largest distance outside the leaf is smallest.
  std::uint32_t bestHolder(const std::vector<Vector3d>& corners, const std::vector<std::uint32_t>& near) const {
    if (near.empty()) refuseHole(0, corners[0]);
    double smallest = std::numeric_limits<double>::infinity();
    std::uint32_t best = near.front();
    for (const std::uint32_t slot : near) {
      double largest = -std::numeric_limits<double>::infinity();
      for (const Vector3d& p : corners) largest = std::max(largest, power(slot, p));
      if (largest < smallest) smallest = largest, best = slot;
    }
    return best;
  }

  // The part with sign * difference <= 0. Both sides compute the same new corners.
  static std::vector<Weights> side(const std::vector<Weights>& polygon, const std::vector<double>& difference, double sign) {
    std::vector<Weights> part;
    for (std::size_t v = 0, before = polygon.size() - 1; v < polygon.size(); before = v++) {
      const double here = difference[v], there = difference[before];
      if ((here < 0 && there > 0) || (here > 0 && there < 0))
        part.push_back(polygon[before] + (there / (there - here)) * (polygon[v] - polygon[before]));
      if (sign * here <= 0) part.push_back(polygon[v]);
    }
    return part;
  }

  void refuseHole(std::uint32_t slot, const Vector3d& p) const {
    const Ball& ball = index_.balls[slot];
    const double gap = (p - ball.centre).norm() - ball.radius;
    if (gap <= allowed_) return;
    throw BuildError("tissue: the leaves of the tree leave triangle " + std::to_string(number_) + " of the mesh uncovered by " +
                     std::to_string(gap) + " mm: this is not the mesh that the tree was built from");
  }

  const BallIndex& index_;
  double allowed_;
  std::array<Vector3d, 3> triangle_;
  std::uint32_t number_ = 0;
  std::vector<Piece>* pieces_ = nullptr;
};

// Numbers the corners: vertices keep their number, each cut gets one number in its triangle.
class Numbering {
 public:
  Numbering(const TriangleMesh& mesh, std::size_t leaves) : mesh_(mesh), corners_of_(leaves) {}

  void add(const Piece& piece) {
    if (piece.triangle != triangle_) triangle_ = piece.triangle, first_cut_ = out_.cuts.size();
    for (const Weights& w : piece.corners) corners_of_[piece.leaf].push_back(numberOf(w));
  }

  TissueLeaves finish() {
    out_.begin.push_back(0);
    for (std::vector<std::uint32_t>& corners : corners_of_) {
      std::sort(corners.begin(), corners.end());
      corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
      out_.corners.insert(out_.corners.end(), corners.begin(), corners.end());
      out_.begin.push_back(static_cast<std::uint32_t>(out_.corners.size()));
    }
    return std::move(out_);
  }

 private:
  std::uint32_t numberOf(const Weights& w) {
    const Triangle& vertex = mesh_.triangles[triangle_];
    for (int k = 0; k < 3; ++k)
      if (w[k] == 1 && w[(k + 1) % 3] == 0 && w[(k + 2) % 3] == 0) return vertex[static_cast<std::size_t>(k)];
    const std::array<double, 2> weight{w[1], w[2]};
    std::size_t cut = first_cut_;
    while (cut < out_.cuts.size() && out_.cuts[cut].weight != weight) ++cut;
    if (cut == out_.cuts.size()) out_.cuts.push_back({vertex, 0, weight});
    return static_cast<std::uint32_t>(mesh_.positions.size() + cut);
  }

  const TriangleMesh& mesh_;
  std::uint32_t triangle_ = kNone;
  std::size_t first_cut_ = 0;
  std::vector<std::vector<std::uint32_t>> corners_of_;
  TissueLeaves out_;
};

}  // namespace

TissueLeaves cutPieces(const TriangleMesh& mesh, std::span<const Sphere> leaves, const Vector3d& origin, Progress& progress) {
  std::vector<Ball> balls;
  for (const Sphere& s : leaves) balls.push_back({centreOf(s), s.radius});
  const BallIndex index(balls);
  double extent = 0;
  for (const Vector3d& p : mesh.positions) extent = std::max(extent, (p - origin).cwiseAbs().maxCoeff());
  std::vector<std::vector<Piece>> parts(mesh.triangles.size());
  tbb::parallel_for(std::size_t{0}, parts.size(), [&](std::size_t t) {
    progress.check();
    Cutter(index, kRounding * extent)  // how far a corner may lie outside of its leaf at rest
        .cut({mesh.corner(t, 0) - origin, mesh.corner(t, 1) - origin, mesh.corner(t, 2) - origin}, static_cast<std::uint32_t>(t), parts[t]);
  });
  Numbering numbering(mesh, leaves.size());
  for (const std::vector<Piece>& part : parts)
    for (const Piece& piece : part) numbering.add(piece);
  return numbering.finish();
}

}  // namespace spheretree::builder
