// SPDX-License-Identifier: GPL-3.0-or-later
// Renderers side by side: a ball moves along four bodies, with models of several sizes. Compares the time of a step
// with the error of the wrench and with the penetration of the tool. Units: mm, N, us, degrees.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "comparison/cutting.h"
#include "comparison/tool_models.h"
#include "scenarios/stability.h"

namespace spheretree::player {

/// One renderer on one body with models of one size.
struct ComparisonRow {
  Mode mode;
  std::string body;
  bool on_leaves;      // the constrained mode on leaves, without the skin
  std::size_t leaves;  // largest number in the body's tree: 64, 512, 4096; in the constrained mode also 8
  std::size_t bytes;   // size of our compiled scene; the models of the other renderers have the same size
  double step_median, step_p99;
  double penetration;                   // of the ball into the mesh: 99th percentile over the steps in contact
  double force_error, force_error_p99;  // of the force, against the exact solution for a ball: median and 99th percentile
  double angle, angle_p99;              // between the force and the exact one: median and 99th percentile
  double stand_off_p99;                 // distance of the ball's surface from the mesh, outside or inside: 99th percentile
};

/// The position of a ball of radius `radius` that follows a hand and cannot enter a body: the nearest point of the
/// body's offset surface that is reached continuously from the last position. Exact distances; independent of every
/// renderer.
class ExactBall {
 public:
  ExactBall(const builder::DistanceField& field, double radius, const Eigen::Vector3d& start)
      : field_(field), radius_(radius), at_(start) {}
  /// Accurate to about 1e-4 mm where the offset surface is smooth; in the frame of the field.
  const Eigen::Vector3d& follow(const Eigen::Vector3d& hand);

 private:
  Eigen::Vector3d outside(Eigen::Vector3d p) const;
  const builder::DistanceField& field_;
  double radius_;
  Eigen::Vector3d at_;
};

/// Compares all bodies and sizes in each mode, one after the other, since threads would slow each other down. Four
/// bodies: an edge, a groove, a bowl, a molar. @throws builder::Cancelled
std::vector<ComparisonRow> compareRenderers(const ScenarioContext& context, std::span<const Mode> modes, tool::WorkProgress& progress);

/// Writes one page: charts of `rows`, cutting, the scenarios that each renderer passes, all figures.
/// @throws formats::FileError
void writeComparison(const std::filesystem::path& out, std::span<const ComparisonRow> rows, std::span<const CuttingRow> cutting,
                     std::span<const ScenarioResult> scenarios, std::span<const Mode> modes);
/// Writes a page of cutting alone. `edge`: of the voxels [mm]. @throws formats::FileError
void writeCuttingPage(const std::filesystem::path& out, std::span<const CuttingRow> cutting, double edge);
/// Writes a page of models of tools. `depth`: of the hand [mm]. @throws formats::FileError
void writeToolPage(const std::filesystem::path& out, std::span<const ToolRow> rows, double depth);

}  // namespace spheretree::player
