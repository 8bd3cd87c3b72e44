// SPDX-License-Identifier: Apache-2.0
#include "robots.h"

#include <array>
#include <charconv>
#include <cmath>
#include <cstring>
#include <functional>

#include "implicit_surface.h"
#include "spheretree/formats/mesh_writer.h"

namespace spheretree::samples {
namespace {

using Eigen::Vector3d;

constexpr double kRound = 12;  // radius of the rounding of edges, approximately [mm]

/// Solid cylinder about an axis (0: x, 1: y, 2: z) through `centre`.
Field cylinder(int axis, const Vector3d& centre, double radius, double half_length) {
  return [=](const Vector3d& p) {
    const Vector3d d = p - centre;
    const double across = std::sqrt(squared(d[(axis + 1) % 3]) + squared(d[(axis + 2) % 3])) - radius;
    return smoothMax(across, std::abs(d[axis]) - half_length, kRound);
  };
}

/// Tube from a to b, whose radius changes linearly, with round ends.
Field tube(const Vector3d& a, const Vector3d& b, double radius_a, double radius_b) {
  return [=](const Vector3d& p) {
    const double t = std::min(1.0, std::max(0.0, (p - a).dot(b - a) / (b - a).squaredNorm()));
    return (p - a - t * (b - a)).norm() - (radius_a + t * (radius_b - radius_a));
  };
}

Field block(const Vector3d& centre, const Vector3d& half) {
  return [=](const Vector3d& p) {
    const Vector3d d = (p - centre).cwiseAbs() - half;
    return smoothMax(smoothMax(d.x(), d.y(), kRound), d.z(), kRound);
  };
}

Field joined(const std::vector<Field>& parts, double width) {
  return [=](const Vector3d& p) {
    double value = parts[0](p);
    for (std::size_t i = 1; i < parts.size(); ++i) value = smoothMin(value, parts[i](p), width);
    return value;
  };
}

Field without(const Field& solid, const Field& hole) {
  return [=](const Vector3d& p) { return smoothMax(solid(p), -hole(p), kRound); };
}

/// A link of an arm: a tube along z, and the housing of a joint across its ends.
Field armLink(double length, double radius, double low_housing, double high_housing) {
  std::vector<Field> parts{tube({0, 0, 0}, {0, 0, length}, radius, 0.9 * radius)};
  if (low_housing > 0) parts.push_back(cylinder(1, {0, 0, 0}, low_housing, 1.25 * low_housing));
  if (high_housing > 0) parts.push_back(cylinder(1, {0, 0, length}, high_housing, 1.25 * high_housing));
  return joined(parts, 30);
}

std::vector<std::byte> bytesOf(const std::string& text) {
  const auto* first = reinterpret_cast<const std::byte*>(text.data());
  return {first, first + text.size()};
}

std::string number(double value) {
  std::array<char, 32> text;
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr};
}

/// Binary STL.
std::vector<std::byte> stlBytes(const TriangleMesh& mesh) {
  std::vector<std::byte> out(80);
  const auto put = [&out](const auto& value) {
    const auto* first = reinterpret_cast<const std::byte*>(&value);
    out.insert(out.end(), first, first + sizeof(value));
  };
  put(static_cast<std::uint32_t>(mesh.triangles.size()));
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) put(0.0f);
    for (int corner = 0; corner < 3; ++corner)
      for (int k = 0; k < 3; ++k) put(static_cast<float>(mesh.corner(t, corner)[k]));
    put(std::uint16_t{0});
  }
  return out;
}

/// Collada, in this unit [m].
std::vector<std::byte> daeBytes(const TriangleMesh& mesh, double unit) {
  std::string positions, corners;
  for (const Vector3d& p : mesh.positions)
    for (int k = 0; k < 3; ++k) positions += number(p[k]) + " ";
  for (const Triangle& t : mesh.triangles)
    for (const std::uint32_t v : t) corners += std::to_string(v) + " ";
  const std::string count = std::to_string(mesh.positions.size()), numbers = std::to_string(3 * mesh.positions.size());
  return bytesOf(
      "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<COLLADA xmlns=\"http://www.collada.org/2005/11/COLLADASchema\" "
      "version=\"1.4.1\">\n<asset><unit "
      "name=\"own\" meter=\"" +
      number(unit) +
      "\"/><up_axis>Z_UP</up_axis></asset>\n<library_geometries><geometry id=\"g\" name=\"g\"><mesh><source id=\"p\"><float_array "
      "id=\"pa\" count=\"" +
      numbers + "\">" + positions + "</float_array><technique_common><accessor source=\"#pa\" count=\"" + count +
      "\" stride=\"3\"><param name=\"X\" type=\"float\"/><param name=\"Y\" type=\"float\"/><param name=\"Z\" "
      "type=\"float\"/></accessor></technique_common>"
      "</source><vertices id=\"v\"><input semantic=\"POSITION\" source=\"#p\"/></vertices><triangles count=\"" +
      std::to_string(mesh.triangles.size()) + "\"><input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/><p>" + corners +
      "</p></triangles></mesh></geometry></library_geometries>\n<library_visual_scenes><visual_scene id=\"s\"><node "
      "id=\"n\"><instance_geometry "
      "url=\"#g\"/></node></visual_scene></library_visual_scenes>\n<scene><instance_visual_scene url=\"#s\"/></scene>\n</COLLADA>\n");
}

TriangleMesh scaled(TriangleMesh mesh, double factor) {
  for (Vector3d& p : mesh.positions) p *= factor;
  return mesh;
}

/// Collects the files of one robot.
class RobotWriter {
 public:
  explicit RobotWriter(std::string name) : name_(std::move(name)) {}

  /// A link whose mesh is in metres, or in mm with a scale.
  void link(const std::string& link, const Field& field, const Vector3d& low, const Vector3d& high, double cell, const std::string& ending,
            double mass) {
    const TriangleMesh mesh = polygonise(field, low, high, cell);
    const TriangleMesh metres = scaled(mesh, 1e-3);
    std::string scale;
    std::vector<std::byte> bytes;
    if (ending == "stl") bytes = stlBytes(metres);
    if (ending == "obj") bytes = formats::encodeObj(mesh), scale = " scale=\"0.001 0.001 0.001\"";
    if (ending == "ply") bytes = formats::encodePly(metres);
    if (ending == "dae") bytes = daeBytes(mesh, 0.001);
    const std::string file = "meshes/" + link + "." + ending;
    files_.emplace_back(file, std::move(bytes));
    const std::string name = ending == "stl" ? "package://" + name_ + "/" + file : file;
    shapes(link, "<collision><geometry><mesh filename=\"" + name + "\"" + scale + "/></geometry></collision>", mass);
  }

  void shapes(const std::string& link, const std::string& collisions, double mass) {
    const double inertia = mass * 0.01;
    urdf_ += "  <link name=\"" + link + "\">\n    <inertial><origin xyz=\"0 0 0.05\" rpy=\"0 0 0\"/><mass value=\"" + number(mass) +
             "\"/><inertia ixx=\"" + number(inertia) + "\" ixy=\"0\" ixz=\"0\" iyy=\"" + number(inertia) + "\" iyz=\"0\" izz=\"" +
             number(inertia) + "\"/></inertial>\n    " + collisions + "\n  </link>\n";
  }

  void joint(const std::string& joint, const std::string& type, const std::string& parent, const std::string& child, const std::string& xyz,
             const std::string& axis, double lower, double upper, const std::string& more = "") {
    urdf_ += "  <joint name=\"" + joint + "\" type=\"" + type + "\"><parent link=\"" + parent + "\"/><child link=\"" + child +
             "\"/><origin xyz=\"" + xyz + "\" rpy=\"0 0 0\"/>";
    if (type != "fixed")
      urdf_ += "<axis xyz=\"" + axis + "\"/><limit lower=\"" + number(lower) + "\" upper=\"" + number(upper) +
               "\" velocity=\"2\" effort=\"100\"/>" + more;
    urdf_ += "</joint>\n";
  }

  void emptyLink(const std::string& link) { urdf_ += "  <link name=\"" + link + "\"/>\n"; }

  RobotFiles finish() {
    files_.emplace_back(name_ + ".urdf", bytesOf("<?xml version=\"1.0\"?>\n<robot name=\"" + name_ + "\">\n" + urdf_ + "</robot>\n"));
    return std::move(files_);
  }

 private:
  std::string name_, urdf_;
  RobotFiles files_;
};

}  // namespace

RobotFiles sampleArm7() {
  RobotWriter robot("sample_arm7");
  const double cell = 7;
  robot.link("base",
             joined({cylinder(2, {0, 0, 20}, 95, 20), tube({0, 0, 40}, {0, 0, 110}, 68, 66), block({-70, 0, 40}, {50, 55, 35})}, 25),
             {-160, -140, -30}, {140, 140, 220}, cell, "stl", 4);
  robot.link("link1", armLink(165, 64, 0, 62), {-110, -130, -100}, {110, 130, 270}, cell, "stl", 3);
  robot.link("link2", joined({armLink(185, 56, 60, 0), tube({0, 45, 20}, {0, 10, 150}, 40, 45)}, 30), {-110, -130, -110}, {110, 130, 280},
             cell, "obj", 3);
  robot.link("link3", joined({armLink(160, 55, 0, 0), cylinder(1, {40, 0, 165}, 56, 68)}, 40), {-110, -120, -100}, {150, 120, 270}, cell,
             "ply", 3);
  robot.link("link4", joined({cylinder(1, {0, 0, 0}, 55, 66), tube({-10, 0, 20}, {-40, 0, 175}, 50, 52)}, 40), {-140, -120, -100},
             {110, 120, 270}, cell, "dae", 2);
  robot.link("link5",
             joined({tube({0, 0, 0}, {0, 0, 110}, 52, 46), tube({0, 40, 90}, {0, 30, 200}, 34, 38), cylinder(1, {0, 0, 205}, 46, 58)}, 35),
             {-100, -110, -90}, {100, 130, 290}, cell, "stl", 2);
  robot.link("link6", joined({cylinder(1, {0, 0, 0}, 46, 55), tube({0, 0, 0}, {82, 0, 10}, 44, 46), cylinder(2, {84, 0, 15}, 46, 40)}, 30),
             {-90, -100, -90}, {170, 100, 110}, cell, "obj", 1.5);
  robot.link("link7", joined({cylinder(2, {0, 0, 30}, 40, 32), block({28, 28, 45}, {22, 22, 14})}, 15), {-75, -75, -40}, {90, 90, 100}, 5,
             "stl", 0.7);
  robot.link("hand",
             without(joined({block({0, 0, 35}, {30, 100, 32}), cylinder(2, {0, 0, -5}, 38, 12)}, 15), block({0, 0, 85}, {40, 45, 30})),
             {-70, -140, -45}, {70, 140, 110}, 5, "stl", 0.6);
  const std::string finger =
      "<collision name=\"pad\"><origin xyz=\"0 0 0.04\" rpy=\"0 0 0\"/><geometry><box size=\"0.02 0.014 0.05\"/></geometry></collision>\n  "
      "  "
      "<collision name=\"tip\"><origin xyz=\"0 0 0.07\" rpy=\"1.5707963267948966 0 0\"/><geometry><cylinder radius=\"0.009\" "
      "length=\"0.016\"/></geometry></collision>"
      "\n    <collision name=\"root\"><origin xyz=\"0 0 0.012\" rpy=\"0 0 0\"/><geometry><sphere radius=\"0.012\"/></geometry></collision>";
  robot.shapes("finger_left", finger, 0.05);
  robot.shapes("finger_right", finger, 0.05);
  robot.emptyLink("tool");
  robot.joint("joint1", "revolute", "base", "link1", "0 0 0.16", "0 0 1", -2.9, 2.9);
  robot.joint("joint2", "revolute", "link1", "link2", "0 0 0.165", "0 1 0", -1.9, 1.9);
  robot.joint("joint3", "revolute", "link2", "link3", "0 0 0.215", "0 0 1", -2.9, 2.9);
  robot.joint("joint4", "revolute", "link3", "link4", "0.04 0 0.165", "0 -1 0", 0, 2.6);
  robot.joint("joint5", "revolute", "link4", "link5", "-0.04 0 0.205", "0 0 1", -2.9, 2.9);
  robot.joint("joint6", "revolute", "link5", "link6", "0 0 0.205", "0 -1 0", -0.1, 3.7);
  robot.joint("joint7", "revolute", "link6", "link7", "0.084 0 0.055", "0 0 1", -2.9, 2.9);
  robot.joint("hand_joint", "fixed", "link7", "hand", "0 0 0.08", "", 0, 0);
  robot.joint("finger_joint", "prismatic", "hand", "finger_left", "0 0 0.058", "0 1 0", 0.01, 0.045);
  robot.joint("finger_mimic", "prismatic", "hand", "finger_right", "0 0 0.058", "0 -1 0", 0.01, 0.045,
              "<mimic joint=\"finger_joint\" multiplier=\"1\" offset=\"0\"/>");
  robot.joint("tool_joint", "fixed", "hand", "tool", "0 0 0.14", "", 0, 0);
  return robot.finish();
}

RobotFiles sampleArm6() {
  RobotWriter robot("sample_arm6");
  const double cell = 16;
  robot.link("base_link",
             joined({block({-60, 0, 60}, {300, 220, 60}), cylinder(2, {0, 0, 180}, 190, 150), block({-250, 0, 150}, {90, 130, 90})}, 60),
             {-420, -300, -60}, {320, 300, 400}, cell, "stl", 150);
  robot.link("link_1",
             joined({cylinder(2, {0, 0, 60}, 185, 90), block({110, 0, 210}, {130, 150, 110}), cylinder(1, {150, 0, 285}, 150, 190),
                     cylinder(2, {-90, 100, 260}, 75, 130)},
                    60),
             {-280, -280, -110}, {380, 280, 510}, cell, "stl", 120);
  robot.link("link_2",
             without(joined({cylinder(1, {0, 0, 0}, 140, 70), cylinder(1, {0, 0, 700}, 110, 70), block({0, 0, 350}, {85, 60, 330})}, 80),
                     block({0, 0, 350}, {40, 90, 190})),
             {-220, -170, -220}, {220, 170, 900}, cell, "obj", 80);
  robot.link("link_3",
             joined({block({30, 0, 60}, {170, 130, 120}), cylinder(1, {0, 0, 0}, 115, 150), cylinder(0, {-200, 70, 90}, 62, 110),
                     cylinder(0, {-200, -70, 90}, 62, 110)},
                    50),
             {-400, -240, -190}, {310, 240, 270}, cell, "ply", 60);
  robot.link("link_4",
             joined({cylinder(0, {120, 0, 0}, 95, 110), tube({200, 0, 0}, {520, 0, 0}, 90, 70), block({560, 75, 0}, {70, 22, 65}),
                     block({560, -75, 0}, {70, 22, 65})},
                    40),
             {-80, -160, -160}, {700, 160, 160}, 12, "stl", 30);
  robot.link("link_5", joined({cylinder(1, {0, 0, 0}, 52, 46), tube({0, 0, 0}, {70, 0, 0}, 46, 44)}, 25), {-100, -100, -100},
             {170, 100, 100}, 8, "dae", 6);
  robot.link("link_6", joined({cylinder(0, {12, 0, 0}, 40, 14), cylinder(0, {30, 0, 0}, 24, 12)}, 8), {-40, -80, -80}, {80, 80, 80}, 6,
             "stl", 1);
  robot.emptyLink("tool0");
  robot.joint("joint_1", "revolute", "base_link", "link_1", "0 0 0.33", "0 0 1", -3.1, 3.1);
  robot.joint("joint_2", "revolute", "link_1", "link_2", "0.15 0 0.285", "0 1 0", -1.7, 1.9);
  robot.joint("joint_3", "revolute", "link_2", "link_3", "0 0 0.7", "0 1 0", -1.05, 1.13);
  robot.joint("joint_4", "revolute", "link_3", "link_4", "0.2 0 0.115", "1 0 0", -3.4, 3.4);
  robot.joint("joint_5", "revolute", "link_4", "link_5", "0.56 0 0", "0 1 0", -2.1, 2.1);
  robot.joint("joint_6", "continuous", "link_5", "link_6", "0.115 0 0", "1 0 0", 0, 0);
  robot.joint("tool_joint", "fixed", "link_6", "tool0", "0.045 0 0", "", 0, 0);
  return robot.finish();
}

}  // namespace spheretree::samples
