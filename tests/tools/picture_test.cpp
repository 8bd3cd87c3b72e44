// SPDX-License-Identifier: GPL-3.0-or-later
#include "page/picture.h"

#include <gtest/gtest.h>
#include <png.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "spheretree/formats/errors.h"
#include "support/shapes.h"

namespace spheretree {
namespace {

struct Pixels {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;
  std::array<int, 3> at(int x, int y) const {
    const std::size_t i = (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)) * 3;
    return {rgb[i], rgb[i + 1], rgb[i + 2]};
  }
  bool isWhite(int x, int y) const { return at(x, y) == std::array<int, 3>{255, 255, 255}; }
  int painted(int from_x, int to_x) const {
    int count = 0;
    for (int y = 0; y < height; ++y)
      for (int x = from_x; x < to_x; ++x) count += isWhite(x, y) ? 0 : 1;
    return count;
  }
};

Pixels decode(const std::vector<std::byte>& png) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  Pixels pixels;
  EXPECT_NE(png_image_begin_read_from_memory(&image, png.data(), png.size()), 0) << image.message;
  image.format = PNG_FORMAT_RGB;
  pixels.width = static_cast<int>(image.width);
  pixels.height = static_cast<int>(image.height);
  pixels.rgb.resize(PNG_IMAGE_SIZE(image));
  EXPECT_NE(png_image_finish_read(&image, nullptr, pixels.rgb.data(), 0, nullptr), 0) << image.message;
  return pixels;
}

/// A root and the spheres of one level below it.
SphereTree twoLevels(const Sphere& root, const std::vector<Sphere>& children) {
  SphereTree tree;
  tree.cover = {root};
  tree.cover.insert(tree.cover.end(), children.begin(), children.end());
  tree.child_count.assign(tree.cover.size(), 0);
  tree.child_count[0] = static_cast<std::uint8_t>(children.size());
  EXPECT_TRUE(linkNodes(tree));
  encloseDescendants(tree);
  countLevels(tree);
  return tree;
}

TEST(Picture, ASphereFillsItsShareOfThePanel) {
  const SphereTree tree = twoLevels({5, -3, 2, 4}, {{5, -3, 2, 4}, {5, -3, 2, 1}});
  PictureSettings settings;
  settings.width = 400;
  settings.levels = 1;
  const Pixels pixels = decode(drawPicture(nullptr, tree, SphereKind::Cover, settings));
  ASSERT_EQ(pixels.width, 400);
  const int gap = 400 / 60;
  const double diameter = 400 - 2.0 * gap;
  EXPECT_NEAR(pixels.height, diameter + 2 * gap, 1.5);
  // Pixels that the outline only touches count as painted: at most one ring.
  EXPECT_NEAR(pixels.painted(0, 400), std::numbers::pi / 4 * diameter * diameter, 4 * diameter);
  EXPECT_TRUE(pixels.isWhite(gap + 2, gap + 2));
  EXPECT_FALSE(pixels.isWhite(200, pixels.height / 2));
}

TEST(Picture, TheNearerSphereHidesTheFartherOne) {
  // Seen along y, both project to the same circle; the side of the eye decides which one is visible.
  const SphereTree tree = twoLevels({0, 0, 0, 3}, {{0, -2, 0, 1}, {0, 2, 0, 1}});
  PictureSettings settings;
  settings.width = 300;
  settings.view = {0, -1, 0};
  const Pixels front = decode(drawPicture(nullptr, tree, SphereKind::Cover, settings));
  settings.view = {0, 1, 0};
  const Pixels back = decode(drawPicture(nullptr, tree, SphereKind::Cover, settings));
  ASSERT_EQ(front.height, back.height);
  int different = 0, darkest = 255;
  for (int x = 0; x < 300; ++x) {
    if (!front.isWhite(x, front.height / 2)) darkest = std::min(darkest, front.at(x, front.height / 2)[0]);
    different += front.at(x, front.height / 2) != back.at(x, back.height / 2) ? 1 : 0;
  }
  EXPECT_LT(darkest, 160);
  EXPECT_GT(different, 40) << "the small panel shows another hue from behind";
}

TEST(Picture, UpIsUpAndRightIsRight) {
  // From the front (-y): x to the right, z up. A small sphere beside the root marks the corner.
  const SphereTree tree = twoLevels({0, 0, 0, 1}, {{0, 0, 0, 1}, {2.5f, 0, 2.5f, 0.5f}});
  PictureSettings settings;
  settings.width = 600;
  settings.view = {0, -1, 0};
  const Pixels pixels = decode(drawPicture(nullptr, tree, SphereKind::Cover, settings));
  int top_right = 0, bottom_right = 0;
  for (int y = 0; y < pixels.height; ++y)
    for (int x = 500; x < 600; ++x) (y < pixels.height / 2 ? top_right : bottom_right) += pixels.isWhite(x, y) ? 0 : 1;
  EXPECT_GT(top_right, 1000);
  EXPECT_EQ(bottom_right, 0);
}

TEST(Picture, AMeshGetsAPanelOfItsOwnAndShowsThroughTheRoot) {
  const TriangleMesh box = test::boxMesh({-1, -1, -1}, {1, 1, 1});
  const SphereTree tree = twoLevels({0, 0, 0, 2}, {{0, 0, 0, 2}});
  PictureSettings settings;
  settings.width = 600;
  settings.levels = 1;
  settings.view = {0, -1, 0};
  const Pixels with = decode(drawPicture(&box, tree, SphereKind::Cover, settings));
  // Panels 2 and 4 wide; the first holds the box, a full square.
  const int gap = 10;
  const double scale = (600 - 3.0 * gap) / 6;
  EXPECT_NEAR(with.painted(0, static_cast<int>(gap * 1.5 + 2 * scale)), 4 * scale * scale, 5 * scale);
  const auto inside = with.at(static_cast<int>(2 * gap + 4 * scale), with.height / 2);
  const auto beside = with.at(static_cast<int>(2 * gap + 2.5 * scale), with.height / 2);
  EXPECT_NE(inside, beside);
}

TEST(Picture, SameTreeSamePixels) {
  const TriangleMesh ball = test::sphereMesh(2, 3);
  const SphereTree tree = twoLevels({0, 0, 0, 2.1f}, {{1, 0, 0, 1.5f}, {-1, 0, 0, 1.5f}});
  const PictureSettings settings{.width = 500};
  EXPECT_EQ(drawPicture(&ball, tree, SphereKind::Bound, settings), drawPicture(&ball, tree, SphereKind::Bound, settings));
}

TEST(Picture, ASlenderTreeStaysWithinTheHeightLimit) {
  const SphereTree tree = twoLevels({0, 0, 0, 30}, {{0, 0, 500, 30}, {0, 0, -500, 30}});
  PictureSettings settings;
  settings.width = 100;
  settings.view = {0, -1, 0};
  const Pixels pixels = decode(drawPicture(nullptr, tree, SphereKind::Cover, settings));
  EXPECT_LE(pixels.height, settings.width);
  EXPECT_GT(pixels.painted(0, 100), 0);
}

TEST(Picture, RefusesAViewOfNoDirectionAndAWidthOutOfRange) {
  const SphereTree tree = twoLevels({0, 0, 0, 2}, {{0, 0, 0, 2}});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const std::array<double, 3>& view : {std::array<double, 3>{0, 0, 0}, {nan, 1, 0}, {1e308, 1e308, 0}}) {
    EXPECT_THROW(drawPicture(nullptr, tree, SphereKind::Cover, {.view = view}), std::invalid_argument);
  }
  for (const int width : {-1, 0, kMinPictureWidth - 1, kMaxPictureWidth + 1}) {
    EXPECT_THROW(drawPicture(nullptr, tree, SphereKind::Cover, {.width = width}), std::invalid_argument);
  }
}

TEST(Picture, RefusesAMeshTooLargeToBeDrawn) {
  const SphereTree tree = twoLevels({0, 0, 0, 2}, {{0, 0, 0, 2}});
  const TriangleMesh huge = test::boxMesh(Eigen::Vector3d::Constant(-1e31), Eigen::Vector3d::Constant(1e31));
  EXPECT_THROW(drawPicture(&huge, tree, SphereKind::Cover, {.width = 100}), formats::FormatError);
  const TriangleMesh large = test::boxMesh(Eigen::Vector3d::Constant(-1e29), Eigen::Vector3d::Constant(1e29));
  EXPECT_FALSE(drawPicture(&large, tree, SphereKind::Cover, {.width = 100}).empty());
}

}  // namespace
}  // namespace spheretree
