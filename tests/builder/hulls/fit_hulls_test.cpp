// SPDX-License-Identifier: GPL-3.0-or-later
#include "hulls/fit_hulls.h"

#include <gtest/gtest.h>

#include <vector>

#include "certify/triangle_piece.h"
#include "hulls/hull_cover.h"
#include "hulls/hull_overhang.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

std::vector<Hull> fit(const TriangleMesh& mesh, double tolerance, std::size_t max_hulls, std::uint64_t seed = 1) {
  Progress progress;
  return fitHulls(mesh, DistanceField(mesh), {.tolerance = tolerance, .rounding = 1e-6, .max_hulls = max_hulls, .seed = seed}, progress);
}

// What the fit returns is a cover within the tolerance, whatever the seed: proven here, as the builder does later.
TEST(FitHulls, CoverWithinTheTolerance) {
  const TriangleMesh torus = test::torusMesh(3, 1, 24, 12);
  for (const std::uint64_t seed : {1, 5}) {
    const std::vector<Hull> hulls = fit(torus, 0.15, 60, seed);
    ASSERT_FALSE(hulls.empty());
    const HullCover cover(hulls, 1e-9);
    for (std::size_t t = 0; t < torus.triangles.size(); ++t)
      ASSERT_TRUE(cover.holds(pieceOf(torus, t, Eigen::Vector3d::Zero()))) << "triangle " << t << ", seed " << seed;
    for (const Hull& hull : hulls) EXPECT_LE(hullOverhang(DistanceField(torus), hull, {.relative = 1e-3}).bound, 0.15 * (1 + 2e-3));
  }
}

TEST(FitHulls, NoneIfTheNumberDoesNotSuffice) { EXPECT_TRUE(fit(test::torusMesh(3, 1, 24, 12), 0.15, 3).empty()); }

}  // namespace
}  // namespace spheretree::builder
