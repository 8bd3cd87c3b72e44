// SPDX-License-Identifier: GPL-3.0-or-later
// The appearance of a stage: colours, kinds of geometry, marks. Plain values that panels and options set.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "model/removal.h"
#include "model/stage.h"
#include "streams/live_streams.h"

namespace spheretree::view {

enum class ThemeKind : std::uint8_t { Dark, Light };

struct Theme {
  Colour top, bottom;                     // of the background
  Colour text, faint, panel, line;        // of panels and plots
  Colour haptic, graphic;                 // the tools
  Colour force, torque, spring, warning;  // also distinguishable by brightness
  Colour good, bad;                       // lamps
};
Theme themeOf(ThemeKind kind);

enum class Geometry : std::uint8_t {
  Meshes,   // leaves if there is no mesh
  Spheres,  // of a level
  Bounds,   // bounding spheres of a level, which a search tests
  Contact,  // the surface of contact: skin or leaves
};

struct Look {
  ThemeKind theme = ThemeKind::Dark;
  Geometry objects = Geometry::Meshes, tool = Geometry::Meshes;
  int level = 100;           // of Spheres and Bounds; beyond the last level: the leaves
  bool skin_contact = true;  // contact is computed with skins, where trees have them; false: with leaves
  bool overhang = false;     // balls coloured by their overhang
  bool haptic_tool = true, spring = true, force = true, torque = true, contacts = true;
  bool cut = false;                   // objects in front of the tool are cut open
  std::vector<bool> hidden;           // (objects) may be shorter: the remaining objects are shown
  std::vector<bool> glass;            // (objects) as `hidden`: translucent
  std::optional<std::size_t> marked;  // an object in a stronger colour
  bool isGlass(std::size_t object) const { return object < glass.size() && glass[object]; }
  bool shows(std::size_t object) const { return object >= hidden.size() || !hidden[object]; }
};

/// The state at one moment.
struct ShownState {
  bool has_tool = false;
  Configuration haptic, graphic;
  Wrench wrench;                                        // on the hand
  Eigen::Vector3d tool_mark = Eigen::Vector3d::Zero();  // Stage::toolMark()
  std::span<const ShownContact> contacts;
  std::span<const std::vector<Eigen::Vector3f>> tissue;  // (object) displacements of the nodes of soft tissue; may be empty [mm]
  std::span<const Configuration> carriers;               // poses of the bodies; missing entries are the identity
  const Removal* removal = nullptr;                      // by the burr; null: none
  Configuration poseOf(const PlacedObject& object) const { return view::poseOf(object, carriers); }
};

}  // namespace spheretree::view
