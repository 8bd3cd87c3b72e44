// SPDX-License-Identifier: GPL-3.0-or-later
#include "split/part_solids.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "spheretree/core/mesh_edit.h"
#include "split/inward_steps.h"
#include "split/region_borders.h"
#include "split/wall_shapes.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr double kFlatArc = 2;  // mean edges by which an arc must rise above the line between its ends to get a window

using Line = std::vector<std::uint32_t>;  // vertices

constexpr std::array<double, 6> kCollars{0.0, 0.03, 0.06, 0.12, 0.25, 0.5};  // depths of collars to try, as shares of the radius of the rim
constexpr std::array<double, 5> kRoots{1.0, 0.75, 0.5, 0.25, 0.0};           // lengths of stubs to try, as shares; 0: a cap

/// Normals of the vertices; `up` where they have none.
std::vector<Vector3d> vertexNormals(const TriangleMesh& mesh, const Vector3d& up) {
  std::vector<Vector3d> normals(mesh.positions.size(), Vector3d::Zero());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vector3d n = (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0));
    for (const std::uint32_t v : mesh.triangles[t]) normals[v] += n;
  }
  for (Vector3d& n : normals) n = n.norm() > 0 ? Vector3d(n.normalized()) : up;
  return normals;
}

Line reversed(Line line) {
  std::reverse(line.begin(), line.end());
  return line;
}

/// Closes the regions one after the other: strips along all borders, then windows and a cap for each loop.
class WallFinder {
 public:
  WallFinder(ScanSurface& surface, const WallSettings& settings)
      : mesh_(surface.mesh),
        settings_(settings),
        borders_(surface),
        normal_(vertexNormals(surface.mesh, settings.up)),
        walls_(surface),
        rim_length_(surface.region_label.size(), 0) {}

  PartSolids run() {
    leaveSurface();
    for (std::int32_t region = 1; region < borders_.regionCount(); ++region) {
      const auto loops = borders_.loopsOf(region);
      std::size_t longest = 0;
      for (const auto& loop : loops) longest = std::max(longest, loop.size());
      for (const auto& loop : loops) {
        close(region, loop, loop.size() == longest);
        if (loop.size() == longest) longest = 0;  // one root only
      }
    }
    std::vector<std::uint32_t> crossed = walls_.crossedTriangles();
    return {walls_.takeWalls(), std::move(rim_length_), std::move(short_roots_), std::move(crossed)};
  }

 private:
  /// Makes strips of wall from the borders of all regions into the solid, short enough to cross nothing. The walls that
  /// close the regions start at the inner ends.
  void leaveSurface() {
    std::vector<InwardStep> steps = findInwardSteps(mesh_, borders_, settings_.up);
    const auto first = static_cast<std::uint32_t>(mesh_.positions.size());
    for (std::uint32_t v = 0; v < first; ++v) inner_of_.push_back(v);
    for (std::size_t i = 0; i < steps.size(); ++i) {
      const InwardStep& step = steps[i];
      mesh_.positions.push_back(mesh_.positions[step.vertex] + step.length * step.direction);
      inner_of_[step.vertex] = first + static_cast<std::uint32_t>(i);
      normal_.push_back(normal_[step.vertex]);
    }
    for (std::int32_t region = 1; region < borders_.regionCount(); ++region) {
      std::map<std::int32_t, std::vector<Triangle>> strip_to;
      for (const BorderEdge& e : borders_.edgesOf(region)) {
        if (e.other > region) continue;  // the other region makes this strip
        const std::uint32_t from = inner_of_[e.from], to = inner_of_[e.to];
        strip_to[e.other].push_back({e.to, e.from, from});
        strip_to[e.other].push_back({e.to, from, to});
      }
      for (auto& [other, strip] : strip_to) walls_.add({region, other, std::move(strip)});
    }
    shortenStrips(steps, first);
  }

  /// Halves the steps whose strips cross something. Their inner ends are the vertices from `first` on.
  void shortenStrips(std::vector<InwardStep>& steps, std::uint32_t first) {
    const std::vector<Triangle> strips = walls_.trianglesFrom(0);
    const std::size_t old_count = mesh_.triangles.size();
    for (int round = 0; round < kMaxRounds; ++round) {
      const auto pairs = walls_.against(strips);
      if (pairs.empty()) return;
      std::vector<char> is_long(steps.size(), 0);
      for (const auto& [a, b] : pairs)
        for (const std::uint32_t t : {a, b})
          if (t >= old_count)
            for (const std::uint32_t v : strips[t - old_count])
              if (v >= first) is_long[v - first] = 1;
      for (std::size_t i = 0; i < steps.size(); ++i)
        if (is_long[i]) {
          steps[i].length /= 2;
          mesh_.positions[first + i] = mesh_.positions[steps[i].vertex] + steps[i].length * steps[i].direction;
        }
    }
  }

  /// `has_root`: with a stub, if roots are asked for.
  void close(std::int32_t region, std::vector<BorderEdge> loop, bool has_root) {
    for (const BorderEdge& e : loop)
      rim_length_[static_cast<std::size_t>(region)] += (mesh_.positions[e.to] - mesh_.positions[e.from]).norm();
    const std::size_t n = loop.size();
    std::size_t start = 0;
    while (start < n && !borders_.isNode(loop[(start + n - 1) % n], loop[start])) ++start;
    std::vector<char> is_node(n, 0);
    for (std::size_t i = 0; i < n; ++i) is_node[i] = borders_.isNode(loop[(i + n - 1) % n], loop[i]);
    for (BorderEdge& e : loop) e.from = inner_of_[e.from], e.to = inner_of_[e.to];
    if (start == n && loop[0].other != kGumRegion) {  // one neighbour all around: their common window closes the region
      if (loop[0].other > region) addCap(region, loop[0].other, {reversed(verticesOf(loop)), std::vector<char>(n, 0)}, 0);
      return;
    }
    std::rotate(loop.begin(), loop.begin() + static_cast<std::ptrdiff_t>(start % n), loop.end());
    std::rotate(is_node.begin(), is_node.begin() + static_cast<std::ptrdiff_t>(start % n), is_node.end());
    WallRim rim;  // still on a line between two teeth, and at its ends
    for (std::size_t i = 0; i < n;) {
      Line arc{loop[i].from, loop[i].to};
      const std::int32_t other = loop[i].other;
      for (++i; i < n && !is_node[i]; ++i) arc.push_back(loop[i].to);
      const Line line = other == kGumRegion ? arc : lineUnder(region, other, arc);
      rim.loop.insert(rim.loop.end(), line.begin(), line.end() - 1);
      rim.is_still.resize(rim.loop.size(), other != kGumRegion);
    }
    std::vector<char>& is_still = rim.is_still;
    for (std::size_t i = is_still.size(); i-- > 0;)  // the last vertex of a line is the first one of the next part
      if (is_still[i] && !is_still[(i + 1) % is_still.size()]) is_still[(i + 1) % is_still.size()] = 1;
    std::reverse(rim.loop.begin(), rim.loop.end());
    std::reverse(is_still.begin(), is_still.end());
    addCap(region, kGumRegion, rim, has_root ? settings_.root_mm : 0);
  }

  static Line verticesOf(const std::vector<BorderEdge>& loop) {
    Line line;
    for (const BorderEdge& e : loop) line.push_back(e.from);
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
      walls_.addBest(region, kCollars.size(), edge, [&](std::size_t attempt) {
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
        WallRim rim{reversed(arc), std::vector<char>(arc.size(), 0)};
        rim.is_still.front() = rim.is_still.back() = 1;
        rim.loop.insert(rim.loop.end(), line.begin() + 1, line.end() - 1);
        rim.is_still.resize(rim.loop.size(), 1);
        addCollared(region, other, rim, depth / 2, edge, 0);
      });
    }
    for (std::size_t i = 1; i < arc.size(); ++i) line_of_[{arc[i - 1], arc[i]}] = line;
    return line;
  }

  /// Where the rim runs beside the bottom of a groove, such as the sulcus, a cap that spans the rim lies above the scan
  /// and crosses the crown. Therefore a collar first leads down from the rim, only as deep as necessary. With roots, a
  /// stub follows on the collar instead of a cap, shorter if necessary.
  void addCap(std::int32_t region, std::int32_t below, const WallRim& rim, double wanted_root) {
    const Line& loop = rim.loop;
    double length = 0;
    for (std::size_t i = 0; i < loop.size(); ++i)
      length += (mesh_.positions[loop[(i + 1) % loop.size()]] - mesh_.positions[loop[i]]).norm();
    const double radius = length / (2 * M_PI), edge = length / static_cast<double>(loop.size());
    const WallSet::Mark begin = walls_.mark();
    for (const double share : kRoots) {
      const double root = share * wanted_root;
      const std::size_t left = walls_.addBest(region, kCollars.size(), edge, [&](std::size_t attempt) {
        addCollared(region, below, rim, kCollars[attempt] * radius, edge, root);
      });
      if (left > 0 && root > 0) {
        walls_.undoTo(begin);
        continue;
      }
      if (root < wanted_root) short_roots_.push_back(root);
      return;
    }
  }

  /// A collar of `depth` downward from the rim, and a wall that spans the rest, or a stub of the length `root`.
  void addCollared(std::int32_t above, std::int32_t below, const WallRim& rim, double depth, double edge, double root) {
    if (!(depth > 0)) return addEnd(above, below, rim.loop, root);
    Collar collar = addCollar(mesh_, rim, depth, edge, normal_, settings_.up);
    walls_.add({above, below, std::move(collar.triangles)});
    addEnd(above, below, collar.inner, root);
  }

  void addEnd(std::int32_t above, std::int32_t below, const Line& loop, double root) {
    if (root > 0)
      walls_.add({above, kGumRegion, addStub(mesh_, loop, root, settings_.up)});
    else
      walls_.add({above, below, spanWall(mesh_, loop)});
  }

  TriangleMesh& mesh_;
  const WallSettings& settings_;
  RegionBorders borders_;
  std::vector<Vector3d> normal_;                                     // of the vertices of the surface, then of the inner ends of the strips
  std::vector<std::uint32_t> inner_of_;                              // of each vertex of the surface: the inner end of its strip, or itself
  std::map<std::pair<std::uint32_t, std::uint32_t>, Line> line_of_;  // of each edge of an arc, in the direction of the first region
  WallSet walls_;
  std::vector<double> rim_length_, short_roots_;  // as in PartSolids
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
