// SPDX-License-Identifier: GPL-3.0-or-later
// Spheres that cover the collision shapes of a robot's links, with one tree for each collision element; a sphere of the
// URDF is its own cover, and a capsule is covered by a row of equal balls. Distribution of leaves and proofs:
// docs/robots.md
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "robot/model/link_shape.h"
#include "robot/model/robot_model.h"
#include "robot/model/robot_shapes.h"
#include "spheretree/builder/build_settings.h"
#include "spheretree/builder/progress.h"
#include "spheretree/builder/repair_mesh.h"
#include "spheretree/core/sphere.h"

namespace spheretree::robot {

/// The number of spheres of every link whose name matches the pattern: * is any text, ? any letter.
struct LinkCount {
  std::string pattern;
  std::size_t spheres = 0;  // >= 1
};

/// No sphere of the link extends beyond the plane: all of them lie in axis . p >= value.
struct ClipPlane {
  std::string link;
  Eigen::Vector3d axis;  // in the link's frame, unit length
  double value = 0;      // [mm]
};

struct CoverSettings {
  double tolerance_mm = 0;        // > 0: the smallest number of spheres with at most this overhang; 0: `budget` is used
  std::size_t budget = 0;         // > 0: spheres for all links without a count of their own, distributed for equal error
  std::vector<LinkCount> counts;  // the first match counts
  std::vector<ClipPlane> clips;
  builder::Quality quality = builder::Quality::Standard;
  builder::RepairKind repair = builder::RepairKind::Auto;
  std::uint64_t seed = 1;
  int threads = 0;  // 0: all processors of the machine
};

/// A sphere in metres, in the frame of its link, as it is written. The radii include the rounding errors, so that the
/// spheres of a link cover it both as floats and as the shortest decimals of these floats read in double precision.
using MetreSphere = Sphere;

struct LinkCover {
  std::size_t link = 0;
  std::vector<std::vector<MetreSphere>> levels;  // from the roots of the elements' trees to the leaves; planners get the last level
  std::vector<double> overhang_bounds_mm;        // (levels) proven: no sphere of the level has a larger overhang over its element
  bool is_clipped = false;                       // then the shape is uncovered beyond the plane and near it
  std::vector<std::string> notes;                // repairs, missed tolerances; sentences that name the element
  const std::vector<MetreSphere>& spheres() const { return levels.back(); }
  double overhangBound() const { return overhang_bounds_mm.back(); }  // [mm]
};

struct RobotCover {
  std::vector<LinkCover> links;  // of the links with collision elements, in the order of the robot
  std::size_t sphereCount() const;
  const LinkCover* of(std::size_t link) const;  // null for a link without spheres
};

/// The default budget: 8 spheres for each collision element.
std::size_t usualBudget(const Robot& robot);

/// `shapes`: those of the robot, by readShapes(). Same arguments (except `threads`): same spheres.
/// @throws tool::UsageError, before any work, for settings that do not fit the robot (a budget below one sphere for
/// each element, a pattern or a clip that matches no link with collision elements, a clip that removes a link);
/// builder::BuildError, with the link, for a mesh that is refused; builder::Cancelled.
RobotCover coverRobot(const Robot& robot, std::vector<ShapedElement> shapes, const CoverSettings& settings, builder::Progress& progress);

/// `ball` in metres, rounded outward.
MetreSphere metreSphere(const LinkBall& ball);

/// Back to mm, as a program that reads floats does it.
LinkBall linkBall(const MetreSphere& sphere);

}  // namespace spheretree::robot
