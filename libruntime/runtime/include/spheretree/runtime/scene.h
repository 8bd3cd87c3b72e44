// SPDX-License-Identifier: Apache-2.0
// A scene: the tool, the objects in their places, stiffness and limits. It is described first and compiled once; steps
// only read it.
// Units: mm, N, N mm, rad.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "spheretree/core/rigid.h"
#include "spheretree/core/sphere_tree.h"
#include "spheretree/core/tissue.h"

namespace spheretree::runtime {

/// The spring, and the damper beside it, between haptic and graphic tool, and the mass of the latter. Stiffness > 0,
/// damping and mass >= 0; the mode of the paper has the spring alone.
struct Coupling {
  double translation = 1;       // [N/mm]
  double rotation = 1000;       // [N mm/rad]
  double damping = 0;           // [N s/mm]
  double rotation_damping = 0;  // [N mm s/rad]
  double mass = 0;              // at the reference point [kg]
  double inertia = 0;           // about it, the same for all axes [kg mm^2]
};

/// Largest wrench that is rendered; all > 0.
struct WrenchLimits {
  double force = 8;                      // of the vector [N]
  Eigen::Vector3d torque{188, 188, 48};  // of each component, world axes [N mm]
};

/// What one step may cost. Both are counts, not clock time, so that a step is the same on every machine.
struct StepLimits {
  std::uint32_t max_pairs = 8192;    // pairs at a time; 64 for each object .. 2^20
  std::uint32_t max_work = 100'000;  // 8-lane tests and groups of 8 rows (about 3 ns each) in a step; 1'000 .. 2^30
};

/// The defaults, with as many pairs as this number of objects needs.
inline StepLimits defaultLimits(std::size_t object_count) {
  StepLimits limits;
  limits.max_pairs = std::max(limits.max_pairs, 64 * static_cast<std::uint32_t>(object_count));
  return limits;
}

/// What the tool rests on in the constrained mode.
enum class ContactSurface : std::uint8_t {
  Skin,    // the skin of each object that has one, else its leaves
  Leaves,  // the leaf spheres of every object
};

/// A sphere-tree that any number of objects share. Never null.
class SharedTree {
 public:
  SharedTree() : tree_(std::make_shared<const SphereTree>()) {}
  SharedTree(SphereTree tree) : tree_(std::make_shared<const SphereTree>(std::move(tree))) {}  // NOLINT: a tree is one
  /// Of a tree that decodeSphereTree() read, or in which findFault() found nothing: compileScene() does not check it
  /// again.
  static SharedTree sound(SphereTree tree) {
    SharedTree shared(std::move(tree));
    shared.is_sound_ = true;
    return shared;
  }
  bool isSound() const { return is_sound_; }
  const SphereTree& operator*() const { return *tree_; }
  const SphereTree* operator->() const { return tree_.get(); }

 private:
  std::shared_ptr<const SphereTree> tree_;
  bool is_sound_ = false;  // known to be
};

struct TissueModel;

/// The soft tissue of `tree`, as they come out of a .soft file (core's decodeSoftTree), for objects of a scene. Null
/// with a sentence in `fault` if it is unsound, of another tree, or has no response. Not in the shared library for
/// other languages.
std::shared_ptr<const TissueModel> tissueModel(const SharedTree& tree, std::shared_ptr<const Tissue> tissue, std::string& fault);

struct SceneObject {
  SharedTree tree;         // copies of one SharedTree are checked, compiled and stored once
  Configuration pose;      // of the tree's mesh frame in the world when the scene starts
  std::uint32_t body = 0;  // what it belongs to, 0..kMostBodies; 0: the world, which stands still. moveBody() moves the others
  double friction = 0;     // Coulomb's coefficient, 0 .. 2; the larger of the object's and the tool's counts
  double stiffness = 0;    // against force, > 0 [N/mm]; 0: rigid
  std::shared_ptr<const TissueModel> tissue = nullptr;  // of this tree: it gives way where it is pressed; null: it does not
};

inline constexpr std::uint32_t kMostBodies = 4096;

struct SceneDescription {
  SphereTree tool;
  Eigen::Vector3d reference_point = Eigen::Vector3d::Zero();  // in the mesh frame of the tool [mm]
  double tool_friction = 0;                                   // Coulomb's coefficient, 0 .. 2
  std::vector<SceneObject> objects;
  Coupling coupling;
  WrenchLimits wrench_limits;
  StepLimits step_limits;
  ContactSurface contact = ContactSurface::Skin;
  double step_time = 0.001;  // from one step to the next, 1e-5 .. 1 [s]; what velocities need
};

struct CompiledScene;

/// A compiled scene, which does not change. Empty until compileScene() fills it.
class Scene {
 public:
  Scene();
  explicit Scene(std::unique_ptr<const CompiledScene> compiled);
  ~Scene();
  Scene(Scene&&) noexcept;
  Scene& operator=(Scene&&) noexcept;

  std::size_t objectCount() const;
  std::size_t bodyCount() const;  // with the world: one more than the highest body of an object
  /// What the object is made of; null: it is rigid.
  const Tissue* tissue(std::size_t object) const;
  const Coupling& coupling() const;
  const WrenchLimits& wrenchLimits() const;
  const StepLimits& stepLimits() const;
  /// Memory that the compiled scene holds [bytes].
  std::size_t byteCount() const;

  const CompiledScene& compiled() const { return *compiled_; }  // for the library's own parts

 private:
  std::unique_ptr<const CompiledScene> compiled_;
};

/// Checks the description and compiles it. False with a sentence in `fault` (which part, what, what to do) if a tree is
/// unsound (findFault), a pose is not finite, or a limit is out of range; `scene` is then unchanged.
/// Cost: O(spheres + triangles of the skins), about 0.3 ms for 512 leaves with a skin of 4,000 triangles; copies of an
/// object cost nothing but their place. Allocates all that the scene will ever hold.
[[nodiscard]] bool compileScene(const SceneDescription& description, Scene& scene, std::string& fault);

}  // namespace spheretree::runtime
