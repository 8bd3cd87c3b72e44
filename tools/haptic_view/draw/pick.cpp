// SPDX-License-Identifier: GPL-3.0-or-later
#include "draw/pick.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace spheretree::view {
namespace {

using Eigen::Vector3d;
constexpr double kMissed = std::numeric_limits<double>::infinity();

/// Distance to the nearest triangle along the ray.
double distanceTo(const Surface& surface, const Ray& ray) {
  double nearest = kMissed;
  for (std::size_t t = 0; t + 2 < surface.indices.size(); t += 3) {
    const auto corner = [&](std::size_t k) -> Vector3d { return surface.corners[surface.indices[t + k]].position.cast<double>(); };
    const Vector3d a = corner(0), ab = corner(1) - a, ac = corner(2) - a, p = ray.direction.cross(ac);
    const double det = ab.dot(p);
    if (det == 0) continue;
    const Vector3d from_a = ray.origin - a, q = from_a.cross(ab);
    const double u = from_a.dot(p) / det, v = ray.direction.dot(q) / det, along = ac.dot(q) / det;
    if (u >= 0 && v >= 0 && u + v <= 1 && along > 0) nearest = std::min(nearest, along);
  }
  return nearest;
}

double distanceTo(const std::vector<Ball>& balls, const Ray& ray) {
  double nearest = kMissed;
  for (const Ball& ball : balls) {
    const Vector3d from = ray.origin - Vector3d(ball.x, ball.y, ball.z);
    const double middle = -from.dot(ray.direction), r = static_cast<double>(ball.radius);
    const double square = r * r - (from + middle * ray.direction).squaredNorm();
    if (square >= 0 && middle > 0) nearest = std::min(nearest, middle - std::sqrt(square));
  }
  return nearest;
}

/// Whether the ray comes near the box, so that the geometry must be searched. Balls reach a little beyond the box.
bool meets(const Eigen::AlignedBox3d& box, const Ray& ray) {
  const Vector3d to_centre = box.center() - ray.origin;
  const double reach = 0.6 * box.sizes().norm();
  return (to_centre - to_centre.dot(ray.direction) * ray.direction).norm() <= reach;
}

double distanceTo(const Body& body, const Look& look, const Ray& ray) {
  if (look.objects == Geometry::Contact && look.skin_contact && !body.skin.empty()) return distanceTo(body.skin, ray);
  if (body.levels.empty() || (look.objects == Geometry::Meshes && !body.mesh.empty())) return distanceTo(body.mesh, ray);
  const std::size_t last = body.levels.size() - 1;
  const bool by_level = look.objects == Geometry::Spheres || look.objects == Geometry::Bounds;
  const std::size_t level = by_level ? std::min(static_cast<std::size_t>(std::max(look.level, 0)), last) : last;
  return distanceTo(look.objects == Geometry::Bounds ? body.bounds[level] : body.levels[level], ray);
}

}  // namespace

std::optional<std::size_t> pickObject(const Stage& stage, const Look& look, const ShownState& state, const Ray& ray) {
  std::optional<std::size_t> found;
  double nearest = kMissed;
  for (std::size_t i = 0; i < stage.objects.size(); ++i) {
    const Body& body = stage.bodies[stage.objects[i].body];
    if (!look.shows(i) || body.box.isEmpty()) continue;
    const Configuration pose = state.poseOf(stage.objects[i]);
    const Quaternion back = pose.orientation.conjugate();
    const Ray own{back * (ray.origin - pose.position), back * ray.direction};
    if (!meets(body.box, own)) continue;
    const double distance = distanceTo(body, look, own);
    if (distance < nearest) nearest = distance, found = i;
  }
  return found;
}

std::optional<double> gapToObject(const Stage& stage, const ShownState& state, std::size_t object) {
  if (!state.has_tool || !stage.tool) return std::nullopt;
  const Body &tool = stage.bodies[*stage.tool], &body = stage.bodies[stage.objects[object].body];
  if (tool.levels.empty() || body.levels.empty()) return std::nullopt;
  // The tool's leaves in the frame of the object.
  const Configuration pose = state.poseOf(stage.objects[object]);
  const Quaternion back = pose.orientation.conjugate();
  const Configuration& g = state.graphic;
  double smallest = kMissed;
  for (const Ball& leaf : tool.levels.back()) {
    const Vector3d in_world = g.position + g.orientation * (Vector3d(leaf.x, leaf.y, leaf.z) - stage.reference_point);
    const Eigen::Vector3f at = (back * (in_world - pose.position)).cast<float>();
    for (const Ball& ball : body.levels.back()) {
      const float gap = (Eigen::Vector3f(ball.x, ball.y, ball.z) - at).norm() - ball.radius - leaf.radius;
      smallest = std::min(smallest, static_cast<double>(gap));
    }
  }
  return smallest;
}

}  // namespace spheretree::view
