// SPDX-License-Identifier: GPL-3.0-or-later
#include "robot/cover/body_inertia.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>

namespace spheretree::robot {
namespace {

constexpr double kLeastMass = 1e-12;       // MuJoCo needs more than 1e-15 [kg]
constexpr double kLeastMoment = 1e-13;     // MuJoCo needs more than 1e-14 [kg m^2]
constexpr double kLeastShare = 1e-6;       // of the largest moment: a rod 400 times as long as thick has 1e-5
constexpr double kRounding = 1e-9;         // of the largest moment: margin for MuJoCo's own computation of the moments
constexpr double kUnknownMass = 0.001;     // [kg]
constexpr double kUnknownHalfSize = 0.05;  // half the edge of the cube for a link without spheres [m]

Eigen::AlignedBox3d boxAround(std::span<const MetreSphere> spheres) {
  Eigen::AlignedBox3d box;
  for (const MetreSphere& s : spheres)
    for (const double r : {-1.0 * s.radius, 1.0 * s.radius}) box.extend((Eigen::Array3d(s.x, s.y, s.z) + r).matrix());
  if (box.isEmpty()) box.extend(Eigen::Vector3d::Constant(-kUnknownHalfSize)).extend(Eigen::Vector3d::Constant(kUnknownHalfSize));
  return box;
}

Eigen::Matrix3d boxTensor(double mass, const Eigen::AlignedBox3d& box) {
  const Eigen::Array3d squares = box.sizes().array().square();
  return (mass / 12 * (squares.sum() - squares)).max(kLeastMoment).matrix().asDiagonal();
}

/// True if the tensor had to be changed.
bool mend(BodyInertia& body, const Eigen::AlignedBox3d& box) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(body.tensor);
  const Eigen::Vector3d moments = solver.eigenvalues();  // increasing
  const double c = moments[2];
  if (!body.tensor.allFinite() || !moments.allFinite() || !(c >= kLeastMoment)) {
    body.tensor = boxTensor(body.mass, box);
    return true;
  }
  const double b = std::max(moments[1], c / 2), a = std::max({moments[0], c - b, kLeastShare * c, kLeastMoment});
  if (a - moments[0] <= kRounding * c && b - moments[1] <= kRounding * c && moments[0] >= kLeastMoment) return false;
  body.tensor =
      solver.eigenvectors() * Eigen::Vector3d(a + kRounding * c, b + kRounding * c, c).asDiagonal() * solver.eigenvectors().transpose();
  return true;
}

}  // namespace

std::optional<BodyInertia> bodyInertia(const Link& link, bool is_moved, std::span<const MetreSphere> spheres) {
  const bool has_mass = link.inertia && link.inertia->mass >= kLeastMass;
  if (!has_mass && !is_moved) return std::nullopt;
  const Eigen::AlignedBox3d box = boxAround(spheres);
  BodyInertia out;
  if (!has_mass) {
    out.mass = kUnknownMass;
    out.centre = 1000 * box.center();
    out.tensor = boxTensor(out.mass, box);
    out.change = std::string(link.inertia ? "has no mass" : "has no <inertial>") + "; in the MJCF it has 1 g, as a box around its spheres";
    return out;
  }
  out.mass = link.inertia->mass;
  out.centre = link.inertia->origin.translation();
  const Eigen::Matrix3d turn = link.inertia->origin.linear();
  out.tensor = turn * link.inertia->tensor * turn.transpose();
  if (mend(out, box)) out.change = "has an inertia tensor that no solid body has; in the MJCF its moments are raised to possible ones";
  return out;
}

}  // namespace spheretree::robot
