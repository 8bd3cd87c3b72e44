// SPDX-License-Identifier: Apache-2.0
// An open mouth for a probe: 28 teeth in two jaws with gums, a tongue and a face.
#pragma once

#include <string>
#include <vector>

#include "spheretree/core/rigid.h"
#include "spheretree/core/triangle_mesh.h"
#include "tooth_forms.h"

namespace spheretree::samples {

/// Triangles of each part: those of the published scene, except that the tongue has 1,046 in place of 1,045, because a
/// closed mesh has an even number.
inline constexpr std::size_t kJawTriangles = 2280, kFaceTriangles = 3138, kTongueTriangles = 1046;

struct MouthTooth {
  std::string name;                          // tooth_11 .. tooth_47 (FDI)
  TriangleMesh mesh;                         // world
  Eigen::Vector3d centre;                    // of its cervical line, world [mm]
  Eigen::Vector3d mesial, buccal, occlusal;  // unit axes of the tooth in the world
  double width = 0;                          // of the crown along the arch [mm]
};

/// World frame [mm]: x to the patient's left, y to the front, z up; z = 0 at the cervical lines of the lower teeth.
struct Mouth {
  std::vector<MouthTooth> teeth;  // 11..17, 21..27, 31..37, 41..47
  TriangleMesh lower_jaw, upper_jaw, tongue, face;

  struct Part {
    std::string name;
    const TriangleMesh* mesh;
  };
  std::vector<Part> parts() const;  // teeth, lower_jaw, upper_jaw, tongue, face
};

/// Every mesh is closed, manifold and free of self-intersections. Around each tooth there is a sulcus, open to the
/// biting side, 2 mm deep and 0.45 mm wide at its floor, 0.8 mm at its rim. The same bytes on every machine.
Mouth makeMouth();

/// Highest point of `tooth` along its occlusal axis over the point (mesial, buccal) of its frame; 0 beside it [mm].
double crownHeight(const MouthTooth& tooth, double mesial, double buccal);

/// Middle of the floor of the sulcus of `tooth` in direction (mesial, buccal), a unit vector; world [mm].
Eigen::Vector3d sulcusFloor(const MouthTooth& tooth, const Eigen::Vector2d& direction);

}  // namespace spheretree::samples
