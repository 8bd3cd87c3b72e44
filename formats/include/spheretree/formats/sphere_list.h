// SPDX-License-Identifier: Apache-2.0
// The spheres of one level as a flat list, in formats that robot programs read: CSV, YAML or JSON, in the frame of the
// mesh.
#pragma once

#include <string>

#include "spheretree/core/sphere_tree.h"

namespace spheretree::formats {

struct SphereListSettings {
  int level = 0;            // its level set is written: the level, and the leaves of earlier levels
  std::string unit = "mm";  // of the list: mm, cm, m or in
  SphereKind kind = SphereKind::Cover;
  std::string name;  // of the body, in JSON
};

/// Header x_mm,y_mm,z_mm,radius_mm, with the unit of the list, and a line for each sphere.
std::string sphereListCsv(const SphereTree& tree, const SphereListSettings& settings);

/// After a comment with the unit, collision_spheres: a list of {center: [x, y, z], radius: r}.
std::string sphereListYaml(const SphereTree& tree, const SphereListSettings& settings);

/// {"unit": "mm", "NAME": [{"origin": [x, y, z], "radius": r}, ...]}
std::string sphereListJson(const SphereTree& tree, const SphereListSettings& settings);

}  // namespace spheretree::formats
