// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/scene_draft.h"

#include <gtest/gtest.h>

#include <fstream>

#include "program_end.h"
#include "support/scratch_folder.h"

namespace spheretree::pipeline {
namespace {

constexpr const char* kTetrahedron = "f -4 -2 -3\nf -4 -3 -1\nf -4 -1 -2\nf -3 -2 -1\n";

/// A tetrahedron of this size at x.
std::string solid(double x, double size = 10) {
  const auto vertex = [](double a, double b, double c) {
    return "v " + std::to_string(a) + " " + std::to_string(b) + " " + std::to_string(c) + "\n";
  };
  return vertex(x, 0, 0) + vertex(x + size, 0, 0) + vertex(x, size, 0) + vertex(x, 0, size) + kTetrahedron;
}

class SceneDraftTest : public ::testing::Test {
 protected:
  std::filesystem::path write(const std::string& name, const std::string& text) {
    const std::filesystem::path path = scratch_.path() / name;
    std::ofstream(path) << text;
    return path;
  }
  SceneDraft draft(SceneDraftSettings settings) {
    MeshStore meshes;
    return draftScene(settings, scratch_.path() / "out.scene.json", meshes);
  }
  static std::vector<std::string> namesOf(const SceneDraft& draft) {
    std::vector<std::string> names;
    for (const formats::SceneItem& item : draft.scene.objects) names.push_back(item.name);
    return names;
  }
  test::ScratchFolder scratch_;
};

TEST_F(SceneDraftTest, NamesAreUniqueButForCaseAndSafe) {
  const auto a = write("a.obj", "g Zahn 11\n" + solid(0) + "g ../x\n" + solid(20) + "g Left\n" + solid(40));
  const auto b = write("b.obj", "g left\n" + solid(60) + "g " + std::string(100, 'n') + "\n" + solid(80));
  const auto tool = write("my probe.obj", solid(0));
  const SceneDraft drafted = draft({.files = {a, b, tool}});
  EXPECT_EQ(namesOf(drafted), (std::vector<std::string>{"Zahn_11", "_x", "a_Left", "b_left", std::string(64, 'n')}));
  EXPECT_EQ(drafted.scene.tool.name, "my_probe");
  EXPECT_EQ(drafted.scene.objects[0].part, "Zahn 11");
  EXPECT_NO_THROW(formats::parseScene(formats::sceneText(drafted.scene), "drafted"));
}

TEST_F(SceneDraftTest, ManyFilesOfOneNameGetNumbers) {
  std::filesystem::create_directory(scratch_.path() / "one");
  std::filesystem::create_directory(scratch_.path() / "two");
  const SceneDraft drafted = draft({.files = {write("one/tooth.obj", solid(0)), write("two/tooth.obj", solid(20))}});
  EXPECT_EQ(namesOf(drafted), (std::vector<std::string>{"tooth", "tooth_2"}));
  EXPECT_EQ(drafted.scene.objects[1].mesh, "two/tooth.obj");
}

TEST_F(SceneDraftTest, TrianglesWithoutAPartBecomeObjectsOfTheirComponents) {
  const auto file = write("a.obj", solid(0) + "g named\n" + solid(20));
  const SceneDraft drafted = draft({.files = {file}});
  EXPECT_EQ(namesOf(drafted), (std::vector<std::string>{"named", "a_0"}));
  EXPECT_EQ(drafted.scene.objects[1].part, "#0");
  // A triangle that is connected to a named part cannot become an object, and a note reports it.
  const auto torn = write("b.obj", solid(0) + "g named\nf 1 2 3\n" + solid(20));
  ASSERT_EQ(draft({.files = {torn}}).notes.size(), 2u);
}

TEST_F(SceneDraftTest, TheToolIsNamedRecognisedOrABall) {
  const auto many = write("many.obj", "g tooth\n" + solid(0) + "g Bur_2\n" + solid(20) + "g toolbox\n" + solid(40));
  EXPECT_EQ(draft({.files = {many}}).scene.tool.name, "Bur_2");
  EXPECT_EQ(draft({.files = {many}, .tool = "toolbox"}).scene.tool.name, "toolbox");
  const auto file = write("thing.obj", solid(0));
  const SceneDraft from_file = draft({.files = {many}, .tool = file.string()});
  EXPECT_EQ(from_file.scene.tool.name, "thing");
  EXPECT_EQ(from_file.scene.objects.size(), 3u);
  const SceneDraft ball = draft({.files = {file}});
  EXPECT_EQ(ball.scene.tool.name, "ball");
  EXPECT_EQ(ball.ball.filename(), "ball.obj");
  EXPECT_FALSE(ball.ball_mesh.empty());
  const auto both = write("both.obj", "g probe\n" + solid(0) + "g drill\n" + solid(20) + "g tooth\n" + solid(40));
  EXPECT_THROW(draft({.files = {both}}), tool::UsageError);
}

TEST_F(SceneDraftTest, ALaterMatchGoesBeforeAnEarlierOne) {
  const auto file = write("a.obj", "g tooth_1\n" + solid(0) + "g tooth_2\n" + solid(20) + "g gum\n" + solid(40));
  const SceneDraft drafted = draft({.files = {file}, .tolerance_mm = 0.5, .matches = {{"tooth_*", 0.1}, {"*_2", 0.05}}, .reach_mm = 0.2});
  EXPECT_EQ(drafted.scene.defaults.tolerance_mm, 0.5);
  EXPECT_EQ(drafted.scene.objects[0].settings.tolerance_mm, 0.1);
  EXPECT_EQ(drafted.scene.objects[1].settings.tolerance_mm, 0.05);
  EXPECT_FALSE(drafted.scene.objects[2].settings.tolerance_mm);
  EXPECT_EQ(drafted.scene.reach->tolerance_mm, 2.5);
  for (const char* bad : {"", "=1", "a", "a=", "a=0", "a=-1", "a=nan", "a=inf", "a=1x", "a=1e7"})
    EXPECT_THROW((void)parseToleranceMatch(bad), tool::UsageError) << bad;
  EXPECT_EQ(parseToleranceMatch("a=b=2").pattern, "a=b");
}

TEST_F(SceneDraftTest, SaysWhenSizesAreUnlikely) {
  const auto small = write("small.obj", solid(0, 0.02)), usual = write("usual.obj", solid(0, 30));
  EXPECT_NE(draft({.files = {small}}).notes.at(0).find("--unit m makes it 34.6 mm"), std::string::npos);
  EXPECT_EQ(draft({.files = {usual}}).notes.size(), 1u) << "only that the tool is a ball";
  EXPECT_EQ(draft({.files = {small, usual}}).notes.size(), 3u) << "and that the two differ by more than a thousand";
}

}  // namespace
}  // namespace spheretree::pipeline
