// SPDX-License-Identifier: GPL-3.0-or-later
// The bodies of the stability scenarios: meshes given by formulas, and their trees by our own builder.
// Units: mm. All meshes are closed, oriented outward, manifold, without self-intersections.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
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

/// Rotates the profile (radius, z), given from bottom to top as seen from outside, about the z axis. Its first and last
/// point are on the axis. `around` >= 3.
TriangleMesh lathe(const std::vector<Eigen::Vector2d>& profile, std::uint32_t around);

/// Extrudes the simple polygon in the x, z plane, counter-clockwise seen from -y, from y = -length / 2 to length / 2.
TriangleMesh extrude(const std::vector<Eigen::Vector2d>& polygon, double length);

/// Axis-aligned box between two corners.
TriangleMesh box(const Eigen::Vector3d& low, const Eigen::Vector3d& high);

/// The same surface, subdivided until every edge is at most as long as `longest` allows at its middle [mm] (or exceeds
/// it by less than half, if it was made by a later cut).
TriangleMesh refined(TriangleMesh mesh, const std::function<double(const Eigen::Vector3d&)>& longest);

/// The frame of a body's mesh: a point p of the scenario is scale * (turn * p) there. All bodies of a library have the
/// same scale, and the world of the runtime is additionally rotated by `world`.
struct BodyFrame {
  double scale = 1;
  Quaternion turn{1, 0, 0, 0}, world{1, 0, 0, 0};
};

/// Soft tissue in the form that the runtime takes.
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
  runtime::ContactSurface contact = runtime::ContactSurface::Skin;  // the surface of the body on which the tool rests
  BodyFrame frame{};
  std::optional<SoftPart> soft{};  // empty: rigid
};

struct PlacedBody {
  const Body* body;
  Configuration pose;  // of the mesh frame in the world
};

/// Makes the bodies that scenarios name, and trees of any mesh; the same mesh and settings only once. Each thread needs
/// one of its own: sharing().
class BodyLibrary {
 public:
  /// `cache`: a folder that keeps the trees for later runs; empty: none. Empty the folder when the builder has changed,
  /// since the cache does not detect it.
  BodyLibrary(builder::Quality quality, runtime::ContactSurface contact, builder::Progress& progress, std::filesystem::path cache = {})
      : quality_(quality), contact_(contact), progress_(progress), cache_(std::move(cache)) {}
  /// A library for another thread, without variant, over the same bodies. While one of them builds, the others wait.
  BodyLibrary sharing(builder::Progress& progress) const {
    BodyLibrary other(quality_, contact_, progress, cache_);
    other.made_ = made_;
    return other;
  }

  /// The names, each with its largest number of leaves (8^(levels - 1)) or its tolerance, are in scenario_shapes.cpp;
  /// tooth_11 to tooth_47, lower_jaw and upper_jaw are those of the sample mouth. NAME_work is NAME with at most the
  /// same number of leaves, concentrated where its scenario works.
  /// @throws std::invalid_argument, formats::FileError
  const Body& get(const std::string& name);
  /// A box of soft tissue with Poisson's ratio 0.45 and tetrahedra by formula. "soft_block": 24 x 20 x 12, top at z =
  /// 0, held at the bottom, 15 kPa; "cheek": 30 x 30 x 2, middle at z = 0, held at its rim, 30 kPa.
  /// @throws std::out_of_range for another name
  const Body& getSoft(const std::string& name);
  /// After this call get() and getSoft() rotate each body differently, scale all by the same factor of 0.8 to 1.25, and
  /// build with another seed. 0: unchanged bodies. A ScenarioRun transforms poses and wrenches in both directions, so
  /// that scenarios need no change.
  void setVariant(std::uint64_t variant) { variant_ = variant; }
  /// The unchanged mesh of any of these names.
  static TriangleMesh mesh(const std::string& name);
  builder::Quality quality() const { return quality_; }
  /// Makes a body under a new name; the same name again returns the same body. `frame`: of its mesh.
  const Body& make(const std::string& name, TriangleMesh mesh, const builder::BuildSettings& settings, const BodyFrame& frame = {});
  /// @throws builder::Cancelled, formats::FileError if the cache cannot be written
  const SphereTree& tree(const TriangleMesh& mesh, const builder::BuildSettings& settings);

 private:
  builder::BuildSettings settingsFor(const std::string& name, const TriangleMesh& mesh) const;

  BodyFrame frameOf(const std::string& name) const;

  std::uint64_t variant_ = 0;
  builder::Quality quality_;
  runtime::ContactSurface contact_;
  builder::Progress& progress_;
  std::filesystem::path cache_;
  struct Made {
    std::recursive_mutex mutex;  // get() calls make(), and that calls tree()
    std::map<std::string, std::unique_ptr<Body>> bodies;
    std::map<std::string, SphereTree> trees;  // by the hashes of mesh and settings
  };
  std::shared_ptr<Made> made_ = std::make_shared<Made>();
};

}  // namespace spheretree::player
