// SPDX-License-Identifier: GPL-3.0-or-later
#include "level_search.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "spheretree/core/sphere_tree.h"
#include "support/random.h"

namespace spheretree::builder {
namespace {

// A model of a builder: n leaves reach out by about `size / n`, and certification adds a random share.
struct Model {
  double size = 10, max_added = 0.04;
  std::uint64_t seed = 1;
  bool noisy = true;
  mutable int builds = 0;

  double overhang(std::size_t leaves) const {
    test::Random random(seed + 977 * leaves);
    return size / static_cast<double>(leaves) * (noisy ? random.between(1, 1.1) : 1);
  }
  double certifiedOverhang(std::size_t leaves) const {
    test::Random random(seed + 31 * leaves);
    return overhang(leaves) * (1 + random.between(0, max_added));
  }

  CertifiedLevels withLeaves(std::size_t leaves, int levels) const {
    CertifiedLevels out;
    std::size_t width = leaves;
    for (int level = 0; level < levels; ++level, width = std::max<std::size_t>(1, width / 4))
      out.spheres.insert(out.spheres.begin(), std::vector<Sphere>(level + 1 == levels ? 1 : width));
    out.uncertified_overhang = overhang(leaves);
    out.overhang_bound = certifiedOverhang(leaves);
    return out;
  }

  CertifiedLevels operator()(const BuildSettings& settings, std::size_t max_levels) const {
    ++builds;
    std::size_t budget = 1;
    for (int level = 1; level < settings.levels; ++level) budget *= static_cast<std::size_t>(settings.branching);
    if (settings.tolerance_mm == 0) {
      const auto depth = static_cast<int>(std::min(max_levels, static_cast<std::size_t>(settings.levels)));
      CertifiedLevels out = withLeaves(depth == 1 ? 1 : budget, depth);
      std::size_t width = 1;
      for (std::size_t level = 0; level < out.spheres.size(); ++level, width *= static_cast<std::size_t>(settings.branching))
        out.spheres[level].resize(width);
      return out;
    }
    std::size_t leaves = 1;
    while (leaves < budget && overhang(leaves) > settings.tolerance_mm) ++leaves;
    int depth = 1;
    for (std::size_t width = 1; width < leaves; width *= 4) ++depth;
    return withLeaves(leaves, depth);
  }
};

CertifiedLevels search(const Model& model, double tolerance, BuilderKind kind = BuilderKind::Cover) {
  BuildSettings settings;
  settings.builder = kind;
  settings.tolerance_mm = tolerance;
  return searchLevels(settings, tolerance, [&](const BuildSettings& s, std::size_t max_count) { return model(s, max_count); });
}

TEST(LevelSearch, WithoutAToleranceBuildsOnceWithTheSettings) {
  const Model model;
  const CertifiedLevels out = search(model, 0);
  EXPECT_EQ(model.builds, 1);
  EXPECT_EQ(out.spheres.back().size(), 512u);
}

TEST(LevelSearch, KeepsEveryToleranceInReachWhateverCertificationAdds) {
  for (const BuilderKind kind : {BuilderKind::Cover, BuilderKind::Grid, BuilderKind::Octree})
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      Model model;
      model.seed = seed;
      model.max_added = kind == BuilderKind::Octree ? 0 : 0.06;  // more than the allowance
      for (double tolerance = 0.05; tolerance < 12; tolerance *= 1.37) {
        const CertifiedLevels out = search(model, tolerance, kind);
        EXPECT_LE(out.overhang_bound, tolerance) << name(kind) << ", seed " << seed;
      }
    }
}

TEST(LevelSearch, GivesTheBestItHasWhereTheToleranceIsOutOfReach) {
  const Model model;
  const double tolerance = 0.5 * model.overhang(512);
  const CertifiedLevels out = search(model, tolerance);
  EXPECT_GT(out.overhang_bound, tolerance);
  EXPECT_EQ(out.spheres.back().size(), 512u);
}

TEST(LevelSearch, OneSphereIsEnoughWhereOneSphereKeepsIt) {
  Model model;
  model.noisy = false;
  const CertifiedLevels out = search(model, 1.2 * model.size);
  EXPECT_EQ(out.count(), 1u);
}

// The exhaustive part: no full tree of at most 21 nodes that keeps the tolerance has fewer nodes than the result. It
// tests the enumeration, not the quality of any builder.
TEST(LevelSearch, NoSmallFullTreeIsPassedOver) {
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    Model model;
    model.seed = seed;
    for (int branching = 2; branching <= 4; ++branching)
      for (int depth = 2; depth <= 3; ++depth) {
        BuildSettings settings;
        settings.branching = branching;
        settings.levels = depth;
        const CertifiedLevels full = model(settings, static_cast<std::size_t>(depth));
        EXPECT_LE(search(model, full.overhang_bound).count(), full.count()) << branching << " by " << depth << ", seed " << seed;
      }
  }
}

}  // namespace
}  // namespace spheretree::builder
