// SPDX-License-Identifier: GPL-3.0-or-later
#include "split/border_distances.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "support/random.h"

namespace spheretree::builder {
namespace {

constexpr std::uint32_t kGridCells = 40;
constexpr double kGridEdge = 0.25, kGridBorder = 5 - kGridEdge / 2;

/// A square grid in the plane z = 0 with a tooth at x > kGridBorder, in the middle between two columns of vertices.
ScanSurface halves() {
  ScanSurface s;
  for (std::uint32_t j = 0; j <= kGridCells; ++j)
    for (std::uint32_t i = 0; i <= kGridCells; ++i) {
      s.mesh.positions.emplace_back(kGridEdge * i, kGridEdge * j, 0);
      s.vertex_region.push_back(kGridEdge * i > kGridBorder ? 1 : kGumRegion);
    }
  for (std::uint32_t j = 0; j < kGridCells; ++j)
    for (std::uint32_t i = 0; i < kGridCells; ++i) {
      const std::uint32_t a = j * (kGridCells + 1) + i, b = a + 1, c = b + kGridCells + 1, d = c - 1;
      s.mesh.triangles.push_back({a, b, c});
      s.mesh.triangles.push_back({a, c, d});
    }
  s.is_invented.assign(s.mesh.triangles.size(), 0);
  s.region_label = {0, 11};
  return s;
}

TEST(BorderDistances, AreExactAtAStraightBorderAndOppositeInBothRegions) {
  const ScanSurface s = halves();
  const BorderDistances found = findBorderDistances(s, VertexNeighbours(s.mesh), 0.15);
  EXPECT_GE(found.band, 4 * kGridEdge);
  for (std::size_t v = 0; v < s.mesh.positions.size(); ++v) {
    const double x = s.mesh.positions[v].x() - kGridBorder;
    if (std::abs(x) > found.band) {
      EXPECT_TRUE(found.of_vertex[v].empty());
    }
    for (const RegionDistance& k : found.of_vertex[v]) EXPECT_NEAR(k.distance, k.region == 1 ? x : -x, 1e-12);
    if (std::abs(x) < found.band - kGridEdge) {
      EXPECT_EQ(found.of_vertex[v].size(), 2u);
    }
  }
}

// Random labels at the vertices beside the border: it comes back near to where it was, and the distances of the gum are
// the opposite ones.
TEST(BorderDistances, OfJaggedLabelsAreThoseToTheMiddleOfWhatIsInDoubt) {
  double squares = 0;
  std::size_t count = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    test::Random random(seed);
    ScanSurface s = halves();
    const auto isBeside = [&](std::size_t v) { return std::abs(s.mesh.positions[v].x() - kGridBorder) < 0.6 * kGridEdge; };
    for (std::size_t v = 0; v < s.vertex_region.size(); ++v)
      if (isBeside(v)) s.vertex_region[v] = random.unit() < 0.5;
    const BorderDistances found = findBorderDistances(s, VertexNeighbours(s.mesh), 0.15);
    for (std::size_t v = 0; v < s.vertex_region.size(); ++v) {
      const auto& known = found.of_vertex[v];
      if (!isBeside(v) || known.size() < 2) continue;
      EXPECT_NEAR(known[0].distance, -known[1].distance, 1e-12);
      squares += std::pow((known[1].distance - (s.mesh.positions[v].x() - kGridBorder)) / kGridEdge, 2);
      ++count;
    }
  }
  ASSERT_GT(count, 1000u);
  const double rms = std::sqrt(squares / static_cast<double>(count));
  std::printf("centred: %.3f edges\n", rms);
  EXPECT_LT(rms, 0.45);
}

}  // namespace
}  // namespace spheretree::builder
