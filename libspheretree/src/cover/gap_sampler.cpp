// SPDX-License-Identifier: GPL-3.0-or-later
#include "cover/gap_sampler.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <set>

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr double kShortSide = 2;  // longest side of a triangle that is searched for gaps, in widths of a patch

double widthOfPatch(const DistanceField& field, std::size_t balls) { return std::sqrt(1.2 * field.area() / static_cast<double>(balls)); }

}  // namespace

GapSampler::GapSampler(const TriangleMesh& mesh, const DistanceField& field, std::size_t balls, double spacing)
    : mesh_(subdivided(mesh, std::max(kShortSide * widthOfPatch(field, balls), 1e-3 * field.diagonal()))),
      spacing_(spacing * widthOfPatch(field, balls)),
      all_(mesh_.triangles.size()),
      held_by_(mesh_.triangles.size()) {
  std::iota(all_.begin(), all_.end(), 0u);
  for (HeldBy& balls_of : held_by_) balls_of.fill(kNoBall);
  std::vector<Eigen::AlignedBox3d> boxes(mesh_.triangles.size());
  for (std::size_t t = 0; t < boxes.size(); ++t)
    for (int k = 0; k < 3; ++k) boxes[t].extend(mesh_.corner(t, k));
  triangles_ = BoxTree(boxes, 4);
}

std::vector<Vector3d> GapSampler::find(std::span<const Ball> balls, double h, double tolerance, const std::vector<Ball>* left,
                                       Progress& progress) {
  std::vector<std::uint32_t> near;
  if (!left) {
    near = all_;
  } else {
    std::vector<char> marked(all_.size(), 0);
    for (const std::uint32_t t : open_) marked[t] = 1;
    for (const Ball& b : *left) {
      const double held = b.radius + (1 + tolerance) * h;
      triangles_.searchWithin(b.centre, held * held, [&](std::size_t first, std::size_t count) {
        for (std::size_t slot = first; slot < first + count; ++slot) marked[triangles_.order()[slot]] = 1;
      });
    }
    for (const std::uint32_t t : all_)
      if (marked[t]) near.push_back(t);
  }
  looked_at_ = near.size();
  std::vector<Ball> grown(balls.begin(), balls.end());
  for (Ball& b : grown) b.radius += h;
  std::vector<CoverGap> gaps = findCoverGaps(mesh_, near, grown, tolerance * h, progress, held_by_);
  open_.clear();
  for (const CoverGap& g : gaps) open_.push_back(g.triangle);
  std::stable_sort(gaps.begin(), gaps.end(), [](const CoverGap& a, const CoverGap& b) { return a.gap > b.gap; });
  std::set<std::array<std::int64_t, 3>> taken;
  std::vector<Vector3d> points;
  for (const CoverGap& g : gaps) {
    const Vector3d cell = g.point / spacing_;
    if (taken.insert({std::llround(cell.x()), std::llround(cell.y()), std::llround(cell.z())}).second) points.push_back(g.point);
  }
  return points;
}

}  // namespace spheretree::builder
