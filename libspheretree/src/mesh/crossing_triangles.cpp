// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/crossing_triangles.h"

#include <CGAL/Box_intersection_d/Box_with_info_d.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/box_intersection_d.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <tuple>

#include "base/ball.h"
#include "mesh/canonical_order.h"

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

// The corner of a triangle at which at least kFan triangles meet, if there is one.
constexpr std::size_t kFan = 64;
constexpr std::uint32_t kNoHub = std::numeric_limits<std::uint32_t>::max();

std::vector<std::uint32_t> hubsOf(const TriangleMesh& mesh) {
  std::vector<std::uint32_t> count(mesh.positions.size()), hub(mesh.triangles.size(), kNoHub);
  for (const Triangle& t : mesh.triangles)
    for (const std::uint32_t v : t) ++count[v];
  for (std::size_t t = 0; t < hub.size(); ++t)
    for (const std::uint32_t v : mesh.triangles[t])
      if (count[v] >= kFan && (hub[t] == kNoHub || std::pair(count[v], hub[t]) > std::pair(count[hub[t]], v))) hub[t] = v;
  return hub;
}

// A few neighbouring triangles, with a box along their longest side and their normal: around slivers that lie askew, it
// is far smaller than a box along the axes.
struct Cluster {
  std::size_t first = 0, last = 0;  // places in the order of the search
  std::uint32_t hub = kNoHub;       // of all its triangles
  Eigen::AlignedBox3d box{};
  Eigen::Matrix3d axes = Eigen::Matrix3d::Zero();            // rows
  Vector3d low = Vector3d::Zero(), high = Vector3d::Zero();  // along them

  // The box of a triangle along the axes.
  Eigen::AlignedBox3d boxOf(const std::array<Vector3d, 3>& corners) const {
    const Vector3d a = axes * corners[0], b = axes * corners[1], c = axes * corners[2];
    return {a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c)};
  }
  bool excludes(const Eigen::AlignedBox3d& along) const {
    return (along.min().array() > high.array()).any() || (along.max().array() < low.array()).any();
  }
  bool excludes(const Cluster& other) const {
    const Vector3d middle = axes * (other.axes.transpose() * (0.5 * (other.low + other.high)));
    const Vector3d reach = (axes * other.axes.transpose()).cwiseAbs() * (0.5 * (other.high - other.low));
    return ((middle - reach).array() > high.array()).any() || ((middle + reach).array() < low.array()).any();
  }
};

// Finds the pairs that cross, in tasks that do not depend on each other. Triangles with a common hub meet elsewhere
// only if their directions from it do: these pairs are found among the directions, all others among clusters.
class CrossingSearch {
 public:
  CrossingSearch(const TriangleMesh& mesh, const std::vector<char>& is_flat) : mesh_(mesh) {
    Eigen::AlignedBox3d whole;
    std::vector<std::uint32_t> order;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
      if (!is_flat[t]) {
        order.push_back(t);
        for (int k = 0; k < 3; ++k) whole.extend(mesh.corner(t, k));
      }
    if (order.empty()) return;
    margin_ = kSure * std::max(whole.min().cwiseAbs().maxCoeff(), whole.max().cwiseAbs().maxCoeff());
    const std::vector<std::uint32_t> hub = hubsOf(mesh);
    std::vector<std::uint64_t> place(mesh.triangles.size());
    const auto each = [](std::size_t count, auto&& one) {
      tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count), [&](const auto& range) {
        for (std::size_t i = range.begin(); i < range.end(); ++i) one(i);
      });
    };
    each(order.size(), [&](std::size_t i) {
      const auto [a, b, c] = cornersOf(order[i]);
      place[order[i]] = placeOnCurve((a + b + c) / 3, whole);
    });
    const auto key = [&](std::uint32_t t) { return std::tuple(hub[t], place[t], t); };
    tbb::parallel_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return key(a) < key(b); });
    order_ = std::move(order);
    place = {};
    std::size_t begun = 0;  // triangles of one hub
    for (std::size_t i = 0; i < order_.size(); ++i) {
      const std::uint32_t own = hub[order_[i]];
      if (i == 0 || own != hub[order_[begun]]) begun = i;
      if ((i - begun) % kClusterSize == 0) clusters_.push_back({i, i, own});
      clusters_.back().last = i + 1;
      if (own == kNoHub) continue;
      if (i == begun) fans_.push_back({i, i});
      fans_.back()[1] = i + 1;
    }
    boxes_.resize(order_.size());
    each(clusters_.size(), [&](std::size_t c) { fit(clusters_[c]); });
    findChunks(whole);
  }

  std::size_t tasks() const { return fans_.size() + earlier_.size(); }

  /// Appends the pairs that one task finds; `goes_on` ends it by returning false.
  template <class GoesOn>
  void search(std::size_t task, std::vector<Pair>& pairs, GoesOn&& goes_on) const {
    try {
      const auto test = [&](std::uint32_t a, std::uint32_t b) {
        if (!goes_on()) throw Enough{};
        if (doCross(mesh_.positions, mesh_.triangles[a], mesh_.triangles[b])) pairs.push_back(std::minmax(a, b));
      };
      if (task < fans_.size())
        searchFan(fans_[task], test);
      else
        searchChunk(task - fans_.size(), test);
    } catch (const Enough&) {
    }
  }

 private:
  static constexpr std::size_t kClusterSize = 16, kChunk = 1024;
  struct Enough {};

  std::array<Vector3d, 3> cornersOf(std::uint32_t t) const { return {mesh_.corner(t, 0), mesh_.corner(t, 1), mesh_.corner(t, 2)}; }

  void fit(Cluster& cluster) {
    Vector3d longest = Vector3d::Zero(), normal = Vector3d::Zero();
    for (std::size_t i = cluster.first; i < cluster.last; ++i) {
      const auto corners = cornersOf(order_[i]);
      const Vector3d cross = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
      normal += cross.dot(normal) < 0 ? Vector3d(-cross) : cross;
      for (std::size_t k = 0; k < 3; ++k) {
        boxes_[i].extend(corners[k]);
        if (const Vector3d side = corners[(k + 1) % 3] - corners[k]; side.squaredNorm() > longest.squaredNorm()) longest = side;
      }
      cluster.box.extend(boxes_[i]);
    }
    const Vector3d along = longest.normalized(), across = normal.cross(along).normalized();
    cluster.axes << along.transpose(), across.transpose(), along.cross(across).transpose();
    if (!cluster.axes.allFinite() || !(across.squaredNorm() > 0.5)) cluster.axes.setIdentity();
    cluster.low.setConstant(kInfinity), cluster.high.setConstant(-kInfinity);
    for (std::size_t i = cluster.first; i < cluster.last; ++i)
      for (const Vector3d& p : cornersOf(order_[i])) {
        const Vector3d at = cluster.axes * p;
        cluster.low = cluster.low.cwiseMin(at), cluster.high = cluster.high.cwiseMax(at);
      }
    cluster.low.array() -= margin_, cluster.high.array() += margin_;
  }

  static Box boxOf(const Eigen::AlignedBox3d& box, std::size_t info) {
    return Box(CGAL::Bbox_3(box.min().x(), box.min().y(), box.min().z(), box.max().x(), box.max().y(), box.max().z()),
               static_cast<std::uint32_t>(info));
  }

  // Clusters in the order of their lower ends along an axis, in chunks. Two boxes overlap within a chunk, or one of
  // them begins in an earlier chunk and reaches into the later one.
  void findChunks(const Eigen::AlignedBox3d& whole) {
    Eigen::Index longest = 0;
    whole.sizes().maxCoeff(&longest);
    const int axis = static_cast<int>(longest);
    for (std::size_t c = 0; c < clusters_.size(); ++c)
      in_order_.push_back(boxOf(clusters_[c].box, c));  // on one thread, since CGAL counts them
    std::sort(in_order_.begin(), in_order_.end(),
              [&](const Box& a, const Box& b) { return std::pair(a.min_coord(axis), a.info()) < std::pair(b.min_coord(axis), b.info()); });
    earlier_.resize((in_order_.size() + kChunk - 1) / kChunk);
    for (std::size_t c = 1; c < earlier_.size(); ++c) {
      const double begin = in_order_[c * kChunk].min_coord(axis);
      const auto reaches = [&](std::size_t i) { return in_order_[i].max_coord(axis) >= begin; };
      std::copy_if(earlier_[c - 1].begin(), earlier_[c - 1].end(), std::back_inserter(earlier_[c]), reaches);
      for (std::size_t i = (c - 1) * kChunk; i < c * kChunk; ++i)
        if (reaches(i)) earlier_[c].push_back(static_cast<std::uint32_t>(i));
    }
    for (const auto& [first, last] : fans_)
      for (std::size_t i = first; i < last; ++i) directions_.push_back(directionBox(i));
  }

  // Around the directions of a triangle from its hub: the arc over a chord c rises above it by at most c^2 / 4.
  Box directionBox(std::size_t i) const {
    const Triangle& t = mesh_.triangles[order_[i]];
    const std::uint32_t hub = hubAt(i);
    const std::size_t k = t[0] == hub ? 0 : t[1] == hub ? 1 : 2;
    const Vector3d& origin = mesh_.positions[hub];
    const Vector3d p = (mesh_.positions[t[(k + 1) % 3]] - origin).stableNormalized(),
                   q = (mesh_.positions[t[(k + 2) % 3]] - origin).stableNormalized();
    Eigen::AlignedBox3d box(p.cwiseMin(q), p.cwiseMax(q));
    const double rise = 0.25 * (p - q).squaredNorm() + kSure;
    box.min().array() -= rise, box.max().array() += rise;
    return boxOf(box, i);
  }

  std::uint32_t hubAt(std::size_t place) const {
    const auto after =
        std::upper_bound(clusters_.begin(), clusters_.end(), place, [](std::size_t i, const Cluster& c) { return i < c.first; });
    return std::prev(after)->hub;
  }

  template <class Test>
  void searchFan(const std::array<std::size_t, 2>& fan, Test&& test) const {
    const auto first = directions_.begin() + static_cast<std::ptrdiff_t>(fan[0] - fans_.front()[0]);
    std::vector<Box> own(first, first + static_cast<std::ptrdiff_t>(fan[1] - fan[0]));
    CGAL::box_self_intersection_d(own.begin(), own.end(), [&](const Box& a, const Box& b) { test(order_[a.info()], order_[b.info()]); });
  }

  template <class Test>
  void searchChunk(std::size_t chunk, Test&& test) const {
    const auto first = in_order_.begin() + static_cast<std::ptrdiff_t>(chunk * kChunk);
    std::vector<Box> own(first, first + static_cast<std::ptrdiff_t>(std::min(kChunk, in_order_.size() - chunk * kChunk))), before;
    for (const std::uint32_t i : earlier_[chunk]) before.push_back(in_order_[i]);
    // Triangles and their boxes along the axes of the first of two clusters, with a margin: slivers beside each other,
    // whose boxes along the axes of space overlap, have boxes there that do not.
    std::vector<std::pair<std::size_t, Eigen::AlignedBox3d>> within, near;
    const auto place = [&](const Cluster& cluster, std::size_t i) {
      const Eigen::AlignedBox3d along = cluster.boxOf(cornersOf(order_[i]));
      return std::pair(i, Eigen::AlignedBox3d(along.min().array() - margin_, along.max().array() + margin_));
    };
    for (const Box& box : own) {
      const Cluster& cluster = clusters_[box.info()];
      if (cluster.hub != kNoHub) continue;
      within.clear();
      for (std::size_t i = cluster.first; i < cluster.last; ++i) {
        const auto next = place(cluster, i);
        for (const auto& [j, along] : within)
          if (along.intersects(next.second) && boxes_[j].intersects(boxes_[i])) test(order_[j], order_[i]);
        within.push_back(next);
      }
    }
    const auto compare = [&](const Box& one, const Box& two) {
      const Cluster &a = clusters_[one.info()], &b = clusters_[two.info()];
      if ((a.hub != kNoHub && a.hub == b.hub) || a.excludes(b) || b.excludes(a)) return;
      near.clear();
      for (std::size_t j = b.first; j < b.last; ++j)
        if (boxes_[j].intersects(a.box))
          if (const auto placed = place(a, j); !a.excludes(placed.second)) near.push_back(placed);
      if (near.empty()) return;
      for (std::size_t i = a.first; i < a.last; ++i) {
        if (!boxes_[i].intersects(b.box)) continue;
        const Eigen::AlignedBox3d own_along = place(a, i).second;
        for (const auto& [j, along] : near)
          if (along.intersects(own_along) && boxes_[i].intersects(boxes_[j])) test(order_[i], order_[j]);
      }
    };
    CGAL::box_intersection_d(own.begin(), own.end(), before.begin(), before.end(), compare);
    CGAL::box_self_intersection_d(own.begin(), own.end(), compare);
  }

  const TriangleMesh& mesh_;
  double margin_ = 0;                                // rounding of a place along an axis
  std::vector<std::uint32_t> order_;                 // triangles by their hub, then along a curve
  std::vector<Eigen::AlignedBox3d> boxes_;           // of them
  std::vector<Cluster> clusters_;                    // in their order
  std::vector<std::array<std::size_t, 2>> fans_;     // triangles with a common hub; they precede those without
  std::vector<Box> directions_;                      // of the triangles of fans
  std::vector<Box> in_order_;                        // of clusters
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
  const CrossingSearch search(mesh, is_flat);
  CrossingTriangles found;
  std::vector<std::vector<Pair>> pairs(search.tasks());
  std::atomic<std::size_t> total = 0;
  tbb::parallel_for(std::size_t{0}, search.tasks(), [&](std::size_t task) {
    std::size_t counted = 0;
    search.search(task, pairs[task], [&] {
      progress.check();
      total += pairs[task].size() - counted;
      counted = pairs[task].size();
      return total <= max_pairs;
    });
    total += pairs[task].size() - counted;
  });
  if (total <= max_pairs) {
    for (const std::vector<Pair>& of_task : pairs) found.pairs.insert(found.pairs.end(), of_task.begin(), of_task.end());
  } else {  // too many: the first ones again, in an order that does not depend on the threads
    found.is_stopped = true;
    for (std::size_t task = 0; found.pairs.size() < max_pairs; ++task)
      search.search(task, found.pairs, [&] {
        progress.check();
        return found.pairs.size() < max_pairs;
      });
  }
  std::sort(found.pairs.begin(), found.pairs.end());
  return found;
}

}  // namespace spheretree::builder
