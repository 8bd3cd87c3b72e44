// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/batch/reference_point.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <limits>

namespace spheretree::pipeline {
namespace {

using Eigen::Vector3d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

Vector3d centreOf(const std::vector<Vector3d>& points) {
  Vector3d low = Vector3d::Constant(kInfinity), high = -low;
  for (const Vector3d& p : points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  return (low + high) / 2;
}

/// The middle of some points perpendicular to an axis, and their largest distance from it.
struct Section {
  Vector3d middle = Vector3d::Zero();
  double width = 0;
};

Section sectionOf(const std::vector<Vector3d>& points, const Vector3d& axis) {
  Section section;
  std::vector<Vector3d> across;
  for (const Vector3d& p : points) across.push_back(p - axis * p.dot(axis));
  section.middle = centreOf(across);
  for (const Vector3d& p : across) section.width = std::max(section.width, (p - section.middle).norm());
  return section;
}

/// The direction in which points spread farthest; its largest component is positive.
Vector3d axisOf(const std::vector<Vector3d>& points) {
  Vector3d mean = Vector3d::Zero();
  for (const Vector3d& p : points) mean += p / static_cast<double>(points.size());
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const Vector3d& p : points) spread += (p - mean) * (p - mean).transpose();
  const Vector3d axis = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvectors().col(2);
  Eigen::Index largest = 0;
  axis.cwiseAbs().maxCoeff(&largest);
  return axis[largest] < 0 ? Vector3d(-axis) : axis;
}

Vector3d tipOf(const std::vector<Vector3d>& points) {
  const Vector3d axis = axisOf(points);
  double low = kInfinity, high = -kInfinity;
  for (const Vector3d& p : points) {
    low = std::min(low, p.dot(axis));
    high = std::max(high, p.dot(axis));
  }
  std::array<std::vector<Vector3d>, 2> ends;
  for (const Vector3d& p : points) {
    if (p.dot(axis) <= low + (high - low) / 10) ends[0].push_back(p);
    if (p.dot(axis) >= high - (high - low) / 10) ends[1].push_back(p);
  }
  const Section at_low = sectionOf(ends[0], axis), at_high = sectionOf(ends[1], axis);
  return at_low.width <= at_high.width ? Vector3d(at_low.middle + axis * low) : Vector3d(at_high.middle + axis * high);
}

std::vector<Vector3d> leafCentres(const SphereTree& tree) {
  const Vector3d origin(tree.origin_mm[0], tree.origin_mm[1], tree.origin_mm[2]);
  std::vector<Vector3d> points;
  for (std::uint32_t i = 0; i < tree.nodeCount(); ++i)
    if (tree.isLeaf(i)) points.push_back(origin + centreOf(tree.cover[i]));
  return points;
}

/// Vertices of the mesh of an item.
std::vector<Vector3d> verticesOf(const TreeJob& job) {
  const TriangleMesh& mesh = job.file->mesh.mesh;
  return job.part.empty() ? mesh.positions : partOf(mesh, job.part, job.file->components).positions;
}

}  // namespace

Vector3d namedPoint(const std::string& name, const std::vector<Vector3d>& points) {
  return name == "tip" ? tipOf(points) : centreOf(points);
}

void resolveReferencePoint(formats::SceneItem& tool, const BatchItem& item) {
  if (tool.reference_point.empty()) return;
  tool.reference_point_mm = namedPoint(tool.reference_point, item.job.file ? verticesOf(item.job) : leafCentres(item.result.tree));
  tool.reference_point.clear();
}

double distanceFrom(const Vector3d& point, const BatchItem& item) {
  double nearest = kInfinity;
  for (const Vector3d& p : item.job.file ? verticesOf(item.job) : leafCentres(item.result.tree))
    nearest = std::min(nearest, (p - point).norm());
  return nearest;
}

}  // namespace spheretree::pipeline
