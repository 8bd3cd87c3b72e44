// SPDX-License-Identifier: GPL-3.0-or-later
#include "split/label_pieces.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace spheretree::builder {
namespace {

/// A grid of squares of 1 mm, each of two triangles, and a label for each vertex.
struct Grid {
  static constexpr std::uint32_t kSide = 20;
  TriangleMesh mesh;
  std::vector<std::int32_t> label;
  Grid() {
    for (std::uint32_t j = 0; j <= kSide; ++j)
      for (std::uint32_t i = 0; i <= kSide; ++i) mesh.positions.emplace_back(i, j, 0), label.push_back(0);
    for (std::uint32_t j = 0; j < kSide; ++j)
      for (std::uint32_t i = 0; i < kSide; ++i) {
        const std::uint32_t a = j * (kSide + 1) + i, b = a + 1, c = b + kSide + 1, d = c - 1;
        mesh.triangles.push_back({a, b, c});
        mesh.triangles.push_back({a, c, d});
      }
  }
  void fill(std::uint32_t left, std::uint32_t bottom, std::uint32_t right, std::uint32_t top, std::int32_t value) {
    for (std::uint32_t j = bottom; j <= top; ++j)
      for (std::uint32_t i = left; i <= right; ++i) label[j * (kSide + 1) + i] = value;
  }
};

TEST(LabelPieces, PiecesAreRegionsByLabelAndSize) {
  Grid grid;
  grid.fill(1, 1, 4, 4, 21);
  grid.fill(10, 10, 16, 16, 21);
  grid.fill(1, 10, 4, 14, 11);
  const LabelPieces pieces = findLabelPieces(grid.mesh, grid.label, 4);
  EXPECT_EQ(pieces.region_label, (std::vector<std::int32_t>{0, 11, 21, 21}));
  EXPECT_EQ(pieces.region_piece, (std::vector<int>{1, 1, 1, 2}));
  EXPECT_EQ(pieces.islands, 0u);
  EXPECT_EQ(pieces.region[10 * 21 + 10], 2) << "the larger piece comes first";
  EXPECT_EQ(pieces.region[21 + 1], 3);
}

TEST(LabelPieces, AnIslandTakesTheLabelRoundMostOfIt) {
  Grid grid;
  grid.fill(0, 0, 20, 9, 31);
  grid.fill(8, 8, 9, 9, 46);  // two by two vertices at the edge of 31, which surrounds three of their sides
  grid.fill(3, 3, 3, 3, 0);   // a spot of gum within 31
  const LabelPieces pieces = findLabelPieces(grid.mesh, grid.label, 5);
  EXPECT_EQ(pieces.islands, 2u);
  EXPECT_EQ(pieces.region_label, (std::vector<std::int32_t>{0, 31}));
  EXPECT_EQ(pieces.region[8 * 21 + 8], 1);
  EXPECT_EQ(pieces.region[3 * 21 + 3], 1);
}

TEST(LabelPieces, AllGumIsOneRegion) {
  Grid grid;
  grid.fill(9, 0, 11, 20, 41);  // a wall of tooth between two pieces of gum
  const LabelPieces pieces = findLabelPieces(grid.mesh, grid.label, 1);
  EXPECT_EQ(pieces.region_label.size(), 2u);
  EXPECT_EQ(pieces.region[0], kGumRegion);
  EXPECT_EQ(pieces.region[20], kGumRegion);
}

TEST(LabelPieces, ChequeredLabelsEnd) {
  Grid grid;
  for (std::size_t v = 0; v < grid.label.size(); ++v) grid.label[v] = static_cast<std::int32_t>(v * 7919 % 5);
  const LabelPieces pieces = findLabelPieces(grid.mesh, grid.label, 30);
  EXPECT_EQ(pieces.region.size(), grid.label.size());
  EXPECT_LE(pieces.region_label.size(), 14u) << "400 mm2 hold no more pieces of 30";
}

}  // namespace
}  // namespace spheretree::builder
