// SPDX-License-Identifier: Apache-2.0
// A scene of the C interface that ends with its scope.
#pragma once

#include "spheretree/runtime/runtime.h"

namespace spheretree::test {

inline constexpr double kOrigin[3] = {0, 0, 0};
inline constexpr st_pose kHere{{0, 0, 0}, {1, 0, 0, 0}};

struct CScene {
  st_scene* scene = st_scene_create();
  ~CScene() { st_scene_destroy(scene); }
};

}  // namespace spheretree::test
