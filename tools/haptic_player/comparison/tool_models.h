// SPDX-License-Identifier: GPL-3.0-or-later
// How much model a tool needs: leaves from 8 to 4,096 and hulls, against the exact answer for the meshes of tool and
// body. Units: mm, N, N mm, us, degrees.
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "bodies/scenario_shapes.h"
#include "comparison/exact_tool.h"
#include "work_progress.h"

namespace spheretree::player {

/// A tool that is drawn over a body, and how.
struct ToolCourse {
  std::string tool, body;
  TriangleMesh tool_mesh, body_mesh;  // the tool's axis is z; the body is touched from above, around its origin
  Eigen::Vector3d reference;          // where the hand holds the tool
  std::vector<Configuration> hand;    // one for each step
};

struct ToolModel {
  std::string name;  // for example "64 leaves", "hulls of 0.03 mm"
  builder::BuildSettings settings;
};

/// One model of a tool on one course; the angle is that of the force off the exact one.
struct ToolRow {
  std::string tool, body, model;
  std::size_t parts = 0;  // leaves, or parts of hulls; 0: the exact answer itself
  double step_median = 0, step_p99 = 0;
  double angle_median = 0, angle_p99 = 0;
  double force_p99 = 0, torque_p99 = 0;         // lengths of the differences from the exact wrench
  double stand_off_p99 = 0;                     // distance of the meshes from each other
  double deepest = 0;                           // penetration of the meshes
  double l_ratio_p99 = 0, l_ratio_largest = 0;  // change of the wrench in a step over the way of the hand, as in F1
};

/// Ball, probe, mirror and burr with its shaft, each on a sphere, over an edge, in a groove, on a molar and on its
/// side, at 10 mm/s with a tremor of 0.05 mm at 9 Hz, `depth` below where the tool would touch. Of the tools those
/// with one of `names`, or all if none has one; the same for the bodies. @throws std::invalid_argument for an unknown
/// name
std::vector<ToolCourse> toolBench(std::span<const std::string> names, double depth, builder::Progress& progress);
/// 8, 64, 512 and 4,096 leaves; hulls with tolerances of 0.1, 0.03 and 0.01 mm.
std::vector<ToolModel> toolModels();

/// The exact answer to a course: a pose for each step.
std::vector<Configuration> exactAnswer(const ToolCourse& course, const runtime::Coupling& coupling, builder::Progress& progress);

/// A row for the exact answer of each course and one for each model. Exact answers are computed on all processors,
/// steps on one, since their times are measured. @throws builder::Cancelled
std::vector<ToolRow> compareTools(std::span<const ToolCourse> courses, std::span<const ToolModel> models, BodyLibrary& bodies,
                                  tool::WorkProgress& progress);

/// Lines of text.
std::string toolTable(std::span<const ToolRow> rows);
/// Schema spheretree.tools/1.
nlohmann::ordered_json toolJson(std::span<const ToolRow> rows);
/// For a page: charts of the figures against the time of a step, and a table.
std::string toolSection(std::span<const ToolRow> rows);

}  // namespace spheretree::player
