// SPDX-License-Identifier: GPL-3.0-or-later
#include "repair/repair_soup.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <tuple>
#include <utility>

#include "geometry/box_tree.h"
#include "mesh/crossing_triangles.h"
#include "mesh/mesh_edges.h"
#include "mesh/triangle_area.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr std::array kTolerances{0.0, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 3e-5, 1e-4};  // of the diagonal
constexpr double kShareOfSide = 0.25;                                             // share of its shortest side by which a vertex may move
constexpr double kNearlyAll = 0.02;                                               // share of the closable edges that may stay open
constexpr double kMaxFinArea = 0.03;                                              // share of the total area
constexpr double kFinSize = 0.1;                                                  // as a share of the diagonal: size of a fin's box

/// Keeps the triangles for which `keep` is true; returns the sources of the others.
template <class Keep>
std::vector<std::uint32_t> filter(RepairSoup& soup, Keep&& keep) {
  std::vector<std::uint32_t> dropped;
  std::size_t kept = 0;
  for (std::size_t t = 0; t < soup.source.size(); ++t) {
    if (!keep(t)) {
      if (soup.source[t] != kNone) dropped.push_back(soup.source[t]);
      continue;
    }
    soup.mesh.triangles[kept] = soup.mesh.triangles[t];
    soup.source[kept++] = soup.source[t];
  }
  soup.mesh.triangles.resize(kept);
  soup.source.resize(kept);
  return dropped;
}

double diagonalOf(const TriangleMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Triangle& triangle : mesh.triangles)
    for (const std::uint32_t v : triangle) box.extend(mesh.positions[v]);
  return box.isEmpty() ? 0 : box.diagonal().norm();
}

std::vector<std::uint32_t> openVertices(const std::vector<OpenEdge>& open) {
  std::vector<std::uint32_t> vertices;
  for (const OpenEdge& e : open) vertices.push_back(e.from), vertices.push_back(e.to);
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  return vertices;
}

BoxTree treeOfPoints(const TriangleMesh& mesh, const std::vector<std::uint32_t>& vertices) {
  std::vector<Eigen::AlignedBox3d> boxes;
  for (const std::uint32_t v : vertices) boxes.emplace_back(mesh.positions[v]);
  return BoxTree(boxes);
}

/// Distance by which the rounding of coordinates can move a point off an edge. The certificate allows a hundred times
/// as much.
double roundingOf(double length, const Vector3d& from) { return 1e-15 * (length + from.cwiseAbs().maxCoeff()); }

class Stitcher {
 public:
  Stitcher(RepairSoup& soup, Stitched& result, std::size_t max_triangles, RepairWork& work)
      : soup_(soup), result_(result), max_triangles_(max_triangles), work_(work) {}

  void run(double tolerance) {
    result_.tolerance = tolerance;
    if (tolerance > 0) weld(tolerance);
    filter(soup_, [&](std::size_t t) {  // triangles that the weld made flat
      const auto [a, b, c] = soup_.mesh.triangles[t];
      const bool holds = a != b && b != c && c != a;
      if (!holds) modify(t);
      return holds;
    });
    for (int round = 0; round < 8 && splitTJunctions(tolerance); ++round) {
    }
  }

 private:
  void modify(std::size_t t) {
    if (soup_.source[t] != kNone) result_.is_modified[soup_.source[t]] = 1;
  }

  void weld(double tolerance) {
    TriangleMesh& mesh = soup_.mesh;
    const std::vector<std::uint32_t> vertices = openVertices(findOpenEdges(mesh));
    if (vertices.empty()) return;
    std::vector<double> reach(mesh.positions.size(), tolerance);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      for (int k = 0; k < 3; ++k) {
        const double largest = kShareOfSide * (mesh.corner(t, (k + 1) % 3) - mesh.corner(t, k)).norm();
        for (const int end : {k, (k + 1) % 3}) {
          double& r = reach[mesh.triangles[t][static_cast<std::size_t>(end)]];
          r = std::min(r, largest);
        }
      }
    const BoxTree tree = treeOfPoints(mesh, vertices);
    std::vector<std::uint32_t> into(mesh.positions.size());  // a vertex is merged into the first near one that is not merged itself
    std::iota(into.begin(), into.end(), 0u);
    std::vector<char> is_taken(mesh.positions.size(), 0);
    std::vector<std::vector<std::uint32_t>> clusters;
    for (const std::uint32_t v : vertices) {
      if (is_taken[v]) continue;
      std::vector<std::uint32_t> cluster{v};
      is_taken[v] = 1;
      tree.searchWithin(mesh.positions[v], reach[v] * reach[v], [&](std::size_t first, std::size_t count) {
        work_.spend(1);
        for (std::size_t s = first; s < first + count; ++s) {
          const std::uint32_t u = vertices[tree.order()[s]];
          if (is_taken[u] || (mesh.positions[u] - mesh.positions[v]).norm() > std::min(reach[u], reach[v])) continue;
          is_taken[u] = 1;
          into[u] = v;
          cluster.push_back(u);
        }
      });
      if (cluster.size() > 1) clusters.push_back(std::move(cluster));
    }
    std::vector<char> is_moved(mesh.positions.size(), 0);
    for (std::vector<std::uint32_t>& cluster : clusters) {
      std::sort(cluster.begin(), cluster.end());
      Vector3d middle = Vector3d::Zero();
      for (const std::uint32_t v : cluster) middle += mesh.positions[v] - mesh.positions[cluster[0]];
      middle = mesh.positions[cluster[0]] + middle / static_cast<double>(cluster.size());
      for (const std::uint32_t v : cluster) {
        is_moved[v] = 1;
        result_.moved = std::max(result_.moved, (mesh.positions[v] - middle).norm());
      }
      for (const std::uint32_t v : cluster) mesh.positions[v] = middle;
      result_.welded += cluster.size() - 1;
    }
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      for (std::uint32_t& v : mesh.triangles[t]) {
        if (is_moved[v]) modify(t);
        v = into[v];
      }
  }

  // One round: splits each triangle at no more than one of its sides. Returns whether there was anything to split.
  bool splitTJunctions(double tolerance) {
    TriangleMesh& mesh = soup_.mesh;
    const std::vector<OpenEdge> open = findOpenEdges(mesh);
    if (open.empty()) return false;
    const std::vector<std::uint32_t> vertices = openVertices(open);
    const BoxTree tree = treeOfPoints(mesh, vertices);
    std::set<std::uint32_t> done;
    const std::size_t before = result_.split;
    for (const OpenEdge& e : open) {
      if (done.contains(e.triangle)) continue;
      const Vector3d a = mesh.positions[e.from], d = mesh.positions[e.to] - a;
      const double length = d.norm();
      if (!(length > 4 * tolerance)) continue;
      const double near = std::max(tolerance, roundingOf(length, a));
      work_.spend(1);
      std::size_t leaves = 0;
      std::vector<std::pair<double, std::uint32_t>> on;  // position along the edge, vertex
      tree.searchWithin(a + 0.5 * d, std::pow(0.5 * length + near, 2), [&](std::size_t first, std::size_t count) {
        if (++leaves % 16 == 0) work_.spend(1);
        for (std::size_t s = first; s < first + count; ++s) {
          const std::uint32_t v = vertices[tree.order()[s]];
          if (v == e.from || v == e.to || std::ranges::find(mesh.triangles[e.triangle], v) != mesh.triangles[e.triangle].end()) continue;
          const double at = (mesh.positions[v] - a).dot(d) / (length * length), off = (mesh.positions[v] - a - at * d).norm();
          if (off <= near && at * length > near && (1 - at) * length > near) on.emplace_back(at, v);
        }
      });
      if (on.empty() || mesh.triangles.size() + on.size() > max_triangles_) continue;
      std::sort(on.begin(), on.end());
      split(e, on);
      done.insert(e.triangle);
    }
    return result_.split > before;
  }

  void split(const OpenEdge& e, const std::vector<std::pair<double, std::uint32_t>>& on) {
    TriangleMesh& mesh = soup_.mesh;
    const Triangle whole = mesh.triangles[e.triangle];
    std::uint32_t apex = 0;
    for (std::size_t k = 0; k < 3; ++k)
      if (whole[k] == e.from) apex = whole[(k + 2) % 3];
    const Vector3d a = mesh.positions[e.from], d = mesh.positions[e.to] - a;
    std::uint32_t last = e.from;
    for (std::size_t i = 0; i <= on.size(); ++i) {
      const std::uint32_t next = i < on.size() ? on[i].second : e.to;
      const Triangle piece{last, next, apex};
      if (i == 0) {
        mesh.triangles[e.triangle] = piece;
      } else {
        mesh.triangles.push_back(piece);
        soup_.source.push_back(soup_.source[e.triangle]);
      }
      last = next;
      if (i == on.size()) break;
      const double off = (mesh.positions[next] - a - on[i].first * d).norm();
      result_.moved = std::max(result_.moved, off);
      if (off > roundingOf(d.norm(), a)) modify(e.triangle);
    }
    result_.split += on.size();
  }

  RepairSoup& soup_;
  Stitched& result_;
  std::size_t max_triangles_;
  RepairWork& work_;
};

/// Patches of triangles that are connected by edges of exactly two triangles.
struct Patches {
  std::vector<std::uint32_t> of;  // for each triangle
  std::size_t count = 0;
};

Patches findPatches(const TriangleMesh& mesh, const std::vector<Side>& sides) {
  std::vector<std::vector<std::uint32_t>> neighbours(mesh.triangles.size());
  forEachEdge(sides, [&](std::size_t first, std::size_t last) {
    if (last - first != 2) return;
    neighbours[sides[first].triangle].push_back(sides[first + 1].triangle);
    neighbours[sides[first + 1].triangle].push_back(sides[first].triangle);
  });
  Patches patches;
  patches.of.assign(mesh.triangles.size(), kNone);
  std::vector<std::uint32_t> queue;
  for (std::uint32_t seed = 0; seed < mesh.triangles.size(); ++seed) {
    if (patches.of[seed] != kNone) continue;
    queue.assign(1, seed);
    patches.of[seed] = static_cast<std::uint32_t>(patches.count);
    while (!queue.empty()) {
      const std::uint32_t t = queue.back();
      queue.pop_back();
      for (const std::uint32_t u : neighbours[t])
        if (patches.of[u] == kNone) patches.of[u] = static_cast<std::uint32_t>(patches.count), queue.push_back(u);
    }
    ++patches.count;
  }
  return patches;
}

}  // namespace

std::vector<OpenEdge> findOpenEdges(const TriangleMesh& mesh) {
  const std::vector<Side> sides = sortedSides(mesh);
  std::vector<OpenEdge> open;
  forEachEdge(sides, [&](std::size_t first, std::size_t last) {
    int forwards = 0;
    for (std::size_t i = first; i < last; ++i) forwards += sides[i].forward ? 1 : -1;
    if (forwards == 0) return;
    const auto at = std::find_if(sides.begin() + static_cast<std::ptrdiff_t>(first), sides.end(),
                                 [&](const Side& s) { return s.forward == (forwards > 0); });
    if (forwards > 0)
      open.push_back({at->low(), at->high(), at->triangle, forwards});
    else
      open.push_back({at->high(), at->low(), at->triangle, -forwards});
  });
  std::sort(open.begin(), open.end(), [](const OpenEdge& a, const OpenEdge& b) { return std::tie(a.from, a.to) < std::tie(b.from, b.to); });
  return open;
}

std::vector<std::uint32_t> dropFlat(RepairSoup& soup) {
  return filter(soup, [&](std::size_t t) { return !isFlat(soup.mesh, t); });
}

std::vector<std::uint32_t> dropDuplicates(RepairSoup& soup) {
  std::set<Triangle> seen;
  return filter(soup, [&](std::size_t t) {
    Triangle corners = soup.mesh.triangles[t];
    std::sort(corners.begin(), corners.end());
    return seen.insert(corners).second;
  });
}

bool hasDuplicates(const TriangleMesh& mesh) {
  std::vector<Triangle> sorted = mesh.triangles;
  for (Triangle& corners : sorted) std::sort(corners.begin(), corners.end());
  std::sort(sorted.begin(), sorted.end());
  return std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end();
}

Stitched stitchCracks(RepairSoup& soup, std::size_t input_triangles, std::size_t max_triangles, RepairWork& work) {
  const auto attempt = [&](double tolerance, RepairSoup& copy) {
    Stitched result;
    result.is_modified.assign(input_triangles, 0);
    Stitcher(copy, result, max_triangles, work).run(tolerance);
    return result;
  };
  const double diagonal = diagonalOf(soup.mesh);
  std::array<std::size_t, kTolerances.size()> open{};
  std::size_t fewest_open = findOpenEdges(soup.mesh).size();
  const std::size_t before = fewest_open;
  for (std::size_t i = 0; i < kTolerances.size(); ++i) {
    RepairSoup copy = soup;
    attempt(kTolerances[i] * diagonal, copy);
    open[i] = findOpenEdges(copy.mesh).size();
    fewest_open = std::min(fewest_open, open[i]);
    if (fewest_open == 0) break;
  }
  Stitched result;
  result.is_modified.assign(input_triangles, 0);
  const auto target = static_cast<std::size_t>(kNearlyAll * static_cast<double>(before - fewest_open)) + fewest_open;
  if (before <= target) return result;
  for (std::size_t i = 0; i < kTolerances.size(); ++i)
    if (open[i] <= target) return attempt(kTolerances[i] * diagonal, soup);
  return result;
}

std::size_t alignWinding(RepairSoup& soup) {
  TriangleMesh& mesh = soup.mesh;
  const std::vector<Side> sides = sortedSides(mesh);
  struct Neighbour {
    std::uint32_t triangle;
    bool clashes;
  };
  std::vector<std::vector<Neighbour>> neighbours(mesh.triangles.size());
  forEachEdge(sides, [&](std::size_t first, std::size_t last) {
    if (last - first != 2) return;
    const Side &a = sides[first], &b = sides[first + 1];
    neighbours[a.triangle].push_back({b.triangle, a.forward == b.forward});
    neighbours[b.triangle].push_back({a.triangle, a.forward == b.forward});
  });
  std::vector<signed char> turn(mesh.triangles.size(), -1);
  std::vector<std::uint32_t> patch;
  std::size_t turned = 0;
  for (std::uint32_t seed = 0; seed < mesh.triangles.size(); ++seed) {
    if (turn[seed] >= 0) continue;
    turn[seed] = 0;
    patch.assign(1, seed);
    double balance = 0;  // area that keeps its winding minus area that is turned
    for (std::size_t i = 0; i < patch.size(); ++i) {
      const std::uint32_t t = patch[i];
      balance += turn[t] ? -triangleArea(mesh, t) : triangleArea(mesh, t);
      for (const Neighbour& n : neighbours[t])
        if (turn[n.triangle] < 0) {
          turn[n.triangle] = static_cast<signed char>(n.clashes ? !turn[t] : turn[t]);
          patch.push_back(n.triangle);
        }
    }
    for (const std::uint32_t t : patch)
      if ((turn[t] != 0) == (balance >= 0)) std::swap(mesh.triangles[t][1], mesh.triangles[t][2]), ++turned;
  }
  return turned;
}

bool isOneSided(const TriangleMesh& mesh) {
  const std::vector<Side> sides = sortedSides(mesh);
  bool found = false;
  forEachEdge(sides,
              [&](std::size_t first, std::size_t last) { found |= last - first == 2 && sides[first].forward == sides[first + 1].forward; });
  return found;
}

std::vector<std::uint32_t> cancelOpposites(RepairSoup& soup) {
  std::map<Triangle, std::vector<std::size_t>> unmatched;  // by sorted corners: triangles of one winding
  std::vector<char> goes(soup.source.size(), 0);
  const auto isEven = [&](std::size_t t) {
    const auto [a, b, c] = soup.mesh.triangles[t];
    return ((a < b) + (b < c) + (c < a)) == 2;
  };
  for (std::size_t t = 0; t < goes.size(); ++t) {
    Triangle corners = soup.mesh.triangles[t];
    std::sort(corners.begin(), corners.end());
    std::vector<std::size_t>& others = unmatched[corners];
    if (others.empty() || isEven(others.back()) == isEven(t)) {
      others.push_back(t);
    } else {
      goes[t] = goes[others.back()] = 1;
      others.pop_back();
    }
  }
  return filter(soup, [&](std::size_t t) { return !goes[t]; });
}

std::size_t turnInward(RepairSoup& soup, const std::vector<std::uint32_t>& component_of, RepairWork& work) {
  TriangleMesh& mesh = soup.mesh;
  struct Body {
    double volume = 0;
    Eigen::AlignedBox3d box;
  };
  std::vector<Body> bodies;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    bodies.resize(std::max<std::size_t>(bodies.size(), component_of[t] + 1u));
    for (int k = 0; k < 3; ++k) bodies[component_of[t]].box.extend(mesh.corner(t, k));
  }
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    Body& body = bodies[component_of[t]];
    const Vector3d middle = body.box.center();  // otherwise a small body far from the origin would lose its digits
    body.volume += (mesh.corner(t, 0) - middle).dot((mesh.corner(t, 1) - middle).cross(mesh.corner(t, 2) - middle));
  }
  const auto goesRound = [&](const Body& inner) {
    work.spend(1 + bodies.size() / 256);
    return std::ranges::any_of(bodies, [&](const Body& b) { return &b != &inner && b.box.contains(inner.box); });
  };
  std::vector<char> turns(bodies.size(), 0);
  std::size_t count = 0;
  for (std::size_t c = 0; c < bodies.size(); ++c)
    if (bodies[c].volume < 0 && !goesRound(bodies[c])) turns[c] = 1, ++count;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    if (turns[component_of[t]]) std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
  return count;
}

std::vector<std::uint32_t> dropFins(RepairSoup& soup, RepairWork& work) {
  double left = 0;  // area that may still be removed
  for (std::size_t t = 0; t < soup.mesh.triangles.size(); ++t) left += kMaxFinArea * triangleArea(soup.mesh, t);
  const double max_size = kFinSize * diagonalOf(soup.mesh);
  std::vector<std::uint32_t> dropped;
  for (bool again = true; again;) {  // a fin may be attached to a fin
    again = false;
    work.spend(soup.mesh.triangles.size());
    const std::vector<Side> sides = sortedSides(soup.mesh);
    const Patches patches = findPatches(soup.mesh, sides);
    std::vector<char> is_free(patches.count, 0), is_joined(patches.count, 0);
    forEachEdge(sides, [&](std::size_t first, std::size_t last) {
      if (last - first == 1) is_free[patches.of[sides[first].triangle]] = 1;
      for (std::size_t i = first; i < last && last - first > 2; ++i) is_joined[patches.of[sides[i].triangle]] = 1;
    });
    std::vector<double> area(patches.count, 0);
    std::vector<Eigen::AlignedBox3d> box(patches.count);
    for (std::size_t t = 0; t < soup.mesh.triangles.size(); ++t) {
      area[patches.of[t]] += triangleArea(soup.mesh, t);
      for (int k = 0; k < 3; ++k) box[patches.of[t]].extend(soup.mesh.corner(t, k));
    }
    std::vector<std::uint32_t> order(patches.count);
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return area[a] < area[b]; });
    std::vector<char> goes(patches.count, 0);
    for (const std::uint32_t p : order)
      if (is_free[p] && is_joined[p] && area[p] <= left && box[p].diagonal().norm() <= max_size) goes[p] = 1, left -= area[p], again = true;
    const auto removed = filter(soup, [&](std::size_t t) { return !goes[patches.of[t]]; });
    dropped.insert(dropped.end(), removed.begin(), removed.end());
  }
  std::sort(dropped.begin(), dropped.end());
  return dropped;
}

}  // namespace spheretree::builder
