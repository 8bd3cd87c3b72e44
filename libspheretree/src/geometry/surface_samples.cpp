// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/surface_samples.h"

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>

#include "base/random.h"
#include "base/sum_in_order.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

Vector3d areaVector(const TriangleMesh& mesh, std::size_t t) {
  return 0.5 * (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0));
}

struct SharpEdge {
  std::uint32_t low, high, triangle;
  Vector3d normal;
};

std::vector<SharpEdge> findSharpEdges(const TriangleMesh& mesh, double angle) {
  struct HalfEdge {
    std::uint32_t low, high, triangle;
  };
  std::vector<HalfEdge> edges(3 * mesh.triangles.size());
  forEachIndex(edges.size(), [&](std::size_t i) {
    const std::size_t t = i / 3, k = i % 3;
    const std::uint32_t a = mesh.triangles[t][k], b = mesh.triangles[t][(k + 1) % 3];
    edges[i] = {std::min(a, b), std::max(a, b), static_cast<std::uint32_t>(t)};
  });
  tbb::parallel_sort(edges.begin(), edges.end(), [](const HalfEdge& a, const HalfEdge& b) {
    return a.low != b.low ? a.low < b.low : a.high != b.high ? a.high < b.high : a.triangle < b.triangle;
  });
  const double limit = std::cos(angle);
  const auto normalOf = [&](std::size_t i) { return Vector3d(areaVector(mesh, edges[i].triangle).normalized()); };
  const auto isSharp = [&](std::size_t i) -> char {
    return edges[i].low == edges[i + 1].low && edges[i].high == edges[i + 1].high && normalOf(i).dot(normalOf(i + 1)) < limit;
  };
  std::vector<SharpEdge> sharp;
  addInOrder<char>(edges.empty() ? 0 : edges.size() - 1, isSharp, [&](std::size_t i, char is_sharp) {
    if (is_sharp) sharp.push_back({edges[i].low, edges[i].high, edges[i].triangle, (normalOf(i) + normalOf(i + 1)).normalized()});
  });
  return sharp;
}

}  // namespace

std::vector<SurfaceSample> sampleSurface(const TriangleMesh& mesh, const SampleSettings& settings) {
  std::mt19937_64 random(settings.seed);
  std::vector<SurfaceSample> samples;
  const std::size_t triangles = mesh.triangles.size();
  std::vector<double> cumulative(triangles + 1, 0);
  addInOrder<double>(
      triangles, [&](std::size_t t) { return areaVector(mesh, t).norm(); },
      [&](std::size_t t, double area) { cumulative[t + 1] = cumulative[t] + area; });
  const double area = cumulative.back();
  if (!(area > 0) || settings.count == 0) return samples;
  samples.reserve(settings.count + settings.count / 2);

  std::size_t t = 0;
  for (std::size_t i = 0; i < settings.count; ++i) {
    const double at = area * (static_cast<double>(i) + randomUnit(random)) / static_cast<double>(settings.count);
    while (t + 1 < triangles && cumulative[t + 1] <= at) ++t;
    const double root = std::sqrt(randomUnit(random)), v = randomUnit(random);
    const Vector3d p = (1 - root) * mesh.corner(t, 0) + root * (1 - v) * mesh.corner(t, 1) + root * v * mesh.corner(t, 2);
    samples.push_back({p, areaVector(mesh, t).normalized(), static_cast<std::uint32_t>(t), false});
  }

  const std::vector<SharpEdge> sharp = findSharpEdges(mesh, settings.sharp_angle);
  std::vector<std::uint32_t> degree(mesh.positions.size(), 0), a_triangle(mesh.positions.size(), 0);
  std::vector<Vector3d> direction(mesh.positions.size(), Vector3d::Zero()), normal(mesh.positions.size(), Vector3d::Zero());
  for (const SharpEdge& e : sharp) {
    const Vector3d along = (mesh.positions[e.high] - mesh.positions[e.low]).normalized();
    for (const std::uint32_t v : {e.low, e.high}) {
      ++degree[v];
      a_triangle[v] = e.triangle;
      direction[v] += v == e.low ? along : Vector3d(-along);
      normal[v] += e.normal;
    }
  }
  std::vector<SurfaceSample> features;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    // A corner: sharp edges meet, end, or turn by more than the sharp angle.
    const bool corner = degree[v] > 0 && (degree[v] != 2 || direction[v].norm() > 2 * std::sin(0.5 * settings.sharp_angle));
    if (corner) features.push_back({mesh.positions[v], normal[v].normalized(), a_triangle[v], true});
  }
  const double spacing = std::sqrt(area / static_cast<double>(settings.count));
  double carry = 0.5 * spacing;
  for (const SharpEdge& e : sharp) {
    const Vector3d a = mesh.positions[e.low], b = mesh.positions[e.high];
    const double edge_length = (b - a).norm();
    for (; carry < edge_length; carry += spacing) features.push_back({a + (carry / edge_length) * (b - a), e.normal, e.triangle, true});
    carry -= edge_length;
  }
  // A rough scan has sharp edges everywhere: an even selection of them suffices.
  const std::size_t largest = settings.count / 2;
  if (features.size() <= largest) {
    samples.insert(samples.end(), features.begin(), features.end());
  } else {
    for (std::size_t i = 0; i < largest; ++i) samples.push_back(features[i * features.size() / largest]);
  }
  return samples;
}

}  // namespace spheretree::builder
