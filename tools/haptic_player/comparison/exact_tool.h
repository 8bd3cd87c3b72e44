// SPDX-License-Identifier: GPL-3.0-or-later
// The pose of a rigid tool that follows a hand and cannot enter a body, by the meshes of both: what every renderer
// should come to. It uses no sphere, no skin and no code of the runtime, and takes its time: milliseconds for a step.
//
// Points of each surface, a small spacing apart, have exact distances from the other surface. Among the poses without
// penetration that are reached continuously from the last one, the energy of the coupling is least: in small moves,
// each the solution of a least distance problem with the linearised gaps as its rows.
// Paper: C. L. Lawson, R. J. Hanson. Solving least squares problems. 1974, chapter 23 (NNLS, LDP).
// Units: mm, N, rad; frame: that of the body's mesh.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "geometry/distance_field.h"
#include "spheretree/core/rigid.h"
#include "spheretree/core/triangle_mesh.h"
#include "spheretree/runtime/scene.h"

namespace spheretree::player {

inline double degreesBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) * 180 / std::numbers::pi;
}

using Scaled = Eigen::Vector<double, 6>;  // translation, rotation times a length [mm]

/// A closed mesh with points of its surface, vertices and edges first: about `spacing` apart, and not much closer.
struct SampledSolid {
  SampledSolid(const TriangleMesh& mesh, double spacing);

  builder::DistanceField field;
  std::vector<Eigen::Vector3d> points;
};

/// Where two surfaces are near each other.
struct NearPlace {
  Eigen::Vector3d point;   // of the tool, or of the body
  Eigen::Vector3d normal;  // unit, from body to tool
  double gap;              // distance of the surfaces there, negative where one is in the other [mm]
};

/// The places where a tool that moves is near a body. Points that are farther away wait until the tool has moved far
/// enough.
class ToolGaps {
 public:
  /// `reference`: the point of the tool's mesh that a pose places. Both solids must outlive the object.
  ToolGaps(const SampledSolid& tool, const SampledSolid& body, const Eigen::Vector3d& reference);

  /// All places with a gap of at most `margin`; valid until the next call.
  std::span<const NearPlace> near(const Configuration& pose, double margin);
  /// The smallest gap at a pose, at most `margin`.
  double smallest(const Configuration& pose, double margin);
  double reach() const { return reach_; }  // of the tool, from its reference point

 private:
  const SampledSolid& tool_;
  const SampledSolid& body_;
  const Eigen::Vector3d reference_;
  double reach_ = 0, travelled_ = 0;  // largest motion of a point of the tool so far
  std::optional<Configuration> last_;
  std::vector<double> reached_;  // (point of the tool, then of the body) may touch when so much is travelled, not before
  std::vector<NearPlace> places_;
};

/// The vector nearest to `target` with a . y >= b for each row (a, b); nothing if the rows contradict each other.
std::optional<Scaled> nearestWithin(std::span<const std::pair<Scaled, double>> rows, const Scaled& target);

class ExactTool {
 public:
  ExactTool(const SampledSolid& tool, const SampledSolid& body, const Eigen::Vector3d& reference, const runtime::Coupling& coupling,
            const Configuration& start);
  /// The pose for this one of the hand. Rests kExactGap off the body.
  const Configuration& follow(const Configuration& hand);

 private:
  std::optional<Configuration> moveBy(const Scaled& way, double longest, double& moved);

  ToolGaps gaps_;
  const double angle_length_;  // a rotation counts by so much [mm]
  Configuration at_;
};

inline constexpr double kExactGap = 1e-3;  // so that the direction between the surfaces is always known [mm]

}  // namespace spheretree::player
