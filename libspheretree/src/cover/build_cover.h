// SPDX-License-Identifier: GPL-3.0-or-later
// The `cover` builder: every level by itself, as tight as its number of spheres allows.
#pragma once

#include "base/ball.h"
#include "geometry/distance_field.h"
#include "spheretree/builder/build_settings.h"
#include "spheretree/builder/progress.h"

namespace spheretree::builder {

/// Balls of each level, deepest first computed; no parents: hierarchy.h groups them. A level has at most
/// branching^level balls and no more than the level below. With a tolerance, the leaves are the fewest found whose
/// stand-off stays within it; if even the whole budget does not reach it, the whole budget is used. Deterministic for
/// any number of threads.
LevelBalls buildCover(const TriangleMesh& mesh, const DistanceField& field, const BuildSettings& settings, Progress& progress);

}  // namespace spheretree::builder
