// SPDX-License-Identifier: GPL-3.0-or-later
// The bodies of the stability scenarios: meshes by formula, and their trees by our own builder.
// Units: mm. All meshes are closed, oriented outward, manifold, without self-intersections.
#pragma once

#include <Eigen/Core>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "spheretree/builder/build_sphere_tree.h"
#include "spheretree/builder/distance_field.h"
#include "spheretree/core/sphere_tree.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::player {

/// Turns the profile (radius, z), bottom to top seen from outside, round the z axis. First and last point on the axis. `around` >= 3.
TriangleMesh lathe(const std::vector<Eigen::Vector2d>& profile, std::uint32_t around);

/// Draws the simple polygon of the x, z plane, counter-clockwise seen from -y, from y = -length / 2 to length / 2.
TriangleMesh extrude(const std::vector<Eigen::Vector2d>& polygon, double length);

/// Axis-aligned box between two corners.
TriangleMesh box(const Eigen::Vector3d& low, const Eigen::Vector3d& high);

/// A body with its tree and its exact distance.
struct Body {
  std::string name;
  TriangleMesh mesh;
  SphereTree tree;
  builder::DistanceField field;
  bool bridges = false;  // the runtime fills the pits between its leaves
};

/// Makes the bodies that scenarios ask for by name, each once.
class BodyLibrary {
 public:
  BodyLibrary(builder::Quality quality, bool bridges, builder::Progress& progress)
      : quality_(quality), bridges_(bridges), progress_(progress) {}

  /// Names, with the largest leaf count (8^(levels - 1)) or the tolerance of each: docs/stability.md. @throws std::invalid_argument
  const Body& get(const std::string& name);
  const std::map<std::string, std::unique_ptr<Body>>& all() const { return bodies_; }

 private:
  builder::Quality quality_;
  bool bridges_;
  builder::Progress& progress_;
  std::map<std::string, std::unique_ptr<Body>> bodies_;
};

}  // namespace spheretree::player
