// SPDX-License-Identifier: GPL-3.0-or-later
#include "tissue/elasticity.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <numeric>
#include <string>

#include "spheretree/builder/build_settings.h"
#include "spheretree/tissue/rest_stiffness.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

// Connected parts of the solid, each identified by its lowest node.
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

// Three fixed corners that are not collinear hold a body.
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

Elasticity::Elasticity(const Tetrahedra& solid, const TissueMaterial& material, std::span<const char> is_fixed, Progress& progress) {
  refuseLooseParts(solid, is_fixed);
  std::int32_t unknown = 0, column = 0;
  for (std::uint32_t i = 0; i < solid.nodes.size(); ++i) {
    free_.push_back(is_fixed[i] ? -1 : unknown);
    fixed_column_.push_back(is_fixed[i] ? column : -1);
    (is_fixed[i] ? column : unknown) += 3;
  }
  if (unknown == 0) throw BuildError("tissue: every node is fixed, so that nothing can move. Fix a smaller region");
  stiffness_.resize(unknown, unknown);
  coupling_.resize(unknown, column);
  progress.check();
  assemble(tissue::restStiffness(solid.nodes, solid.corners, material));
  progress.check();
  factor_.compute(stiffness_);
  if (factor_.info() != Eigen::Success) throw BuildError("tissue: the stiffness matrix is singular: a part of the body is not held");
}

void Elasticity::assemble(const Eigen::SparseMatrix<double>& all) {
  std::vector<Eigen::Triplet<double>> own, coupled;
  for (Eigen::Index j = 0; j < all.outerSize(); ++j)
    for (Eigen::SparseMatrix<double>::InnerIterator it(all, j); it; ++it) {
      const auto axis = static_cast<std::int32_t>(it.row() % 3), other_axis = static_cast<std::int32_t>(j % 3);
      const std::int32_t row = free_[static_cast<std::size_t>(it.row() / 3)], column = free_[static_cast<std::size_t>(j / 3)];
      if (row < 0) continue;
      if (column < 0)
        coupled.emplace_back(row + axis, fixed_column_[static_cast<std::size_t>(j / 3)] + other_axis, it.value());
      else if (column + other_axis <= row + axis)
        own.emplace_back(row + axis, column + other_axis, it.value());
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
  // Row by row for all right-hand sides, so that each entry of the factor is read only once.
  columns = factor_.permutationP() * columns;
  const Eigen::SparseMatrix<double>& lower = factor_.matrixL().nestedExpression();
  using Entry = Eigen::SparseMatrix<double>::InnerIterator;
  for (Eigen::Index j = 0; j < lower.outerSize(); ++j) {
    Entry it(lower, j);
    columns.row(j) /= it.value();  // the diagonal is the first entry
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
