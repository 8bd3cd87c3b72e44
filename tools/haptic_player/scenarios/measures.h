// SPDX-License-Identifier: GPL-3.0-or-later
// What the stability scenarios measure, from the outside: nothing here asks the runtime. Units: mm, N, N mm, rad.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "recording.h"
#include "scenarios/scenario_shapes.h"
#include "spheretree/runtime/scene.h"

namespace spheretree::player {

/// How deep the leaf spheres of the tool are in what they must stay out of, every leaf of it, in double: the leaves of
/// an object, or, of one whose skin is felt, its mesh less what the skin's tolerances allow. Soft
/// tissue, which is elsewhere, is left out. Pairs that are farther apart than the tool can have moved since they were
/// tested are not tested again.
class LeafPenetration {
 public:
  LeafPenetration(const SphereTree& tool, const Eigen::Vector3d& reference_point, std::span<const PlacedBody> objects,
                  runtime::ContactSurface contact);
  /// max(0, -gap), tool at `pose` [mm]. `object`: one of them alone, or all (-1).
  double at(const Configuration& pose, int object = -1);
  void moveObject(std::size_t object, const Eigen::Vector3d& way);

 private:
  struct Ball {
    Eigen::Vector3d centre;
    double radius;
  };
  static std::vector<Ball> leavesOf(const SphereTree& tree, const Configuration& pose);
  struct Object {
    const Body* body;
    Configuration pose;
    bool has_skin;
    std::vector<Ball> balls;  // world
    Ball around;              // encloses them
  };
  struct Pair {
    std::uint32_t object, tool_ball, object_ball;  // kMesh: the mesh in place of a ball
  };
  static constexpr std::uint32_t kMesh = 0xffffffffu;
  double depthIn(const Object& object, const Eigen::Vector3d& centre, double radius) const;
  void listNear(const Configuration& pose);

  std::vector<Ball> tool_;  // about the reference point
  double reach_ = 0;        // of the tool's leaves from the reference point
  std::vector<Object> objects_;
  std::vector<Pair> near_;                  // all that are nearer than kNear at `near_pose_`
  std::optional<Configuration> near_pose_;  // none: the objects have moved
};

/// Deepest penetration of the two meshes: points spread over the tool's surface by their exact signed distance to the
/// objects, and the objects' points by theirs to the tool. Finds what is deeper than about a point spacing; never
/// reports what is not there.
class MeshPenetration {
 public:
  MeshPenetration(const Body& tool, const Eigen::Vector3d& reference_point, std::vector<PlacedBody> objects, double spacing);
  double at(const Configuration& pose) const;
  void moveObject(std::size_t object, const Eigen::Vector3d& way) { objects_[object].pose.position += way; }

 private:
  const Body& tool_;
  Eigen::Vector3d reference_point_;
  std::vector<PlacedBody> objects_;
  std::vector<Eigen::Vector3d> tool_points_;                 // mesh frame
  std::vector<std::vector<Eigen::Vector3d>> object_points_;  // mesh frame
};

/// Points on the surface no farther than `spacing` apart along triangles.
std::vector<Eigen::Vector3d> surfacePoints(const TriangleMesh& mesh, double spacing);

/// Largest |change of wrench| / |motion of the hand| of a step, each in its stiffness metric. At most 1 on a convex
/// body: the projection on a convex set does not expand. Steps whose hand moves less than 1e-9 are left out.
double largestLRatio(std::span<const RecordedStep> rows, const runtime::Coupling& coupling);

/// Largest force step beyond k_t |dx| (and k_r |dtheta| for torque), as a share of what may pass: max(0.1 N, 7 % of the
/// force), max(5 N mm, 13 % of the torque).
double largestForceJump(std::span<const RecordedStep> rows, const runtime::Coupling& coupling);
double largestTorqueJump(std::span<const RecordedStep> rows, const runtime::Coupling& coupling);

/// Exact answers for a ball of radius r whose centre is held outside a body: the point nearest to `haptic` of the
/// body's offset surface.
Eigen::Vector3d offsetEdge(const Eigen::Vector3d& haptic, double r);                       // solid x <= 0 and z <= 0
Eigen::Vector3d offsetGroove(const Eigen::Vector3d& haptic, double r, double half_angle);  // walls meet at x = z = 0, open to +z

}  // namespace spheretree::player
