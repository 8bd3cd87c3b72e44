// SPDX-License-Identifier: GPL-3.0-or-later
#include "split/part_solids.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <tuple>

#include "repair/fill_holes.h"
#include "spheretree/core/mesh_edit.h"
#include "split/crossing_search.h"
#include "split/move_apart.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

using Line = std::vector<std::uint32_t>;  // vertices

constexpr double kStep = 0.5;      // length of the first straight part of a wall, in mean border edges
constexpr int kWayRounds = 4;      // rounds of smoothing the directions of these parts
constexpr double kMinShare = 0.5;  // smallest remaining share of the slope of the bisecting direction after smoothing
constexpr int kMaxHalvings = 40;   // halvings of a length where it crosses something
constexpr double kFlatArc = 2;     // mean edges by which an arc must rise above the line between its ends to get a window
constexpr std::array<double, 6> kCollars{0.0, 0.03, 0.06, 0.12, 0.25, 0.5};  // depths of collars to try, as shares of the radius of the rim
constexpr double kCell = 3;                                                  // side of a cube of the search, in mean edges of the scan
constexpr double kWallDensity = 0.5;                                // of a wall that is moved, in triangles along the edges of its border
constexpr std::array<double, 5> kRoots{1.0, 0.75, 0.5, 0.25, 0.0};  // lengths of stubs to try, as shares; 0: a cap
constexpr double kStubTaper = 0.4;  // width of the end of a stub, as a share of its beginning: about that of a root's tip

/// A border edge of a region, in the direction of its triangles, and the region on the other side.
struct BorderEdge {
  std::uint32_t from, to;
  std::int32_t other;
};

class WallFinder {
 public:
  WallFinder(ScanSurface& surface, const WallSettings& settings)
      : s_(surface), mesh_(surface.mesh), settings_(settings), faces_(surface.mesh), borders_at_(surface.mesh.positions.size(), 0) {}

  PartSolids run() {
    findNormals();
    findSearch();
    findBorders();
    leaveSurface();
    out_.rim_length.assign(s_.region_label.size(), 0);
    for (std::int32_t region = 1; region < static_cast<std::int32_t>(edges_of_.size()); ++region) {
      const auto loops = loopsOf(region);
      std::size_t longest = 0;
      for (const auto& loop : loops) longest = std::max(longest, loop.size());
      for (const auto& loop : loops) {
        close(region, loop, loop.size() == longest);
        if (loop.size() == longest) longest = 0;  // one root only
      }
    }
    std::vector<std::uint32_t>& crossed = out_.crossed;
    std::sort(crossed.begin(), crossed.end());
    crossed.erase(std::unique(crossed.begin(), crossed.end()), crossed.end());
    return std::move(out_);
  }

 private:
  void findNormals() {
    normal_.assign(mesh_.positions.size(), Vector3d::Zero());
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
      const Vector3d n = (mesh_.corner(t, 1) - mesh_.corner(t, 0)).cross(mesh_.corner(t, 2) - mesh_.corner(t, 0));
      for (const std::uint32_t v : mesh_.triangles[t]) normal_[v] += n;
    }
    for (Vector3d& n : normal_) n = n.norm() > 0 ? Vector3d(n.normalized()) : settings_.up;
  }

  void findSearch() {
    search_ = std::make_unique<CrossingSearch>(mesh_.positions, kCell * meanEdge(s_));
    for (const Triangle& t : mesh_.triangles) search_->add(t);
    wall_of_.assign(mesh_.triangles.size(), -1);
  }

  /// Adds the walls to the search that are not yet in it.
  void addWallsToSearch() {
    for (; walls_in_search_ < out_.walls.size(); ++walls_in_search_)
      for (const Triangle& t : out_.walls[walls_in_search_].triangles) {
        search_->add(t);
        wall_of_.push_back(static_cast<std::int32_t>(walls_in_search_));
      }
  }

  std::vector<Triangle> trianglesFrom(std::size_t first) const {
    std::vector<Triangle> triangles;
    for (std::size_t w = first; w < out_.walls.size(); ++w)
      triangles.insert(triangles.end(), out_.walls[w].triangles.begin(), out_.walls[w].triangles.end());
    return triangles;
  }

  /// Calls `add(i)`, which adds walls and vertices, for i = 0, 1, ... until nothing crosses. If all attempts have
  /// crossings, refines and moves their walls, in the order of increasing crossings, until one has none; otherwise
  /// keeps the best. Returns the number of remaining crossings.
  template <class Add>
  std::size_t addBest(std::int32_t region, std::size_t count, double edge, Add&& add) {
    addWallsToSearch();
    const std::size_t points = mesh_.positions.size(), walls = out_.walls.size();
    const auto undo = [&] {
      mesh_.positions.resize(points);
      out_.walls.resize(walls);
    };
    std::vector<std::pair<std::size_t, std::size_t>> order;  // crossings, attempt
    for (std::size_t i = 0; i < count; ++i) {
      add(i);
      const std::size_t crossings = search_->against(trianglesFrom(walls)).size();
      if (crossings == 0) return 0;
      order.emplace_back(crossings, i);
      undo();
    }
    std::sort(order.begin(), order.end());
    std::size_t fewest_crossings = std::numeric_limits<std::size_t>::max();
    std::vector<Vector3d> best_positions;
    std::vector<InnerWall> best_walls;
    for (const auto& [crossings, attempt] : order) {
      add(attempt);
      for (std::size_t w = walls; w < out_.walls.size(); ++w) refineSpan(mesh_, out_.walls[w].triangles, kWallDensity);
      const std::size_t left = moveWallsApart(region, walls, points, edge);
      if (left == 0) return 0;
      if (left < fewest_crossings) {
        fewest_crossings = left;
        best_positions.assign(mesh_.positions.begin() + static_cast<std::ptrdiff_t>(points), mesh_.positions.end());
        best_walls.assign(out_.walls.begin() + static_cast<std::ptrdiff_t>(walls), out_.walls.end());
      }
      undo();
    }
    mesh_.positions.insert(mesh_.positions.end(), best_positions.begin(), best_positions.end());
    out_.walls.insert(out_.walls.end(), best_walls.begin(), best_walls.end());
    for (const auto& [first, second] : search_->against(trianglesFrom(walls)))
      if (first < wall_of_.size() && wall_of_[first] < 0) out_.crossed.push_back(first);
    return fewest_crossings;
  }

  /// Moves the vertices from `points` on until the walls from `first` on cross nothing. Returns the number of remaining
  /// pairs.
  std::size_t moveWallsApart(std::int32_t region, std::size_t first, std::size_t points, double edge) {
    MovableSheet sheet{.first_new = points, .edge = edge};
    for (std::size_t w = first; w < out_.walls.size(); ++w)
      for (const Triangle& t : out_.walls[w].triangles) {
        sheet.triangles.push_back(t);
        sheet.group.push_back(static_cast<std::uint32_t>(w));
      }
    const std::size_t left =
        moveApart(mesh_.positions, sheet, *search_, [this, region](std::uint32_t triangle) { return outOf(region, triangle); });
    for (std::size_t w = first; w < out_.walls.size(); ++w) out_.walls[w].triangles.clear();
    for (std::size_t i = 0; i < sheet.triangles.size(); ++i) out_.walls[sheet.group[i]].triangles.push_back(sheet.triangles[i]);
    return left;
  }

  /// Unit normal of a triangle in the search, pointing away from the side where walls of `region` may be.
  Vector3d outOf(std::int32_t region, std::uint32_t triangle) const {
    const Triangle& t = search_->triangles()[triangle];
    const Vector3d n = (mesh_.positions[t[1]] - mesh_.positions[t[0]]).cross(mesh_.positions[t[2]] - mesh_.positions[t[0]]).normalized();
    const std::int32_t wall = wall_of_[triangle];
    if (wall < 0) return n;
    const InnerWall& of = out_.walls[static_cast<std::size_t>(wall)];
    return of.above == region ? n : Vector3d(-n);
  }

  void findBorders() {
    edges_of_.resize(s_.region_label.size());
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t)
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t a = mesh_.triangles[t][k], b = mesh_.triangles[t][(k + 1) % 3], other = faces_.face(b, a);
        const std::int32_t beyond = other == EdgeFaces::kNone ? kGumRegion : s_.region[other];
        if (beyond == s_.region[t]) continue;
        edges_of_[static_cast<std::size_t>(s_.region[t])].push_back({a, b, beyond});
        ++borders_at_[a];
      }
  }

  /// Makes strips of wall from the borders of all regions into the solid. A border vertex lies within an edge or a
  /// triangle of the scan, so at most two planes meet there, and the bisector of the angle between them points inside;
  /// sufficiently short strips along these directions cross nothing. The walls that close the regions start at the
  /// inner ends.
  void leaveSurface() {
    std::vector<std::pair<std::uint32_t, double>> steps;  // border vertex, distance inside
    std::vector<std::uint32_t> step_of(mesh_.positions.size(), EdgeFaces::kNone);
    std::vector<Vector3d> way;
    findWays(steps, step_of, way);
    const auto first = static_cast<std::uint32_t>(mesh_.positions.size());
    for (std::size_t i = 0; i < steps.size(); ++i) mesh_.positions.push_back(mesh_.positions[steps[i].first] + steps[i].second * way[i]);
    for (std::uint32_t v = 0; v < first; ++v) inner_of_.push_back(step_of[v] == EdgeFaces::kNone ? v : first + step_of[v]);
    for (const auto& [v, length] : steps) normal_.push_back(normal_[v]);
    for (std::int32_t region = 1; region < static_cast<std::int32_t>(edges_of_.size()); ++region) {
      std::map<std::int32_t, std::vector<Triangle>> strip_to;
      for (const BorderEdge& e : edges_of_[static_cast<std::size_t>(region)]) {
        if (e.other > region) continue;  // the other region makes this strip
        const std::uint32_t from = inner_of_[e.from], to = inner_of_[e.to];
        strip_to[e.other].push_back({e.to, e.from, from});
        strip_to[e.other].push_back({e.to, from, to});
      }
      for (auto& [other, strip] : strip_to) out_.walls.push_back({region, other, std::move(strip)});
    }
    const std::vector<Triangle> strips = trianglesFrom(0);
    const auto old_count = static_cast<std::uint32_t>(search_->triangles().size());
    for (int round = 0; round < kMaxHalvings; ++round) {
      const auto pairs = search_->against(strips);
      if (pairs.empty()) return;
      std::vector<char> is_long(steps.size(), 0);
      for (const auto& [a, b] : pairs)
        for (const std::uint32_t t : {a, b})
          if (t >= old_count)
            for (const std::uint32_t v : strips[t - old_count])
              if (v >= first) is_long[v - first] = 1;
      for (std::size_t i = 0; i < steps.size(); ++i)
        if (is_long[i]) {
          steps[i].second /= 2;
          mesh_.positions[first + i] = mesh_.positions[steps[i].first] + steps[i].second * way[i];
        }
    }
  }

  void findWays(std::vector<std::pair<std::uint32_t, double>>& steps, std::vector<std::uint32_t>& step_of,
                std::vector<Vector3d>& way) const {
    std::vector<std::array<std::uint32_t, 2>> borders;  // both ends as indices in `steps`
    const auto placeOf = [&](std::uint32_t v) {
      if (step_of[v] == EdgeFaces::kNone) {
        step_of[v] = static_cast<std::uint32_t>(steps.size());
        steps.emplace_back(v, 0);
      }
      return step_of[v];
    };
    double length = 0;
    for (std::size_t region = 1; region < edges_of_.size(); ++region)
      for (const BorderEdge& e : edges_of_[region]) {
        borders.push_back({placeOf(e.from), placeOf(e.to)});
        length += (mesh_.positions[e.to] - mesh_.positions[e.from]).norm();
      }
    for (auto& [v, step] : steps) step = kStep * length / static_cast<double>(borders.size());
    // Normals of the planes at each border vertex: the first one, and the one that differs most from it.
    std::vector<std::array<Vector3d, 2>> planes(steps.size(), {Vector3d::Zero(), Vector3d::Zero()});
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t)
      for (int k = 0; k < 3; ++k) {
        const std::uint32_t i = step_of[mesh_.triangles[t][static_cast<std::size_t>(k)]];
        if (i == EdgeFaces::kNone) continue;
        const Vector3d a = mesh_.corner(t, (k + 1) % 3) - mesh_.corner(t, k), b = mesh_.corner(t, (k + 2) % 3) - mesh_.corner(t, k);
        const Vector3d normal = a.cross(b).normalized();
        if (!normal.allFinite()) continue;
        if (planes[i][0].isZero()) planes[i] = {normal, normal};
        if (normal.dot(planes[i][0]) < planes[i][1].dot(planes[i][0])) planes[i][1] = normal;
      }
    for (const auto& [first, second] : planes) {
      const Vector3d sum = first + second;
      way.push_back(sum.norm() > 0 ? Vector3d(-sum.normalized()) : -settings_.up);
    }
    const std::vector<Vector3d> straight = way;
    for (int round = 0; round < kWayRounds; ++round) {
      std::vector<Vector3d> sum = way;
      for (const auto& [a, b] : borders) sum[a] += way[b], sum[b] += way[a];
      for (std::size_t i = 0; i < way.size(); ++i) {
        const double smallest = kMinShare * straight[i].dot(planes[i][0]);
        for (const double share : {0.0, 0.25, 0.5, 0.75, 1.0}) {
          way[i] = ((1 - share) * sum[i].normalized() + share * straight[i]).normalized();
          if (way[i].dot(planes[i][0]) <= smallest && way[i].dot(planes[i][1]) <= smallest) break;
        }
      }
    }
  }

  /// The next border edge of the region, going around the end of `edge` through its triangles.
  std::pair<std::uint32_t, std::int32_t> next(std::int32_t region, const BorderEdge& edge) const {
    std::uint32_t face = faces_.face(edge.from, edge.to);
    for (;;) {
      const Triangle& t = mesh_.triangles[face];
      const std::size_t k = static_cast<std::size_t>(std::find(t.begin(), t.end(), edge.to) - t.begin());
      const std::uint32_t to = t[(k + 1) % 3], beyond = faces_.face(to, edge.to);
      if (beyond == EdgeFaces::kNone) return {to, kGumRegion};
      if (s_.region[beyond] != region) return {to, s_.region[beyond]};
      face = beyond;
    }
  }

  std::vector<std::vector<BorderEdge>> loopsOf(std::int32_t region) const {
    const std::vector<BorderEdge>& edges = edges_of_[static_cast<std::size_t>(region)];
    std::map<std::pair<std::uint32_t, std::uint32_t>, char> is_used;
    for (const BorderEdge& e : edges) is_used[{e.from, e.to}] = 0;
    std::vector<std::vector<BorderEdge>> loops;
    for (const BorderEdge& start : edges) {
      if (is_used[{start.from, start.to}]) continue;
      std::vector<BorderEdge> loop;
      BorderEdge at = start;
      while (!is_used[{at.from, at.to}]) {
        is_used[{at.from, at.to}] = 1;
        loop.push_back(at);
        const auto [to, other] = next(region, at);
        at = {at.to, to, other};
      }
      loops.push_back(std::move(loop));
    }
    return loops;
  }

  /// End of an arc: the neighbour changes, or more than two borders meet.
  bool isNode(const BorderEdge& before, const BorderEdge& after) const {
    return before.other != after.other || borders_at_[after.from] != 2;
  }

  /// `has_root`: with a stub, if roots are asked for.
  void close(std::int32_t region, std::vector<BorderEdge> loop, bool has_root) {
    for (const BorderEdge& e : loop)
      out_.rim_length[static_cast<std::size_t>(region)] += (mesh_.positions[e.to] - mesh_.positions[e.from]).norm();
    const std::size_t n = loop.size();
    std::size_t start = 0;
    while (start < n && !isNode(loop[(start + n - 1) % n], loop[start])) ++start;
    std::vector<char> is_node(n, 0);
    for (std::size_t i = 0; i < n; ++i) is_node[i] = isNode(loop[(i + n - 1) % n], loop[i]);
    for (BorderEdge& e : loop) e.from = inner_of_[e.from], e.to = inner_of_[e.to];
    if (start == n && loop[0].other != kGumRegion) {  // one neighbour all around: their common window closes the region
      if (loop[0].other > region) addCap(region, loop[0].other, reversed(verticesOf(loop)), std::vector<char>(n, 0), 0);
      return;
    }
    std::rotate(loop.begin(), loop.begin() + static_cast<std::ptrdiff_t>(start % n), loop.end());
    std::rotate(is_node.begin(), is_node.begin() + static_cast<std::ptrdiff_t>(start % n), is_node.end());
    Line rim;
    std::vector<char> is_shared;  // of the rim: on a line between two teeth, or at its end
    for (std::size_t i = 0; i < n;) {
      Line arc{loop[i].from, loop[i].to};
      const std::int32_t other = loop[i].other;
      for (++i; i < n && !is_node[i]; ++i) arc.push_back(loop[i].to);
      const Line line = other == kGumRegion ? arc : lineUnder(region, other, arc);
      rim.insert(rim.end(), line.begin(), line.end() - 1);
      is_shared.resize(rim.size(), other != kGumRegion);
    }
    for (std::size_t i = rim.size(); i-- > 0;)  // the last vertex of a line is the first one of the next part
      if (is_shared[i] && !is_shared[(i + 1) % rim.size()]) is_shared[(i + 1) % rim.size()] = 1;
    std::reverse(rim.begin(), rim.end());
    std::reverse(is_shared.begin(), is_shared.end());
    addCap(region, kGumRegion, rim, is_shared, has_root ? settings_.root_mm : 0);
  }

  static Line verticesOf(const std::vector<BorderEdge>& loop) {
    Line line;
    for (const BorderEdge& e : loop) line.push_back(e.from);
    return line;
  }
  static Line reversed(Line line) {
    std::reverse(line.begin(), line.end());
    return line;
  }

  double height(std::uint32_t v) const { return mesh_.positions[v].dot(settings_.up); }

  /// The part of the cap's rim that replaces `arc`: the arc itself, or the line below its window, from the arc's first
  /// vertex to its last. The region with the lower number makes it; the other one reuses it.
  Line lineUnder(std::int32_t region, std::int32_t other, const Line& arc) {
    const auto known = line_of_.find({arc[1], arc[0]});
    if (known != line_of_.end() && known->second.front() == arc.back() && known->second.back() == arc.front())
      return reversed(known->second);
    Line line = arc;
    double length = 0, rise = 0;
    for (std::size_t i = 1; i < arc.size(); ++i) length += (mesh_.positions[arc[i]] - mesh_.positions[arc[i - 1]]).norm();
    const double edge = length / static_cast<double>(arc.size() - 1);
    const Vector3d first = mesh_.positions[arc.front()], way = mesh_.positions[arc.back()] - first;
    const auto share = [&](std::uint32_t v) {
      return std::clamp((mesh_.positions[v] - first).dot(way) / std::max(way.squaredNorm(), 1e-12), 0.0, 1.0);
    };
    for (const std::uint32_t v : arc) rise = std::max(rise, (mesh_.positions[v] - first - share(v) * way).dot(settings_.up));
    if (rise > kFlatArc * edge && arc.front() != arc.back()) {
      const auto pieces = static_cast<std::size_t>(std::ceil(way.norm() / edge));
      addBest(region, kCollars.size(), edge, [&](std::size_t attempt) {
        const double depth = kCollars[attempt] * way.norm() / 2;
        line = {arc.front()};
        for (std::size_t i = 1; i < pieces; ++i) {
          const double at = static_cast<double>(i) / static_cast<double>(pieces);
          Vector3d p = first + at * way - 4 * at * (1 - at) * depth * settings_.up;
          for (const std::uint32_t v : arc)  // never above the arc
            if (std::abs(share(v) - at) * static_cast<double>(pieces) < 1)
              p += std::min(0.0, height(v) - edge - p.dot(settings_.up)) * settings_.up;
          line.push_back(static_cast<std::uint32_t>(mesh_.positions.size()));
          mesh_.positions.push_back(p);
        }
        line.push_back(arc.back());
        Line loop = reversed(arc);
        std::vector<char> is_still(loop.size(), 0);
        is_still.front() = is_still.back() = 1;
        loop.insert(loop.end(), line.begin() + 1, line.end() - 1);
        is_still.resize(loop.size(), 1);
        addCollared(region, other, loop, is_still, depth / 2, edge, 0);
      });
    }
    for (std::size_t i = 1; i < arc.size(); ++i) line_of_[{arc[i - 1], arc[i]}] = line;
    return line;
  }

  /// Triangulates `loop`, which has the direction of the triangles of the wall of `above`.
  void addWall(std::int32_t above, std::int32_t below, const Line& loop) {
    if (loop.size() < 3) {
      out_.walls.push_back({above, below, {}});
      return;
    }
    std::vector<Triangle> triangles = spanLoop(mesh_, loop);
    if (triangles.empty()) {
      Vector3d middle = Vector3d::Zero();
      for (const std::uint32_t v : loop) middle += mesh_.positions[v] / static_cast<double>(loop.size());
      const auto hub = static_cast<std::uint32_t>(mesh_.positions.size());
      mesh_.positions.push_back(middle);
      for (std::size_t i = 0; i < loop.size(); ++i) triangles.push_back({loop[i], loop[(i + 1) % loop.size()], hub});
    }
    out_.walls.push_back({above, below, std::move(triangles)});
  }

  /// Where the rim runs beside the bottom of a groove, such as the sulcus, a cap that spans the rim lies above the scan
  /// and crosses the crown. Therefore a collar first leads down from the rim, only as deep as necessary. With roots, a
  /// stub follows on the collar instead of a cap, shorter if necessary.
  void addCap(std::int32_t region, std::int32_t below, const Line& rim, const std::vector<char>& is_shared, double wanted_root) {
    double length = 0;
    for (std::size_t i = 0; i < rim.size(); ++i) length += (mesh_.positions[rim[(i + 1) % rim.size()]] - mesh_.positions[rim[i]]).norm();
    const double radius = length / (2 * M_PI), edge = length / static_cast<double>(rim.size());
    const std::size_t points = mesh_.positions.size(), walls = out_.walls.size(), crossed = out_.crossed.size();
    for (const double share : kRoots) {
      const double root = share * wanted_root;
      const std::size_t left = addBest(region, kCollars.size(), edge, [&](std::size_t attempt) {
        addCollared(region, below, rim, is_shared, kCollars[attempt] * radius, edge, root);
      });
      if (left > 0 && root > 0) {
        mesh_.positions.resize(points);
        out_.walls.resize(walls);
        out_.crossed.resize(crossed);
        continue;
      }
      if (root < wanted_root) out_.short_roots.push_back(root);
      return;
    }
  }

  /// Inner end of a collar: the rim, smoothed over a length of about `depth`, moved into the solid.
  std::vector<Vector3d> innerRing(const Line& rim, const std::vector<char>& is_shared, double depth, double edge) const {
    const std::size_t n = rim.size();
    std::vector<Vector3d> ring(n), move(n, -settings_.up);
    for (std::size_t i = 0; i < n; ++i) ring[i] = mesh_.positions[rim[i]];
    for (std::size_t i = 0; i < n; ++i)
      if (rim[i] < normal_.size()) move[i] = -normal_[rim[i]];
    const auto rounds = static_cast<std::size_t>(std::min(1000.0, std::pow(depth / edge, 2))) + 1;
    for (std::vector<Vector3d>* values : {&ring, &move})
      for (std::size_t round = 0; round < rounds; ++round) {
        const std::vector<Vector3d> before = *values;
        for (std::size_t i = 0; i < n; ++i)
          if (!is_shared[i]) (*values)[i] = (before[(i + n - 1) % n] + 2 * before[i] + before[(i + 1) % n]) / 4;
      }
    for (std::size_t i = 0; i < n; ++i)
      if (!is_shared[i]) ring[i] += depth * move[i].normalized();
    return ring;
  }

  /// A collar of `depth` downward from the loop, except where it is marked in `is_still`, and a wall that spans the
  /// rest, or a stub of the length `root`.
  void addCollared(std::int32_t above, std::int32_t below, const Line& loop, const std::vector<char>& is_still, double depth, double edge,
                   double root) {
    if (!(depth > 0)) return addEnd(above, below, loop, root);
    const std::vector<Vector3d> ring = innerRing(loop, is_still, depth, edge);
    Line inner;
    for (std::size_t i = 0; i < loop.size(); ++i) {
      inner.push_back(is_still[i] ? loop[i] : static_cast<std::uint32_t>(mesh_.positions.size()));
      if (!is_still[i]) mesh_.positions.push_back(ring[i]);
    }
    std::vector<Triangle> collar;
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const std::size_t j = (i + 1) % loop.size();
      if (inner[j] != loop[j]) collar.push_back({loop[i], loop[j], inner[j]});
      if (inner[i] != loop[i]) collar.push_back({loop[i], inner[j], inner[i]});
    }
    out_.walls.push_back({above, below, std::move(collar)});
    addEnd(above, below, inner, root);
  }

  void addEnd(std::int32_t above, std::int32_t below, const Line& loop, double root) {
    if (root > 0)
      addStub(above, loop, root);
    else
      addWall(above, below, loop);
  }

  void addStub(std::int32_t region, const Line& rim, double root) {
    Vector3d middle = Vector3d::Zero();
    for (const std::uint32_t v : rim) middle += mesh_.positions[v] / static_cast<double>(rim.size());
    const Vector3d end = middle - root * settings_.up;
    const auto first = static_cast<std::uint32_t>(mesh_.positions.size()), n = static_cast<std::uint32_t>(rim.size());
    for (const std::uint32_t v : rim) {
      const Vector3d arm = mesh_.positions[v] - middle;
      mesh_.positions.push_back(end + kStubTaper * (arm - arm.dot(settings_.up) * settings_.up));
    }
    mesh_.positions.push_back(end);
    std::vector<Triangle> triangles;
    for (std::uint32_t i = 0; i < n; ++i) {
      const std::uint32_t j = (i + 1) % n;
      triangles.push_back({rim[i], rim[j], first + j});
      triangles.push_back({rim[i], first + j, first + i});
      triangles.push_back({first + i, first + j, first + n});
    }
    out_.walls.push_back({region, kGumRegion, std::move(triangles)});
  }

  ScanSurface& s_;
  TriangleMesh& mesh_;
  const WallSettings& settings_;
  EdgeFaces faces_;
  std::vector<Vector3d> normal_;            // of the vertices of the surface, then of the inner ends of the strips
  std::vector<std::uint32_t> inner_of_;     // of each vertex of the surface: the inner end of its strip, or itself
  std::unique_ptr<CrossingSearch> search_;  // contains the surface, then the final walls
  std::vector<std::int32_t> wall_of_;       // of each triangle in search_; -1: of the surface
  std::size_t walls_in_search_ = 0;
  std::vector<std::uint32_t> borders_at_;  // of each vertex: number of border edges that begin there
  std::vector<std::vector<BorderEdge>> edges_of_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, Line> line_of_;  // of each edge of an arc, in the direction of the first region
  PartSolids out_;
};

}  // namespace

PartSolids findWalls(ScanSurface& surface, const WallSettings& settings) { return WallFinder(surface, settings).run(); }

TriangleMesh solidOf(const ScanSurface& surface, const PartSolids& solids, std::int32_t region, std::vector<char>& is_invented) {
  TriangleMesh mesh;
  mesh.positions = surface.mesh.positions;
  is_invented.clear();
  for (std::size_t t = 0; t < surface.mesh.triangles.size(); ++t) {
    if (surface.region[t] != region) continue;
    mesh.triangles.push_back(surface.mesh.triangles[t]);
    is_invented.push_back(surface.is_invented[t]);
  }
  for (const InnerWall& wall : solids.walls) {
    if (wall.above != region && wall.below != region) continue;
    for (Triangle t : wall.triangles) {
      if (wall.above != region) std::swap(t[1], t[2]);
      mesh.triangles.push_back(t);
      is_invented.push_back(1);
    }
  }
  dropUnusedVertices(mesh);
  return mesh;
}

}  // namespace spheretree::builder
