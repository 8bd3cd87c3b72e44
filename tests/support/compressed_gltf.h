// SPDX-License-Identifier: Apache-2.0
// A triangle mesh as a GLB: plain, compressed by meshoptimizer, compressed by Draco; each made by the library itself.
#pragma once

#include <draco/compression/expert_encode.h>
#include <meshoptimizer.h>

#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "spheretree/core/triangle_mesh.h"
#include "support/gltf_document.h"

namespace spheretree::test {

inline nlohmann::json plainJson(std::size_t vertices, std::size_t indices, std::size_t bytes) {
  nlohmann::json json = tetrahedronJson();
  json["accessors"] = {{{"bufferView", 0}, {"componentType", 5126}, {"count", vertices}, {"type", "VEC3"}},
                       {{"bufferView", 1}, {"componentType", 5125}, {"count", indices}, {"type", "SCALAR"}}};
  json["bufferViews"] = {{{"buffer", 0}, {"byteLength", 12 * vertices}},
                         {{"buffer", 0}, {"byteOffset", 12 * vertices}, {"byteLength", 4 * indices}}};
  json["buffers"] = {{{"byteLength", bytes}}};
  return json;
}

inline std::string plainGlb(const TriangleMesh& mesh) {
  const std::string data = rawBytes(positionsOf(mesh)) + rawBytes(indicesOf(mesh));
  return toGlb(plainJson(mesh.positions.size(), 3 * mesh.triangles.size(), data.size()), data);
}

/// `mode` of the indices: "TRIANGLES" (which may turn a triangle's corners round) or "INDICES".
inline std::string meshoptGlb(const TriangleMesh& mesh, const std::string& mode = "TRIANGLES",
                              const std::string& extension = "EXT_meshopt_compression") {
  const std::vector<float> positions = positionsOf(mesh);
  const std::vector<std::uint32_t> indices = indicesOf(mesh);
  const std::size_t vertices = mesh.positions.size();
  std::vector<unsigned char> first(meshopt_encodeVertexBufferBound(vertices, 12));
  first.resize(meshopt_encodeVertexBuffer(first.data(), first.size(), positions.data(), vertices, 12));
  const bool triangles = mode == "TRIANGLES";
  std::vector<unsigned char> second(triangles ? meshopt_encodeIndexBufferBound(indices.size(), vertices)
                                              : meshopt_encodeIndexSequenceBound(indices.size(), vertices));
  second.resize(triangles ? meshopt_encodeIndexBuffer(second.data(), second.size(), indices.data(), indices.size())
                          : meshopt_encodeIndexSequence(second.data(), second.size(), indices.data(), indices.size()));
  std::string data = rawBytes(first);
  data.resize((data.size() + 3) / 4 * 4);
  const std::size_t second_at = data.size();
  data += rawBytes(second);
  nlohmann::json json = plainJson(vertices, indices.size(), data.size());
  json["buffers"].push_back({{"byteLength", 12 * vertices + 4 * indices.size()}, {"extensions", {{extension, {{"fallback", true}}}}}});
  for (nlohmann::json& view : json["bufferViews"]) view["buffer"] = 1;
  json["bufferViews"][0]["byteStride"] = 12;
  json["bufferViews"][0]["extensions"][extension] = {{"buffer", 0},       {"byteLength", first.size()}, {"byteStride", 12},
                                                     {"count", vertices}, {"mode", "ATTRIBUTES"},       {"filter", "NONE"}};
  json["bufferViews"][1]["extensions"][extension] = {{"buffer", 0},     {"byteOffset", second_at}, {"byteLength", second.size()},
                                                     {"byteStride", 4}, {"count", indices.size()}, {"mode", mode}};
  json["extensionsUsed"] = json["extensionsRequired"] = {extension};
  return toGlb(json, data);
}

/// `quantisation`: bits of a coordinate; 0 keeps every bit of a float. `method`: draco::MESH_EDGEBREAKER_ENCODING or
/// draco::MESH_SEQUENTIAL_ENCODING. The ids of the attributes are 7 (POSITION), 8 (JOINTS_0) and 9 (WEIGHTS_0).
inline std::string dracoBytes(const TriangleMesh& mesh, int method, int quantisation = 0, const SkinWeights& skin = {}) {
  draco::Mesh to;
  const auto vertices = static_cast<std::uint32_t>(mesh.positions.size());
  to.set_num_points(vertices);
  const auto add = [&](draco::GeometryAttribute::Type type, draco::DataType data, int components, std::uint32_t id, const void* values) {
    draco::GeometryAttribute attribute;
    const int stride = draco::DataTypeLength(data) * components;
    attribute.Init(type, nullptr, static_cast<std::uint8_t>(components), data, false, stride, 0);
    const int index = to.AddAttribute(attribute, true, vertices);
    to.attribute(index)->set_unique_id(id);
    for (std::uint32_t v = 0; v < vertices; ++v)
      to.attribute(index)->SetAttributeValue(draco::AttributeValueIndex(v),
                                             static_cast<const char*>(values) + std::size_t{v} * static_cast<std::size_t>(stride));
    return index;
  };
  const std::vector<float> positions = positionsOf(mesh);
  const int position = add(draco::GeometryAttribute::POSITION, draco::DT_FLOAT32, 3, 7, positions.data());
  if (!skin.joints.empty()) {
    add(draco::GeometryAttribute::GENERIC, draco::DT_UINT8, 4, 8, skin.joints.data());
    add(draco::GeometryAttribute::GENERIC, draco::DT_FLOAT32, 4, 9, skin.weights.data());
  }
  for (const Triangle& t : mesh.triangles) to.AddFace({draco::PointIndex(t[0]), draco::PointIndex(t[1]), draco::PointIndex(t[2])});
  draco::ExpertEncoder encoder(to);
  encoder.SetEncodingMethod(method);
  if (quantisation > 0) encoder.SetAttributeQuantization(position, quantisation);
  draco::EncoderBuffer buffer;
  if (!encoder.EncodeToBuffer(&buffer).ok()) throw std::runtime_error("Draco cannot encode the mesh");
  return {buffer.data(), buffer.size()};
}

inline std::string dracoGlb(const TriangleMesh& mesh, int method, int quantisation = 0) {
  const std::string data = dracoBytes(mesh, method, quantisation);
  nlohmann::json json = plainJson(mesh.positions.size(), 3 * mesh.triangles.size(), data.size());
  for (nlohmann::json& accessor : json["accessors"]) accessor.erase("bufferView");
  json["bufferViews"] = {{{"buffer", 0}, {"byteLength", data.size()}}};
  json["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"] = {{"bufferView", 0}, {"attributes", {{"POSITION", 7}}}};
  json["extensionsUsed"] = json["extensionsRequired"] = {"KHR_draco_mesh_compression"};
  return toGlb(json, data);
}

}  // namespace spheretree::test
