// SPDX-License-Identifier: GPL-3.0-or-later
// URDF with spheres, SRDF, MJCF.
#include <algorithm>
#include <set>

#include "robot/robot_files.h"
#include "robot/xml_element.h"
#include "robot/yaml_text.h"
#include "spheretree/formats/errors.h"

namespace spheretree::robot {
namespace {

using tinyxml2::XMLDocument;

std::string centreText(const MetreSphere& s) { return decimal(s.x) + " " + decimal(s.y) + " " + decimal(s.z); }

/// Appends a new child.
XmlElement& add(tinyxml2::XMLNode& parent, const char* name) {
  return *parent.InsertEndChild(parent.GetDocument()->NewElement(name))->ToElement();
}

void set(XmlElement& element, const char* name, const std::string& value) { element.SetAttribute(name, value.c_str()); }

/// Changes mesh paths relative to the URDF into paths relative to the folder of the copy.
void moveMeshPaths(XmlElement& element, const std::filesystem::path& from, const std::filesystem::path& to) {
  const char* name =
      std::string(element.Name()) == "mesh" || std::string(element.Name()) == "texture" ? element.Attribute("filename") : nullptr;
  if (name && *name && std::string(name).find("://") == std::string::npos && !std::filesystem::path(name).is_absolute())
    set(element, "filename",
        std::filesystem::proximate(std::filesystem::absolute(from / name).lexically_normal(), std::filesystem::absolute(to)).string());
  for (XmlElement* child = element.FirstChildElement(); child; child = child->NextSiblingElement()) moveMeshPaths(*child, from, to);
}

const LinkCover* coverOf(const CoveredRobot& c, std::size_t link) {
  const auto found = std::find_if(c.cover.links.begin(), c.cover.links.end(), [&](const LinkCover& l) { return l.link == link; });
  return found == c.cover.links.end() ? nullptr : &*found;
}

const char* reasonText(PairReason reason) {
  return reason == PairReason::Adjacent ? "Adjacent" : reason == PairReason::Never ? "Never" : "Default";
}

std::string numbersText(std::initializer_list<double> values) {
  std::string out;
  for (const double value : values) out += (out.empty() ? "" : " ") + decimal(value);
  return out;
}

std::string text(const Eigen::Vector3d& v) { return numbersText({v.x(), v.y(), v.z()}); }

void setFrame(XmlElement& element, const Eigen::Isometry3d& frame) {
  const Eigen::Quaterniond q(frame.linear());
  set(element, "pos", text(frame.translation() / 1000));
  set(element, "quat", numbersText({q.w(), q.x(), q.y(), q.z()}));
}

/// One MuJoCo joint for each degree of freedom of a joint of the URDF.
void addJoints(XmlElement& body, const Joint& joint) {
  const auto one = [&](const std::string& name, const char* type, const Eigen::Vector3d& axis) -> XmlElement& {
    XmlElement& e = add(body, "joint");
    set(e, "name", name);
    set(e, "type", type);
    if (std::string(type) != "ball") set(e, "axis", text(axis));
    return e;
  };
  const double unit = joint.kind == JointKind::Prismatic ? 1000 : 1;
  if (joint.kind == JointKind::Revolute || joint.kind == JointKind::Prismatic) {
    XmlElement& e = one(joint.name, joint.kind == JointKind::Revolute ? "hinge" : "slide", joint.axis);
    set(e, "limited", joint.lower < joint.upper ? "true" : "false");  // for MuJoCo, a range of one value is no range
    if (joint.lower < joint.upper) set(e, "range", numbersText({joint.lower / unit, joint.upper / unit}));
  }
  if (joint.kind == JointKind::Continuous) one(joint.name, "hinge", joint.axis);
  if (joint.kind == JointKind::Planar) {
    const Eigen::Vector3d across = joint.axis.unitOrthogonal();
    one(joint.name + "_x", "slide", across);
    one(joint.name + "_y", "slide", joint.axis.cross(across));
    one(joint.name + "_turn", "hinge", joint.axis);
  }
  if (joint.kind == JointKind::Floating) {
    for (int axis = 0; axis < 3; ++axis) one(joint.name + "_" + "xyz"[axis], "slide", Eigen::Vector3d::Unit(axis));
    one(joint.name + "_turn", "ball", Eigen::Vector3d::Zero());
  }
}

void addBody(XmlElement& parent, const CoveredRobot& c, std::size_t link) {
  XmlElement& body = add(parent, "body");
  set(body, "name", c.robot.links[link].name);
  if (const auto j = c.robot.parent_joint[link]) {
    setFrame(body, c.robot.joints[*j].origin);
    addJoints(body, c.robot.joints[*j]);
  }
  if (const auto& inertia = c.robot.links[link].inertia; inertia && inertia->mass > 0) {
    XmlElement& e = add(body, "inertial");
    const Eigen::Matrix3d turned = inertia->origin.linear() * inertia->tensor * inertia->origin.linear().transpose();
    set(e, "pos", text(inertia->origin.translation() / 1000));
    set(e, "mass", decimal(inertia->mass));
    set(e, "fullinertia", numbersText({turned(0, 0), turned(1, 1), turned(2, 2), turned(0, 1), turned(0, 2), turned(1, 2)}));
  }
  if (const LinkCover* cover = coverOf(c, link))
    for (const MetreSphere& s : cover->spheres()) {
      XmlElement& geom = add(body, "geom");
      set(geom, "type", "sphere");
      set(geom, "size", decimal(s.radius));
      set(geom, "pos", centreText(s));
      set(geom, "mass", "0");  // masses of overlapping spheres would add up
    }
  for (const Joint& joint : c.robot.joints)
    if (joint.parent == link) addBody(body, c, joint.child);
}

}  // namespace

std::string sphereUrdf(const CoveredRobot& c, const std::filesystem::path& folder) {
  XMLDocument document;
  (void)readXml(c.robot.path, document);
  XmlElement& root = *document.RootElement();
  moveMeshPaths(root, std::filesystem::absolute(c.robot.path).parent_path(), folder);
  std::size_t index = 0;
  for (XmlElement* link = root.FirstChildElement("link"); link; link = link->NextSiblingElement("link"), ++index) {
    while (XmlElement* collision = link->FirstChildElement("collision")) link->DeleteChild(collision);
    const LinkCover* cover = coverOf(c, index);
    if (!cover) continue;
    for (const MetreSphere& s : cover->spheres()) {
      XmlElement& collision = add(*link, "collision");
      XmlElement& sphere = add(add(collision, "geometry"), "sphere");
      set(sphere, "radius", decimal(s.radius));
      XmlElement& origin = add(collision, "origin");
      set(origin, "xyz", centreText(s));
      set(origin, "rpy", "0 0 0");
    }
  }
  return xmlText(document);
}

std::string srdf(const CoveredRobot& c) {
  XMLDocument document;
  if (c.srdf.empty()) {
    document.InsertFirstChild(document.NewDeclaration());
    set(add(document, "robot"), "name", c.robot.name);
  } else if (std::string(readXml(c.srdf, document).Name()) != "robot") {
    throw formats::FormatError(c.srdf.string() + ": is not an SRDF: its root element should be <robot>.");
  }
  XmlElement& root = *document.RootElement();
  std::set<std::pair<std::string, std::string>> known;
  for (XmlElement* e = root.FirstChildElement("disable_collisions"); e; e = e->NextSiblingElement("disable_collisions")) {
    const std::string a = requiredText(c.srdf, *e, "link1"), b = requiredText(c.srdf, *e, "link2");
    known.insert(std::minmax(a, b));
  }
  for (XmlElement* e = root.FirstChildElement("link_sphere_approximation"); e;) {
    XmlElement* next = e->NextSiblingElement("link_sphere_approximation");
    root.DeleteChild(e);
    e = next;
  }
  for (const LinkCover& link : c.cover.links) {
    XmlElement& approximation = add(root, "link_sphere_approximation");
    set(approximation, "link", c.robot.links[link.link].name);
    for (const MetreSphere& s : link.spheres()) {
      XmlElement& sphere = add(approximation, "sphere");
      set(sphere, "center", centreText(s));
      set(sphere, "radius", decimal(s.radius));
    }
  }
  for (const IgnoredPair& pair : c.pairs) {
    const std::string &a = c.robot.links[pair.a].name, &b = c.robot.links[pair.b].name;
    if (known.contains(std::minmax(a, b))) continue;
    XmlElement& e = add(root, "disable_collisions");
    set(e, "link1", a);
    set(e, "link2", b);
    set(e, "reason", reasonText(pair.reason));
  }
  return xmlText(document);
}

std::string mjcf(const CoveredRobot& c) {
  XMLDocument document;
  XmlElement& root = add(document, "mujoco");
  set(root, "model", c.robot.name);
  XmlElement& compiler = add(root, "compiler");
  set(compiler, "angle", "radian");
  set(compiler, "balanceinertia", "true");
  // For links without an <inertial>, whose spheres have no mass.
  set(compiler, "boundmass", "0.001");
  set(compiler, "boundinertia", "0.000001");
  addBody(add(root, "worldbody"), c, c.robot.root);
  if (!c.pairs.empty()) {
    XmlElement& contact = add(root, "contact");
    for (const IgnoredPair& pair : c.pairs) {
      XmlElement& e = add(contact, "exclude");
      set(e, "body1", c.robot.links[pair.a].name);
      set(e, "body2", c.robot.links[pair.b].name);
    }
  }
  XmlElement* equality = nullptr;
  for (const Joint& joint : c.robot.joints) {
    if (!joint.mimic) continue;
    const auto of =
        std::find_if(c.robot.joints.begin(), c.robot.joints.end(), [&](const Joint& j) { return j.name == joint.mimic->joint; });
    const auto unit = [](const Joint& j) { return j.kind == JointKind::Prismatic ? 1000.0 : 1.0; };
    if (of->kind == JointKind::Fixed || of->kind == JointKind::Floating || of->kind == JointKind::Planar) continue;
    if (!equality) equality = &add(root, "equality");
    XmlElement& e = add(*equality, "joint");
    set(e, "joint1", joint.name);
    set(e, "joint2", joint.mimic->joint);
    set(e, "polycoef", numbersText({joint.mimic->offset / unit(joint), joint.mimic->factor * unit(*of) / unit(joint), 0, 0, 0}));
  }
  return xmlText(document);
}

}  // namespace spheretree::robot
