// SPDX-License-Identifier: GPL-3.0-or-later
#include "repair/resolve_overlaps.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>

#include "geometry/winding_number.h"
#include "mesh/crossing_triangles.h"
#include "repair/arrange_triangles.h"
#include "spheretree/core/mesh_edit.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

/// Facets that are connected by edges of exactly two facets have the same winding numbers on their sides, after they
/// are wound consistently; the numbers are computed once for each such patch.
class Classifier {
 public:
  Classifier(const Arrangement& a, RepairWork& work)
      : a_(a), work_(work), mesh_{a.positions, a.facets, {}, {}}, patch_(a.facets.size(), kNone) {
    findPatches();
  }

  /// Winding number on the front of every facet.
  std::vector<int> fronts() {
    // The original surface, since a facet of several triangles counts several times.
    TriangleMesh whole{a_.positions, {}, {}, {}};
    std::vector<std::vector<std::uint32_t>> of_facet(a_.facets.size());
    for (std::size_t f = 0; f < a_.facets.size(); ++f) {
      const int net = a_.net(f);
      for (int i = 0; i < std::abs(net); ++i) {
        of_facet[f].push_back(static_cast<std::uint32_t>(whole.triangles.size()));
        Triangle triangle = a_.facets[f];
        if (net < 0) std::swap(triangle[1], triangle[2]);
        whole.triangles.push_back(triangle);
      }
    }
    const WindingNumber winding(whole);
    // The largest facet of each patch is used.
    std::vector<std::uint32_t> largest(patches_, kNone);
    std::vector<double> area(patches_, -1);
    for (std::uint32_t f = 0; f < a_.facets.size(); ++f) {
      const double own = a_.area(f);
      if (own > area[patch_[f]]) area[patch_[f]] = own, largest[patch_[f]] = f;
    }
    std::vector<int> front_of_patch(patches_);  // on the front of the largest facet
    for (std::size_t p = 0; p < patches_; ++p) {
      work_.spend(kConstruction);
      const std::uint32_t f = largest[p];
      const Vector3d middle = (mesh_.corner(f, 0) + mesh_.corner(f, 1) + mesh_.corner(f, 2)) / 3;
      front_of_patch[p] = static_cast<int>(std::lround(winding.at(middle, of_facet[f]) - 0.5 * a_.net(f)));
    }
    std::vector<int> fronts(a_.facets.size());
    for (std::uint32_t f = 0; f < a_.facets.size(); ++f) {
      const std::uint32_t speaker = largest[patch_[f]];
      const bool is_alike = alike_[f] == alike_[speaker];
      fronts[f] = is_alike ? front_of_patch[patch_[f]] : front_of_patch[patch_[f]] + a_.net(speaker);
    }
    return fronts;
  }

 private:
  void findPatches() {
    struct FacetSide {
      std::uint64_t edge;
      std::uint32_t facet;
      bool forward;
    };
    std::vector<FacetSide> sides;
    for (std::uint32_t f = 0; f < a_.facets.size(); ++f)
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t u = a_.facets[f][k], v = a_.facets[f][(k + 1) % 3];
        sides.push_back({std::uint64_t{std::min(u, v)} << 32 | std::max(u, v), f, u < v});
      }
    std::sort(sides.begin(), sides.end(),
              [](const FacetSide& a, const FacetSide& b) { return std::tie(a.edge, a.facet) < std::tie(b.edge, b.facet); });
    struct Neighbour {
      std::uint32_t facet;
      bool is_alike;
    };
    std::vector<std::vector<Neighbour>> neighbours(a_.facets.size());
    for (std::size_t i = 0, j = 0; i < sides.size(); i = j) {
      while (j < sides.size() && sides[j].edge == sides[i].edge) ++j;
      if (j - i != 2) continue;
      const bool is_alike = sides[i].forward != sides[i + 1].forward;
      if (a_.net(sides[i].facet) != (is_alike ? 1 : -1) * a_.net(sides[i + 1].facet)) continue;  // not closed there
      neighbours[sides[i].facet].push_back({sides[i + 1].facet, is_alike});
      neighbours[sides[i + 1].facet].push_back({sides[i].facet, is_alike});
    }
    alike_.assign(a_.facets.size(), 1);
    std::vector<std::uint32_t> queue;
    for (std::uint32_t seed = 0; seed < a_.facets.size(); ++seed) {
      if (patch_[seed] != kNone) continue;
      patch_[seed] = static_cast<std::uint32_t>(patches_);
      queue.assign(1, seed);
      while (!queue.empty()) {
        const std::uint32_t f = queue.back();
        queue.pop_back();
        for (const Neighbour& n : neighbours[f])
          if (patch_[n.facet] == kNone) {
            patch_[n.facet] = patch_[seed];
            alike_[n.facet] = static_cast<char>(n.is_alike ? alike_[f] : !alike_[f]);
            queue.push_back(n.facet);
          }
      }
      ++patches_;
    }
  }

  const Arrangement& a_;
  RepairWork& work_;
  TriangleMesh mesh_;
  std::vector<std::uint32_t> patch_;
  std::vector<char> alike_;  // whether it is wound like the first facet of its patch
  std::size_t patches_ = 0;
};

std::vector<std::uint32_t> sorted(std::vector<std::uint32_t> list) {
  std::sort(list.begin(), list.end());
  list.erase(std::unique(list.begin(), list.end()), list.end());
  return list;
}

/// Moves the vertices of triangles that cross to the grid and merges those at one place. Triangles that become flat go;
/// where they leave a vertex on the side of a triangle, that is one of the places to cut.
void snapCrossing(RepairSoup& soup, const CrossingTriangles& crossing, double grid, Resolved& result) {
  TriangleMesh& mesh = soup.mesh;
  std::vector<char> is_snapped(mesh.positions.size(), 0);
  for (const auto& [t, u] : crossing.pairs)
    for (const std::uint32_t triangle : {t, u})
      for (const std::uint32_t v : mesh.triangles[triangle]) is_snapped[v] = 1;
  std::map<std::array<double, 3>, std::uint32_t> at;
  std::vector<std::uint32_t> into(mesh.positions.size());
  for (std::uint32_t v = 0; v < into.size(); ++v) {
    into[v] = v;
    Vector3d& p = mesh.positions[v];
    if (is_snapped[v]) {
      const Vector3d q = grid * (p / grid).array().round().matrix();
      result.snapped = std::max(result.snapped, (q - p).norm());
      p = q;
    }
    const auto [first, is_new] = at.try_emplace({p.x(), p.y(), p.z()}, v);
    if (!is_new) into[v] = first->second;
  }
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::uint32_t& v : mesh.triangles[t]) {
      if (is_snapped[v] && soup.source[t] != kNone) result.moved.push_back(soup.source[t]);
      v = into[v];
    }
  for (const std::uint32_t source : cancelOpposites(soup)) result.moved.push_back(source);
  const std::vector<std::uint32_t> flat = dropFlat(soup);
  result.moved.insert(result.moved.end(), flat.begin(), flat.end());
  result.moved = sorted(std::move(result.moved));
}

/// The facets of which just one side is solid, wound outward; sorts the triangles of the input by what became of them.
template <class IsSolid>
RepairSoup boundaryOf(const Arrangement& arrangement, const std::vector<int>& fronts, const RepairSoup& soup, const IsSolid& isSolid,
                      Resolved& result) {
  RepairSoup kept;
  kept.mesh.positions = arrangement.positions;
  std::vector<std::uint32_t> within, bounds;
  for (std::size_t f = 0; f < arrangement.facets.size(); ++f) {
    const bool front = isSolid(fronts[f]), back = isSolid(fronts[f] + arrangement.net(f));
    std::uint32_t speaker = kNone;  // the first triangle of the input
    for (const Arrangement::Member& m : arrangement.membersOf(f)) {
      const std::uint32_t source = soup.source[m.triangle];
      if (source == kNone) continue;
      speaker = std::min(speaker, source);
      (front != back ? bounds : front ? within : result.lost).push_back(source);
    }
    if (front == back) continue;
    Triangle corners = arrangement.facets[f];
    if (front) std::swap(corners[1], corners[2]);
    kept.mesh.triangles.push_back(corners);
    kept.source.push_back(speaker);
  }
  within = sorted(within), bounds = sorted(bounds), result.lost = sorted(result.lost);
  for (const std::uint32_t source : within) {
    const bool is_left =
        std::binary_search(bounds.begin(), bounds.end(), source) || std::binary_search(result.lost.begin(), result.lost.end(), source);
    (is_left ? result.partly_within : result.within).push_back(source);
  }
  dropUnusedVertices(kept.mesh);
  return kept;
}

}  // namespace

Resolved resolveOverlaps(RepairSoup& soup, const OverlapLimits& limits, double grid, double max_lost, Progress& progress,
                         RepairWork& work) {
  Resolved result;
  CrossingTriangles crossing = findCrossingTriangles(soup.mesh, limits.pairs, progress);
  if (grid > 0 && !crossing.is_stopped) {
    snapCrossing(soup, crossing, grid, result);
    crossing = findCrossingTriangles(soup.mesh, limits.pairs, progress);
  }
  result.crossing_pairs = crossing.pairs.size();
  result.is_stopped = crossing.is_stopped;
  if (crossing.is_stopped) return result;
  const std::optional<Arrangement> arranged = arrangeTriangles(soup.mesh, crossing.pairs, limits.pieces, progress, work);
  result.is_stopped = !arranged;
  if (!arranged) return result;
  const Arrangement& arrangement = *arranged;
  progress.check();
  Classifier classifier(arrangement, work);
  const std::vector<int> fronts = classifier.fronts();

  const auto isSolid = [&](int winding) { return winding >= 1 || (result.is_either_way && winding < 0); };
  const auto boundsNothing = [&](std::size_t f) { return !isSolid(fronts[f]) && !isSolid(fronts[f] + arrangement.net(f)); };
  const auto lostArea = [&] {
    double sum = 0;
    for (std::size_t f = 0; f < arrangement.facets.size(); ++f)
      if (boundsNothing(f) &&
          std::ranges::any_of(arrangement.membersOf(f), [&](const auto& m) { return soup.source[m.triangle] != kNone; }))
        sum += arrangement.area(f);
    return sum;
  };
  result.lost_area = lostArea();
  if (result.lost_area > max_lost) {
    result.is_either_way = true;
    result.lost_area = lostArea();
  }
  soup = boundaryOf(arrangement, fronts, soup, isSolid, result);
  return result;
}

}  // namespace spheretree::builder
