// SPDX-License-Identifier: Apache-2.0
// Whole scenes through the C interface of libspheretree_scene.so, against the C++ interface.
#include "spheretree/scene/scene.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "spheretree/core/sphere_tree_codec.h"
#include "spheretree/core/tissue_codec.h"
#include "spheretree/runtime/step.h"
#include "spheretree/scene/describe_scene.h"
#include "support/c_scene.h"
#include "support/count_allocations.h"
#include "support/octahedron_tissue.h"
#include "support/scratch_folder.h"

namespace spheretree::scene {
namespace {

using test::CScene;
using test::kHere;
using test::kOrigin;
using Renderer = std::unique_ptr<st_renderer, decltype(&st_renderer_destroy)>;
Renderer rendererOf(const CScene& c) {
  Renderer renderer(st_renderer_create(c.scene, ST_CONSTRAINED), &st_renderer_destroy);
  EXPECT_TRUE(renderer) << st_scene_error(c.scene);
  return renderer;
}

void writeBytes(const std::filesystem::path& path, const std::vector<std::byte>& bytes) {
  std::ofstream(path, std::ios::binary).write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}
void writeText(const std::filesystem::path& path, const std::string& text) { std::ofstream(path) << text; }

std::vector<std::byte> softBytes() {
  const test::OctahedronTissue soft = test::octahedronTissue(0.5f, 3);  // the corners at +x, -x and +y can move
  return encodeSoftTree(*soft.tree, *soft.tissue);
}

// A rod, a sphere on a hinge with friction, one that yields, one of tissue, and one on a path.
class LoadedScene : public ::testing::Test {
 protected:
  LoadedScene() {
    const std::filesystem::path& folder = folder_.path();
    writeBytes(folder / "rod.stree", encodeSphereTree(test::rodTree(20, 40, 1)));
    writeBytes(folder / "ball.stree", encodeSphereTree(test::withSkin(test::oneBallTree(5.2), test::roundSkin(3))));
    writeBytes(folder / "soft.soft", softBytes());
    writeText(folder / "lift.csv", "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz\n0,0,0,0,1,0,0,0\n0.001,0,0,0.5,1,0,0,0\n");
    writeText(folder / "scene.json", R"({"schema": "spheretree.scene/1",
      "coupling": {"translation_n_per_mm": 2, "rotation_n_mm_per_rad": 1000}, "limits": {"force_n": 3, "torque_n_mm": [50, 60, 70]},
      "tool": {"name": "rod", "tree": "rod.stree", "reference_point_mm": [0, 0, 1], "friction": 0.1},
      "bodies": [{"name": "jaw", "hinge": {"point_mm": [0, 0, 0], "axis": [1, 0, 0], "angle_deg": [[0, 0], [2, 90]]}},
                 {"name": "lift", "pose_csv": "lift.csv"}],
      "objects": [{"name": "tooth", "tree": "ball.stree", "body": "jaw", "friction": 0.4},
                  {"name": "cyst", "tree": "ball.stree", "position_mm": [30, 0, 0], "stiffness_n_per_mm": 2},
                  {"name": "tongue", "tree": "soft.soft", "position_mm": [60, 0, 0]},
                  {"name": "plate", "tree": "ball.stree", "position_mm": [90, 0, 0], "body": "lift"}]})");
  }
  std::string path(const char* name = "scene.json") const { return (folder_.path() / name).string(); }

  test::ScratchFolder folder_;
};

TEST_F(LoadedScene, StepsAsTheDescriptionOfTheFile) {
  CScene c;
  ASSERT_EQ(st_scene_load(c.scene, path().c_str()), 0) << st_scene_error(c.scene);
  const Renderer renderer = rendererOf(c);
  runtime::Scene scene;
  std::string fault;
  ASSERT_TRUE(compileScene(describeScene(formats::readScene(path()), path()), scene, fault)) << fault;
  runtime::Workspace workspace(scene);
  for (int n = 0; n < 1200; ++n) {
    const double x = 30.0 * (n / 300), z = 9 - 0.03 * (n % 300);
    if (n % 300 == 0) st_renderer_reset(renderer.get(), nullptr), reset(workspace);
    const st_pose haptic{{x, 0.3, z}, {1, 0, 0, 0}};
    st_step out = ST_STEP_INIT;
    st_renderer_step(renderer.get(), &haptic, &out);
    const runtime::StepResult r = step(scene, {{x, 0.3, z}, {1, 0, 0, 0}}, runtime::Mode::Constrained, workspace);
    for (int k = 0; k < 3; ++k) {
      ASSERT_EQ(out.graphic_tool.position_mm[k], r.graphic.position[k]) << n;
      ASSERT_EQ(out.limited_wrench.force_n[k], r.limited_wrench.force[k]) << n;
    }
    ASSERT_EQ(out.faults, r.faults);
    if (n % 300 == 299) {
      EXPECT_GT(out.limited_wrench.force_n[2], 0.5) << n;  // each is felt
    }
  }
}

TEST_F(LoadedScene, CutsAsTheDescriptionOfTheFile) {
  const auto box = [](const Eigen::Vector3d& half) {
    return encodeSphereTree(test::withSkin(test::boxTree(half, {8, 8, 4}, 1), test::boxSkin(half)));
  };
  writeBytes(folder_.path() / "burr.stree", encodeSphereTree(test::oneBallTree(0.5)));
  writeBytes(folder_.path() / "tooth.stree", box({6, 6, 3}));
  writeBytes(folder_.path() / "core.stree", box({5, 5, 2.5}));
  writeText(folder_.path() / "cut.json", R"({"schema": "spheretree.scene/1",
    "tool": {"name": "burr", "tree": "burr.stree", "burr": [{"centre_mm": [0, 0, 0], "radius_mm": 0.5}]},
    "objects": [{"name": "tooth", "tree": "tooth.stree",
                 "cut": {"layers": [{"name": "enamel", "mesh": "a.obj"}, {"name": "dentine", "mesh": "b.obj", "tree": "core.stree"}],
                         "removal_mm_per_n_s": {"enamel": 2, "dentine": 6}, "tangential": 0.3}}]})");
  CScene c;
  ASSERT_EQ(st_scene_load(c.scene, path("cut.json").c_str()), 0) << st_scene_error(c.scene);
  const Renderer renderer = rendererOf(c);
  runtime::Scene scene;
  std::string fault;
  ASSERT_TRUE(compileScene(describeScene(formats::readScene(path("cut.json")), path("cut.json")), scene, fault)) << fault;
  runtime::Workspace workspace(scene);
  EXPECT_EQ(st_renderer_cut_layer(renderer.get(), 0), -1);
  ASSERT_EQ(st_renderer_set_spindle(renderer.get(), 1), 0);
  ASSERT_TRUE(setSpindle(true, workspace));
  bool met[2] = {false, false};
  for (int n = 0; n < 1500; ++n) {
    const double z = std::max(2.0, 5 - 0.005 * n);
    const st_pose haptic{{0.1, 0.2, z}, {1, 0, 0, 0}};
    st_step out = ST_STEP_INIT;
    st_renderer_step(renderer.get(), &haptic, &out);
    const runtime::StepResult r = step(scene, {{0.1, 0.2, z}, {1, 0, 0, 0}}, runtime::Mode::Constrained, workspace);
    for (int k = 0; k < 3; ++k) ASSERT_EQ(out.graphic_tool.position_mm[k], r.graphic.position[k]) << n;
    if (const int layer = st_renderer_cut_layer(renderer.get(), 0); layer >= 0) met[layer] = true;
  }
  EXPECT_TRUE(met[0] && met[1]);
  double removed[2];
  ASSERT_EQ(st_renderer_removed(renderer.get(), 0, removed, 2), 2u);
  EXPECT_EQ(removed[0], cutState(0, workspace).removed[0]);
  EXPECT_GT(removed[0], 0.1);
  EXPECT_GT(removed[1], 0.05);
  EXPECT_EQ(st_renderer_removed(renderer.get(), 1, removed, 2), 0u);
  st_renderer_mend(renderer.get());
  st_renderer_removed(renderer.get(), 0, removed, 2);
  EXPECT_EQ(removed[0] + removed[1], 0);
  ASSERT_EQ(st_scene_load(c.scene, path().c_str()), 0);
  EXPECT_EQ(st_renderer_set_spindle(rendererOf(c).get(), 1), -1);
}

TEST_F(LoadedScene, NamesObjectsAndBodies) {
  CScene c;
  ASSERT_EQ(st_scene_load(c.scene, folder_.path().string().c_str()), 0) << st_scene_error(c.scene);  // the folder that batch writes
  ASSERT_EQ(st_scene_object_count(c.scene), 4u);
  EXPECT_STREQ(st_scene_object_name(c.scene, 2), "tongue");
  EXPECT_STREQ(st_scene_object_name(c.scene, 4), "");
  ASSERT_EQ(st_scene_body_count(c.scene), 2u);
  EXPECT_STREQ(st_scene_body_name(c.scene, 1), "jaw");
  EXPECT_STREQ(st_scene_body_name(c.scene, 0), "");
  EXPECT_STREQ(st_scene_body_name(c.scene, 3), "");
}

TEST_F(LoadedScene, HasBodiesWhereTheFileHasThem) {
  CScene c;
  ASSERT_EQ(st_scene_load(c.scene, path().c_str()), 0) << st_scene_error(c.scene);
  st_pose pose;
  ASSERT_EQ(st_scene_body_pose(c.scene, 1, 1, &pose), 0);  // half way: 45 degrees about x
  EXPECT_NEAR(pose.orientation_wxyz[1], std::sin(std::acos(-1) / 8), 1e-12);
  ASSERT_EQ(st_scene_body_pose(c.scene, 2, 5, &pose), 0);  // after the end of the file
  EXPECT_EQ(pose.position_mm[2], 0.5);
  EXPECT_EQ(st_scene_body_pose(c.scene, 0, 0, &pose), -1);
  EXPECT_EQ(st_scene_body_pose(c.scene, 3, 0, &pose), -1);

  const Renderer renderer = rendererOf(c);
  st_step out = ST_STEP_INIT;
  const st_pose haptic{{90, 0, 40}, {1, 0, 0, 0}};
  ASSERT_EQ(st_scene_body_pose(c.scene, 2, 5, &pose), 0);
  ASSERT_EQ(st_renderer_move_body(renderer.get(), 2, &pose, nullptr), 0);
  st_renderer_step(renderer.get(), &haptic, &out);
  ASSERT_EQ(st_renderer_object_pose(renderer.get(), 3, &pose), 0);
  EXPECT_EQ(pose.position_mm[0], 90);
  EXPECT_EQ(pose.position_mm[2], 0.5);
  EXPECT_EQ(st_renderer_object_pose(renderer.get(), 4, &pose), -1);
}

TEST_F(LoadedScene, GivesTheSpheresOfEveryLevel) {
  CScene c;
  ASSERT_EQ(st_scene_load(c.scene, path().c_str()), 0) << st_scene_error(c.scene);
  const SphereTree rod = test::rodTree(20, 40, 1);
  ASSERT_EQ(st_scene_level_count(c.scene, ST_TOOL), rod.levelCount());
  ASSERT_EQ(st_scene_level_count(c.scene, 0), 1);
  EXPECT_EQ(st_scene_level_count(c.scene, 4), 0);
  const st_pose lifted{{1, 2, 3}, {0, 1, 0, 0}};  // half a turn about x
  for (int level = -1; level < rod.levelCount(); ++level) {
    const std::vector<std::uint32_t> nodes = levelSet(rod, level < 0 ? rod.levelCount() - 1 : level);
    ASSERT_EQ(st_scene_spheres(c.scene, ST_TOOL, level, nullptr, nullptr, 0), nodes.size());
    std::vector<float> own(4 * nodes.size()), world(own.size() + 1, -7.0f);
    st_scene_spheres(c.scene, ST_TOOL, level, nullptr, own.data(), nodes.size());
    EXPECT_EQ(test::allocationsIn([&] { st_scene_spheres(c.scene, ST_TOOL, level, &lifted, world.data(), nodes.size()); }), 0);
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const Sphere& s = rod.cover[nodes[i]];
      ASSERT_EQ(own[4 * i + 2], s.z - 1);  // relative to the reference point
      ASSERT_EQ(own[4 * i + 3], s.radius);
      ASSERT_NEAR(world[4 * i], s.x + 1, 1e-5);
      ASSERT_NEAR(world[4 * i + 2], 3 - (s.z - 1), 1e-5);
    }
    EXPECT_EQ(world.back(), -7.0f);
  }
  float one[4];
  EXPECT_EQ(st_scene_spheres(c.scene, ST_TOOL, -1, nullptr, one, 1), 40u);  // no more than there is room for
  EXPECT_EQ(st_scene_spheres(c.scene, ST_TOOL, -2, nullptr, nullptr, 0), 0u);
  EXPECT_EQ(st_scene_spheres(c.scene, ST_TOOL, rod.levelCount(), nullptr, nullptr, 0), 0u);
  EXPECT_EQ(st_scene_spheres(c.scene, 9, 0, nullptr, nullptr, 0), 0u);
  EXPECT_EQ(st_scene_level_count(CScene().scene, ST_TOOL), 0);
}

TEST_F(LoadedScene, MeasuresDistances) {
  CScene c;
  ASSERT_EQ(st_scene_load(c.scene, path().c_str()), 0) << st_scene_error(c.scene);
  const Renderer renderer = rendererOf(c);
  st_distance d = ST_DISTANCE_INIT;
  const st_pose haptic{{30, 0, 9}, {1, 0, 0, 0}};  // the lowest leaf of the rod ends 2 mm below its reference point
  ASSERT_EQ(st_renderer_distance(renderer.get(), 1, &haptic, 100, &d), 0);
  EXPECT_NEAR(d.object_point_mm[2], 5, 0.05);
  EXPECT_NEAR(d.tool_point_mm[2], 7, 1e-4);
  EXPECT_NEAR(d.lower_mm, 2 - 0.125, 0.05);  // less the error of the sample skin
  st_step out = ST_STEP_INIT;
  st_renderer_step(renderer.get(), &haptic, &out);
  EXPECT_EQ(test::allocationsIn([&] { EXPECT_EQ(st_renderer_distance(renderer.get(), 1, &out.graphic_tool, 100, &d), 0); }), 0);
  EXPECT_EQ(st_renderer_distance(renderer.get(), 4, &haptic, 100, &d), -1);
  ASSERT_EQ(st_renderer_set_active(renderer.get(), 1, 0), 0);
  EXPECT_EQ(st_renderer_set_active(renderer.get(), 4, 0), -1);
  const st_pose inside{{30, 0, 0}, {1, 0, 0, 0}};
  st_renderer_step(renderer.get(), &inside, &out);
  EXPECT_EQ(out.graphic_tool.position_mm[2], 0);
  unsigned char small[sizeof d];
  std::memset(small, 0x5a, sizeof small);
  auto* const known = reinterpret_cast<st_distance*>(small);
  known->struct_size = offsetof(st_distance, upper_mm);
  ASSERT_EQ(st_renderer_distance(renderer.get(), 1, &haptic, 100, known), 0);
  for (std::size_t i = known->struct_size; i < sizeof small; ++i) ASSERT_EQ(small[i], 0x5a);
}

TEST_F(LoadedScene, SaysWhatIsWrongAndStaysAsItWas) {
  CScene c;
  ASSERT_EQ(st_scene_load(c.scene, path().c_str()), 0) << st_scene_error(c.scene);
  writeText(path("mesh.json"),
            R"({"schema": "spheretree.scene/1", "tool": {"name": "a", "mesh": "a.obj"}, "objects": [{"name": "b", "mesh": "b.obj"}]})");
  EXPECT_EQ(st_scene_load(c.scene, path("mesh.json").c_str()), -1);
  EXPECT_NE(std::string(st_scene_error(c.scene)).find("spheretree batch"), std::string::npos) << st_scene_error(c.scene);
  EXPECT_EQ(st_scene_load(c.scene, path("none.json").c_str()), -1);
  EXPECT_NE(std::string(st_scene_error(c.scene)).find("none.json"), std::string::npos) << st_scene_error(c.scene);
  EXPECT_EQ(st_scene_load(c.scene, nullptr), -1);
  EXPECT_EQ(st_scene_load(nullptr, path().c_str()), -1);
  EXPECT_EQ(st_scene_object_count(c.scene), 4u);
}

TEST(SceneInC, TissueGivesWayAndMovesOn) {
  CScene c;
  const std::vector<std::byte> tool = encodeSphereTree(test::oneBallTree(1)), soft = softBytes();
  ASSERT_EQ(st_scene_set_tool(c.scene, tool.data(), tool.size(), kOrigin), 0);
  ASSERT_EQ(st_scene_add_tissue(c.scene, soft.data(), soft.size(), &kHere), 0) << st_scene_error(c.scene);
  EXPECT_EQ(st_scene_add_tissue(c.scene, tool.data(), tool.size(), &kHere), -1);
  EXPECT_NE(std::string(st_scene_error(c.scene)).find(".soft"), std::string::npos) << st_scene_error(c.scene);
  EXPECT_EQ(st_scene_add_tissue(c.scene, soft.data(), soft.size() - 1, &kHere), -1);
  const Renderer renderer = rendererOf(c);
  char error[200];
  st_tissue* const tissue = st_tissue_create(renderer.get(), error, sizeof error);
  ASSERT_NE(tissue, nullptr) << error;
  EXPECT_STREQ(error, "");
  EXPECT_EQ(st_tissue_solve(tissue), 0);  // nothing was asked for
  int solved = 0;
  const auto press = [&](bool with_solver) {
    st_step out = ST_STEP_INIT;
    for (int n = 0; n < 400; ++n) {
      const st_pose haptic{{std::max(5.5, 8 - 0.02 * n), 0, 0}, {1, 0, 0, 0}};
      if (with_solver && n % 10 == 0 && st_tissue_exchange(tissue)) {
        EXPECT_EQ(st_tissue_exchange(tissue), 0);  // the last request is not answered yet
        solved += st_tissue_solve(tissue);
      }
      st_renderer_step(renderer.get(), &haptic, &out);
      EXPECT_LT(out.penetration_mm, 0.01);
    }
    return out.wrench.force_n[0];
  };
  const double small = press(false);
  EXPECT_GT(small, 0.05);
  EXPECT_LT(small, 0.45);  // a rigid ball would push back with 0.5 N
  st_renderer_reset(renderer.get(), nullptr);
  EXPECT_GT(std::abs(press(true) - small), 0.01);  // the elements of this tissue are not those of its invented compliance
  EXPECT_GT(solved, 20);
  st_renderer_reset(renderer.get(), nullptr);
  st_tissue_reset(tissue);
  EXPECT_EQ(st_tissue_solve(tissue), 0);
  EXPECT_EQ(press(false), small);
  st_tissue_destroy(tissue);
}

TEST(SceneInC, ARigidSceneHasNoTissueToSolve) {
  CScene c;
  const std::vector<std::byte> tool = encodeSphereTree(test::oneBallTree(1));
  ASSERT_EQ(st_scene_set_tool(c.scene, tool.data(), tool.size(), kOrigin), 0);
  ASSERT_EQ(st_scene_add_object(c.scene, tool.data(), tool.size(), &kHere), 0);
  const Renderer renderer = rendererOf(c);
  char error[8] = "?";
  EXPECT_EQ(st_tissue_create(renderer.get(), error, sizeof error), nullptr);
  EXPECT_STREQ(error, "");
  EXPECT_STREQ(st_scene_object_name(c.scene, 0), "");
  EXPECT_EQ(st_scene_body_count(c.scene), 0u);
}

}  // namespace
}  // namespace spheretree::scene
