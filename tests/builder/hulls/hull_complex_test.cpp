// SPDX-License-Identifier: GPL-3.0-or-later
#include "hulls/hull_complex.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "support/hull_fit.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

TEST(HullComplex, JoinedBallsHoldAllSamples) {
  const test::HullFitRig rig(test::torusMesh(3, 1, 24, 12), 0.15);
  const HullComplex complex = rig.joined();
  EXPECT_TRUE(test::isConsistent(complex));
  EXPECT_LE(test::worstSample(complex), complex.most());
  for (std::uint32_t v = 0; v < complex.balls().size(); ++v)
    for (const std::uint32_t w : complex.neighbours(v)) {
      const auto back = complex.neighbours(w);
      EXPECT_NE(std::ranges::find(back, v), back.end()) << "neighbours of each other";
    }
}

TEST(HullComplex, PruningAndBarePlacesKeepItConsistent) {
  const test::HullFitRig rig(test::torusMesh(3, 1, 24, 12), 0.15);
  HullComplex complex = rig.joined();
  const std::size_t hulls = complex.simplices().size(), samples = complex.samples().size();
  complex.prune();
  EXPECT_LT(complex.simplices().size(), hulls);
  EXPECT_TRUE(test::isConsistent(complex));
  EXPECT_LE(test::worstSample(complex), complex.most());
  const HullComplex before = complex;
  const bool was_bare = complex.addBare();
  EXPECT_EQ(complex.samples().size() > samples, was_bare);
  const std::size_t more = complex.samples().size();
  complex.restore(before);
  EXPECT_EQ(complex.samples().size(), more) << "samples stay";
  EXPECT_TRUE(test::isConsistent(complex));
}

}  // namespace
}  // namespace spheretree::builder
