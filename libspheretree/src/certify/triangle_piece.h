// SPDX-License-Identifier: GPL-3.0-or-later
// Pieces of a triangle, as the proofs of coverage split it.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>

#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

inline constexpr std::size_t kTrianglesAChunk = 256;  // of one parallel task

struct Piece {
  std::array<Eigen::Vector3d, 3> corner;
};

/// Triangle `t` of the mesh, relative to `origin`.
inline Piece pieceOf(const TriangleMesh& mesh, std::size_t t, const Eigen::Vector3d& origin) {
  return {{mesh.corner(t, 0) - origin, mesh.corner(t, 1) - origin, mesh.corner(t, 2) - origin}};
}

inline Eigen::Vector3d centroidOf(const Piece& piece) { return (piece.corner[0] + piece.corner[1] + piece.corner[2]) / 3; }

/// Radius of the smallest ball about `c` that holds the piece.
inline double radiusAbout(const Piece& piece, const Eigen::Vector3d& c) {
  double largest = 0;
  for (const Eigen::Vector3d& p : piece.corner) largest = std::max(largest, (p - c).squaredNorm());
  return std::sqrt(largest);
}

/// Squared length of the side opposite corner `k`.
inline double side2(const Piece& p, std::size_t k) { return (p.corner[(k + 1) % 3] - p.corner[(k + 2) % 3]).squaredNorm(); }

/// Index of the corner opposite the longest side.
inline std::size_t longestSide(const Piece& piece) {
  std::size_t k = 0;
  for (std::size_t j = 1; j < 3; ++j)
    if (side2(piece, j) > side2(piece, k)) k = j;
  return k;
}

/// Index of the corner opposite the shortest side.
inline std::size_t shortestSide(const Piece& piece) {
  std::size_t k = 0;
  for (std::size_t j = 1; j < 3; ++j)
    if (side2(piece, j) < side2(piece, k)) k = j;
  return k;
}

/// Halves the piece at the side opposite corner `k`: if that is the longest, slivers become compact. Both halves have
/// exactly the same new corner.
inline std::array<Piece, 2> halvesOf(const Piece& piece, std::size_t k) {
  const Eigen::Vector3d halfway = 0.5 * (piece.corner[(k + 1) % 3] + piece.corner[(k + 2) % 3]);
  std::array<Piece, 2> halves{piece, piece};
  halves[0].corner[(k + 2) % 3] = halves[1].corner[(k + 1) % 3] = halfway;
  return halves;
}

/// Upper bound of the rounding error of a split point or a distance [mm]: a split is at most 100 deep, and each
/// midpoint is off by half a unit in the last place.
inline double roundingMargin(const TriangleMesh& mesh, const Eigen::Vector3d& origin) {
  double largest = origin.cwiseAbs().maxCoeff();
  for (const Eigen::Vector3d& p : mesh.positions) largest = std::max(largest, p.cwiseAbs().maxCoeff());
  return 1e-13 * largest;
}

}  // namespace spheretree::builder
