// SPDX-License-Identifier: GPL-3.0-or-later
// Drilling by the rule of AMBF's plugin volumetric_drilling, for comparison: objects are voxels, full or empty; the
// balls of the tool follow the hand as god-objects, each by itself; a burr that spins empties the voxels that it
// touches, at most a fixed number in a step, whatever the force and the material; the force is that of a spring to the
// ball that is held back farthest, without torque. docs/renderers.md says what is theirs and what is ours.
// Papers: A. Munawar et al. Virtual reality for synergistic surgical training and data generation. Computer Methods in
//         Biomechanics and Biomedical Engineering: Imaging and Visualization 10(4), 2022. C. B. Zilles, J. K.
//         Salisbury. A constraint-based god-object method for haptic display. IROS 1995.
// Units: mm, N, N mm.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "published/renderer.h"

namespace spheretree::player {

/// The objects of a scene that a burr cuts: those of `scene`, each with the distance from its surface in its mesh
/// frame.
struct CutSolid {
  std::size_t object;
  const builder::DistanceField* field;
};

class VoxelRenderer final : public Renderer {
 public:
  static constexpr double kMostVoxels = 1 << 28;  // a byte each
  /// How many voxels of this edge the box of a solid has.
  static double voxelCount(const builder::DistanceField& field, double edge);
  /// `compiled` is `scene`: the balls of the tool are the leaves with which our runtime feels walls, and the burr.
  VoxelRenderer(const runtime::SceneDescription& scene, const runtime::Scene& compiled, std::span<const CutSolid> solids, double edge);

  void setSpindle(bool spins) { spins_ = spins; }
  void restart() override;
  /// Voxels that were full and are empty.
  std::size_t removed() const { return removed_; }
  /// The largest number that a ball of the burr removes in a step.
  static std::size_t mostRemoved(double diameter);
  std::size_t byteCount() const;

 private:
  struct Voxels {
    std::size_t object;
    Eigen::Vector3d low = Eigen::Vector3d::Zero();  // corner of the first voxel, mesh frame
    std::array<int, 3> size{};
    std::vector<std::uint8_t> is_full;
  };
  /// A voxel on the way of a ball.
  struct Hit {
    double way;  // of the ball, until it touches the voxel
    std::size_t solid, voxel;
    Eigen::Vector3d normal;  // from the voxel to the ball, world axes
  };
  struct Part {
    Eigen::Vector3d centre;  // from the reference point, axes of the tool
    double radius;
    bool is_burr;
    Eigen::Vector3d proxy = Eigen::Vector3d::Zero();  // world
    std::vector<Hit> touched = {};                    // by the burr in the last step
  };

  std::uint32_t follow(const Configuration& haptic) override;
  bool moveProxy(Part& part, const Eigen::Vector3d& goal);
  void meet(const Eigen::Vector3d& from, const Eigen::Vector3d& way, double radius);
  void addHits(std::size_t solid, const Eigen::Vector3d& from, const Eigen::Vector3d& direction, double begin, double end, double reach);

  double edge_;
  std::vector<Voxels> voxels_;  // (solid)
  std::vector<Part> parts_;
  std::vector<Hit> hits_;  // scratch
  const Part* held_ = nullptr;
  std::size_t removed_ = 0;
  bool spins_ = false, is_placed_ = false;
};

}  // namespace spheretree::player
