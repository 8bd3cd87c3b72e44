// SPDX-License-Identifier: Apache-2.0
// What the benchmarks of steps share. They are programs, not tests: a scene that does not compile ends them.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <string>

#include "spheretree/runtime/scene.h"
#include "support/sample_skins.h"
#include "support/shape_trees.h"

namespace spheretree::benchmark {

inline runtime::Scene compiled(const runtime::SceneDescription& description) {
  runtime::Scene scene;
  std::string fault;
  if (runtime::compileScene(description, scene, fault)) return scene;
  std::fprintf(stderr, "%s\n", fault.c_str());
  std::exit(1);
}

/// An ellipsoid with these half axes [mm]: 512 leaves with radii of about `grain` [mm], search tree and skin.
inline SphereTree ellipsoid(const Eigen::Vector3d& half, double grain) {
  return test::withSkin(test::withSearch(test::ellipsoidTree(half, 512, grain)), test::ellipsoidSkin(half, 4));
}

}  // namespace spheretree::benchmark
