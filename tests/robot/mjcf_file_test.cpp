// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include <memory>

#include "robot/cover/body_inertia.h"
#include "robot/sample_urdf.h"
#include "support/random.h"
#include "support/scratch_folder.h"
#include "support/texts.h"

namespace spheretree::robot {
namespace {

using test::armUrdf;
using test::collision;
using test::has;
using Model = std::unique_ptr<mjModel, decltype(&mj_deleteModel)>;

class MjcfFile : public testing::Test {
 protected:
  /// The MJCF of a URDF as MuJoCo compiles it.
  Model load(const std::string& urdf) {
    Robot robot = readUrdf(test::written(folder_.path() / "a.urdf", urdf));
    const builder::Progress progress;
    const RobotCover cover = test::roughCover(readShapes(robot, {}, progress));
    notes_.clear();
    const std::string text = mjcf({robot, cover, {}, {}, {}}, notes_);
    char error[1000] = "";
    Model model(mj_loadXML(test::written(folder_.path() / "a.xml", text).c_str(), nullptr, error, sizeof error), &mj_deleteModel);
    EXPECT_TRUE(model) << error << "\n" << urdf << text;
    return model;
  }
  static std::string inertial(const std::string& mass, double xx, double yy, double zz, double xy = 0, double xz = 0, double yz = 0) {
    std::string out = "<inertial><mass value=\"" + mass + "\"/><inertia";
    for (const auto& [name, value] : {std::pair("ixx", xx), {"iyy", yy}, {"izz", zz}, {"ixy", xy}, {"ixz", xz}, {"iyz", yz}}) {
      std::array<char, 40> number;
      std::snprintf(number.data(), number.size(), " %s=\"%.17g\"", name, value);
      out += number.data();
    }
    return out + "/></inertial>";
  }
  std::string notes() const {
    std::string all;
    for (const std::string& note : notes_) all += note + "\n";
    return all;
  }
  static constexpr const char* kBox = "<collision><geometry><box size=\"0.1 0.08 0.06\"/></geometry></collision>";
  test::ScratchFolder folder_;
  std::vector<std::string> notes_;
};

TEST_F(MjcfFile, AMovingLinkWithoutMassGetsAGramme) {
  for (const std::string& own : {std::string(), inertial("0", 1, 1, 1), inertial("1e-13", 1, 1, 1), std::string("<inertial/>")}) {
    const Model model = load(armUrdf(kBox + own));
    ASSERT_TRUE(model);
    EXPECT_EQ(model->body_mass[2], 0.001);
    EXPECT_GT(model->body_inertia[6], 1e-8);
    ASSERT_EQ(notes_.size(), 1u);
    EXPECT_TRUE(has(notes(), "a.urdf:3: link tool has no ")) << notes();
    // A link that nothing moves needs no mass.
    EXPECT_TRUE(load(armUrdf(kBox + own, "", "fixed")));
    EXPECT_TRUE(notes_.empty()) << notes();
  }
}

TEST_F(MjcfFile, WhatASolidBodyHasIsKept) {
  const Model model = load(armUrdf(kBox + inertial("2", 0.03, 0.04, 0.05)));
  ASSERT_TRUE(model);
  EXPECT_TRUE(notes_.empty()) << notes();
  EXPECT_EQ(model->body_mass[2], 2);
  EXPECT_NEAR(model->body_inertia[6] + model->body_inertia[7] + model->body_inertia[8], 0.12, 1e-12);
  EXPECT_TRUE(load(armUrdf(kBox + inertial("2", 0.01, 0.02, 0.03))));  // a plate: the limit of what is possible
  EXPECT_TRUE(notes_.empty()) << notes();
  EXPECT_TRUE(load(armUrdf(kBox + inertial("1e-6", 1e-12, 1e-12, 1e-12))));
  EXPECT_TRUE(notes_.empty()) << notes();
}

TEST_F(MjcfFile, ATensorThatNoSolidBodyHasIsRaisedToAPossibleOne) {
  struct Case {
    double xx, yy, zz, xy;
    Eigen::Vector3d moments;  // expected, decreasing; 0: any
  };
  for (const Case& c : {Case{0, 0, 0, 0, {0, 0, 0}}, Case{-1, -1, -1, 0, {0, 0, 0}}, Case{0, 0, 1, 0, {1, 0.5, 0.5}},
                        Case{-1, 2, 3, 0, {3, 2, 1}}, Case{1, 1, 3, 0, {3, 1.5, 1.5}}, Case{0, 1, 1, 0, {1, 1, 1e-6}},
                        Case{1, 1, 1, 5, {6, 3, 3}}, Case{1e-20, 1e-20, 1e-20, 0, {0, 0, 0}}}) {
    for (const char* kind : {"continuous", "fixed", "floating", "planar", "prismatic"}) {
      const Model model = load(armUrdf(kBox + inertial("2", c.xx, c.yy, c.zz, c.xy), "<limit upper=\"1\"/>", kind));
      ASSERT_TRUE(model);
      EXPECT_TRUE(has(notes(), "a.urdf:3: link tool has an inertia tensor that no solid body has")) << c.xx << notes();
      for (int i = 0; i < 3; ++i) {
        EXPECT_GT(model->body_inertia[6 + i], 0);
        if (c.moments[i] > 0) {
          EXPECT_NEAR(model->body_inertia[6 + i], c.moments[i], 1e-6 * c.moments[0]) << c.xx << " " << c.yy << " " << c.zz;
        }
      }
    }
  }
}

TEST_F(MjcfFile, AnyTensorLoads) {
  test::Random random(5);
  for (int trial = 0; trial < 300; ++trial) {
    const double scale = std::exp(random.between(-40, 10));
    const auto number = [&] { return random.below(4) == 0 ? 0 : scale * random.between(-1, 1); };
    const std::string mass = std::array<const char*, 6>{"0", "-1", "1e-300", "1e-9", "1", "1e9"}[random.below(6)];
    const double xx = number(), yy = number(), zz = number(), xy = number(), xz = number(), yz = number();
    ASSERT_TRUE(load(armUrdf(kBox + inertial(mass, xx, yy, zz, xy, xz, yz))));
  }
}

TEST_F(MjcfFile, NamesThatMuJoCoUsesItselfAreChanged) {
  const Model world = load(test::replaced(test::replaced(armUrdf(kBox), "link name=\"base\"", "link name=\"world\""),
                                          "parent link=\"base\"", "parent link=\"world\""));
  ASSERT_TRUE(world);
  EXPECT_STREQ(mj_id2name(world.get(), mjOBJ_BODY, 1), "world_");
  EXPECT_TRUE(has(notes(), "a.urdf:2: link world is called world_ in the MJCF")) << notes();
  // The joint k_x beside the x of the planar joint k.
  const std::string joint =
      "<joint name=\"k_x\" type=\"planar\"><parent link=\"tool\"/><child link=\"end\"/></joint><link name=\"end\"/>"
      "<joint name=\"k\" type=\"planar\"><parent link=\"tool\"/><child link=\"last\"/></joint><link name=\"last\"/></robot>";
  EXPECT_TRUE(load(test::replaced(armUrdf(kBox), "</robot>", joint)));
}

}  // namespace
}  // namespace spheretree::robot
