// SPDX-License-Identifier: GPL-3.0-or-later
// How a stage is shown: colours, which geometry, which marks. Plain values that panels and options set.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "model/stage.h"
#include "streams/live_streams.h"

namespace spheretree::view {

enum class ThemeKind : std::uint8_t { Dark, Light };

struct Theme {
  Colour top, bottom;                     // of the background
  Colour text, faint, panel, line;        // of panels and plots
  Colour haptic, graphic;                 // the tools
  Colour force, torque, spring, warning;  // told apart by brightness too
  Colour good, bad;                       // lamps
};
Theme themeOf(ThemeKind kind);

enum class Geometry : std::uint8_t {
  Meshes,   // leaves where there is no mesh
  Spheres,  // of a level
  Bounds,   // bounding spheres of a level: what a search tests
  Contact,  // what contact is computed with: skin or leaves
};

struct Look {
  ThemeKind theme = ThemeKind::Dark;
  Geometry objects = Geometry::Meshes, tool = Geometry::Meshes;
  int level = 100;           // of Spheres and Bounds; beyond the last: the leaves
  bool skin_contact = true;  // contact is computed with skins, where trees have them; false: with leaves
  bool overhang = false;     // balls in the colours of their overhang
  bool haptic_tool = true, spring = true, force = true, torque = true, contacts = true;
  bool cut = false;          // objects in front of the tool have a hole
  std::vector<bool> hidden;  // (objects); shorter: the others are shown
  bool shows(std::size_t object) const { return object >= hidden.size() || !hidden[object]; }
};

/// Of one moment.
struct ShownState {
  bool has_tool = false;
  Configuration haptic, graphic;
  Wrench wrench;  // on the hand
  std::span<const ShownContact> contacts;
  std::span<const std::vector<Eigen::Vector3f>> tissue;  // (object) displacements of the nodes of soft tissue; may be empty [mm]
  std::span<const Configuration> carriers;               // where what moves is; what is missing stands at the identity
  Configuration poseOf(const PlacedObject& object) const {
    return object.carrier == 0 || object.carrier > carriers.size() ? object.pose : composed(carriers[object.carrier - 1], object.pose);
  }
};

}  // namespace spheretree::view
