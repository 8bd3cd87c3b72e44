// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/comparison/comparison_figures.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "spheretree/formats/errors.h"

namespace spheretree::pipeline {

std::string idOf(const Method& method) { return name(method.builder) + "." + std::string(name(method.quality)); }

LeafFigures leafFigures(const Comparison& comparison, const Run& run) {
  const auto mesh =
      std::find_if(comparison.meshes.begin(), comparison.meshes.end(), [&](const MeshFigures& m) { return m.name == run.mesh; });
  if (mesh == comparison.meshes.end() || run.levels.empty())
    throw formats::FormatError("compare.json: a run names the mesh '" + run.mesh +
                               "', which is not among the meshes, or has no levels. Run spheretree compare again.");
  const builder::LevelEvaluation& leaves = run.levels.back();
  const double percent = 100 / mesh->diagonal_mm;
  return {.processor_seconds = run.processor_seconds,
          .seconds = run.seconds,
          .overhang_percent = leaves.overhang.max * percent,
          .p99_percent = leaves.overhang.p99 * percent,
          .excess_percent = leaves.excess_volume_fraction * 100};
}

std::vector<MeanFigures> geometricMeans(const Comparison& comparison) {
  constexpr double kMin = 1e-9;  // a figure of 0 has no logarithm
  struct Sum {
    Method method;
    LeafFigures logs;
    std::size_t runs;
  };
  constexpr std::array kFields{&LeafFigures::processor_seconds, &LeafFigures::seconds, &LeafFigures::overhang_percent,
                               &LeafFigures::p99_percent, &LeafFigures::excess_percent};
  std::vector<Sum> sums;
  for (const Run& run : comparison.runs) {
    if (!run.isBuilt()) continue;
    const LeafFigures figures = leafFigures(comparison, run);
    auto at = std::find_if(sums.begin(), sums.end(), [&](const Sum& sum) { return sum.method == run.method; });
    if (at == sums.end()) at = sums.insert(at, {run.method, {}, 0});
    for (const auto field : kFields) at->logs.*field += std::log(std::max(figures.*field, kMin));
    ++at->runs;
  }
  std::vector<MeanFigures> means;
  for (const Sum& sum : sums) {
    if (sum.runs != comparison.meshes.size()) continue;
    MeanFigures mean{sum.method, {}};
    for (const auto field : kFields) mean.figures.*field = std::exp(sum.logs.*field / static_cast<double>(sum.runs));
    means.push_back(mean);
  }
  return means;
}

}  // namespace spheretree::pipeline
