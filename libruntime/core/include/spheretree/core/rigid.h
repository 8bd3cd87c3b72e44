// SPDX-License-Identifier: Apache-2.0
// Rigid motion: the configuration of a tool, the displacement between two configurations, and the wrench on the tool.
// Units: mm, rad, N, N mm. Rotations are unit quaternions (w, x, y, z) from body axes to world axes. There are no Euler
// angles, hence no singular poses.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

namespace spheretree {

// Unaligned, so that the layout does not depend on the instruction set a user compiles for.
using Quaternion = Eigen::Quaternion<double, Eigen::DontAlign>;

/// Position of the reference point in the world [mm] and orientation (body to world).
struct Configuration {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Quaternion orientation{1, 0, 0, 0};
};

/// A step: translation of the reference point [mm] and rotation vector about it [rad], both in world axes.
struct Displacement {
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
  Eigen::Vector3d rotation = Eigen::Vector3d::Zero();
};

/// Force [N] and torque [N mm] in world axes; the torque is about the reference point.
struct Wrench {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  Eigen::Vector3d torque = Eigen::Vector3d::Zero();
};

/// The same wrench with its torque about `to` instead of `from` (two points of the world [mm]).
inline Wrench wrenchAbout(const Wrench& wrench, const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  return {wrench.force, wrench.torque + (from - to).cross(wrench.force)};
}

/// exp: the rotation by |v| rad about the axis v. Smooth at v = 0.
inline Quaternion rotationOf(const Eigen::Vector3d& v) {
  const double angle = v.norm();
  // Below 1e-4 rad the series is exact to double precision: the next term is x^4 / 3840.
  const double scale = angle < 1e-4 ? 0.5 - angle * angle / 48 : std::sin(angle / 2) / angle;
  const Eigen::Vector3d xyz = v * scale;
  return {std::cos(angle / 2), xyz.x(), xyz.y(), xyz.z()};
}

/// log: the rotation vector of `q`, of length [0, pi]. q and -q give the same vector.
inline Eigen::Vector3d rotationVector(const Quaternion& q) {
  const double sign = q.w() < 0 ? -1 : 1;
  const Eigen::Vector3d xyz = sign * Eigen::Vector3d(q.x(), q.y(), q.z());
  const double sine = xyz.norm(), cosine = sign * q.w();
  if (sine < 1e-8) return xyz * 2.0;
  return xyz * (2 * std::atan2(sine, cosine) / sine);
}

/// The configuration after `step`. moved(a, displacementBetween(a, b)) is b up to rounding.
inline Configuration moved(const Configuration& from, const Displacement& step) {
  return {from.position + step.translation, (rotationOf(step.rotation) * from.orientation).normalized()};
}

/// The displacement from `from` to `to`, with the shorter of the two possible rotations.
inline Displacement displacementBetween(const Configuration& from, const Configuration& to) {
  return {to.position - from.position, rotationVector(to.orientation * from.orientation.conjugate())};
}

/// Composition of two frames: if `inner` is given in the axes of `outer`, and `outer` in world axes, the result is
/// `inner` in world axes.
inline Configuration composed(const Configuration& outer, const Configuration& inner) {
  return {outer.position + outer.orientation * inner.position, (outer.orientation * inner.orientation).normalized()};
}

/// composed(q, inverse(q)) is the identity up to rounding.
inline Configuration inverse(const Configuration& q) {
  const Quaternion back = q.orientation.conjugate();
  return {back * -q.position, back};
}

/// Compares bit for bit, without a tolerance.
inline bool isIdentity(const Configuration& q) {
  return q.position == Eigen::Vector3d::Zero() && q.orientation.coeffs() == Quaternion(1, 0, 0, 0).coeffs();
}

/// True if all numbers are finite and the quaternion is not zero.
inline bool isFinite(const Configuration& q) {
  return q.position.allFinite() && q.orientation.coeffs().allFinite() && q.orientation.squaredNorm() > 1e-12;
}

}  // namespace spheretree
