// SPDX-License-Identifier: Apache-2.0
// Where a ball, the probe, that rolls over leaves from outside touches two of them and no other: arcs of circles of its centre. At an end
// of an arc it touches a third. These are the edges and corners of the reduced surface (bridge.h).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "bridge_tree.h"
#include "free_arcs.h"

namespace spheretree::runtime {

struct Leaf {
  Eigen::Vector3d c;
  double r;
};

/// A part of the circle on which a probe touches two leaves, free of all others, with the leaves that end it; kNone: the whole circle.
struct Arc {
  std::uint32_t i, j;
  std::array<std::uint32_t, 2> end;
  std::array<double, 2> angle;  // about the axis from i to j, from `across`
  Eigen::Vector3d across;
};

/// Three leaves that a probe touches, in order, and the side of their plane on which it is.
struct Triple {
  std::array<std::uint32_t, 3> leaf;
  bool above;
  auto operator<=>(const Triple&) const = default;
};

/// How high the cone about two balls stands above the circle in which they meet; apart: above the ball.
double pairDepth(const Leaf& a, const Leaf& b);

class ProbeArcs {
 public:
  explicit ProbeArcs(std::span<const Sphere> leaves);

  const std::vector<Leaf>& leaves() const { return leaves_; }
  const SphereGroups& tree() const { return tree_; }
  double medianRadius() const { return median_; }

  /// Of all leaves that stand side by side; each free of what stands beside the smaller of the two. Finds hollows too. Cost: O(n).
  std::vector<Arc> ofNeighbours(double probe) const;
  /// Of the one surface that the probe rolls over from the top, free of all leaves: it has no slit. Cost: O(n log n) on round shapes, at
  /// most the leaves times those that it touches.
  std::vector<Arc> ofTheOutside(double probe) const;
  /// From now on ofTheOutside() is as if this leaf were not there.
  void passOver(std::uint32_t leaf) { passed_over_[leaf] = true; }

  Eigen::Vector3d directionAt(const Arc& arc, double angle) const;
  /// The three leaves at end 0 or 1 of an arc that is not a whole circle.
  Triple tripleAt(const Arc& arc, std::size_t end) const;

 private:
  struct Circle;
  struct Contact;
  Circle circleOf(std::uint32_t i, std::uint32_t j, double probe, const Eigen::Vector3d& through) const;
  Contact firstContact(const Circle& circle, std::uint32_t behind) const;
  void meet(const Circle& circle, std::uint32_t behind, std::size_t level, std::size_t at, Contact& first) const;
  void addArcs(std::uint32_t i, std::uint32_t j, double probe, FreeArcs& left, std::vector<Arc>& arcs) const;

  std::vector<Leaf> leaves_;
  SphereGroups tree_;
  double median_ = 0;
  std::vector<bool> passed_over_;
  std::vector<std::vector<std::uint32_t>> neighbours_;  // the one with the shallowest pit between first
};

}  // namespace spheretree::runtime
