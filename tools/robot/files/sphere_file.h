// SPDX-License-Identifier: GPL-3.0-or-later
// Reads the spheres of robots that other programs wrote: the formats of robot_files.h and related ones, identified by
// their content.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "robot/model/link_shape.h"
#include "spheretree/core/sphere_tree.h"

namespace spheretree::robot {

struct SphereSet {
  std::string link;             // "" if the file names none
  std::vector<LinkBall> balls;  // [mm]
};

struct SphereFile {
  std::string format;              // "cuRobo", "XRDF", ...
  std::vector<SphereSet> sets;     // links with spheres, in the order of the file
  std::size_t without_volume = 0;  // ignored spheres: their radius is 0 or negative, which planners treat as absent
};

/// Identifies the format by its content: cuRobo (`collision_spheres`, in the file or in one that it names), XRDF, foam
/// (its last depth), ballpark, MorphIt, lists of {center|origin, radius}, whole or for each link, tables (.csv) with
/// the columns x, y, z and radius; URDF (<sphere> of
/// collisions, placed by their origins), SRDF (<link_sphere_approximation>), MJCF (geoms of type sphere). `unit_mm`:
/// one unit of its numbers, finite and above 0; empty: as the file states it, which lists of `convert` do, otherwise
/// metres, which these formats prescribe.
/// @throws formats::FileError; formats::FormatError for anything else, or if it contains no sphere.
SphereFile readSphereFile(const std::filesystem::path& path, std::optional<double> unit_mm = std::nullopt);

/// The set of this link; if `link` is empty, the only set. @throws formats::FormatError with the existing links.
const SphereSet& setOf(const SphereFile& file, const std::filesystem::path& path, const std::string& link);

/// Whether a file has one of these formats, by its name or, since a .json may also be a tree, by its content.
bool isSphereFile(const std::filesystem::path& path);

/// The balls as the only level of a tree, for the measures; it is not made for traversals.
SphereTree levelOf(const SphereSet& set);

}  // namespace spheretree::robot
