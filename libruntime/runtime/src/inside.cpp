// SPDX-License-Identifier: Apache-2.0
#include "inside.h"

#include <cmath>

#include "step_parts.h"

namespace spheretree::runtime {
namespace {

// The winding number of the surface around a point: 1 inside a closed surface, 0 outside; in between for a surface with
// holes.
// Paper: A. Jacobson, L. Kavan, O. Sorkine-Hornung. Robust inside-outside segmentation using generalized winding
//         numbers. ACM TOG 32(4), 2013. A triangle's solid angle: A. van Oosterom, J. Strackee. The solid angle of a
//         plane triangle. IEEE TBME 30(2), 1983.
double windingNumber(const CompiledSkin& skin, const Eigen::Vector3d& point) {
  double half_angles = 0;
  for (const CompiledPatch& patch : skin.patch) {
    Eigen::Vector3d v[3];
    for (int k = 0; k < 3; ++k) v[k] = Eigen::Vector3d(patch.position[k][0], patch.position[k][1], patch.position[k][2]) - point;
    const double a = v[0].norm(), b = v[1].norm(), c = v[2].norm();
    half_angles += std::atan2(v[0].dot(v[1].cross(v[2])), a * b * c + v[0].dot(v[1]) * c + v[1].dot(v[2]) * a + v[2].dot(v[0]) * b);
  }
  return half_angles / (2 * M_PI);
}

float smallestGap(const RowSet& rows, const PairRun& run) {
  float gap = std::numeric_limits<float>::infinity();
  for (std::uint32_t i = run.begin; i < run.begin + run.count; ++i) gap = std::min(gap, -rows.b[i] / rows.weight[i]);
  return gap;
}

// Whether the centre of a leaf of the tool is inside the object: in one of its leaves, with a skin that winds around
// it.
bool isWithin(const StepParts& parts, const PairSet& pairs, const PairRun& run) {
  const CompiledScene& scene = parts.scene;
  const Configuration& graphic = parts.memory.graphic;
  const CompiledObject& object = parts.memory.objects[run.object];
  const CompiledShape& shape = scene.shapes[object.shape];
  std::uint32_t last = kNoItem;
  for (const std::uint32_t pair : pairs.pairs.subspan(run.begin, run.count)) {
    const std::uint32_t tool = pair >> 16;
    const std::array<double, 3>&c = scene.tool.exact[tool], &leaf = shape.leaves.exact[pair & 0xffff];
    const Eigen::Vector3d world = graphic.position + graphic.orientation * Eigen::Vector3d(c[0], c[1], c[2]),
                          local = object.rotation.transpose() * (world - object.anchor);
    const auto radius = static_cast<double>(shape.leaves.spheres[pair & 0xffff].radius);
    if (tool == last || (local - Eigen::Vector3d(leaf[0], leaf[1], leaf[2])).norm() > radius) continue;
    if (windingNumber(shape.skin, local) > 0.5) return true;
    last = tool;
  }
  return false;
}

// Leaves are those of the shape at rest, so deformed tissue keeps its skin.
bool isWhereItsTreeIs(const StepParts& parts, std::uint32_t object) {
  return !parts.memory.isTissue(object) || parts.memory.tissue->isAtRest(object);
}

}  // namespace

void settleSides(StepParts& parts) {
  StepMemory& memory = parts.memory;
  if (memory.sides_known) return;
  memory.sides_known = true;
  const Configuration& graphic = memory.graphic;
  const PairSet touching = parts.search(graphic, 0, PairsOf::ContactSurface);
  const RowSet rows = parts.rows(touching, graphic);
  for (const PairRun& run : touching.runs)
    if (isWhereItsTreeIs(parts, run.object) && (touching.coarse || smallestGap(rows, run) < -static_cast<float>(kGapTolerance)))
      memory.feelLeaves(run.object);
  const PairSet leaves = parts.search(graphic, 0, PairsOf::LeavesExactly);
  for (const PairRun& run : leaves.runs)
    if (memory.feelsSkin(run.object) && isWhereItsTreeIs(parts, run.object) && (leaves.coarse || isWithin(parts, leaves, run)))
      memory.feelLeaves(run.object);
}

void leaveInsides(StepParts& parts) {
  StepMemory& memory = parts.memory;
  if (memory.leaves_felt == 0) return;
  const PairSet touching = parts.search(memory.graphic, 0, PairsOf::ContactSurface);
  if (touching.coarse) return;
  const RowSet rows = parts.rows(touching, memory.graphic);
  const PairRun* run = touching.runs.data();
  const PairRun* const end = run + touching.runs.size();
  for (std::uint32_t i = 0; i < memory.views.size(); ++i) {
    const bool is_touched = run != end && run->object == i;
    if (!is_touched || smallestGap(rows, *run) >= -static_cast<float>(kGapTolerance)) memory.feelSkin(i);
    run += is_touched;
  }
}

}  // namespace spheretree::runtime
