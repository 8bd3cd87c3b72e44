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

namespace {

// The published method that builds by regions; Cover, Octree and Combined are not such methods.
Method methodOf(BuilderKind kind) {
  switch (kind) {
    case BuilderKind::Merge:
      return {reduceMerge, true};
    case BuilderKind::Burst:
      return {reduceBurst, true};
    case BuilderKind::Expand:
      return {reduceExpand, true};
    case BuilderKind::Spawn:
      return {reduceSpawn, false};
    case BuilderKind::Grid:
      return {reduceGrid, false};
    case BuilderKind::Hubbard:
      return {reduceHubbard, true};
    default:
      throw std::invalid_argument("build: '" + std::string(name(kind)) +
                                  "' cannot be combined; use merge, burst, expand, spawn, grid or hubbard");
  }
}

}  // namespace

LevelBalls LevelBuilder::build(const BuildSettings& settings, Progress& progress) {
  PublishedSettings published;
  published.levels = settings.levels;
  published.branching = settings.branching;
  published.quality = settings.quality;
  published.tolerance_mm = settings.tolerance_mm;
  published.seed = settings.seed;
  std::vector<Method> methods;
  switch (settings.builder) {
    case BuilderKind::Cover:
      return cover_.build(settings, progress);
    case BuilderKind::Octree:
      return buildOctree(mesh_, field_, published, progress);
    case BuilderKind::Combined: {
      const std::vector<BuilderKind> usual{BuilderKind::Expand, BuilderKind::Merge, BuilderKind::Burst};
      for (const BuilderKind member : settings.combine.empty() ? usual : settings.combine) methods.push_back(methodOf(member));
      break;
    }
    default:
      methods.push_back(methodOf(settings.builder));
  }
  return buildByRegions(mesh_, field_, methods, published, progress);
}

}  // namespace spheretree::builder
