// SPDX-License-Identifier: GPL-3.0-or-later
#include "published/voxel_renderer.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "scene/compiled_scene.h"

namespace spheretree::player {
namespace {

using Eigen::Vector3d;

constexpr double kVoxelRadius = 0.7;  // of the ball that stands for a voxel, in edges; as theirs
struct BurrSize {
  double diameter;
  std::size_t most_removed;
};
constexpr std::array<BurrSize, 4> kBurrSizes{{{1, 1}, {2, 3}, {4, 6}, {6, 10}}};  // theirs [mm]
constexpr double kAlong = 1e-9;  // a ball that approaches a voxel by a smaller share of its way moves along it: rounding

}  // namespace

double VoxelRenderer::voxelCount(const builder::DistanceField& field, double edge) {
  return (field.box().sizes() / edge).array().ceil().prod();
}

std::size_t VoxelRenderer::mostRemoved(double diameter) {
  std::size_t most = kBurrSizes.front().most_removed;
  for (const BurrSize& size : kBurrSizes)
    if (diameter >= size.diameter) most = size.most_removed;
  return most;
}

VoxelRenderer::VoxelRenderer(const runtime::SceneDescription& scene, const runtime::Scene& compiled, std::span<const CutSolid> solids,
                             double edge)
    : Renderer(scene), edge_(edge) {
  const runtime::CompiledScene& tool = compiled.compiled();
  for (const std::uint32_t slot : tool.wall_slots) {
    const Sphere& ball = tool.tool.spheres[slot];
    parts_.push_back({centreOf(ball), static_cast<double>(ball.radius), slot >= tool.burr_slot});
  }
  for (const auto& [object, field] : solids) {
    Voxels& made = voxels_.emplace_back();
    made.object = object;
    made.low = field->box().min();
    for (int k = 0; k < 3; ++k) made.size[static_cast<std::size_t>(k)] = static_cast<int>(std::ceil(field->box().sizes()[k] / edge));
    const auto [columns, rows, layers] = made.size;
    for (int z = 0; z < layers; ++z)
      for (int y = 0; y < rows; ++y)
        for (int x = 0; x < columns;) {  // as far as a distance reaches, all are on the same side
          const double distance = field->signedDistance(made.low + edge * (Vector3d(x, y, z).array() + 0.5).matrix());
          const int same = std::clamp(static_cast<int>(std::min(std::abs(distance) / edge, 1e6)), 1, columns - x);
          made.is_full.insert(made.is_full.end(), static_cast<std::size_t>(same), distance < 0);
          x += same;
        }
  }
}

std::size_t VoxelRenderer::byteCount() const {
  std::size_t bytes = parts_.size() * sizeof(Part);
  for (const Voxels& voxels : voxels_) bytes += voxels.is_full.size();
  return bytes;
}

void VoxelRenderer::restart() {
  Renderer::restart();
  is_placed_ = false;
}

// The full voxels that a ball touches while it moves from `begin` to `end` along `direction`; in the frame of the
// solid.
void VoxelRenderer::addHits(std::size_t solid, const Vector3d& from, const Vector3d& direction, double begin, double end, double reach) {
  const Voxels& voxels = voxels_[solid];
  const Vector3d a = from + begin * direction - voxels.low, b = from + end * direction - voxels.low;
  std::array<int, 3> low{}, high{};
  for (int k = 0; k < 3; ++k) {
    const auto clamped = [&](double at) {
      return static_cast<int>(std::clamp(std::floor(at / edge_), -1.0, double(voxels.size[static_cast<std::size_t>(k)])));
    };
    low[static_cast<std::size_t>(k)] = std::max(0, clamped(std::min(a[k], b[k]) - reach));
    high[static_cast<std::size_t>(k)] = std::min(voxels.size[static_cast<std::size_t>(k)] - 1, clamped(std::max(a[k], b[k]) + reach));
  }
  for (int z = low[2]; z <= high[2]; ++z)
    for (int y = low[1]; y <= high[1]; ++y)
      for (int x = low[0]; x <= high[0]; ++x) {
        const auto voxel = static_cast<std::size_t>((z * voxels.size[1] + y)) * static_cast<std::size_t>(voxels.size[0]) + std::size_t(x);
        if (!voxels.is_full[voxel]) continue;
        const Vector3d apart = from - voxels.low - edge_ * (Vector3d(x, y, z).array() + 0.5).matrix();
        const double along = apart.dot(direction), root = along * along - apart.squaredNorm() + reach * reach;
        if (along > -kAlong * reach || root < 0) continue;
        const double way = std::max(0.0, -along - std::sqrt(root));
        if (way <= end) hits_.push_back({way, solid, voxel, poses_[voxels.object].orientation * (apart + way * direction).normalized()});
      }
}

// Fills hits_ with the full voxels on the first piece of the way, of the length of a voxel, that has any; the first to
// be touched comes first.
void VoxelRenderer::meet(const Vector3d& from, const Vector3d& way, double radius) {
  hits_.clear();
  const double length = way.norm();
  for (double begin = 0; begin < length && hits_.empty(); begin += edge_)
    for (std::size_t solid = 0; solid < voxels_.size(); ++solid) {
      const Configuration& pose = poses_[voxels_[solid].object];
      const Quaternion back = pose.orientation.conjugate();
      addHits(solid, back * (from - pose.position), back * (way / length), begin, std::min(begin + edge_, length),
              radius + kVoxelRadius * edge_);
    }
  std::sort(hits_.begin(), hits_.end(),
            [](const Hit& a, const Hit& b) { return std::tie(a.way, a.solid, a.voxel) < std::tie(b.way, b.solid, b.voxel); });
}

// A god-object: straight to the goal, then along the first voxel's tangent plane, then along two planes. Returns
// whether it was held back.
bool VoxelRenderer::moveProxy(Part& part, const Vector3d& goal) {
  std::array<Vector3d, 2> normal;
  part.touched.clear();
  for (std::size_t planes = 0;; ++planes) {
    Vector3d way = goal - part.proxy;
    if (planes == 1) way -= way.dot(normal[0]) * normal[0];
    if (planes == 2) {
      const Vector3d line = normal[0].cross(normal[1]);
      way = line.squaredNorm() > kAlong ? Vector3d(way.dot(line) / line.squaredNorm() * line) : Vector3d::Zero();
    }
    meet(part.proxy, way, part.radius);
    if (hits_.empty()) {
      part.proxy += way;
      return planes > 0;
    }
    if (planes == 0 && part.is_burr) {
      const std::size_t most = std::min(hits_.size(), mostRemoved(2 * part.radius));
      part.touched.assign(hits_.begin(), hits_.begin() + static_cast<std::ptrdiff_t>(most));
    }
    part.proxy += hits_.front().way * way.normalized();
    if (planes == 2) return true;
    normal[planes] = hits_.front().normal;
  }
}

std::uint32_t VoxelRenderer::follow(const Configuration& haptic) {
  const auto goalOf = [&](const Part& part) -> Vector3d { return haptic.position + haptic.orientation * part.centre; };
  for (Part& part : parts_)
    if (!is_placed_) part.proxy = goalOf(part), part.touched.clear();
  is_placed_ = true;
  if (spins_ && held_)
    for (const Hit& hit : held_->touched) {
      std::uint8_t& is_full = voxels_[hit.solid].is_full[hit.voxel];
      removed_ += is_full;
      is_full = 0;
    }
  std::uint32_t contacts = 0;
  double farthest = 0;
  held_ = nullptr;
  graphic_ = haptic;
  for (Part& part : parts_) {
    const Vector3d goal = goalOf(part);
    contacts += moveProxy(part, goal);
    if (const double way = (part.proxy - goal).norm(); way > farthest) {
      farthest = way;
      held_ = &part;
      graphic_.position = haptic.position + part.proxy - goal;
    }
  }
  return contacts;
}

}  // namespace spheretree::player
