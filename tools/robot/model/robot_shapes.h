// SPDX-License-Identifier: GPL-3.0-or-later
// The shapes of a robot's links, read from its URDF and mesh files: placeholders are left out, and sizes that suggest
// another unit are doubted. Documentation: docs/robots.md
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "robot/model/link_shape.h"
#include "robot/model/robot_model.h"
#include "spheretree/builder/progress.h"

namespace spheretree::robot {

/// Parses "PATTERN=UNIT", or "UNIT" for all links; UNIT is mm, cm, m or in. Empty for anything else.
std::optional<LinkUnit> linkUnit(const std::string& text);

/// The text that linkUnit() parses.
std::string textOf(const LinkUnit& unit);

struct ShapedElement {
  std::size_t link = 0;
  std::string name;   // of the collision element, or its mesh file; may be empty
  std::string place;  // for messages, as CollisionElement::place
  LinkShape shape;
};

/// The shapes of all collision elements, link by link. Elements without a surface are removed from `robot`. Notes about
/// these, about links that are left without any, and about doubtful sizes are added to `robot`.
/// @throws formats::FileError, formats::FormatError for meshes, with the place in the URDF, and if no element is left;
/// tool::UsageError for a pattern of `units` that no link with a mesh file matches; builder::Cancelled
std::vector<ShapedElement> readShapes(Robot& robot, const std::vector<LinkUnit>& units, const builder::Progress& progress);

/// The elements of each link; links without shapes are left out.
std::vector<std::span<const ShapedElement>> linksOf(std::span<const ShapedElement> shapes);

/// The shapes of a link as one mesh; a capsule or ball is represented by triangles with vertices on it.
TriangleMesh meshOf(std::span<const ShapedElement> elements);

}  // namespace spheretree::robot
