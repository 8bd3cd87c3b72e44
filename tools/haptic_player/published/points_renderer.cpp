// SPDX-License-Identifier: GPL-3.0-or-later
// Points against a distance field with penalty forces and a static virtual coupling.
// Papers: W. A. McNeely, K. D. Puterbaugh, J. J. Troy. Six degree-of-freedom haptic rendering using voxel sampling.
//         SIGGRAPH 1999. J. Barbic, D. L. James. Six-DoF haptic rendering of contact between geometrically complex
//         reduced deformable models. IEEE Transactions on Haptics 1(1), 2008.
#include "published/distance_grid.h"
#include "published/point_shell.h"
#include "published/renderer_kinds.h"
#include "published/static_coupling.h"
#include "scenarios/measures.h"

namespace spheretree::player {
namespace {

constexpr double kPointStiffness = 10;  // of a point, times that of the coupling; Barbic and James scale by hand as well

class PointsRenderer final : public Renderer {
 public:
  explicit PointsRenderer(const RendererScene& scene)
      : coupling_(scene.coupling), shell_(*scene.tool, scene.reference_point, pointBudget(scene.bytes, scene.objects.size()).points) {
    const std::size_t bytes = pointBudget(scene.bytes, scene.objects.size()).grid_bytes;
    for (const PlacedBody& object : scene.objects) {
      grids_.emplace_back(object.body->field, bytes);
      poses_.push_back(object.pose);
    }
  }

  runtime::StepResult step(const Configuration& haptic) override {
    if (!is_started_) graphic_ = haptic;
    is_started_ = true;
    const Penalty penalty = penaltyAt(graphic_);
    graphic_ = balanced(coupling_, haptic, graphic_, penalty);
    return resultOf(coupling_, haptic, graphic_, penalty.contacts);
  }
  void restart() override { is_started_ = false; }
  void moveObject(std::size_t object, const Configuration& pose) override { poses_[object] = pose; }

 private:
  /// McNeely 1999, equation 1: F = k d n for each point at depth d, here along the inward normal of the point (Barbic
  /// and James 2008, section 5), summed to a wrench.
  Penalty penaltyAt(const Configuration& tool) const {
    Penalty penalty;
    const double stiffness = kPointStiffness * coupling_.translation;
    for (std::size_t o = 0; o < grids_.size(); ++o) {
      const DistanceGrid& grid = grids_[o];
      const Quaternion turn = (poses_[o].orientation.conjugate() * tool.orientation).normalized();
      const Eigen::Vector3d shift = poses_[o].orientation.conjugate() * (tool.position - poses_[o].position);
      shell_.tree.visit([&](const Eigen::Vector3d& centre,
                            double radius) { return grid.at(turn * centre + shift).distance < DistanceGrid::kSteepest * radius; },
                        [&](std::uint32_t i) {
                          const DistanceGrid::Sample sample = grid.at(turn * shell_.point[i] + shift);
                          if (!(sample.distance < 0)) return;
                          const Eigen::Vector3d arm = tool.orientation * shell_.point[i], inward = tool.orientation * -shell_.normal[i],
                                                out = poses_[o].orientation * sample.gradient;
                          penalty.add(arm, inward, stiffness * -sample.distance, out, stiffness);
                        });
    }
    return penalty;
  }

  runtime::Coupling coupling_;
  PointShell shell_;
  std::vector<DistanceGrid> grids_;
  std::vector<Configuration> poses_;
  Configuration graphic_;
  bool is_started_ = false;
};

}  // namespace

std::unique_ptr<Renderer> makePointsRenderer(const RendererScene& scene) { return std::make_unique<PointsRenderer>(scene); }

}  // namespace spheretree::player
