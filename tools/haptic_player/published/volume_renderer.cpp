// SPDX-License-Identifier: GPL-3.0-or-later
// Inner spheres with a penalty proportional to their common volume, and a static virtual coupling.
// Paper: R. Weller, G. Zachmann. Inner sphere trees for proximity and penetration queries. Robotics: Science and
// Systems 2009, section V (penetration volume), and A unified approach for physically-based simulations and haptic
// rendering, ACM SIGGRAPH Video Game Symposium 2009 (forces and torques).
#include <algorithm>
#include <cmath>
#include <numbers>

#include "published/inner_spheres.h"
#include "published/static_coupling.h"

namespace spheretree::player {
namespace {

constexpr double kVolumeStiffness = 300;       // force for each mm^3, divided by the coupling's for each mm [1/mm^2]
constexpr std::size_t kMin = 50, kMax = 5000;  // spheres of a body

struct Lens {
  double volume, slope;  // [mm^3], and its decrease for each mm that the centres move apart [mm^2]
  double from_first;     // distance of its middle from the first centre, along the line of centres [mm]
};

/// The lens of two balls whose centres are `d` apart, d < a + b.
Lens lensOf(double a, double b, double d) {
  if (d <= std::abs(a - b)) {  // one ball is within the other: all directions out are equally long
    const double small = std::min(a, b);
    return {4.0 / 3 * std::numbers::pi * small * small * small, std::numbers::pi * small * small, b < a ? d : 0};
  }
  const double sum = a + b - d, plane = (d * d + a * a - b * b) / (2 * d);
  const double volume = std::numbers::pi * sum * sum * (d * d + 2 * d * (a + b) - 3 * (a - b) * (a - b)) / (12 * d);
  return {volume, std::numbers::pi * std::max(0.0, a * a - plane * plane), plane};
}

class VolumeRenderer final : public PenaltyRenderer {
 public:
  explicit VolumeRenderer(const RendererScene& scene)
      : PenaltyRenderer(scene), reference_point_(scene.reference_point), tool_(*scene.tool, countFor(scene)) {
    for (const PlacedBody& object : scene.objects) objects_.emplace_back(*object.body, countFor(scene));
  }

 private:
  static std::size_t countFor(const RendererScene& scene) {
    return std::clamp(scene.bytes / InnerSpheres::kBytes / (scene.objects.size() + 1), kMin, kMax);
  }

  Penalty penaltyAt(const Configuration& tool) const override {
    Penalty penalty;
    for (std::size_t o = 0; o < objects_.size(); ++o) {
      ToObject to_object(tool, poses_[o]);
      to_object.shift -= to_object.turn * reference_point_;  // the spheres are in the mesh frame of the tool
      collide(o, tool, to_object, 0, penalty);
    }
    return penalty;
  }

  /// Tests a node of the tool's hierarchy against the whole hierarchy of the object, in the frame of the object.
  void collide(std::size_t o, const Configuration& tool, const ToObject& to_object, std::uint32_t at, Penalty& penalty) const {
    const InnerSpheres& object = objects_[o];
    if (tool_.tree.nodes.empty()) return;
    const BallTree::Node& node = tool_.tree.nodes[at];
    const Eigen::Vector3d centre = to_object(node.centre);
    bool touches = false;
    object.tree.visit(
        [&](const Eigen::Vector3d& c, double r) { return !touches && (c - centre).squaredNorm() < (r + node.radius) * (r + node.radius); },
        [&](std::uint32_t) { touches = true; });
    if (!touches) return;
    if (node.left != 0) {
      collide(o, tool, to_object, node.left, penalty);
      collide(o, tool, to_object, node.left + 1, penalty);
      return;
    }
    for (std::uint32_t k = node.first; k < node.first + node.count; ++k) {
      const std::uint32_t i = tool_.tree.order[k];
      const Eigen::Vector3d ball = to_object(tool_.centre[i]);
      const double a = tool_.radius[i];
      object.tree.visit([&](const Eigen::Vector3d& c, double r) { return (c - ball).squaredNorm() < (r + a) * (r + a); },
                        [&](std::uint32_t j) { addPair(object.centre[j], object.radius[j], ball, a, o, tool, penalty); });
    }
  }

  /// Weller and Zachmann: the force of a pair is its common volume, in the direction of the line of centres, at the
  /// middle of the lens.
  void addPair(const Eigen::Vector3d& other, double b, const Eigen::Vector3d& ball, double a, std::size_t o, const Configuration& tool,
               Penalty& penalty) const {
    const Eigen::Vector3d away = ball - other;
    const double d = away.norm();
    if (!(d < a + b) || !(d > 0)) return;
    const Lens lens = lensOf(b, a, d);
    const double stiffness = kVolumeStiffness * coupling_.translation;
    const Configuration& pose = poses_[o];
    const Eigen::Vector3d normal = pose.orientation * (away / d),
                          place = pose.orientation * (other + away * (lens.from_first / d)) + pose.position;
    penalty.add(place - tool.position, normal, stiffness * lens.volume, normal, stiffness * lens.slope);
  }

  Eigen::Vector3d reference_point_;
  InnerSpheres tool_;
  std::vector<InnerSpheres> objects_;
};

}  // namespace

std::unique_ptr<Renderer> makeVolumeRenderer(const RendererScene& scene) { return std::make_unique<VolumeRenderer>(scene); }

}  // namespace spheretree::player
