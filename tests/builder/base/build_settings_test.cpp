// SPDX-License-Identifier: GPL-3.0-or-later
#include "spheretree/builder/build_settings.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>
#include <string>

namespace spheretree::builder {
namespace {

TEST(BuildSettings, EveryBuilderAndQualityHasANameOfItsOwn) {
  std::set<std::string_view> names;
  for (int kind = 0; kind <= static_cast<int>(BuilderKind::Octree); ++kind) names.insert(name(static_cast<BuilderKind>(kind)));
  for (int quality = 0; quality <= static_cast<int>(Quality::Best); ++quality) names.insert(name(static_cast<Quality>(quality)));
  EXPECT_EQ(names.size(), 12u);
  EXPECT_EQ(names.count(""), 0u);
  EXPECT_EQ(name(BuilderKind::Hubbard), "hubbard");
  EXPECT_EQ(name(Quality::Standard), "standard");
}

// A refusal names the setting, so that a caller of the library can correct it.
template <class Change>
std::string faultAfter(Change change) {
  BuildSettings settings;
  change(settings);
  try {
    validate(settings);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(BuildSettings, EverySettingOutOfRangeIsRefusedByName) {
  EXPECT_EQ(faultAfter([](BuildSettings&) {}), "");
  const double nan = std::nan(""), infinity = std::numeric_limits<double>::infinity();
  for (const int levels : {-1, 0, 1, 7})
    EXPECT_NE(faultAfter([&](BuildSettings& s) { s.levels = levels; }).find("levels is " + std::to_string(levels) + "; it must be 2 to 6"),
              std::string::npos);
  for (const int branching : {-1, 0, 1, 9})
    EXPECT_NE(faultAfter([&](BuildSettings& s) { s.branching = branching; }).find("branching"), std::string::npos) << branching;
  for (const double tolerance : {-1.0, nan, infinity})
    EXPECT_NE(faultAfter([&](BuildSettings& s) { s.tolerance_mm = tolerance; }).find("tolerance"), std::string::npos) << tolerance;
  EXPECT_NE(faultAfter([](BuildSettings& s) { s.threads = -1; }).find("threads"), std::string::npos);
  for (const int leaves : {-1, 32769})
    EXPECT_NE(faultAfter([&](BuildSettings& s) { s.max_leaves = leaves; }).find("max_leaves is " + std::to_string(leaves)),
              std::string::npos);
  EXPECT_NE(faultAfter([](BuildSettings& s) { s.max_leaves = 8, s.builder = BuilderKind::Merge; }).find("leaves"), std::string::npos);
}

TEST(BuildSettings, TolerancesOfTrianglesAreForCoverAndNotBelowTheTolerance) {
  const auto fault = [](double tolerance, double of_triangle, BuilderKind builder) {
    return faultAfter([&](BuildSettings& s) {
      s.tolerance_mm = tolerance, s.builder = builder;
      s.tolerance_of_triangle_mm = {tolerance, of_triangle};
    });
  };
  EXPECT_EQ(fault(0.1, 0.1, BuilderKind::Cover), "");
  EXPECT_EQ(fault(0.1, 5, BuilderKind::Cover), "");
  EXPECT_NE(fault(0.1, 0.09, BuilderKind::Cover), "");
  EXPECT_NE(fault(0, 0.1, BuilderKind::Cover), "") << "no tolerance to start from";
  EXPECT_NE(fault(0.1, std::numeric_limits<double>::infinity(), BuilderKind::Cover), "");
  EXPECT_NE(fault(0.1, 0.1, BuilderKind::Grid), "");
}

}  // namespace
}  // namespace spheretree::builder
