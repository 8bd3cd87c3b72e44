// SPDX-License-Identifier: GPL-3.0-or-later
#include "certify/redundant_spheres.h"

#include <algorithm>

#include "certify/certify_cover.h"
#include "geometry/surface_samples.h"
#include "medial/surface_regions.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr std::size_t kSamplesASphere = 40;

}  // namespace

std::vector<char> findRedundantSpheres(const TriangleMesh& mesh, std::span<const Sphere> spheres, const Vector3d& origin,
                                       std::span<const std::uint32_t> group, std::span<const char> fixed, std::size_t max_count,
                                       std::uint64_t seed, Progress& progress) {
  SampleSettings sampling;
  sampling.count = kSamplesASphere * spheres.size();
  sampling.seed = seed;
  std::vector<Vector3d> points;
  for (const SurfaceSample& s : sampleSurface(mesh, sampling)) points.push_back(s.point);
  std::vector<FittedBall> fitted;
  for (const Sphere& s : spheres)
    fitted.push_back({Vector3d(s.x, s.y, s.z) + origin, s.radius, 0});  // clearance 0: the largest balls are removed first
  const Holders holders = findHolders(points, fitted);
  std::vector<char> redundant(spheres.size(), 0), kept(spheres.size(), 0);
  std::copy(fixed.begin(), fixed.end(), kept.begin());
  // A sphere that turned out to be needed between the samples may have kept others from being candidates. Therefore
  // repeats the search with this sphere fixed.
  for (bool again = true; again;) {
    again = false;
    std::vector<std::uint32_t> left, candidates;  // candidates: indices in `left`
    std::vector<Sphere> left_spheres;
    const std::vector<char> maybe = maybeRedundant(holders, fitted, group, kept, redundant);
    const auto marked_count = static_cast<std::size_t>(std::count(redundant.begin(), redundant.end(), 1));
    for (std::uint32_t b = 0; b < spheres.size(); ++b) {
      if (redundant[b]) continue;
      if (maybe[b] && candidates.size() < max_count - marked_count) candidates.push_back(static_cast<std::uint32_t>(left.size()));
      left.push_back(b);
      left_spheres.push_back(spheres[b]);
    }
    const std::vector<char> proven = provenRedundant(mesh, left_spheres, origin, candidates, progress);
    for (const std::uint32_t i : candidates) {
      (proven[i] ? redundant : kept)[left[i]] = 1;
      again = again || !proven[i];
    }
  }
  return redundant;
}

}  // namespace spheretree::builder
