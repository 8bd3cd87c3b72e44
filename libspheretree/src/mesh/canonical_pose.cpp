// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/canonical_pose.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <limits>
#include <optional>
#include <tuple>
#include <utility>

#include "base/sum_in_order.h"
#include "mesh/canonical_order.h"

namespace spheretree::builder {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

constexpr double kAlike = 1e-3;        // relative to their sum: variances that differ by less do not distinguish axes
constexpr double kSignificant = 1e-3;  // a skewness, or a share of aligned normals, below this counts as 0
constexpr double kTie = 1e-6;
constexpr std::size_t kMaxFaces = 64;  // number of largest faces whose normals are tried as an axis
constexpr double kGrid = 0x1p-25;
constexpr std::size_t kFirst = 1024;  // positions that are compared before all are put in order

std::vector<Vector3d> positionsInPose(const TriangleMesh& mesh, const Pose& pose) {
  std::vector<Vector3d> positions(mesh.positions.size());
  forEachIndex(positions.size(), [&](std::size_t v) {
    const Vector3d q = pose.turn.transpose() * (mesh.positions[v] - pose.centre) / (kGrid * pose.scale);
    positions[v] = kGrid * (q.array().round() + 0.0).matrix();
  });
  return positions;
}

// Twice the area, in the direction of the normal.
Vector3d areaVector(const TriangleMesh& mesh, std::size_t t) {
  return (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0));
}

struct Moments {
  double area = 0;
  Vector3d mean = Vector3d::Zero();
  Matrix3d covariance = Matrix3d::Zero();
};

// Moments of the surface, exact: the integral of a polynomial over a triangle is a polynomial of its corners.
Moments momentsOf(const TriangleMesh& mesh) {
  Moments m;
  const std::size_t triangles = mesh.triangles.size();
  const auto areaOf = [&](std::size_t t) { return 0.5 * areaVector(mesh, t).norm(); };
  const auto first = [&](std::size_t t) {
    Moments of;
    const Vector3d &origin = mesh.positions[0], a = mesh.corner(t, 0), b = mesh.corner(t, 1), c = mesh.corner(t, 2);
    of.area = areaOf(t);
    of.mean = of.area / 3 * (a - origin + b - origin + c - origin);
    return of;
  };
  addInOrder<Moments>(triangles, first, [&](std::size_t, const Moments& of) { m.area += of.area, m.mean += of.mean; });
  m.mean = mesh.positions[0] + m.mean / m.area;
  const auto second = [&](std::size_t t) {
    const Vector3d a = mesh.corner(t, 0) - m.mean, b = mesh.corner(t, 1) - m.mean, c = mesh.corner(t, 2) - m.mean, sum = a + b + c;
    return Matrix3d(areaOf(t) / 12 * (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose()));
  };
  addInOrder<Matrix3d>(triangles, second, [&](std::size_t, const Matrix3d& of) { m.covariance += of; });
  m.covariance /= m.area;
  return m;
}

// Third moment along each axis divided by the cube of the standard deviation; 0 if it is not significant.
Vector3d skewness(const TriangleMesh& mesh, const Moments& m, const Matrix3d& axes, const Vector3d& variance) {
  const auto third = [&](std::size_t t) {
    const double area = 0.5 * areaVector(mesh, t).norm();
    Vector3d along;
    for (int k = 0; k < 3; ++k) {
      const Vector3d axis = axes.col(k);
      const double a = axis.dot(mesh.corner(t, 0) - m.mean), b = axis.dot(mesh.corner(t, 1) - m.mean),
                   c = axis.dot(mesh.corner(t, 2) - m.mean);
      const double all = a * a * a + b * b * b + c * c * c + a * a * (b + c) + b * b * (a + c) + c * c * (a + b) + a * b * c;
      along[k] = area / 10 * all;
    }
    return along;
  };
  Vector3d skew = Vector3d::Zero();
  addInOrder<Vector3d>(mesh.triangles.size(), third, [&](std::size_t, const Vector3d& of) { skew += of; });
  for (int k = 0; k < 3; ++k) {
    skew[k] /= m.area * variance[k] * std::sqrt(variance[k]);
    if (!(std::abs(skew[k]) > kSignificant)) skew[k] = 0;  // also if the variance is 0
  }
  return skew;
}

// The normal of a large face to which most of the area is parallel or perpendicular.
Vector3d commonestNormal(const TriangleMesh& mesh) {
  std::vector<std::pair<double, std::size_t>> by_area(mesh.triangles.size());
  forEachIndex(by_area.size(), [&](std::size_t t) { by_area[t] = {-areaVector(mesh, t).norm(), t}; });
  const std::size_t tried = std::min(kMaxFaces, by_area.size());
  std::partial_sort(by_area.begin(), by_area.begin() + static_cast<std::ptrdiff_t>(tried), by_area.end());
  std::vector<Vector3d> normals(tried);
  std::vector<double> aligned(tried, 0.0);
  forEachIndex(tried, [&](std::size_t i) {
    normals[i] = areaVector(mesh, by_area[i].second).normalized();
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const Vector3d v = areaVector(mesh, t);
      const double area2 = v.squaredNorm(), along = v.dot(normals[i]);
      if (area2 > 0) aligned[i] += along * along * along * along / (area2 * std::sqrt(area2));
    }
  });
  Vector3d best = Vector3d::UnitZ();
  double largest = 0;
  for (std::size_t i = 0; i < tried; ++i)
    if (aligned[i] > largest * (1 + kTie)) largest = aligned[i], best = normals[i];
  return best;
}

// Completes one axis to three: the other two are the directions to which most normals perpendicular to it are aligned,
// according to the fourth harmonic of their angles.
Matrix3d axesAbout(const Vector3d& axis, const TriangleMesh& mesh) {
  int smallest = 0;
  axis.cwiseAbs().minCoeff(&smallest);
  const Vector3d u = (Vector3d::Unit(smallest) - axis[smallest] * axis).normalized(), v = axis.cross(u);
  struct Term {
    std::complex<double> harmonic = 0;
    double across = 0;
  };
  const auto term = [&](std::size_t t) {
    const Vector3d n = areaVector(mesh, t);
    const double area = n.norm();
    if (!(area > 0)) return Term();
    const std::complex<double> in_plane(n.dot(u) / area, n.dot(v) / area), squared = in_plane * in_plane;
    return Term{area * squared * squared, area * std::norm(squared)};
  };
  std::complex<double> harmonic = 0;
  double across = 0;
  addInOrder<Term>(mesh.triangles.size(), term, [&](std::size_t, const Term& of) { harmonic += of.harmonic, across += of.across; });
  const double angle = std::abs(harmonic) > kSignificant * across ? 0.25 * std::arg(harmonic) : 0;
  Matrix3d axes;
  axes.col(0) = axis;
  axes.col(1) = std::cos(angle) * u + std::sin(angle) * v;
  axes.col(2) = axis.cross(axes.col(1));
  return axes;
}

bool isLess(const Vector3d& p, const Vector3d& q) { return std::tie(p.x(), p.y(), p.z()) < std::tie(q.x(), q.y(), q.z()); }

// The first positions of a mesh in the order of their coordinates.
std::vector<Vector3d> firstPositions(const TriangleMesh& mesh, const Pose& pose) {
  std::vector<Vector3d> positions = positionsInPose(mesh, pose);
  const auto end = positions.begin() + static_cast<std::ptrdiff_t>(std::min(kFirst, positions.size()));
  std::partial_sort(positions.begin(), end, positions.end(), isLess);
  positions.erase(end, positions.end());
  return positions;
}

// Whether a mesh in its canonical order comes before another in the order of coordinates.
bool comesFirst(const TriangleMesh& mesh, const TriangleMesh& other) {
  const auto [at, other_at] = std::mismatch(mesh.positions.begin(), mesh.positions.end(), other.positions.begin());
  return at == mesh.positions.end() ? mesh.triangles < other.triangles : isLess(*at, *other_at);
}

// Of the rotations that map a symmetric object to itself, the one for which its triangles come first in the order of
// their coordinates. If two rotations give the same triangles, either may be chosen. Most often, the first positions
// differ already.
Pose firstOf(const std::vector<Matrix3d>& turns, const TriangleMesh& mesh, Pose pose) {
  pose.turn = turns[0];
  if (turns.size() == 1) return pose;
  const auto ordered = [&](const Pose& of) { return inCanonicalOrder(inPose(mesh, of)).mesh; };
  std::vector<Vector3d> first = firstPositions(mesh, pose);
  std::optional<TriangleMesh> whole;  // in `pose`, if it had to be put in order
  Pose trial = pose;
  for (std::size_t i = 1; i < turns.size(); ++i) {
    trial.turn = turns[i];
    std::vector<Vector3d> other = firstPositions(mesh, trial);
    if (const auto [at, other_at] = std::mismatch(first.begin(), first.end(), other.begin()); at != first.end()) {
      if (isLess(*other_at, *at)) pose = trial, first = std::move(other), whole.reset();
      continue;
    }
    if (!whole) whole = ordered(pose);
    TriangleMesh whole_other = ordered(trial);
    if (comesFirst(whole_other, *whole)) pose = trial, whole = std::move(whole_other);
  }
  return pose;
}

}  // namespace

Pose canonicalPose(const TriangleMesh& mesh) {
  const Moments m = momentsOf(mesh);
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(m.covariance);
  const double total = m.covariance.trace();
  const auto alike = [&](double a, double b) { return std::abs(a - b) <= kAlike * total; };
  const Vector3d& variances = solver.eigenvalues();  // ascending
  const bool low_alike = alike(variances[0], variances[1]), high_alike = alike(variances[1], variances[2]);
  Matrix3d axes = solver.eigenvectors();
  if (low_alike && high_alike)
    axes = axesAbout(commonestNormal(mesh), mesh);
  else if (low_alike || high_alike)
    axes = axesAbout(axes.col(low_alike ? 2 : 0), mesh);
  Vector3d variance;
  for (int k = 0; k < 3; ++k) variance[k] = axes.col(k).dot(m.covariance * axes.col(k));
  const Vector3d skew = skewness(mesh, m, axes, variance);

  // Of the 24 right-handed ways to order and orient the axes: the longest first, then the largest skewness.
  std::vector<Matrix3d> turns;
  double max_skew = -std::numeric_limits<double>::infinity();
  std::array<int, 3> order{0, 1, 2};
  do {
    if (variance[order[0]] < variance[order[1]] - kAlike * total || variance[order[1]] < variance[order[2]] - kAlike * total) continue;
    for (int signs = 0; signs < 8; ++signs) {
      Matrix3d turn;
      double skews = 0;
      for (int k = 0; k < 3; ++k) {
        const double sign = signs >> k & 1 ? -1 : 1;
        const int axis = order[static_cast<std::size_t>(k)];
        turn.col(k) = sign * axes.col(axis);
        skews += sign * skew[axis] * (4 >> k);  // weights that distinguish any two ways
      }
      if (turn.determinant() < 0 || skews < max_skew - kTie) continue;
      if (skews > max_skew + kTie) max_skew = skews, turns.clear();
      turns.push_back(turn);
    }
  } while (std::next_permutation(order.begin(), order.end()));
  return firstOf(turns, mesh, {Matrix3d::Identity(), m.mean, std::sqrt(total)});
}

TriangleMesh inPose(const TriangleMesh& mesh, const Pose& pose) {
  TriangleMesh out;
  out.triangles = mesh.triangles;
  out.positions = positionsInPose(mesh, pose);
  return out;
}

}  // namespace spheretree::builder
