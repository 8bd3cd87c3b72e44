// SPDX-License-Identifier: GPL-3.0-or-later
#include "hulls/build_hulls.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "hulls/cut_hulls.h"
#include "hulls/fit_hulls.h"
#include "hulls/hull_cover.h"
#include "hulls/hull_overhang.h"
#include "spheretree/core/rounding.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr double kFloatStep =
    0x1p-23;                     // larger than the errors of a rounded centre and radius together, as a share of the farthest coordinate
constexpr double kFirst = 1e-3;  // tolerance at the start of the search for the smallest one, as a share of the diagonal
constexpr double kStep = 4, kLastStep = 1.1;  // its factors at the start and at the end

std::vector<Hull> partsOf(const Hulls& hulls) {
  std::vector<Hull> parts;
  for (const HullPart& part : hulls.parts) parts.push_back(hullOf(hulls, part));
  return parts;
}

// The largest of the bounds of the parts.
double overhangOf(const DistanceField& field, std::vector<Hull> parts, const Vector3d& origin, const HullOverhangSettings& settings,
                  Progress& progress) {
  std::vector<double> bound(parts.size());
  tbb::parallel_for(std::size_t{0}, parts.size(), [&](std::size_t i) {
    progress.check();
    for (Ball& ball : parts[i].ball) ball.centre += origin;
    bound[i] = hullOverhang(field, parts[i], settings).bound;
  });
  return *std::ranges::max_element(bound);
}

Hulls hullsWithin(const TriangleMesh& mesh, const DistanceField& field, const Vector3d& origin, const HullSettings& settings,
                  Progress& progress) {
  const Eigen::AlignedBox3d& box = field.box();
  const double farthest = std::max((box.min() - origin).cwiseAbs().maxCoeff(), (box.max() - origin).cwiseAbs().maxCoeff());
  // Less than the tolerance by what the bound may be above what is attained: the bound itself meets the tolerance.
  HullOverhangSettings search;
  search.absolute = search.relative * settings.tolerance;  // of parts that hardly reach out
  const FitSettings fit{
      .tolerance = settings.tolerance * (1 - 2 * search.relative), .rounding = 2 * kFloatStep * farthest, .max_hulls = settings.max_hulls};
  const std::vector<Hull> fitted = fitHulls(mesh, field, fit, progress);
  Hulls hulls = fitted.empty() ? Hulls{} : cutHulls(fitted, origin);
  if (hulls.empty()) return {};
  hulls.overhang_bound = roundUp(std::max(0.0, overhangOf(field, partsOf(hulls), origin, search, progress)));
  return hulls;
}

}  // namespace

Hulls buildHulls(const TriangleMesh& mesh, const DistanceField& field, const Vector3d& origin, const HullSettings& settings,
                 Progress& progress) {
  if (settings.tolerance > 0) return hullsWithin(mesh, field, origin, settings, progress);
  HullSettings tried = settings;
  tried.tolerance = kFirst * field.diagonal();
  Hulls best;
  bool seen_fit = false, seen_miss = false;
  for (double factor = kStep; factor > kLastStep;) {
    Hulls hulls = hullsWithin(mesh, field, origin, tried, progress);
    // Steps down until too many hulls are needed, or up until no longer; then halves the step.
    const bool fits = !hulls.empty();
    if (fits && (best.empty() || hulls.overhang_bound < best.overhang_bound)) best = std::move(hulls);
    (fits ? seen_fit : seen_miss) = true;
    if (seen_fit && seen_miss) factor = std::sqrt(factor);
    tried.tolerance *= fits ? 1 / factor : factor;
  }
  return best;
}

std::string findUnproven(const TriangleMesh& mesh, const DistanceField& field, const Hulls& decoded, const Vector3d& origin,
                         Progress& progress) {
  const std::vector<Hull> parts = partsOf(decoded);
  const double bound{decoded.overhang_bound};
  const HullOverhangSettings search{.relative = 0, .absolute = 0, .accept = bound, .limit = bound};
  if (overhangOf(field, parts, origin, search, progress) > bound) return "the hulls reach out by more than their bound";
  return provenCovered(mesh, parts, origin, progress) ? "" : "the hulls do not provably cover the surface";
}

}  // namespace spheretree::builder
