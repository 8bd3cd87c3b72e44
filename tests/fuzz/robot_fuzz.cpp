// SPDX-License-Identifier: GPL-3.0-or-later
// Feeds any text to the readers of robots and of their spheres: it is refused with a reason that names the file, or
// gives a tree of finite frames, or balls of finite size.
#include "fuzz/fuzz_target.h"
#include "robot/files/sphere_file.h"
#include "robot/model/robot_model.h"
#include "robot/model/robot_shapes.h"
#include "spheretree/formats/errors.h"

namespace spheretree::fuzz {
namespace {

void feedRobot(const std::filesystem::path& path) {
  robot::Robot arm = robot::readUrdf(path);
  require(arm.root < arm.links.size() && arm.parent_joint.size() == arm.links.size(), "a robot has a root");
  for (const Eigen::Isometry3d& frame : robot::zeroPose(arm)) require(frame.matrix().allFinite(), "a frame is finite");
  for (const robot::Joint& joint : arm.joints) require(joint.lower <= joint.upper, "a joint has a range");
  for (const robot::ShapedElement& element : robot::readShapes(arm, {}, builder::Progress()))
    require(element.link < arm.links.size(), "a shape belongs to a link");
}

void feedSpheres(const std::filesystem::path& path) {
  const robot::SphereFile file = robot::readSphereFile(path);
  require(!file.sets.empty(), "a file has spheres");
  for (const robot::SphereSet& set : file.sets)
    for (const robot::LinkBall& ball : set.balls) require(ball.centre.allFinite() && ball.radius > 0, "a ball is a ball");
}

}  // namespace

std::vector<std::string> seeds() {
  const auto link = [](const std::string& name, const std::string& shape) {
    return "<link name=\"" + name + "\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" iyy=\"1\" izz=\"1\"/></inertial><collision>" +
           "<origin xyz=\"0 0 0.1\" rpy=\"0 1.57 0\"/><geometry>" + shape + "</geometry></collision></link>\n";
  };
  return {
      "<robot name=\"arm\">\n" + link("base", "<box size=\"0.1 0.08 0.06\"/>") + link("a", "<cylinder radius=\"0.05\" length=\"0.2\"/>") +
          link("b", "<sphere radius=\"0.03\"/>") + link("c", "<capsule radius=\"0.02\" length=\"0.1\"/>") +
          "<joint name=\"i\" type=\"revolute\"><parent link=\"base\"/><child link=\"a\"/><axis xyz=\"0 0 1\"/><limit lower=\"-1\" "
          "upper=\"1\" "
          "effort=\"1\" velocity=\"1\"/></joint>\n<joint name=\"j\" type=\"prismatic\"><parent link=\"a\"/><child link=\"b\"/><axis "
          "xyz=\"1 0 0\"/>"
          "<limit lower=\"0\" upper=\"0.1\"/><mimic joint=\"i\" multiplier=\"0.5\" offset=\"0.1\"/></joint>\n<joint name=\"k\" "
          "type=\"fixed\"><parent "
          "link=\"b\"/><child link=\"c\"/></joint></robot>\n",
      "<mujoco model=\"m\"><worldbody><body name=\"a\"><geom type=\"sphere\" size=\"0.1\" pos=\"0 0 1\"/></body></worldbody></mujoco>\n",
      "<robot name=\"s\"><link_sphere_approximation link=\"a\"><sphere center=\"0 0 1\" "
      "radius=\"0.1\"/></link_sphere_approximation></robot>\n",
      "robot_cfg:\n  kinematics:\n    collision_spheres:\n      a:\n        - center: [0, 0, 0.1]\n          radius: 0.05\n",
      "format: xrdf\nformat_version: 1.0\ngeometry:\n  g:\n    spheres:\n      a:\n      - {center: [0, 0, 0.1], radius: 0.05}\n",
      R"([{"mean": 0.1, "best": 0.1, "worst": 0.1, "spheres": [{"origin": [0, 0, 0], "radius": 0.1}]}])",
      R"({"a": {"centers": [[0, 0, 0], [0, 0, 1]], "radii": [0.1, 0.2]}})",
      R"({"unit": "mm", "m": [{"origin": [0, 0, 0], "radius": 1}]})",
      "x_mm,y_mm,z_mm,radius_mm\n0,0,1,2\n",
      "x,y,z,radius\n0,0,1,0.5\n"};
}

}  // namespace spheretree::fuzz

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace spheretree;
  const auto feed = [&](const std::string& ending, void (*read)(const std::filesystem::path&)) {
    const std::filesystem::path path = fuzz::asFile(data, size, ending);
    try {
      read(path);
    } catch (const formats::FormatError& error) {
      fuzz::require(std::string(error.what()).starts_with(path.string()), "a refusal names the file");
    } catch (const formats::FileError&) {  // another file that it names
    }
  };
  if (size > 0 && data[0] == '<') {  // the ending decides how a file is read
    feed(".urdf", fuzz::feedRobot);
    feed(".xml", fuzz::feedSpheres);
  } else {
    feed(".csv", fuzz::feedSpheres);
    feed(".yml", fuzz::feedSpheres);
  }
  return 0;
}
