// SPDX-License-Identifier: GPL-3.0-or-later
#include "robot/model/robot_shapes.h"

#include <gtest/gtest.h>

#include "program_end.h"
#include "robot/sample_urdf.h"
#include "spheretree/formats/errors.h"
#include "support/scratch_folder.h"
#include "support/texts.h"

namespace spheretree::robot {
namespace {

using test::armUrdf;
using test::collision;
using test::has;

class RobotShapes : public testing::Test {
 protected:
  RobotShapes() {
    test::written(folder_.path() / "box.stl", test::boxStl(0.1));
    test::written(folder_.path() / "box_mm.stl", test::boxStl(100));
    test::written(folder_.path() / "empty.stl", std::string(84, '\0'));
    test::written(folder_.path() / "empty.obj", "v 0 0 0\n");
    test::written(folder_.path() / "empty.dae",
                  "<?xml version=\"1.0\"?><COLLADA xmlns=\"http://www.collada.org/2005/11/COLLADASchema\" version=\"1.4.1\"><asset/>"
                  "<library_visual_scenes><visual_scene id=\"s\"><node id=\"n\"/></visual_scene></library_visual_scenes>"
                  "<scene><instance_visual_scene url=\"#s\"/></scene></COLLADA>");
  }
  std::vector<ShapedElement> read(const std::string& text, const std::vector<std::string>& unit_words = {},
                                  ShapeSource source = ShapeSource::Collision) {
    std::vector<LinkUnit> units;
    for (const std::string& word : unit_words) units.push_back(linkUnit(word).value());
    robot_ = readUrdf(test::written(folder_.path() / "a.urdf", text), {}, source);
    const builder::Progress progress;
    return readShapes(robot_, units, progress);
  }
  /// All notes, a line each.
  std::string notes() const {
    std::string all;
    for (const std::string& note : robot_.notes) all += note + "\n";
    return all;
  }
  test::ScratchFolder folder_;
  Robot robot_;
};

TEST_F(RobotShapes, PlaceholdersAreLeftOutWithANote) {
  for (const char* shape :
       {"<box size=\"0 0 0\"/>", "<box size=\"0 1 0\"/>", "<sphere radius=\"0\"/>", "<cylinder radius=\"0\" length=\"0\"/>",
        "<cylinder radius=\"0\" length=\"1\"/>", "<capsule radius=\"0\" length=\"1\"/>", "<mesh filename=\"\"/>",
        "<mesh filename=\"empty.stl\"/>", "<mesh filename=\"empty.obj\"/>", "<mesh filename=\"empty.dae\"/>",
        "<mesh filename=\"box.stl\" scale=\"0 0 0\"/>", "<mesh filename=\"box.stl\" scale=\"0 1 0\"/>", ""}) {
    EXPECT_EQ(read(armUrdf("\n" + collision(shape))).size(), 1u) << shape;
    EXPECT_TRUE(robot_.links[1].collisions.empty());
    EXPECT_TRUE(has(notes(), "a.urdf:4: ") && has(notes(), "> of link tool: ") && has(notes(), "It is left out.")) << shape << notes();
    EXPECT_TRUE(has(notes(), "a.urdf:3: link tool is left without any shape")) << shape << notes();
    const auto elements = read(armUrdf(collision(shape) + collision("<box size=\"1 1 1\"/>")));
    EXPECT_EQ(elements.size(), 2u) << shape;
    EXPECT_EQ(robot_.links[1].collisions.size(), 1u);
    EXPECT_FALSE(has(notes(), "without any shape")) << notes();
  }
  EXPECT_EQ(read(armUrdf("<collision/>")).size(), 1u);
  EXPECT_TRUE(has(notes(), "<collision> of link tool: names no shape")) << notes();
}

TEST_F(RobotShapes, AMeshThatIsRefusedIsNamedWithItsLink) {
  test::written(folder_.path() / "bad.obj", "f 1 2 3\n");
  const std::string message =
      test::refusalOf<formats::FormatError>([&] { (void)read(armUrdf("\n" + collision("<mesh filename=\"bad.obj\"/>"))); });
  EXPECT_TRUE(has(message, "a.urdf:4: <mesh> of link tool: ") && has(message, "bad.obj: line 1")) << message;
}

TEST_F(RobotShapes, WithoutAShapeTheWayOutIsSaid) {
  const std::string visual = "<visual><geometry><sphere radius=\"0.02\"/></geometry></visual>";
  const std::string text = "<robot name=\"r\"><link name=\"a\">" + visual + "</link></robot>";
  EXPECT_TRUE(has(test::refusalOf<formats::FormatError>([&] { (void)read(text); }), "--visual takes the shapes of <visual>"));
  EXPECT_EQ(read(text, {}, ShapeSource::Visual).at(0).shape.capsule->radius, 20);
  const std::string neither = "<robot name=\"r\"><link name=\"a\"/></robot>";
  const std::string message = test::refusalOf<formats::FormatError>([&] { (void)read(neither); });
  EXPECT_TRUE(has(message, "nothing to cover") && !has(message, "--visual")) << message;
  // --visual takes these shapes and no others.
  EXPECT_EQ(read(armUrdf(visual), {}, ShapeSource::Visual).size(), 1u);
  EXPECT_TRUE(has(test::refusalOf<formats::FormatError>([&] { (void)read(armUrdf(""), {}, ShapeSource::Visual); }), "Without --visual"));
}

TEST_F(RobotShapes, SizesOfAnotherUnitAreDoubtedWithTheOptionThatMendsThem) {
  const std::string text = armUrdf(collision("<mesh filename=\"box_mm.stl\"/>"));
  (void)read(text);
  EXPECT_TRUE(has(notes(), "a.urdf:3: link tool has a size of 173 m, beside links of at most 0.141 m; ")) << notes();
  EXPECT_TRUE(has(notes(), "--unit tool=mm makes it 0.173 m")) << notes();
  EXPECT_EQ(robot_.notes.size(), 1u);
  for (const char* unit : {"tool=mm", "mm", "t*=mm"}) {
    const auto elements = read(text, {unit});
    EXPECT_TRUE(robot_.notes.empty()) << notes();
    double largest = 0;
    for (const Eigen::Vector3d& p : elements.at(1).shape.mesh.positions) largest = std::max(largest, p.maxCoeff());
    EXPECT_NEAR(largest, 100, 1e-9);
  }
  (void)read(armUrdf(collision("<mesh filename=\"box.stl\"/>")));
  EXPECT_TRUE(robot_.notes.empty()) << notes();
  // A robot that is in mm as a whole, a large primitive, and a link that is large beside its neighbour only.
  (void)read(test::replaced(text, "<box size=\"0.1 0.08 0.06\"/>", "<mesh filename=\"box_mm.stl\"/>"));
  EXPECT_TRUE(has(notes(), "--unit base=mm") && has(notes(), "--unit tool=mm")) << notes();
  (void)read(armUrdf(collision("<box size=\"100 100 1\"/>")));
  EXPECT_TRUE(has(notes(), "check the sizes") && !has(notes(), "--unit")) << notes();
  (void)read(armUrdf(collision("<sphere radius=\"0.00001\"/>")));
  EXPECT_TRUE(has(notes(), "link base has a size of 0.141 m, beside links of at most 3.46e-05 m")) << notes();
}

TEST_F(RobotShapes, UnitsThatFitNoLinkAreRefused) {
  const std::string text = armUrdf(collision("<mesh filename=\"box.stl\"/>"));
  for (const char* unit : {"base=mm", "none=cm"})
    EXPECT_TRUE(has(test::refusalOf<tool::UsageError>([&] { (void)read(text, {unit}); }), "names no link with a mesh file")) << unit;
  for (const char* wrong : {"", "km", "=mm", "tool=", "tool=MM"}) EXPECT_FALSE(linkUnit(wrong)) << wrong;
  EXPECT_EQ(linkUnit("a=b=in")->pattern, "a=b");
  EXPECT_EQ(linkUnit("in")->unit_mm, 25.4);
}

TEST_F(RobotShapes, ACapsuleHasItsCylinderOfThatLength) {
  const auto elements =
      read(armUrdf("<collision><origin xyz=\"1 0 0\" rpy=\"0 1.5707963267948966 0\"/><geometry><capsule radius=\"0.03\" "
                   "length=\"0.12\"/></geometry></collision>"));
  const LinkCapsule capsule = elements.at(1).shape.capsule.value();
  EXPECT_NEAR((capsule.a - Eigen::Vector3d(940, 0, 0)).norm(), 0, 1e-9);
  EXPECT_NEAR((capsule.b - Eigen::Vector3d(1060, 0, 0)).norm(), 0, 1e-9);
  EXPECT_EQ(capsule.radius, 30);
  // Its triangles are closed and lie on it.
  const TriangleMesh mesh = capsuleMesh(capsule);
  double volume = 0;
  for (const Triangle& t : mesh.triangles) volume += mesh.positions[t[0]].dot(mesh.positions[t[1]].cross(mesh.positions[t[2]])) / 6;
  EXPECT_NEAR(volume / (M_PI * 900 * 120 + 4.0 / 3 * M_PI * 27000), 1, 0.005);
}

}  // namespace
}  // namespace spheretree::robot
