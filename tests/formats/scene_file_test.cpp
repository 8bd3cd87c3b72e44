// SPDX-License-Identifier: Apache-2.0
#include "spheretree/formats/scene_file.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "spheretree/formats/errors.h"
#include "spheretree/formats/file_io.h"
#include "support/random.h"
#include "support/scratch_folder.h"
#include "support/texts.h"

namespace spheretree::formats {
namespace {

using test::replaced;

constexpr const char* kFull = R"({"schema": "spheretree.scene/1", "unit": "cm",
 "defaults": {"builder": "cover", "levels": 4, "tolerance_mm": 0.1},
 "coupling": {"translation_n_per_mm": 2.0, "rotation_n_mm_per_rad": 900.0, "damping_n_s_per_mm": 0.001,
              "rotation_damping_n_mm_s_per_rad": 0.5, "mass_kg": 0.05, "inertia_kg_mm2": 20},
 "limits": {"force_n": 7.5, "torque_n_mm": [100, 90, 48]},
 "tool": {"name": "probe", "mesh": "probe.obj", "reference_point_mm": [1, 2, 3], "tolerance_mm": 0.05, "friction": 0.1},
 "bodies": [{"name": "jaw", "hinge": {"point_mm": [0, 60, 20], "axis": [0, 0, 2], "angle_deg": [[0, 0], [1, 20], [3.5, 0]]}},
            {"name": "mirror", "pose_csv": "mirror.csv"}],
 "objects": [
  {"name": "tooth_11", "mesh": "mouth.obj", "part": "tooth 11", "position_mm": [1, 0, -2.5], "quaternion_wxyz": [0, 1, 0, 0],
   "tolerance_mm": 0.2, "quality": "best", "repair": "off", "branching": 4, "seed": 18446744073709551615,
   "skin_mm": 0.02, "crease_angle_deg": 40, "body": "jaw", "friction": 0.2, "stiffness_n_per_mm": 3},
  {"name": "tongue", "tree": "trees/tongue.stree"},
  {"name": "cheek", "mesh": "cheek.obj",
   "soft": {"young_kpa": 30, "poisson": 0.4, "density_kg_m3": 1100, "share": 0.25, "tetrahedra": 900,
            "fixed": [{"sphere": {"centre_mm": [1, 2, 4], "radius_mm": 4}}, {"box": {"low_mm": [-1, -1, -1], "high_mm": [1, 2, 4]}},
                      {"inside": "tooth_11"}]}}],
 "work": [{"name": "pocket", "sphere": {"centre_mm": [1, 2, 3], "radius_mm": 5}, "tolerance_mm": 0.05},
          {"box": {"low_mm": [0, 0, 0], "high_mm": [1, 1, 1]}, "tolerance_mm": 0.01}],
 "reach": {"radius_mm": 0.25, "tolerance_mm": 1}})";

constexpr const char* kMinimal = R"({"schema": "spheretree.scene/1", "tool": {"name": "t", "mesh": "t.obj"},
 "objects": [{"name": "o", "tree": "o.stree"}]})";

constexpr const char* kCut = R"({"schema": "spheretree.scene/1",
 "tool": {"name": "drill", "mesh": "drill.obj",
          "burr": [{"centre_mm": [0, 0, 0.5], "radius_mm": 0.5}, {"centre_mm": [0, 0, 1.25], "radius_mm": 0.625}]},
 "objects": [{"name": "tooth_36", "mesh": "tooth.obj",
  "cut": {"layers": [{"name": "enamel", "mesh": "tooth.obj"}, {"name": "dentine", "mesh": "inner/dentine.obj"}],
          "removal_mm_per_n_s": {"enamel": 1.0, "dentine": 3.0}, "tangential": 0.25}}]})";

std::string sceneRefusal(const std::string& text) {
  return test::refusalOf<FormatError>([&] { (void)parseScene(text, "a.scene.json"); });
}

TEST(SceneFile, ReadsEveryField) {
  const SceneFile s = parseScene(kFull, "a.scene.json");
  EXPECT_EQ(s.unit, "cm");
  EXPECT_EQ(s.translation_n_per_mm, 2);
  EXPECT_EQ(s.rotation_n_mm_per_rad, 900);
  EXPECT_EQ(s.force_n, 7.5);
  EXPECT_EQ(s.torque_n_mm, Eigen::Vector3d(100, 90, 48));
  EXPECT_EQ(s.tool.name, "probe");
  EXPECT_EQ(s.tool.mesh, "probe.obj");
  EXPECT_EQ(s.tool.reference_point_mm, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(s.tool.settings.tolerance_mm, 0.05);
  ASSERT_EQ(s.objects.size(), 3u);
  ASSERT_TRUE(s.objects[2].soft);
  const SoftSettings& soft = *s.objects[2].soft;
  EXPECT_EQ(soft.young_kpa, 30);
  EXPECT_EQ(soft.poisson, 0.4);
  EXPECT_EQ(soft.density_kg_m3, 1100);
  EXPECT_EQ(soft.share, 0.25);
  EXPECT_EQ(soft.tetrahedra, 900);
  ASSERT_EQ(soft.fixed.size(), 3u);
  EXPECT_EQ(soft.fixed[0].region.radius_mm, 4);
  EXPECT_EQ(soft.fixed[1].region.high_mm, Eigen::Vector3d(1, 2, 4));
  EXPECT_EQ(soft.fixed[2].inside, "tooth_11");
  const SceneItem& tooth = s.objects[0];
  EXPECT_EQ(tooth.part, "tooth 11");
  EXPECT_EQ(tooth.pose.position, Eigen::Vector3d(1, 0, -2.5));
  EXPECT_EQ(tooth.pose.orientation.x(), 1);
  EXPECT_EQ(tooth.settings.seed, 18446744073709551615u);
  EXPECT_EQ(tooth.settings.skin_mm, 0.02);
  EXPECT_EQ(tooth.settings.crease_angle_deg, 40);
  EXPECT_EQ(tooth.body, "jaw");
  EXPECT_EQ(tooth.friction, 0.2);
  EXPECT_EQ(tooth.stiffness_n_per_mm, 3);
  EXPECT_EQ(s.tool.friction, 0.1);
  EXPECT_EQ(s.damping_n_s_per_mm, 0.001);
  EXPECT_EQ(s.rotation_damping_n_mm_s_per_rad, 0.5);
  EXPECT_EQ(s.mass_kg, 0.05);
  EXPECT_EQ(s.inertia_kg_mm2, 20);
  ASSERT_EQ(s.bodies.size(), 2u);
  ASSERT_TRUE(s.bodies[0].hinge);
  EXPECT_EQ(s.bodies[0].hinge->axis, Eigen::Vector3d(0, 0, 1));
  EXPECT_EQ(s.bodies[0].hinge->angles.at(2).t_s, 3.5);
  EXPECT_EQ(s.bodies[1].pose_csv, "mirror.csv");
  EXPECT_TRUE(s.objects[1].mesh.empty());
  EXPECT_EQ(s.objects[1].tree, "trees/tongue.stree");
  EXPECT_EQ(s.objects[1].pose.orientation.w(), 1);
  ASSERT_EQ(s.work.size(), 2u);
  EXPECT_EQ(s.work[0].radius_mm, 5);
  EXPECT_EQ(s.work[1].shape, WorkRegion::Shape::Box);
  EXPECT_EQ(s.work[1].high_mm, Eigen::Vector3d(1, 1, 1));
  ASSERT_TRUE(s.reach);
  EXPECT_EQ(s.reach->radius_mm, 0.25);

  const TreeSettings merged = mergedSettings(tooth.settings, s.defaults);
  EXPECT_EQ(merged.tolerance_mm, 0.2);
  EXPECT_EQ(merged.builder, "cover");
  EXPECT_EQ(merged.levels, 4);
  EXPECT_EQ(merged.branching, 4);
  EXPECT_EQ(mergedSettings({}, s.defaults), s.defaults);
}

TEST(SceneFile, ReadsWhatABurrCuts) {
  const SceneFile s = parseScene(kCut, "a.scene.json");
  ASSERT_EQ(s.tool.burr.size(), 2u);
  EXPECT_EQ(s.tool.burr[1].centre, Eigen::Vector3d(0, 0, 1.25));
  EXPECT_EQ(s.tool.burr[1].radius, 0.625);
  ASSERT_TRUE(s.objects[0].cut);
  const CutDescription& cut = *s.objects[0].cut;
  ASSERT_EQ(cut.layers.size(), 2u);
  EXPECT_EQ(cut.layers[0].name, "enamel");
  EXPECT_EQ(cut.layers[0].removal, 1);
  EXPECT_EQ(cut.layers[1].mesh, "inner/dentine.obj");
  EXPECT_EQ(cut.layers[1].removal, 3);
  EXPECT_EQ(cut.tangential, 0.25);
  EXPECT_TRUE(canCut(s));
  EXPECT_FALSE(canCut(parseScene(kFull, "a")));
  EXPECT_EQ(parseScene(replaced(kCut, ", \"tangential\": 0.25", ""), "a").objects[0].cut->tangential, 0.5);
}

TEST(SceneFile, RefusesABurrOrLayersThatCannotBe) {
  const std::vector<std::array<std::string, 3>> cases{
      {"\"radius_mm\": 0.625", "\"radius_mm\": 0", "tool.burr[1].radius_mm is 0, not within 0.1 .. 10"},
      {"\"radius_mm\": 0.625", "\"radius_mm\": -1", "tool.burr[1].radius_mm is -1, not within 0.1 .. 10"},
      {"\"radius_mm\": 0.625", "\"size\": 1", "tool.burr[1] has the unknown key \"size\""},
      {"{\"centre_mm\": [0, 0, 0.5], \"radius_mm\": 0.5}, {\"centre_mm\": [0, 0, 1.25], \"radius_mm\": 0.625}", "",
       "tool.burr has 0 balls, not 1 to 32"},
      {"\"enamel\": 1.0", "\"enamel\": -1.0", "objects[0].cut.removal_mm_per_n_s.enamel is -1, not above 0"},
      {"\"enamel\": 1.0", "\"enamel\": \"fast\"", "removal_mm_per_n_s.enamel is not a number"},
      {", \"dentine\": 3.0", "", "objects[0].cut.removal_mm_per_n_s has no rate for the layer \"dentine\""},
      {", \"dentine\": 3.0", ", \"dentine\": 3.0, \"pulp\": 9", "has a rate for \"pulp\", and layers has none of this name"},
      {"\"name\": \"dentine\"", "\"name\": \"enamel\"", "objects[0].cut.layers[1].name is \"enamel\", the name of another layer"},
      {"\"name\": \"dentine\"", "\"name\": \"a/b\"", "objects[0].cut.layers[1].name is \"a/b\", not safe"},
      {"\"mesh\": \"inner/dentine.obj\"", "\"mesh\": \"\"", "objects[0].cut.layers[1].mesh is empty"},
      {"\"mesh\": \"inner/dentine.obj\"", "\"part\": \"d\"", "objects[0].cut.layers[1] has the unknown key \"part\""},
      {"{\"name\": \"enamel\", \"mesh\": \"tooth.obj\"}", "{\"name\": \"enamel\", \"mesh\": \"shell.obj\"}",
       "objects[0].cut.layers[0].mesh is \"shell.obj\", not \"tooth.obj\": the first layer is the whole object"},
      {"\"tangential\": 0.25", "\"tangential\": 3", "objects[0].cut.tangential is 3, not within 0 .. 2"},
      {"\"tangential\"", "\"friction\"", "objects[0].cut has the unknown key \"friction\""},
      {"\"mesh\": \"tooth.obj\",", "\"mesh\": \"tooth.obj\", \"part\": \"a\",", "objects[0].cut is for a whole mesh"},
      {"\"mesh\": \"tooth.obj\",", "\"mesh\": \"tooth.obj\", \"stiffness_n_per_mm\": 2,", "objects[0].cut is for a rigid object"},
      {"\"mesh\": \"tooth.obj\",", "\"mesh\": \"tooth.obj\", \"skin_mm\": \"off\",", "objects[0].cut needs a skin"},
      {"\"tool\"", "\"defaults\": {\"skin_mm\": \"off\"}, \"tool\"", "objects[0].cut needs a skin"},
      {"\"mesh\": \"tooth.obj\",",
       "\"mesh\": \"tooth.obj\", \"soft\": {\"young_kpa\": 5, \"fixed\": [{\"sphere\": {\"centre_mm\": [0, 0, 0], \"radius_mm\": 1}}]},",
       "objects[0].cut is for a rigid object"}};
  for (const auto& [from, to, message] : cases) {
    const std::string said = sceneRefusal(replaced(kCut, from, to));
    EXPECT_NE(said.find(message), std::string::npos) << from << " -> " << to << ": " << said;
  }
}

TEST(SceneFile, HasTheDefaultsOfTheContract) {
  const SceneFile s = parseScene(kMinimal, "a.scene.json");
  EXPECT_EQ(s.unit, "mm");
  EXPECT_EQ(s.translation_n_per_mm, 1);
  EXPECT_EQ(s.rotation_n_mm_per_rad, 1000);
  EXPECT_EQ(s.force_n, 8);
  EXPECT_EQ(s.torque_n_mm, Eigen::Vector3d(188, 188, 48));
  EXPECT_EQ(s.defaults, TreeSettings());
  EXPECT_FALSE(s.reach);
}

TEST(SceneFile, SurvivesARoundTrip) {
  for (const char* text : {kFull, kMinimal, kCut}) {
    const std::string once = sceneText(parseScene(text, "a"));
    EXPECT_EQ(sceneText(parseScene(once, "b")), once);
  }
  EXPECT_EQ(nlohmann::json::parse(sceneText(parseScene(kCut, "a")))["objects"][0]["cut"], nlohmann::json::parse(kCut)["objects"][0]["cut"]);
  EXPECT_EQ(nlohmann::json::parse(sceneText(parseScene(kCut, "a")))["tool"]["burr"], nlohmann::json::parse(kCut)["tool"]["burr"]);
  const nlohmann::json before = nlohmann::json::parse(kFull), after = nlohmann::json::parse(sceneText(parseScene(kFull, "a")));
  for (const char* key : {"unit", "defaults", "coupling", "limits", "tool", "work", "reach"}) EXPECT_EQ(before[key], after[key]) << key;
  EXPECT_EQ(before["objects"][0], after["objects"][0]);
  EXPECT_EQ(before["objects"][2]["soft"], after["objects"][2]["soft"]);
  // Rotations of any kind, once normalised, come back bit for bit.
  test::Random random(5);
  SceneFile scene = parseScene(kFull, "a");
  for (int i = 0; i < 200; ++i) {
    scene.objects[0].pose.orientation = rotationOf(random.direction() * random.between(0, 3)).normalized();
    const std::string text = sceneText(scene);
    EXPECT_EQ(sceneText(parseScene(text, "b")), text);
  }
}

TEST(SceneFile, MakesAQuaternionAUnit) {
  const SceneFile s = parseScene(replaced(kFull, "[0, 1, 0, 0]", "[0.7071, 0.7071, 0, 0]"), "a");
  EXPECT_NEAR(s.objects[0].pose.orientation.norm(), 1, 1e-15);
  EXPECT_EQ(s.objects[0].pose.orientation.w(), s.objects[0].pose.orientation.x());
}

TEST(SceneFile, KeepsHowTheToolIsHeldAndWhereTheDeviceStands) {
  EXPECT_EQ(sceneText(parseScene(kMinimal, "a")).find("device"), std::string::npos);
  SceneFile controlled = parseScene(kMinimal, "a");
  EXPECT_FALSE(controlled.passivity_control);
  controlled.passivity_control = true;
  EXPECT_TRUE(parseScene(sceneText(controlled), "a").passivity_control);
  std::string text = kMinimal;
  text.insert(text.find("\"tool\": {") + 9, "\"position_mm\": [0, 0, -60], \"quaternion_wxyz\": [0, 0, 1, 0], ");
  text.insert(1, "\"device\": {\"position_mm\": [5, -40, 7]}, ");
  const SceneFile once = parseScene(text, "a"), again = parseScene(sceneText(once), "b");
  for (const SceneFile& s : {once, again}) {
    EXPECT_EQ(s.tool.pose.position, Eigen::Vector3d(0, 0, -60));
    EXPECT_EQ(s.tool.pose.orientation.y(), 1);
    EXPECT_EQ(s.device.position, Eigen::Vector3d(5, -40, 7));
    EXPECT_EQ(s.device.orientation.w(), 1);
  }
}

TEST(SceneFile, RefusesWithThePlaceAndWhatToDo) {
  const std::vector<std::array<std::string, 3>> cases{
      {"spheretree.scene/1", "spheretree.scene/2", "schema is not \"spheretree.scene/1\""},
      {"\"cm\"", "\"feet\"", "unit is \"feet\", not one of mm, cm, m, in"},
      {"\"builder\": \"cover\"", "\"builder\": \"covers\"", "defaults.builder is \"covers\", not one of cover, combined"},
      {"\"levels\": 4", "\"levels\": 7", "defaults.levels is not a whole number from 2 to 6"},
      {"\"levels\": 4", "\"levels\": 4.5", "defaults.levels is not a whole number"},
      {"\"levels\": 4", "\"level\": 4", "defaults has the unknown key \"level\"; the nearest known one is \"levels\""},
      {"\"coupling\"", "\"cuopling\"", "the text has the unknown key \"cuopling\"; the nearest known one is \"coupling\""},
      {"2.0", "0", "coupling.translation_n_per_mm is 0, not above 0"},
      {"2.0", "\"2\"", "coupling.translation_n_per_mm is not a number"},
      {"7.5", "-1", "limits.force_n is -1, not above 0"},
      {"[100, 90, 48]", "[100, 90]", "limits.torque_n_mm is not [x, y, z]"},
      {"[100, 90, 48]", "[100, 0, 48]", "limits.torque_n_mm[1] is 0, not above 0"},
      {"[1, 2, 3]", "[1, 2, 1e7]", "tool.reference_point_mm[2] is beyond 1000000"},
      {"\"tolerance_mm\": 0.05", "\"tolerance_mm\": 0", "tool.tolerance_mm is 0, not above 0"},
      {"\"reference_point_mm\"", "\"origin_mm\"", "tool has the unknown key \"origin_mm\""},
      {"\"tool\": {", "\"device\": {\"name\": \"d\"}, \"tool\": {", "device has the unknown key \"name\""},
      {"\"probe\"", "\"../probe\"", "tool.name is \"../probe\", not safe as a file name"},
      {"\"probe\"", "\"\"", "tool.name is \"\", not safe as a file name"},
      {"\"probe\"", "\".probe\"", "not safe as a file name"},
      {"\"tool\": {", "\"tool\": {\"reference_point\": \"tip\", ", "tool has both \"reference_point\" and \"reference_point_mm\""},
      {"\"tree\": \"trees/tongue.stree\"", "\"tree\": \"a\", \"unit\": \"m\"", "objects[1].unit is for a mesh"},
      {"\"levels\": 4", "\"levels\": 4, \"levels\": 5", "the key \"levels\" stands twice in one object"},
      {"\"radius_mm\": 0.25", "\"size\": 0.25", "reach has the unknown key \"size\"; known are radius_mm, tolerance_mm"},
      {"\"probe\"", "\"tongue\"", "objects[1].name is \"tongue\", the name of the tool; give it"},
      {"\"probe\"", "\"Tongue\"", "objects[1].name is \"tongue\", the name of the tool but for case"},
      {"\"tongue\"", "\"tooth_11\"", "objects[1].name is \"tooth_11\", the name of objects[0]"},
      {"\"mesh\": \"mouth.obj\"", "\"mesh\": \"\"", "objects[0].mesh is empty"},
      {"\"mesh\": \"mouth.obj\"", "\"tree\": \"mouth.stree\"", "objects[0].part is for a mesh"},
      {"\"tree\": \"trees/tongue.stree\"", "\"tree\": \"\", \"mesh\": \"b\"", "objects[1].tree is empty"},
      {", \"tree\": \"trees/tongue.stree\"", "", "objects[1] has neither \"mesh\" nor \"tree\""},
      {"[0, 1, 0, 0]", "[0, 1.1, 0, 0]", "objects[0].quaternion_wxyz has length 1.1, not 1"},
      {"[0, 1, 0, 0]", "[0, 0, 0, 0]", "objects[0].quaternion_wxyz has length 0, not 1"},
      {"[0, 1, 0, 0]", "[0, 1, 0]", "objects[0].quaternion_wxyz is not [w, x, y, z]"},
      {"18446744073709551615", "-1", "objects[0].seed is not a whole number"},
      {"\"radius_mm\": 5", "\"radius_mm\": -5", "work[0].sphere.radius_mm is -5, not above 0"},
      {"\"low_mm\": [0, 0, 0]", "\"low_mm\": [0, 1, 0]", "work[1].box has a low_mm that is not below its high_mm"},
      {"{\"box\": {\"low_mm\": [0,", "{\"cube\": {\"low_mm\": [0,", "work[1] has the unknown key \"cube\""},
      {"\"young_kpa\": 30", "\"young_kpa\": 0.03", "objects[2].soft is out of range: Young's modulus"},
      {"\"young_kpa\": 30, ", "", "objects[2].soft has no \"young_kpa\""},
      {"\"share\": 0.25", "\"share\": 1", "objects[2].soft.share is 1, not within 0.05 .. 0.5"},
      {"\"inside\"", "\"within\"", "objects[2].soft.fixed[2] has the unknown key \"within\""},
      {"\"inside\": \"tooth_11\"", "\"inside\": \"jaw\"", "objects[2].soft.fixed[2].inside is \"jaw\", which is the name of no object"},
      {"\"inside\": \"tooth_11\"", "\"inside\": \"cheek\"", "objects[2].soft.fixed[2].inside is \"cheek\", which is soft itself"},
      {"\"mesh\": \"cheek.obj\"", "\"tree\": \"cheek.stree\"", "objects[2].soft is for a mesh"},
      {"\"radius_mm\": 0.25, ", "", "reach has no \"radius_mm\""}};
  for (const auto& [from, to, message] : cases) {
    const std::string said = sceneRefusal(replaced(kFull, from, to));
    EXPECT_NE(said.find(message), std::string::npos) << from << " -> " << to << ": " << said;
    EXPECT_EQ(said.rfind("a.scene.json: ", 0), 0u);
  }
  EXPECT_NE(sceneRefusal("").find("is empty, not a scene"), std::string::npos);
  EXPECT_NE(sceneRefusal("[]").find("is not an object"), std::string::npos);
  EXPECT_NE(sceneRefusal(replaced(kMinimal, "[{\"name\": \"o\", \"tree\": \"o.stree\"}]", "[]")).find("has 0 objects"), std::string::npos);
}

// A cut or a changed byte gives a scene that can be written and read again, or a refusal, and nothing else.
TEST(SceneFile, ATreeMayNameTheMeshToBeShown) {
  const SceneFile scene = parseScene(replaced(kFull, "\"tree\": \"trees/tongue.stree\"",
                                              "\"tree\": \"trees/tongue.stree\", \"mesh\": \"../mouth.obj\", \"part\": \"tongue\""),
                                     "a.scene.json");
  EXPECT_EQ(scene.objects[1].tree, "trees/tongue.stree");
  EXPECT_EQ(scene.objects[1].mesh, "../mouth.obj");
  EXPECT_EQ(scene.objects[1].part, "tongue");
  const SceneFile again = parseScene(sceneText(scene), "again");
  EXPECT_EQ(again.objects[1].tree, scene.objects[1].tree);
  EXPECT_EQ(again.objects[1].mesh, scene.objects[1].mesh);
}

TEST(SceneFile, SurvivesMutation) {
  const std::string full = kFull;
  const auto tryIt = [](const std::string& text) {
    try {
      const SceneFile s = parseScene(text, "a");
      EXPECT_TRUE(isFinite(s.objects.at(0).pose));
      const std::string again = sceneText(s);
      EXPECT_EQ(sceneText(parseScene(again, "b")), again);
      return true;
    } catch (const FormatError&) {
      return false;
    }
  };
  for (std::size_t length = 0; length < full.size(); ++length) EXPECT_FALSE(tryIt(full.substr(0, length))) << length;
  test::Random random(1);
  int accepted = 0;
  for (int i = 0; i < 5000; ++i) {
    std::string text = full;
    for (std::size_t n = 1 + random.below(3); n-- > 0;) {
      const std::size_t at = random.below(text.size());
      if (random.below(3) == 0)
        text.erase(at, 1 + random.below(6));
      else
        text[at] = "0123456789-.eE\"{}[],:nul\\ \x01\xff"[random.below(26)];
    }
    accepted += tryIt(text);
  }
  EXPECT_GT(accepted, 100);  // otherwise only the JSON reader was tested
}

TEST(SceneFile, TakesPathsFromItsOwnFolder) {
  EXPECT_EQ(scenePath("a/b.scene.json", "m.obj"), "a/m.obj");
  EXPECT_EQ(scenePath("b.scene.json", "m.obj"), "m.obj");
  EXPECT_EQ(scenePath("a/b.scene.json", "../c/m.obj"), "c/m.obj");
  EXPECT_EQ(scenePath("a/b.scene.json", "/c/m.obj"), "/c/m.obj");
}

TEST(SceneFile, ReadsAFile) {
  const test::ScratchFolder folder;
  writeWhole(folder.path() / "a.scene.json", std::string_view(kFull));
  EXPECT_EQ(readScene(folder.path() / "a.scene.json").objects.size(), 3u);
  EXPECT_THROW((void)readScene(folder.path() / "b.scene.json"), FileError);
}

TEST(SceneFile, AHingeTurnsAboutItsAxis) {
  const Hinge hinge{{0, 60, 20}, {0, 0, 1}, {{0, 0}, {1, 20}, {3, -10}}};
  for (const auto& [t, degree] : {std::pair(-1.0, 0.0), {0.5, 10.0}, {1.0, 20.0}, {2.0, 5.0}, {9.0, -10.0}}) {
    const Configuration pose = hingePose(hinge, hingeAngle(hinge, t));
    EXPECT_NEAR(rotationVector(pose.orientation).z(), degree * M_PI / 180, 1e-12) << t;
    EXPECT_LT((pose.orientation * hinge.point_mm + pose.position - hinge.point_mm).norm(), 1e-12);  // the axis stays
  }
}

TEST(SceneFile, RefusesInvalidBodies) {
  EXPECT_NE(sceneRefusal(replaced(kFull, "\"body\": \"jaw\"", "\"body\": \"jow\"")).find("none of this name"), std::string::npos);
  EXPECT_NE(sceneRefusal(replaced(kFull, "[0, 0, 2]", "[0, 0, 0]")).find("axis"), std::string::npos);
  EXPECT_NE(sceneRefusal(replaced(kFull, "[3.5, 0]", "[0.5, 0]")).find("later"), std::string::npos);
  EXPECT_NE(sceneRefusal(replaced(kFull, "\"name\": \"mirror\"", "\"name\": \"jaw\"")).find("another body"), std::string::npos);
  EXPECT_NE(sceneRefusal(replaced(kFull, "\"pose_csv\": \"mirror.csv\"", "\"pose\": 1")).find("pose_csv"), std::string::npos);
  EXPECT_NE(sceneRefusal(replaced(kFull, "\"friction\": 0.2", "\"friction\": 3")).find("friction"), std::string::npos);
}

}  // namespace
}  // namespace spheretree::formats
