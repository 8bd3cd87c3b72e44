// SPDX-License-Identifier: Apache-2.0
// The model of a document, for any bytes; gltf_test.cpp tests the mesh that the reader makes of it.
#include "gltf/gltf_model.h"

#include <gtest/gtest.h>

#include "spheretree/formats/errors.h"
#include "support/mesh_measures.h"
#include "support/sample_gltf.h"
#include "support/texts.h"

namespace spheretree::formats {
namespace {

using Json = nlohmann::json;
using test::tetrahedronBuffer;
using test::tetrahedronJson;
using test::toGlb;

GltfModel load(const std::string& bytes) {
  MeshAssembly assembly("test.glb", 1000);
  return loadGltfModel(test::charsOf(bytes), {}, assembly);
}

/// Checks every index, size and array against the promises of the header.
void expectWhole(const GltfModel& model) {
  const auto within = [](std::size_t index, const auto& array) { return index < array.size(); };
  for (const GltfModel::Node& node : model.nodes) {
    if (node.mesh) {
      EXPECT_TRUE(within(*node.mesh, model.meshes));
    }
    for (const std::size_t child : node.children) EXPECT_TRUE(within(child, model.nodes));
    EXPECT_TRUE(node.matrix.empty() || node.matrix.size() == 16);
    EXPECT_TRUE(node.rotation.empty() || node.rotation.size() == 4);
    for (const auto& three : {node.scale, node.translation}) EXPECT_TRUE(three.empty() || three.size() == 3);
  }
  for (const GltfModel::Mesh& mesh : model.meshes)
    for (const GltfModel::Primitive& primitive : mesh.primitives) {
      EXPECT_LE(primitive.mode, 6u);
      if (primitive.mode < 4) continue;
      ASSERT_TRUE(within(primitive.positions, model.accessors));
      const GltfModel::Accessor& positions = model.accessors[primitive.positions];
      EXPECT_EQ(positions.components, 3u);
      EXPECT_GT(positions.count, 0u);
      if (!primitive.indices) continue;
      ASSERT_TRUE(within(*primitive.indices, model.accessors));
      const GltfModel::Accessor& indices = model.accessors[*primitive.indices];
      EXPECT_EQ(indices.components, 1u);
      ASSERT_TRUE(indices.view.has_value());
      EXPECT_TRUE(within(*indices.view, model.views));
    }
  for (const GltfModel::View& view : model.views) EXPECT_TRUE(within(view.buffer, model.buffers) || view.length == 0);
}

TEST(GltfModel, HoldsTheBytesOfItsBuffers) {
  const std::string bytes = toGlb(tetrahedronJson(), tetrahedronBuffer());  // the model views it
  const GltfModel model = load(bytes);
  expectWhole(model);
  ASSERT_EQ(model.buffers.size(), 1u);
  EXPECT_EQ(std::string(model.buffers[0].begin(), model.buffers[0].end()), tetrahedronBuffer());
  EXPECT_EQ(model.nodes[0].name, "tooth");
}

TEST(GltfModel, LeavesOutUnneededElementsAndKeepsEveryIndex) {
  Json json = tetrahedronJson();
  json["meshes"].insert(json["meshes"].begin(), Json{{"primitives", "none"}});  // no node refers to it: it is never read
  json["nodes"][0]["mesh"] = 1;
  json["buffers"].push_back({{"byteLength", 1'000'000'000}, {"uri", "../nowhere.bin"}});
  json["images"] = {{{"uri", "missing.png"}}};
  json["materials"] = "all wrong";
  json["nodes"][0]["extras"] = {{"mesh", -7}};
  const std::string bytes = toGlb(json, tetrahedronBuffer());
  const GltfModel model = load(bytes);
  expectWhole(model);
  EXPECT_TRUE(model.meshes[0].primitives.empty());
  EXPECT_EQ(model.meshes[1].primitives.size(), 1u);
  EXPECT_EQ(model.buffers.size(), 2u);
  EXPECT_TRUE(model.buffers[1].empty());
}

/// Calls `visit` with every value below `json`.
template <class Visit>
void forEachValue(Json& json, Visit visit) {
  for (Json& value : json) {
    visit(value);
    if (value.is_structured()) forEachValue(value, visit);
  }
}

// Every value of the document in turn is replaced by one of another type or by a number out of range: it is refused by
// name, or has no effect.
TEST(GltfModel, AnyValueMayBeWrong) {
  const Json wrong[] = {nullptr,       true,           -1,          0.5, 1e300, 4294967296u, 18446744073709551615u, "x",
                        Json::array(), Json::object(), {{{"a", 1}}}};
  std::size_t values = 0, refused = 0;
  Json whole = tetrahedronJson();
  whole["nodes"][0]["rotation"] = {0, 0, 0, 1};
  whole["nodes"][0]["children"] = Json::array();
  whole["accessors"][0]["sparse"] = {
      {"count", 1}, {"indices", {{"bufferView", 1}, {"componentType", 5123}}}, {"values", {{"bufferView", 0}}}};
  forEachValue(whole, [&](Json&) { ++values; });
  for (std::size_t place = 0; place < values; ++place)
    for (const Json& other : wrong) {
      Json json = whole;
      std::size_t k = 0;
      forEachValue(json, [&](Json& value) {
        if (k++ == place) value = other;
      });
      try {
        expectWhole(load(toGlb(json, tetrahedronBuffer())));
      } catch (const FormatError& error) {
        EXPECT_TRUE(std::string(error.what()).starts_with("test.glb: ")) << error.what();
        ++refused;
      }
    }
  EXPECT_GT(refused, values * std::size(wrong) / 2);
}

}  // namespace
}  // namespace spheretree::formats
