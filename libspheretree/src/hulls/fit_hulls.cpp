// SPDX-License-Identifier: GPL-3.0-or-later
#include "hulls/fit_hulls.h"

#include <cstddef>
#include <utility>

#include "hulls/choose_hulls.h"
#include "hulls/collapse_hulls.h"
#include "hulls/hull_complex.h"

namespace spheretree::builder {

namespace {

constexpr std::size_t kMinSamples = 16;  // fewer say nothing of the shape
constexpr std::size_t kHopeless = 2;     // times the allowed number of hulls: so many do not become few enough

// No hulls if too many are needed, or if the solid is nowhere thicker than the tolerance.
ChosenHulls fitOnce(const FitTask& task) {
  const ChosenHulls too_many{}, too_thin{.hulls = {}, .is_thin = true};
  HullComplex complex(task);
  if (complex.samples().size() < kMinSamples || !complex.addFirstBalls()) return too_thin;
  std::vector<Ball> balls = complex.balls();
  for (int round = 1;; ++round) {
    complex.join(balls);
    balls = complex.balls();
    collapseBalls(complex);
    complex.prune();
    if (complex.simplices().size() > kHopeless * task.settings.max_hulls) return too_many;
    if (!complex.addBare() || round == kBareRounds) break;
  }
  complex.allowAll();
  tryCollapses(complex);
  complex.compact();
  ChosenHulls chosen = chooseHulls(complex);
  if (chosen.hulls.size() > task.settings.max_hulls) chosen.hulls.clear();
  return chosen;
}

}  // namespace

std::vector<Hull> fitHulls(const TriangleMesh& mesh, const DistanceField& field, const FitSettings& settings, Progress& progress) {
  // Hulls for a smaller tolerance are within one that is larger than the solid is thick, and may be fewer.
  std::vector<Hull> fewest;
  for (FitSettings tried = settings; tried.accuracy() >= tried.rounding; tried.tolerance /= 2) {
    ChosenHulls fitted = fitOnce(FitTask(mesh, field, tried, progress));
    if (!fitted.hulls.empty() && (fewest.empty() || fitted.hulls.size() < fewest.size())) fewest = std::move(fitted.hulls);
    if (!fitted.is_thin) break;
  }
  return fewest;
}

}  // namespace spheretree::builder
