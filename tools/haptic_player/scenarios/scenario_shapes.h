// SPDX-License-Identifier: GPL-3.0-or-later
// The bodies of the stability scenarios: meshes by formula, and their trees by our own builder.
// Units: mm. All meshes are closed, oriented outward, manifold, without self-intersections.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "geometry/distance_field.h"
#include "spheretree/builder/build_sphere_tree.h"
#include "spheretree/core/rigid.h"
#include "spheretree/core/sphere_tree.h"
#include "spheretree/core/triangle_mesh.h"
#include "spheretree/runtime/scene.h"

namespace spheretree::player {

/// Turns the profile (radius, z), bottom to top seen from outside, round the z axis. First and last point on the axis.
/// `around` >= 3.
TriangleMesh lathe(const std::vector<Eigen::Vector2d>& profile, std::uint32_t around);

/// Draws the simple polygon of the x, z plane, counter-clockwise seen from -y, from y = -length / 2 to length / 2.
TriangleMesh extrude(const std::vector<Eigen::Vector2d>& polygon, double length);

/// Axis-aligned box between two corners.
TriangleMesh box(const Eigen::Vector3d& low, const Eigen::Vector3d& high);

/// The same surface, cut until no edge is longer than `longest` says of its middle [mm] (or one that was cut later by
/// less than half).
TriangleMesh refined(TriangleMesh mesh, const std::function<double(const Eigen::Vector3d&)>& longest);

/// The frame of a body's mesh: a point p of its scenario is scale * (turn * p) there. All bodies of a library have one
/// scale, and the world of the runtime is turned as a whole, too: by `world`.
struct BodyFrame {
  double scale = 1;
  Quaternion turn{1, 0, 0, 0}, world{1, 0, 0, 0};
};

/// Soft tissue as the runtime takes it.
struct SoftPart {
  runtime::SharedTree tree;
  std::shared_ptr<const runtime::TissueModel> model;
};

/// A body with its tree and its exact distance.
struct Body {
  std::string name;
  TriangleMesh mesh;
  SphereTree tree;
  builder::DistanceField field;
  runtime::ContactSurface contact = runtime::ContactSurface::Skin;  // what is felt of it
  BodyFrame frame{};
  std::optional<SoftPart> soft{};  // none: rigid
};

struct PlacedBody {
  const Body* body;
  Configuration pose;  // of the mesh frame in the world
};

/// Makes the bodies that scenarios ask for by name, and trees of any mesh; the same mesh and settings only once.
class BodyLibrary {
 public:
  /// `cache`: a folder that keeps the trees for later runs; empty: none. It does not notice that the builder changed:
  /// empty it then.
  BodyLibrary(builder::Quality quality, runtime::ContactSurface contact, builder::Progress& progress, std::filesystem::path cache = {})
      : quality_(quality), contact_(contact), progress_(progress), cache_(std::move(cache)) {}

  /// Names, with the largest leaf count (8^(levels - 1)) or the tolerance of each: scenario_shapes.cpp; tooth_11 to
  /// tooth_47, lower_jaw and upper_jaw are those of the sample mouth. NAME_work is NAME with as many leaves at most,
  /// spent where its scenario works.
  /// @throws std::invalid_argument, formats::FileError
  const Body& get(const std::string& name);
  /// A box of soft tissue, Poisson's ratio 0.45, tetrahedra by formula. "soft_block": 24 x 20 x 12, its top at z = 0,
  /// held below, 15 kPa; "cheek": 30 x 30 x 2, its middle at z = 0, held at its rim, 30 kPa.
  /// @throws std::out_of_range for another name
  const Body& getSoft(const std::string& name);
  /// From now on get() and getSoft() make every body turned, each its own way, all scaled by the same 0.8 to 1.25, and
  /// with another seed. 0: as they were written. A ScenarioRun takes poses and wrenches there and back, so that a
  /// scenario does not notice.
  void setVariant(std::uint64_t variant) { variant_ = variant; }
  /// The mesh alone, of any of these names, as it was written.
  static TriangleMesh mesh(const std::string& name);
  builder::Quality quality() const { return quality_; }
  /// A body of its own under a name that is not taken; the same name again is the same body. `frame`: of its mesh.
  const Body& make(const std::string& name, TriangleMesh mesh, const builder::BuildSettings& settings, const BodyFrame& frame = {});
  /// @throws builder::Cancelled, formats::FileError if the cache cannot be written
  const SphereTree& tree(const TriangleMesh& mesh, const builder::BuildSettings& settings);
  /// What is said to be going on again once a tree is built.
  void setStage(std::string stage) { stage_ = std::move(stage); }

 private:
  builder::BuildSettings settingsFor(const std::string& name, const TriangleMesh& mesh) const;

  BodyFrame frameOf(const std::string& name) const;

  std::uint64_t variant_ = 0;
  builder::Quality quality_;
  runtime::ContactSurface contact_;
  builder::Progress& progress_;
  std::filesystem::path cache_;
  std::string stage_;
  std::map<std::string, std::unique_ptr<Body>> bodies_;
  std::map<std::string, SphereTree> trees_;  // by hashes of mesh and settings
};

}  // namespace spheretree::player
