// SPDX-License-Identifier: GPL-3.0-or-later
// Generated URDFs, with each optional part present, absent, empty, zero or malformed, against urdfdom: what it takes,
// our reader takes with the same values, or says in one line what is unusual. All files that are written from what our
// reader takes are read back by urdfdom and MuJoCo.
#include <console_bridge/console.h>
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>
#include <urdf_parser/urdf_parser.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <regex>

#include "robot/sample_urdf.h"
#include "spheretree/formats/errors.h"
#include "support/random.h"
#include "support/scratch_folder.h"
#include "support/texts.h"

namespace spheretree::robot {
namespace {

/// Writes one URDF. One part in `rarity` is unusual.
class UrdfGenerator {
 public:
  UrdfGenerator(std::uint64_t seed, std::uint64_t rarity) : random_(seed), rarity_(rarity) {}

  std::string robot() {
    const std::uint64_t links = 1 + random_.below(4);
    std::string out = "<?xml version=\"1.0\"?>\n<robot" + name("r", "") + ">\n";
    for (std::uint64_t l = 0; l < links; ++l) out += link(l);
    for (std::uint64_t l = 1; l < links; ++l) out += joint(l);
    if (random_.below(4) == 0)
      out += "<transmission name=\"t\"><joint name=\"none\"/></transmission>\n<gazebo reference=\"l0\"><x/></gazebo>\n<sensor/>\n";
    return out + "</robot>\n";
  }

 private:
  bool isUnusual() { return random_.below(rarity_) == 0; }
  std::string oneOf(std::initializer_list<const char*> texts) { return texts.begin()[random_.below(texts.size())]; }

  /// `count` numbers; `usual` makes one.
  template <class Usual>
  std::string attribute(const std::string& name, int count, Usual&& usual) {
    const auto join = [&](auto&& one) {
      std::string out;
      for (int i = 0; i < count; ++i) out += (i > 0 ? " " : "") + std::string(one());
      return out;
    };
    const auto number = [&] { return std::to_string(usual()); };
    std::string value = join(number);
    if (isUnusual()) switch (random_.below(9)) {
        case 0:
          return "";
        case 1:
          value = "";
          break;
        case 2:
          value = join([] { return "0"; });
          break;
        case 3:
          value = join([&] { return random_.below(2) == 0 ? std::string("0") : number(); });
          break;
        case 4:
          value = join([&] { return oneOf({"1e-400", "+1", ".5", "2.", "1e2", "-0", "0x10", "1e-5", "-1", "1e400"}); });
          break;
        case 5:
          value += " " + number();
          break;
        case 6:
          value = oneOf({"nan", "inf", "abc", "1,0", "${x}", "1.0f", "--1", "1 2", "1 2 nan", "1;2;3", "\t1 2 3", " 1 ", "1\n2\n3"});
          break;
        case 7:
          value = "  " + value;
          break;
        default:
          value = join([&] { return "-" + number(); });
      }
    return " " + name + "=\"" + value + "\"";
  }
  std::string plain(const std::string& name, double low, double high, int count = 1) {
    return attribute(name, count, [&, low, high] { return random_.between(low, high); });
  }
  std::string name(const std::string& usual, const std::string& other) {
    if (!isUnusual()) return " name=\"" + usual + "\"";
    const std::string unusual = oneOf({"", " name=\"\"", " name=\"l0\"", " name=\"a b\"", " name=\"world\"", " name=\"&lt;x&gt;\""});
    return unusual.empty() ? other : unusual;
  }
  /// An element, which may be absent, empty or given twice.
  std::string element(const std::string& tag, const std::string& attributes, const std::string& content = "") {
    const std::string one = "<" + tag + attributes + (content.empty() ? "/>" : ">" + content + "</" + tag + ">") + "\n";
    if (!isUnusual()) return one;
    return std::array<std::string, 3>{"", "<" + tag + "/>\n", one + one}[random_.below(3)];
  }
  std::string origin() { return element("origin", plain("xyz", -1, 1, 3) + plain("rpy", -3, 3, 3)); }
  std::string shape() {
    switch (random_.below(isUnusual() ? 6 : 4)) {
      case 0:
        return element("box", plain("size", 0.01, 1, 3));
      case 1:
        return element("cylinder", plain("radius", 0.01, 1) + plain("length", 0.01, 1));
      case 2:
        return element("sphere", plain("radius", 0.01, 1));
      case 3:
        return element("mesh", (isUnusual() ? oneOf({"", " filename=\"\"", " filename=\"none.stl\"", " filename=\"empty.stl\""})
                                            : " filename=\"box.stl\"") +
                                   (random_.below(2) == 0 ? plain("scale", 0.1, 2, 3) : ""));
      case 4:
        return element("capsule", plain("radius", 0.01, 1) + plain("length", 0.01, 1));
      default:
        return oneOf({"<cone/>", "", "text", "<box/>"});
    }
  }
  std::string shapes(const std::string& tag) { return element(tag, "", origin() + element("geometry", "", shape())); }
  std::string link(std::uint64_t l) {
    std::string content;
    if (random_.below(2) == 0)
      content += element("inertial", "",
                         origin() + element("mass", plain("value", 0.1, 5)) +
                             element("inertia", plain("ixx", 0.5, 1) + plain("iyy", 0.5, 1) + plain("izz", 0.5, 1) +
                                                    plain("ixy", -0.1, 0.1) + plain("ixz", -0.1, 0.1) + plain("iyz", -0.1, 0.1)));
    if (random_.below(4) == 0) content += shapes("visual");
    for (std::uint64_t n = random_.below(3); n > 0; --n) content += shapes("collision");
    return "<link" + name("l" + std::to_string(l), "") + ">\n" + content + "</link>\n";
  }
  std::string joint(std::uint64_t l) {
    const std::string kind = isUnusual()
                                 ? oneOf({"", " type=\"\"", " type=\"hinge\""})
                                 : " type=\"" + oneOf({"fixed", "revolute", "continuous", "prismatic", "floating", "planar"}) + "\"";
    const std::uint64_t parent = isUnusual() ? random_.below(5) : random_.below(l);
    std::string content = element("parent", " link=\"l" + std::to_string(parent) + "\"") +
                          element("child", " link=\"l" + std::to_string(l) + "\"") + origin();
    if (random_.below(3) > 0) content += element("axis", plain("xyz", -1, 1, 3));
    content += element("limit", plain("lower", -2, 0) + plain("upper", 0, 2) + plain("effort", 1, 10) + plain("velocity", 1, 10));
    if (random_.below(4) == 0)
      content += element("mimic", (isUnusual() ? "" : " joint=\"j" + std::to_string(1 + random_.below(4)) + "\"") +
                                      plain("multiplier", -2, 2) + plain("offset", -1, 1));
    if (random_.below(4) == 0) content += element("dynamics", plain("damping", 0, 1) + plain("friction", 0, 1));
    if (random_.below(6) == 0) content += element("safety_controller", plain("k_velocity", 0, 1) + plain("k_position", 0, 1));
    return "<joint" + name("j" + std::to_string(l), "") + kind + ">\n" + content + "</joint>\n";
  }

  test::Random random_;
  std::uint64_t rarity_;
};

Eigen::Isometry3d frameOf(const urdf::Pose& pose) {
  const urdf::Rotation& q = pose.rotation;
  Eigen::Isometry3d frame = Eigen::Isometry3d::Identity();
  frame.linear() = Eigen::Quaterniond(q.w, q.x, q.y, q.z).normalized().toRotationMatrix();
  frame.translation() = 1000 * Eigen::Vector3d(pose.position.x, pose.position.y, pose.position.z);
  return frame;
}

void expectFrame(const Eigen::Isometry3d& ours, const urdf::Pose& theirs) {
  EXPECT_TRUE(ours.isApprox(frameOf(theirs), 1e-9)) << ours.matrix() << "\n" << frameOf(theirs).matrix();
}

/// Sizes of a shape [mm].
std::vector<double> sizesOf(const CollisionElement& element) {
  if (const auto* box = std::get_if<Box>(&element.shape)) return {box->size.x(), box->size.y(), box->size.z()};
  if (const auto* cylinder = std::get_if<Cylinder>(&element.shape)) return {cylinder->radius, cylinder->length};
  if (const auto* ball = std::get_if<Capsule>(&element.shape)) return {ball->radius};
  if (const auto* mesh = std::get_if<MeshFile>(&element.shape))
    return {1000 * mesh->scale.x(), 1000 * mesh->scale.y(), 1000 * mesh->scale.z()};
  return {};
}

std::vector<double> sizesOf(const urdf::Geometry& geometry) {
  std::vector<double> out;
  if (geometry.type == urdf::Geometry::BOX) {
    const urdf::Vector3& d = static_cast<const urdf::Box&>(geometry).dim;
    out = {d.x, d.y, d.z};
  } else if (geometry.type == urdf::Geometry::CYLINDER) {
    const auto& c = static_cast<const urdf::Cylinder&>(geometry);
    out = {c.radius, c.length};
  } else if (geometry.type == urdf::Geometry::SPHERE) {
    out = {static_cast<const urdf::Sphere&>(geometry).radius};
  } else {
    const urdf::Vector3& s = static_cast<const urdf::Mesh&>(geometry).scale;
    out = {s.x, s.y, s.z};
  }
  for (double& size : out) size *= 1000;
  return out;
}

void expectLink(const Link& ours, const urdf::Link& theirs) {
  ASSERT_EQ(ours.collisions.size(), theirs.collision_array.size());
  for (std::size_t i = 0; i < ours.collisions.size(); ++i) {
    expectFrame(ours.collisions[i].origin, theirs.collision_array[i]->origin);
    const std::vector<double> a = sizesOf(ours.collisions[i]), b = sizesOf(*theirs.collision_array[i]->geometry);
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t k = 0; k < a.size(); ++k) EXPECT_NEAR(a[k], b[k], 1e-9 * std::abs(b[k]));
  }
  if (!theirs.inertial) return;
  ASSERT_TRUE(ours.inertia);
  expectFrame(ours.inertia->origin, theirs.inertial->origin);
  EXPECT_EQ(ours.inertia->mass, theirs.inertial->mass);
  const urdf::Inertial& t = *theirs.inertial;
  Eigen::Matrix3d tensor;
  tensor << t.ixx, t.ixy, t.ixz, t.ixy, t.iyy, t.iyz, t.ixz, t.iyz, t.izz;
  EXPECT_EQ(ours.inertia->tensor, tensor);
}

void expectJoint(const Robot& robot, const Joint& ours, const urdf::Joint& theirs) {
  const std::map<JointKind, int> kinds{{JointKind::Fixed, urdf::Joint::FIXED},           {JointKind::Revolute, urdf::Joint::REVOLUTE},
                                       {JointKind::Continuous, urdf::Joint::CONTINUOUS}, {JointKind::Prismatic, urdf::Joint::PRISMATIC},
                                       {JointKind::Floating, urdf::Joint::FLOATING},     {JointKind::Planar, urdf::Joint::PLANAR}};
  EXPECT_EQ(kinds.at(ours.kind), static_cast<int>(theirs.type));
  EXPECT_EQ(robot.links[ours.parent].name, theirs.parent_link_name);
  EXPECT_EQ(robot.links[ours.child].name, theirs.child_link_name);
  expectFrame(ours.origin, theirs.parent_to_joint_origin_transform);
  if (ours.kind != JointKind::Fixed && ours.kind != JointKind::Floating) {
    const Eigen::Vector3d axis(theirs.axis.x, theirs.axis.y, theirs.axis.z);
    EXPECT_TRUE(ours.axis.isApprox(axis.normalized(), 1e-9));
  }
  if (ours.kind == JointKind::Revolute || ours.kind == JointKind::Prismatic) {
    const double unit = ours.kind == JointKind::Prismatic ? 1000 : 1;
    EXPECT_NEAR(ours.lower, unit * std::min(theirs.limits->lower, theirs.limits->upper), 1e-9);
    EXPECT_NEAR(ours.upper, unit * std::max(theirs.limits->lower, theirs.limits->upper), 1e-9);
  }
}

/// The reasons for which a URDF that urdfdom takes may be refused, each in one line with its place.
const std::regex kUnusual(
    "^[^\n]*\\.urdf:[0-9]+: (<[a-z_]+> of )?((link|joint) [^\n]*|<robot>): "
    "(the axis of a joint that moves needs a direction, and this one is 0 0 0\\.|"
    "(radius|length) must not be negative\\.|needs a size of three numbers that are not negative\\.|"
    "needs the attribute name\\.|the link [^\n]* already hangs on the joint [^\n]*|the joints from it to its root run in a circle\\.[^\n]*|"
    "needs the attribute joint\\.|"
    "the mesh [^\n]*/none\\.stl does not exist\\.)[^\n]*$");

/// Counts the errors of urdfdom. After an error in a link it goes on with the rest of the robot, and without the rest
/// of the link.
class ErrorCounter : public console_bridge::OutputHandler {
 public:
  void log(const std::string&, console_bridge::LogLevel level, const char*, int) override {
    errors += level >= console_bridge::CONSOLE_BRIDGE_LOG_ERROR;
  }
  int errors = 0;
};

struct Counts {
  int theirs = 0, partly = 0, both = 0, unusual = 0, ours_alone = 0, loaded = 0, written = 0;
};

class UrdfSweep : public testing::Test {
 protected:
  UrdfSweep() {
    console_bridge::useOutputHandler(&errors_);
    test::written(folder_.path() / "box.stl", test::boxStl(0.1));
    test::written(folder_.path() / "empty.stl", std::string(84, '\0'));
  }
  ~UrdfSweep() override { console_bridge::restorePreviousOutputHandler(); }

  void compare(const std::string& text) {
    SCOPED_TRACE(text);
    const std::filesystem::path path = test::written(folder_.path() / "a.urdf", text);
    errors_.errors = 0;
    urdf::ModelInterfaceSharedPtr theirs = urdf::parseURDF(text);
    if (theirs && errors_.errors > 0) {
      ++counts_.partly;
      theirs.reset();
    }
    counts_.theirs += theirs != nullptr;
    std::string refusal;
    try {
      Robot robot = readUrdf(path);
      counts_.both += theirs != nullptr, counts_.ours_alone += theirs == nullptr;
      if (theirs) expectSame(robot, *theirs);
      writeAll(robot, theirs != nullptr);
      return;
    } catch (const formats::FormatError& error) {
      refusal = error.what();
    } catch (const formats::FileError& error) {
      refusal = error.what();
    }
    EXPECT_EQ(refusal.find('\n'), std::string::npos) << refusal;
    EXPECT_TRUE(std::regex_search(refusal, std::regex("a\\.urdf:[0-9]+: "))) << refusal;
    if (!theirs) return;
    ++counts_.unusual;
    EXPECT_TRUE(std::regex_match(refusal, kUnusual)) << refusal;
  }

  static void expectSame(const Robot& robot, const urdf::ModelInterface& theirs) {
    ASSERT_EQ(robot.links.size(), theirs.links_.size());
    ASSERT_EQ(robot.joints.size(), theirs.joints_.size());
    EXPECT_EQ(robot.links[robot.root].name, theirs.getRoot()->name);
    for (const Link& link : robot.links) {
      ASSERT_TRUE(theirs.links_.contains(link.name));
      expectLink(link, *theirs.links_.at(link.name));
    }
    for (const Joint& joint : robot.joints) {
      ASSERT_TRUE(theirs.joints_.contains(joint.name));
      expectJoint(robot, joint, *theirs.joints_.at(joint.name));
    }
  }

  /// From a cover that is not built.
  void writeAll(Robot& robot, bool is_readable) {
    std::vector<ShapedElement> shapes;
    try {
      const builder::Progress progress;
      shapes = readShapes(robot, {}, progress);
    } catch (const formats::FormatError& error) {
      EXPECT_TRUE(test::has(error.what(), "nothing to cover")) << error.what();
      return;
    }
    const RobotCover cover = test::roughCover(shapes);
    const RobotFiles files = robotFiles({robot, cover, {}, {}, {}}, folder_.path());
    const std::vector<std::filesystem::path> names = robotFileNames(robot);
    ASSERT_EQ(files.contents.size(), names.size());
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (names[i].string().ends_with(".mjcf.xml")) {
        char error[1000] = "";
        mjModel* model = mj_loadXML(test::written(folder_.path() / "m.xml", files.contents[i]).c_str(), nullptr, error, sizeof error);
        EXPECT_TRUE(model) << error << files.contents[i];
        counts_.loaded += model != nullptr;
        mj_deleteModel(model);
      }
      if (is_readable && names[i].string().ends_with(".urdf")) {
        EXPECT_TRUE(urdf::parseURDF(files.contents[i])) << files.contents[i];
        ++counts_.written;
      }
    }
  }

  test::ScratchFolder folder_;
  ErrorCounter errors_;
  Counts counts_;
};

TEST_F(UrdfSweep, WhatUrdfdomTakesIsTakenOrNamed) {
  constexpr int kFiles = 2000;
  for (int n = 0; n < kFiles; ++n) {
    compare(UrdfGenerator(static_cast<std::uint64_t>(n), n % 4 == 0 ? 10 : 60).robot());
    if (HasFailure()) return;
  }
  // It compares something: urdfdom takes a third of the files, and both take most of these.
  EXPECT_GT(counts_.theirs, kFiles / 4);
  EXPECT_GT(counts_.both, 9 * counts_.theirs / 10);
  EXPECT_GT(counts_.unusual, 10);
  EXPECT_GT(counts_.ours_alone, 100);
  EXPECT_GT(counts_.loaded, kFiles / 4);
  RecordProperty("taken_by_urdfdom", counts_.theirs);
  RecordProperty("taken_by_both", counts_.both);
  RecordProperty("named_as_unusual", counts_.unusual);
  RecordProperty("loaded_by_mujoco", counts_.loaded);
}

}  // namespace
}  // namespace spheretree::robot
