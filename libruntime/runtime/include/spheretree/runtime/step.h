// SPDX-License-Identifier: Apache-2.0
// One servo step: the pose of the haptic tool in, the pose of the graphic tool, the wrench and the contacts out.
// The two modes, what is guaranteed and why: docs/runtime.md
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "spheretree/runtime/scene.h"

namespace spheretree::runtime {

enum class Mode : std::uint8_t {
  Constrained,  // the graphic tool never passes through anything
  Paper,        // the published algorithm
};

/// Which arithmetic runs the inner loops. All give the same bits.
enum class Kernel { Best, Scalar, Avx2 };

/// True if this machine can run `kernel`.
bool isAvailable(Kernel kernel);

/// Bits. After each of them the wrench is safe to render.
enum StepFault : std::uint32_t {
  kNoFault = 0,
  kPairsFull = 1,      // more pairs than max_pairs: upper levels of the trees stood in
  kWorkLimit = 2,      // max_work was used up: the graphic tool goes on next step
  kQpStopped = 4,      // the QP stopped early
  kRowsConflict = 8,   // the rows contradict each other: the answer has the smallest worst violation
  kPenetrating = 16,   // the graphic tool is inside an object by more than kGapTolerance
  kBadInput = 32,      // the haptic pose is not finite or beyond 1e7 mm: the tool rests and the wrench decays by 10 % a step
  kTissueFrozen = 64,  // aimTissue() said so: soft tissue gives way from the last good state on, by the compliance of its rest
};

inline constexpr double kGapTolerance = 1e-3;  // the graphic tool is feasible if no leaf is deeper than this [mm]

struct StepResult {
  Configuration graphic;  // reference point and orientation of the graphic tool
  Wrench wrench;          // on the hand, about the reference point of the haptic tool, world axes [N, N mm]
  Wrench limited_wrench;  // the same within WrenchLimits: what to render
  double penetration =
      0;  // of the graphic tool's leaves into what is guaranteed: leaves, or the skin less its tolerance [mm]; constrained mode
  std::uint32_t faults = 0;  // StepFault
  std::uint32_t pairs = 0;   // of the last search
  std::uint32_t rows = 0;    // of the last QP
  std::uint32_t active = 0;  // rows that hold the tool
  std::uint32_t qp_iterations = 0;
  std::uint32_t searches = 0, linearisations = 0;
  std::uint32_t work = 0;             // in the unit of StepLimits::max_work
  std::uint32_t friction_rounds = 0;  // most of any QP: of the forces of friction, until they are those of the contacts
};

/// Time spent in the stages of one step [ns]. Reading the clock costs about 25 ns each time.
struct StageTimes {
  std::uint64_t find = 0, rows = 0, qp = 0;
};

/// Where the graphic tool is held, and how.
struct Contact {
  std::uint32_t object = 0;           // index in SceneDescription::objects
  std::uint32_t tool_leaf = 0;        // node of the tool's tree
  bool on_skin = false;               // else on a leaf of the object
  std::uint32_t element = 0;          // triangle of the object's skin, or node of its tree
  Eigen::Vector3d point{0, 0, 0};     // where the tool's leaf is touched, world [mm]
  Eigen::Vector3d normal{0, 0, 1};    // from object to tool, unit length, world axes
  double force = 0;                   // along the normal, on the tool [N]. All contacts together balance spring and damper.
  Eigen::Vector3d friction{0, 0, 0};  // force across the normal, on the tool, world axes [N]
  Eigen::Vector3d slip{0, 0, 0};      // velocity of the tool's point across the object, world axes [mm/s]
};

inline constexpr std::size_t kMostContacts = 24;  // 6 without friction: more never hold a rigid body

struct StepMemory;

/// All memory that changes while a scene is rendered: scratch lists and the state from step to step. Sized once.
class Workspace {
 public:
  /// For `scene`, which must outlive it. `kernel` that is not available falls back to Scalar. @throws std::bad_alloc.
  explicit Workspace(const Scene& scene, Kernel kernel = Kernel::Best);
  ~Workspace();
  Workspace(const Workspace&) = delete;
  Workspace& operator=(const Workspace&) = delete;

  StepMemory& memory() { return *memory_; }  // for the library's own parts
  const StepMemory& memory() const { return *memory_; }

 private:
  std::unique_ptr<StepMemory> memory_;
};

/// The first step, and the first after reset(), puts the graphic tool at the haptic pose.
/// No allocation, lock, exception or I/O. Cost: bounded by StepLimits; the first step after a reset also finds out on
/// which side of each skin the tool is (about 15 ns for each triangle and leaf of the tool that is near). Same scene,
/// poses and mode: same bytes.
/// `times`, if given, gets the stage times.
StepResult step(const Scene& scene, const Configuration& haptic_tool, Mode mode, Workspace& workspace,
                StageTimes* times = nullptr) noexcept;

/// The contacts that held the graphic tool at the end of the last step; at most kMostContacts. Valid until the next
/// step. Empty in free space and in the mode of the paper.
std::span<const Contact> contacts(const Workspace& workspace) noexcept;

/// Puts an object of the scene elsewhere at once, a jump: its mesh frame in the world, as in SceneDescription. It goes
/// on with its body from there. The tool is not taken along: where the object comes upon it, it is pushed out in the
/// next step. False, and nothing changes, if there is no such object or the pose is not finite or beyond 1e7 mm. No
/// allocation. Cost: 0.3 us; a jump of more than a quarter of the smallest ball's radius also finds out anew on which
/// side of the skins the tool is.
bool moveObject(std::size_t object, const Configuration& pose, Workspace& workspace) noexcept;

/// The body goes to `pose` during the next step: the displacement of its objects from where the scene has them at its
/// start, world axes. On its way it pushes the tool ahead and never passes through it, however fast it is
/// (docs/runtime.md). `velocity` [mm/s, rad/s; about the origin of the body, world axes] is for poses that come less
/// often than steps: in a step without a new pose the body goes on at it. False, and nothing changes, if there is no
/// such body or it is 0, the world, or a number is not finite or beyond 1e7. No allocation.
bool moveBody(std::uint32_t body, const Configuration& pose, Workspace& workspace, const Displacement& velocity = {}) noexcept;

/// Large motion of soft tissue, which a solver outside of the step finds, in a thread of the caller's own
/// (spheretree/tissue/moving_tissue.h): the forces that press on the tissue of an object, x, y, z of each of its
/// pressed nodes [N], axes of its mesh. Empty if the object is rigid. Valid until the next step.
std::span<const float> tissueForces(std::size_t object, const Workspace& workspace) noexcept;

/// And its answer: how far the pressed nodes are displaced under these forces, x, y, z of each, less what the
/// compliance of the rest says that the forces do. The surface goes most of the way in 40 ms, by at most 0.25 mm in a
/// step, and pushes the tool ahead; while it has no way out it waits. `surface` is held until the next call or reset.
/// `is_frozen`: the solver is at a loss and gives its last good state; steps say so by kTissueFrozen. False, and
/// nothing changes, if the object is rigid or does not have so many pressed nodes. Cost of a step with it: about 5 ns a
/// triangle that is on the way.
bool aimTissue(std::size_t object, std::span<const float> surface, bool is_frozen, Workspace& workspace) noexcept;

/// Where a body is: on its way if the last step ran out of work. `body` < Scene::bodyCount().
Configuration bodyPose(std::uint32_t body, const Workspace& workspace) noexcept;

/// Forgets the last step: the next one starts at its haptic pose.
void reset(Workspace& workspace) noexcept;

/// As reset(), but the graphic tool starts at `graphic_tool`, which should be free.
void resetTo(const Configuration& graphic_tool, Workspace& workspace) noexcept;

}  // namespace spheretree::runtime
