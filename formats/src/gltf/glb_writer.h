// SPDX-License-Identifier: Apache-2.0
// The common part of the writers of GLB: a model of tinygltf whose binary data grow with each accessor, and its file.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "gltf/tinygltf_model.h"

namespace spheretree::formats {

inline constexpr double kMetre = 0.001;  // [m/mm]: glTF is in metres

class GlbWriter {
 public:
  GlbWriter();

  /// Triangles with a point and a normal for each vertex, shown by a node. `positions` in mm.
  struct Part {
    std::string name;
    std::array<double, 3> colour;
    double roughness = 0.6;
    bool is_double_sided = false;
    std::vector<Eigen::Vector3d> positions, normals;      // equally many; normals of unit length
    std::vector<std::array<std::uint32_t, 3>> triangles;  // empty: each three consecutive positions are a triangle
  };
  /// Returns the index of its node.
  int add(const Part& part);
  /// Returns the index of the mesh, which no node shows yet.
  int addMesh(const Part& part);
  /// Adds a node that shows a mesh, scaled by `scale` and moved by `origin` [mm]; returns its index. Further nodes with
  /// the same mesh cost next to nothing.
  int addInstance(const std::string& name, int mesh, double scale, const Eigen::Vector3d& origin);
  /// Adds a parent of other nodes, `origin` in mm; returns its index.
  int addNode(const std::string& name, std::vector<int> children, const std::array<double, 3>& origin);
  /// The first scene is the default scene.
  void addScene(const std::string& name, std::vector<int> nodes);
  /// The content of the file. Same calls, same bytes.
  std::vector<std::byte> finish();

 private:
  int addAccessor(std::size_t begin, int target, int component, int type, std::size_t count);
  int addPoints(const std::vector<Eigen::Vector3d>& points, double scale);

  tinygltf::Model model_;
  std::vector<unsigned char> buffer_;
};

}  // namespace spheretree::formats
