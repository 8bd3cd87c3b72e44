// SPDX-License-Identifier: GPL-3.0-or-later
#include "cavity.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "geometry/winding_number.h"
#include "spheretree/builder/mesh_checks.h"
#include "spheretree/formats/scene_file.h"
#include "spheretree/formats/trajectory.h"

namespace spheretree::samples {
namespace {

TEST(Cavity, LayersAreClosedAndNested) {
  const CariousMolar molar = makeCariousMolar();
  for (const TriangleMesh* mesh : {&molar.tooth, &molar.dentine, &molar.lesion, &molar.pulp}) {
    const builder::MeshReport report = builder::checkMesh(*mesh);
    EXPECT_TRUE(report.clean()) << report.summary();
    EXPECT_EQ(report.components.size(), 1u);
  }
  const auto isWithin = [](const TriangleMesh& inner, const TriangleMesh& outer) {
    const builder::WindingNumber winding(outer);
    return std::all_of(inner.positions.begin(), inner.positions.end(), [&](const auto& p) { return winding.at(p) > 0.5; });
  };
  EXPECT_TRUE(isWithin(molar.dentine, molar.tooth));
  EXPECT_TRUE(isWithin(molar.pulp, molar.dentine));
  EXPECT_TRUE(isWithin(molar.lesion, molar.tooth));
  const builder::WindingNumber dentine(molar.dentine), pulp(molar.pulp);
  const auto in_dentine =
      std::count_if(molar.lesion.positions.begin(), molar.lesion.positions.end(), [&](const auto& p) { return dentine.at(p) > 0.5; });
  EXPECT_GT(in_dentine, 20);  // the lesion is on both sides of the border
  EXPECT_LT(in_dentine, static_cast<std::ptrdiff_t>(molar.lesion.positions.size()) - 20);
  EXPECT_TRUE(std::none_of(molar.lesion.positions.begin(), molar.lesion.positions.end(), [&](const auto& p) { return pulp.at(p) > 0.5; }));
}

TEST(Cavity, TheHandpieceEndsInItsBurr) {
  const TriangleMesh mesh = makeHandpiece();
  const builder::MeshReport report = builder::checkMesh(mesh);
  EXPECT_TRUE(report.clean()) << report.summary();
  double lowest = 0;
  for (const Eigen::Vector3d& p : mesh.positions) {
    lowest = std::min(lowest, p.z());
    if (p.z() < 0.35) {
      EXPECT_NEAR((p - kBurr.centre).norm(), kBurr.radius, 0.005);
    }
  }
  EXPECT_EQ(lowest, -kBurr.radius);
}

TEST(Cavity, ItsSceneAndPathCanBeRead) {
  const formats::SceneFile scene = formats::parseScene(cavitySceneText(), "cavity.scene.json");
  EXPECT_TRUE(formats::canCut(scene));
  EXPECT_EQ(scene.objects[0].cut->layers.size(), 4u);
  const DrillPath path = prepareCavity();
  const formats::Trajectory read = formats::parseTrajectory(drillText(path), "drill.csv");
  EXPECT_EQ(read.poses.size(), path.poses.size());
  EXPECT_EQ(read.spins, path.spins);
  EXPECT_FALSE(path.spins.front());
  EXPECT_FALSE(path.spins.back());
  EXPECT_GT(std::count(path.spins.begin(), path.spins.end(), true), 20'000);
}

}  // namespace
}  // namespace spheretree::samples
