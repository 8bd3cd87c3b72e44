// SPDX-License-Identifier: Apache-2.0
// The parts of a glTF or GLB file that a mesh needs, checked so that any bytes are safe.
// Specification: Khronos, glTF 2.0, ISO/IEC 12113:2022.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "gltf/gltf_component.h"
#include "mesh/mesh_assembly.h"

namespace spheretree::formats {

/// Indices are those of the file; unneeded elements keep their index, but are empty. Views and accessors of decoded
/// data follow those of the file.
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
    std::size_t components = 1;  // numbers in an element
    bool is_normalised = false;
    std::optional<Sparse> sparse;
  };
  struct Primitive {
    std::uint64_t mode = 4;     // 0 to 6; for points and lines (below 4) all other members are empty
    std::size_t positions = 0;  // accessor
    std::optional<std::size_t> indices;
    std::array<std::uint8_t, 3> colour{255, 255, 255};           // the base colour of its material, sRGB
    std::vector<std::pair<std::size_t, std::size_t>> skin_sets;  // JOINTS_n and WEIGHTS_n
    std::vector<std::optional<std::size_t>> morph_targets;       // accessors of displacements; empty: moves no position
  };
  struct Mesh {
    std::string name;
    std::vector<Primitive> primitives;
    std::vector<double> weights;  // of the morph targets
  };
  struct Instances {  // accessors
    std::optional<std::size_t> translation, rotation, scale;
  };
  struct Node {
    std::string name;
    std::vector<std::size_t> children;
    std::vector<double> matrix, rotation, scale, translation;  // 16, 4, 3 and 3 numbers, or empty
    std::optional<std::size_t> mesh, skin;
    std::optional<Instances> instances;
    std::vector<double> weights;  // override those of the mesh, if there are any
    bool is_visible = true;       // with its children
  };
  struct Skin {
    std::vector<std::size_t> joints;
    std::optional<std::size_t> inverse_bind_matrices;
  };

  std::vector<Node> nodes;
  std::vector<Mesh> meshes;
  std::vector<Accessor> accessors;
  std::vector<View> views;
  std::vector<std::span<const unsigned char>> buffers;  // views of the file's bytes, or of `opened`
  std::vector<Skin> skins;
  std::vector<std::vector<std::size_t>> scenes;  // their root nodes
  std::optional<std::size_t> scene;              // the default scene
  std::vector<std::vector<unsigned char>> opened;
  std::size_t animations = 0;
};

/// Limit of the triangles, primitives, nodes and instances in a file of this size.
std::uint64_t gltfWorkLimit(std::uint64_t file_bytes);

/// Contains the nodes, the scene to read, the meshes of its nodes with their triangles, positions, joints and weights,
/// the skins and instances of those nodes, and the accessors, views and buffers of all these. Data compressed by
/// meshoptimizer or Draco are decoded. Guaranteed: every index is within its array; accessors in use have an element,
/// the type and a component type for their use, and a view if they contain indices; transforms have all their numbers;
/// buffers have all their bytes. Not guaranteed: that views lie within buffers, and accessors within views. Cost:
/// O(bytes) in time and memory, including buffers and decoded data.
/// @param bytes Must outlive the model. @param folder External buffers must be in or below it; empty: none are read.
/// @throws FormatError for invalid content; FileError for a buffer that cannot be read.
GltfModel loadGltfModel(std::span<const char> bytes, const std::filesystem::path& folder, MeshAssembly& assembly);

}  // namespace spheretree::formats
