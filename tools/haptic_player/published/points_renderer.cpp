// SPDX-License-Identifier: GPL-3.0-or-later
// Points against a distance field with penalty forces and a static virtual coupling.
// Papers: W. A. McNeely, K. D. Puterbaugh, J. J. Troy. Six degree-of-freedom haptic rendering using voxel sampling.
//         SIGGRAPH 1999. J. Barbic, D. L. James. Six-DoF haptic rendering of contact between geometrically complex
//         reduced deformable models. IEEE Transactions on Haptics 1(1), 2008.
#include "published/point_shell.h"
#include "published/static_coupling.h"

namespace spheretree::player {
namespace {

constexpr double kPointStiffness = 10;  // stiffness of a point, as a multiple of the coupling's; Barbic and James also scale by hand

class PointsRenderer final : public PenaltyRenderer {
 public:
  explicit PointsRenderer(const RendererScene& scene) : PenaltyRenderer(scene), model_(scene) {}

 private:
  /// McNeely 1999, equation 1: F = k d n for each point at depth d, here along the inward normal of the point (Barbic
  /// and James 2008, section 5), summed to a wrench.
  Penalty penaltyAt(const Configuration& tool) const override {
    Penalty penalty;
    const PointShell& shell = model_.shell;
    const double stiffness = kPointStiffness * coupling_.translation;
    for (std::size_t o = 0; o < poses_.size(); ++o) {
      const DistanceGrid& grid = model_.grids[o];
      const ToObject to_object(tool, poses_[o]);
      const auto mayTouch = [&](const Eigen::Vector3d& centre, double radius) {
        return grid.at(to_object(centre)).distance < DistanceGrid::kSteepest * radius;
      };
      shell.tree.visit(mayTouch, [&](std::uint32_t i) {
        const DistanceGrid::Sample sample = grid.at(to_object(shell.point[i]));
        if (!(sample.distance < 0)) return;
        penalty.add(tool.orientation * shell.point[i], tool.orientation * -shell.normal[i], stiffness * -sample.distance,
                    poses_[o].orientation * sample.gradient, stiffness);
      });
    }
    return penalty;
  }

  PointModel model_;
};

}  // namespace

std::unique_ptr<Renderer> makePointsRenderer(const RendererScene& scene) { return std::make_unique<PointsRenderer>(scene); }

}  // namespace spheretree::player
