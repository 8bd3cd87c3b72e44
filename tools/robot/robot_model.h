// SPDX-License-Identifier: GPL-3.0-or-later
// The model of a robot in a URDF: links with collision shapes, and the joints between them.
// Units: mm, rad. A URDF is in metres; lengths are multiplied by 1000 when they are read.
// Format: http://wiki.ros.org/urdf/XML
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace spheretree::robot {

struct Box {
  Eigen::Vector3d size;  // [mm], > 0
};
struct Cylinder {
  double radius, length;  // about z, from -length / 2 to length / 2 [mm], > 0
};
struct Ball {
  double radius;  // [mm], > 0
};
struct MeshFile {
  std::string name;            // as written in the URDF
  std::filesystem::path path;  // the file that was found
  Eigen::Vector3d scale;       // of the coordinates in the file, which are then in metres; not 0
};

struct CollisionElement {
  std::string name;                                          // may be empty
  Eigen::Isometry3d origin = Eigen::Isometry3d::Identity();  // of the shape in the link [mm]
  std::variant<Box, Cylinder, Ball, MeshFile> shape;
};

struct Inertia {
  double mass = 0;                                           // [kg]
  Eigen::Isometry3d origin = Eigen::Isometry3d::Identity();  // of the principal frame's origin in the link [mm]
  Eigen::Matrix3d tensor = Eigen::Matrix3d::Zero();          // about that origin [kg m^2]
};

struct Link {
  std::string name;
  std::vector<CollisionElement> collisions;
  std::optional<Inertia> inertia;
};

enum class JointKind { Fixed, Revolute, Continuous, Prismatic, Floating, Planar };

/// The joint that this one follows: the position is `factor` times that of the other joint, plus `offset`.
struct Mimic {
  std::string joint;
  double factor = 1, offset = 0;
};

struct Joint {
  std::string name;
  JointKind kind = JointKind::Fixed;
  std::size_t parent = 0, child = 0;                         // links
  Eigen::Isometry3d origin = Eigen::Isometry3d::Identity();  // of the child's frame in the parent's, at position 0 [mm]
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();           // in the child's frame, unit length
  double lower = 0, upper = 0;                               // of Revolute [rad] and Prismatic [mm]
  double velocity = 0, effort = 0;                           // limits; [rad/s] or [mm/s], [N m] or [N]; 0: not given
  std::optional<Mimic> mimic;
};

struct Robot {
  std::string name;
  std::filesystem::path path;                            // of the URDF
  std::vector<Link> links;                               // in the order of the file
  std::vector<Joint> joints;                             // likewise; a tree
  std::size_t root = 0;                                  // link without a parent
  std::vector<std::optional<std::size_t>> parent_joint;  // of each link; empty for the root

  /// @throws std::out_of_range
  std::size_t linkNamed(const std::string& name) const;
  bool moves(const Joint& joint) const { return joint.kind != JointKind::Fixed; }
};

/// Search path of `package://PACKAGE/PATH`: PATH in each of these folders that is named PACKAGE or contains a folder
/// PACKAGE, then in the folders above the URDF, then below ROS_PACKAGE_PATH. `file://` and plain paths are relative to
/// the URDF.
struct PackagePaths {
  std::vector<std::filesystem::path> folders;
};

/// Checks everything that is used: unique names, a tree of links, finite numbers, sizes above 0, existing mesh files.
/// Ignores unused elements (visuals, transmissions, unknown elements).
/// @throws formats::FileError if the file, or a mesh that it names, cannot be found; formats::FormatError with the
/// element and its line otherwise, also for xacro, which has to be expanded first.
Robot readUrdf(const std::filesystem::path& path, const PackagePaths& packages = {});

/// The frame of `joint`'s child in its parent's, at `position` [rad or mm].
Eigen::Isometry3d jointFrame(const Joint& joint, double position);

/// Frames of all links in the root's frame, at joint positions (joints); the entries of mimicking joints are ignored.
/// Floating and planar joints stay at 0.
std::vector<Eigen::Isometry3d> linkFrames(const Robot& robot, const std::vector<double>& positions);

}  // namespace spheretree::robot
