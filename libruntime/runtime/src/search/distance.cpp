// SPDX-License-Identifier: Apache-2.0
// The distance of tool and object: branch and bound over the search trees of both, nearest pairs of nodes first.
// Paper: S. Quinlan. Efficient distance computation between non-convex objects. ICRA 1994.
// Units: mm; frame of the search: axes of the object, origin at the centre of its shape.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "state/step_memory.h"

namespace spheretree::runtime {
namespace {

using Eigen::Vector3d;

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr std::size_t kPending = 512;  // pairs of nodes that wait; each level of the two trees adds at most 7

Vector3d vectorOf(const float (&p)[3]) { return {p[0], p[1], p[2]}; }

Vector3d nearestOfSegment(const Vector3d& a, const Vector3d& b, const Vector3d& p) {
  const Vector3d way = b - a;
  const double square = way.squaredNorm();
  return square > 0 ? Vector3d(a + std::clamp((p - a).dot(way) / square, 0.0, 1.0) * way) : a;
}

// The foot of the perpendicular if it lies in the triangle, else the nearest point of the three sides. For a triangle
// that is almost a segment the foot may be missed by rounding; the sides are then as near.
Vector3d nearestOfTriangle(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& p) {
  const Vector3d across = (b - a).cross(c - a);
  const double square = across.squaredNorm();
  const bool is_above =
      across.dot((b - a).cross(p - a)) >= 0 && across.dot((c - b).cross(p - b)) >= 0 && across.dot((a - c).cross(p - c)) >= 0;
  if (square > 0 && is_above) return p - across.dot(p - a) / square * across;
  Vector3d best = nearestOfSegment(a, b, p);
  for (const Vector3d& other : {nearestOfSegment(b, c, p), nearestOfSegment(c, a, p)})
    if ((other - p).squaredNorm() < (best - p).squaredNorm()) best = other;
  return best;
}

struct Ball {
  Vector3d centre;
  double radius;
};

// Of inner nodes, the float that was rounded; of leaves, the centre before rounding.
Ball ballOf(const CompiledTree& tree, std::uint32_t slot) {
  const Block& block = tree.bound[slot / 8];
  const std::uint32_t lane = slot % 8;
  const auto radius = static_cast<double>(block.r[lane]);
  if (!tree.exact.empty()) return {Vector3d(tree.exact[slot].data()), radius};
  return {{block.x[lane], block.y[lane], block.z[lane]}, radius};
}

struct Nearest {
  double gap;  // of the nearest pair
  Vector3d centre, on_object;
  double lower = kInfinite;  // of the gaps of pairs that were not opened
};

class DistanceSearch {
 public:
  DistanceSearch(const CompiledTree& tool, const CompiledShape& shape, const Eigen::Matrix3d& rotation, const Vector3d& offset,
                 double rounding)
      : tool_(tool),
        shape_(shape),
        object_(shape.skin.empty() ? shape.leaves : shape.skin.tree),
        rotation_(rotation),
        offset_(offset),
        rounding_(rounding) {}

  Nearest run(double limit) {
    Nearest best{limit, Vector3d::Zero(), Vector3d::Zero()};
    add(0, 0, best.gap);
    while (count_ > 0) {
      const Pending next = pending_[--count_];
      if (next.gap > best.gap) continue;
      const bool tool_opens = tool_.isInner(next.tool), object_opens = object_.isInner(next.object);
      if (!tool_opens && !object_opens)
        measure(next, best);
      else if (count_ + 8 > kPending)
        best.lower = std::min(best.lower, next.gap);
      else if (tool_opens && (!object_opens || radiusOf(tool_, next.tool) > radiusOf(object_, next.object)))
        open<true>(next, best.gap);
      else
        open<false>(next, best.gap);
    }
    return best;
  }

 private:
  struct Pending {
    double gap;
    std::uint32_t tool, object;
  };
  static double radiusOf(const CompiledTree& tree, std::uint32_t slot) { return static_cast<double>(tree.bound[slot / 8].r[slot % 8]); }

  Ball toolBall(std::uint32_t slot) const {
    const Ball ball = ballOf(tool_, slot);
    return {rotation_ * ball.centre + offset_, ball.radius};
  }

  void add(std::uint32_t tool, std::uint32_t object, double best) {
    const Ball a = toolBall(tool), b = ballOf(object_, object);
    const double gap = (a.centre - b.centre).norm() - a.radius - b.radius - rounding_;
    if (gap <= best) pending_[count_++] = {gap, tool, object};
  }

  template <bool kOfTool>
  void open(const Pending& pair, double best) {
    const CompiledTree& tree = kOfTool ? tool_ : object_;
    const std::uint32_t slot = kOfTool ? pair.tool : pair.object, block = tree.links[slot / 8].first_child + slot % 8;
    const std::size_t first = count_;
    for (std::uint32_t child = 8 * block; child < 8 * block + 8; ++child) {
      if (!tree.isInner(child) && tree.item[child] == kNoItem) continue;
      add(kOfTool ? child : pair.tool, kOfTool ? pair.object : child, best);
    }
    std::sort(pending_.begin() + static_cast<std::ptrdiff_t>(first), pending_.begin() + static_cast<std::ptrdiff_t>(count_),
              [](const Pending& a, const Pending& b) { return a.gap > b.gap; });
  }

  void measure(const Pending& pair, Nearest& best) const {
    const Ball ball = toolBall(pair.tool);
    Vector3d point;
    double gap;
    if (shape_.skin.empty()) {
      const Ball leaf = ballOf(object_, pair.object);
      const Vector3d way = ball.centre - leaf.centre;
      const double distance = way.norm();
      point = leaf.centre + (distance > 0 ? Vector3d(leaf.radius / distance * way) : Vector3d::Zero());
      gap = distance - leaf.radius - ball.radius;
    } else {
      const CompiledPatch& patch = shape_.skin.patch[object_.item[pair.object]];
      point = nearestOfTriangle(vectorOf(patch.position[0]), vectorOf(patch.position[1]), vectorOf(patch.position[2]), ball.centre);
      gap = (ball.centre - point).norm() - ball.radius;
    }
    if (gap < best.gap) best = {gap, ball.centre, point, best.lower};
  }

  const CompiledTree& tool_;
  const CompiledShape& shape_;
  const CompiledTree& object_;
  const Eigen::Matrix3d rotation_;
  const Vector3d offset_;
  const double rounding_;  // bound of the errors of a gap [mm]
  std::array<Pending, kPending> pending_;
  std::size_t count_ = 0;
};

}  // namespace

bool distance(std::size_t object, const Configuration& tool, double limit, const Workspace& workspace, Distance& out) noexcept {
  const StepMemory& memory = workspace.memory();
  if (object >= memory.objects.size() || !isFinite(tool) || std::isnan(limit)) return false;
  const CompiledScene& scene = memory.scene;
  const CompiledShape& shape = scene.shapeOf(object);
  const bool has_skin = !shape.skin.empty();
  const Configuration pose = objectPose(object, workspace), local = composed(inverse(pose), {tool.position, tool.orientation.normalized()});
  const Vector3d offset = local.position - shape.centre;
  // Bounds of the rounding errors of floats relative to the centre of the shape and to the reference point of the tool,
  // and of the doubles of the world.
  const double reach = scene.tool.reach + std::max({shape.radius, shape.leaves.reach, shape.skin.tree.reach}),
               rounding = kFloatRounding * reach + 1e-14 * (tool.position.norm() + pose.position.norm() + shape.centre.norm());
  const double object_error = has_skin ? static_cast<double>(shape.mesh_distance) : 0, far_limit = limit + object_error + rounding;
  const Nearest nearest = DistanceSearch(scene.tool, shape, local.orientation.toRotationMatrix(), offset, rounding).run(far_limit);
  out = {limit, kInfinite, Vector3d::Zero(), Vector3d::Zero()};
  if (!(nearest.gap < far_limit)) return true;
  out.lower = std::min(nearest.gap, nearest.lower) - object_error - rounding;
  const float object_overhang = has_skin ? shape.mesh_distance : shape.overhang;
  if (scene.tool_overhang >= 0 && object_overhang >= 0)
    out.upper = std::max(0.0, nearest.gap) + static_cast<double>(scene.tool_overhang) + static_cast<double>(object_overhang) + rounding;
  const Vector3d way = nearest.on_object - nearest.centre;
  const double length = way.norm(), radius = length - nearest.gap;
  const auto toWorld = [&](const Vector3d& p) { return Vector3d(pose.orientation * (p + shape.centre) + pose.position); };
  out.on_tool = toWorld(length > 0 ? Vector3d(nearest.centre + radius / length * way) : nearest.centre);
  out.on_object = toWorld(nearest.on_object);
  return true;
}

}  // namespace spheretree::runtime
