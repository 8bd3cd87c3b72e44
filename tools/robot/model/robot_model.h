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

#include "robot/model/mesh_search.h"

namespace spheretree::robot {

struct Box {
  Eigen::Vector3d size;  // [mm], >= 0
};
struct Cylinder {
  double radius, length;  // about z, from -length / 2 to length / 2 [mm], >= 0
};
/// All points within `radius` of a segment of z from -length / 2 to length / 2; a ball has length 0.
struct Capsule {
  double radius, length;  // [mm], >= 0
};
struct MeshFile {
  std::string name;            // as written in the URDF
  std::filesystem::path path;  // the file that was found; empty if the URDF names none
  Eigen::Vector3d scale;       // of the coordinates in the file, which are then in metres
};
/// An empty <geometry>.
struct NoShape {};

struct CollisionElement {
  std::string name;                                          // may be empty
  std::string place;                                         // of its shape, for messages: "FILE:LINE: <box> of link NAME"
  Eigen::Isometry3d origin = Eigen::Isometry3d::Identity();  // of the shape in the link [mm]
  std::variant<NoShape, Box, Cylinder, Capsule, MeshFile> shape;
};

struct Inertia {
  double mass = 0;                                           // [kg]
  Eigen::Isometry3d origin = Eigen::Isometry3d::Identity();  // of the principal frame's origin in the link [mm]
  Eigen::Matrix3d tensor = Eigen::Matrix3d::Zero();          // about that origin [kg m^2]
};

struct Link {
  std::string name;
  std::string place;  // for messages: "FILE:LINE: link NAME"
  std::vector<CollisionElement> collisions;
  std::optional<Inertia> inertia;
};

enum class JointKind { Fixed, Revolute, Continuous, Prismatic, Floating, Planar };

/// The joint that this one follows: the position is `factor` times that of the other joint, plus `offset`.
struct Mimic {
  std::size_t joint = 0;  // which mimics no other
  double factor = 1, offset = 0;
};

struct Joint {
  std::string name;
  std::string place;  // for messages: "FILE:LINE: joint NAME (link CHILD)"
  JointKind kind = JointKind::Fixed;
  std::size_t parent = 0, child = 0;                         // links
  Eigen::Isometry3d origin = Eigen::Isometry3d::Identity();  // of the child's frame in the parent's, at position 0 [mm]
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();           // in the child's frame, unit length
  double lower = 0, upper = 0;                               // of Revolute [rad] and Prismatic [mm]; lower <= upper
  std::optional<Mimic> mimic;
};

enum class ShapeSource { Collision, Visual };

/// The unit of the numbers in the mesh files of every link whose name matches the pattern: * is any text, ? any letter.
struct LinkUnit {
  std::string pattern;
  double unit_mm = 1000;
};

struct Robot {
  std::string name;
  std::filesystem::path path;                            // of the URDF
  std::vector<Link> links;                               // in the order of the file
  std::vector<Joint> joints;                             // likewise; a tree
  std::size_t root = 0;                                  // link without a parent
  std::vector<std::optional<std::size_t>> parent_joint;  // of each link; empty for the root
  ShapeSource source = ShapeSource::Collision;           // the elements that `collisions` were read from
  PackagePaths packages;                                 // where packages were searched
  std::vector<LinkUnit> units;                           // of its mesh files, as readShapes() was told
  std::vector<std::string> notes;                        // what is unusual in the file, in sentences that name the place
  std::size_t links_with_other_shapes = 0;               // with a <visual> if <collision> was read, or the other way round
};

/// Checks everything that is used: unique names, a tree of links, finite numbers, existing mesh files. What the type of
/// a joint does not have (the axis of a fixed joint) is ignored, as are transmissions, unknown elements, and the shapes
/// that are not asked for.
/// @throws formats::FileError if the file, or a mesh that it names, cannot be found; formats::FormatError with the
/// place otherwise, also for xacro, which has to be expanded first.
Robot readUrdf(const std::filesystem::path& path, const PackagePaths& packages = {}, ShapeSource source = ShapeSource::Collision);

/// The frame of `joint`'s child in its parent's, at `position` [rad or mm].
Eigen::Isometry3d jointFrame(const Joint& joint, double position);

/// (links) The frame of each link in that of the root while every joint is at position 0, or at the offset of its
/// mimic.
std::vector<Eigen::Isometry3d> zeroPose(const Robot& robot);

}  // namespace spheretree::robot
