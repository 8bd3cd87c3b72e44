// SPDX-License-Identifier: Apache-2.0
// What a mesh needs of a glTF or GLB file, checked so that any bytes are safe.
// Specification: Khronos, glTF 2.0, ISO/IEC 12113:2022.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "mesh_assembly.h"

namespace spheretree::formats {

enum Component : std::uint64_t { kInt8 = 5120, kUint8 = 5121, kInt16 = 5122, kUint16 = 5123, kUint32 = 5125, kFloat32 = 5126 };

/// Indices are those of the file; what no mesh needs keeps its place, but is empty. Views and accessors of unpacked
/// data stand behind those of the file.
struct GltfModel {
  struct View {
    std::size_t buffer = 0;
    std::uint64_t offset = 0, length = 0, stride = 0;  // [bytes]; stride 0: tightly packed
  };
  struct Sparse {
    std::uint64_t count = 0;
    std::size_t indices_view = 0, values_view = 0;
    std::uint64_t indices_offset = 0, values_offset = 0;
    std::uint64_t component = kUint32;  // of the indices
  };
  struct Accessor {
    std::optional<std::size_t> view;
    std::uint64_t offset = 0, count = 0;
    std::uint64_t component = kFloat32;
    std::size_t components = 1;  // numbers of an element
    bool is_normalised = false;
    std::optional<Sparse> sparse;
  };
  struct Primitive {
    std::uint64_t mode = 4;     // 0 to 6; below 4, points and lines, all else is empty
    std::size_t positions = 0;  // accessors
    std::optional<std::size_t> indices;
    std::vector<std::pair<std::size_t, std::size_t>> skin_sets;  // JOINTS_n and WEIGHTS_n
  };
  struct Mesh {
    std::string name;
    std::vector<Primitive> primitives;
  };
  struct Instances {  // accessors
    std::optional<std::size_t> translation, rotation, scale;
  };
  struct Node {
    std::string name;
    std::vector<std::size_t> children;
    std::vector<double> matrix, rotation, scale, translation;  // 16, 4, 3 and 3 numbers, or none
    std::optional<std::size_t> mesh, skin;
    std::optional<Instances> instances;
  };
  struct Skin {
    std::vector<std::size_t> joints;
    std::optional<std::size_t> inverse_bind_matrices;
  };

  std::vector<Node> nodes;
  std::vector<Mesh> meshes;
  std::vector<Accessor> accessors;
  std::vector<View> views;
  std::vector<std::span<const unsigned char>> buffers;  // into the file's bytes, or into `opened`
  std::vector<Skin> skins;
  std::vector<std::vector<std::size_t>> scenes;  // their root nodes
  std::optional<std::size_t> scene;              // the default one
  std::vector<std::vector<unsigned char>> opened;
};

/// Triangles, primitives, nodes and instances that a file of so many bytes may add up to.
std::uint64_t gltfWorkLimit(std::uint64_t file_bytes);

/// Holds the nodes, the scene to read, the meshes that nodes name with their triangles, positions, joints and weights,
/// the skins and instances of those nodes, and the accessors, views and buffers of all these. What meshoptimizer or
/// Draco compressed is unpacked. Certain: every index is within its array; accessors in use have an element, the type
/// and a component of their use, and a view if they hold indices; transforms have all their numbers; buffers have all
/// their bytes. Not certain: that views lie within buffers, and accessors within views. Cost: O(bytes) in time and
/// memory, of the buffers, and of what is unpacked.
/// @param bytes Must outlive the model. @param folder Buffers in files lie in it or below; empty: none are read.
/// @throws FormatError for what is not such a file; FileError for a buffer that cannot be read.
GltfModel loadGltfModel(std::span<const char> bytes, const std::filesystem::path& folder, MeshAssembly& assembly);

}  // namespace spheretree::formats
