// SPDX-License-Identifier: GPL-3.0-or-later
// Small robots for tests, and covers that are not built.
#pragma once

#include <Eigen/Geometry>
#include <fstream>
#include <string>

#include "robot/files/robot_files.h"
#include "robot/model/robot_shapes.h"

namespace spheretree::test {

inline std::filesystem::path written(const std::filesystem::path& path, const std::string& text) {
  std::filesystem::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary) << text;
  return path;
}

/// A box in ASCII STL with a corner at the origin.
inline std::string boxStl(double size) {
  const Eigen::Vector3d e[3] = {{size, 0, 0}, {0, size, 0}, {0, 0, size}};
  std::string out = "solid box\n";
  const auto facet = [&](const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
    out += "facet normal 0 0 0\nouter loop\n";
    for (const Eigen::Vector3d& p : {a, b, c})
      out += "vertex " + std::to_string(p.x()) + " " + std::to_string(p.y()) + " " + std::to_string(p.z()) + "\n";
    out += "endloop\nendfacet\n";
  };
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d &u = e[(axis + 1) % 3], &v = e[(axis + 2) % 3], &n = e[axis];
    facet({0, 0, 0}, u + v, u), facet({0, 0, 0}, v, u + v);
    facet(n, n + u, n + u + v), facet(n, n + u + v, n + v);
  }
  return out + "endsolid box\n";
}

/// <robot> with a link "base" (a box) and a link "tool" with this content, that hang on the joint "j".
inline std::string armUrdf(const std::string& tool, const std::string& joint = "<axis xyz=\"0 0 1\"/>",
                           const std::string& kind = "continuous") {
  return "<robot name=\"arm\">\n"
         "<link name=\"base\"><collision><geometry><box size=\"0.1 0.08 0.06\"/></geometry></collision></link>\n"
         "<link name=\"tool\">" +
         tool +
         "</link>\n"
         "<joint name=\"j\" type=\"" +
         kind + "\"><parent link=\"base\"/><child link=\"tool\"/>" + joint +
         "</joint>\n"
         "</robot>\n";
}

/// <collision> with this shape.
inline std::string collision(const std::string& shape) { return "<collision><geometry>" + shape + "</geometry></collision>"; }

/// Two balls about each shape, in place of a cover that takes time.
inline robot::RobotCover roughCover(const std::vector<robot::ShapedElement>& shapes) {
  robot::RobotCover cover;
  for (const robot::ShapedElement& element : shapes) {
    if (cover.links.empty() || cover.links.back().link != element.link) {
      robot::LinkCover& link = cover.links.emplace_back();
      link.link = element.link;
      link.levels.resize(1);
      link.overhang_bounds_mm = {1};
    }
    Eigen::AlignedBox3d box;
    for (const Eigen::Vector3d& p : element.shape.mesh.positions) box.extend(p);
    if (const auto& capsule = element.shape.capsule) box.extend(capsule->a).extend(capsule->b);
    const double radius = box.diagonal().norm() / 2 + (element.shape.capsule ? element.shape.capsule->radius : 0);
    for (const double factor : {1.0, 1.5}) cover.links.back().levels[0].push_back(robot::metreSphere({box.center(), factor * radius}));
  }
  return cover;
}

}  // namespace spheretree::test
