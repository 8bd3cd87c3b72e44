// SPDX-License-Identifier: GPL-3.0-or-later
#include "draw/shapes.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace spheretree::view {
namespace {

using Eigen::Vector3d;
constexpr int kSides = 20;
constexpr double kTurn = 2 * std::numbers::pi;

struct Frame {
  Vector3d u, v, axis;
  explicit Frame(const Vector3d& along) : axis(along.normalized()) {
    u = axis.unitOrthogonal();
    v = axis.cross(u);
  }
  Vector3d rim(double angle) const { return std::cos(angle) * u + std::sin(angle) * v; }
};

void addTriangle(Shapes& shapes, const Vector3d& a, const Vector3d& na, const Vector3d& b, const Vector3d& nb, const Vector3d& c,
                 const Vector3d& nc, Colour colour) {
  shapes.push_back({a.cast<float>(), na.cast<float>(), colour});
  shapes.push_back({b.cast<float>(), nb.cast<float>(), colour});
  shapes.push_back({c.cast<float>(), nc.cast<float>(), colour});
}

/// A band between two circles with the same axis; `slope`: of the normals along the axis.
void addBand(Shapes& shapes, const Frame& f, const Vector3d& from, double r0, const Vector3d& to, double r1, double slope, Colour colour) {
  for (int k = 0; k < kSides; ++k) {
    const Vector3d e0 = f.rim(kTurn * k / kSides), e1 = f.rim(kTurn * (k + 1) / kSides);
    const Vector3d n0 = (e0 + slope * f.axis).normalized(), n1 = (e1 + slope * f.axis).normalized();
    addTriangle(shapes, from + r0 * e0, n0, from + r0 * e1, n1, to + r1 * e1, n1, colour);
    addTriangle(shapes, from + r0 * e0, n0, to + r1 * e1, n1, to + r1 * e0, n0, colour);
  }
}

void addCap(Shapes& shapes, const Frame& f, const Vector3d& centre, double radius, double side, Colour colour) {
  const Vector3d n = side * f.axis;
  for (int k = 0; k < kSides; ++k)
    addTriangle(shapes, centre, n, centre + radius * f.rim(kTurn * k / kSides), n, centre + radius * f.rim(kTurn * (k + 1) / kSides), n,
                colour);
}

void addCone(Shapes& shapes, const Vector3d& base, const Vector3d& along, double radius, Colour colour) {
  const Frame f(along);
  addBand(shapes, f, base, radius, base + along, 0, radius / along.norm(), colour);
  addCap(shapes, f, base, radius, -1, colour);
}

/// A tube along closely spaced points.
void addTube(Shapes& shapes, const std::vector<Vector3d>& path, double radius, Colour colour) {
  constexpr int kRound = 10;
  if (path.size() < 2) return;
  Vector3d u = Frame(path[1] - path[0]).u;
  std::vector<Vector3d> ring;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const Vector3d along = (path[std::min(i + 1, path.size() - 1)] - path[i > 0 ? i - 1 : 0]).normalized();
    u = (u - u.dot(along) * along).normalized();
    const Vector3d v = along.cross(u);
    for (int k = 0; k < kRound; ++k) ring.push_back(std::cos(kTurn * k / kRound) * u + std::sin(kTurn * k / kRound) * v);
  }
  for (std::size_t i = 0; i + 1 < path.size(); ++i)
    for (std::size_t k = 0; k < kRound; ++k) {
      const Vector3d &a = ring[i * kRound + k], &b = ring[i * kRound + (k + 1) % kRound];
      const Vector3d &c = ring[(i + 1) * kRound + (k + 1) % kRound], &d = ring[(i + 1) * kRound + k];
      addTriangle(shapes, path[i] + radius * a, a, path[i] + radius * b, b, path[i + 1] + radius * c, c, colour);
      addTriangle(shapes, path[i] + radius * a, a, path[i + 1] + radius * c, c, path[i + 1] + radius * d, d, colour);
    }
}

}  // namespace

void addArrow(Shapes& shapes, const Vector3d& from, const Vector3d& along, double radius, Colour colour) {
  const double length = along.norm();
  if (!(length > 0)) return;
  const double head = std::min(5 * radius, 0.6 * length);
  const Vector3d base = from + along * (1 - head / length);
  const Frame f(along);
  addBand(shapes, f, from, radius, base, radius, 0, colour);
  addCap(shapes, f, from, radius, -1, colour);
  addCone(shapes, base, along * (head / length), 2.2 * radius, colour);
}

void addArc(Shapes& shapes, const Vector3d& centre, const Vector3d& axis, double circle, double angle, double radius, Colour colour) {
  if (!(axis.norm() > 0)) return;
  const Frame f(axis);
  const double head = std::min(4.5 * radius / circle, 0.7 * angle);
  std::vector<Vector3d> path;
  const int steps = std::max(2, static_cast<int>(48 * angle / kTurn));
  for (int k = 0; k <= steps; ++k) path.push_back(centre + circle * f.rim((angle - head) * k / steps));
  addTube(shapes, path, radius, colour);
  addCone(shapes, path.back(), centre + circle * f.rim(angle) - path.back(), 2.2 * radius, colour);
}

void addCoil(Shapes& shapes, const Vector3d& from, const Vector3d& to, double coil, double wire, Colour colour) {
  const Vector3d along = to - from;
  if (along.norm() < 1e-6) return;
  constexpr int kWindings = 7, kSteps = 16 * kWindings;
  const Frame f(along);
  std::vector<Vector3d> path;
  for (int k = 0; k <= kSteps; ++k) {
    const double t = static_cast<double>(k) / kSteps;
    const double r = coil * std::min({1.0, 8 * t, 8 * (1 - t)});  // straight at both ends
    path.push_back(from + t * along + r * f.rim(kTurn * kWindings * t));
  }
  addTube(shapes, path, wire, colour);
}

void addDisc(Shapes& shapes, const Vector3d& centre, const Vector3d& normal, double radius, Colour colour) {
  if (normal.norm() > 0) addCap(shapes, Frame(normal), centre, radius, 1, colour);
}

void addRing(Shapes& shapes, const Vector3d& centre, const Vector3d& normal, double inner, double outer, Colour colour) {
  if (!(normal.norm() > 0)) return;
  const Frame f(normal);
  for (int k = 0; k < kSides; ++k) {
    const Vector3d e0 = f.rim(kTurn * k / kSides), e1 = f.rim(kTurn * (k + 1) / kSides);
    addTriangle(shapes, centre + inner * e0, f.axis, centre + outer * e0, f.axis, centre + outer * e1, f.axis, colour);
    addTriangle(shapes, centre + inner * e0, f.axis, centre + outer * e1, f.axis, centre + inner * e1, f.axis, colour);
  }
}

void addRod(Shapes& shapes, const Vector3d& from, const Vector3d& to, double radius, Colour colour) {
  if (!((to - from).norm() > 0)) return;
  const Frame f(to - from);
  addBand(shapes, f, from, radius, to, radius, 0, colour);
  addCap(shapes, f, from, radius, -1, colour);
  addCap(shapes, f, to, radius, 1, colour);
}

void addBall(Shapes& shapes, const Vector3d& centre, double radius, Colour colour) {
  constexpr int kRings = 8;
  const auto point = [](int ring, int k) {
    const double polar = std::numbers::pi * ring / kRings, angle = kTurn * k / kSides;
    return Vector3d(std::sin(polar) * std::cos(angle), std::sin(polar) * std::sin(angle), std::cos(polar));
  };
  for (int ring = 0; ring < kRings; ++ring)
    for (int k = 0; k < kSides; ++k) {
      const Vector3d a = point(ring, k), b = point(ring + 1, k), c = point(ring + 1, k + 1), d = point(ring, k + 1);
      addTriangle(shapes, centre + radius * a, a, centre + radius * b, b, centre + radius * c, c, colour);
      addTriangle(shapes, centre + radius * a, a, centre + radius * c, c, centre + radius * d, d, colour);
    }
}

double arrowShare(double newtons) { return newtons > 0.1 ? std::min(1.0, std::log10(newtons / 0.1) / 2) : 0; }

}  // namespace spheretree::view
