// SPDX-License-Identifier: Apache-2.0
// A molar with caries, a handpiece with a round burr, and a path that prepares a class I cavity.
// Units: mm. Frame of the tooth as in makeMolar().
#pragma once

#include <string>
#include <vector>

#include "spheretree/core/rigid.h"
#include "spheretree/core/sphere.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::samples {

/// Closed meshes: dentine within the tooth, the pulp within the dentine, the lesion below the fissure, across the
/// border of enamel and dentine.
struct CariousMolar {
  TriangleMesh tooth, dentine, lesion, pulp;
};
CariousMolar makeCariousMolar();

/// Its burr is kBurr, its axis is z, the handle up.
TriangleMesh makeHandpiece();
inline const Ball kBurr{{0, 0, 0}, 0.5};

/// The tooth as an object with layers, the handpiece as the tool. Rates of removal are examples, not measurements.
std::string cavitySceneText();

struct DrillPath {
  std::vector<Configuration> poses;  // of the hand; one for each millisecond
  std::vector<bool> spins;
};

/// The hand moves in lanes over the fissure and goes deeper after each pass, then returns. With forces below 2 N, the
/// burr follows it in the scene of cavitySceneText().
DrillPath prepareCavity();

/// In the form that spheretree/formats/trajectory.h reads, with the column `spin`.
std::string drillText(const DrillPath& path);

}  // namespace spheretree::samples
