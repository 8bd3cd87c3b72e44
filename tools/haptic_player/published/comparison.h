// SPDX-License-Identifier: GPL-3.0-or-later
// Renderers side by side: a ball along four bodies, with models of several sizes; time of a step against what is felt
// and against how deep the tool goes in. Units: mm, N, us, degrees.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "scenarios/stability.h"

namespace spheretree::player {

/// One renderer on one body with one size of models.
struct ComparisonRow {
  Mode mode;
  std::string body;
  bool on_leaves;      // the constrained mode, without the skin
  std::size_t leaves;  // at most, of the body's tree: 64, 512, 4096; 8 too in the constrained mode
  std::size_t bytes;   // of our compiled scene; the others' models have the same
  double step_median, step_p99;
  double penetration;                   // of the ball into the mesh, 99th percentile of the steps in contact
  double force_error, force_error_p99;  // against the exact answer for a ball: median and 99th percentile
  double angle, angle_p99;              // of the force off the exact one: median and 99th percentile
  double stand_off_p99;                 // of the ball's surface from the mesh, outside or inside: 99th percentile
};

/// The place of a ball of radius `radius` that follows a hand and cannot enter a body: the nearest point of the body's
/// offset surface that can be reached by going on from the last one. Exact distances; independent of every renderer.
class ExactBall {
 public:
  ExactBall(const builder::DistanceField& field, double radius, const Eigen::Vector3d& start)
      : field_(field), radius_(radius), at_(start) {}
  /// Within about 1e-4 mm where the offset surface is smooth; in the frame of the field.
  const Eigen::Vector3d& follow(const Eigen::Vector3d& hand);

 private:
  Eigen::Vector3d outside(Eigen::Vector3d p) const;
  const builder::DistanceField& field_;
  double radius_;
  Eigen::Vector3d at_;
};

/// All bodies and sizes in each mode. Four bodies: an edge, a groove, a bowl, a molar. @throws builder::Cancelled
std::vector<ComparisonRow> compareRenderers(ScenarioContext& context, std::span<const Mode> modes);

/// One page: charts of `rows`, the scenarios that each renderer holds, all figures. @throws formats::FileError
void writeComparison(const std::filesystem::path& out, std::span<const ComparisonRow> rows, std::span<const ScenarioResult> scenarios,
                     std::span<const Mode> modes);

}  // namespace spheretree::player
