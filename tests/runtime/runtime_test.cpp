// SPDX-License-Identifier: Apache-2.0
#include "spheretree/runtime/runtime.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <string>

#include "spheretree/core/sphere_tree_codec.h"
#include "spheretree/runtime/step.h"
#include "support/c_scene.h"
#include "support/sample_skins.h"
#include "support/shape_trees.h"

namespace spheretree::runtime {
namespace {

using test::CScene;
using test::kHere;
using test::kOrigin;

void stepAsTheCppFaceDoes(ContactSurface contact) {
  SceneDescription d;
  d.contact = contact;
  d.tool = test::rodTree(20, 40, 1);
  d.reference_point = {0, 0, 10};
  d.objects.push_back(
      {test::withSkin(test::boxTree({6, 6, 2}, {8, 8, 3}, 1.5), test::boxSkin({7, 7, 3})), {{1, 2, 3}, rotationOf({0.1, 0.2, 0.3})}});
  d.coupling = {2, 3000};
  d.wrench_limits = {3, {50, 60, 70}};
  d.step_limits = {4096, 50000};
  Scene scene;
  std::string fault;
  ASSERT_TRUE(compileScene(d, scene, fault));

  CScene c;
  const std::vector<std::byte> tool = encodeSphereTree(d.tool), object = encodeSphereTree(*d.objects[0].tree);
  const double reference[3] = {0, 0, 10}, torque[3] = {50, 60, 70};
  const Quaternion q = d.objects[0].pose.orientation;
  const st_pose pose{{1, 2, 3}, {q.w(), q.x(), q.y(), q.z()}};
  ASSERT_EQ(st_scene_set_tool(c.scene, tool.data(), tool.size(), reference), 0) << st_scene_error(c.scene);
  ASSERT_EQ(st_scene_add_object(c.scene, object.data(), object.size(), &pose), 0) << st_scene_error(c.scene);
  ASSERT_EQ(st_scene_set_coupling(c.scene, 2, 3000), 0);
  ASSERT_EQ(st_scene_set_wrench_limits(c.scene, 3, torque), 0);
  ASSERT_EQ(st_scene_set_step_limits(c.scene, 4096, 50000), 0);
  if (contact == ContactSurface::Leaves) {  // the skin is the default
    ASSERT_EQ(st_scene_set_contact(c.scene, ST_LEAVES), 0);
  }
  for (const Mode mode : {Mode::Constrained, Mode::Published}) {
    st_renderer* const renderer = st_renderer_create(c.scene, static_cast<int>(mode));
    ASSERT_NE(renderer, nullptr) << st_scene_error(c.scene);
    Workspace workspace(scene);
    for (int n = 0; n < 200; ++n) {
      const Configuration haptic{{1, 2, 25 - 0.1 * n}, rotationOf({0.002 * n, 0, 0})};
      const Quaternion o = haptic.orientation;
      const st_pose in{{1, 2, 25 - 0.1 * n}, {o.w(), o.x(), o.y(), o.z()}};
      st_step out = ST_STEP_INIT;
      st_renderer_step(renderer, &in, &out);
      const StepResult r = step(scene, haptic, mode, workspace);
      for (int k = 0; k < 3; ++k) {
        ASSERT_EQ(out.graphic_tool.position_mm[k], r.graphic.position[k]);
        ASSERT_EQ(out.wrench.force_n[k], r.wrench.force[k]);
        ASSERT_EQ(out.limited_wrench.torque_n_mm[k], r.limited_wrench.torque[k]);
      }
      ASSERT_EQ(out.graphic_tool.orientation_wxyz[0], r.graphic.orientation.w());
      ASSERT_EQ(out.faults, r.faults);
      ASSERT_EQ(out.pairs, r.pairs);
      ASSERT_EQ(out.work, r.work);
    }
    st_step out = ST_STEP_INIT;
    st_renderer_reset(renderer, nullptr);
    const st_pose far_away{{500, 0, 0}, {1, 0, 0, 0}};
    st_renderer_step(renderer, &far_away, &out);
    EXPECT_EQ(out.graphic_tool.position_mm[0], 500);
    EXPECT_EQ(out.wrench.force_n[0], 0);
    st_renderer_destroy(renderer);
  }
}

TEST(Runtime, StepsAsTheCppFaceDoes) {
  stepAsTheCppFaceDoes(ContactSurface::Skin);
  stepAsTheCppFaceDoes(ContactSurface::Leaves);
}

// A ball of radius 1 over a sphere of radius 5 with a skin; the leaf reaches out by 0.2.
struct OnSphere {
  CScene c;
  st_renderer* renderer = nullptr;

  explicit OnSphere(int surface = ST_SKIN, int copies = 0) {
    const std::vector<std::byte> tool = encodeSphereTree(test::oneBallTree(1)),
                                 object = encodeSphereTree(test::withSkin(test::oneBallTree(5.2), test::roundSkin(4)));
    EXPECT_EQ(st_scene_set_tool(c.scene, tool.data(), tool.size(), kOrigin), 0) << st_scene_error(c.scene);
    EXPECT_EQ(st_scene_add_object(c.scene, object.data(), object.size(), &kHere), 0) << st_scene_error(c.scene);
    for (int i = 1; i <= copies; ++i) {
      const st_pose pose{{0, 20.0 * i, 0}, {1, 0, 0, 0}};
      EXPECT_EQ(st_scene_add_copy(c.scene, 0, &pose), 0) << st_scene_error(c.scene);
    }
    EXPECT_EQ(st_scene_set_contact(c.scene, surface), 0);
    renderer = st_renderer_create(c.scene, ST_CONSTRAINED);
    EXPECT_NE(renderer, nullptr) << st_scene_error(c.scene);
  }
  ~OnSphere() { st_renderer_destroy(renderer); }
  st_step press(double x, double y, double z, int steps = 20) {
    st_step out = ST_STEP_INIT;
    const st_pose pose{{x, y, z}, {1, 0, 0, 0}};
    for (int n = 0; n < steps; ++n) st_renderer_step(renderer, &pose, &out);
    return out;
  }
};

TEST(Runtime, RestsOnTheSkinOrOnTheLeaves) {
  OnSphere skin(ST_SKIN), leaves(ST_LEAVES);
  for (OnSphere* on : {&skin, &leaves}) {
    on->press(0, 0, 7);
    EXPECT_NEAR(on->press(0, 0, 5.5).graphic_tool.position_mm[2], on == &skin ? 6 : 6.2, 2e-3);
  }
}

TEST(Runtime, TellsTheContacts) {
  OnSphere on;
  EXPECT_EQ(st_renderer_contacts(on.renderer, nullptr, 0), 0u);
  on.press(0, 0, 7);
  EXPECT_EQ(st_renderer_contacts(on.renderer, nullptr, 0), 0u);
  const st_step out = on.press(0, 0, 5.5);
  EXPECT_EQ(st_renderer_contacts(on.renderer, nullptr, 0), 1u);  // the number of contacts, although there is space for none
  st_contact contacts[ST_MAX_CONTACTS] = {ST_CONTACT_INIT};
  ASSERT_EQ(st_renderer_contacts(on.renderer, contacts, ST_MAX_CONTACTS), 1u);
  const st_contact& c = contacts[0];
  EXPECT_EQ(c.struct_size, sizeof(st_contact));
  EXPECT_NEAR(c.point_mm[2], 5, 2e-3);
  EXPECT_NEAR(c.normal[2], 1, 1e-5);
  EXPECT_NEAR(c.force_n, out.wrench.force_n[2], 1e-3);
  EXPECT_EQ(c.object, 0u);
  EXPECT_EQ(c.on_skin, 1u);
  EXPECT_EQ(c.tool_leaf, 0u);
}

TEST(Runtime, BodiesFrictionStiffnessDampingAndMass) {
  OnSphere on;
  st_renderer_destroy(on.renderer);
  EXPECT_EQ(st_scene_set_body(on.c.scene, 0, 1), 0);
  EXPECT_EQ(st_scene_set_friction(on.c.scene, 0, 0.4), 0);
  EXPECT_EQ(st_scene_set_tool_friction(on.c.scene, 0.1), 0);
  EXPECT_EQ(st_scene_set_damping(on.c.scene, 1e-4, 0.1), 0);
  EXPECT_EQ(st_scene_set_mass(on.c.scene, 1e-4, 0.05), 0);
  EXPECT_EQ(st_scene_set_step_time(on.c.scene, 0.002), 0);
  EXPECT_EQ(st_scene_set_stiffness(on.c.scene, 0, 9), 0);
  EXPECT_EQ(st_scene_set_stiffness(on.c.scene, 1, 9), -1);
  EXPECT_NE(std::string(st_scene_error(on.c.scene)).find("no object 1"), std::string::npos);
  EXPECT_EQ(st_scene_set_body(on.c.scene, 1, 1), -1);
  EXPECT_EQ(st_scene_set_friction(on.c.scene, 1, 0.1), -1);
  on.renderer = st_renderer_create(on.c.scene, ST_CONSTRAINED);
  ASSERT_NE(on.renderer, nullptr) << st_scene_error(on.c.scene);
  on.press(0, 0, 7);
  EXPECT_NEAR(on.press(0, 0, 5).wrench.force_n[2], 0.9, 0.01);  // a spring of 9 N/mm behind one of 1 N/mm
  on.press(0, 0, 7);
  const st_pose up{{0, 0, 0.5}, {1, 0, 0, 0}};
  const st_velocity aside{{10, 0, 0}, {0, 0, 0}};
  EXPECT_EQ(st_renderer_move_body(on.renderer, 1, &up, nullptr), 0);
  EXPECT_NEAR(on.press(0, 0, 5.5).wrench.force_n[2], 0.9, 0.01);
  EXPECT_EQ(st_renderer_move_body(on.renderer, 1, &up, &aside), 0);
  st_contact contact = ST_CONTACT_INIT;
  on.press(0, 0, 5.5, 6);  // 0.1 mm sideways in five steps; the sixth has the pose
  ASSERT_EQ(st_renderer_contacts(on.renderer, &contact, 1), 1u);
  EXPECT_GT(contact.friction_n[0], 0.02);  // friction holds the tool
  EXPECT_LE(contact.friction_n[0], 0.4 * contact.force_n * 1.01);
  EXPECT_EQ(st_renderer_move_body(on.renderer, 0, &up, nullptr), -1);
  EXPECT_EQ(st_renderer_move_body(on.renderer, 2, &up, nullptr), -1);
  EXPECT_EQ(st_renderer_move_body(on.renderer, 1, nullptr, nullptr), -1);
  EXPECT_EQ(st_scene_set_friction(on.c.scene, 0, 7), 0);
  EXPECT_EQ(st_renderer_create(on.c.scene, ST_CONSTRAINED), nullptr);
  EXPECT_NE(std::string(st_scene_error(on.c.scene)).find("friction"), std::string::npos);
}

TEST(Runtime, WritesNoByteBeyondTheSizeThatTheCallerKnows) {
  OnSphere on;
  on.press(0, 0, 7);
  const st_step whole = on.press(0, 0, 5.5);
  const st_pose pose{{0, 0, 5.5}, {1, 0, 0, 0}};
  // A caller that was compiled when a struct ended at an earlier member, for each member, or that knows only its size.
  for (const std::size_t size : {sizeof(size_t), offsetof(st_step, wrench), offsetof(st_step, limited_wrench), offsetof(st_step, faults),
                                 offsetof(st_step, pairs), offsetof(st_step, work), sizeof(st_step)}) {
    st_step out;
    std::memset(&out, 0x5a, sizeof out);
    out.struct_size = size;
    st_renderer_step(on.renderer, &pose, &out);
    EXPECT_EQ(out.struct_size, size);
    const auto* const bytes = reinterpret_cast<const unsigned char*>(&out);
    for (std::size_t i = size; i < sizeof out; ++i) ASSERT_EQ(bytes[i], 0x5a) << "byte " << i << " of a struct of " << size;
    if (size >= offsetof(st_step, wrench)) {
      EXPECT_EQ(out.graphic_tool.position_mm[2], whole.graphic_tool.position_mm[2]);
    }
  }
  // A later caller, whose struct is longer.
  struct Longer {
    st_step known;
    unsigned char added[16];
  } longer;
  std::memset(&longer, 0x5a, sizeof longer);
  longer.known.struct_size = sizeof longer;
  st_renderer_step(on.renderer, &pose, &longer.known);
  EXPECT_EQ(longer.known.struct_size, sizeof longer);
  for (const unsigned char byte : longer.added) EXPECT_EQ(byte, 0x5a);
  EXPECT_EQ(longer.known.active, 1u);

  // Contacts for a caller that knows only the point.
  constexpr std::size_t kShort = offsetof(st_contact, normal);
  alignas(st_contact) unsigned char few[2 * kShort];
  std::memset(few, 0x5a, sizeof few);
  reinterpret_cast<st_contact*>(few)->struct_size = kShort;  // NOLINT: the struct of an old caller
  EXPECT_EQ(st_renderer_contacts(on.renderer, reinterpret_cast<st_contact*>(few), 1), 1u);
  double point[3];
  std::memcpy(point, few + offsetof(st_contact, point_mm), sizeof point);
  EXPECT_NEAR(point[2], 5, 2e-3);
  for (std::size_t i = kShort; i < sizeof few; ++i) ASSERT_EQ(few[i], 0x5a) << i;
}

TEST(Runtime, CopiesAreObjectsOfTheirOwn) {
  OnSphere on(ST_SKIN, 3);
  for (int i = 0; i <= 3; ++i) {
    const double y = 20 * i;
    st_renderer_reset(on.renderer, nullptr);
    on.press(0, y, 7);
    EXPECT_NEAR(on.press(0, y, 5.5).graphic_tool.position_mm[2], 6, 2e-3) << i;
    st_contact contact = ST_CONTACT_INIT;
    ASSERT_EQ(st_renderer_contacts(on.renderer, &contact, 1), 1u);
    EXPECT_EQ(contact.object, static_cast<std::uint32_t>(i));
  }
  EXPECT_EQ(st_scene_add_copy(on.c.scene, 4, &kHere), -1);
  EXPECT_NE(std::string(st_scene_error(on.c.scene)).find("no object 4"), std::string::npos) << st_scene_error(on.c.scene);
  EXPECT_EQ(st_scene_add_copy(on.c.scene, 0, nullptr), -1);
}

TEST(Runtime, MovesObjects) {
  OnSphere on(ST_SKIN, 1);
  on.press(0, 0, 9);
  const st_pose up{{0, 0, 2}, {1, 0, 0, 0}}, nowhere{{0, 0, NAN}, {1, 0, 0, 0}}, turned_by_nothing{{0, 0, 0}, {0, 0, 0, 0}};
  EXPECT_EQ(st_renderer_move_object(on.renderer, 0, &up), 0);
  EXPECT_NEAR(on.press(0, 0, 7, 60).graphic_tool.position_mm[2], 8, 2e-3);
  EXPECT_EQ(st_renderer_move_object(on.renderer, 0, &nowhere), -1);
  EXPECT_EQ(st_renderer_move_object(on.renderer, 0, &turned_by_nothing), -1);
  EXPECT_EQ(st_renderer_move_object(on.renderer, 2, &up), -1);
  EXPECT_EQ(st_renderer_move_object(on.renderer, 0, nullptr), -1);
  EXPECT_NEAR(on.press(0, 0, 7, 60).graphic_tool.position_mm[2], 8, 2e-3);
  EXPECT_EQ(st_renderer_move_object(on.renderer, 0, &kHere), 0);
  EXPECT_NEAR(on.press(0, 0, 5, 60).graphic_tool.position_mm[2], 6, 2e-3);
}

TEST(Runtime, ReportsInvalidArguments) {
  CScene c;
  const std::vector<std::byte> tree = encodeSphereTree(test::oneBallTree(1));
  const auto expectError = [&](int result, const char* part) {
    EXPECT_EQ(result, -1);
    EXPECT_NE(std::string(st_scene_error(c.scene)).find(part), std::string::npos) << st_scene_error(c.scene);
  };
  EXPECT_STREQ(st_scene_error(c.scene), "");
  EXPECT_EQ(st_renderer_create(c.scene, ST_CONSTRAINED), nullptr);
  EXPECT_NE(std::string(st_scene_error(c.scene)).find("no tool"), std::string::npos);
  for (const std::size_t size : {std::size_t{0}, std::size_t{7}, tree.size() / 2, tree.size() - 1})
    expectError(st_scene_set_tool(c.scene, tree.data(), size, kOrigin), "tool: ");
  expectError(st_scene_set_tool(c.scene, nullptr, 10, kOrigin), "tool: ");
  expectError(st_scene_add_object(c.scene, tree.data(), 5, &kHere), "object 0: ");
  expectError(st_scene_add_object(c.scene, tree.data(), tree.size(), nullptr), "object: ");
  expectError(st_scene_set_contact(c.scene, 2), "contact surface 2 is unknown");
  ASSERT_EQ(st_scene_set_tool(c.scene, tree.data(), tree.size(), kOrigin), 0);
  ASSERT_EQ(st_scene_add_object(c.scene, tree.data(), tree.size(), &kHere), 0);
  EXPECT_EQ(st_renderer_create(c.scene, 7), nullptr);
  ASSERT_EQ(st_scene_set_coupling(c.scene, -1, 1000), 0);
  EXPECT_EQ(st_renderer_create(c.scene, ST_PAPER), nullptr);
  EXPECT_NE(std::string(st_scene_error(c.scene)).find("stiffness"), std::string::npos);
  ASSERT_EQ(st_scene_set_coupling(c.scene, 1, 1000), 0);
  st_renderer* const renderer = st_renderer_create(c.scene, ST_PAPER);
  ASSERT_NE(renderer, nullptr) << st_scene_error(c.scene);
  st_renderer_destroy(renderer);
  st_renderer_destroy(nullptr);
  st_scene_destroy(nullptr);
  EXPECT_EQ(st_scene_set_coupling(nullptr, 1, 1), -1);
  EXPECT_EQ(st_renderer_create(nullptr, ST_PAPER), nullptr);
}

TEST(Runtime, ARendererOutlivesItsScene) {
  st_scene* const scene = st_scene_create();
  const std::vector<std::byte> tree = encodeSphereTree(test::oneBallTree(1));
  ASSERT_EQ(st_scene_set_tool(scene, tree.data(), tree.size(), kOrigin), 0);
  ASSERT_EQ(st_scene_add_object(scene, tree.data(), tree.size(), &kHere), 0);
  st_renderer* const renderer = st_renderer_create(scene, ST_CONSTRAINED);
  st_scene_destroy(scene);
  st_step out = ST_STEP_INIT;
  const st_pose start{{5, 0, 0}, {1, 0, 0, 0}}, inside{{1, 0, 0}, {1, 0, 0, 0}};
  st_renderer_reset(renderer, &start);
  st_renderer_step(renderer, &inside, &out);
  EXPECT_NEAR(out.graphic_tool.position_mm[0], 2, 1e-3);
  EXPECT_NEAR(out.wrench.force_n[0], 1, 1e-3);
  st_renderer_destroy(renderer);
}

}  // namespace
}  // namespace spheretree::runtime
