// SPDX-License-Identifier: GPL-3.0-or-later
#include "robot/robot_model.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <set>

#include "robot/xml_element.h"
#include "spheretree/formats/errors.h"

namespace spheretree::robot {
namespace {

namespace fs = std::filesystem;

constexpr double kMmPerMetre = 1000;

/// PATH below the first folder that is the package or contains it.
std::optional<fs::path> inPackage(const fs::path& folder, const fs::path& package, const fs::path& rest) {
  std::error_code none;
  for (const fs::path& candidate : {folder.filename() == package ? folder / rest : fs::path(), folder / package / rest})
    if (!candidate.empty() && fs::is_regular_file(candidate, none)) return candidate;
  return std::nullopt;
}

std::optional<fs::path> findInPackages(const fs::path& package, const fs::path& rest, const fs::path& urdf, const PackagePaths& packages) {
  for (const fs::path& folder : packages.folders)
    if (const auto found = inPackage(fs::absolute(folder).lexically_normal(), package, rest)) return found;
  for (fs::path above = fs::absolute(urdf).lexically_normal().parent_path();; above = above.parent_path()) {
    if (const auto found = inPackage(above, package, rest)) return found;
    if (above == above.parent_path()) break;
  }
  const char* list = std::getenv("ROS_PACKAGE_PATH");
  for (std::string left = list ? list : ""; !left.empty();) {
    const std::size_t end = left.find(':');
    if (const auto found = inPackage(left.substr(0, end), package, rest)) return found;
    left = end == std::string::npos ? "" : left.substr(end + 1);
  }
  return std::nullopt;
}

fs::path meshPath(const fs::path& urdf, const XmlElement& element, const std::string& name, const PackagePaths& packages) {
  std::error_code none;
  for (const std::string scheme : {"package://", "model://"}) {
    if (!name.starts_with(scheme)) continue;
    const std::string inside = name.substr(scheme.size());
    const std::size_t slash = inside.find('/');
    const fs::path package = inside.substr(0, slash);
    const fs::path rest = slash == std::string::npos ? "" : inside.substr(slash + 1);
    const auto found = findInPackages(package, rest, urdf, packages);
    if (found) return *found;
    throw formats::FileError(
        urdf.string() + ":" + std::to_string(element.GetLineNum()) + ": " + name + " is in no folder above the file, in none of " +
        "ROS_PACKAGE_PATH and of --package. Name the folder that holds the package " + package.string() + ": --package FOLDER.");
  }
  const fs::path plain = name.starts_with("file://") ? fs::path(name.substr(7)) : fs::path(name);
  const fs::path path = plain.is_absolute() ? plain : urdf.parent_path() / plain;
  if (!fs::is_regular_file(path, none))
    throw formats::FileError(urdf.string() + ":" + std::to_string(element.GetLineNum()) + ": the mesh " + path.string() +
                             " does not exist.");
  return path;
}

double positive(const fs::path& path, const XmlElement& element, const char* attribute) {
  const double value = requiredNumber(path, element, attribute);
  if (!(value > 0)) refuse(path, element, std::string(attribute) + " must be above 0.");
  return kMmPerMetre * value;
}

/// Reads one URDF.
class Reader {
 public:
  Reader(const fs::path& path, const PackagePaths& packages) : path_(path), packages_(packages) {}

  Robot read() {
    tinyxml2::XMLDocument document;
    const XmlElement& root = readXml(path_, document);
    if (root.FindAttribute("xmlns:xacro")) refuseIfXacro(root);
    if (std::string(root.Name()) != "robot") refuse(path_, root, "is not a URDF: its root element should be <robot>.");
    robot_.path = path_;
    robot_.name = requiredText(path_, root, "name");
    for (const XmlElement* e = root.FirstChildElement("link"); e; e = e->NextSiblingElement("link")) robot_.links.push_back(link(*e));
    for (const XmlElement* e = root.FirstChildElement("joint"); e; e = e->NextSiblingElement("joint")) joint(*e);
    if (robot_.links.empty()) refuse(path_, root, "has no <link>.");
    findRoot(root);
    checkMimics(root);
    return std::move(robot_);
  }

 private:
  void refuseIfXacro(const XmlElement& element) const {
    if (std::string(element.Name()).starts_with("xacro:"))
      refuse(path_, element, "is xacro, which has to be expanded first: xacro " + path_.string() + " > robot.urdf");
    for (const XmlElement* child = element.FirstChildElement(); child; child = child->NextSiblingElement()) refuseIfXacro(*child);
  }

  std::variant<Box, Cylinder, Ball, MeshFile> shape(const XmlElement& collision) const {
    const XmlElement* geometry = collision.FirstChildElement("geometry");
    if (!geometry) refuse(path_, collision, "needs a <geometry>.");
    const XmlElement* e = geometry->FirstChildElement();
    if (!e) refuse(path_, *geometry, "is empty.");
    const std::string kind = e->Name();
    if (kind == "box") {
      const std::vector<double> size = numbers(path_, *e, "size", 3);
      if (size.empty() || !(*std::min_element(size.begin(), size.end()) > 0)) refuse(path_, *e, "needs a size of three numbers above 0.");
      return Box{kMmPerMetre * Eigen::Vector3d(size[0], size[1], size[2])};
    }
    if (kind == "cylinder") return Cylinder{positive(path_, *e, "radius"), positive(path_, *e, "length")};
    if (kind == "sphere") return Ball{positive(path_, *e, "radius")};
    if (kind != "mesh") refuse(path_, *e, "is not a supported shape: box, cylinder, sphere or mesh.");
    MeshFile mesh;
    mesh.name = requiredText(path_, *e, "filename");
    mesh.path = meshPath(path_, *e, mesh.name, packages_);
    const std::vector<double> scale = numbers(path_, *e, "scale", 3);
    mesh.scale = scale.empty() ? Eigen::Vector3d(1, 1, 1) : Eigen::Vector3d(scale[0], scale[1], scale[2]);
    if (!(mesh.scale.cwiseAbs().minCoeff() > 0)) refuse(path_, *e, "a scale must not be 0.");
    return mesh;
  }

  Link link(const XmlElement& e) {
    Link out;
    out.name = requiredText(path_, e, "name");
    if (!index_.emplace(out.name, robot_.links.size()).second) refuse(path_, e, "there are two links named " + out.name + ".");
    for (const XmlElement* c = e.FirstChildElement("collision"); c; c = c->NextSiblingElement("collision")) {
      const char* name = c->Attribute("name");
      out.collisions.push_back({name ? name : "", originOf(path_, *c), shape(*c)});
    }
    if (const XmlElement* inertial = e.FirstChildElement("inertial")) out.inertia = inertia(*inertial);
    return out;
  }

  Inertia inertia(const XmlElement& e) const {
    Inertia out;
    out.origin = originOf(path_, e);
    if (const XmlElement* mass = e.FirstChildElement("mass")) out.mass = requiredNumber(path_, *mass, "value");
    if (const XmlElement* tensor = e.FirstChildElement("inertia")) {
      const auto at = [&](const char* name) { return optionalNumber(path_, *tensor, name).value_or(0); };
      const double xy = at("ixy"), xz = at("ixz"), yz = at("iyz");
      out.tensor << at("ixx"), xy, xz, xy, at("iyy"), yz, xz, yz, at("izz");
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

  void limits(const XmlElement& e, Joint& joint) const {
    const XmlElement* limit = e.FirstChildElement("limit");
    const double unit = joint.kind == JointKind::Prismatic ? kMmPerMetre : 1;
    const bool is_bounded = joint.kind == JointKind::Revolute || joint.kind == JointKind::Prismatic;
    if (!limit) {
      if (is_bounded) refuse(path_, e, "a joint of this type needs a <limit>.");
      return;
    }
    joint.velocity = unit * std::abs(optionalNumber(path_, *limit, "velocity").value_or(0));
    joint.effort = std::abs(optionalNumber(path_, *limit, "effort").value_or(0));
    if (!is_bounded) return;
    joint.lower = unit * optionalNumber(path_, *limit, "lower").value_or(0);
    joint.upper = unit * optionalNumber(path_, *limit, "upper").value_or(0);
    if (joint.lower > joint.upper) refuse(path_, *limit, "lower is above upper.");
  }

  void joint(const XmlElement& e) {
    static const std::map<std::string, JointKind> kKinds{{"fixed", JointKind::Fixed},           {"revolute", JointKind::Revolute},
                                                         {"continuous", JointKind::Continuous}, {"prismatic", JointKind::Prismatic},
                                                         {"floating", JointKind::Floating},     {"planar", JointKind::Planar}};
    Joint out;
    out.name = requiredText(path_, e, "name");
    if (!joint_names_.insert(out.name).second) refuse(path_, e, "there are two joints named " + out.name + ".");
    const std::string kind = requiredText(path_, e, "type");
    if (!kKinds.contains(kind)) refuse(path_, e, "the type " + kind + " is not one of a URDF.");
    out.kind = kKinds.at(kind);
    out.parent = linkOf(e, "parent");
    out.child = linkOf(e, "child");
    out.origin = originOf(path_, e);
    if (const XmlElement* axis = e.FirstChildElement("axis"))
      if (const std::vector<double> xyz = numbers(path_, *axis, "xyz", 3); !xyz.empty()) {
        out.axis = Eigen::Vector3d(xyz[0], xyz[1], xyz[2]);
        if (!(out.axis.norm() > 0)) refuse(path_, *axis, "an axis needs a direction.");
        out.axis.normalize();
      }
    limits(e, out);
    if (const XmlElement* mimic = e.FirstChildElement("mimic")) {
      const double unit = out.kind == JointKind::Prismatic ? kMmPerMetre : 1;
      out.mimic = Mimic{requiredText(path_, *mimic, "joint"), optionalNumber(path_, *mimic, "multiplier").value_or(1),
                        unit * optionalNumber(path_, *mimic, "offset").value_or(0)};
    }
    robot_.joints.push_back(std::move(out));
  }

  void findRoot(const XmlElement& root) {
    robot_.parent_joint.resize(robot_.links.size());
    for (std::size_t j = 0; j < robot_.joints.size(); ++j) {
      auto& parent = robot_.parent_joint[robot_.joints[j].child];
      if (parent)
        refuse(path_, root, "the link " + robot_.links[robot_.joints[j].child].name + " has two parents. A robot must be a tree.");
      parent = j;
    }
    std::vector<std::size_t> roots;
    for (std::size_t l = 0; l < robot_.links.size(); ++l)
      if (!robot_.parent_joint[l]) roots.push_back(l);
    if (roots.size() != 1)
      refuse(path_, root,
             roots.empty() ? "its joints run in a circle. A robot must be a tree."
                           : "the links " + robot_.links[roots[0]].name + " and " + robot_.links[roots[1]].name +
                                 " both have no parent. A robot must be one tree.");
    robot_.root = roots[0];
    for (std::size_t l = 0; l < robot_.links.size(); ++l) {  // checks that every link is a descendant of the root
      std::size_t at = l, steps = 0;
      while (robot_.parent_joint[at] && steps++ <= robot_.links.size()) at = robot_.joints[*robot_.parent_joint[at]].parent;
      if (at != robot_.root)
        refuse(path_, root, "the joints about the link " + robot_.links[l].name + " run in a circle. A robot must be a tree.");
    }
  }

  void checkMimics(const XmlElement& root) {
    for (Joint& joint : robot_.joints) {
      if (!joint.mimic) continue;
      const auto of =
          std::find_if(robot_.joints.begin(), robot_.joints.end(), [&](const Joint& j) { return j.name == joint.mimic->joint; });
      if (of == robot_.joints.end()) refuse(path_, root, joint.name + " mimics " + joint.mimic->joint + ", and there is no such joint.");
      if (of->mimic) refuse(path_, root, joint.name + " mimics " + of->name + ", which itself mimics another joint.");
      // The factor in a URDF is in metres and radians.
      if (joint.kind == JointKind::Prismatic && of->kind != JointKind::Prismatic) joint.mimic->factor *= kMmPerMetre;
      if (joint.kind != JointKind::Prismatic && of->kind == JointKind::Prismatic) joint.mimic->factor /= kMmPerMetre;
      const bool turns = joint.kind == JointKind::Revolute || joint.kind == JointKind::Continuous || joint.kind == JointKind::Prismatic;
      if (!turns) refuse(path_, root, joint.name + " mimics a joint, but its type has no single position.");
    }
  }

  const fs::path& path_;
  const PackagePaths& packages_;
  Robot robot_;
  std::map<std::string, std::size_t> index_;
  std::set<std::string> joint_names_;
};

}  // namespace

std::size_t Robot::linkNamed(const std::string& wanted) const {
  for (std::size_t l = 0; l < links.size(); ++l)
    if (links[l].name == wanted) return l;
  throw std::out_of_range("no link is named " + wanted);
}

Robot readUrdf(const std::filesystem::path& path, const PackagePaths& packages) { return Reader(path, packages).read(); }

Eigen::Isometry3d jointFrame(const Joint& joint, double position) {
  Eigen::Isometry3d frame = joint.origin;
  if (joint.kind == JointKind::Revolute || joint.kind == JointKind::Continuous) frame.rotate(Eigen::AngleAxisd(position, joint.axis));
  if (joint.kind == JointKind::Prismatic) frame.translate(position * joint.axis);
  return frame;
}

std::vector<Eigen::Isometry3d> linkFrames(const Robot& robot, const std::vector<double>& positions) {
  const auto positionOf = [&](std::size_t j) {
    const Joint& joint = robot.joints[j];
    if (!joint.mimic) return positions[j];
    const auto of =
        std::find_if(robot.joints.begin(), robot.joints.end(), [&](const Joint& other) { return other.name == joint.mimic->joint; });
    return joint.mimic->factor * positions[static_cast<std::size_t>(of - robot.joints.begin())] + joint.mimic->offset;
  };
  std::vector<Eigen::Isometry3d> frames(robot.links.size(), Eigen::Isometry3d::Identity());
  std::vector<bool> is_known(robot.links.size());
  is_known[robot.root] = true;
  for (std::size_t l = 0; l < robot.links.size(); ++l) {
    std::vector<std::size_t> chain;  // from the link up to a known one
    for (std::size_t at = l; !is_known[at]; at = robot.joints[*robot.parent_joint[at]].parent) chain.push_back(at);
    for (auto at = chain.rbegin(); at != chain.rend(); ++at) {
      const std::size_t j = *robot.parent_joint[*at];
      frames[*at] = frames[robot.joints[j].parent] * jointFrame(robot.joints[j], positionOf(j));
      is_known[*at] = true;
    }
  }
  return frames;
}

}  // namespace spheretree::robot
