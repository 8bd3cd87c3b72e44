// SPDX-License-Identifier: Apache-2.0
// A scene (*.scene.json, schema "spheretree.scene/1"): a tool and objects as meshes or sphere-trees, their poses, the
// settings of each tree, the coupling of the tool and the limits of the wrench. Every field, its range and default:
// docs/scene_file.md
// Units: mm, N, N mm, rad. World frame; an object's pose maps the frame of its mesh to the world.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "spheretree/core/rigid.h"
#include "spheretree/core/sphere.h"

namespace spheretree::formats {

inline constexpr std::size_t kMaxSceneObjects = 4096;
inline constexpr double kMaxSceneLength = 1e6;  // largest coordinate or tolerance [mm]
inline constexpr std::size_t kMaxCutLayers = 16, kMaxBurrBalls = 32;

/// How a tree is built. Absent values come from the scene's defaults, then from those of `spheretree build`.
struct TreeSettings {
  std::optional<std::string> builder;      // a name of `spheretree build --builder`
  std::optional<bool> search;              // whether the cover search distributes the balls of a published builder
  std::optional<std::string> medial_axis;  // adaptive, static
  std::optional<std::string> quality;      // quick, standard, best
  std::optional<std::string> repair;       // auto, off, wrap
  std::optional<int> levels;               // 2 .. 6
  std::optional<int> branching;            // 2 .. 8
  std::optional<double> tolerance_mm;      // > 0; absent: all leaves that levels and branching allow
  std::optional<std::uint64_t> seed;
  std::optional<double> skin_mm;           // of the skin: its tolerance, > 0; 0: no skin, "off" in the file
  std::optional<double> crease_angle_deg;  // of the skin; 1 .. 180
  friend bool operator==(const TreeSettings&, const TreeSettings&) = default;
};

/// The values of `own`; those that are absent, from `defaults`.
TreeSettings mergedSettings(const TreeSettings& own, const TreeSettings& defaults);

/// A region of the world with a tolerance of its own.
struct WorkRegion {
  enum class Shape { Sphere, Box };
  std::string name;  // may be empty
  Shape shape = Shape::Sphere;
  Eigen::Vector3d centre_mm{0, 0, 0};                 // of a sphere
  double radius_mm = 0;                               // of a sphere, > 0
  Eigen::Vector3d low_mm{0, 0, 0}, high_mm{0, 0, 0};  // of a box, low < high
  double tolerance_mm = 0;                            // > 0
};

/// What holds soft tissue in place: a region of the world, or the leaves of another object.
struct FixedRegion {
  WorkRegion region;   // unused if `inside` is set; without name and tolerance
  std::string inside;  // name of an object; "": the region counts
};

/// An object of soft tissue; docs/tissue.md
struct SoftSettings {
  double young_kpa = 0;                         // 0.1 .. 100000
  double poisson = 0.45, density_kg_m3 = 1040;  // 0 .. 0.495, 100 .. 5000
  double share = 0.5;                           // largest radius of leaves, as with `spheretree build --soft`; 0.05 .. 0.5
  int tetrahedra = 3000;                        // approximate number; 100 .. 50000
  std::vector<FixedRegion> fixed;               // one or more
};

/// What a burr removes at one rate.
struct CutLayer {
  std::string name;                 // unique in its object; see safe_name.h
  std::filesystem::path mesh;       // closed; as written: see scenePath(). Unit and frame are those of the object's mesh
  double removal = 0;               // depth that a burr gains for each N and s [mm/(N s)], > 0
  std::filesystem::path tree = {};  // its skin is the mesh for the runtime; as written. `batch` makes it; empty for the first layer
};

/// An object from which a burr removes material.
struct CutDescription {
  std::vector<CutLayer> layers;  // 1 .. kMaxCutLayers, innermost last: a point belongs to the last layer whose mesh contains it.
                                 // The mesh of the first is the whole object
  double tangential = 0.5;       // force against the motion of the burr's surface / normal force, 0 .. 2
};

/// The tool or an object: a mesh from which a tree is built, or a tree, optionally with the mesh that it was built
/// from, for display.
struct SceneItem {
  std::string name;                  // unique, ignoring case; see safe_name.h
  std::filesystem::path mesh, tree;  // one or both are set; as written: relative to the folder of the scene file, or absolute
  std::string unit;                  // of the mesh file, glTF included: mm, cm, m, in; "": that of the scene (glTF: m)
  std::string part;                  // of the mesh file: name of a part, or #N for its component N; "": the whole mesh
  Configuration
      pose;  // of an object: mesh frame in the world; of the tool: reference point with the axes of its mesh, in the frame of the handle
  Eigen::Vector3d reference_point_mm{0, 0, 0};  // of the tool, in its mesh frame; of an object: unused
  std::string reference_point;                  // of the tool: "tip" or "centre": computed from its shape; "": reference_point_mm
  TreeSettings settings;                        // only its own, not merged with the defaults
  std::string body;                             // of an object: name of the body that moves it; "": the world
  double friction = 0;                          // Coulomb's coefficient, 0 .. 2
  double stiffness_n_per_mm = 0;                // of an object: > 0; 0: it is rigid
  std::optional<SoftSettings> soft;             // of an object with a mesh
  std::optional<CutDescription> cut;            // of a rigid object with a skin
  std::vector<Ball> burr;                       // of the tool, in its mesh frame [mm]: the balls that cut; 0 .. kMaxBurrBalls
};

/// A rotation about an axis of the world by an angle over time: linear between the rows, constant before the first and
/// after the last.
struct Hinge {
  Eigen::Vector3d point_mm{0, 0, 0}, axis{1, 0, 0};  // axis of unit length; rotation right-handed
  struct Angle {
    double t_s = 0, degree = 0;
  };
  std::vector<Angle> angles;  // at least one, times increasing
};

/// A body that moves while a scene is played: along the poses of a file, or about a hinge. Objects name their body.
struct SceneBody {
  std::string name;
  std::filesystem::path pose_csv;  // as written; a trajectory (trajectory.h) of displacements from the poses of its objects in the scene
  std::optional<Hinge> hinge;      // alternative to pose_csv
};

/// The angle at time `t` [s], in degrees.
double hingeAngle(const Hinge& hinge, double t);

/// The displacement of a body that is rotated about the hinge by an angle.
Configuration hingePose(const Hinge& hinge, double degree);

/// A surface that a ball of this radius cannot touch, when it moves from outside the scene's box through free space,
/// needs only the accuracy `tolerance_mm`.
struct Reach {
  double radius_mm = 0;     // > 0: at most the thickness of the thinnest part of the tool that may touch
  double tolerance_mm = 0;  // > 0
};

struct SceneFile {
  std::string unit = "mm";  // of meshes without a unit of their own (not glTF): mm, cm, m, in. Fields that end in _mm are always in mm
  TreeSettings defaults;
  double translation_n_per_mm = 1;             // > 0, coupling
  double rotation_n_mm_per_rad = 1000;         // > 0, coupling
  double damping_n_s_per_mm = 0;               // >= 0, coupling
  double rotation_damping_n_mm_s_per_rad = 0;  // >= 0, coupling
  double mass_kg = 0, inertia_kg_mm2 = 0;      // >= 0, coupling: mass and inertia of the tool that the hand feels
  double force_n = 8;                          // > 0, limit of the force
  Eigen::Vector3d torque_n_mm{188, 188, 48};   // > 0, limit of each component
  SceneItem tool;
  std::vector<SceneItem> objects;  // 1 .. kMaxSceneObjects
  std::vector<WorkRegion> work;
  std::optional<Reach> reach;
  std::vector<SceneBody> bodies;
  Configuration device;            // device frame (+x right, +y up, +z to the user) in the world
  bool passivity_control = false;  // of the device
};

/// Whether the tool has a burr and an object can be cut: only then do recordings have the columns of cutting.
bool canCut(const SceneFile& scene);

/// Resolves `path` of a scene file: relative to the folder of `scene_path`.
std::filesystem::path scenePath(const std::filesystem::path& scene_path, const std::filesystem::path& path);

/// Checks every field: type, range, finite numbers, unit quaternions (which are normalised), unique names. Unknown keys
/// are refused. Does not check that meshes and trees exist.
/// @throws FileError if the file cannot be read; FormatError with the path of the element and the reason.
SceneFile readScene(const std::filesystem::path& path);

/// As readScene(), from a text; `name` is the prefix of messages. @throws FormatError
SceneFile parseScene(std::string_view text, const std::string& name);

/// parseScene(sceneText(s)) gives s, with exact numbers. Default values are left out where the schema allows it.
std::string sceneText(const SceneFile& scene);

}  // namespace spheretree::formats
