// SPDX-License-Identifier: GPL-3.0-or-later
#include "tissue/elasticity.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <numeric>
#include <string>

#include "spheretree/builder/build_settings.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr std::array<std::pair<std::size_t, std::size_t>, 6> kEdges{{{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}};
using ElementStiffness = Eigen::Matrix<double, 30, 30>;
using Gradients = Eigen::Matrix<double, 3, 10>;  // of the shape functions [1/mm]

// Of the corners' barycentric coordinates, which are constant in the element.
Eigen::Matrix<double, 3, 4> barycentricGradients(const std::array<Vector3d, 4>& p) {
  Eigen::Matrix3d edges;
  for (int k = 0; k < 3; ++k) edges.col(k) = p[static_cast<std::size_t>(k) + 1] - p[0];
  Eigen::Matrix<double, 3, 4> gradients;
  gradients.rightCols<3>() = edges.inverse().transpose();
  gradients.col(0) = -(gradients.col(1) + gradients.col(2) + gradients.col(3));
  return gradients;
}

// N_i = w_i (2 w_i - 1) at corners, 4 w_i w_j at the middle of edge ij.
Gradients shapeGradients(const Eigen::Matrix<double, 3, 4>& of_weights, const std::array<double, 4>& w) {
  Gradients gradients;
  for (std::size_t i = 0; i < 4; ++i)
    gradients.col(static_cast<Eigen::Index>(i)) = (4 * w[i] - 1) * of_weights.col(static_cast<Eigen::Index>(i));
  for (std::size_t e = 0; e < kEdges.size(); ++e) {
    const auto [i, j] = kEdges[e];
    gradients.col(static_cast<Eigen::Index>(4 + e)) =
        4 * (w[i] * of_weights.col(static_cast<Eigen::Index>(j)) + w[j] * of_weights.col(static_cast<Eigen::Index>(i)));
  }
  return gradients;
}

// K_ij = integral of lambda g_i g_j^T + mu (g_j g_i^T + (g_i . g_j) I), g the gradients of the shape functions.
ElementStiffness elementStiffness(const std::array<Vector3d, 4>& p, double lambda, double mu) {
  const double volume = (p[1] - p[0]).cross(p[2] - p[0]).dot(p[3] - p[0]) / 6;
  const Eigen::Matrix<double, 3, 4> of_weights = barycentricGradients(p);
  const double far = 0.1381966011250105, near = 0.5854101966249685;  // (5 - sqrt 5) / 20, (5 + 3 sqrt 5) / 20
  ElementStiffness stiffness = ElementStiffness::Zero();
  for (std::size_t point = 0; point < 4; ++point) {
    std::array<double, 4> w{far, far, far, far};
    w[point] = near;
    const Gradients g = shapeGradients(of_weights, w);
    for (Eigen::Index i = 0; i < 10; ++i)
      for (Eigen::Index j = 0; j <= i; ++j) {
        const Vector3d gi = g.col(i), gj = g.col(j);
        Eigen::Matrix3d block = lambda * gi * gj.transpose() + mu * gj * gi.transpose();
        block.diagonal().array() += mu * gi.dot(gj);
        stiffness.block<3, 3>(3 * i, 3 * j) += volume / 4 * block;
      }
  }
  for (Eigen::Index i = 0; i < 10; ++i)
    for (Eigen::Index j = 0; j < i; ++j) stiffness.block<3, 3>(3 * j, 3 * i) = stiffness.block<3, 3>(3 * i, 3 * j).transpose();
  return stiffness;
}

// Connected parts of the solid, by the lowest node of each.
std::vector<std::uint32_t> partOfNodes(const Tetrahedra& solid) {
  std::vector<std::uint32_t> root(solid.nodes.size());
  std::iota(root.begin(), root.end(), 0u);
  const auto find = [&](std::uint32_t i) {
    while (root[i] != i) i = root[i] = root[root[i]];
    return i;
  };
  for (const auto& c : solid.corners)
    for (std::size_t k = 1; k < 4; ++k) {
      const std::uint32_t a = find(c[0]), b = find(c[k]);
      root[std::max(a, b)] = std::min(a, b);
    }
  for (std::uint32_t i = 0; i < root.size(); ++i) root[i] = find(i);
  return root;
}

// Three fixed corners that are not in line hold a body.
bool isHeld(const std::vector<Vector3d>& fixed, double size) {
  if (fixed.size() < 3) return false;
  const Vector3d& a = fixed.front();
  const Vector3d b = *std::max_element(fixed.begin(), fixed.end(),
                                       [&](const Vector3d& p, const Vector3d& q) { return (p - a).squaredNorm() < (q - a).squaredNorm(); });
  const double longest = (b - a).norm();
  return std::any_of(fixed.begin(), fixed.end(), [&](const Vector3d& p) { return (p - a).cross(b - a).norm() > 1e-3 * size * longest; });
}

void refuseLooseParts(const Tetrahedra& solid, std::span<const char> is_fixed) {
  const std::vector<std::uint32_t> part = partOfNodes(solid);
  for (std::uint32_t first = 0; first < part.size(); ++first) {
    if (part[first] != first) continue;
    std::vector<Vector3d> fixed;
    Eigen::AlignedBox3d box;
    for (std::uint32_t i = first; i < part.size(); ++i) {
      if (part[i] != first) continue;
      box.extend(solid.nodes[i]);
      if (is_fixed[i]) fixed.push_back(solid.nodes[i]);
    }
    if (isHeld(fixed, box.diagonal().norm())) continue;
    char text[256];
    std::snprintf(
        text, sizeof text,
        "tissue: the part between (%.4g, %.4g, %.4g) and (%.4g, %.4g, %.4g) mm is held by %zu of its nodes; three that are not in "
        "line are needed, or it would float away. Fix a region that holds more of it",
        box.min().x(), box.min().y(), box.min().z(), box.max().x(), box.max().y(), box.max().z(), fixed.size());
    throw BuildError(text);
  }
}

}  // namespace

std::uint32_t QuadraticNodes::middle(std::uint32_t a, std::uint32_t b) const {
  const auto corners = static_cast<std::uint32_t>(position.size() - edges.size());
  const auto at = std::lower_bound(edges.begin(), edges.end(), std::pair(std::min(a, b), std::max(a, b)));
  return corners + static_cast<std::uint32_t>(at - edges.begin());
}

QuadraticNodes quadraticNodes(const Tetrahedra& solid) {
  QuadraticNodes nodes;
  for (const auto& c : solid.corners)
    for (const auto& [i, j] : kEdges) nodes.edges.emplace_back(std::min(c[i], c[j]), std::max(c[i], c[j]));
  std::sort(nodes.edges.begin(), nodes.edges.end());
  nodes.edges.erase(std::unique(nodes.edges.begin(), nodes.edges.end()), nodes.edges.end());
  nodes.position = solid.nodes;
  for (const auto& [a, b] : nodes.edges) nodes.position.push_back((solid.nodes[a] + solid.nodes[b]) / 2);
  for (const auto& c : solid.corners) {
    std::array<std::uint32_t, 10> all{c[0], c[1], c[2], c[3]};
    for (std::size_t e = 0; e < kEdges.size(); ++e) all[4 + e] = nodes.middle(c[kEdges[e].first], c[kEdges[e].second]);
    nodes.of_element.push_back(all);
  }
  return nodes;
}

Elasticity::Elasticity(const Tetrahedra& solid, const TissueMaterial& material, std::span<const char> is_fixed, Progress& progress)
    : nodes_(quadraticNodes(solid)) {
  refuseLooseParts(solid, is_fixed);
  std::int32_t unknown = 0, column = 0;
  for (std::uint32_t i = 0; i < nodes_.position.size(); ++i) {
    bool fixed = false;
    if (i < solid.nodes.size()) {
      fixed = is_fixed[i];
    } else {
      const auto [a, b] = nodes_.edges[i - solid.nodes.size()];
      fixed = is_fixed[a] && is_fixed[b];
    }
    free_.push_back(fixed ? -1 : unknown);
    fixed_column_.push_back(fixed ? column : -1);
    (fixed ? column : unknown) += 3;
  }
  if (unknown == 0) throw BuildError("tissue: every node is fixed, so that nothing can move. Fix a smaller region");
  stiffness_.resize(unknown, unknown);
  coupling_.resize(unknown, column);
  assemble(solid, material, progress);
  progress.check();
  factor_.compute(stiffness_);
  if (factor_.info() != Eigen::Success) throw BuildError("tissue: the stiffness matrix is singular: a part of the body is not held");
}

void Elasticity::assemble(const Tetrahedra& solid, const TissueMaterial& material, Progress& progress) {
  const double young = material.young_kpa / 1000, nu = material.poisson;
  const double lambda = young * nu / ((1 + nu) * (1 - 2 * nu)), mu = young / (2 * (1 + nu));
  std::vector<Eigen::Triplet<double>> own, coupled;
  own.reserve(solid.corners.size() * 500);
  for (std::size_t t = 0; t < solid.corners.size(); ++t) {
    if (t % 1024 == 0) progress.check();
    const auto& c = solid.corners[t];
    const ElementStiffness k = elementStiffness({solid.nodes[c[0]], solid.nodes[c[1]], solid.nodes[c[2]], solid.nodes[c[3]]}, lambda, mu);
    const std::array<std::uint32_t, 10>& nodes = nodes_.of_element[t];
    for (int i = 0; i < 30; ++i) {
      const std::int32_t row = free_[nodes[static_cast<std::size_t>(i / 3)]];
      if (row < 0) continue;
      for (int j = 0; j < 30; ++j) {
        const std::uint32_t other = nodes[static_cast<std::size_t>(j / 3)];
        if (free_[other] < 0)
          coupled.emplace_back(row + i % 3, fixed_column_[other] + j % 3, k(i, j));
        else if (free_[other] + j % 3 <= row + i % 3)
          own.emplace_back(row + i % 3, free_[other] + j % 3, k(i, j));
      }
    }
  }
  stiffness_.setFromTriplets(own.begin(), own.end());
  coupling_.setFromTriplets(coupled.begin(), coupled.end());
}

std::vector<Vector3d> Elasticity::displacements(std::span<const Vector3d> forces, std::span<const Vector3d> prescribed) const {
  Eigen::VectorXd right = Eigen::VectorXd::Zero(stiffness_.rows());
  Eigen::VectorXd given = Eigen::VectorXd::Zero(coupling_.cols());
  for (std::size_t i = 0; i < free_.size(); ++i) {
    if (free_[i] >= 0)
      right.segment<3>(free_[i]) = forces[i];
    else if (!prescribed.empty())
      given.segment<3>(fixed_column_[i]) = prescribed[i];
  }
  right -= coupling_ * given;
  const Eigen::VectorXd solution = factor_.solve(right);
  std::vector<Vector3d> out(free_.size(), Vector3d::Zero());
  for (std::size_t i = 0; i < free_.size(); ++i) {
    if (free_[i] >= 0)
      out[i] = solution.segment<3>(free_[i]);
    else if (!prescribed.empty())
      out[i] = prescribed[i];
  }
  return out;
}

void Elasticity::solve(Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>& columns) const {
  // Rows of all right-hand sides stand together: an entry of the factor is read once for all of them.
  columns = factor_.permutationP() * columns;
  const Eigen::SparseMatrix<double>& lower = factor_.matrixL().nestedExpression();
  using Entry = Eigen::SparseMatrix<double>::InnerIterator;
  for (Eigen::Index j = 0; j < lower.outerSize(); ++j) {
    Entry it(lower, j);
    columns.row(j) /= it.value();  // the diagonal comes first
    for (++it; it; ++it) columns.row(it.index()) -= it.value() * columns.row(j);
  }
  for (Eigen::Index j = lower.outerSize(); j-- > 0;) {
    Entry it(lower, j);
    const double diagonal = it.value();
    for (++it; it; ++it) columns.row(j) -= it.value() * columns.row(it.index());
    columns.row(j) /= diagonal;
  }
  columns = factor_.permutationPinv() * columns;
}

}  // namespace spheretree::builder
