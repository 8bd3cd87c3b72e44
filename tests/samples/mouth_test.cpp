// SPDX-License-Identifier: GPL-3.0-or-later
#include "mouth.h"

#include <gtest/gtest.h>

#include "geometry/distance_field.h"
#include "mouth_files.h"
#include "probe.h"
#include "spheretree/builder/mesh_checks.h"
#include "spheretree/formats/file_io.h"
#include "spheretree/formats/mesh_file.h"
#include "spheretree/formats/scene_file.h"
#include "spheretree/formats/trajectory.h"
#include "support/scratch_folder.h"

namespace spheretree::samples {
namespace {

const Mouth& mouth() {
  static const Mouth made = makeMouth();
  return made;
}

TEST(Mouth, HasPartsOfTheRightSizeThatABuildTakes) {
  const std::vector<Mouth::Part> parts = mouth().parts();
  ASSERT_EQ(parts.size(), 32u);
  for (const Mouth::Part& part : parts) {
    const builder::MeshReport report = builder::checkMesh(*part.mesh);
    EXPECT_TRUE(report.clean()) << part.name << ": " << report.summary();
    EXPECT_EQ(report.components.size(), 1u) << part.name;
    EXPECT_GT(report.volume, 0) << part.name;
    const std::size_t wanted = part.name == "face"                       ? kFaceTriangles
                               : part.name == "tongue"                   ? kTongueTriangles
                               : part.name.find("jaw") != part.name.npos ? kJawTriangles
                                                                         : kToothTriangles;
    EXPECT_EQ(report.triangles, wanted) << part.name;
  }
}

TEST(Mouth, HasFormsThatDiffer) {
  // An incisor has a thin edge; a canine ends in one point; a premolar has two cusps, a molar more: the highest points,
  // at least 2 mm apart.
  const auto peaks = [](const MouthTooth& tooth) {
    int count = 0;
    for (int i = -12; i <= 12; ++i) {
      for (int k = -12; k <= 12; ++k) {
        const double x = 0.4 * i, y = 0.4 * k, here = crownHeight(tooth, x, y);
        bool highest = here > 3;
        for (int di = -2; di <= 2; ++di)
          for (int dk = -2; dk <= 2; ++dk) highest = highest && crownHeight(tooth, x + 0.4 * di, y + 0.4 * dk) <= here;
        count += highest;
      }
    }
    return count;
  };
  EXPECT_EQ(peaks(mouth().teeth[2]), 1);   // 13
  EXPECT_EQ(peaks(mouth().teeth[3]), 2);   // 14
  EXPECT_EQ(peaks(mouth().teeth[26]), 5);  // 46
  const MouthTooth& incisor = mouth().teeth[0];
  EXPECT_GT(crownHeight(incisor, 3, 0.5), 8);
  EXPECT_LT(crownHeight(incisor, 0, 2.5), 8);
  EXPECT_EQ(crownHeight(incisor, 0, 6), 0);  // beside it
}

// The probe's tip, 0.1 mm in radius, has free space in the sulcus of every tooth, on the cheek's and the tongue's side.
TEST(Mouth, HasASulcusThatTheTipEnters) {
  const builder::DistanceField upper(mouth().upper_jaw), lower(mouth().lower_jaw);
  for (std::size_t i = 0; i < mouth().teeth.size(); ++i) {
    const MouthTooth& tooth = mouth().teeth[i];
    const builder::DistanceField field(tooth.mesh);
    for (const double side : {1.0, -1.0}) {
      const Eigen::Vector3d tip = sulcusFloor(tooth, {0, side}) + 0.15 * tooth.occlusal;
      EXPECT_GT(field.signedDistance(tip), 0.12) << tooth.name;
      EXPECT_GT((i < 14 ? upper : lower).signedDistance(tip), 0.12) << tooth.name;
      // The sulcus is 2 mm deep, with gum beside it.
      const Eigen::Vector3d beside = tip + side * 0.9 * tooth.buccal;
      EXPECT_LT((i < 14 ? upper : lower).signedDistance(beside), 0) << tooth.name;
    }
  }
}

TEST(Mouth, IsTheSameInEveryFile) {
  const test::ScratchFolder folder;
  formats::writeWhole(folder.path() / "mouth.obj", objText(mouth().parts(), "Open mouth"));
  formats::writeWhole(folder.path() / "mouth.glb", glbBytes(mouth().parts()));
  const TriangleMesh obj = formats::readMesh(folder.path() / "mouth.obj").mesh, glb = formats::readMesh(folder.path() / "mouth.glb").mesh;
  EXPECT_EQ(obj.part_names, glb.part_names);
  for (const Mouth::Part& part : mouth().parts()) {
    const TriangleMesh from_obj = formats::selectPart(obj, part.name), from_glb = formats::selectPart(glb, part.name);
    ASSERT_EQ(from_obj.triangles.size(), part.mesh->triangles.size());
    ASSERT_EQ(from_glb.triangles.size(), part.mesh->triangles.size());
    for (std::size_t t = 0; t < part.mesh->triangles.size(); t += 97) {
      EXPECT_LT((from_obj.corner(t, 1) - part.mesh->corner(t, 1)).norm(), 2e-5);
      EXPECT_LT((from_glb.corner(t, 1) - part.mesh->corner(t, 1)).norm(), 2e-5);
    }
  }
  const formats::SceneFile scene = formats::parseScene(mouthSceneText(mouth()), "mouth.scene.json");
  EXPECT_EQ(scene.objects.size(), 32u);
  EXPECT_EQ(scene.objects[31].part, "face");
  int lower = 0;
  for (const formats::SceneItem& object : scene.objects) lower += object.body == "mandible";
  EXPECT_EQ(lower, 16);
  ASSERT_TRUE(scene.bodies.at(0).hinge);
  EXPECT_EQ(formats::hingeAngle(*scene.bodies[0].hinge, 2.5), 0);  // it rests
  // While it opens, the lower incisors move down and back.
  const formats::SceneFile opening = formats::parseScene(mouthSceneText(mouth(), MouthMotion::Opening), "opening.scene.json");
  const Configuration open = formats::hingePose(*opening.bodies.at(0).hinge, formats::hingeAngle(*opening.bodies[0].hinge, 2.5));
  const Eigen::Vector3d incisor = mouth().teeth[14].centre, way = open.orientation * incisor + open.position - incisor;
  EXPECT_LT(way.z(), -5);
  const formats::SceneFile hands = formats::parseScene(mouthSceneText(mouth(), MouthMotion::TwoHands), "two_hands.scene.json");
  EXPECT_EQ(hands.objects.back().body, "second_hand");
  const formats::SceneFile tissue = formats::parseScene(mouthSceneText(mouth(), MouthMotion::Soft), "soft.scene.json");
  int soft = 0;
  for (const formats::SceneItem& object : tissue.objects) soft += object.soft.has_value();
  EXPECT_EQ(soft, 4);
}

TEST(Mouth, HasPathsThatTouchTheirParts) {
  const Path pocket = probePocket(mouth()), inspection = inspectTeeth(mouth()), press = pressTongue();
  EXPECT_EQ(formats::parseTrajectory(trajectoryText(pocket), "pocket.csv").poses.size(), pocket.size());
  EXPECT_EQ(formats::parseTrajectory(trajectoryText(inspection), "inspection.csv").poses.size(), inspection.size());
  for (const Path& path : {pocket, inspection, press})
    for (std::size_t i = 1; i < path.size(); ++i) {
      const Displacement step = displacementBetween(path[i - 1], path[i]);
      EXPECT_LT(step.translation.norm(), 0.07);  // 60 mm/s
      EXPECT_LT(step.rotation.norm(), 0.01);
    }
  // The tip presses on the floor of the sulcus of tooth 46 nine times, beside the tooth and not into it.
  const builder::DistanceField gum(mouth().lower_jaw), tooth(mouth().teeth[26].mesh);
  int visits = 0;
  double nearest = 1;
  bool inside = false;
  for (const Configuration& pose : pocket) {
    const bool now = gum.signedDistance(pose.position) < -0.15;
    visits += now && !inside;
    inside = now;
    nearest = std::min(nearest, tooth.signedDistance(pose.position));
  }
  EXPECT_EQ(visits, 9);
  EXPECT_GT(nearest, -0.05);
  // The tip is inside every tooth at some time, at most 0.4 mm deep, its intended depth, for the height that it
  // crosses.
  for (const MouthTooth& touched : mouth().teeth) {
    const builder::DistanceField field(touched.mesh);
    double deepest = 0;
    for (std::size_t i = 0; i < inspection.size(); i += 5)
      if ((inspection[i].position - touched.centre).norm() < 14) deepest = std::min(deepest, field.signedDistance(inspection[i].position));
    EXPECT_LT(deepest, -0.15) << touched.name;
    for (const Eigen::Vector3d& p : makeProbe().positions)  // a path that begins inside a tooth is no evidence
      ASSERT_GT(field.signedDistance(inspection[0].orientation * p + inspection[0].position), 1) << touched.name;
    EXPECT_GT(deepest, -1.5) << touched.name;
  }
}

}  // namespace
}  // namespace spheretree::samples
