// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <string>

#include "pipeline/cut/cut_run.h"
#include "pipeline/cut/grade.h"
#include "spheretree/builder/progress.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/file_io.h"
#include "spheretree/formats/scene_file.h"
#include "support/scratch_folder.h"
#include "support/shapes.h"
#include "support/texts.h"

namespace spheretree::pipeline {
namespace {

using Eigen::Vector3d;
constexpr double kPi = std::numbers::pi;
const std::string kCutHeader = "tick,t_s,gx_mm,gy_mm,gz_mm,gqw,gqx,gqy,gqz,scene,hinges_deg,spin\n";

std::string objText(const TriangleMesh& mesh) {
  std::string text;
  for (const Vector3d& p : mesh.positions)
    text += "v " + std::to_string(p.x()) + " " + std::to_string(p.y()) + " " + std::to_string(p.z()) + "\n";
  for (const Triangle& t : mesh.triangles)
    text += "f " + std::to_string(t[0] + 1) + " " + std::to_string(t[1] + 1) + " " + std::to_string(t[2] + 1) + "\n";
  return text;
}

/// A block with a lesion, and a burr 2 mm above the reference point of its tool.
class CutRunFiles : public ::testing::Test {
 protected:
  CutRunFiles() {
    formats::writeWhole(folder_.path() / "block.obj", objText(test::boxMesh({-4, -4, -4}, {4, 4, 0})));
    formats::writeWhole(folder_.path() / "lesion.obj", objText(test::boxMesh({-1, -1, -2}, {1, 1, -1})));
    scene_.tool.name = "drill";
    scene_.tool.tree = "drill.stree";
    scene_.tool.reference_point_mm = {0, 0, 1};
    scene_.tool.burr = {{{0, 0, 3}, 0.5}};
    formats::SceneItem block;
    block.name = "block";
    block.mesh = "block.obj";
    block.pose = {{10, 20, 30}, {std::sqrt(0.5), std::sqrt(0.5), 0, 0}};  // its z is the y of the world, turned
    block.cut = formats::CutDescription{{{"sound", "block.obj", 1}, {"lesion", "lesion.obj", 2}}, 0.5};
    scene_.objects.push_back(block);
    writeScene();
  }
  void writeScene() { formats::writeWhole(folder_.path() / "a.scene.json", formats::sceneText(scene_)); }

  /// A row in which the burr is at `p` of the block's frame while nothing moves.
  std::string row(int tick, const Vector3d& p, int spin, const std::string& hinges = "") const {
    const Vector3d at = scene_.objects[0].pose.position + scene_.objects[0].pose.orientation * p - Vector3d(0, 0, 2);
    char text[256];
    std::snprintf(text, sizeof text, "%d,%.3f,%.17g,%.17g,%.17g,1,0,0,0,%s,%s,%d\n", tick, tick / 1000.0, at.x(), at.y(), at.z(),
                  tick == 0 ? "a.scene.json" : "", hinges.c_str(), spin);
    return text;
  }
  CutRun read(const std::string& text, std::uint64_t last_tick = kWholeRun) {
    formats::writeWhole(folder_.path() / "run.csv", text);
    builder::Progress progress;
    return readCutRun(folder_.path() / "run.csv", last_tick, progress);
  }
  std::string refusal(const std::string& text, std::uint64_t last_tick = kWholeRun) {
    return test::refusalOf<formats::FormatError>([&] { (void)read(text, last_tick); });
  }

  test::ScratchFolder folder_;
  formats::SceneFile scene_;
};

TEST_F(CutRunFiles, GradesAHoleThroughTheLesion) {
  std::string text = kCutHeader + row(0, {0, 0, 3}, 0) + row(1, {0, 0, 2}, 0);
  for (int n = 2; n < 52; ++n) text += row(n, {0, 0, 2 - 0.1 * (n - 1)}, 1);  // down to -3
  text += row(52, {0, 0, 2}, 0);
  const CutRun run = read(text);
  EXPECT_EQ(run.steps, 53u);
  EXPECT_EQ(run.spinning, 50u);
  ASSERT_EQ(run.objects.size(), 1u);
  ASSERT_EQ(run.objects[0].paths.size(), 1u);
  ASSERT_EQ(run.objects[0].paths[0].centres.size(), 51u);
  EXPECT_LE((run.objects[0].paths[0].centres.back() - Vector3d(0, 0, -3)).norm(), 1e-12);
  builder::Progress progress;
  const std::vector<GradedObject> graded = gradeRun(run, 0, "lesion", progress);
  const double area = kPi * 0.25, whole = area * 3 + 2 * kPi / 3 * 0.125;
  const auto holds = [](const builder::VolumeBounds& bounds, double truth) {
    return bounds.low <= truth + 1e-9 && bounds.high >= truth - 1e-9 && bounds.width() < 0.011 * std::max(1.0, truth);
  };
  ASSERT_EQ(graded.size(), 1u);
  const GradedObject& block = graded[0];
  EXPECT_TRUE(block.is_met);
  EXPECT_TRUE(holds(block.removed, whole)) << block.removed.low << " " << block.removed.high;
  EXPECT_TRUE(holds(block.layers[1].removed, area));
  EXPECT_TRUE(holds(block.layers[1].left(), 1 - area / 4));
  EXPECT_TRUE(holds(block.outsideLesion(), whole - area));
  EXPECT_LE(block.layers[0].volume.low, 252 + 1e-6);
  EXPECT_GE(block.layers[0].volume.high, 252 - 1e-6);
  EXPECT_FALSE(block.layers[0].distance);
  EXPECT_EQ(*block.layers[1].distance->high, 0);
  const auto json = gradeJson(run, graded, "run.csv");
  EXPECT_EQ(json["objects"][0]["lesion"]["layer"], "lesion");
  EXPECT_EQ(json["objects"][0]["layers"][1]["removed_mm3"]["low"], block.layers[1].removed.low);
  // The first rows alone cut nothing yet.
  EXPECT_EQ(gradeRun(read(text, 4), 0, "", progress)[0].removed.high, 0);
}

TEST_F(CutRunFiles, FollowsAnObjectThatMoves) {
  scene_.bodies.push_back({"jaw", {}, formats::Hinge{{0, 0, 0}, {0, 0, 1}, {{0, 0}}}});
  scene_.objects[0].body = "jaw";
  writeScene();
  // The jaw turns by 90 degrees while the burr stands still: it cuts from one place of the block to another.
  const CutRun run = read(kCutHeader + row(0, {0, 0, -1}, 1, "0") + row(1, {0, 0, -1}, 1, "90"));
  const std::vector<Vector3d>& centres = run.objects[0].paths.at(0).centres;
  const Configuration& pose = scene_.objects[0].pose;
  const Vector3d world = pose.position + pose.orientation * Vector3d(0, 0, -1);
  EXPECT_LE((centres[0] - Vector3d(0, 0, -1)).norm(), 1e-12);
  const Vector3d turned_back(world.y(), -world.x(), world.z());
  EXPECT_LE((centres[1] - pose.orientation.conjugate() * (turned_back - pose.position)).norm(), 1e-12);
}

TEST_F(CutRunFiles, RefusesBrokenRecordings) {
  const std::string good = kCutHeader + row(0, {0, 0, 1}, 0) + row(1, {0, 0, 0}, 1);
  EXPECT_EQ(read(good).spinning, 1u);
  EXPECT_NE(refusal("").find("empty"), std::string::npos);
  EXPECT_NE(refusal(kCutHeader).find("no step was recorded"), std::string::npos);
  EXPECT_NE(refusal(good + row(3, {0, 0, -1}, 1)).find("the row before is tick 1"), std::string::npos);
  EXPECT_NE(refusal(good + row(1, {0, 0, -1}, 1)).find("the row before is tick 1"), std::string::npos);
  EXPECT_NE(refusal(good, 7).find("ends with tick 1, before tick 7"), std::string::npos);
  EXPECT_NE(refusal(test::replaced(good, ",spin\n", ",spun\n")).find("no column spin"), std::string::npos);
  EXPECT_NE(refusal(test::replaced(good, "gqw", "qw")).find("no column gqw"), std::string::npos);
  EXPECT_NE(refusal(test::replaced(good, "a.scene.json", "")).find("names no scene file"), std::string::npos);
  EXPECT_NE(refusal(good + "2,0.002,0,0,0,2,0,0,0,,,1\n").find("not of length 1"), std::string::npos);
  EXPECT_NE(refusal(good + "2,0.002,0,nan,0,1,0,0,0,,,1\n").find("gy_mm"), std::string::npos);
  EXPECT_NE(refusal(good + "2,0.002,0,0,0,1,0,0,0,,,2\n").find("spin"), std::string::npos);
  EXPECT_THROW((void)read(test::replaced(good, "a.scene.json", "b.scene.json")), formats::FileError);
  scene_.objects[0].cut.reset();
  writeScene();
  EXPECT_NE(refusal(good).find("has no burr, or no object that can be cut"), std::string::npos);
}

}  // namespace
}  // namespace spheretree::pipeline
