// SPDX-License-Identifier: Apache-2.0
#include "gltf/gltf_nodes.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "gltf/gltf_json.h"

namespace spheretree::formats {
namespace {

constexpr double kQuaternionTolerance =
    0.02;  // for a quaternion of four normalised bytes: half of 1/127 each, and twice that for imprecise writers

}  // namespace

GltfNodes::GltfNodes(const GltfModel& model, GltfAccessors& accessors, MeshAssembly& assembly, WorkBudget& work)
    : model_(model), accessors_(accessors), assembly_(assembly), work_(work) {
  struct Visit {
    std::size_t node;
    GltfPose parent;
    bool is_visible;
  };
  std::vector<Visit> stack;  // a stack of its own, since a file may nest nodes deeper than the machine's stack allows
  const std::vector<std::size_t> roots = rootNodes();
  for (std::size_t k = roots.size(); k-- > 0;) stack.push_back({roots[k], GltfPose{}, true});
  while (!stack.empty()) {
    const Visit visit = stack.back();
    stack.pop_back();
    const std::size_t index = visit.node;
    const GltfModel::Node& node = model_.nodes[index];
    const std::string where = place("nodes", index);
    if (!place_of_.try_emplace(index, placed_.size()).second)
      refuseElement(assembly_, where, "is reached twice: nodes must form trees, without cycles");
    const GltfPose pose = visit.parent * poseOf(node, where);
    const bool is_visible = visit.is_visible && node.is_visible;
    placed_.push_back({index, pose, is_visible});
    work_.spend(node.children.size());
    for (std::size_t k = node.children.size(); k-- > 0;) stack.push_back({node.children[k], pose, is_visible});
  }
}

GltfPose GltfNodes::poseOf(const GltfModel::Node& node, const std::string& where) const {
  if (const std::vector<double>& m = node.matrix; !m.empty()) {
    if (m[3] != 0 || m[7] != 0 || m[11] != 0 || m[15] != 1)
      refuseElement(assembly_, where + ".matrix", "is not affine: its last row must be 0 0 0 1");
    GltfPose pose;
    pose.linear << m[0], m[4], m[8], m[1], m[5], m[9], m[2], m[6], m[10];
    pose.offset << m[12], m[13], m[14];
    return pose;
  }
  const std::vector<double>&t = node.translation, &q = node.rotation, &s = node.scale;
  return fromParts(t.empty() ? Eigen::Vector3d(0, 0, 0) : Eigen::Vector3d(t[0], t[1], t[2]),
                   q.empty() ? Eigen::Vector4d(0, 0, 0, 1) : Eigen::Vector4d(q[0], q[1], q[2], q[3]),
                   s.empty() ? Eigen::Vector3d(1, 1, 1) : Eigen::Vector3d(s[0], s[1], s[2]), where);
}

GltfPose GltfNodes::fromParts(const Eigen::Vector3d& translation, const Eigen::Vector4d& rotation, const Eigen::Vector3d& scale,
                              const std::string& where) const {
  const Eigen::Quaterniond turn(rotation[3], rotation[0], rotation[1], rotation[2]);
  if (!(std::abs(turn.norm() - 1) < kQuaternionTolerance)) refuseElement(assembly_, where + ".rotation", "is not a unit quaternion");
  GltfPose pose;
  pose.linear =
      turn.normalized().toRotationMatrix() * scale.asDiagonal();  // normalised, since it is stored as float32 or less, hence rounded
  pose.offset = translation;
  return pose;
}

std::vector<GltfPose> GltfNodes::instances(std::size_t index) {
  const std::optional<GltfModel::Instances>& from = model_.nodes[index].instances;
  if (!from) return {};
  const std::string where = place("nodes", index) + ".EXT_mesh_gpu_instancing";
  const auto numbers = [&](std::optional<std::size_t> accessor) { return accessor ? &accessors_.numbers(*accessor) : nullptr; };
  const Numbers *translation = numbers(from->translation), *rotation = numbers(from->rotation), *scale = numbers(from->scale);
  const std::uint64_t count = (translation ? translation : rotation ? rotation : scale)->count;
  for (const Numbers* each : {translation, rotation, scale})
    if (each && each->count != count)
      refuseElement(assembly_, where, "has attributes of " + std::to_string(count) + " and " + std::to_string(each->count) + " instances");
  work_.spend(count);
  std::vector<GltfPose> poses;
  for (std::uint64_t i = 0; i < count; ++i) {
    Eigen::Vector4d turn(0, 0, 0, 1);
    if (rotation)
      for (std::size_t axis = 0; axis < 4; ++axis) turn[static_cast<Eigen::Index>(axis)] = rotation->at(i, axis);
    poses.push_back(fromParts(translation ? translation->vectorAt(i) : Eigen::Vector3d(0, 0, 0), turn,
                              scale ? scale->vectorAt(i) : Eigen::Vector3d(1, 1, 1), where + " of instance " + std::to_string(i)));
  }
  return poses;
}

std::vector<GltfPose> GltfNodes::joints(std::size_t skin_index) {
  const GltfModel::Skin& skin = model_.skins[skin_index];
  const std::string where = place("skins", skin_index);
  const Numbers* inverse = skin.inverse_bind_matrices ? &accessors_.numbers(*skin.inverse_bind_matrices) : nullptr;
  if (inverse && inverse->count < skin.joints.size())
    refuseElement(assembly_, where,
                  "has " + std::to_string(skin.joints.size()) + " joints, but " + std::to_string(inverse->count) + " matrices");
  work_.spend(skin.joints.size());
  std::vector<GltfPose> poses;
  for (std::size_t k = 0; k < skin.joints.size(); ++k) {
    const auto joint = place_of_.find(skin.joints[k]);
    if (joint == place_of_.end())
      refuseElement(assembly_, where, "has a joint, " + place("nodes", skin.joints[k]) + ", that is not in the scene");
    GltfPose bind;
    for (Eigen::Index row = 0; inverse && row < 3; ++row) {
      for (Eigen::Index column = 0; column < 3; ++column)
        bind.linear(row, column) = inverse->at(k, static_cast<std::size_t>(4 * column + row));
      bind.offset[row] = inverse->at(k, static_cast<std::size_t>(12 + row));
    }
    poses.push_back(placed_[joint->second].pose * bind);
  }
  return poses;
}

std::vector<std::size_t> GltfNodes::rootNodes() const {
  if (const std::size_t count = model_.scenes.size(); count > 1)
    assembly_.note(model_.scene ? "The default scene " + std::to_string(*model_.scene) + " of " + std::to_string(count) + " was read."
                                : "No default scene is named; the first of " + std::to_string(count) + " was read.");
  if (!model_.scenes.empty()) return model_.scenes[model_.scene.value_or(0)];
  std::vector<bool> is_child(model_.nodes.size());
  for (const GltfModel::Node& node : model_.nodes)
    for (const std::size_t child : node.children) is_child[child] = true;
  std::vector<std::size_t> roots;
  for (std::size_t n = 0; n < is_child.size(); ++n)
    if (!is_child[n]) roots.push_back(n);
  if (roots.size() > 1) assembly_.note("No scene is named; all " + std::to_string(roots.size()) + " root nodes were read.");
  return roots;
}

}  // namespace spheretree::formats
