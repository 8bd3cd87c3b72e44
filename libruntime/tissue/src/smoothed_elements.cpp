// SPDX-License-Identifier: Apache-2.0
#include "smoothed_elements.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "edges_of.h"
#include "spheretree/core/rounding.h"

namespace spheretree::tissue {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

namespace {

constexpr int kTurns = 12;            // iterations for a rotation; 2 or 3 are usual
constexpr double kFlat = 0.3;         // share of the volume below which a tetrahedron gets the additional energy
constexpr double kBarrier = 10;       // its stiffness, as a multiple of the material's bulk resistance
constexpr double kMinStretch = 0.05;  // sums of two singular values below this: nearly flat or inverted

// The rotation nearest to `gradient`, starting from `turn`, the rotation of a similar state, by Newton's method. With
// R^T F = A the derivative of |F - R exp(w)|^2 is zero where  (tr S - S) w = axial vector of A,  with S its symmetric
// part. Where the gradient is nearly flat or inverted, uses the shorter steps of M. Mueller, J. Bender, N. Chentanez,
// M. Macklin. A robust method to extract the rotational part of deformations. Motion in Games 2016. The result is
// always a rotation.
Matrix3d turnTowards(const Matrix3d& gradient, Quaterniond& turn) {
  Matrix3d r = turn.toRotationMatrix();
  for (int i = 0; i < kTurns; ++i) {
    const Matrix3d a = r.transpose() * gradient;
    const Vector3d axial(a(2, 1) - a(1, 2), a(0, 2) - a(2, 0), a(1, 0) - a(0, 1));
    const Matrix3d slope = a.trace() * Matrix3d::Identity() - 0.5 * (a + a.transpose());
    const double minor = slope(0, 0) * slope(1, 1) - slope(0, 1) * slope(0, 1), det = slope.determinant();
    constexpr double k = kMinStretch;
    const bool is_upright = slope(0, 0) > k && minor > k * k && det > k * k * k;
    const Vector3d omega = is_upright ? Vector3d(slope.inverse() * axial) : Vector3d(axial / (std::abs(a.trace()) + 1));
    const Vector3d half = 0.5 * omega;
    turn = (turn * Quaterniond(1, half.x(), half.y(), half.z())).normalized();
    r = turn.toRotationMatrix();
    if (!(omega.squaredNorm() > kRounding)) break;  // the square is the error that is left [rad]
  }
  return r;
}

Matrix3d cofactor(const Matrix3d& f) {
  Matrix3d out;
  out << f.col(1).cross(f.col(2)), f.col(2).cross(f.col(0)), f.col(0).cross(f.col(1));
  return out;
}

}  // namespace

SmoothedElements::SmoothedElements(const Tissue& tissue) : nodes_(tissue.nodes.size()) {
  const double young = tissue.material.young_kpa / 1000, nu = tissue.material.poisson;
  lambda_ = young * nu / ((1 + nu) * (1 - 2 * nu)), mu_ = young / (2 * (1 + nu));
  barrier_ = kBarrier * (lambda_ + 2 * mu_);
  for (const auto& n : tissue.nodes) rest_.emplace_back(n[0], n[1], n[2]);
  const EdgeList edges = edgesOf(tissue.tetrahedra);
  edges_.resize(edges.count);
  for (const auto& c : tissue.tetrahedra) {
    Matrix3d sides;
    for (int k = 0; k < 3; ++k) sides.col(k) = rest_[c[static_cast<std::size_t>(k) + 1]] - rest_[c[0]];
    Element e{c, edges.of_element[elements_.size()], sides.inverse(), sides.determinant() / 6};
    for (const std::uint32_t edge : e.edge) edges_[edge].volume += e.volume / 6;
    for (const std::uint32_t node : c) nodes_[node].volume += e.volume / 4;
    elements_.push_back(e);
  }
  gradients_.resize(elements_.size());
  flat_.resize(elements_.size());
}

Matrix3d SmoothedElements::gradientOf(const Element& e, std::span<const Vector3d> u) const {
  const Vector3d first = rest_[e.corner[0]] + u[e.corner[0]];
  Matrix3d moved;
  for (int k = 0; k < 3; ++k) {
    const std::uint32_t node = e.corner[static_cast<std::size_t>(k) + 1];
    moved.col(k) = rest_[node] + u[node] - first;
  }
  return moved * e.inverse;
}

double SmoothedElements::energy(std::span<const Vector3d> u, std::vector<Vector3d>& out) {
  double sum = 0;
  for (Edge& edge : edges_) edge.gradient.setZero();
  for (Node& node : nodes_) node.ratio = 0;
  for (std::size_t t = 0; t < elements_.size(); ++t) {
    const Element& e = elements_[t];
    const Matrix3d& f = gradients_[t] = gradientOf(e, u);
    const double det = f.determinant();
    for (const std::uint32_t edge : e.edge) edges_[edge].gradient += e.volume / 6 * f;
    for (const std::uint32_t node : e.corner) nodes_[node].ratio += e.volume / 4 * det;
    flat_[t] = std::max(0.0, kFlat - det);
    sum += e.volume * barrier_ / 2 * flat_[t] * flat_[t];
  }
  for (Edge& edge : edges_) {
    const Matrix3d f = edge.gradient / edge.volume, strain = f - turnTowards(f, edge.turn);
    edge.stress = mu_ / 3 * strain;  // a sixth of 2 mu (F - R)
    sum += edge.volume * mu_ * strain.squaredNorm();
  }
  for (Node& node : nodes_) {
    if (!(node.volume > 0)) continue;  // a node without tetrahedra
    const double change = node.ratio / node.volume - 1;
    node.pressure = lambda_ / 4 * change;
    sum += node.volume * lambda_ / 2 * change * change;
  }
  std::fill(out.begin(), out.end(), Vector3d::Zero());
  for (std::size_t t = 0; t < elements_.size(); ++t) {
    const Element& e = elements_[t];
    double pressure = -barrier_ * flat_[t];
    for (const std::uint32_t node : e.corner) pressure += nodes_[node].pressure;
    Matrix3d stress = pressure * cofactor(gradients_[t]);
    for (const std::uint32_t edge : e.edge) stress += edges_[edge].stress;
    const Matrix3d forces = e.volume * stress * e.inverse.transpose();
    for (int k = 0; k < 3; ++k) out[e.corner[static_cast<std::size_t>(k) + 1]] += forces.col(k);
    out[e.corner[0]] -= forces.rowwise().sum();
  }
  return sum;
}

std::size_t SmoothedElements::inverted(std::span<const Vector3d> u) const {
  return static_cast<std::size_t>(
      std::count_if(elements_.begin(), elements_.end(), [&](const Element& e) { return !(gradientOf(e, u).determinant() > 0); }));
}

void SmoothedElements::reset() {
  for (Edge& edge : edges_) edge.turn = {1, 0, 0, 0};
}

}  // namespace spheretree::tissue
