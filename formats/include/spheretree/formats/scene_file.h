// SPDX-License-Identifier: Apache-2.0
// A scene (*.scene.json, schema "spheretree.scene/1"): a tool and objects as meshes or sphere-trees, their places, how
// each tree is to be built, the coupling of the tool and the limits of the wrench. Every field, its range and default:
// docs/scene_file.md
// Units: mm, N, N mm, rad. World frame; an object's pose takes the frame of its mesh to the world.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "spheretree/core/rigid.h"

namespace spheretree::formats {

inline constexpr std::size_t kMaxSceneObjects = 4096;
inline constexpr double kMaxSceneLength = 1e6;  // of any coordinate or tolerance [mm]

/// How a tree is built; what is absent is taken from the scene's defaults, and then from those of `spheretree build`.
struct TreeSettings {
  std::optional<std::string> builder;  // a name of `spheretree build --builder`
  std::optional<std::string> quality;  // quick, standard, best
  std::optional<std::string> repair;   // auto, off, wrap
  std::optional<int> levels;           // 2 .. 6
  std::optional<int> branching;        // 2 .. 8
  std::optional<double> tolerance_mm;  // > 0; absent: the whole budget of leaves
  std::optional<std::uint64_t> seed;
  std::optional<double> skin_mm;           // of the skin: its tolerance, > 0; 0: no skin, "off" in the file
  std::optional<double> crease_angle_deg;  // of the skin; 1 .. 180
  friend bool operator==(const TreeSettings&, const TreeSettings&) = default;
};

/// `own` where it says something, else `defaults`.
TreeSettings mergedSettings(const TreeSettings& own, const TreeSettings& defaults);

/// A region of the world in which its own tolerance holds.
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
  WorkRegion region;   // without name and tolerance
  std::string inside;  // name of an object; then there is no region
};

/// Of an object that is soft tissue; docs/tissue.md
struct SoftSettings {
  double young_kpa = 0;                         // 0.1 .. 100000
  double poisson = 0.45, density_kg_m3 = 1040;  // 0 .. 0.495, 100 .. 5000
  double share = 0.5;                           // of the radius of leaves, as `spheretree build --soft`; 0.05 .. 0.5
  int tetrahedra = 3000;                        // about; 100 .. 50000
  std::vector<FixedRegion> fixed;               // one or more
};

/// The tool or an object: a mesh to build a tree from, or a tree, which may name the mesh that it was built from, to be
/// shown.
struct SceneItem {
  std::string name;                  // unique but for case; safe as a file name: A-Z a-z 0-9 _ - . (not first), at most 64
  std::filesystem::path mesh, tree;  // one or both are set; as written: relative to the folder of the scene file, or absolute
  std::string unit;                  // of the mesh file, glTF included: mm, cm, m, in; "": that of the scene (glTF: m)
  std::string part;                  // of the mesh file: a name, or #N, its component N; "": all of it
  Configuration pose;  // of the mesh frame in the world; of the tool: its reference point, with the axes of its mesh, from the handle
  Eigen::Vector3d reference_point_mm{0, 0, 0};  // of the tool, in its mesh frame; of an object: unused
  std::string reference_point;                  // of the tool: "tip" or "centre", to be found from its shape; "": reference_point_mm
  TreeSettings settings;                        // its own, not merged
  std::string body;                             // of an object: name of the body that carries it; "": the world
  double friction = 0;                          // Coulomb's coefficient, 0 .. 2
  double stiffness_n_per_mm = 0;                // of an object: > 0; 0: it is rigid
  std::optional<SoftSettings> soft;             // of an object with a mesh
};

/// A turn about an axis of the world, by an angle over time: linear between the rows, held before the first and after
/// the last.
struct Hinge {
  Eigen::Vector3d point_mm{0, 0, 0}, axis{1, 0, 0};  // the axis of unit length; right-handed
  struct Angle {
    double t_s = 0, degree = 0;
  };
  std::vector<Angle> angles;  // at least one, times increasing
};

/// What moves while a scene is played, with the objects that belong to it: along the poses of a file, or about a hinge.
struct SceneBody {
  std::string name;
  std::filesystem::path pose_csv;  // as written; a trajectory (trajectory.h): displacements from where the scene has the objects
  std::optional<Hinge> hinge;      // or this
};

/// The angle at `t` [s], in degrees.
double hingeAngle(const Hinge& hinge, double t);

/// The displacement of what is turned about the hinge by an angle.
Configuration hingePose(const Hinge& hinge, double degree);

/// Surfaces that a ball of this radius cannot touch, as it moves from outside the scene's box through free space, need
/// no more accuracy than `tolerance_mm`.
struct Reach {
  double radius_mm = 0;     // > 0: no thicker than the tool's thinnest part that may touch
  double tolerance_mm = 0;  // > 0
};

struct SceneFile {
  std::string unit = "mm";  // of meshes without one (not glTF): mm, cm, m, in. Fields that end in _mm are in mm whatever it is
  TreeSettings defaults;
  double translation_n_per_mm = 1;             // > 0, coupling
  double rotation_n_mm_per_rad = 1000;         // > 0, coupling
  double damping_n_s_per_mm = 0;               // >= 0, coupling
  double rotation_damping_n_mm_s_per_rad = 0;  // >= 0, coupling
  double mass_kg = 0, inertia_kg_mm2 = 0;      // >= 0, coupling: of the tool that is felt
  double force_n = 8;                          // > 0, limit of the force
  Eigen::Vector3d torque_n_mm{188, 188, 48};   // > 0, limit of each component
  SceneItem tool;
  std::vector<SceneItem> objects;  // 1 .. kMaxSceneObjects
  std::vector<WorkRegion> work;
  std::optional<Reach> reach;
  std::vector<SceneBody> bodies;
  Configuration device;            // its frame (+x right, +y up, +z to the user) in the world
  bool passivity_control = false;  // of the device
};

/// Where `path` of a scene file leads: relative to the folder that `scene_path` is in.
std::filesystem::path scenePath(const std::filesystem::path& scene_path, const std::filesystem::path& path);

/// Every field is checked: type, range, finite, unit quaternion (made exact), unique names; unknown keys are refused.
/// Whether meshes and trees exist is not looked at.
/// @throws FileError if the file cannot be read, FormatError with the path of the element and what is wrong.
SceneFile readScene(const std::filesystem::path& path);

/// The same from a text; `name` stands in front of messages. @throws FormatError
SceneFile parseScene(std::string_view text, const std::string& name);

/// parseScene(sceneText(s)) gives s, numbers without loss. What is at its default is left out where the schema allows
/// it.
std::string sceneText(const SceneFile& scene);

}  // namespace spheretree::formats
