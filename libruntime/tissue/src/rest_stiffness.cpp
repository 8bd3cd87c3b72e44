// SPDX-License-Identifier: Apache-2.0
#include "spheretree/tissue/rest_stiffness.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <vector>

#include "edges_of.h"

namespace spheretree::tissue {

namespace {

using Gradients = Eigen::Matrix<double, 3, 4>;  // of the barycentric coordinates [1/mm]

struct Element {
  Gradients gradients;
  double volume;  // [mm^3]
};

Element elementOf(std::span<const Eigen::Vector3d> nodes, const std::array<std::uint32_t, 4>& c) {
  Eigen::Matrix3d sides;
  for (int k = 0; k < 3; ++k) sides.col(k) = nodes[c[static_cast<std::size_t>(k) + 1]] - nodes[c[0]];
  Element e;
  e.volume = sides.determinant() / 6;
  e.gradients.rightCols<3>() = sides.inverse().transpose();
  e.gradients.col(0) = -e.gradients.rightCols<3>().rowwise().sum();
  return e;
}

}  // namespace

// K = S^T S: a row of S is a strain component at an edge, or the volume change around a node, times the square root of
// its stiffness.
Eigen::SparseMatrix<double> restStiffness(std::span<const Eigen::Vector3d> nodes, std::span<const std::array<std::uint32_t, 4>> corners,
                                          const TissueMaterial& material) {
  const double young = material.young_kpa / 1000, nu = material.poisson;
  const double lambda = young * nu / ((1 + nu) * (1 - 2 * nu)), mu = young / (2 * (1 + nu));
  const EdgeList edges = edgesOf(corners);
  std::vector<Element> elements;
  std::vector<double> edge_volume(edges.count, 0), node_volume(nodes.size(), 0);
  for (std::size_t t = 0; t < corners.size(); ++t) {
    elements.push_back(elementOf(nodes, corners[t]));
    for (const std::uint32_t edge : edges.of_element[t]) edge_volume[edge] += elements[t].volume / 6;
    for (const std::uint32_t node : corners[t]) node_volume[node] += elements[t].volume / 4;
  }
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(corners.size() * 264);
  const auto first_of_nodes = static_cast<int>(6 * edges.count);
  for (std::size_t t = 0; t < corners.size(); ++t) {
    const Element& e = elements[t];
    for (const std::uint32_t edge : edges.of_element[t]) {
      const double scale = e.volume / 6 * std::sqrt(2 * mu / edge_volume[edge]), shear = scale / std::sqrt(2.0);
      const auto row = static_cast<int>(6 * edge);
      for (std::size_t a = 0; a < 4; ++a) {
        const auto column = static_cast<int>(3 * corners[t][a]);
        const Eigen::Vector3d g = e.gradients.col(static_cast<Eigen::Index>(a));
        for (int k = 0; k < 3; ++k) {
          const int l = (k + 1) % 3;
          entries.emplace_back(row + k, column + k, scale * g[k]);
          entries.emplace_back(row + 3 + k, column + k, shear * g[l]);
          entries.emplace_back(row + 3 + k, column + l, shear * g[k]);
        }
      }
    }
    for (const std::uint32_t node : corners[t]) {
      const double scale = e.volume / 4 * std::sqrt(lambda / node_volume[node]);
      for (std::size_t a = 0; a < 4; ++a)
        for (int k = 0; k < 3; ++k)
          entries.emplace_back(first_of_nodes + static_cast<int>(node), static_cast<int>(3 * corners[t][a]) + k,
                               scale * e.gradients(k, static_cast<Eigen::Index>(a)));
    }
  }
  Eigen::SparseMatrix<double> s(first_of_nodes + static_cast<int>(nodes.size()), static_cast<int>(3 * nodes.size()));
  s.setFromTriplets(entries.begin(), entries.end());
  return s.transpose() * s;
}

}  // namespace spheretree::tissue
