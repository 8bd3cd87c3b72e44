// SPDX-License-Identifier: GPL-3.0-or-later
// Trees of the same object in other representations: limits on the change of the worst leaf overhang. The short run
// takes the box with trees of 3 levels at quick quality. SPHERETREE_LONG=1: cover and merge with 4 levels at standard
// quality on the probe, tooth and box with 24 rotations (about six minutes of one core).
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <string>

#include "probe.h"
#include "spheretree/builder/sensitivity.h"
#include "spheretree/formats/mesh_file.h"
#include "support/shapes.h"

namespace spheretree {
namespace {

using builder::BuilderKind;

bool isLong() { return std::getenv("SPHERETREE_LONG") != nullptr; }

std::vector<builder::SensitivityRow> measure(const std::string& mesh_name, const TriangleMesh& mesh, BuilderKind kind) {
  builder::BuildSettings build;
  build.builder = kind;
  build.search = kind != BuilderKind::Cover;  // small changes are the claim of the search, not of the methods
  build.quality = isLong() ? builder::Quality::Standard : builder::Quality::Quick;
  build.levels = isLong() ? 4 : 3;
  builder::SensitivitySettings settings;
  if (!isLong()) settings.rotations = 6, settings.others = 2;
  builder::Progress progress;
  std::vector<builder::SensitivityRow> rows = builder::measureSensitivity(mesh, build, settings, progress);
  for (const builder::SensitivityRow& row : rows)
    std::printf("%-6s %-9s %-12s %2d cases, at most %8.4f %%%s\n", mesh_name.c_str(), std::string(name(kind)).c_str(), row.change.c_str(),
                row.cases, 100 * row.largest_change, row.same_spheres ? ", the same spheres" : "");
  return rows;
}

/// Changes of a mesh in per cent.
struct Changes {
  double rotation, noise, scale, subdivision;
};

// A figure is what this test prints. It may double: the builds are deterministic, so that only another builder moves a
// figure, and more than twice is no longer the same claim. The limit of noise on the probe is not met
// (docs/compare.md).
Changes limitsOf(const std::string& mesh_name, BuilderKind kind) {
  constexpr double kMargin = 2;
  const auto doubled = [](const Changes& c) {
    return Changes{kMargin * c.rotation, kMargin * c.noise, kMargin * c.scale, kMargin * c.subdivision};
  };
  const bool is_cover = kind == BuilderKind::Cover;
  if (mesh_name == "box" && !isLong()) return doubled(is_cover ? Changes{0.1, 5, 0.001, 4.8} : Changes{0.1, 2.9, 0.001, 2.6});
  if (mesh_name == "box") return doubled(is_cover ? Changes{0.08, 0.9, 0.001, 1.3} : Changes{0.03, 2.0, 0.001, 0.03});
  if (mesh_name == "tooth") return doubled(is_cover ? Changes{0.03, 2.2, 0.001, 1.7} : Changes{0.05, 4.7, 0.001, 2.5});
  return doubled(is_cover ? Changes{0.08, 5, 0.004, 1.1} : Changes{0.18, 5, 0.002, 4.7});
}

void expectSmallChanges(const std::string& mesh_name, const TriangleMesh& mesh) {
  for (const BuilderKind kind : {BuilderKind::Cover, BuilderKind::Merge}) {
    SCOPED_TRACE(mesh_name + ", " + std::string(name(kind)));
    const Changes limits = limitsOf(mesh_name, kind);
    const std::map<std::string, double> limit_of{
        {"rotation", limits.rotation}, {"noise", limits.noise}, {"scale 1.7", limits.scale}, {"subdivision", limits.subdivision}};
    for (const builder::SensitivityRow& row : measure(mesh_name, mesh, kind)) {
      if (row.change == "scale 2^k" || row.change.ends_with("order")) {
        EXPECT_TRUE(row.same_spheres) << row.change << ": a power of two changes no digit, an order nothing";
        EXPECT_EQ(row.largest_change, 0) << row.change;
      } else {
        EXPECT_LE(100 * row.largest_change, limit_of.at(row.change)) << row.change;
      }
    }
  }
}

TEST(Sensitivity, Box) { expectSmallChanges("box", test::boxMesh({0, 0, 0}, {3, 2, 1})); }
TEST(Sensitivity, Probe) {
  if (!isLong()) GTEST_SKIP() << "SPHERETREE_LONG=1 runs it";
  expectSmallChanges("probe", samples::makeProbe());
}
TEST(Sensitivity, Tooth) {
  const std::filesystem::path path = std::filesystem::path(SPHERETREE_SHARED_DIR) / "meshes/toolkit/tooth.obj";
  if (!isLong() || !std::filesystem::exists(path)) GTEST_SKIP() << "SPHERETREE_LONG=1 runs it, with " << path;
  expectSmallChanges("tooth", formats::readMesh(path).mesh);
}

}  // namespace
}  // namespace spheretree
