// SPDX-License-Identifier: GPL-3.0-or-later
#include "split/cut_labels.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdlib>

#include "scan.h"
#include "split/label_pieces.h"

#include "support/mesh_measures.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

struct Error {
  double mean = 0, largest = 0;
};

ScanSurface cutScan(const samples::SampleScan& scan, double smooth) {
  const LabelPieces pieces = findLabelPieces(scan.mesh, scan.labels, 4);
  ScanSurface surface{scan.mesh, pieces.region, {}, std::vector<char>(scan.mesh.triangles.size(), 0), pieces.region_label};
  cutLabels(surface, smooth);
  return surface;
}

/// For the midpoints of the edges between regions, the distance to the nearest margin of a tooth.
Error marginError(const samples::SampleScan& scan, const ScanSurface& surface) {
  const EdgeFaces faces(surface.mesh);
  Error error;
  std::size_t count = 0;
  for (std::size_t t = 0; t < surface.mesh.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = surface.mesh.triangles[t][k], b = surface.mesh.triangles[t][(k + 1) % 3], other = faces.face(b, a);
      if (other == EdgeFaces::kNone || surface.region[t] == 0 || surface.region[other] == surface.region[t]) continue;
      const Vector3d p = (surface.mesh.positions[a] + surface.mesh.positions[b]) / 2;
      double smallest = 1e9;
      for (const auto& margin : scan.margins)
        for (std::size_t i = 0; i < margin.size(); ++i) {
          const Vector3d &q = margin[i], way = margin[(i + 1) % margin.size()] - q;
          const double at = way.squaredNorm() > 0 ? std::clamp((p - q).dot(way) / way.squaredNorm(), 0.0, 1.0) : 0;
          smallest = std::min(smallest, (p - q - at * way).norm());
        }
      error.mean += smallest, error.largest = std::max(error.largest, smallest), ++count;
    }
  error.mean /= static_cast<double>(count);
  return error;
}

TEST(CutLabels, IsAtTheMarginAndSmoothWhereLabelsAreJagged) {
  const samples::Mouth mouth = samples::makeMouth();
  const double edge = std::getenv("SPHERETREE_LONG") ? 0.3 : 0.4;
  samples::ScanSettings settings{.edge_mm = edge, .hidden_removed = false};
  const samples::SampleScan exact = samples::makeScan(mouth, settings);
  settings.jagged = true;
  const samples::SampleScan rough = samples::makeScan(mouth, settings);
  const Error whole = marginError(exact, cutScan(exact, 0.15)), jagged = marginError(rough, cutScan(rough, 0.15));
  const Error raw = marginError(rough, cutScan(rough, 0));
  std::printf("margin: exact %.3f %.3f, jagged %.3f %.3f, without smoothing %.3f %.3f mm (mean, largest)\n", whole.mean, whole.largest,
              jagged.mean, jagged.largest, raw.mean, raw.largest);
  // The vertices on the margin are labelled as teeth, so that the midpoints of the edges lie half an edge beside it.
  EXPECT_LT(whole.mean, 0.6 * edge);
  EXPECT_LT(whole.largest, edge);
  EXPECT_LT(jagged.largest, raw.largest);
  EXPECT_LT(jagged.mean, 0.3);
}

TEST(CutLabels, KeepsTheAreaAndOpensNoEdge) {
  const samples::SampleScan scan = samples::makeScan(samples::makeMouth(), {.edge_mm = 0.9, .hidden_removed = false});
  const ScanSurface surface = cutScan(scan, 0.3);
  EXPECT_NEAR(test::areaOf(surface.mesh), test::areaOf(scan.mesh), 1e-9 * test::areaOf(scan.mesh));
  EXPECT_EQ(surface.region.size(), surface.mesh.triangles.size());
  const auto borders = [](const TriangleMesh& mesh) {
    const EdgeFaces faces(mesh);
    std::size_t open = 0;
    for (const Triangle& t : mesh.triangles)
      for (std::size_t k = 0; k < 3; ++k) open += faces.face(t[(k + 1) % 3], t[k]) == EdgeFaces::kNone;
    return open;
  };
  EXPECT_EQ(borders(surface.mesh), borders(scan.mesh));
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
