// SPDX-License-Identifier: GPL-3.0-or-later
#include "medial/adaptive_medial_axis.h"

#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_cell_base_with_info_3.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <queue>

#include "geometry/circumcentre.h"
#include "medial/shrinking_balls.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using VertexBase = CGAL::Triangulation_vertex_base_with_info_3<std::uint32_t, Kernel>;
using CellBase = CGAL::Triangulation_cell_base_with_info_3<std::uint32_t, Kernel, CGAL::Delaunay_triangulation_cell_base_3<Kernel>>;
using SiteDelaunay = CGAL::Delaunay_triangulation_3<Kernel, CGAL::Triangulation_data_structure_3<VertexBase, CellBase>>;

// Relative to `a`, so that small cells far from the origin keep their digits. Not finite for a flat cell.
Kernel::Point_3 toCgal(const Vector3d& p) { return {p.x(), p.y(), p.z()}; }

}  // namespace

struct AdaptiveMedialAxis::Impl {
  struct Cell {
    Vector3d centre = Vector3d::Zero();
    Vector3d touch = Vector3d::Zero();  // surface point nearest to the centre
    double radius = 0, clearance = 0;
    std::array<std::uint32_t, 4> site{};
    std::uint32_t birth = 0;  // distinguishes a reused slot from the cell to which a queue entry refers
    bool inside = false;      // whether the cell has a ball
    SiteDelaunay::Cell_handle handle;
    double overhang() const { return radius - clearance; }
  };
  struct Entry {
    double overhang;
    std::uint32_t cell, birth;
    bool operator<(const Entry& o) const { return overhang != o.overhang ? overhang < o.overhang : birth > o.birth; }
  };

  const DistanceField& field;
  SiteDelaunay delaunay;
  std::vector<Vector3d> sites;
  std::vector<std::uint32_t> balls_at;  // (sites) cells whose ball touches the site
  std::vector<Cell> cells;
  std::vector<std::uint32_t> free_cells;
  std::uint32_t births = 0;
  std::size_t ball_count = 0;

  explicit Impl(const DistanceField& distance_field) : field(distance_field) {}

  // Cells are numbered in the order of their sorted sites, so that nothing depends on their storage in CGAL.
  std::vector<std::uint32_t> adopt(std::vector<SiteDelaunay::Cell_handle> handles) {
    struct Named {
      std::array<std::uint32_t, 4> site;
      SiteDelaunay::Cell_handle handle;
    };
    std::vector<Named> named;
    for (const SiteDelaunay::Cell_handle handle : handles) {
      handle->info() = kNone;
      if (delaunay.is_infinite(handle)) continue;
      Named n{{handle->vertex(0)->info(), handle->vertex(1)->info(), handle->vertex(2)->info(), handle->vertex(3)->info()}, handle};
      std::sort(n.site.begin(), n.site.end());
      named.push_back(n);
    }
    std::sort(named.begin(), named.end(), [](const Named& a, const Named& b) { return a.site < b.site; });
    std::vector<std::uint32_t> made;
    for (const Named& n : named) {
      std::uint32_t id = static_cast<std::uint32_t>(cells.size());
      if (free_cells.empty()) {
        cells.emplace_back();
      } else {
        id = free_cells.back();
        free_cells.pop_back();
      }
      n.handle->info() = id;
      Cell& cell = cells[id];
      cell = Cell{};
      cell.site = n.site;
      cell.birth = births++;
      cell.handle = n.handle;
      const Vector3d centre = circumcentre(sites[n.site[0]], sites[n.site[1]], sites[n.site[2]], sites[n.site[3]]);
      if (!centre.allFinite() || !field.box().contains(centre)) continue;
      NearestPoint touch;
      const double depth = -field.signedDistance(centre, &touch);
      if (!(depth > 0.1 * kVanishing * field.diagonal())) continue;
      double radius = 0;
      for (const std::uint32_t s : n.site) radius = std::max(radius, (sites[s] - centre).norm());
      cell.centre = centre;
      cell.touch = touch.point;
      cell.radius = std::max(radius, depth);
      cell.clearance = depth;
      cell.inside = true;
      ++ball_count;
      for (const std::uint32_t s : n.site) ++balls_at[s];
      made.push_back(id);
    }
    return made;
  }

  template <class Died>
  void forget(std::uint32_t id, Died&& died) {
    Cell& cell = cells[id];
    if (cell.inside) {
      died(cell);
      --ball_count;
      for (const std::uint32_t s : cell.site) --balls_at[s];
    }
    cell.inside = false;
    cell.birth = kNone;
    free_cells.push_back(id);
  }

  // Inserts a site and returns the new cells with balls; empty if the point already is a site.
  template <class Died>
  std::vector<std::uint32_t> insert(const Vector3d& p, SiteDelaunay::Cell_handle near, Died&& died) {
    SiteDelaunay::Locate_type type;
    int i = 0, j = 0;
    const SiteDelaunay::Cell_handle at = delaunay.locate(toCgal(p), type, i, j, near);
    if (type == SiteDelaunay::VERTEX || type == SiteDelaunay::OUTSIDE_AFFINE_HULL) return {};
    std::vector<SiteDelaunay::Facet> facets;
    std::vector<SiteDelaunay::Cell_handle> conflict;
    delaunay.find_conflicts(toCgal(p), at, std::back_inserter(facets), std::back_inserter(conflict));
    if (facets.empty()) return {};
    std::vector<std::uint32_t> ids;
    for (const SiteDelaunay::Cell_handle cell : conflict)
      if (!delaunay.is_infinite(cell)) ids.push_back(cell->info());
    // In the order of birth, so that the order in which slots are reused is deterministic.
    std::sort(ids.begin(), ids.end(), [&](std::uint32_t a, std::uint32_t b) { return cells[a].birth < cells[b].birth; });
    for (const std::uint32_t id : ids) forget(id, died);
    const SiteDelaunay::Vertex_handle vertex =
        delaunay.insert_in_hole(toCgal(p), conflict.begin(), conflict.end(), facets.front().first, facets.front().second);
    vertex->info() = static_cast<std::uint32_t>(sites.size());
    sites.push_back(p);
    balls_at.push_back(0);
    std::vector<SiteDelaunay::Cell_handle> created;
    delaunay.incident_cells(vertex, std::back_inserter(created));
    return adopt(std::move(created));
  }

  void refineRegions(const std::function<std::uint32_t(const Vector3d&)>& region_of, std::span<const Target> regions, double smallest,
                     std::vector<std::uint32_t>& label, Progress& progress);
  struct Living {
    std::vector<std::uint32_t> cell, first_equal;
  };
  Living livingCells(double smallest) const;
};

AdaptiveMedialAxis::AdaptiveMedialAxis(const DistanceField& field, std::span<const Vector3d> sites) : impl_(std::make_unique<Impl>(field)) {
  Impl& m = *impl_;
  // One by one in the given order: the numbers of vertices are then deterministic, and a repeated point keeps its first
  // number.
  SiteDelaunay::Cell_handle hint;
  for (const Vector3d& p : sites) {
    const std::size_t before = m.delaunay.number_of_vertices();
    const SiteDelaunay::Vertex_handle vertex = m.delaunay.insert(toCgal(p), hint);
    hint = vertex->cell();
    if (m.delaunay.number_of_vertices() == before) continue;
    vertex->info() = static_cast<std::uint32_t>(m.sites.size());
    m.sites.push_back(p);
  }
  m.balls_at.assign(m.sites.size(), 0);
  if (m.delaunay.dimension() < 3) return;  // fewer than four sites, or all coplanar: only inner balls
  std::vector<SiteDelaunay::Cell_handle> handles;
  for (auto cell = m.delaunay.all_cells_begin(); cell != m.delaunay.all_cells_end(); ++cell) handles.push_back(cell);
  m.adopt(std::move(handles));
}

AdaptiveMedialAxis::~AdaptiveMedialAxis() = default;

std::size_t AdaptiveMedialAxis::siteCount() const { return impl_->sites.size(); }
std::size_t AdaptiveMedialAxis::ballCount() const { return impl_->ball_count; }

namespace {

// Calls visit(region) once for each region below `regions` to which one of the four sites belongs.
template <class Visit>
void forEachRegion(const std::array<std::uint32_t, 4>& site, const std::vector<std::uint32_t>& label, std::size_t regions, Visit&& visit) {
  for (std::size_t k = 0; k < 4; ++k) {
    const std::uint32_t region = label[site[k]];
    bool is_first = region < regions;
    for (std::size_t j = 0; j < k; ++j) is_first = is_first && label[site[j]] != region;
    if (is_first) visit(region);
  }
}

}  // namespace

// Inserts sites, region by region: the surface point nearest to the ball with the largest overhang, until each target
// is met. `label`: the region of each site; grows with the sites. Balls whose sites are nearer than `smallest` are not
// refined further.
void AdaptiveMedialAxis::Impl::refineRegions(const std::function<std::uint32_t(const Vector3d&)>& region_of,
                                             std::span<const Target> regions, double smallest, std::vector<std::uint32_t>& label,
                                             Progress& progress) {
  std::vector<std::priority_queue<Entry>> queues(regions.size());
  std::vector<std::size_t> count(regions.size(), 0);
  const auto born = [&](std::uint32_t id) {
    forEachRegion(cells[id].site, label, regions.size(), [&](std::uint32_t region) {
      ++count[region];
      queues[region].push({cells[id].overhang(), id, cells[id].birth});
    });
  };
  const auto died = [&](const Cell& cell) {
    forEachRegion(cell.site, label, regions.size(), [&](std::uint32_t region) { --count[region]; });
  };
  for (std::uint32_t id = 0; id < cells.size(); ++id)
    if (cells[id].inside) born(id);
  for (std::uint32_t region = 0; region < regions.size(); ++region) {
    progress.check();
    const Target& target = regions[region];
    for (std::size_t inserted = 0; inserted < target.max_sites && !queues[region].empty();) {
      const Entry worst = queues[region].top();
      if (worst.overhang <= smallest || (worst.overhang <= target.overhang && count[region] >= target.min_balls)) break;
      queues[region].pop();
      if (cells[worst.cell].birth != worst.birth) continue;
      const Vector3d touch = cells[worst.cell].touch;
      label.push_back(region_of(touch));  // a new site gets the next number
      const std::vector<std::uint32_t> made = insert(touch, cells[worst.cell].handle, died);
      if (sites.size() < label.size()) {
        label.pop_back();
        continue;
      }
      if (++inserted % 256 == 0) progress.check();
      for (const std::uint32_t id : made) born(id);
    }
    queues[region] = {};
  }
}

// Cells with a ball, the oldest first, and for each of them the first cell with the same centre. Cospherical sites give
// the same centre many times, up to rounding, so centres in one grid cell of side `smallest` count as equal.
AdaptiveMedialAxis::Impl::Living AdaptiveMedialAxis::Impl::livingCells(double smallest) const {
  Living out;
  for (std::uint32_t id = 0; id < cells.size(); ++id)
    if (cells[id].inside) out.cell.push_back(id);
  std::sort(out.cell.begin(), out.cell.end(), [&](std::uint32_t a, std::uint32_t b) { return cells[a].birth < cells[b].birth; });
  struct Key {
    std::array<std::int64_t, 3> place;
    std::uint32_t order;
    auto operator<=>(const Key&) const = default;
  };
  std::vector<Key> keys;
  for (std::uint32_t i = 0; i < out.cell.size(); ++i) {
    const Vector3d q = (cells[out.cell[i]].centre - field.box().min()) / smallest;
    keys.push_back({{std::llround(q.x()), std::llround(q.y()), std::llround(q.z())}, i});
  }
  std::sort(keys.begin(), keys.end());
  out.first_equal.resize(out.cell.size());
  for (std::size_t i = 0; i < keys.size(); ++i)
    out.first_equal[keys[i].order] = i > 0 && keys[i].place == keys[i - 1].place ? out.first_equal[keys[i - 1].order] : keys[i].order;
  return out;
}

std::vector<std::vector<FittedBall>> AdaptiveMedialAxis::refine(const std::function<std::uint32_t(const Vector3d&)>& region_of,
                                                                std::span<const Target> regions, Progress& progress) {
  Impl& m = *impl_;
  std::vector<std::uint32_t> label;
  for (const Vector3d& p : m.sites) label.push_back(region_of(p));
  const double smallest = kVanishing * m.field.diagonal();  // a site nearer to others would only repeat the sites of its ball
  m.refineRegions(region_of, regions, smallest, label, progress);

  std::vector<std::vector<FittedBall>> balls(regions.size());
  const Impl::Living living = m.livingCells(smallest);
  std::vector<std::vector<std::uint32_t>> chosen(regions.size());
  for (std::uint32_t i = 0; i < living.cell.size(); ++i)
    forEachRegion(m.cells[living.cell[i]].site, label, regions.size(),
                  [&](std::uint32_t region) { chosen[region].push_back(living.first_equal[i]); });
  for (std::size_t region = 0; region < regions.size(); ++region) {
    std::sort(chosen[region].begin(), chosen[region].end());
    chosen[region].erase(std::unique(chosen[region].begin(), chosen[region].end()), chosen[region].end());
    for (const std::uint32_t i : chosen[region]) {
      const Impl::Cell& cell = m.cells[living.cell[i]];
      balls[region].push_back({cell.centre, cell.radius, cell.clearance});
    }
  }
  for (std::size_t site = 0; site < m.sites.size(); ++site) {
    if (m.balls_at[site] > 0 || label[site] >= regions.size()) continue;
    const Ball ball = shrinkingBall(m.field, m.sites[site], m.field.pseudonormal(m.field.nearest(m.sites[site])));
    if (ball.radius > smallest) balls[label[site]].push_back({ball.centre, ball.radius, ball.radius});
  }
  return balls;
}

}  // namespace spheretree::builder
