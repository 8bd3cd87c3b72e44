// SPDX-License-Identifier: GPL-3.0-or-later
// Spheres of robots as other programs write them: the formats of robot_files.h and their relatives, read by what they
// hold.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "robot/link_shape.h"
#include "spheretree/core/sphere_tree.h"

namespace spheretree::robot {

struct SphereSet {
  std::string link;             // "" where the file names none
  std::vector<LinkBall> balls;  // [mm]
};

struct SphereFile {
  std::string format;              // "cuRobo", "XRDF", ...
  std::vector<SphereSet> sets;     // links with spheres, in the order of the file
  std::size_t without_volume = 0;  // spheres left out: their radius is 0 or below, which planners take for none
};

/// Reads by content: cuRobo (`collision_spheres`, in the file or in one that it names), XRDF, foam (its last depth),
/// ballpark, MorphIt, lists of {center|origin, radius}, whole or for each link; URDF (<sphere> of collisions, placed by
/// their origins), SRDF (<link_sphere_approximation>), MJCF (geoms of type sphere). `unit_mm`: one unit of its numbers,
/// finite and above 0; these formats say metres.
/// @throws formats::FileError; formats::FormatError for anything else, or if it holds no sphere.
SphereFile readSphereFile(const std::filesystem::path& path, double unit_mm = 1000);

/// The set of this link; of the only one, if `link` is empty. @throws formats::FormatError with the links there are.
const SphereSet& setOf(const SphereFile& file, const std::filesystem::path& path, const std::string& link);

/// Whether a file is one of these by its name, or, as a .json may also be a tree, by what it holds.
bool isSphereFile(const std::filesystem::path& path);

/// The balls as the one level of a tree, which measures take; no traversal does.
SphereTree levelOf(const SphereSet& set);

}  // namespace spheretree::robot
