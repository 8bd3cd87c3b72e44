// SPDX-License-Identifier: GPL-3.0-or-later
// Everything that is shown and does not change: bodies as meshes, spheres of every level and the surface of contact,
// and their poses. Units: mm; world frame, bodies in their own frames.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "model/colour.h"
#include "model/surface.h"
#include "spheretree/core/rigid.h"
#include "spheretree/core/sphere.h"
#include "spheretree/core/sphere_tree.h"

namespace spheretree::view {

struct Ball {
  float x, y, z, radius;  // [mm]
  Colour colour;
};
static_assert(sizeof(Ball) == 20);

/// A surface with a colour for each corner.
struct TintedSurface {
  Surface surface;
  std::vector<Colour> colours;  // (corners)
};

/// A mark at an important place: where a sphere has the largest overhang.
struct Spot {
  Eigen::Vector3d position = Eigen::Vector3d::Zero(), direction = Eigen::Vector3d::UnitZ();
  double length = 0;  // [mm]
};

/// One body in its own frame. Any member may be empty.
struct Body {
  std::string name, meaning;               // meaning: what the name says to a reader of the field; may be empty
  bool is_tooth = false;                   // as its name says
  int fdi = 0;                             // its number, ISO 3950; 0: unknown
  double overhang = -1;                    // how far the leaves reach out of the object, at most; below 0: unknown [mm]
  Surface mesh;                            // as in the file
  Surface skin;                            // the surface on which a tool rests, if the tree has one
  std::vector<std::vector<Ball>> levels;   // cover spheres of each level set; the last level has the leaves
  std::vector<std::vector<Ball>> bounds;   // bounding spheres of the inner nodes of each level
  std::vector<TintedSurface> overhangs;    // (levels) the balls, coloured by their local overhang; empty: unknown
  std::vector<double> overhang_max;        // (levels) overhang of the strongest colour [mm]
  std::vector<std::optional<Spot>> worst;  // (levels) the ball with the largest overhang
  Colour colour;                           // of the mesh
  Eigen::AlignedBox3d box;                 // of the mesh, or of the leaves
  bool empty() const { return mesh.empty() && levels.empty(); }
};

class MovedSurface;
struct CutMaterial;

struct PlacedObject {
  std::size_t body = 0;
  Configuration pose;                                  // of the body's frame in the world, while its carrier is at the identity
  std::uint32_t carrier = 0;                           // the body that moves it: index n - 1 in ShownState::carriers; 0: the world
  std::shared_ptr<const MovedSurface> soft = nullptr;  // its mesh if it is soft tissue; null: rigid
  std::shared_ptr<const CutMaterial> cut = nullptr;    // its layers if the burr of the tool removes it; null: no burr does
};
/// The pose of an object while its carrier is at its place in `carriers`; missing entries are the identity.
Configuration poseOf(const PlacedObject& object, std::span<const Configuration> carriers);

struct Stage {
  std::vector<Body> bodies;
  std::optional<std::size_t> tool;                            // index into bodies
  Eigen::Vector3d reference_point = Eigen::Vector3d::Zero();  // of the tool, in its frame
  bool y_up = false;                                          // the y axis of the world points up, not the z axis
  std::vector<PlacedObject> objects;
  std::vector<spheretree::Ball> burr;          // of the tool, in its frame
  double force_limit = 8;                      // [N]
  Eigen::Vector3d torque_limit{188, 188, 48};  // [N mm]

  /// Centre of a ball around all objects.
  Eigen::Vector3d centre() const;
  double radius() const;
  /// Distance from the tool's reference point to its farthest point; 0 without a tool [mm].
  double toolReach() const;
  /// Where a mark at the reference point is attached: the reference point if the tool is there, otherwise the centre of
  /// the nearest leaf; relative to the reference point, axes of the tool [mm].
  Eigen::Vector3d toolMark() const;
  int levelCount() const;
};

/// A colour for the mesh of object `index`: that of its kind, if the name indicates it (tooth, jaw or gum, tongue,
/// face); otherwise one of eight colours that colour-blind people can distinguish.
Colour colourOf(const std::string& name, std::size_t index);

/// The colour of layer `index` of an object of this colour, which the outermost layer has. The others have Okabe and
/// Ito's, which colour-blind people can distinguish.
Colour layerColour(std::size_t index, Colour object);

/// From dark violet (0) through blue and green to yellow (1), with increasing brightness, so that the order is also
/// visible to colour-blind people and in grey prints.
Colour heat(double share);

/// `mesh` may be null. Balls that descend from the same child of the root have the same hue.
Body bodyOf(std::string name, const SphereTree* tree, const TriangleMesh* mesh, Colour colour);

}  // namespace spheretree::view
