// SPDX-License-Identifier: Apache-2.0
// One servo step: from the pose of the haptic tool to the pose of the graphic tool, the wrench and the contacts.
// The two modes, what is guaranteed and why: docs/runtime.md
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>

#include "spheretree/runtime/scene.h"

namespace spheretree::runtime {

enum class Mode : std::uint8_t {
  Constrained,  // the graphic tool never passes through an object
  Published,    // the published algorithm
};

/// Which instruction set the inner loops use. All give the same bits.
enum class Kernel { Best, Scalar, Avx2 };

/// True if this machine can run `kernel`.
bool isAvailable(Kernel kernel);

/// Bits of StepResult::faults. After each of them the wrench is safe to render.
enum StepFault : std::uint32_t {
  kNoFault = 0,
  kPairsFull = 1,      // more pairs than max_pairs: nodes of upper levels of the trees replaced leaves
  kWorkLimit = 2,      // max_work was used up: the graphic tool continues in the next step
  kQpStopped = 4,      // the QP stopped early
  kRowsConflict = 8,   // no pose satisfies all rows: the result has the smallest possible worst violation
  kPenetrating = 16,   // the graphic tool is inside an object by more than kGapTolerance
  kBadInput = 32,      // the haptic pose is not finite or beyond 1e7 mm: the tool rests and the wrench decays by 10 % a step
  kTissueFrozen = 64,  // set by aimTissue(): soft tissue deforms from its last good state, with the compliance of the shape at rest
};

inline constexpr double kGapTolerance = 1e-3;  // the graphic tool is feasible if no leaf is deeper than this [mm]

struct StepResult {
  Configuration graphic;  // reference point and orientation of the graphic tool
  Wrench wrench;          // of the coupling, acts on the hand about the reference point of the haptic tool, world axes [N, N mm]
  Wrench limited_wrench;  // `wrench` within WrenchLimits: render this one, unless safety rules of your device limit `wrench`
  double penetration =
      0;  // of the graphic tool's leaves into the guaranteed surface: leaves, or the skin less its tolerance [mm]; constrained mode
  std::uint32_t faults = 0;  // StepFault
  std::uint32_t pairs = 0;   // in the list of the last search
  std::uint32_t rows = 0;    // in the last QP
  std::uint32_t active = 0;  // active rows: they hold the tool
  std::uint32_t qp_iterations = 0;
  std::uint32_t searches = 0, linearisations = 0;
  std::uint32_t work = 0;      // in the unit of StepLimits::max_work
  std::uint32_t unsolved = 0;  // contact problems whose forces miss the law of friction by more than 1e-6 mm of motion
};

/// Time spent in the stages of one step [ns]. Reading the clock costs about 25 ns each time.
struct StageTimes {
  std::uint64_t find = 0, rows = 0, qp = 0;
};

/// A contact that holds the graphic tool.
struct Contact {
  std::uint32_t object = 0;           // index in SceneDescription::objects
  std::uint32_t tool_leaf = 0;        // node of the tool's tree; if the tool rests with its hulls: their part
  bool on_skin = false;               // true: on the skin; false: on a leaf of the object, or on the wall of what was cut off
  bool on_wall = false;               // on such a wall: then there is no element
  std::uint32_t element = 0;          // triangle of the object's skin, or node of its tree
  Eigen::Vector3d point{0, 0, 0};     // where the tool's leaf is touched, world frame [mm]
  Eigen::Vector3d normal{0, 0, 1};    // from object to tool, unit length, world axes
  double force = 0;                   // along the normal, on the tool [N]. The forces of all contacts balance spring and damper.
  Eigen::Vector3d friction{0, 0, 0};  // tangential force on the tool, world axes [N]
  Eigen::Vector3d slip{0, 0, 0};      // tangential velocity of the tool's point relative to the object, world axes [mm/s]
};

inline constexpr std::size_t kMaxContacts = 24;  // without friction at most 6, since 6 contacts determine the pose of a rigid body

struct StepMemory;

/// All memory that changes while a scene is rendered: scratch lists and the state between steps. It is allocated once.
class Workspace {
 public:
  /// `scene` must outlive the workspace. If `kernel` is not available, Scalar is used. @throws std::bad_alloc.
  explicit Workspace(const Scene& scene, Kernel kernel = Kernel::Best);
  ~Workspace();
  Workspace(const Workspace&) = delete;
  Workspace& operator=(const Workspace&) = delete;

  StepMemory& memory() { return *memory_; }  // for the library's own parts
  const StepMemory& memory() const { return *memory_; }

 private:
  std::unique_ptr<StepMemory> memory_;
};

/// Computes one servo step. The first step, and the first after reset(), puts the graphic tool at the haptic pose. No
/// allocation, lock, exception or I/O. The cost is bounded by StepLimits; the first step after a reset also determines
/// on which side of each skin the tool is (about 15 ns for each pair of a near triangle and a leaf of the tool). Same
/// scene, poses and mode: same bytes. `times`, if given, receives the time spent in each stage.
StepResult step(const Scene& scene, const Configuration& haptic_tool, Mode mode, Workspace& workspace,
                StageTimes* times = nullptr) noexcept;

/// The contacts that held the graphic tool at the end of the last step, at most kMaxContacts. Valid until the next
/// step. Empty in free space and in the mode of the paper.
std::span<const Contact> contacts(const Workspace& workspace) noexcept;

/// Moves an object of the scene at once, as a jump. `pose` is that of its mesh frame in the world, as in
/// SceneDescription. From there it moves on with its body. The tool does not move with it; if the object now overlaps
/// the tool, the next step pushes the tool out. Returns false, and changes nothing, if there is no such object, or the
/// pose is not finite or beyond 1e7 mm. No allocation. Cost: 0.3 us; a jump of more than a quarter of the smallest
/// ball's radius also determines anew on which side of the skins the tool is.
bool moveObject(std::size_t object, const Configuration& pose, Workspace& workspace) noexcept;

/// Switches an object off or on, between two steps. An object that is off is left out of every search: it costs no
/// work, gives no contact, and its body does not push the tool with it. It still follows its body. At the beginning,
/// all objects are on; reset() changes nothing. An object that is switched on where the tool is pushes the tool out, as
/// one that moveObject() put there; nothing passes through it from the first pose that is free of it. Returns false if
/// there is no such object. No allocation. Cost: 0.1 us; the next step determines anew on which side of the skins the
/// tool is.
bool setActive(std::size_t object, bool is_active, Workspace& workspace) noexcept;
/// `object` < Scene::objectCount().
bool isActive(std::size_t object, const Workspace& workspace) noexcept;

/// The current pose of the mesh frame of an object in the world. `object` < Scene::objectCount().
Configuration objectPose(std::size_t object, const Workspace& workspace) noexcept;

/// Switches the spindle on or off, between two steps. While it turns, the burr of the tool removes material of the
/// objects that can be cut, and meets its resistance; the rest of the tool is firm. While it rests, the burr is firm as
/// well. At the beginning it rests. Returns false if the scene has no burr or nothing to cut.
bool setSpindle(bool turns, Workspace& workspace) noexcept;
bool turns(const Workspace& workspace) noexcept;

/// What the burr has done to an object.
struct CutState {
  static constexpr std::uint32_t kNone = ~0u;
  std::array<double, kMaxCutLayers> removed{};  // of each layer, the outermost first, as a sum over cells of a lattice [mm^3]
  std::uint32_t layer = kNone;                  // innermost layer that resisted in the last step; kNone: none
};

/// `object` < Scene::objectCount(). Zero for an object that is not cut.
CutState cutState(std::size_t object, const Workspace& workspace) noexcept;

/// Makes all material whole again, between two steps. A reset of the tool does not. Where the tool is in the material,
/// the next step pushes it out.
void mend(Workspace& workspace) noexcept;

/// How far the tool is from an object, with proven bounds.
struct Distance {
  double lower = 0;                    // no point of the tool's mesh is nearer to the mesh of the object [mm]
  double upper = 0;                    // two points of the solids are at most this far apart [mm]; infinite if no bound is proven
  Eigen::Vector3d on_tool{0, 0, 0};    // the nearest points of the tool's leaves and of what stands for the object:
  Eigen::Vector3d on_object{0, 0, 0};  // its skin, else its leaves; world frame [mm]
};

/// The distance of the tool at `tool` from an object where it is now, switched off or not. The object counts as it is
/// at rest, whether or not it yields. If nothing is nearer than `limit` [mm], `lower` is `limit`, `upper` is infinite
/// and the points are zero; a small limit makes the search short. Returns false if there is no such object or the pose
/// is not finite. No allocation. Cost: a branch-and-bound search, about 0.2 ms for 505 leaves and a skin of 4,164
/// triangles. What the bounds rest on: docs/runtime.md
bool distance(std::size_t object, const Configuration& tool, double limit, const Workspace& workspace, Distance& out) noexcept;

/// Moves a body to `pose` during the next step. `pose` is the displacement of its objects from their poses in the
/// scene, world axes. On its way the body pushes the tool ahead and never passes through it, at any speed
/// (docs/runtime.md). `velocity` (about the origin of the body, world axes [mm/s, rad/s]) serves poses that arrive less
/// often than steps: in a step without a new pose the body continues with this velocity. Returns false, and changes
/// nothing, if there is no such body, it is 0 (the world), or a number is not finite or beyond 1e7. No allocation.
bool moveBody(std::uint32_t body, const Configuration& pose, Workspace& workspace, const Displacement& velocity = {}) noexcept;

/// Input of a solver for large deformation of soft tissue, which runs outside of the step in a thread of the caller
/// (spheretree/tissue/moving_tissue.h): the forces that press on the tissue of an object, x, y, z of each of its
/// pressed nodes [N], in the axes of its mesh. Empty if the object is rigid. Valid until the next step.
std::span<const float> tissueForces(std::size_t object, const Workspace& workspace) noexcept;

/// Takes the solver's answer: the displacements of the pressed nodes under these forces (x, y, z of each), minus
/// what the compliance at rest predicts for the forces. The surface covers most of the way in 40 ms, by at most
/// 0.1 mm in a step, and pushes the tool ahead; it waits while the tool cannot get out of its way. `surface` must stay
/// valid until the next call or reset. `is_frozen`: the solver failed and returned its last good state; steps then
/// report kTissueFrozen. Returns false, and changes nothing, if the object is rigid or has another number of pressed
/// nodes. Cost in a step: about 5 ns for each triangle that is still moving.
bool aimTissue(std::size_t object, std::span<const float> surface, bool is_frozen, Workspace& workspace) noexcept;

/// The current pose of a body; it has not arrived yet if the last step ran out of work. `body` < Scene::bodyCount().
Configuration bodyPose(std::uint32_t body, const Workspace& workspace) noexcept;

/// Forgets the state of the last step: the next step starts at its haptic pose.
void reset(Workspace& workspace) noexcept;

/// As reset(), but the next step starts at `graphic_tool`, which should be free of objects.
void resetTo(const Configuration& graphic_tool, Workspace& workspace) noexcept;

}  // namespace spheretree::runtime
