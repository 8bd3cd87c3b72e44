// SPDX-License-Identifier: Apache-2.0
#include "step/inside.h"

#include "scene/winding_number.h"
#include "step/step_parts.h"

namespace spheretree::runtime {
namespace {

float smallestGap(const RowSet& rows, const PairRun& run) {
  float gap = std::numeric_limits<float>::infinity();
  for (std::uint32_t i = run.begin; i < run.begin + run.count; ++i) gap = std::min(gap, -rows.b[i] / rows.weight[i]);
  return gap;
}

// Whether the centre of a leaf of the tool is inside the object: in one of its leaves, with a skin that winds around
// it. No leaf is in the skin, so one leaf answers for its part of the tool. The answer is also yes if the work runs
// out: the leaves of the object then hold the tool outside of them, or lead it out.
bool isWithin(StepParts& parts, const PairSet& pairs, const PairRun& run) {
  const CompiledScene& scene = parts.scene;
  StepMemory& memory = parts.memory;
  const Configuration& graphic = memory.graphic;
  const CompiledObject& object = memory.objects[run.object];
  const CompiledShape& shape = scene.shapes[object.shape];
  std::fill(memory.part_settled.begin(), memory.part_settled.end(), false);
  std::uint32_t left = scene.tool_part_count;
  parts.result.work += run.count;
  for (const std::uint32_t pair : pairs.pairs.subspan(run.begin, run.count)) {
    char& is_settled = memory.part_settled[scene.tool_parts[pair >> 16]];
    if (is_settled) continue;
    const std::array<double, 3>&c = scene.tool.exact[pair >> 16], &leaf = shape.leaves.exact[pair & 0xffff];
    const Eigen::Vector3d world = graphic.position + graphic.orientation * Eigen::Vector3d(c[0], c[1], c[2]),
                          local = object.rotation.transpose() * (world - object.anchor);
    const auto radius = static_cast<double>(shape.leaves.spheres[pair & 0xffff].radius);
    if ((local - Eigen::Vector3d(leaf[0], leaf[1], leaf[2])).norm() > radius) continue;
    if (memory.cutting && memory.cutting->isRemoved(run.object, local)) continue;
    if (!parts.workLeft() || windingNumber(shape.skin, local, parts.result.work) > 0.5) return true;
    is_settled = true;
    if (--left == 0) break;
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
    bool is_free = true;
    for (; run != end && run->object == i; ++run) is_free = is_free && smallestGap(rows, *run) >= -static_cast<float>(kGapTolerance);
    if (is_free) memory.feelSkin(i);
  }
}

}  // namespace spheretree::runtime
