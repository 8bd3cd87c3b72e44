// SPDX-License-Identifier: GPL-3.0-or-later
#include "spheretree/builder/needless_spheres.h"

#include <algorithm>

#include "spheretree/builder/ball.h"
#include "spheretree/builder/certify_cover.h"
#include "spheretree/builder/surface_regions.h"
#include "spheretree/builder/surface_samples.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr std::size_t kSamplesASphere = 40;

class GroupTest {
 public:
  GroupTest(const TriangleMesh& mesh, std::span<const Ball> balls, const Vector3d& origin, double resolution, Progress& progress)
      : mesh_(mesh), balls_(balls), origin_(origin), resolution_(resolution), progress_(progress), needless_(balls.size(), 0) {}

  // All at once if they can be spared together, else one half after the other.
  void spare(std::span<const std::uint32_t> candidates) {
    if (candidates.empty()) return;
    for (const std::uint32_t b : candidates) needless_[b] = 1;
    if (covers()) return;
    for (const std::uint32_t b : candidates) needless_[b] = 0;
    if (candidates.size() == 1) return;
    const std::size_t half = candidates.size() / 2;
    spare(candidates.first(half));
    spare(candidates.subspan(half));
  }
  std::vector<char> take() { return std::move(needless_); }

 private:
  bool covers() {
    std::vector<Ball> left;
    for (std::size_t b = 0; b < balls_.size(); ++b)
      if (!needless_[b]) left.push_back(balls_[b]);
    return certifyCover(mesh_, left, origin_, resolution_, progress_).largest_growth == 0;
  }

  const TriangleMesh& mesh_;
  std::span<const Ball> balls_;
  const Vector3d& origin_;
  double resolution_;
  Progress& progress_;
  std::vector<char> needless_;
};

}  // namespace

std::vector<char> findNeedless(const TriangleMesh& mesh, std::span<const Sphere> spheres, const Vector3d& origin,
                               std::span<const std::uint32_t> group, std::span<const char> fixed, std::size_t most, double resolution,
                               std::uint64_t seed, Progress& progress) {
  SampleSettings sampling;
  sampling.count = kSamplesASphere * spheres.size();
  sampling.seed = seed;
  std::vector<Vector3d> points;
  for (const SurfaceSample& s : sampleSurface(mesh, sampling)) points.push_back(s.point);
  std::vector<Ball> balls;
  std::vector<FittedBall> fitted;
  for (const Sphere& s : spheres) {
    balls.push_back({Vector3d(s.x, s.y, s.z) + origin, s.radius});
    fitted.push_back({balls.back().centre, 0, s.radius});  // clearance 0: the largest go first
  }
  const std::vector<char> maybe = findRedundant(points, fitted, group, fixed);
  std::vector<std::uint32_t> candidates;
  for (std::uint32_t b = 0; b < maybe.size(); ++b)
    if (maybe[b] && candidates.size() < most) candidates.push_back(b);
  GroupTest test(mesh, balls, origin, resolution, progress);
  test.spare(candidates);
  return test.take();
}

}  // namespace spheretree::builder
