// SPDX-License-Identifier: Apache-2.0
// The poses of a glTF model's nodes: their transforms, instances and joints.
// Specification: Khronos, glTF 2.0, ISO/IEC 12113:2022, sections 3.5 and 3.7.3; extension EXT_mesh_gpu_instancing.
#pragma once

#include <Eigen/Core>
#include <map>
#include <vector>

#include "gltf/gltf_accessors.h"

namespace spheretree::formats {

struct GltfPose {
  Eigen::Matrix3d linear = Eigen::Matrix3d::Identity();
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();  // [m]

  GltfPose operator*(const GltfPose& inner) const { return {linear * inner.linear, linear * inner.offset + offset}; }
  Eigen::Vector3d operator*(const Eigen::Vector3d& point) const { return linear * point + offset; }
};

class GltfNodes {
 public:
  struct Placed {
    std::size_t node;
    GltfPose pose;  // in the scene
    bool is_visible;
  };

  /// Traverses the scene. Refers to all arguments, which must outlive it.
  /// @throws FormatError if nodes do not form trees, or a transform is invalid.
  GltfNodes(const GltfModel& model, GltfAccessors& accessors, MeshAssembly& assembly, WorkBudget& work);

  const std::vector<Placed>& placed() const { return placed_; }  // parents before children, in the order of the file
  /// Instances of a node with EXT_mesh_gpu_instancing, in the frame of the node; otherwise empty.
  std::vector<GltfPose> instances(std::size_t node);
  /// Transforms from the frame of a skinned mesh into the scene, for each joint, in the rest pose.
  std::vector<GltfPose> joints(std::size_t skin);

 private:
  GltfPose poseOf(const GltfModel::Node& node, const std::string& where) const;
  GltfPose fromParts(const Eigen::Vector3d& translation, const Eigen::Vector4d& rotation, const Eigen::Vector3d& scale,
                     const std::string& where) const;
  std::vector<std::size_t> rootNodes() const;

  const GltfModel& model_;
  GltfAccessors& accessors_;
  MeshAssembly& assembly_;
  WorkBudget& work_;
  std::vector<Placed> placed_;
  std::map<std::size_t, std::size_t> place_of_;  // index in placed_ of each node
};

}  // namespace spheretree::formats
