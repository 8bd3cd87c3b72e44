// SPDX-License-Identifier: GPL-3.0-or-later
// Trees of the `cover` builder, measured: nothing uncovered at any level, no leaf outside an ancestor, overhang within
// its proof.
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "molar.h"
#include "probe.h"
#include "spheretree/builder/build_sphere_tree.h"
#include "spheretree/builder/evaluate_tree.h"
#include "spheretree/formats/mesh_file.h"
#include "support/shapes.h"

namespace spheretree {
namespace {

void expectGoodMeasures(const TriangleMesh& mesh) {
  builder::Progress progress;
  builder::BuildSettings settings;
  settings.quality = builder::Quality::Quick;
  const builder::BuildResult built = builder::buildSphereTree(mesh, settings, progress);
  builder::EvaluateSettings what;
  what.limits = false;
  const builder::Evaluation evaluation = builder::evaluateTree(mesh, built.tree, what, progress);
  ASSERT_EQ(evaluation.levels.size(), 4u);
  for (const builder::LevelEvaluation& level : evaluation.levels) {
    SCOPED_TRACE("level " + std::to_string(level.level));
    EXPECT_EQ(level.coverage.uncovered_fraction, 0);
    EXPECT_LE(level.coverage.max_gap, 1e-5 * evaluation.diagonal);
    EXPECT_GE(level.overhang.bound, level.overhang.max);
    // The bound of the tree was proven in another way, from the centres.
    EXPECT_GE(static_cast<double>(built.tree.statistics[static_cast<std::size_t>(level.level)].overhang_bound), level.overhang.max);
  }
  EXPECT_LE(evaluation.hierarchy.leaves, 512u);
  EXPECT_EQ(evaluation.hierarchy.leaves_outside_ancestor, 0u);
}

/// The mesh of the collection or, if it is missing, one of ours of the same kind.
void expectGoodMeasuresOf(const std::string& name, const TriangleMesh& ours) {
  const std::filesystem::path path = std::filesystem::path(SPHERETREE_SHARED_DIR) / "meshes/bench" / name;
  expectGoodMeasures(std::filesystem::exists(path) ? formats::readMesh(path).mesh : ours);
}

TriangleMesh finerBox(const Eigen::Vector3d& size) { return test::quartered(test::quartered(test::boxMesh({0, 0, 0}, size))); }

TEST(CoverMeasures, Molar) { expectGoodMeasures(samples::makeMolar()); }
TEST(CoverMeasures, Probe) { expectGoodMeasures(samples::makeProbe()); }
TEST(CoverMeasures, ThinPlate) { expectGoodMeasuresOf("cad_thin_plate.obj", finerBox({100, 80, 2})); }
TEST(CoverMeasures, Cylinder) { expectGoodMeasuresOf("elongated_cylinder.stl", finerBox({2, 2, 20})); }
TEST(CoverMeasures, Spot) { expectGoodMeasuresOf("organic_spot.obj", test::torusMesh(20, 7, 40, 18)); }
TEST(CoverMeasures, Bottle) { expectGoodMeasuresOf("elongated_bottle.ply", test::sphereMesh(10, 3)); }

}  // namespace
}  // namespace spheretree
