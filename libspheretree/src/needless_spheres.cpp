// SPDX-License-Identifier: GPL-3.0-or-later
#include "spheretree/builder/needless_spheres.h"

#include <algorithm>

#include "spheretree/builder/certify_cover.h"
#include "spheretree/builder/surface_regions.h"
#include "spheretree/builder/surface_samples.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr std::size_t kSamplesASphere = 40;

}  // namespace

std::vector<char> findNeedless(const TriangleMesh& mesh, std::span<const Sphere> spheres, const Vector3d& origin,
                               std::span<const std::uint32_t> group, std::span<const char> fixed, std::size_t most, std::uint64_t seed,
                               Progress& progress) {
  SampleSettings sampling;
  sampling.count = kSamplesASphere * spheres.size();
  sampling.seed = seed;
  std::vector<Vector3d> points;
  for (const SurfaceSample& s : sampleSurface(mesh, sampling)) points.push_back(s.point);
  std::vector<FittedBall> fitted;
  for (const Sphere& s : spheres) fitted.push_back({Vector3d(s.x, s.y, s.z) + origin, 0, s.radius});  // clearance 0: the largest go first
  const std::vector<char> maybe = findRedundant(points, fitted, group, fixed);
  std::vector<std::uint32_t> candidates;
  for (std::uint32_t b = 0; b < maybe.size(); ++b)
    if (maybe[b] && candidates.size() < most) candidates.push_back(b);
  return findSpare(mesh, spheres, origin, candidates, progress);
}

}  // namespace spheretree::builder
