// SPDX-License-Identifier: GPL-3.0-or-later
#include "split/fill_scan.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <queue>
#include <tuple>

#include "mesh/crossing_triangles.h"
#include "repair/fill_holes.h"
#include "spheretree/builder/mesh_checks.h"
#include "split/close_scan.h"
#include "split/crossing_search.h"
#include "split/move_apart.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

using Loop = std::vector<std::uint32_t>;
using Pairs = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

constexpr std::size_t kMaxSpanned = 3000;  // largest number of vertices of a loop that is triangulated at once
constexpr double kFillDensity = 1.5;       // of the finer filling, in triangles along the edges of its border
constexpr int kMaxWidened = 20;            // rounds of widening holes whose filling crosses something

/// Every border loop except the outer one.
std::vector<Loop> loopsToFill(const TriangleMesh& mesh) {
  const Loop outer = findOuterLoop(mesh);
  std::vector<Loop> loops = findHoleLoops(mesh);
  std::erase(loops, outer);
  return loops;
}

/// One attempt at filling all loops of a scan.
class Filling {
 public:
  explicit Filling(ScanSurface& s)
      : s_(s), mesh_(s.mesh), scanned_(s.mesh.triangles.size()), faces_(s.mesh), search_(s.mesh.positions, meanEdge(s)) {}

  /// Returns the triangles of the scan that have to be removed first, true for each; empty if everything is filled.
  /// `widen`: also removes rings around holes that cannot be filled. `is_last`: fills all holes, even with crossings.
  std::vector<char> run(const std::vector<Loop>& loops, bool widen, bool is_last) {
    findNear(loops);
    for (const Loop& loop : loops) fill(loop, widen, is_last);
    if (!is_any_dropped_) return {};
    for (std::size_t t = 0; t < scanned_; ++t)
      for (const std::uint32_t v : mesh_.triangles[t]) is_dropped_[t] |= is_bad_[v];
    return std::move(is_dropped_);
  }

 private:
  void findNear(const std::vector<Loop>& loops) {
    is_bad_.assign(mesh_.positions.size(), 0);
    is_dropped_.assign(scanned_, 0);
    // By place, not by connection: the neighbour of a tooth is as near as the tooth itself.
    std::vector<Eigen::AlignedBox3d> boxes;
    for (const Loop& loop : loops) {
      Eigen::AlignedBox3d box;
      for (const std::uint32_t v : loop) box.extend(mesh_.positions[v]);
      const Vector3d beside = Vector3d::Constant(search_.cell() + box.diagonal().norm() / 2);
      boxes.emplace_back(box.min() - beside, box.max() + beside);
    }
    // By their begin along x, with the farthest end of each box and those before it: a scan may have many holes.
    std::sort(boxes.begin(), boxes.end(), [](const auto& a, const auto& b) { return a.min().x() < b.min().x(); });
    std::vector<double> farthest;
    for (const auto& box : boxes) farthest.push_back(std::max(farthest.empty() ? box.max().x() : farthest.back(), box.max().x()));
    for (std::uint32_t t = 0; t < scanned_; ++t) {
      Eigen::AlignedBox3d box;
      for (const std::uint32_t v : mesh_.triangles[t]) box.extend(mesh_.positions[v]);
      auto i = std::upper_bound(boxes.begin(), boxes.end(), box.max().x(), [](double x, const auto& b) { return x < b.min().x(); }) -
               boxes.begin();
      bool is_near = false;
      while (!is_near && i-- > 0 && farthest[static_cast<std::size_t>(i)] >= box.min().x())
        is_near = boxes[static_cast<std::size_t>(i)].intersects(box);
      if (!is_near) continue;
      scan_triangle_.push_back(t);
      search_.add(mesh_.triangles[t]);
    }
  }

  void fill(const Loop& loop, bool widen, bool is_last) {
    const std::size_t points = mesh_.positions.size();
    std::vector<Triangle> first_filling;
    Pairs first_pairs;
    std::vector<char> first_bad;
    const bool is_spanned = loop.size() <= kMaxSpanned;
    for (int attempt = is_spanned ? 0 : 2; attempt < 3; ++attempt) {
      std::vector<Triangle> filling = attempt < 2 ? spanLoop(mesh_, loop) : fan(loop);
      if (attempt == 1 && !filling.empty()) bend(filling, loop);
      if (filling.empty()) continue;
      Pairs pairs = search_.against(filling);
      std::vector<char> is_bad = badTriangles(filling, loop);
      const bool is_good = pairs.empty() && std::count(is_bad.begin(), is_bad.end(), 1) == 0;
      if (is_good || (is_last && attempt == 2)) return accept(filling, loop);
      mesh_.positions.resize(points);
      if (first_filling.empty()) first_filling = std::move(filling), first_pairs = std::move(pairs), first_bad = std::move(is_bad);
    }
    noteBad(first_filling, first_pairs, first_bad, widen);
    is_any_dropped_ = true;
  }

  /// Refines a filling, and moves it to the outer side of the scan where it crosses it.
  void bend(std::vector<Triangle>& filling, const Loop& loop) {
    MovableSheet sheet{.first_new = mesh_.positions.size()};
    for (std::size_t k = 0; k < loop.size(); ++k)
      sheet.edge += (mesh_.positions[loop[k]] - mesh_.positions[loop[(k + 1) % loop.size()]]).norm() / static_cast<double>(loop.size());
    refineSpan(mesh_, filling, kFillDensity);
    sheet.triangles = std::move(filling);
    sheet.group.assign(sheet.triangles.size(), 0);
    const std::map<std::uint32_t, std::uint32_t> next = nextOf(loop);
    splitEdges(mesh_.positions, sheet,
               [&](std::uint32_t a, std::uint32_t b) { return isOfScan(a, b) && !isOf(next, a, b) && !isOf(next, b, a); });
    moveApart(mesh_.positions, sheet, search_, [this](std::uint32_t triangle) {
      const Triangle& t = search_.triangles()[triangle];
      return Vector3d((mesh_.positions[t[2]] - mesh_.positions[t[0]]).cross(mesh_.positions[t[1]] - mesh_.positions[t[0]]).normalized());
    });
    filling = std::move(sheet.triangles);
  }

  /// Marks triangles to remove where a filling fails: the triangles that it crosses; and the ring around the corners of
  /// its own triangles that are bad, cross each other or, with `widen`, cross anything.
  void noteBad(const std::vector<Triangle>& filling, const Pairs& pairs, std::vector<char>& is_bad, bool widen) {
    const auto old_count = static_cast<std::uint32_t>(scan_triangle_.size());
    for (const auto& [first, second] : pairs) {
      const bool is_scan = first < old_count && scan_triangle_[first] != kNone;
      if (is_scan) is_dropped_[scan_triangle_[first]] = 1;
      if (widen || !is_scan) is_bad[second - old_count] = 1;
      if (first >= old_count) is_bad[first - old_count] = 1;
    }
    for (std::size_t i = 0; i < filling.size(); ++i)
      for (const std::uint32_t v : filling[i])
        if (is_bad[i] && v < is_bad_.size()) is_bad_[v] = 1;
  }

  std::vector<Triangle> fan(const Loop& loop) {
    std::vector<Triangle> filling;
    const auto hub = static_cast<std::uint32_t>(mesh_.positions.size());
    Vector3d middle = Vector3d::Zero();
    for (const std::uint32_t v : loop) middle += mesh_.positions[v] / static_cast<double>(loop.size());
    mesh_.positions.push_back(middle);
    for (std::size_t k = 0; k < loop.size(); ++k) filling.push_back({loop[k], loop[(k + 1) % loop.size()], hub});
    return filling;
  }

  static std::map<std::uint32_t, std::uint32_t> nextOf(const Loop& loop) {
    std::map<std::uint32_t, std::uint32_t> next;
    for (std::size_t k = 0; k < loop.size(); ++k) next[loop[k]] = loop[(k + 1) % loop.size()];
    return next;
  }
  static bool isOf(const std::map<std::uint32_t, std::uint32_t>& next, std::uint32_t a, std::uint32_t b) {
    const auto at = next.find(a);
    return at != next.end() && at->second == b;
  }
  bool isOfScan(std::uint32_t a, std::uint32_t b) const {
    return std::max(a, b) < is_bad_.size() && (faces_.face(a, b) != kNone || faces_.face(b, a) != kNone);
  }

  /// True for triangles that are flat, or that share an edge with the scan that is not part of the loop.
  std::vector<char> badTriangles(const std::vector<Triangle>& filling, const Loop& loop) const {
    const std::map<std::uint32_t, std::uint32_t> next = nextOf(loop);
    std::vector<char> is_bad(filling.size(), 0);
    for (std::size_t i = 0; i < filling.size(); ++i) {
      const Triangle& t = filling[i];
      is_bad[i] = isFlat(mesh_.positions, t);
      for (std::size_t k = 0; k < 3; ++k)
        if (isOfScan(t[k], t[(k + 1) % 3]) && !isOf(next, t[k], t[(k + 1) % 3])) is_bad[i] = 1;
    }
    return is_bad;
  }

  void accept(const std::vector<Triangle>& filling, const Loop& loop) {
    for (std::size_t v = s_.vertex_region.size(); v < mesh_.positions.size(); ++v) {  // a new vertex gets the region of the nearest old one
      std::uint32_t nearest = loop[0];
      for (const std::uint32_t u : loop)
        if ((mesh_.positions[u] - mesh_.positions[v]).squaredNorm() < (mesh_.positions[nearest] - mesh_.positions[v]).squaredNorm())
          nearest = u;
      s_.vertex_region.push_back(s_.vertex_region[nearest]);
    }
    for (const Triangle& t : filling) {
      search_.add(t);
      scan_triangle_.push_back(kNone);
      mesh_.triangles.push_back(t);
      s_.is_invented.push_back(1);
    }
  }

  ScanSurface& s_;
  TriangleMesh& mesh_;
  std::size_t scanned_;
  EdgeFaces faces_;  // of the scan
  CrossingSearch search_;
  std::vector<std::uint32_t> scan_triangle_;  // of each triangle in the search; kNone: it belongs to a filling
  std::vector<char> is_bad_, is_dropped_;
  bool is_any_dropped_ = false;
};

}  // namespace

std::size_t dropCrossings(ScanSurface& s) {
  const auto pairs = findCrossingTriangles(s.mesh, kMaxCrossingPairs).pairs;
  std::map<std::uint32_t, std::vector<std::uint32_t>> crossed;
  for (const auto& [a, b] : pairs) crossed[a].push_back(b), crossed[b].push_back(a);
  using Entry = std::tuple<std::size_t, double, std::uint32_t>;  // number of pairs, - area, triangle
  std::map<std::uint32_t, std::size_t> count;
  std::priority_queue<Entry> queue;
  for (const auto& [t, others] : crossed) {
    count[t] = others.size();
    queue.emplace(others.size(), -triangleArea(s.mesh, t), t);
  }
  std::vector<char> is_dropped(s.mesh.triangles.size(), 0);
  std::size_t dropped = 0;
  while (!queue.empty()) {
    const auto [pairs_left, area, t] = queue.top();
    queue.pop();
    if (is_dropped[t] || pairs_left != count[t] || pairs_left == 0) continue;
    is_dropped[t] = 1;
    ++dropped;
    for (const std::uint32_t u : crossed[t])
      if (!is_dropped[u] && --count[u] > 0) queue.emplace(count[u], -triangleArea(s.mesh, u), u);
  }
  if (dropped > 0) dropTriangles(s, is_dropped);
  return dropped;
}

std::size_t fillScanHoles(ScanSurface& s) {
  for (int round = 0;; ++round) {
    const std::size_t scanned = s.mesh.triangles.size(), points = s.mesh.positions.size();
    const std::vector<Loop> loops = loopsToFill(s.mesh);
    const std::vector<char> is_dropped = Filling(s).run(loops, round > 0, round == kMaxWidened);
    if (is_dropped.empty()) return loops.size();
    s.mesh.positions.resize(points);
    s.vertex_region.resize(points);
    s.mesh.triangles.resize(scanned);
    dropTriangles(s, is_dropped);
  }
}

}  // namespace spheretree::builder
