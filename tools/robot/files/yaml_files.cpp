// SPDX-License-Identifier: GPL-3.0-or-later
// cuRobo and XRDF.
#include <algorithm>
#include <map>

#include "robot/files/robot_files.h"
#include "robot/text/yaml_text.h"
#include "run_files.h"
#include "spheretree/formats/errors.h"

namespace spheretree::robot {
namespace {

using YAML::Node;

bool isXrdf(const std::filesystem::path& path) { return tool::endingOf(path) == ".xrdf"; }

const std::string& linkName(const CoveredRobot& c, const LinkCover& link) { return c.robot.links[link.link].name; }

Node sphereMap(const CoveredRobot& c) {
  Node out(YAML::NodeType::Map);
  for (const LinkCover& link : c.cover.links) {
    Node list(YAML::NodeType::Sequence);
    for (const MetreSphere& s : link.spheres()) {
      Node sphere(YAML::NodeType::Map);
      for (const float x : {s.x, s.y, s.z}) sphere["center"].push_back(Node(decimal(x)));
      sphere["radius"] = Node(decimal(s.radius));
      list.push_back(sphere);
    }
    out[linkName(c, link)] = list;
  }
  return out;
}

/// One direction suffices.
Node ignoreMap(const CoveredRobot& c) {
  Node out(YAML::NodeType::Map);
  for (const IgnoredPair& pair : c.pairs) out[c.robot.links[pair.a].name].push_back(textNode(c.robot.links[pair.b].name));
  return out;
}

/// Joints that planners move, in the order of the file, without those that mimic another.
std::vector<const Joint*> movedJoints(const Robot& robot) {
  std::vector<const Joint*> out;
  for (const Joint& joint : robot.joints)
    if (!joint.mimic && (joint.kind == JointKind::Revolute || joint.kind == JointKind::Continuous || joint.kind == JointKind::Prismatic))
      out.push_back(&joint);
  return out;
}

/// 0 or, if the limits exclude 0, their middle; in rad or m.
double restPosition(const Joint& joint) {
  if (joint.kind == JointKind::Continuous || (joint.lower <= 0 && joint.upper >= 0)) return 0;
  return (joint.lower + joint.upper) / 2 / (joint.kind == JointKind::Prismatic ? 1000 : 1);
}

/// Links without a child: grippers, flanges.
Node toolFrames(const Robot& robot) {
  Node out(YAML::NodeType::Sequence);
  for (std::size_t l = 0; l < robot.links.size(); ++l)
    if (std::none_of(robot.joints.begin(), robot.joints.end(), [&](const Joint& j) { return j.parent == l; }))
      out.push_back(textNode(robot.links[l].name));
  return out;
}

/// The joint data of a file to merge, in either of the two formats.
struct Merged {
  Node joint_names, acceleration, jerk, tool_frames;
  std::map<std::string, Node> rest;  // position of each joint
};

Merged mergedFrom(const Node& root, bool is_xrdf) {
  Merged out;
  const Node kinematics = is_xrdf ? root : root["robot_cfg"]["kinematics"];
  const Node cspace = kinematics["cspace"];
  if (!cspace) return out;
  out.joint_names = cspace["joint_names"];
  out.acceleration = cspace[is_xrdf ? "acceleration_limits" : "max_acceleration"];
  out.jerk = cspace[is_xrdf ? "jerk_limits" : "max_jerk"];
  out.tool_frames = kinematics["tool_frames"];
  if (is_xrdf) {
    for (const auto& entry : root["default_joint_positions"]) out.rest[entry.first.Scalar()] = entry.second;
  } else if (const Node positions = cspace["default_joint_position"] ? cspace["default_joint_position"] : cspace["retract_config"]) {
    for (std::size_t i = 0; i < std::min(positions.size(), out.joint_names.size()); ++i)
      out.rest[out.joint_names[i].Scalar()] = positions[i];
  }
  return out;
}

/// The file to merge, or an empty map.
Node mergeRoot(const CoveredRobot& c) {
  if (c.merge.empty()) return Node(YAML::NodeType::Map);
  Node root = readYaml(c.merge);
  const bool fits = root.IsMap() && (isXrdf(c.merge) ? root["format"] && root["format"].Scalar() == "xrdf"
                                                     : root["robot_cfg"] && root["robot_cfg"].IsMap() && root["robot_cfg"]["kinematics"] &&
                                                           root["robot_cfg"]["kinematics"].IsMap());
  if (!fits)
    throw formats::FormatError(c.merge.string() +
                               ": is neither an XRDF (format: xrdf) nor a configuration of cuRobo (robot_cfg: kinematics:).");
  return root;
}

template <class Make>
void setMissing(Node map, const char* key, Make&& make) {
  if (!map[key] || map[key].IsNull()) map[key] = make();
}

/// One value for each of `names`; a single number applies to all. Empty if they are unknown.
Node perJoint(const Node& values, const Node& known_names, const Node& names) {
  if (!values || values.IsNull()) return Node();
  Node out(YAML::NodeType::Sequence);
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (values.IsScalar()) {
      out.push_back(values);
      continue;
    }
    for (std::size_t k = 0; k < std::min(values.size(), known_names.size()); ++k)
      if (known_names[k].Scalar() == names[i].Scalar()) out.push_back(values[k]);
    if (out.size() != i + 1) return Node();
  }
  return out;
}

Node jointNames(const Robot& robot) {
  Node names(YAML::NodeType::Sequence);
  for (const Joint* joint : movedJoints(robot)) names.push_back(textNode(joint->name));
  return names;
}

Node restOf(const Joint& joint, const Merged& merged) {
  const auto found = merged.rest.find(joint.name);
  return found != merged.rest.end() ? found->second : numberNode(restPosition(joint));
}

}  // namespace

std::string curoboYaml(const CoveredRobot& c) {
  const bool is_own = !c.merge.empty() && !isXrdf(c.merge);
  const Node source = mergeRoot(c);
  const Merged merged = c.merge.empty() ? Merged{} : mergedFrom(source, isXrdf(c.merge));
  Node root = is_own ? source : Node(YAML::NodeType::Map);
  Node k = root["robot_cfg"]["kinematics"];
  setMissing(k, "format_version", [] { return Node("2.0"); });
  setMissing(k, "base_link", [&] { return textNode(c.robot.links[c.robot.root].name); });
  setMissing(k, "tool_frames", [&] { return merged.tool_frames ? merged.tool_frames : toolFrames(c.robot); });
  const std::filesystem::path urdf = std::filesystem::absolute(c.robot.path).lexically_normal();
  setMissing(k, "urdf_path", [&] { return textNode(urdf.string()); });
  setMissing(k, "asset_root_path", [&] { return textNode(urdf.parent_path().string()); });
  Node names(YAML::NodeType::Sequence), buffers(YAML::NodeType::Map);
  for (const LinkCover& link : c.cover.links) {
    names.push_back(textNode(linkName(c, link)));
    const Node known = k["self_collision_buffer"] ? k["self_collision_buffer"][linkName(c, link)] : Node();
    buffers[linkName(c, link)] = known && known.IsScalar() ? known : Node("0.0");
  }
  k["collision_link_names"] = names;
  k["mesh_link_names"] = YAML::Clone(names);
  setMissing(k, "collision_sphere_buffer", [] { return Node("0.0"); });
  k["self_collision_buffer"] = buffers;
  k["self_collision_ignore"] = ignoreMap(c);
  k["collision_spheres"] = sphereMap(c);
  Node cspace = k["cspace"];
  setMissing(cspace, "joint_names", [&] { return jointNames(c.robot); });
  if (const Node limits = perJoint(merged.acceleration, merged.joint_names, cspace["joint_names"]); limits.size() > 0)
    setMissing(cspace, "max_acceleration", [&] { return limits; });
  if (const Node limits = perJoint(merged.jerk, merged.joint_names, cspace["joint_names"]); limits.size() > 0)
    setMissing(cspace, "max_jerk", [&] { return limits; });
  setMissing(cspace, "default_joint_position", [&] {
    Node rest(YAML::NodeType::Sequence);
    for (const Node& name : cspace["joint_names"])
      for (const Joint& joint : c.robot.joints)
        if (joint.name == name.Scalar()) rest.push_back(restOf(joint, merged));
    return rest;
  });
  return yamlText(root);
}

std::string xrdf(const CoveredRobot& c) {
  const bool is_own = isXrdf(c.merge);
  const Node source = mergeRoot(c);
  const Merged merged = c.merge.empty() ? Merged{} : mergedFrom(source, is_own);
  const std::string geometry = c.robot.name + "_spheres";
  Node root = is_own ? source : Node(YAML::NodeType::Map);
  root["format"] = Node("xrdf");
  root["format_version"] = Node("1.0");
  setMissing(root, "modifiers", [&] {
    Node base(YAML::NodeType::Map), list(YAML::NodeType::Sequence);
    base["set_base_frame"] = textNode(c.robot.links[c.robot.root].name);
    list.push_back(base);
    return list;
  });
  setMissing(root, "default_joint_positions", [&] {
    Node rest(YAML::NodeType::Map);
    for (const Joint* joint : movedJoints(c.robot)) rest[joint->name] = restOf(*joint, merged);
    return rest;
  });
  Node cspace = root["cspace"];
  setMissing(cspace, "joint_names", [&] { return merged.joint_names ? merged.joint_names : jointNames(c.robot); });
  if (const Node limits = perJoint(merged.acceleration, merged.joint_names, cspace["joint_names"]); limits.size() > 0)
    setMissing(cspace, "acceleration_limits", [&] { return limits; });
  if (const Node limits = perJoint(merged.jerk, merged.joint_names, cspace["joint_names"]); limits.size() > 0)
    setMissing(cspace, "jerk_limits", [&] { return limits; });
  setMissing(root, "tool_frames", [&] { return merged.tool_frames ? merged.tool_frames : toolFrames(c.robot); });
  for (const char* part : {"collision", "self_collision"}) {
    Node block = root[part];
    block["geometry"] = textNode(geometry);  // the same for both
    setMissing(block, "buffer_distance", [&] {
      Node buffers(YAML::NodeType::Map);
      for (const LinkCover& link : c.cover.links) buffers[linkName(c, link)] = Node("0.0");
      return buffers;
    });
  }
  root["self_collision"]["ignore"] = ignoreMap(c);
  Node all(YAML::NodeType::Map);
  all[geometry]["spheres"] = sphereMap(c);
  root["geometry"] = all;
  return yamlText(root);
}

}  // namespace spheretree::robot
