// SPDX-License-Identifier: GPL-3.0-or-later
// Points against a distance field with continuous collision detection: the tool moves to the first time of impact, then
// on along the constraints of its contacts. There is no penalty force that pushes it out.
// Paper: H. Xu, J. Barbic. 6-DoF haptic rendering using continuous collision detection between points and signed
// distance fields. IEEE Transactions on Haptics 10(2), 2017. Gauss' principle of least constraint after M. Ortega, S.
// Redon, S. Coquillart. A six degree-of-freedom god-object method for haptic display of rigid bodies. IEEE VR 2006.
#include <algorithm>
#include <cmath>

#include "contact/qp6.h"
#include "kernel/kernel.h"
#include "published/point_shell.h"

namespace spheretree::player {
namespace {

constexpr int kMoves = 5;          // moves to a time of impact in a step
constexpr double kNear = 0.2;      // points nearer than this become constraints [mm]
constexpr double kOff = 0.01;      // distance that points keep from the surface [mm]
constexpr double kLanded = 0.005;  // in excess of kOff: within this distance, a point has hit the surface [mm]
constexpr std::size_t kMaxRows = 512;

/// Rows of a QP in the layout of qp6.h.
class Rows {
 public:
  void clear() { count_ = 0; }
  std::size_t count() const { return count_; }
  /// direction . (translation + rotation x arm) >= bound, rotations in units of `lever` [mm].
  void add(const Eigen::Vector3d& arm, const Eigen::Vector3d& direction, double bound, double lever) {
    if (count_ == kMaxRows) return;
    runtime::Vector6 a;
    a << direction, arm.cross(direction) / lever;
    const double length = a.norm();
    if (!(length > 0)) return;
    for (std::size_t k = 0; k < 6; ++k) values_[k][count_] = static_cast<float>(a[static_cast<Eigen::Index>(k)] / length);
    values_[6][count_++] = static_cast<float>(bound / length);
  }
  runtime::QpRows view() {
    for (std::size_t i = count_; i < (count_ + 15) / 8 * 8; ++i) {
      for (std::size_t k = 0; k < 6; ++k) values_[k][i] = 0;
      values_[6][i] = -1e30f;
    }
    runtime::QpRows rows;
    for (std::size_t k = 0; k < 6; ++k) rows.a[k] = values_[k].data();
    rows.b = values_[6].data();
    rows.count = static_cast<std::uint32_t>(count_);
    return rows;
  }

 private:
  std::array<std::array<float, kMaxRows + 16>, 7> values_{};
  std::size_t count_ = 0;
};

class ContinuousRenderer final : public Renderer {
 public:
  explicit ContinuousRenderer(const RendererScene& scene)
      : Renderer(scene), lever_(std::sqrt(scene.coupling.rotation / scene.coupling.translation)), model_(scene) {}

 private:
  std::uint32_t follow(const Configuration& haptic) override {
    for (int n = 0; n < kMoves; ++n) {
      const Displacement way = constrainedWay(haptic);
      if (way.translation.norm() + lever_ * way.rotation.norm() < 1e-6) break;
      const double share = timeOfImpact(way);
      graphic_ = moved(graphic_, {share * way.translation, share * way.rotation});
      if (share >= 1 && active_ == 0) break;
    }
    return active_;
  }

  /// The motion towards the hand that the near points allow (Xu and Barbic 2017, section 5: a QP with one row for
  /// each).
  Displacement constrainedWay(const Configuration& haptic) {
    rows_.clear();
    const PointShell& shell = model_.shell;
    for (std::size_t o = 0; o < poses_.size(); ++o) {
      const DistanceGrid& grid = model_.grids[o];
      const ToObject to_object(graphic_, poses_[o]);
      const auto isNear = [&](const Eigen::Vector3d& centre, double radius) {
        return grid.at(to_object(centre)).distance < DistanceGrid::kSteepest * (radius + kNear);
      };
      shell.tree.visit(isNear, [&](std::uint32_t i) {
        const DistanceGrid::Sample sample = grid.at(to_object(shell.point[i]));
        const double steep = sample.gradient.norm();
        if (!(sample.distance < kNear * steep) || !(steep > 0)) return;
        rows_.add(graphic_.orientation * shell.point[i], poses_[o].orientation * (sample.gradient / steep), kOff - sample.distance / steep,
                  lever_);
      });
    }
    const Displacement way = displacementBetween(graphic_, haptic);
    runtime::Vector6 target;
    target << way.translation, lever_ * way.rotation;
    runtime::QpAnswer answer;
    if (rows_.count() > 0)
      runtime::solveQp6(runtime::scalarKernel(), rows_.view(), target, answer);
    else
      answer.y = target;
    active_ = answer.active_count;
    if (answer.status == runtime::QpStatus::Infeasible) return {};  // squeezed: the tool rests
    return {answer.y.head<3>(), answer.y.tail<3>() / lever_};
  }

  /// The share of the motion after which a point comes within kOff of a surface, by conservative advancement.
  double timeOfImpact(const Displacement& way) const {
    double first = 1;
    for (std::size_t o = 0; o < poses_.size(); ++o) advance(o, ToObject(graphic_, poses_[o]), way, 0, first);
    return first;
  }
  void advance(std::size_t o, const ToObject& to_object, const Displacement& way, std::uint32_t at, double& first) const {
    const DistanceGrid& grid = model_.grids[o];
    const BallTree::Node& node = model_.shell.tree.nodes[at];
    const double speed = way.translation.norm() + way.rotation.norm() * (node.centre.norm() + node.radius);
    if (!(grid.at(to_object(node.centre)).distance / DistanceGrid::kSteepest - node.radius - kOff < speed * first)) return;
    if (node.left != 0) {
      advance(o, to_object, way, node.left, first);
      advance(o, to_object, way, node.left + 1, first);
      return;
    }
    for (std::uint32_t k = node.first; k < node.first + node.count; ++k) {
      const Eigen::Vector3d& p = model_.shell.point[model_.shell.tree.order[k]];
      const double own = way.translation.norm() + way.rotation.norm() * p.norm();
      double t = 0, gap = grid.at(to_object(p)).distance - kOff;
      if (gap < kLanded) continue;  // in contact: constrained by its row
      while (t < first && own > 0) {
        t += std::max(gap, kLanded) / (DistanceGrid::kSteepest * own);
        if (t >= first) break;
        const Configuration then = moved(graphic_, {t * way.translation, t * way.rotation});
        gap = grid.at(ToObject(then, poses_[o])(p)).distance - kOff;
        if (gap < kLanded) first = t;
      }
    }
  }

  const double lever_;  // [mm]
  PointModel model_;
  Rows rows_;
  std::uint32_t active_ = 0;
};

}  // namespace

std::unique_ptr<Renderer> makeContinuousRenderer(const RendererScene& scene) { return std::make_unique<ContinuousRenderer>(scene); }

}  // namespace spheretree::player
