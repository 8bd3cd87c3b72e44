// SPDX-License-Identifier: GPL-3.0-or-later
#include "cut/cut_volumes.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>

#include "cut/convex_cell.h"
#include "cut/solid_in_cell.h"
#include "spheretree/core/rounding.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

constexpr double kShare = 0.005;          // default tolerance: of the removed volume
constexpr double kLeastTolerance = 1e-4;  // [mm^3]
constexpr double kSlackOfRadius = 1e-4;   // by which capsules that join steps are shrunk or grown

enum class Place : char { Unknown, In, Out };

struct Cell {
  Vector3d centre;
  double half;
  std::vector<std::uint32_t> capsules;  // those that may meet it
  bool is_swept = false;                // by one capsule, wholly
  std::vector<Place> sides;             // (layer) where it is known to lie, wholly
  std::vector<VolumeBounds> layers;     // contributions
  VolumeBounds total;
  double width = 0;  // of all layers
};

/// A capsule's distance function is convex: its tangent plane at the centre bounds it from below. From above, the
/// distance to the nearest point of the axis does, whose tangent plane is too low by at most `bend` in the cell.
struct Plane {
  HalfSpace free;  // where the capsule certainly is not: normal . p + offset <= 0
  double bend;     // where it certainly is: normal . p + offset >= bend; infinite: unknown
};

class Octree {
 public:
  Octree(LayerFields layers, std::vector<Capsule> capsules, double slack)
      : layers_(layers), capsules_(std::move(capsules)), slack_(slack) {}

  CutVolumes run(double tolerance, std::size_t max_cells, Progress& progress);

 private:
  struct Scratch {
    std::vector<SolidInCell> solids;
    std::vector<Plane> planes;
    std::vector<CellPart> parts;
    ConvexCell convex;
  };

  std::vector<Cell> root() const;
  void examine(Cell& cell, Scratch& scratch) const;
  bool meetCapsules(Cell& cell, Scratch& scratch) const;
  VolumeBounds removedOf(std::size_t layer, const Cell& cell, Scratch& scratch) const;
  VolumeBounds sweptPart(std::span<const CellPart> inner, std::span<const CellPart> outer, const Cell& cell, Scratch& scratch) const;

  LayerFields layers_;
  std::vector<Capsule> capsules_;
  double slack_;
};

std::vector<Cell> Octree::root() const {
  Eigen::AlignedBox3d swept;
  for (const Capsule& c : capsules_)
    for (const Vector3d& p : {c.from, c.to})
      swept.extend(Eigen::AlignedBox3d(p.array() - (c.radius + slack_), p.array() + (c.radius + slack_)));
  const Eigen::AlignedBox3d box = layers_[0].box().intersection(swept);
  Cell cell;
  cell.capsules.resize(capsules_.size());
  std::iota(cell.capsules.begin(), cell.capsules.end(), 0u);
  if (box.isEmpty()) return {};
  cell.centre = box.center();
  cell.half = box.sizes().maxCoeff() / 2 * (1 + kRounding) + kRounding;
  return {cell};
}

/// Keeps the capsules that may meet the cell, with their planes. Returns false if none does.
bool Octree::meetCapsules(Cell& cell, Scratch& scratch) const {
  if (cell.is_swept) return true;
  const double reach = std::sqrt(3.0) * cell.half, margin = kRounding * (cell.half + cell.centre.cwiseAbs().maxCoeff());
  scratch.planes.clear();
  std::size_t kept = 0;
  for (const std::uint32_t k : cell.capsules) {
    const Capsule& capsule = capsules_[k];
    const Vector3d away = cell.centre - nearestOnAxis(capsule, cell.centre);
    const double distance = away.norm(), gap = distance - capsule.radius - slack_ - margin;
    const Vector3d normal = distance > 0 ? Vector3d(away / distance) : Vector3d(Vector3d::Zero());
    if (gap > cell.half * normal.lpNorm<1>()) continue;
    cell.capsules[kept++] = k;
    const double deepest = capsule.radius - slack_ - margin;  // shrunk
    if (distance < deepest) {
      bool is_within = true;  // a capsule is convex
      for (int corner = 0; corner < 8 && is_within; ++corner) {
        const Vector3d p = cell.centre + cell.half * Vector3d(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
        is_within = (p - nearestOnAxis(capsule, p)).norm() <= deepest;
      }
      if (is_within) return cell.is_swept = true;
    }
    const double bend = distance > 1.01 * reach ? reach * reach / (2 * (distance - reach)) + 2 * (slack_ + margin)
                                                : std::numeric_limits<double>::infinity();
    scratch.planes.push_back({{-normal, -gap}, bend});
  }
  cell.capsules.resize(kept);
  // The deepest first: they leave little for the others to cut.
  std::stable_sort(scratch.planes.begin(), scratch.planes.end(),
                   [](const Plane& a, const Plane& b) { return a.free.offset > b.free.offset; });
  return kept > 0;
}

/// Makes `out` the intersection of the parts, none of which is empty. Returns its volume.
double fill(ConvexCell& out, std::span<const CellPart> parts, double half) {
  out.reset(half);
  for (const CellPart& part : parts)
    for (int k = 0; k < part.count; ++k) out.clip(part.half_spaces[static_cast<std::size_t>(k)]);
  return out.volume();
}

/// The swept volume of a set between the intersections of `inner` and of `outer`: what the cell holds of it, without
/// what no capsule reaches.
VolumeBounds Octree::sweptPart(std::span<const CellPart> inner, std::span<const CellPart> outer, const Cell& cell, Scratch& scratch) const {
  const auto isEmpty = [](const CellPart& part) { return part.is_empty; };
  const auto isWhole = [](const CellPart& part) { return part.isWhole(); };
  const double size = 8 * cell.half * cell.half * cell.half, margin = 1000 * kRounding * size;  // each of the planes may add to it
  const bool is_swept = cell.is_swept;
  if (std::any_of(outer.begin(), outer.end(), isEmpty)) return {};
  if (is_swept && std::all_of(inner.begin(), inner.end(), isWhole)) return {size, size};
  VolumeBounds out{0, size};
  if (!is_swept || !std::all_of(outer.begin(), outer.end(), isWhole)) {
    const double held = fill(scratch.convex, outer, cell.half);
    for (std::size_t i = 0; !is_swept && i < scratch.planes.size() && !scratch.convex.isEmpty(); ++i)
      scratch.convex.clip(scratch.planes[i].free);
    const double free = is_swept ? 0 : scratch.convex.volume();
    out.high = free == held ? 0 : std::clamp(held - free + margin, 0.0, size);  // equal only if no plane met it
  }
  if (std::any_of(inner.begin(), inner.end(), isEmpty)) return out;
  const double held = fill(scratch.convex, inner, cell.half);
  for (std::size_t i = 0; !is_swept && i < scratch.planes.size() && !scratch.convex.isEmpty(); ++i)
    if (const Plane& plane = scratch.planes[i]; !std::isinf(plane.bend))
      scratch.convex.clip({plane.free.normal, plane.free.offset - plane.bend});
  out.low = std::clamp(held - (is_swept ? 0 : scratch.convex.volume()) - margin, 0.0, out.high);
  return out;
}

VolumeBounds Octree::removedOf(std::size_t layer, const Cell& cell, Scratch& scratch) const {
  std::vector<CellPart>& parts = scratch.parts;  // inner ones, then outer ones
  parts.clear();
  const auto collect = [&](CellPart CellBounds::*which) {
    parts.push_back(scratch.solids[0].inside.*which);
    if (layer > 0) parts.push_back(scratch.solids[layer].inside.*which);
    for (std::size_t k = layer + 1; k < layers_.size(); ++k) parts.push_back(scratch.solids[k].outside.*which);
  };
  collect(&CellBounds::inner);
  const std::size_t half = parts.size();
  collect(&CellBounds::outer);
  return sweptPart({parts.data(), half}, {parts.data() + half, half}, cell, scratch);
}

void Octree::examine(Cell& cell, Scratch& scratch) const {
  cell.layers.assign(layers_.size(), {});
  cell.total = {};
  cell.width = 0;
  if (!meetCapsules(cell, scratch)) return;
  scratch.solids.clear();
  cell.sides.resize(layers_.size(), Place::Unknown);
  for (std::size_t k = 0; k < layers_.size(); ++k) {
    const SolidInCell& solid = scratch.solids.emplace_back(cell.sides[k] == Place::Unknown ? boundSolid(layers_[k], cell.centre, cell.half)
                                                                                           : wholeCell(cell.sides[k] == Place::In));
    if (solid.isInside()) cell.sides[k] = Place::In;
    if (solid.isOutside()) cell.sides[k] = Place::Out;
  }
  for (std::size_t k = 0; k < layers_.size(); ++k) {
    cell.layers[k] = removedOf(k, cell, scratch);
    cell.width += cell.layers[k].width();
  }
  const SolidInCell& object = scratch.solids[0];
  cell.total = sweptPart({&object.inside.inner, 1}, {&object.inside.outer, 1}, cell, scratch);
}

/// Divides the widest of `open`, and leaves there what has, all together, at most half of what the tolerance allows.
std::vector<Cell> divideWidest(std::vector<Cell>& open, double tolerance) {
  std::vector<std::uint32_t> order(open.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return open[a].width < open[b].width; });
  double left = 0;
  std::size_t first = 0;
  while (first < order.size() && left + open[order[first]].width <= tolerance / 2) left += open[order[first++]].width;
  std::vector<Cell> kept, fresh;
  for (std::size_t i = 0; i < first; ++i) kept.push_back(std::move(open[order[i]]));
  for (std::size_t i = first; i < order.size(); ++i) {
    const Cell& parent = open[order[i]];
    for (int corner = 0; corner < 8; ++corner) {
      Cell child;
      child.half = parent.half / 2;
      child.centre = parent.centre + child.half * Vector3d(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
      child.capsules = parent.capsules;
      child.is_swept = parent.is_swept;
      child.sides = parent.sides;
      fresh.push_back(std::move(child));
    }
  }
  open = std::move(kept);
  return fresh;
}

CutVolumes Octree::run(double tolerance, std::size_t max_cells, Progress& progress) {
  CutVolumes out;
  out.layers.resize(layers_.size());
  const auto add = [](VolumeBounds& to, const VolumeBounds& more) { to.low += more.low, to.high += more.high; };
  std::vector<Cell> open = root(), fresh;
  VolumeBounds done_total;
  std::vector<VolumeBounds> done(layers_.size());
  double done_width = 0;  // of cells that are not divided further
  tbb::enumerable_thread_specific<Scratch> scratch;
  fresh.swap(open);
  for (;;) {
    tbb::parallel_for(std::size_t{0}, fresh.size(), [&](std::size_t i) {
      if (!progress.cancelled()) examine(fresh[i], scratch.local());
    });
    progress.check();
    out.cells += fresh.size();
    for (Cell& cell : fresh) {
      if (cell.width > 0) {
        open.push_back(std::move(cell));
        continue;
      }
      for (std::size_t k = 0; k < done.size(); ++k) add(done[k], cell.layers[k]);
      add(done_total, cell.total);
    }
    fresh.clear();
    out.layers = done;
    out.total = done_total;
    double width = done_width, low = 0;
    for (const Cell& cell : open) {
      for (std::size_t k = 0; k < done.size(); ++k) add(out.layers[k], cell.layers[k]);
      add(out.total, cell.total);
      width += cell.width;
    }
    for (const VolumeBounds& layer : out.layers) low += layer.low;
    const double goal = tolerance > 0 ? tolerance : std::max(kLeastTolerance, kShare * low);
    progress.advance(std::min(1.0, goal / std::max(width, 1e-300)));
    if (width <= goal) return out;
    if (open.empty() || out.cells >= max_cells) return out.is_met = false, out;
    fresh = divideWidest(open, goal);
  }
}

}  // namespace

CutVolumes removedVolumes(LayerFields layers, std::span<const BurrPath> paths, const CutVolumeSettings& settings, Progress& progress) {
  double radius = std::numeric_limits<double>::infinity();
  for (const BurrPath& path : paths) radius = std::min(radius, path.radius);
  const double slack = paths.empty() ? 0 : kSlackOfRadius * radius;
  CutVolumes out = Octree(layers, sweptCapsules(paths, slack), slack).run(settings.tolerance, settings.max_cells, progress);
  if (out.is_met || slack == 0) return out;
  return Octree(layers, sweptCapsules(paths, 0), 0).run(settings.tolerance, settings.max_cells, progress);
}

}  // namespace spheretree::builder
