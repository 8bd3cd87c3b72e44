// SPDX-License-Identifier: GPL-3.0-or-later
#include "hulls/choose_hulls.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstdint>
#include <utility>

#include "certify/triangle_piece.h"
#include "hulls/hull_cover.h"
#include "hulls/hull_overhang.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

// With all the growth that the tolerance leaves it, as proven; without balls if that is none.
Hull grownHull(const FitTask& task, const Hull& hull) {
  const HullOverhangSettings search{.absolute = task.settings.accuracy()};
  const double left = task.settings.tolerance - task.settings.rounding - std::max(0.0, hullOverhang(task.field, hull, search).bound);
  return left > 0 ? grownBy(hull, left) : Hull{.ball = {}, .count = 0};
}

// Greedily, the hulls that hold the most samples that none before holds.
std::vector<Hull> holdMost(const HullComplex& complex) {
  const std::vector<FitSample>& samples = complex.samples();
  std::vector<Hull> all(complex.simplices().size()), out;
  std::vector<std::vector<std::uint32_t>> holds(all.size());
  tbb::parallel_for(std::size_t{0}, all.size(), [&](std::size_t i) {
    all[i] = grownHull(complex.task(), complex.simplices()[i].hull);
    if (all[i].count == 0) return;
    const HullDistance distance(all[i]);
    const Eigen::AlignedBox3d box = boxOf(all[i]);
    for (std::uint32_t k = 0; k < samples.size(); ++k)
      if (box.contains(samples[k].point) && distance(samples[k].point) <= -complex.task().settings.margin()) holds[i].push_back(k);
  });
  std::vector<char> held(samples.size(), 0);
  for (;;) {
    std::size_t best = 0, most = 0;
    for (std::size_t i = 0; i < all.size(); ++i) {
      const auto gain = static_cast<std::size_t>(std::ranges::count_if(holds[i], [&](std::uint32_t k) { return !held[k]; }));
      if (gain > most) most = gain, best = i;
    }
    if (most == 0) return out;
    out.push_back(all[best]);
    for (const std::uint32_t k : holds[best]) held[k] = 1;
  }
}

// Adds balls below the pieces that no hull holds.
void fill(const FitTask& task, ChosenHulls& chosen) {
  const double margin = task.settings.margin();
  const HullCover cover(chosen.hulls, margin);
  std::vector<Piece> open = task.bareOf(cover).pieces;
  std::vector<HullDistance> added;
  while (!open.empty() && chosen.hulls.size() < 4 * task.settings.max_hulls) {
    task.progress.check();
    const Piece piece = open.back();
    open.pop_back();
    const auto holdsIt = [&](const HullDistance& d) {
      return std::ranges::all_of(piece.corner, [&](const Vector3d& q) { return d(q) <= -margin; });
    };
    if (std::ranges::any_of(added, holdsIt) || cover.holds(piece)) continue;
    double gap = 0.5 * task.settings.tolerance;
    Ball ball = task.ballBelowPiece(piece, gap);
    while (!(ball.radius > 0) && (gap *= 0.5) > margin) {
      chosen.is_thin = true;
      ball = task.ballBelowPiece(piece, gap);
    }
    const Hull hull = grownBy({.ball = {ball}, .count = 1}, task.settings.tolerance - task.settings.rounding);
    if (ball.radius > 0 && holdsIt(HullDistance(hull))) {
      chosen.hulls.push_back(hull);
      added.emplace_back(hull);
      continue;
    }
    const std::size_t k = longestSide(piece);
    if (side2(piece, k) < margin * margin) continue;  // the solid has no thickness here: the proof of the cover says so
    for (const Piece& half : halvesOf(piece, k)) open.push_back(half);
  }
}

// Without those, the last first, that the others leave nothing to cover.
std::vector<Hull> withoutRedundant(const FitTask& task, std::vector<Hull> hulls) {
  for (std::size_t i = hulls.size(); i-- > 0;) {
    const HullCover cover(hulls, 0.5 * task.settings.margin());
    const Eigen::AlignedBox3d box = boxOf(hulls[i]);
    std::vector<char> bare(task.mesh.triangles.size(), 0);
    tbb::parallel_for(std::size_t{0}, bare.size(), [&](std::size_t t) {
      const Piece triangle = pieceOf(task.mesh, t, Vector3d::Zero());
      Eigen::AlignedBox3d own;
      for (const Vector3d& p : triangle.corner) own.extend(p);
      if (box.intersects(own)) bare[t] = !cover.holds(triangle, i);
    });
    if (std::ranges::count(bare, 1) == 0) hulls.erase(hulls.begin() + static_cast<std::ptrdiff_t>(i));
  }
  return hulls;
}

}  // namespace

ChosenHulls chooseHulls(const HullComplex& complex) {
  ChosenHulls chosen{.hulls = holdMost(complex)};
  fill(complex.task(), chosen);
  chosen.hulls = withoutRedundant(complex.task(), std::move(chosen.hulls));
  return chosen;
}

}  // namespace spheretree::builder
