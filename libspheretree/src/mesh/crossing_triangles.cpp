// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/crossing_triangles.h"

#include <CGAL/Box_intersection_d/Box_with_info_d.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/box_intersection_d.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <iterator>
#include <optional>

#include "base/ball.h"

namespace spheretree::builder {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Box = CGAL::Box_intersection_d::Box_with_info_d<double, 3, std::uint32_t>;
using Pair = std::pair<std::uint32_t, std::uint32_t>;
using Eigen::Vector3d;

Point pointOf(const std::vector<Eigen::Vector3d>& positions, std::uint32_t vertex) {
  const Eigen::Vector3d& p = positions[vertex];
  return {p.x(), p.y(), p.z()};
}

// Beyond the rounding error of a scalar product; differences of coordinates are rounded by 1e-16 of the difference.
constexpr double kSure = 1e-14;

// Whether a plane shows, beyond rounding, that two triangles meet at most in the corner that they share. A first test
// only: exact arithmetic decides the rest. Around the middle of a fan, and in flat faces, it decides nearly all pairs.
bool areSeparate(const std::vector<Vector3d>& positions, const Triangle& a, const Triangle& b,
                 std::optional<std::array<std::size_t, 2>> shared) {
  const auto [at_a, at_b] = shared.value_or(std::array<std::size_t, 2>{0, 0});
  const Vector3d& origin = positions[a[at_a]];
  std::array<Vector3d, 3> p, q;
  double size = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    p[k] = positions[a[(at_a + k) % 3]] - origin, q[k] = positions[b[(at_b + k) % 3]] - origin;
    size = std::max({size, p[k].lpNorm<Eigen::Infinity>(), q[k].lpNorm<Eigen::Infinity>()});
  }
  const auto separates = [&](const Vector3d& normal) {
    double low_p = kInfinity, high_p = -kInfinity, low_q = kInfinity, high_q = -kInfinity;
    for (std::size_t k = shared ? 1 : 0; k < 3; ++k) {
      const double at_p = normal.dot(p[k]), at_q = normal.dot(q[k]);
      low_p = std::min(low_p, at_p), high_p = std::max(high_p, at_p), low_q = std::min(low_q, at_q), high_q = std::max(high_q, at_q);
    }
    const double margin = kSure * size * normal.lpNorm<1>();
    if (shared) return (high_p < -margin && low_q > margin) || (low_p > margin && high_q < -margin);
    return high_p + margin < low_q || high_q + margin < low_p;
  };
  if (shared) return separates((p[1].normalized() + p[2].normalized()).normalized() - (q[1].normalized() + q[2].normalized()).normalized());
  const Vector3d normal_p = (p[1] - p[0]).cross(p[2] - p[0]), normal_q = (q[1] - q[0]).cross(q[2] - q[0]);
  if (separates(normal_p) || separates(normal_q)) return true;
  for (std::size_t k = 0; k < 3; ++k)
    if (separates(normal_p.cross(p[(k + 1) % 3] - p[k])) || separates(normal_q.cross(q[(k + 1) % 3] - q[k]))) return true;
  return false;
}

// Whether two triangles at the edge from `from` to `to`, with the third corners `a` and `b`, are surely not folded onto
// each other.
bool areUnfolded(const Vector3d& from, const Vector3d& to, const Vector3d& a, const Vector3d& b) {
  const Vector3d edge = to - from, u = edge.cross(a - from), v = edge.cross(b - from);
  return u.dot(v) < -kSure * edge.squaredNorm() * (a - from).norm() * (b - from).norm();
}

// Boxes in the order of their lower ends along an axis, in chunks. Two boxes overlap within a chunk, or one of them
// begins in an earlier chunk and reaches into the later one.
class BoxChunks {
 public:
  BoxChunks(const TriangleMesh& mesh, std::vector<Box> boxes) : mesh_(mesh), boxes_(std::move(boxes)) {
    Eigen::AlignedBox3d whole;
    for (const Box& box : boxes_)
      whole.extend(Vector3d(box.min_coord(0), box.min_coord(1), box.min_coord(2)))
          .extend(Vector3d(box.max_coord(0), box.max_coord(1), box.max_coord(2)));
    if (boxes_.empty()) return;
    Eigen::Index longest = 0;
    whole.sizes().maxCoeff(&longest);
    const int axis = static_cast<int>(longest);
    std::sort(boxes_.begin(), boxes_.end(),
              [&](const Box& a, const Box& b) { return std::pair(a.min_coord(axis), a.info()) < std::pair(b.min_coord(axis), b.info()); });
    earlier_.resize((boxes_.size() + kChunk - 1) / kChunk);
    for (std::size_t c = 1; c < earlier_.size(); ++c) {
      const double begin = boxes_[c * kChunk].min_coord(axis);
      const auto reaches = [&](std::size_t i) { return boxes_[i].max_coord(axis) >= begin; };
      std::copy_if(earlier_[c - 1].begin(), earlier_[c - 1].end(), std::back_inserter(earlier_[c]), reaches);
      for (std::size_t i = (c - 1) * kChunk; i < c * kChunk; ++i)
        if (reaches(i)) earlier_[c].push_back(static_cast<std::uint32_t>(i));
    }
  }

  std::size_t size() const { return earlier_.size(); }

  /// Appends the pairs that cross and are first seen in a chunk; `goes_on` ends the search by returning false.
  template <class GoesOn>
  void search(std::size_t chunk, std::vector<Pair>& pairs, GoesOn&& goes_on) const {
    struct Enough {};
    const auto first = boxes_.begin() + static_cast<std::ptrdiff_t>(chunk * kChunk);
    std::vector<Box> own(first, first + static_cast<std::ptrdiff_t>(std::min(kChunk, boxes_.size() - chunk * kChunk))), before;
    for (const std::uint32_t i : earlier_[chunk]) before.push_back(boxes_[i]);
    const auto test = [&](const Box& a, const Box& b) {
      if (!goes_on()) throw Enough{};
      if (doCross(mesh_.positions, mesh_.triangles[a.info()], mesh_.triangles[b.info()])) pairs.push_back(std::minmax(a.info(), b.info()));
    };
    try {
      CGAL::box_intersection_d(own.begin(), own.end(), before.begin(), before.end(), test);
      CGAL::box_self_intersection_d(own.begin(), own.end(), test);
    } catch (const Enough&) {
    }
  }

 private:
  static constexpr std::size_t kChunk = 16384;
  const TriangleMesh& mesh_;
  std::vector<Box> boxes_;
  std::vector<std::vector<std::uint32_t>> earlier_;  // (chunks) boxes before the chunk that reach into it
};

}  // namespace

bool doCross(const std::vector<Eigen::Vector3d>& positions, const Triangle& a, const Triangle& b) {
  std::array<int, 3> shared_a{}, shared_b{};
  int shared = 0;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      if (a[i] == b[j]) shared_a[i] = shared_b[j] = 1, ++shared;
  const auto point = [&](const Triangle& triangle, std::size_t k) { return pointOf(positions, triangle[k % 3]); };
  if (shared == 3) return false;  // a duplicate
  if (shared == 2) {
    // They have further common points only if they are folded flat onto each other.
    const auto i = static_cast<std::size_t>(std::find(shared_a.begin(), shared_a.end(), 0) - shared_a.begin());
    const auto j = static_cast<std::size_t>(std::find(shared_b.begin(), shared_b.end(), 0) - shared_b.begin());
    if (areUnfolded(positions[a[(i + 1) % 3]], positions[a[(i + 2) % 3]], positions[a[i]], positions[b[j]])) return false;
    return CGAL::coplanar(point(a, i + 1), point(a, i + 2), point(a, i), point(b, j)) &&
           CGAL::coplanar_orientation(point(a, i + 1), point(a, i + 2), point(a, i), point(b, j)) == CGAL::POSITIVE;
  }
  // Without a shared corner, these are the first ones.
  const auto i = static_cast<std::size_t>(std::max_element(shared_a.begin(), shared_a.end()) - shared_a.begin());
  const auto j = static_cast<std::size_t>(std::max_element(shared_b.begin(), shared_b.end()) - shared_b.begin());
  if (areSeparate(positions, a, b, shared == 1 ? std::optional(std::array{i, j}) : std::nullopt)) return false;
  const Kernel::Triangle_3 ta(point(a, 0), point(a, 1), point(a, 2)), tb(point(b, 0), point(b, 1), point(b, 2));
  if (shared == 0) return CGAL::do_intersect(ta, tb);
  // If two triangles that share one corner meet elsewhere, the side opposite the corner of one of them meets the other
  // triangle.
  return CGAL::do_intersect(ta, Kernel::Segment_3(point(b, j + 1), point(b, j + 2))) ||
         CGAL::do_intersect(tb, Kernel::Segment_3(point(a, i + 1), point(a, i + 2)));
}

bool isFlat(const std::vector<Eigen::Vector3d>& positions, const Triangle& triangle) {
  const auto [a, b, c] = triangle;
  return a == b || b == c || c == a || CGAL::collinear(pointOf(positions, a), pointOf(positions, b), pointOf(positions, c));
}

bool isFlat(const TriangleMesh& mesh, std::size_t triangle) { return isFlat(mesh.positions, mesh.triangles[triangle]); }

CrossingTriangles findCrossingTriangles(const TriangleMesh& mesh, std::size_t max_pairs, const Progress& progress) {
  std::vector<char> is_flat(mesh.triangles.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, is_flat.size()), [&](const auto& range) {
    progress.check();
    for (std::size_t t = range.begin(); t < range.end(); ++t) is_flat[t] = isFlat(mesh, t);
  });
  std::vector<Box> boxes;  // made on one thread, since CGAL counts them
  boxes.reserve(mesh.triangles.size());
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto [a, b, c] = mesh.triangles[t];
    if (!is_flat[t])
      boxes.emplace_back(pointOf(mesh.positions, a).bbox() + pointOf(mesh.positions, b).bbox() + pointOf(mesh.positions, c).bbox(), t);
  }
  const BoxChunks chunks(mesh, std::move(boxes));
  CrossingTriangles found;
  std::vector<std::vector<Pair>> pairs(chunks.size());
  std::atomic<std::size_t> total = 0;
  tbb::parallel_for(std::size_t{0}, chunks.size(), [&](std::size_t c) {
    std::size_t counted = 0;
    chunks.search(c, pairs[c], [&] {
      progress.check();
      total += pairs[c].size() - counted;
      counted = pairs[c].size();
      return total <= max_pairs;
    });
    total += pairs[c].size() - counted;
  });
  if (total <= max_pairs) {
    for (const std::vector<Pair>& of_chunk : pairs) found.pairs.insert(found.pairs.end(), of_chunk.begin(), of_chunk.end());
  } else {  // too many: the first ones again, in an order that does not depend on the threads
    found.is_stopped = true;
    for (std::size_t c = 0; found.pairs.size() < max_pairs; ++c)
      chunks.search(c, found.pairs, [&] {
        progress.check();
        return found.pairs.size() < max_pairs;
      });
  }
  std::sort(found.pairs.begin(), found.pairs.end());
  return found;
}

}  // namespace spheretree::builder
