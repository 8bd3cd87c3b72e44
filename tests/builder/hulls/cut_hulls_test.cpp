// SPDX-License-Identifier: GPL-3.0-or-later
#include "hulls/cut_hulls.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "support/random.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

std::array<std::size_t, 4> kindsOf(const Hulls& hulls) {
  std::array<std::size_t, 4> kinds{};
  for (const HullPart& part : hulls.parts) ++kinds[ballCount(part)];
  return kinds;
}

TEST(CutHulls, PartsAreShortAndTheirUnionIsTheHull) {
  const std::vector<Hull> hulls{{{Ball{{0, 0, 0}, 0.5}, Ball{{0, 0, 30}, 1}, {}}, 2},
                                {{Ball{{0, 0, 30}, 0.5}, Ball{{6, 0, 30}, 0.4}, Ball{{0, 6, 30}, 0.3}}, 3}};
  const Vector3d origin(0, 0, 10);
  const Hulls cut = cutHulls(hulls, origin);
  EXPECT_EQ(findFault(cut), "");
  EXPECT_EQ(cut.count, 2u);
  std::vector<HullDistance> parts;
  for (const HullPart& part : cut.parts) {
    const Hull hull = hullOf(cut, part);
    parts.emplace_back(hull);
    for (std::size_t k = 0; k < hull.count; ++k)
      EXPECT_LE((hull.ball[k].centre - hull.ball[(k + 1) % hull.count].centre).norm(), 4.001 * std::max(hull.ball[k].radius, 0.5));
  }
  test::Random random(2);
  for (int i = 0; i < 2000; ++i) {
    const Vector3d p = Vector3d(0, 0, 20) + 16 * random.inCube(1).cwiseProduct(Vector3d(0.5, 0.5, 1));
    double whole = kInfinity, by_parts = kInfinity;
    for (const Hull& hull : hulls) whole = std::min(whole, HullDistance(hull)(p));
    for (const HullDistance& part : parts) by_parts = std::min(by_parts, part(p - origin));
    EXPECT_EQ(std::max(whole, 0.0) < 1e-4, std::max(by_parts, 0.0) < 1e-4) << p.transpose();
    if (whole > 0) {
      EXPECT_NEAR(by_parts, whole, 1e-5);
    }
  }
}

TEST(CutHulls, AThinSlabHasNoThousandsOfParts) {
  const Hull face{{Ball{{0, 0, 0}, 0.01}, Ball{{20, 0, 0}, 0.01}, Ball{{0, 20, 0}, 0.01}}, 3};
  const std::array<std::size_t, 4> kinds = kindsOf(cutHulls(std::vector<Hull>{face}, Vector3d::Zero()));
  EXPECT_GE(kinds[3], 64u);
  EXPECT_LE(kinds[3], 128u);
  // Two slabs share a side, which is cut in the same way for both.
  const Hull other{{Ball{{20, 20, 9}, 0.01}, Ball{{20, 0, 0}, 0.01}, Ball{{0, 20, 0}, 0.01}}, 3};
  const std::array<std::size_t, 4> alone = kindsOf(cutHulls(std::vector<Hull>{other}, Vector3d::Zero())),
                                   both = kindsOf(cutHulls(std::vector<Hull>{face, other}, Vector3d::Zero()));
  EXPECT_EQ(both[2], kinds[2] + alone[2] - 1024) << "28.3 mm in pieces of at most 0.04";
}

TEST(CutHulls, JointsMadeByCuttingAndHiddenPartsAreLeftOut) {
  const Hull rod{{Ball{{0, 0, 0}, 1}, Ball{{0, 0, 32}, 1}, {}}, 2};
  EXPECT_EQ(kindsOf(cutHulls(std::vector<Hull>{rod}, Vector3d::Zero())), (std::array<std::size_t, 4>{0, 2, 8, 0}));
  // A ball at the end of the rod hides its end, and a thin rod inside it is not there at all.
  const Hull head{{Ball{{0, 0, 32}, 3}, {}, {}}, 1}, core{{Ball{{0, 0, 1}, 0.5}, Ball{{0, 0, 31}, 0.5}, {}}, 2};
  const std::array<std::size_t, 4> kinds = kindsOf(cutHulls(std::vector<Hull>{rod, head, core}, Vector3d::Zero()));
  EXPECT_EQ(kinds, (std::array<std::size_t, 4>{0, 2, 8, 0}));
  const Hull again = rod;
  EXPECT_EQ(kindsOf(cutHulls(std::vector<Hull>{rod, again}, Vector3d::Zero())), (std::array<std::size_t, 4>{0, 2, 8, 0}))
      << "of equal hulls one stays";
}

TEST(CutHulls, TheCommonSideOfCoplanarSlabsIsNoPart) {
  const Ball a{{0, 0, 0}, 1}, b{{3, 0, 0}, 1}, c{{3, 3, 0}, 1}, d{{0, 3, 0}, 1};
  // The second one reaches beyond the diagonal a c, so that it holds the cone on it.
  const Hull first{{a, b, c}, 3}, second{{a, c, d}, 3};
  const std::array<std::size_t, 4> kinds = kindsOf(cutHulls(std::vector<Hull>{first, second}, Vector3d::Zero()));
  EXPECT_EQ(kinds[3], 4u) << "each slab in two, since its diagonal is longer than four radii";
  EXPECT_EQ(kinds[1], 4u);
}

}  // namespace
}  // namespace spheretree::builder
