// SPDX-License-Identifier: GPL-3.0-or-later
#include "build_levels.h"

#include <stdexcept>
#include <string>

#include "published/build_by_regions.h"
#include "published/reduce_burst.h"
#include "published/reduce_expand.h"
#include "published/reduce_grid.h"
#include "published/reduce_hubbard.h"
#include "published/reduce_merge.h"
#include "published/reduce_octree.h"
#include "published/reduce_spawn.h"

namespace spheretree::builder {

// Cover, Octree and Combined do not build by regions, or not by one method.
Method methodOf(BuilderKind kind) {
  switch (kind) {
    case BuilderKind::Merge:
      return {reduceMerge};
    case BuilderKind::Burst:
      return {reduceBurst};
    case BuilderKind::Expand:
      return {reduceExpand};
    case BuilderKind::Spawn:
      return {reduceSpawn, Method::Axis::None};
    case BuilderKind::Grid:
      return {reduceGrid, Method::Axis::None};
    case BuilderKind::Hubbard:
      return {reduceHubbard, Method::Axis::Static, false};
    default:
      throw std::invalid_argument("build: '" + std::string(name(kind)) +
                                  "' cannot be combined; use merge, burst, expand, spawn, grid or hubbard");
  }
}

LevelBalls LevelBuilder::published(const BuildSettings& settings, Progress& progress) const {
  if (settings.builder == BuilderKind::Octree) return buildOctree(mesh_, field_, settings, progress);
  std::vector<BuilderKind> members{settings.builder};
  if (settings.builder == BuilderKind::Combined) members = settings.combine.empty() ? kUsualMembers : settings.combine;
  std::vector<Method> methods;
  for (const BuilderKind member : members) methods.push_back(methodOf(member));
  return buildByRegions(mesh_, field_, methods, settings, progress);
}

LevelBalls LevelBuilder::build(const BuildSettings& settings, Progress& progress) {
  if (!settings.searches()) return published(settings, progress);
  if (settings.search && start_.balls.empty()) {
    BuildSettings whole = settings;
    whole.tolerance_mm = 0;
    start_ = published(whole, progress);
  }
  return cover_.build(settings, progress, start_.balls);
}

}  // namespace spheretree::builder
