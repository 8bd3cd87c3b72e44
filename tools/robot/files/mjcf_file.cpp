// SPDX-License-Identifier: GPL-3.0-or-later
// MJCF: bodies, joints, inertias, excluded pairs.
#include <set>

#include "robot/cover/body_inertia.h"
#include "robot/files/robot_files.h"
#include "robot/text/xml_element.h"
#include "robot/text/yaml_text.h"

namespace spheretree::robot {
namespace {

std::string numbersText(std::initializer_list<double> values) {
  std::string out;
  for (const double value : values) out += (out.empty() ? "" : " ") + decimal(value);
  return out;
}

std::string text(const Eigen::Vector3d& v) { return numbersText({v.x(), v.y(), v.z()}); }

void setFrame(XmlElement& element, const Eigen::Isometry3d& frame) {
  const Eigen::Quaterniond q(frame.linear());
  setText(element, "pos", text(frame.translation() / 1000));
  setText(element, "quat", numbersText({q.w(), q.x(), q.y(), q.z()}));
}

class MjcfWriter {
 public:
  MjcfWriter(const CoveredRobot& covered, std::vector<std::string>& notes) : c_(covered), notes_(notes) {
    std::set<std::string> bodies{"world"};  // the name of the fixed frame
    for (const Link& link : c_.robot.links)
      if (link.name != "world") bodies.insert(link.name);
    for (const Link& link : c_.robot.links) {
      body_names_.push_back(link.name == "world" ? unused("world", bodies) : link.name);
      if (link.name == "world")
        notes_.push_back(link.place + " is called " + body_names_.back() + " in the MJCF, where world is the fixed frame.");
    }
    for (const Joint& joint : c_.robot.joints) joint_names_.insert(joint.name);
  }

  std::string write() {
    tinyxml2::XMLDocument document;
    XmlElement& root = addElement(document, "mujoco");
    setText(root, "model", c_.robot.name);
    XmlElement& compiler = addElement(root, "compiler");
    setText(compiler, "angle", "radian");
    setText(compiler, "inertiafromgeom", "false");  // MuJoCo refuses bodies whose geoms, several of them, have no mass
    addBody(addElement(root, "worldbody"), c_.robot.root);
    if (!c_.pairs.empty()) {
      XmlElement& contact = addElement(root, "contact");
      for (const IgnoredPair& pair : c_.pairs) {
        XmlElement& e = addElement(contact, "exclude");
        setText(e, "body1", body_names_[pair.a]);
        setText(e, "body2", body_names_[pair.b]);
      }
    }
    addMimics(root);
    return xmlText(document);
  }

 private:
  /// `name` with underscores until no other has it.
  static std::string unused(std::string name, std::set<std::string>& names) {
    while (!names.insert(name).second) name += "_";
    return name;
  }

  /// One MuJoCo joint for each degree of freedom of a joint of the URDF.
  void addJoints(XmlElement& body, const Joint& joint) {
    const auto one = [&](const std::string& name, const char* type, const Eigen::Vector3d& axis) -> XmlElement& {
      XmlElement& e = addElement(body, "joint");
      setText(e, "name", name);
      setText(e, "type", type);
      if (std::string(type) != "ball") setText(e, "axis", text(axis));
      return e;
    };
    const auto part = [&](const std::string& of) { return unused(joint.name + of, joint_names_); };
    const double unit = joint.kind == JointKind::Prismatic ? 1000 : 1;
    if (joint.kind == JointKind::Revolute || joint.kind == JointKind::Prismatic) {
      XmlElement& e = one(joint.name, joint.kind == JointKind::Revolute ? "hinge" : "slide", joint.axis);
      setText(e, "limited", joint.lower < joint.upper ? "true" : "false");  // for MuJoCo, a range of one value is no range
      if (joint.lower < joint.upper) setText(e, "range", numbersText({joint.lower / unit, joint.upper / unit}));
    }
    if (joint.kind == JointKind::Continuous) one(joint.name, "hinge", joint.axis);
    if (joint.kind == JointKind::Planar) {
      const Eigen::Vector3d across = joint.axis.unitOrthogonal();
      one(part("_x"), "slide", across);
      one(part("_y"), "slide", joint.axis.cross(across));
      one(part("_turn"), "hinge", joint.axis);
    }
    if (joint.kind == JointKind::Floating) {
      for (int axis = 0; axis < 3; ++axis) one(part(std::string("_") + "xyz"[axis]), "slide", Eigen::Vector3d::Unit(axis));
      one(part("_turn"), "ball", Eigen::Vector3d::Zero());
    }
  }

  void addInertia(XmlElement& body, std::size_t link, std::span<const MetreSphere> spheres) {
    const auto joint = c_.robot.parent_joint[link];
    const bool is_moved = joint && c_.robot.joints[*joint].kind != JointKind::Fixed;
    const std::optional<BodyInertia> inertia = bodyInertia(c_.robot.links[link], is_moved, spheres);
    if (!inertia) return;
    if (!inertia->change.empty()) notes_.push_back(c_.robot.links[link].place + " " + inertia->change + ".");
    const Eigen::Matrix3d& t = inertia->tensor;
    XmlElement& e = addElement(body, "inertial");
    setText(e, "pos", text(inertia->centre / 1000));
    setText(e, "mass", decimal(inertia->mass));
    setText(e, "fullinertia", numbersText({t(0, 0), t(1, 1), t(2, 2), t(0, 1), t(0, 2), t(1, 2)}));
  }

  void addBody(XmlElement& parent, std::size_t link) {
    XmlElement& body = addElement(parent, "body");
    setText(body, "name", body_names_[link]);
    if (const auto j = c_.robot.parent_joint[link]) {
      setFrame(body, c_.robot.joints[*j].origin);
      addJoints(body, c_.robot.joints[*j]);
    }
    const LinkCover* cover = c_.cover.of(link);
    const std::span<const MetreSphere> spheres = cover ? std::span(cover->spheres()) : std::span<const MetreSphere>();
    addInertia(body, link, spheres);
    for (const MetreSphere& s : spheres) {
      XmlElement& geom = addElement(body, "geom");
      setText(geom, "type", "sphere");
      setText(geom, "size", decimal(s.radius));
      setText(geom, "pos", centreText(s));
      setText(geom, "mass", "0");  // masses of overlapping spheres would add up
    }
    for (const Joint& joint : c_.robot.joints)
      if (joint.parent == link) addBody(body, joint.child);
  }

  void addMimics(XmlElement& root) {
    XmlElement* equality = nullptr;
    const auto unit = [](const Joint& j) { return j.kind == JointKind::Prismatic ? 1000.0 : 1.0; };
    for (const Joint& joint : c_.robot.joints) {
      if (!joint.mimic) continue;
      const Joint& of = c_.robot.joints[joint.mimic->joint];
      if (!equality) equality = &addElement(root, "equality");
      XmlElement& e = addElement(*equality, "joint");
      setText(e, "joint1", joint.name);
      setText(e, "joint2", of.name);
      setText(e, "polycoef", numbersText({joint.mimic->offset / unit(joint), joint.mimic->factor * unit(of) / unit(joint), 0, 0, 0}));
    }
  }

  const CoveredRobot& c_;
  std::vector<std::string>& notes_;
  std::vector<std::string> body_names_;  // (links)
  std::set<std::string> joint_names_;
};

}  // namespace

std::string mjcf(const CoveredRobot& covered, std::vector<std::string>& notes) { return MjcfWriter(covered, notes).write(); }

}  // namespace spheretree::robot
