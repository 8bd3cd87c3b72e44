// SPDX-License-Identifier: GPL-3.0-or-later
// Cutting side by side: our constrained mode and voxels (published/voxel_renderer.h) follow the same hand into the same
// objects. Units: mm, N, N mm, us, mm^3.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "bodies/scenario_shapes.h"
#include "cut/cut_volumes.h"
#include "spheretree/formats/trajectory.h"
#include "spheretree/runtime/scene.h"

namespace spheretree::player {

inline constexpr double kVoxelEdge = 0.1;  // of the voxels, unless the user wants others [mm]

/// A scene in which a burr cuts, and the way of the hand.
struct CuttingCourse {
  std::string name;
  runtime::SceneDescription scene;
  formats::Trajectory hand;
};

struct CuttingRow {
  std::string course, renderer;
  double largest_force = 0;                   // on the hand
  double change_largest = 0, change_p99 = 0;  // of the force in a step
  double beyond = 0;                          // largest change less the hand's motion in the step times the stiffness; at least 0
  double removed = 0;                         // as the renderer counts it
  builder::VolumeBounds swept = {};           // what the burr swept of the objects on the way that it was shown, with proven bounds
  double largest_torque = 0;                  // about the reference point
  double time_median = 0, time_p99 = 0;       // processor time of a step
  std::size_t bytes = 0;                      // of scene and material
  std::vector<float> force = {};              // (step) its magnitude
};

/// Courses at a constant feed: down into a block, and along its upper edge into its side, each as fast as a ball of
/// this size can remove voxels, and faster. `half`: of the edges of the block, whose mesh is turned by `turn`, and with
/// it the tool and its way.
std::vector<CuttingCourse> cuttingBench(BodyLibrary& bodies, const Eigen::Vector3d& half = {4, 4, 2},
                                        const Quaternion& turn = {1, 0, 0, 0});

/// Our row, then that of the voxels. Bodies of the scene rest. @throws builder::Cancelled; std::invalid_argument for a
/// scene that does not compile, without anything to cut, or with too many voxels.
std::vector<CuttingRow> compareCutting(const CuttingCourse& course, double edge, builder::Progress& progress);

/// Lines of text.
std::string cuttingTable(std::span<const CuttingRow> rows);
/// Schema spheretree.cutting/1.
nlohmann::ordered_json cuttingJson(std::span<const CuttingRow> rows, double edge);
/// For a page: the force over time, and a table.
std::string cuttingSection(std::span<const CuttingRow> rows);

}  // namespace spheretree::player
