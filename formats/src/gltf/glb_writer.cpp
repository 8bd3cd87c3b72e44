// SPDX-License-Identifier: Apache-2.0
#include <fstream>  // tinygltf uses it without including it

#define TINYGLTF_IMPLEMENTATION
#include "gltf/glb_writer.h"
#include "spheretree/core/rounding.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <sstream>

namespace spheretree::formats {
namespace {

template <class T>
void append(std::vector<unsigned char>& bytes, const T& value) {
  const auto* first = reinterpret_cast<const unsigned char*>(&value);
  bytes.insert(bytes.end(), first, first + sizeof value);
}

}  // namespace

GlbWriter::GlbWriter() {
  model_.asset.version = "2.0";
  model_.asset.generator = "spheretree";
  model_.defaultScene = 0;
}

int GlbWriter::addAccessor(std::size_t begin, int target, int component, int type, std::size_t count) {
  tinygltf::BufferView view;
  view.buffer = 0;
  view.byteOffset = begin;
  view.byteLength = buffer_.size() - begin;
  view.target = target;
  model_.bufferViews.push_back(std::move(view));
  tinygltf::Accessor accessor;
  accessor.bufferView = static_cast<int>(model_.bufferViews.size()) - 1;
  accessor.componentType = component;
  accessor.type = type;
  accessor.count = count;
  model_.accessors.push_back(std::move(accessor));
  return static_cast<int>(model_.accessors.size()) - 1;
}

int GlbWriter::addPoints(const std::vector<Eigen::Vector3d>& points, double scale) {
  const std::size_t begin = buffer_.size();
  std::vector<double> low(3, std::numeric_limits<double>::infinity()), high(3, -std::numeric_limits<double>::infinity());
  for (const Eigen::Vector3d& p : points)
    for (int axis = 0; axis < 3; ++axis) {
      const float x = roundToFloat(p[axis] * scale);
      append(buffer_, x);
      double &smallest = low[static_cast<std::size_t>(axis)], &largest = high[static_cast<std::size_t>(axis)];
      smallest = std::min(smallest, static_cast<double>(x)), largest = std::max(largest, static_cast<double>(x));
    }
  const int accessor = addAccessor(begin, TINYGLTF_TARGET_ARRAY_BUFFER, TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_VEC3, points.size());
  model_.accessors.back().minValues = low;
  model_.accessors.back().maxValues = high;
  return accessor;
}

int GlbWriter::addMesh(const Part& part) {
  tinygltf::Primitive primitive;
  primitive.mode = TINYGLTF_MODE_TRIANGLES;
  primitive.attributes["POSITION"] = addPoints(part.positions, kMetre);
  primitive.attributes["NORMAL"] = addPoints(part.normals, 1);
  if (!part.triangles.empty()) {
    const std::size_t begin = buffer_.size();
    for (const auto& triangle : part.triangles) append(buffer_, triangle);
    primitive.indices = addAccessor(begin, TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER, TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT, TINYGLTF_TYPE_SCALAR,
                                    3 * part.triangles.size());
  }
  primitive.material = static_cast<int>(model_.materials.size());
  tinygltf::Material material;
  material.name = part.name;
  material.doubleSided = part.is_double_sided;
  material.pbrMetallicRoughness.baseColorFactor = {part.colour[0], part.colour[1], part.colour[2], 1.0};
  material.pbrMetallicRoughness.metallicFactor = 0;
  material.pbrMetallicRoughness.roughnessFactor = part.roughness;
  model_.materials.push_back(std::move(material));
  tinygltf::Mesh mesh;
  mesh.name = part.name;
  mesh.primitives.push_back(std::move(primitive));
  model_.meshes.push_back(std::move(mesh));
  return static_cast<int>(model_.meshes.size()) - 1;
}

int GlbWriter::add(const Part& part) { return addInstance(part.name, addMesh(part), 1, Eigen::Vector3d::Zero()); }

int GlbWriter::addInstance(const std::string& name, int mesh, double scale, const Eigen::Vector3d& origin) {
  tinygltf::Node node;
  node.name = name;
  node.mesh = mesh;
  if (scale != 1) node.scale = {scale, scale, scale};
  if (!origin.isZero(0)) node.translation = {origin[0] * kMetre, origin[1] * kMetre, origin[2] * kMetre};
  model_.nodes.push_back(std::move(node));
  return static_cast<int>(model_.nodes.size()) - 1;
}

int GlbWriter::addNode(const std::string& name, std::vector<int> children, const std::array<double, 3>& origin) {
  tinygltf::Node node;
  node.name = name;
  node.children = std::move(children);
  if (origin != std::array<double, 3>{}) node.translation = {origin[0] * kMetre, origin[1] * kMetre, origin[2] * kMetre};
  model_.nodes.push_back(std::move(node));
  return static_cast<int>(model_.nodes.size()) - 1;
}

void GlbWriter::addScene(const std::string& name, std::vector<int> nodes) {
  tinygltf::Scene scene;
  scene.name = name;
  scene.nodes = std::move(nodes);
  model_.scenes.push_back(std::move(scene));
}

std::vector<std::byte> GlbWriter::finish() {
  if (!buffer_.empty()) {
    tinygltf::Buffer buffer;
    buffer.data = std::move(buffer_);
    model_.buffers.push_back(std::move(buffer));
  }
  std::ostringstream stream;
  tinygltf::TinyGLTF().WriteGltfSceneToStream(&model_, stream, false, true);
  const std::string text = stream.str();
  std::vector<std::byte> bytes(text.size());
  std::memcpy(bytes.data(), text.data(), text.size());
  return bytes;
}

}  // namespace spheretree::formats
