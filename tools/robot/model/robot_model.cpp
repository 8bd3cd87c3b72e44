// SPDX-License-Identifier: GPL-3.0-or-later
#include "robot/model/robot_model.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "robot/text/xml_element.h"
#include "spheretree/formats/errors.h"

namespace spheretree::robot {
namespace {

namespace fs = std::filesystem;

constexpr double kMmPerMetre = 1000;

/// [mm]
double lengthOf(const fs::path& path, const XmlElement& element, const char* attribute) {
  const double value = requiredNumber(path, element, attribute);
  if (!(value >= 0)) refuse(path, element, std::string(attribute) + " must not be negative.");
  return kMmPerMetre * value;
}

bool hasPosition(JointKind kind) { return kind == JointKind::Revolute || kind == JointKind::Continuous || kind == JointKind::Prismatic; }

/// Reads one URDF.
class Reader {
 public:
  Reader(const fs::path& path, const PackagePaths& packages, ShapeSource source)
      : path_(path), packages_(packages), meshes_(path, packages), source_(source) {}

  Robot read() {
    tinyxml2::XMLDocument document;
    const XmlElement& root = readXml(path_, document, "a URDF");
    if (root.FindAttribute("xmlns:xacro")) refuseIfXacro(root);
    if (std::string(root.Name()) != "robot") refuse(path_, root, "is not a URDF: its root element should be <robot>.");
    robot_.path = path_;
    robot_.source = source_;
    robot_.packages = packages_;
    const char* name = root.Attribute("name");
    robot_.name = name && *name ? name : path_.stem().string();
    if (!name || !*name) note(root, "has no name; it is called " + robot_.name + ", as the file");
    for (const XmlElement* e = root.FirstChildElement("link"); e; e = e->NextSiblingElement("link")) robot_.links.push_back(link(*e));
    for (const XmlElement* e = root.FirstChildElement("joint"); e; e = e->NextSiblingElement("joint")) joint(*e);
    if (robot_.links.empty()) refuse(path_, root, "has no <link>.");
    findRoot();
    resolveMimics();
    robot_.notes.insert(robot_.notes.end(), meshes_.notes().begin(), meshes_.notes().end());
    return std::move(robot_);
  }

 private:
  void note(const XmlElement& element, const std::string& what) { robot_.notes.push_back(placeOf(path_, element) + ": " + what + "."); }

  void refuseIfXacro(const XmlElement& element) const {
    if (std::string(element.Name()).starts_with("xacro:"))
      refuse(path_, element, "is xacro, which has to be expanded first: xacro " + path_.string() + " > robot.urdf");
    for (const XmlElement* child = element.FirstChildElement(); child; child = child->NextSiblingElement()) refuseIfXacro(*child);
  }

  CollisionElement element(const XmlElement& e) {
    CollisionElement out;
    const char* name = e.Attribute("name");
    out.name = name ? name : "";
    out.place = placeOf(path_, e);
    out.origin = originOf(path_, e);
    const XmlElement* geometry = e.FirstChildElement("geometry");
    const XmlElement* shape = geometry ? geometry->FirstChildElement() : nullptr;
    if (!shape) return out;
    out.place = placeOf(path_, *shape);
    const std::string kind = shape->Name();
    if (kind == "box") {
      const std::vector<double> size = numbers(path_, *shape, "size", 3);
      if (size.empty() || !(*std::min_element(size.begin(), size.end()) >= 0))
        refuse(path_, *shape, "needs a size of three numbers that are not negative.");
      out.shape = Box{kMmPerMetre * Eigen::Vector3d(size[0], size[1], size[2])};
    } else if (kind == "cylinder") {
      out.shape = Cylinder{lengthOf(path_, *shape, "radius"), lengthOf(path_, *shape, "length")};
    } else if (kind == "capsule") {
      out.shape = Capsule{lengthOf(path_, *shape, "radius"), lengthOf(path_, *shape, "length")};
    } else if (kind == "sphere") {
      out.shape = Capsule{lengthOf(path_, *shape, "radius"), 0};
    } else if (kind == "mesh") {
      out.shape = mesh(*shape);
    } else {
      refuse(path_, *shape, "is not a supported shape: box, capsule, cylinder, mesh or sphere.");
    }
    return out;
  }

  MeshFile mesh(const XmlElement& e) {
    MeshFile out;
    const char* name = e.Attribute("filename");
    if (!name) refuse(path_, e, "needs the attribute filename.");
    out.name = name;
    if (!out.name.empty()) out.path = meshes_.find(out.name, placeOf(path_, e));
    const std::vector<double> scale = numbers(path_, e, "scale", 3);
    out.scale = scale.empty() ? Eigen::Vector3d(1, 1, 1) : Eigen::Vector3d(scale[0], scale[1], scale[2]);
    return out;
  }

  Link link(const XmlElement& e) {
    Link out;
    out.name = requiredText(path_, e, "name");
    out.place = placeOf(path_, e);
    if (!index_.emplace(out.name, robot_.links.size()).second) refuse(path_, e, "there are two links named " + out.name + ".");
    const bool is_visual = source_ == ShapeSource::Visual;
    const char* wanted = is_visual ? "visual" : "collision";
    for (const XmlElement* c = e.FirstChildElement(wanted); c; c = c->NextSiblingElement(wanted)) out.collisions.push_back(element(*c));
    robot_.links_with_other_shapes += e.FirstChildElement(is_visual ? "collision" : "visual") != nullptr;
    if (const XmlElement* inertial = e.FirstChildElement("inertial")) out.inertia = inertia(*inertial);
    return out;
  }

  Inertia inertia(const XmlElement& e) const {
    Inertia out;
    out.origin = originOf(path_, e);
    if (const XmlElement* mass = e.FirstChildElement("mass")) out.mass = optionalNumber(path_, *mass, "value").value_or(0);
    if (const XmlElement* tensor = e.FirstChildElement("inertia")) {
      const auto at = [&](const char* name) { return optionalNumber(path_, *tensor, name).value_or(0); };
      const double xx = at("ixx"), yy = at("iyy"), zz = at("izz"), xy = at("ixy"), xz = at("ixz"), yz = at("iyz");
      out.tensor << xx, xy, xz, xy, yy, yz, xz, yz, zz;
    }
    return out;
  }

  std::size_t linkOf(const XmlElement& joint_element, const char* which) const {
    const XmlElement* e = joint_element.FirstChildElement(which);
    if (!e) refuse(path_, joint_element, std::string("needs a <") + which + ">.");
    const auto found = index_.find(requiredText(path_, *e, "link"));
    if (found == index_.end()) refuse(path_, *e, std::string("there is no link named ") + e->Attribute("link") + ".");
    return found->second;
  }

  void limits(const XmlElement& e, Joint& joint) {
    if (joint.kind != JointKind::Revolute && joint.kind != JointKind::Prismatic) return;
    const XmlElement* limit = e.FirstChildElement("limit");
    if (!limit) refuse(path_, e, "a joint of this type needs a <limit>.");
    const double unit = joint.kind == JointKind::Prismatic ? kMmPerMetre : 1;
    joint.lower = unit * optionalNumber(path_, *limit, "lower").value_or(0);
    joint.upper = unit * optionalNumber(path_, *limit, "upper").value_or(0);
    if (joint.lower > joint.upper) {
      std::swap(joint.lower, joint.upper);
      note(*limit, "lower is above upper; they are taken the other way round");
    } else if (joint.lower == joint.upper) {
      note(*limit, "lower and upper are equal, so that the joint is taken as one that does not move");
    }
  }

  void axis(const XmlElement& e, Joint& joint) const {
    if (joint.kind == JointKind::Fixed || joint.kind == JointKind::Floating) return;
    const XmlElement* axis = e.FirstChildElement("axis");
    const std::vector<double> xyz = axis ? numbers(path_, *axis, "xyz", 3) : std::vector<double>();
    if (xyz.empty()) return;
    const Eigen::Vector3d direction(xyz[0], xyz[1], xyz[2]);
    const double length = direction.stableNorm();
    if (!(length > 0)) refuse(path_, *axis, "the axis of a joint that moves needs a direction, and this one is 0 0 0.");
    joint.axis = (direction / length).normalized();
  }

  void mimic(const XmlElement& e) {
    const XmlElement* mimic = e.FirstChildElement("mimic");
    if (!mimic) return;
    mimics_[robot_.joints.size()] = {requiredText(path_, *mimic, "joint"), optionalNumber(path_, *mimic, "multiplier").value_or(1),
                                     optionalNumber(path_, *mimic, "offset").value_or(0), placeOf(path_, *mimic)};
  }

  void joint(const XmlElement& e) {
    static const std::map<std::string, JointKind> kKinds{{"fixed", JointKind::Fixed},           {"revolute", JointKind::Revolute},
                                                         {"continuous", JointKind::Continuous}, {"prismatic", JointKind::Prismatic},
                                                         {"floating", JointKind::Floating},     {"planar", JointKind::Planar}};
    Joint out;
    out.name = requiredText(path_, e, "name");
    out.place = placeOf(path_, e);
    if (!joint_index_.emplace(out.name, robot_.joints.size()).second) refuse(path_, e, "there are two joints named " + out.name + ".");
    const std::string kind = requiredText(path_, e, "type");
    if (!kKinds.contains(kind)) refuse(path_, e, "the type " + kind + " is not one of a URDF.");
    out.kind = kKinds.at(kind);
    out.parent = linkOf(e, "parent");
    out.child = linkOf(e, "child");
    out.origin = originOf(path_, e);
    axis(e, out);
    limits(e, out);
    if (hasPosition(out.kind)) mimic(e);
    robot_.joints.push_back(std::move(out));
  }

  [[noreturn]] static void refuseTree(const std::string& place, const std::string& what) {
    throw formats::FormatError(place + ": " + what + " A robot must be one tree of links.");
  }

  void findRoot() {
    robot_.parent_joint.resize(robot_.links.size());
    for (std::size_t j = 0; j < robot_.joints.size(); ++j) {
      const Joint& joint = robot_.joints[j];
      auto& parent = robot_.parent_joint[joint.child];
      if (parent)
        refuseTree(joint.place,
                   "the link " + robot_.links[joint.child].name + " already hangs on the joint " + robot_.joints[*parent].name + ".");
      parent = j;
    }
    std::vector<std::size_t> roots;
    for (std::size_t l = 0; l < robot_.links.size(); ++l)
      if (!robot_.parent_joint[l]) roots.push_back(l);
    if (roots.size() > 1)
      refuseTree(robot_.links[roots[1]].place, "neither this link nor the link " + robot_.links[roots[0]].name + " has a parent.");
    robot_.root = roots.empty() ? robot_.links.size() : roots[0];
    for (const Link& link : robot_.links) {  // checks that every link is a descendant of the root
      std::size_t at = index_.at(link.name), steps = 0;
      while (robot_.parent_joint[at] && steps++ <= robot_.links.size()) at = robot_.joints[*robot_.parent_joint[at]].parent;
      if (at != robot_.root) refuseTree(link.place, "the joints from it to its root run in a circle.");
    }
  }

  /// The end of the chain of mimicking joints that begins at `joint`, with factor and offset in the units of the URDF;
  /// empty if the chain ends at no joint that has a position.
  std::optional<Mimic> followed(std::size_t joint) const {
    Mimic out{joint, 1, 0};
    for (std::size_t steps = 0; steps <= mimics_.size(); ++steps) {
      const auto at = mimics_.find(out.joint);
      if (at == mimics_.end()) return out;
      const auto next = joint_index_.find(at->second.joint);
      if (next == joint_index_.end() || !hasPosition(robot_.joints[next->second].kind)) return std::nullopt;
      out = {next->second, out.factor * at->second.factor, out.factor * at->second.offset + out.offset};
    }
    return std::nullopt;
  }

  /// Chains become mimics of their last joint, in mm and rad. A mimic of nothing makes an independent joint.
  void resolveMimics() {
    const auto unit = [](const Joint& joint) { return joint.kind == JointKind::Prismatic ? kMmPerMetre : 1; };
    for (const auto& [j, named] : mimics_) {
      Joint& joint = robot_.joints[j];
      joint.mimic = followed(j);
      if (!joint.mimic) {
        robot_.notes.push_back(named.place + ": it cannot follow " + named.joint + ", and is taken as an independent joint.");
        continue;
      }
      joint.mimic->factor *= unit(joint) / unit(robot_.joints[joint.mimic->joint]);
      joint.mimic->offset *= unit(joint);
    }
  }

  struct NamedMimic {
    std::string joint;
    double factor, offset;  // in the units of the URDF
    std::string place;
  };

  const fs::path& path_;
  const PackagePaths& packages_;
  MeshSearch meshes_;
  const ShapeSource source_;
  Robot robot_;
  std::map<std::string, std::size_t> index_;
  std::map<std::string, std::size_t> joint_index_;
  std::map<std::size_t, NamedMimic> mimics_;  // by joint
};

}  // namespace

Robot readUrdf(const std::filesystem::path& path, const PackagePaths& packages, ShapeSource source) {
  return Reader(path, packages, source).read();
}

Eigen::Isometry3d jointFrame(const Joint& joint, double position) {
  Eigen::Isometry3d frame = joint.origin;
  if (joint.kind == JointKind::Revolute || joint.kind == JointKind::Continuous) frame.rotate(Eigen::AngleAxisd(position, joint.axis));
  if (joint.kind == JointKind::Prismatic) frame.translate(position * joint.axis);
  return frame;
}

std::vector<Eigen::Isometry3d> zeroPose(const Robot& robot) {
  std::vector<Eigen::Isometry3d> frames(robot.links.size(), Eigen::Isometry3d::Identity());
  for (std::size_t l = 0; l < frames.size(); ++l)
    for (std::size_t at = l; robot.parent_joint[at]; at = robot.joints[*robot.parent_joint[at]].parent) {
      const Joint& joint = robot.joints[*robot.parent_joint[at]];
      frames[l] = jointFrame(joint, joint.mimic ? joint.mimic->offset : 0) * frames[l];
    }
  return frames;
}

}  // namespace spheretree::robot
