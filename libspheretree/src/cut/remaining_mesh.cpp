// SPDX-License-Identifier: GPL-3.0-or-later
#include "cut/remaining_mesh.h"

#include <Eigen/Geometry>
#include <optional>
#include <string>

#include "cut/swept_surface.h"
#include "repair/subtract_solid.h"
#include "spheretree/builder/build_settings.h"

namespace spheretree::builder {
namespace {

// Share of the tolerance that capsules take that join steps, and vertices that the cut moves, most often by rounding
// alone; the rest is for the surface of what the capsules sweep.
constexpr double kSlackShare = 0.075;

}  // namespace

RemainingMesh remainingMesh(const TriangleMesh& object, std::span<const BurrPath> paths, double tolerance, Progress& progress) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : object.positions) box.extend(p);
  const double slack = kSlackShare * tolerance, of_surface = tolerance - 2 * slack;
  std::vector<Capsule> capsules = sweptCapsules(paths, slack);
  std::erase_if(capsules, [&](const Capsule& c) {
    const Eigen::AlignedBox3d axis(c.from.cwiseMin(c.to), c.from.cwiseMax(c.to));
    return axis.squaredExteriorDistance(box) > (c.radius + tolerance) * (c.radius + tolerance);
  });
  if (capsules.empty()) return {object, 0};
  progress.stage("surface of the cut");
  const TriangleMesh swept = sweptSurface(capsules, of_surface, progress);
  progress.stage("cut");
  std::optional<Difference> left = subtractSolid(object, swept, progress);
  const double bound = left ? slack + of_surface + left->moved : 0;
  if (!left || bound > tolerance)
    throw BuildError("the cut cannot be made with a tolerance of " + std::to_string(tolerance) + " mm. Give another one.");
  return {std::move(left->mesh), bound};
}

}  // namespace spheretree::builder
