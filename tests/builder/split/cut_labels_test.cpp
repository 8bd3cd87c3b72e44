// SPDX-License-Identifier: GPL-3.0-or-later
#include "split/cut_labels.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

#include "geometry/distance_field.h"
#include "scan.h"
#include "split/label_pieces.h"
#include "support/mesh_measures.h"
#include "support/random.h"
#include "support/sample_mouth.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

struct Error {
  double within_half = 0;                 // share of the cut edges that are cut within half of their length
  double mean = 0, p99 = 0, largest = 0;  // distance on the scan
  double in_space = 0;                    // largest distance
};

ScanSurface cutScan(const samples::SampleScan& scan, double smooth) {
  const LabelPieces pieces = findLabelPieces(scan.mesh, scan.labels, 4);
  ScanSurface surface{scan.mesh,           pieces.region,   {}, std::vector<char>(scan.mesh.triangles.size(), 0),
                      pieces.region_label, pieces.is_island};
  cutLabels(surface, smooth);
  return surface;
}

double distanceTo(const std::vector<std::vector<Vector3d>>& loops, const Vector3d& p) {
  double smallest = 1e9;
  for (const std::vector<Vector3d>& loop : loops)
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const Vector3d &q = loop[i], way = loop[(i + 1) % loop.size()] - q;
      const double at = way.squaredNorm() > 0 ? std::clamp((p - q).dot(way) / way.squaredNorm(), 0.0, 1.0) : 0;
      smallest = std::min(smallest, (p - q - at * way).norm());
    }
  return smallest;
}

/// The points of the scan that are nearest to the margins. The triangles of a scan bridge the furrow in which a margin
/// runs, so that no cut of the scan comes nearer than these.
std::vector<std::vector<Vector3d>> onScan(const samples::SampleScan& scan) {
  const DistanceField field(scan.mesh);
  std::vector<std::vector<Vector3d>> out;
  for (const std::vector<Vector3d>& margin : scan.margins) {
    out.emplace_back();
    for (std::size_t i = 0; i < margin.size(); ++i)
      for (const double at : {0.0, 0.25, 0.5, 0.75})
        out.back().push_back(field.nearest((1 - at) * margin[i] + at * margin[(i + 1) % margin.size()]).point);
  }
  return out;
}

/// Length of the edge of the scan on which the new vertex `v` lies; infinite inside a triangle.
double cutEdge(const TriangleMesh& mesh, const VertexNeighbours& neighbours, std::uint32_t v, std::size_t old_vertices) {
  const Vector3d& p = mesh.positions[v];
  for (const std::uint32_t a : neighbours.of(v))
    for (const std::uint32_t b : neighbours.of(v)) {
      if (a >= b || b >= old_vertices) continue;
      const double way = (mesh.positions[a] - p).norm() + (mesh.positions[b] - p).norm(),
                   edge = (mesh.positions[a] - mesh.positions[b]).norm();
      if (way < (1 + 1e-9) * edge) return edge;
    }
  return std::numeric_limits<double>::infinity();
}

/// For each vertex of the cut, the distance to the nearest margin of a tooth.
Error marginError(const samples::SampleScan& scan, const ScanSurface& surface) {
  const std::vector<std::vector<Vector3d>> margins = onScan(scan);
  const VertexNeighbours neighbours(surface.mesh);
  Error error;
  std::vector<double> all;
  for (auto v = static_cast<std::uint32_t>(scan.mesh.positions.size()); v < surface.mesh.positions.size(); ++v) {
    const Vector3d& p = surface.mesh.positions[v];
    all.push_back(distanceTo(margins, p));
    error.in_space = std::max(error.in_space, distanceTo(scan.margins, p));
    error.within_half += all.back() <= cutEdge(surface.mesh, neighbours, v, scan.mesh.positions.size()) / 2;
  }
  const auto count = static_cast<double>(all.size());
  std::sort(all.begin(), all.end());
  error.within_half /= count;
  error.mean = std::accumulate(all.begin(), all.end(), 0.0) / count;
  error.p99 = all[all.size() * 99 / 100];
  error.largest = all.back();
  return error;
}

void checkMargin(const samples::Mouth& mouth, samples::ScanSettings settings) {
  const double edge = settings.edge_mm;
  const samples::SampleScan exact = samples::makeScan(mouth, settings);
  settings.jagged = true;
  const samples::SampleScan rough = samples::makeScan(mouth, settings);
  const Error whole = marginError(exact, cutScan(exact, 0.15)), jagged = marginError(rough, cutScan(rough, 0.15));
  const Error raw = marginError(rough, cutScan(rough, 0));
  std::printf("margin, edge %.1f, seed %d, %s", edge, static_cast<int>(settings.seed), settings.upper ? "upper" : "lower");
  for (const auto& [name, e] : {std::pair("exact labels", whole), {"jagged", jagged}, {"not smoothed", raw}})
    std::printf("; %s %.4f %.3f %.3f %.3f %.3f", name, e.within_half, e.mean, e.p99, e.largest, e.in_space);
  std::printf("\n");
  // A border may lie anywhere between vertices with different labels, also on an edge that is longer than the mean;
  // smoothing and noise add little to that.
  EXPECT_GT(whole.within_half, 0.99);
  EXPECT_LT(whole.mean, 0.2 * edge);
  EXPECT_LT(whole.largest, edge);
  EXPECT_LT(jagged.mean, 0.4 * edge);
  EXPECT_LT(jagged.mean, 0.6 * raw.mean);
  EXPECT_LT(jagged.p99, 1.2 * edge);
}

/// With SPHERETREE_LONG, this prints the figures of docs/split.md.
TEST(CutLabels, IsAtTheMarginAlsoIfLabelsAreJagged) {
  const samples::Mouth& mouth = test::sampleMouth();
  if (!std::getenv("SPHERETREE_LONG")) return checkMargin(mouth, {.edge_mm = 0.4, .hidden_removed = false});
  for (const double edge : {0.2, 0.3})
    for (const std::uint64_t seed : {1, 2, 3})
      for (const bool upper : {false, true}) checkMargin(mouth, {.upper = upper, .edge_mm = edge, .noise_mm = 0.02, .seed = seed});
}

TEST(CutLabels, KeepsTheAreaAndOpensNoEdge) {
  const samples::SampleScan scan = samples::makeScan(test::sampleMouth(), {.edge_mm = 0.9, .hidden_removed = false});
  const ScanSurface surface = cutScan(scan, 0.3);
  EXPECT_NEAR(test::areaOf(surface.mesh), test::areaOf(scan.mesh), 1e-9 * test::areaOf(scan.mesh));
  EXPECT_EQ(surface.region.size(), surface.mesh.triangles.size());
  const auto borders = [](const TriangleMesh& mesh) {
    const EdgeFaces faces(mesh);
    std::size_t open = 0;
    for (const Triangle& t : mesh.triangles)
      for (std::size_t k = 0; k < 3; ++k) open += faces.face(t[(k + 1) % 3], t[k]) == kNone;
    return open;
  };
  EXPECT_EQ(borders(surface.mesh), borders(scan.mesh));
}

constexpr double kDomeEdge = 0.25, kDomeRadius = 3.5;
const std::array<Vector3d, 2> kDomes{Vector3d(5.5, 8, 0), Vector3d(14.5, 8, 0)};

/// Two teeth that are domes on a slab, with vertices at random places and circles as their margins.
ScanSurface twoDomes(test::Random& random) {
  constexpr std::uint32_t kSide = 80;
  ScanSurface clean;
  for (std::uint32_t j = 0; j <= kSide; ++j)
    for (std::uint32_t i = 0; i <= kSide; ++i) {
      Vector3d p(kDomeEdge * (i + 0.5 * (j % 2)), kDomeEdge * 0.866 * j, 0);
      p += kDomeEdge * Vector3d(random.between(-0.25, 0.25), random.between(-0.25, 0.25), 0);
      std::int32_t region = 0;
      for (std::size_t k = 0; k < 2; ++k)
        if (const double r = (p - kDomes[k]).norm(); r < kDomeRadius)
          region = static_cast<std::int32_t>(k) + 1, p.z() = 0.5 * (kDomeRadius - r);
      clean.mesh.positions.push_back(p);
      clean.vertex_region.push_back(region);
    }
  for (std::uint32_t j = 0; j < kSide; ++j)
    for (std::uint32_t i = 0; i < kSide; ++i) {
      const std::uint32_t a = j * (kSide + 1) + i, b = a + 1, c = b + kSide, d = c + 1;
      if (j % 2 == 0) {
        clean.mesh.triangles.push_back({a, b, c});
        clean.mesh.triangles.push_back({b, d, c});
      } else {
        clean.mesh.triangles.push_back({a, b, d});
        clean.mesh.triangles.push_back({a, d, c});
      }
    }
  clean.is_invented.assign(clean.mesh.triangles.size(), 0);
  clean.region_label = {0, 11, 12};
  return clean;
}

/// With labels that are random at all vertices beside the margin, the border of the labels is off by about an edge and
/// the cut is not. The labels of the neighbour, which are not jagged, do not change its cut.
TEST(CutLabels, FindsTheCircleBehindJaggedLabels) {
  test::Random random(4);
  const ScanSurface clean = twoDomes(random);
  const VertexNeighbours neighbours(clean.mesh);
  std::vector<std::int32_t> labels;
  for (std::uint32_t v = 0; v < clean.vertex_region.size(); ++v) {
    std::int32_t other = clean.vertex_region[v];
    for (const std::uint32_t u : neighbours.of(v))
      if ((clean.vertex_region[u] == 1) != (clean.vertex_region[v] == 1)) other = clean.vertex_region[u];
    labels.push_back(clean.region_label[static_cast<std::size_t>(random.unit() < 0.5 ? other : clean.vertex_region[v])]);
  }
  const LabelPieces pieces = findLabelPieces(clean.mesh, labels, 4);
  ScanSurface jagged = clean;
  jagged.vertex_region = pieces.region, jagged.is_doubtful = pieces.is_island;
  ASSERT_EQ(pieces.region_label, clean.region_label);
  const auto error = [&](ScanSurface surface, double smooth, std::size_t tooth) {
    const std::size_t old_points = surface.mesh.positions.size();
    cutLabels(surface, smooth);
    Error sum;
    std::size_t count = 0;
    for (std::size_t v = old_points; v < surface.mesh.positions.size(); ++v) {
      const Vector3d &p = surface.mesh.positions[v], level(p.x(), p.y(), 0);
      if ((level - kDomes[tooth]).norm() > (level - kDomes[1 - tooth]).norm()) continue;
      const double off = std::hypot((level - kDomes[tooth]).norm() - kDomeRadius, p.z());
      sum.mean += off, sum.largest = std::max(sum.largest, off), ++count;
    }
    sum.mean /= static_cast<double>(count);
    return sum;
  };
  const Error exact = error(clean, 0.15, 0), found = error(jagged, 0.15, 0), raw = error(jagged, 0, 0);
  std::printf("circle: exact labels %.3f %.3f, jagged %.3f %.3f, not smoothed %.3f %.3f mm (mean, largest)\n", exact.mean, exact.largest,
              found.mean, found.largest, raw.mean, raw.largest);
  EXPECT_LT(exact.largest, kDomeEdge / 2);
  EXPECT_LT(found.largest, 1.3 * kDomeEdge);
  EXPECT_LT(found.largest, 0.75 * raw.largest);
  EXPECT_LT(found.mean, 0.6 * raw.mean);
  EXPECT_NEAR(error(jagged, 0.15, 1).largest, error(clean, 0.15, 1).largest, 1e-3);
}

/// A straight border at an angle to the grid, given by a linear function at the vertices: smoothing does not move it.
TEST(CutLabels, AStraightBorderMovesByNoMoreThanAllowed) {
  for (const double smooth : {0.0, 0.1, 0.3}) {
    ScanSurface surface;
    constexpr std::uint32_t kSide = 60;
    for (std::uint32_t j = 0; j <= kSide; ++j)
      for (std::uint32_t i = 0; i <= kSide; ++i) {
        surface.mesh.positions.emplace_back(0.3 * i, 0.3 * j, 0);
        surface.vertex_region.push_back(0.3 * i + 0.11 * j > 12 ? 1 : 0);
      }
    for (std::uint32_t j = 0; j < kSide; ++j)
      for (std::uint32_t i = 0; i < kSide; ++i) {
        const std::uint32_t a = j * (kSide + 1) + i, b = a + 1, c = b + kSide + 1, d = c - 1;
        surface.mesh.triangles.push_back({a, b, c});
        surface.mesh.triangles.push_back({a, c, d});
      }
    surface.is_invented.assign(surface.mesh.triangles.size(), 0);
    surface.region_label = {0, 11};
    const std::size_t old_points = surface.mesh.positions.size();
    cutLabels(surface, smooth);
    double largest = 0;
    for (std::size_t v = old_points; v < surface.mesh.positions.size(); ++v) {
      const Vector3d& p = surface.mesh.positions[v];
      EXPECT_EQ(p.z(), 0);
      largest = std::max(largest, std::abs(p.x() + 0.11 / 0.3 * p.y() - 12) / std::hypot(1, 0.11 / 0.3));
    }
    EXPECT_LT(largest, 0.3 / 2 * std::sqrt(2) + smooth);
  }
}

}  // namespace
}  // namespace spheretree::builder
