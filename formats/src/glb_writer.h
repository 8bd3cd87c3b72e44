// SPDX-License-Identifier: Apache-2.0
// What the writers of GLB share: a model of tinygltf whose binary data grow from accessor to accessor, and its file.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "tinygltf_model.h"

namespace spheretree::formats {

inline constexpr double kMetre = 0.001;  // [m/mm]: glTF is in metres

class GlbWriter {
 public:
  GlbWriter();

  /// Triangles with a point and a normal for each of their corners' vertices, and a node of them. `positions` in mm.
  struct Part {
    std::string name;
    std::array<double, 3> colour;
    double roughness = 0.6;
    bool is_double_sided = false;
    std::vector<Eigen::Vector3d> positions, normals;      // as many of each; normals of unit length
    std::vector<std::array<std::uint32_t, 3>> triangles;  // none: three positions after each other are one
  };
  /// Returns the index of its node.
  int add(const Part& part);
  /// Returns the index of its mesh, which no node shows yet.
  int addMesh(const Part& part);
  /// A node that shows a mesh, `scale` times as large and moved by `origin` [mm]; returns its index. Nodes that share a
  /// mesh cost next to nothing.
  int addInstance(const std::string& name, int mesh, double scale, const Eigen::Vector3d& origin);
  /// A node above others, `origin` in mm; returns its index.
  int addNode(const std::string& name, std::vector<int> children, const std::array<double, 3>& origin);
  /// The first is the one that is shown.
  void addScene(const std::string& name, std::vector<int> nodes);
  /// The file. Same calls, same bytes.
  std::vector<std::byte> finish();

 private:
  int addAccessor(std::size_t begin, int target, int component, int type, std::size_t count);
  int addPoints(const std::vector<Eigen::Vector3d>& points, double scale);

  tinygltf::Model model_;
  std::vector<unsigned char> buffer_;
};

}  // namespace spheretree::formats
