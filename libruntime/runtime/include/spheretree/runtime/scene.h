// SPDX-License-Identifier: Apache-2.0
// A scene: the tool, the objects and their poses, stiffness and limits. It is described first and compiled once; after
// that, steps only read it.
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
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::runtime {

/// The spring and damper between haptic tool and graphic tool, and the mass of the graphic tool. Stiffness > 0, damping
/// and mass >= 0. The mode of the paper uses the spring alone.
struct Coupling {
  double translation = 1;       // [N/mm]
  double rotation = 1000;       // [N mm/rad]
  double damping = 0;           // [N s/mm]
  double rotation_damping = 0;  // [N mm s/rad]
  double mass = 0;              // at the reference point of the graphic tool [kg]
  double inertia = 0;           // about the reference point, the same for all axes [kg mm^2]
};

/// The largest wrench that is rendered; all values > 0.
struct WrenchLimits {
  double force = 8;                      // magnitude of the force [N]
  Eigen::Vector3d torque{188, 188, 48};  // magnitude of each component, world axes [N mm]
};

/// The largest cost of one step. Both limits are counts, not clock time, so that a step is the same on every machine.
struct StepLimits {
  std::uint32_t max_pairs = 8192;    // pairs in the list at any time; 64 for each object .. 2^20
  std::uint32_t max_work = 100'000;  // 8-lane tests and groups of 8 rows (about 8 ns each) in a step; 1'000 .. 2^30
};

/// The default limits, with max_pairs raised to what this number of objects needs.
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

/// A sphere-tree that any number of objects can share. Never null.
class SharedTree {
 public:
  SharedTree() : tree_(std::make_shared<const SphereTree>()) {}
  SharedTree(SphereTree tree) : tree_(std::make_shared<const SphereTree>(std::move(tree))) {}  // NOLINT: converts implicitly from a tree
  /// For a tree that decodeSphereTree() read, or in which findFault() found nothing: compileScene() does not check it
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
  bool is_sound_ = false;  // known to be sound
};

struct TissueModel;

/// The soft tissue of `tree`, both as decodeSoftTree() of core read them from a .soft file, for objects of a scene.
/// Returns null, with a sentence in `fault`, if the tissue is unsound, belongs to another tree, or has no response. The
/// shared library for other languages does not contain this function.
std::shared_ptr<const TissueModel> tissueModel(const SharedTree& tree, std::shared_ptr<const Tissue> tissue, std::string& fault);

/// A layer within an object that a burr cuts.
struct CutLayer {
  std::shared_ptr<const TriangleMesh> surface;  // closed, in the frame of the object's mesh; 1 .. 32768 triangles
  double removal = 1;                           // as in CutMaterial
};

/// How an object yields to a burr, as a volume for each unit of force and time (Preston's law): a ball of radius r
/// removes pi r^2 times this. docs/algorithms/runtime/cutting.md
struct CutMaterial {
  double removal = 1;           // of the outermost layer, 1e-3 .. 1e3 [mm/(N s)]
  std::vector<CutLayer> inner;  // each within the one before it, kMaxCutLayers - 1 at most
  double tangential = 0;        // force across the normal that the turning burr meets, as a share of the force along it, 0 .. 2
};

inline constexpr std::size_t kMaxCutLayers = 16;  // of an object, with the outermost

struct CutModel;

/// The material of `tree` for objects of a scene. Returns null, with a sentence in `fault`, if the tree has no skin, a
/// layer has no sound surface, or a value is out of range.
std::shared_ptr<const CutModel> cutModel(const SharedTree& tree, CutMaterial material, std::string& fault);

struct SceneObject {
  SharedTree tree;         // copies of one SharedTree are checked, compiled and stored once
  Configuration pose;      // of the tree's mesh frame in the world when the scene starts
  std::uint32_t body = 0;  // body that it belongs to, 0..kMaxBodies; 0: the world, which does not move. moveBody() moves the other bodies
  double friction = 0;     // Coulomb's coefficient, 0 .. 2; a contact uses the larger of the object's and the tool's
  double stiffness = 0;    // against force, > 0 [N/mm]; 0: rigid
  std::shared_ptr<const TissueModel> tissue = nullptr;  // of this tree: the object deforms where it is pressed; null: it does not deform
  std::shared_ptr<const CutModel> cut = nullptr;        // of this tree: the burr of the tool removes it; null: no burr does
};

inline constexpr std::uint32_t kMaxBodies = 4096;

struct SceneDescription {
  SphereTree tool;
  Eigen::Vector3d reference_point = Eigen::Vector3d::Zero();  // in the mesh frame of the tool [mm]
  double tool_friction = 0;                                   // Coulomb's coefficient, 0 .. 2
  std::vector<SceneObject> objects;
  Coupling coupling;
  WrenchLimits wrench_limits;
  StepLimits step_limits;
  ContactSurface contact = ContactSurface::Skin;
  std::vector<Ball> burr;  // of the tool, in its mesh frame, 32 at most, 0.1 .. 10 mm: they cut while the spindle turns
  Eigen::Vector3d spindle_axis = Eigen::Vector3d::UnitZ();  // about which the burr turns by the right hand, mesh frame of the tool
  double step_time = 0.001;                                 // from one step to the next, 1e-5 .. 1 [s]; velocities are computed with it
};

struct CompiledScene;

/// A compiled scene, which does not change. Empty until compileScene() fills it.
class Scene {
 public:
  Scene();
  explicit Scene(std::unique_ptr<CompiledScene> compiled);
  ~Scene();
  Scene(Scene&&) noexcept;
  Scene& operator=(Scene&&) noexcept;

  std::size_t objectCount() const;
  std::size_t bodyCount() const;  // including the world: one more than the highest body of an object
  /// The tissue of an object; null if it is rigid.
  const Tissue* tissue(std::size_t object) const;
  /// The number of layers of an object that a burr cuts, with the outermost; 0: no burr cuts it.
  std::size_t cutLayers(std::size_t object) const;
  const Coupling& coupling() const;
  const WrenchLimits& wrenchLimits() const;
  const StepLimits& stepLimits() const;
  /// Memory of the compiled scene [bytes].
  std::size_t byteCount() const;

  // For the library's own parts; changes only between steps.
  const CompiledScene& compiled() const { return *compiled_; }
  CompiledScene& compiled() { return *compiled_; }

 private:
  std::unique_ptr<CompiledScene> compiled_;
};

/// Checks the description and compiles it. Returns false if a tree is unsound (findFault), a pose is not finite, or a
/// limit is out of range; `fault` is then a sentence (which share, what is wrong, what to do) and `scene` is unchanged.
/// Allocates all memory that the scene needs. Cost: O(spheres + triangles of the skins), about 0.3 ms for 512 leaves
/// with a skin of 4,000 triangles; copies of an object cost only their pose.
[[nodiscard]] bool compileScene(const SceneDescription& description, Scene& scene, std::string& fault);

}  // namespace spheretree::runtime
