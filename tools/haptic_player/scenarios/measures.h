// SPDX-License-Identifier: GPL-3.0-or-later
// The measures of the stability scenarios. They are external: nothing here uses results of the runtime. Units: mm, N, N
// mm, rad.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "bodies/scenario_shapes.h"
#include "cut/swept_burr.h"
#include "published/ball_tree.h"
#include "run/recording.h"
#include "spheretree/runtime/scene.h"

namespace spheretree::player {

/// The depth of the tool's leaf spheres, all of them and in double, in what they must stay out of: the leaves of an
/// object or, if the tool rests on its skin, its mesh less the tolerances of the skin. Soft tissue is left out, because
/// it moves. Pairs that are farther apart than the tool can have moved since their last test are not tested again.
class LeafPenetration {
 public:
  LeafPenetration(const SphereTree& tool, const Eigen::Vector3d& reference_point, std::span<const PlacedBody> objects,
                  runtime::ContactSurface contact);
  /// max(0, -gap) with the tool at `pose` [mm]. `object`: index of a single object, or -1 for all.
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
    std::vector<Ball> balls;  // world frame
    Ball around;              // encloses all of them
  };
  struct Pair {
    std::uint32_t object, tool_ball, object_ball;  // kMesh: the mesh instead of a ball
  };
  static constexpr std::uint32_t kMesh = 0xffffffffu;
  double depthIn(const Object& object, const Eigen::Vector3d& centre, double radius) const;
  void listNear(const Configuration& pose);

  std::vector<Ball> tool_;  // relative to the reference point
  double reach_ = 0;        // largest distance of the tool's leaves from the reference point
  std::vector<Object> objects_;
  std::vector<Pair> near_;                  // all pairs nearer than kNear at `near_pose_`
  std::optional<Configuration> near_pose_;  // empty: the objects have moved
};

/// Deepest penetration of the two meshes: points spread over the tool's surface, by their exact signed distance to the
/// objects, and points of the objects by theirs to the tool. It detects penetrations deeper than about the point
/// spacing, and never reports one that does not exist.
class MeshPenetration {
 public:
  MeshPenetration(const Body& tool, const Eigen::Vector3d& reference_point, std::vector<PlacedBody> objects, double spacing);
  double at(const Configuration& pose) const;
  void moveObject(std::size_t object, const Eigen::Vector3d& way) { objects_[object].pose.position += way; }

 private:
  const Body& tool_;
  Eigen::Vector3d reference_point_;
  std::vector<PlacedBody> objects_;
  struct Points {  // of a surface, in its mesh frame
    std::vector<Eigen::Vector3d> places;
    BallTree tree{places, {}};
    explicit Points(std::vector<Eigen::Vector3d> p) : places(std::move(p)) {}
  };
  Points tool_points_;
  std::vector<Points> object_points_;
};

/// What the burr of a tool has left of a body: its mesh less the capsules that the burr has swept. And how deep the
/// parts of the tool that do not cut are in it.
class CutPenetration {
 public:
  /// `burr`: in the mesh frame of the tool, relative to the reference point; the axis of the tool begins in its first
  /// ball. The object does not move.
  CutPenetration(const Body& tool, const Eigen::Vector3d& reference_point, const PlacedBody& object, std::vector<Ball> burr);
  /// The tool moves to `pose`, the first one without a way. The burr cuts on this way, or is as firm as the rest.
  void moveTo(const Configuration& pose, bool cuts);
  /// Of the deepest leaf that is not of the burr, and of the burr if it did not cut on the last way [mm].
  double depth() const;
  /// Ways on which a point of the tool's axis was in the material.
  int passages() const { return passages_; }
  /// Of a point from the surface of what is left, positive inside [mm]. Frame: mesh of the object. Outside, no point of
  /// the material is nearer than its magnitude.
  double depthAt(const Eigen::Vector3d& point) const;

 private:
  /// The last capsule of a ball, which continues as long as its steps are in a line.
  struct Growing {
    std::size_t capsule = 0;
    std::vector<Eigen::Vector3d> centres;  // of its steps
  };
  void sweep(std::size_t ball, const Eigen::Vector3d& from, const Eigen::Vector3d& to);
  bool isAxisInside(const Configuration& pose) const;
  double depthOf(const Eigen::Vector3d& centre, double radius) const;

  const builder::DistanceField& field_;
  Configuration place_;     // of the object
  std::vector<Ball> firm_;  // leaves that are not of the burr, relative to the reference point
  std::vector<Ball> burr_;
  Eigen::Vector3d along_;  // axis of the tool
  double length_;          // of the axis, from the middle of the burr
  std::vector<builder::Capsule> capsules_;
  std::vector<Growing> growing_;       // (ball)
  std::optional<Configuration> pose_;  // in the frame of the object
  bool cuts_ = false;
  int passages_ = 0;
};

/// Points on the surface, at most `spacing` apart along triangles.
std::vector<Eigen::Vector3d> surfacePoints(const TriangleMesh& mesh, double spacing);

/// Largest |change of wrench| / |motion of the hand| in a step, each in its stiffness metric. It is at most 1 on a
/// convex body, since the projection on a convex set is non-expansive. Steps in which the hand moves by less than 1e-9
/// are left out.
double largestLRatio(std::span<const RecordedStep> rows, const runtime::Coupling& coupling);

/// Largest force step in excess of k_t |dx| (for torque k_r |dtheta|), divided by the pass limit: max(0.1 N, 7 % of the
/// force), for torque max(5 N mm, 13 % of the torque).
double largestForceJump(std::span<const RecordedStep> rows, const runtime::Coupling& coupling);
double largestTorqueJump(std::span<const RecordedStep> rows, const runtime::Coupling& coupling);

/// Exact solutions for a ball of radius r that is held outside a body: the point of the body's offset surface nearest
/// to `haptic`.
Eigen::Vector3d offsetEdge(const Eigen::Vector3d& haptic, double r);                       // solid x <= 0 and z <= 0
Eigen::Vector3d offsetGroove(const Eigen::Vector3d& haptic, double r, double half_angle);  // walls meet at x = z = 0, open to +z

}  // namespace spheretree::player
