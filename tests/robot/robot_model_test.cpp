// SPDX-License-Identifier: GPL-3.0-or-later
#include "robot/model/robot_model.h"

#include <gtest/gtest.h>

#include "robot/sample_urdf.h"
#include "spheretree/formats/errors.h"
#include "support/scratch_folder.h"
#include "support/texts.h"

namespace spheretree::robot {
namespace {

using test::armUrdf;
using test::has;

class RobotModel : public testing::Test {
 protected:
  Robot read(const std::string& text) { return readUrdf(test::written(folder_.path() / "a.urdf", text)); }
  std::string refusal(const std::string& text) {
    return test::refusalOf<formats::FormatError>([&] { (void)read(text); });
  }
  test::ScratchFolder folder_;
};

TEST_F(RobotModel, AJointIsReadOnlyForWhatItsTypeHas) {
  const std::string broken =
      "<axis xyz=\"0 0 0\"/><limit lower=\"x\" upper=\"nan\"/><mimic joint=\"none\" multiplier=\"y\"/><safety_controller k_velocity=\"\"/>";
  for (const char* kind : {"fixed", "floating"}) {
    const Robot robot = read(armUrdf("", broken, kind));
    EXPECT_TRUE(robot.notes.empty()) << kind;
    EXPECT_FALSE(robot.joints[0].mimic);
  }
  EXPECT_TRUE(has(refusal(armUrdf("", broken, "continuous")), "a.urdf:4: <axis> of joint j (link tool): "));
  EXPECT_TRUE(has(refusal(armUrdf("", "<axis xyz=\"0 0 0\"/>", "planar")), "needs a direction"));
  EXPECT_TRUE(has(refusal(armUrdf("", "", "revolute")), "a.urdf:4: joint j (link tool): a joint of this type needs a <limit>."));
  EXPECT_TRUE(has(refusal(armUrdf("", "<limit lower=\"x\"/>", "revolute")), "a.urdf:4: <limit> of joint j (link tool): lower=\"x\""));
  EXPECT_NO_THROW(read(armUrdf("", "<limit lower=\"x\"/>", "continuous")));
  EXPECT_NO_THROW(read(armUrdf("", "<limit lower=\"x\"/><mimic/>", "planar")));
}

// The tool is 1 m above the base, turned by a right angle about x. The finger is 0.2 m along the tool's y axis, which
// is then z, and shifted by 0.05 m along x by the offset of its mimic.
TEST_F(RobotModel, AtZeroEveryLinkIsWhereItsJointsPutIt) {
  const Robot robot = read(
      "<robot name=\"r\"><link name=\"finger\"/><link name=\"base\"/><link name=\"tool\"/>"
      "<joint name=\"a\" type=\"revolute\"><parent link=\"base\"/><child link=\"tool\"/><origin xyz=\"0 0 1\" rpy=\"1.5707963267948966 0 "
      "0\"/>"
      "<axis xyz=\"0 0 1\"/><limit lower=\"1\" upper=\"2\"/></joint>"
      "<joint name=\"lead\" type=\"prismatic\"><parent link=\"base\"/><child link=\"other\"/><limit lower=\"0\" upper=\"1\"/></joint>"
      "<link name=\"other\"/>"
      "<joint name=\"b\" type=\"prismatic\"><parent link=\"tool\"/><child link=\"finger\"/><origin xyz=\"0 0.2 0\"/><axis xyz=\"1 0 0\"/>"
      "<limit lower=\"0\" upper=\"1\"/><mimic joint=\"lead\" offset=\"0.05\"/></joint></robot>");
  const std::vector<Eigen::Isometry3d> pose = zeroPose(robot);
  ASSERT_EQ(pose.size(), 4u);
  EXPECT_TRUE(pose[1].isApprox(Eigen::Isometry3d::Identity()));
  EXPECT_LT((pose[2].translation() - Eigen::Vector3d(0, 0, 1000)).norm(), 1e-9);
  EXPECT_LT((pose[0].translation() - Eigen::Vector3d(50, 0, 1200)).norm(), 1e-9);
  EXPECT_LT((pose[0].linear() * Eigen::Vector3d::UnitY() - Eigen::Vector3d::UnitZ()).norm(), 1e-9);
}

TEST_F(RobotModel, MessagesNameFileLineLinkAndShape) {
  EXPECT_TRUE(
      has(refusal(armUrdf(test::collision("<sphere radius=\"-1\"/>"))), "a.urdf:3: <sphere> of link tool: radius must not be negative."));
  EXPECT_TRUE(has(refusal(armUrdf(test::collision("<cone/>"))), "a.urdf:3: <cone> of link tool: is not a supported shape"));
  EXPECT_TRUE(has(refusal(armUrdf(test::collision("<box size=\"${w} 1 1\"/>"))), "xacro"));
  EXPECT_TRUE(has(refusal("<robot name=\"r\">\n<link name=\"a\"/>\n<link name=\"b\"/>\n</robot>"),
                  "a.urdf:3: link b: neither this link nor the link a"));
  EXPECT_TRUE(has(refusal(test::replaced(armUrdf(""), "</robot>",
                                         "<joint name=\"k\" type=\"fixed\"><parent link=\"base\"/><child link=\"tool\"/></joint></robot>")),
                  "a.urdf:5: joint k (link tool): the link tool already hangs on the joint j."));
  EXPECT_TRUE(has(refusal(test::replaced(armUrdf(""), "link=\"base\"/>", "link=\"tool\"/>")), "run in a circle"));
}

TEST_F(RobotModel, WhatIsNoXmlIsSaidInPlainWords) {
  EXPECT_TRUE(has(refusal("solid box\nfacet normal 0 0 0\n"), "is not a URDF, which is XML"));
  EXPECT_TRUE(has(refusal(""), "the file is empty"));
  EXPECT_TRUE(
      has(refusal("<robot name=\"r\">\n<link name=\"a\">\n</robot>"), "a.urdf:2: is not well-formed XML: an element is not closed"));
  EXPECT_TRUE(has(refusal("<robot name=r/>"), "an attribute is not written as name=\"value\""));
  for (const char* text : {"<", "<!--", "<robot", "<?xml?>", "<robot><![CDATA[", "\xff\xfe<"}) {
    const std::string message = refusal(text);
    EXPECT_FALSE(message.empty()) << text;
    EXPECT_FALSE(has(message, "XML_ERROR")) << message;
  }
}

TEST_F(RobotModel, UnusualLimitsAreNoted) {
  const Robot swapped = read(armUrdf("", "<limit lower=\"2\" upper=\"-1\"/>", "prismatic"));
  EXPECT_EQ(swapped.joints[0].lower, -1000);
  EXPECT_EQ(swapped.joints[0].upper, 2000);
  ASSERT_EQ(swapped.notes.size(), 1u);
  EXPECT_TRUE(has(swapped.notes[0], "a.urdf:4: <limit> of joint j (link tool): lower is above upper"));
  EXPECT_TRUE(has(read(armUrdf("", "<limit/>", "revolute")).notes.at(0), "does not move"));
  EXPECT_TRUE(read(armUrdf("", "<limit lower=\"-1\" upper=\"+1\"/>", "revolute")).notes.empty());
}

/// Three links in a row; `second` and `third` are the contents of the joints j1 and j2.
std::string chainUrdf(const std::string& second, const std::string& third) {
  return "<robot name=\"r\"><link name=\"a\"/><link name=\"b\"/><link name=\"c\"/><link name=\"d\"/>"
         "<joint name=\"j0\" type=\"continuous\"><parent link=\"a\"/><child link=\"b\"/></joint>"
         "<joint name=\"j1\" type=\"prismatic\"><parent link=\"b\"/><child link=\"c\"/><limit upper=\"1\"/>" +
         second +
         "</joint>"
         "<joint name=\"j2\" type=\"continuous\"><parent link=\"c\"/><child link=\"d\"/>" +
         third + "</joint></robot>";
}

TEST_F(RobotModel, MimicsOfMimicsFollowTheLastJoint) {
  const Robot robot =
      read(chainUrdf("<mimic joint=\"j0\" multiplier=\"2\" offset=\"0.5\"/>", "<mimic joint=\"j1\" multiplier=\"3\" offset=\"0.25\"/>"));
  EXPECT_TRUE(robot.notes.empty());
  ASSERT_TRUE(robot.joints[1].mimic && robot.joints[2].mimic);
  EXPECT_EQ(robot.joints[1].mimic->joint, 0u);
  EXPECT_EQ(robot.joints[1].mimic->factor, 2000);  // [mm/rad]
  EXPECT_EQ(robot.joints[1].mimic->offset, 500);
  EXPECT_EQ(robot.joints[2].mimic->joint, 0u);
  EXPECT_EQ(robot.joints[2].mimic->factor, 6);
  EXPECT_EQ(robot.joints[2].mimic->offset, 1.75);
}

TEST_F(RobotModel, AMimicOfNothingIsAnIndependentJoint) {
  for (const auto& [second, third] : {std::pair("<mimic joint=\"none\"/>", ""), std::pair("<mimic joint=\"j1\"/>", ""),
                                      std::pair("<mimic joint=\"j2\"/>", "<mimic joint=\"j1\"/>")}) {
    const Robot robot = read(chainUrdf(second, third));
    EXPECT_FALSE(robot.joints[1].mimic);
    ASSERT_FALSE(robot.notes.empty());
    EXPECT_TRUE(has(robot.notes[0], "<mimic> of joint j1 (link c)")) << robot.notes[0];
  }
}

TEST_F(RobotModel, ARobotWithoutANameHasThatOfItsFile) {
  EXPECT_EQ(read("<robot><link name=\"a\"/></robot>").name, "a");
  EXPECT_EQ(read("<robot name=\"\"><link name=\"a\"/></robot>").notes.size(), 1u);
}

TEST_F(RobotModel, NumbersAsPeopleWriteThem) {
  const Robot robot = read(armUrdf(test::collision("<box size=\" +1 .5\t1e-400 \"/>")));
  EXPECT_EQ(std::get<Box>(robot.links[1].collisions[0].shape).size, Eigen::Vector3d(1000, 500, 0));
  for (const char* wrong : {"1 1", "1 1 1 1", "1,1,1", "1 1 nan", "1 1 inf", "1 1 1e400", "1 1 +-1", "1 1 0x1", "1 1 1f", "", " "})
    EXPECT_FALSE(refusal(armUrdf(test::collision(std::string("<box size=\"") + wrong + "\"/>"))).empty()) << wrong;
}

}  // namespace
}  // namespace spheretree::robot
