// SPDX-License-Identifier: Apache-2.0
#include "step/inside.h"

#include <cmath>

#include "step/step_parts.h"

namespace spheretree::runtime {
namespace {

constexpr double kFar = 2;                  // triangles below a node are seen as one face from this many radii
constexpr std::uint32_t kTriangleWork = 5;  // cost of a solid angle, in 8-lane tests

Eigen::Vector3d vectorOf(const float (&p)[3]) { return {p[0], p[1], p[2]}; }

double halfSolidAngle(const CompiledPatch& patch, const Eigen::Vector3d& point) {
  Eigen::Vector3d v[3];
  for (int k = 0; k < 3; ++k) v[k] = vectorOf(patch.position[k]) - point;
  const double a = v[0].norm(), b = v[1].norm(), c = v[2].norm();
  return std::atan2(v[0].dot(v[1].cross(v[2])), a * b * c + v[0].dot(v[1]) * c + v[1].dot(v[2]) * a + v[2].dot(v[0]) * b);
}

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

double windingNumber(const CompiledSkin& skin, const Eigen::Vector3d& point, std::uint32_t& work) {
  std::array<std::uint32_t, 128> open{};  // blocks
  std::size_t count = 1;
  double half_angles = 0;
  while (count > 0) {
    const std::uint32_t block = open[--count];
    for (std::uint32_t lane = 0; lane < 8; ++lane) {
      if (const std::uint32_t item = skin.tree.item[8 * block + lane]; item != kNoItem) {
        half_angles += halfSolidAngle(skin.patch[item], point);
        work += kTriangleWork;
      } else if (lane < skin.tree.links[block].inner) {
        const std::uint32_t child = skin.tree.links[block].first_child + lane;
        const FarFace& face = skin.far[child];
        const Eigen::Vector3d way = vectorOf(face.centre) - point;
        const double distance = way.norm();
        ++work;
        if (distance > kFar * static_cast<double>(face.radius) || count == open.size())
          half_angles += 0.5 * vectorOf(face.area).dot(way) / (distance * distance * distance);
        else
          open[count++] = child;
      }
    }
  }
  return half_angles / (2 * M_PI);
}

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
