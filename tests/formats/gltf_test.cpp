// SPDX-License-Identifier: Apache-2.0
#include "spheretree/formats/gltf.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "spheretree/formats/errors.h"
#include "support/mesh_measures.h"
#include "support/sample_gltf.h"
#include "support/scratch_folder.h"
#include "support/texts.h"

namespace spheretree::formats {
namespace {

using Json = nlohmann::json;
using test::charsOf;
using test::has;
using test::tetrahedronBuffer;
using test::tetrahedronJson;
using test::toGlb;
using test::volumeOf;

constexpr double kVolume = 1e9 / 6;  // of the tetrahedron [mm^3]

MeshFile readGltfText(const Json& json, const std::string& buffer = tetrahedronBuffer()) {
  return readGltf(charsOf(toGlb(json, buffer)), "test.glb");
}

std::string gltfRefusal(const Json& json, const std::string& buffer = tetrahedronBuffer()) {
  return test::refusalOf<FormatError>([&] { readGltfText(json, buffer); });
}

template <class T>
std::string bytesOf(std::initializer_list<T> values) {
  return {reinterpret_cast<const char*>(values.begin()), values.size() * sizeof(T)};
}

TEST(Gltf, ReadsMetresAsMillimetres) {
  const MeshFile file = readGltfText(tetrahedronJson());
  EXPECT_EQ(file.mesh.positions.size(), 4u);
  EXPECT_EQ(file.mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {2, 1, 3}}));  // numbered as they come
  EXPECT_DOUBLE_EQ(volumeOf(file.mesh), kVolume);
  EXPECT_EQ(file.unit_mm, 1000);
  EXPECT_EQ(file.format, "GLB");
  EXPECT_EQ(file.mesh.part_names, std::vector<std::string>{"tooth"});
}

TEST(Gltf, ADataUriStandsForTheBinaryChunk) {
  Json json = tetrahedronJson();
  json["buffers"][0]["uri"] =
      "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAAIA/"
      "AAACAAEAAAABAAMAAAADAAIAAQACAAMA";
  const MeshFile file = readGltf(charsOf(json.dump()), "test.gltf");
  EXPECT_EQ(file.format, "glTF");
  EXPECT_EQ(file.mesh.positions, readGltfText(tetrahedronJson()).mesh.positions);
  json["buffers"][0]["uri"] = "data:;base64,AAAA";
  EXPECT_TRUE(has(gltfRefusal(json), "announces 72 bytes, but has 3")) << gltfRefusal(json);
  json["buffers"][0]["uri"] = "data:;base64,A*AA";
  EXPECT_TRUE(has(gltfRefusal(json), "\"*\""));
}

TEST(Gltf, NodeTransformsNestAndMirroringTurnsTheWinding) {
  Json json = tetrahedronJson();
  json["nodes"] = Json::parse(R"([{"children": [1], "matrix": [0,2,0,0, -2,0,0,0, 0,0,2,0, 5,6,7,1]},
                                  {"children": [2], "scale": [-1, 1, 3], "translation": [1, 0, 0]},
                                  {"mesh": 0, "rotation": [0, 0, 0.70710678, 0.70710678]}])");
  const MeshFile file = readGltfText(json);
  EXPECT_NEAR(volumeOf(file.mesh), kVolume * 24, kVolume * 1e-6);
  // (1, 0, 0): turned to (0, 1, 0), scaled and moved to (1, 1, 0), then by the matrix to (-2, 2, 0) + (5, 6, 7).
  bool is_found = false;
  for (const Eigen::Vector3d& p : file.mesh.positions) is_found |= (p - Eigen::Vector3d(3000, 8000, 7000)).norm() < 1e-3;
  EXPECT_TRUE(is_found);
}

TEST(Gltf, TheDefaultSceneCounts) {
  Json json = tetrahedronJson();
  json["nodes"].push_back({{"mesh", 0}, {"scale", {2, 2, 2}}});
  json["scenes"].push_back({{"nodes", {1}}});
  EXPECT_DOUBLE_EQ(volumeOf(readGltfText(json).mesh), kVolume);
  json["scene"] = 1;
  EXPECT_DOUBLE_EQ(volumeOf(readGltfText(json).mesh), 8 * kVolume);
  json.erase("scene");
  EXPECT_DOUBLE_EQ(volumeOf(readGltfText(json).mesh), kVolume);
  json.erase("scenes");
  EXPECT_DOUBLE_EQ(volumeOf(readGltfText(json).mesh), 9 * kVolume);  // all roots
  json["nodes"][0]["children"] = {1};
  EXPECT_DOUBLE_EQ(volumeOf(readGltfText(json).mesh), 9 * kVolume);
  json["scene"] = 3;
  EXPECT_TRUE(has(gltfRefusal(json), "scenes[3]"));
}

TEST(Gltf, StripsFansAndMissingIndices) {
  Json json = tetrahedronJson();
  json["accessors"][1]["count"] = 6;  // strip 0 1 2 3 0 1: the tetrahedron
  json["meshes"][0]["primitives"][0]["mode"] = 5;
  const std::string positions = tetrahedronBuffer().substr(0, 48);
  const auto strip = readGltfText(json, positions + bytesOf<std::uint16_t>({0, 2, 1, 3, 0, 2, 0, 0, 0, 0, 0, 0}));
  EXPECT_EQ(strip.mesh.triangles.size(), 4u);
  EXPECT_NEAR(volumeOf(strip.mesh), kVolume, 1);
  const auto with_turns = readGltfText(json, positions + bytesOf<std::uint16_t>({0, 2, 1, 1, 3, 3, 0, 0, 0, 0, 0, 0}));
  EXPECT_EQ(with_turns.mesh.triangles.size(), 1u);  // repeated corners only turn a corner
  json["meshes"][0]["primitives"][0]["mode"] = 6;
  json["accessors"][1]["count"] = 5;  // fan round 3: three sides
  const auto fan = readGltfText(json, positions + bytesOf<std::uint16_t>({3, 0, 1, 2, 0, 0, 0, 0, 0, 0, 0, 0}));
  EXPECT_EQ(fan.mesh.triangles.size(), 3u);
  json = tetrahedronJson();
  json["meshes"][0]["primitives"][0].erase("indices");
  json["accessors"][0]["count"] = 3;
  EXPECT_EQ(readGltfText(json).mesh.triangles.size(), 1u);
  json["accessors"][0]["count"] = 4;
  EXPECT_TRUE(has(gltfRefusal(json), "4 corners"));
}

/// The tetrahedron with two morph targets: the first moves the tip (vertex 3) by 1 m, the second vertex 1 by 2 m.
Json withMorphTargets(std::string& buffer) {
  buffer = tetrahedronBuffer();
  for (const auto& [vertex, axis, length] : {std::tuple{3, 2, 1.0f}, {1, 0, 2.0f}}) {
    std::vector<float> moves(12, 0);
    moves[static_cast<std::size_t>(3 * vertex + axis)] = length;
    buffer.append(reinterpret_cast<const char*>(moves.data()), 48);
  }
  Json json = tetrahedronJson();
  json["buffers"][0]["byteLength"] = buffer.size();
  for (int k = 0; k < 2; ++k) {
    json["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", 72 + 48 * k}, {"byteLength", 48}});
    json["accessors"].push_back({{"bufferView", 2 + k}, {"componentType", 5126}, {"count", 4}, {"type", "VEC3"}});
    json["meshes"][0]["primitives"][0]["targets"].push_back({{"POSITION", 2 + k}});
  }
  return json;
}

TEST(Gltf, MorphTargetsHaveTheWeightsOfTheFile) {
  std::string buffer;
  Json json = withMorphTargets(buffer);
  EXPECT_NEAR(volumeOf(readGltfText(json, buffer).mesh), kVolume, 1) << "no weights: targets move nothing";
  json["meshes"][0]["weights"] = {1, 0};
  const MeshFile tip = readGltfText(json, buffer);
  EXPECT_NEAR(volumeOf(tip.mesh), 2 * kVolume, 1);
  EXPECT_EQ(tip.notes, std::vector<std::string>{"1 primitive was read with the weights of morph targets that the file gives."});
  json["nodes"][0]["weights"] = {0.5, 0.5};  // override those of the mesh
  EXPECT_NEAR(volumeOf(readGltfText(json, buffer).mesh), 1.5 * 2 * kVolume, 1);
  json["accessors"][3]["count"] = 3;
  EXPECT_TRUE(has(test::refusalOf<FormatError>([&] { readGltfText(json, buffer); }), "targets[1] has 3 displacements for 4 vertices"));
  json["meshes"][0]["primitives"][0]["targets"] = {7};
  EXPECT_TRUE(has(test::refusalOf<FormatError>([&] { readGltfText(json, buffer); }), "targets[0] is not an object"));
}

TEST(Gltf, HiddenNodesAndNodesOutsideTheSceneAreLeftOutWithANote) {
  Json json = tetrahedronJson();
  json["nodes"] = {{{"mesh", 0}, {"name", "shown"}, {"children", {1}}},
                   {{"name", "group"}, {"children", {2}}, {"extensions", {{"KHR_node_visibility", {{"visible", false}}}}}},
                   {{"mesh", 0}, {"name", "below"}},
                   {{"mesh", 0}, {"name", "elsewhere"}}};
  json["extensionsRequired"] = {"KHR_node_visibility"};
  json["animations"] = {Json::object()};
  const MeshFile file = readGltfText(json);
  EXPECT_EQ(file.mesh.part_names, std::vector<std::string>{"shown"});
  EXPECT_EQ(file.notes, (std::vector<std::string>{"1 hidden node with a mesh was left out.",
                                                  "1 node with a mesh was left out, because the scene does not contain it.",
                                                  "1 animation was ignored; every node stands where the file places it."}));
  json["nodes"][1]["extensions"]["KHR_node_visibility"]["visible"] = true;
  EXPECT_EQ(readGltfText(json).mesh.part_names, (std::vector<std::string>{"shown", "below"}));
}

TEST(Gltf, DamagedJsonIsNamedByItsPlace) {
  const std::string text = "{\"asset\": {\"version\": \"2.0\"},\n \"nodes\": [}";
  const std::string refusal = test::refusalOf<FormatError>([&] { readGltf(test::charsOf(text), "test.gltf"); });
  EXPECT_TRUE(has(refusal, "test.gltf: line 2, column 12: is not JSON: ") && !has(refusal, "exception")) << refusal;
}

TEST(Gltf, PointsAndLinesAreLeftOut) {
  Json json = tetrahedronJson();
  for (int mode = 0; mode < 4; ++mode) json["meshes"][0]["primitives"].push_back({{"attributes", {{"POSITION", 0}}}, {"mode", mode}});
  const MeshFile file = readGltfText(json);
  EXPECT_EQ(file.mesh.triangles.size(), 4u);
  ASSERT_EQ(file.notes.size(), 1u);
  json["meshes"][0]["primitives"].erase(0);
  EXPECT_TRUE(has(gltfRefusal(json), "no triangle"));
  json["meshes"][0]["primitives"][0]["mode"] = 7;
  EXPECT_TRUE(has(gltfRefusal(json), "meshes[0].primitives[0].mode is 7"));
}

TEST(Gltf, QuantisedIntegersOfEveryType) {
  struct Case {
    int component;
    bool is_normalised;
    double largest;  // value of the largest number [m]
    std::string positions;
  };
  const Case cases[] = {
      {5120, false, 127, bytesOf<std::int8_t>({0, 0, 0, 0, 127, 0, 0, 0, 0, 127, 0, 0, 0, 0, 127, 0})},
      {5120, true, 1, bytesOf<std::int8_t>({0, 0, 0, 0, 127, 0, 0, 0, 0, 127, 0, 0, 0, 0, 127, 0})},
      {5121, true, 1, bytesOf<std::uint8_t>({0, 0, 0, 0, 255, 0, 0, 0, 0, 255, 0, 0, 0, 0, 255, 0})},
      {5122, true, 1, bytesOf<std::int16_t>({0, 0, 0, 0, 32767, 0, 0, 0, 0, 32767, 0, 0, 0, 0, 32767, 0})},
      {5123, false, 65535, bytesOf<std::uint16_t>({0, 0, 0, 0, 65535, 0, 0, 0, 0, 65535, 0, 0, 0, 0, 65535, 0})},
  };
  for (const Case& c : cases) {
    Json json = tetrahedronJson();
    json["extensionsRequired"] = {"KHR_mesh_quantization"};
    json["accessors"][0]["componentType"] = c.component;
    json["accessors"][0]["normalized"] = c.is_normalised;
    json["bufferViews"][0] = {{"buffer", 0}, {"byteLength", c.positions.size()}, {"byteStride", c.positions.size() / 4}};
    json["bufferViews"][1]["byteOffset"] = c.positions.size();
    json["buffers"][0]["byteLength"] = c.positions.size() + 24;
    const MeshFile file = readGltfText(json, c.positions + tetrahedronBuffer().substr(48));
    EXPECT_NEAR(volumeOf(file.mesh), kVolume * std::pow(c.largest, 3), 1e-9 * kVolume * std::pow(c.largest, 3)) << c.component;
  }
  // -128 and -127 of a signed byte both mean -1.
  Json json = tetrahedronJson();
  json["accessors"][0]["componentType"] = 5120;
  json["accessors"][0]["normalized"] = true;
  const std::string bytes = bytesOf<std::int8_t>({-128, 0, 0, -127, 0, 0, 0, 127, 0, 0, 0, 127});
  EXPECT_EQ(readGltfText(json, bytes + tetrahedronBuffer().substr(12)).mesh.positions.size(), 3u);
}

TEST(Gltf, SparseAccessorsReplaceElements) {
  Json json = tetrahedronJson();
  std::string buffer = tetrahedronBuffer();
  buffer += bytesOf<std::uint16_t>({1, 3}) + bytesOf<float>({2, 0, 0, 0, 0, 2});
  json["buffers"][0]["byteLength"] = 100;
  json["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", 72}, {"byteLength", 4}});
  json["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", 76}, {"byteLength", 24}});
  json["accessors"][0]["sparse"] = {
      {"count", 2}, {"indices", {{"bufferView", 2}, {"componentType", 5123}}}, {"values", {{"bufferView", 3}}}};
  EXPECT_DOUBLE_EQ(volumeOf(readGltfText(json, buffer).mesh), 4 * kVolume);
  const Json whole = json;
  json["accessors"][0].erase("bufferView");  // the others are zero: 0 and 2 coincide
  EXPECT_EQ(readGltfText(json, buffer).mesh.positions.size(), 3u);
  json = whole;
  json["accessors"][0]["sparse"]["count"] = 5;
  EXPECT_TRUE(has(gltfRefusal(json, buffer), "replaces 5 of 4"));
  json = whole;
  json["accessors"][0]["sparse"]["values"]["byteOffset"] = std::uint64_t{1} << 32;  // 0 in 32 bits
  EXPECT_TRUE(has(gltfRefusal(json, buffer), "accessors[0].sparse.values (offset 4294967296"));
  buffer[72] = 3;  // 3, 3
  EXPECT_TRUE(has(gltfRefusal(whole, buffer), "must rise"));
  buffer[72] = 0, buffer[74] = 4;
  EXPECT_TRUE(has(gltfRefusal(whole, buffer), "stay below 4"));
}

TEST(Gltf, RefusesWhatReachesBeyondItsBuffer) {
  const auto with = [](const char* pointer, Json value) {
    Json json = tetrahedronJson();
    json[Json::json_pointer(pointer)] = std::move(value);
    return gltfRefusal(json);
  };
  const std::uint64_t huge = std::uint64_t(1) << 63;
  for (const std::uint64_t count : {std::uint64_t{5}, std::uint64_t{2147483648}, huge, ~std::uint64_t{0}})
    EXPECT_TRUE(has(with("/accessors/0/count", count), "accessors[0] (offset 0, " + std::to_string(count))) << count;
  EXPECT_TRUE(has(with("/accessors/0/byteOffset", ~std::uint64_t{0}), "accessors[0]"));
  EXPECT_TRUE(has(with("/accessors/0/byteOffset", 4), "accessors[0]"));
  EXPECT_TRUE(has(with("/bufferViews/1/byteOffset", 49), "bufferViews[1]"));
  EXPECT_TRUE(has(with("/bufferViews/1/byteOffset", ~std::uint64_t{0} - 10), "bufferViews[1]"));
  EXPECT_TRUE(has(with("/bufferViews/1/byteLength", huge), "bufferViews[1]"));
  EXPECT_TRUE(has(with("/bufferViews/0/byteStride", 8), "byteStride of 8"));
  EXPECT_TRUE(has(with("/bufferViews/0/byteStride", 252), "accessors[0]"));
  EXPECT_TRUE(has(with("/bufferViews/0/byteStride", 14), "multiple of 4"));
  EXPECT_TRUE(has(with("/bufferViews/0/byteStride", 256), "multiple of 4"));
  EXPECT_TRUE(has(with("/bufferViews/1/byteStride", 4), "only vertex attributes"));
  EXPECT_TRUE(has(with("/buffers/0/byteLength", 0), "buffers[0] has no bytes"));
  EXPECT_TRUE(has(with("/buffers/0/byteLength", 73), "announces 73 bytes, but has 72"));
  EXPECT_TRUE(has(with("/accessors/0/count", 3), "names vertex 3"));
  EXPECT_TRUE(has(with("/accessors/0/count", 0), "no element"));
  EXPECT_TRUE(has(with("/accessors/0/count", -1), "accessors[0].count is not a whole number"));
  EXPECT_TRUE(has(with("/accessors/0/count", "4"), "accessors[0].count"));
  EXPECT_TRUE(has(with("/accessors/0/type", "VEC4"), "VEC3"));
  EXPECT_TRUE(has(with("/accessors/0/componentType", 5125), "componentType 5125"));
  EXPECT_TRUE(has(with("/accessors/1/componentType", 5126), "componentType 5126"));
  EXPECT_TRUE(has(with("/nodes/0/mesh", 1), "meshes[1]"));
  EXPECT_TRUE(has(with("/nodes/0/mesh", std::uint64_t{1} << 32), "meshes[4294967296]"));  // 0 in 32 bits
  EXPECT_TRUE(has(with("/meshes/0/primitives/0/indices", std::uint64_t{1} << 32), "accessors[4294967296]"));
  EXPECT_TRUE(has(with("/nodes/0/rotation", {0, 0, 0, 0}), "unit quaternion"));
  EXPECT_TRUE(has(with("/nodes/0/scale", {1, "2", 3}), "nodes[0].scale"));
  EXPECT_TRUE(has(with("/nodes/0/matrix", {1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}), "affine"));
  EXPECT_TRUE(has(with("/nodes/0/translation", {1e308, 0, 0}), "finite point"));
  EXPECT_TRUE(has(with("/nodes/0/children", {0}), "nodes[0] is reached twice"));
  EXPECT_TRUE(has(with("/scenes/0/nodes", {0, 0}), "nodes[0] is reached twice"));
  EXPECT_TRUE(has(with("/nodes", 3), "nodes is not an array"));
  EXPECT_TRUE(has(with("/asset/version", "1.0"), "\"1.0\""));
}

TEST(Gltf, RequiredExtensionsAreRefusedByName) {
  for (const char* name : {"VENDOR_geometry", "KHR_gaussian_splatting"}) {
    Json json = tetrahedronJson();
    json["extensionsRequired"] = {name};
    EXPECT_TRUE(has(gltfRefusal(json), name));
  }
  Json json = tetrahedronJson();
  json["extensionsRequired"] = {"KHR_materials_transmission", "KHR_texture_basisu"};
  EXPECT_EQ(readGltfText(json).mesh.triangles.size(), 4u);
}

TEST(Gltf, DeepNodesAreReadAndDeepJsonIsRefused) {
  Json json = tetrahedronJson();
  json["nodes"] = Json::array();
  for (int n = 0; n < 100000; ++n) json["nodes"].push_back({{"children", {n + 1}}});
  json["nodes"].push_back({{"mesh", 0}});
  EXPECT_DOUBLE_EQ(volumeOf(readGltfText(json).mesh), kVolume);
  std::string text = tetrahedronJson().dump();
  text.back() = ',';
  text += "\"extras\":" + std::string(1000000, '[') + std::string(1000000, ']') + "}";
  EXPECT_TRUE(has(test::refusalOf<FormatError>([&] { readGltf(charsOf(text), "test.gltf"); }), "nested more than 64"));
}

TEST(Gltf, UnneededElementsAreHarmless) {
  Json json = tetrahedronJson();
  json["images"] = {{{"uri", "missing.png"}}, {{"bufferView", 99}}, 7};
  json["textures"] = "none";
  json["materials"] = {{{"pbrMetallicRoughness", 3}}};
  json["animations"] = {{{"channels", {1}}}};
  json["cameras"] = {5};
  json["skins"] = {5};
  json["extensions"] = {{"KHR_lights_punctual", {{"lights", {1, 2}}}}};
  json["extras"] = {{"nodes", {1, "2"}}};
  json["accessors"].push_back({{"type", "VEC17"}, {"count", -1}});
  json["bufferViews"].push_back({{"buffer", "none"}});
  json["buffers"].push_back({{"byteLength", 9}, {"uri", "missing.bin"}});
  json["meshes"].push_back({{"primitives", {{{"mode", 99}}}}});  // no node refers to it
  json["nodes"][0]["weights"] = "none";
  json["nodes"][0]["camera"] = -4;
  json["nodes"][0]["extensions"] = 1;
  json["meshes"][0]["primitives"][0]["material"] = "none";
  json["meshes"][0]["primitives"][0]["targets"] = {1, {{"POSITION", 1000}}};
  json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = "none";
  const MeshFile file = readGltfText(json);
  EXPECT_DOUBLE_EQ(volumeOf(file.mesh), kVolume);
  EXPECT_EQ(file.notes.size(), 1u) << "the animation is ignored";
}

TEST(Gltf, ABufferMayBeLongerThanAnnounced) {
  Json json = tetrahedronJson();
  EXPECT_DOUBLE_EQ(volumeOf(readGltfText(json, tetrahedronBuffer() + std::string(40, 'x')).mesh), kVolume);
  json["buffers"].push_back({{"byteLength", 5}, {"uri", "data:;base64,AAAAAAAAAAAA"}});
  json["bufferViews"][1]["buffer"] = 1;
  EXPECT_TRUE(has(gltfRefusal(json), "beyond the 5 bytes of its buffer"));
}

TEST(Gltf, TooManyElementsAreRefused) {
  Json json = tetrahedronJson();
  json["nodes"] = Json::array_t(1'000'000, Json::object());
  EXPECT_TRUE(has(gltfRefusal(json), "more than 1000000 nodes"));
}

TEST(Gltf, InstancesWithoutEndAreRefused) {
  Json json = tetrahedronJson();
  const Json primitive = json["meshes"][0]["primitives"][0];
  for (int k = 0; k < 2000; ++k) json["meshes"][0]["primitives"].push_back(primitive);
  for (int n = 1; n < 2000; ++n) {
    json["nodes"].push_back({{"mesh", 0}});
    json["scenes"][0]["nodes"].push_back(n);
  }
  EXPECT_TRUE(has(gltfRefusal(json), "4000000 triangles"));
}

TEST(Gltf, ABufferMayLieInAFileOfTheFolder) {
  const test::ScratchFolder scratch;
  std::ofstream(scratch.path() / "a.bin", std::ios::binary) << tetrahedronBuffer();
  Json json = tetrahedronJson();
  json["buffers"][0]["uri"] = "a.bin";
  EXPECT_EQ(readGltf(charsOf(json.dump()), "test.gltf", scratch.path()).mesh.triangles.size(), 4u);
  EXPECT_THROW(readGltf(charsOf(json.dump()), "test.gltf"), FormatError) << "no folder, no files";
}

TEST(Gltf, RefusesBytesThatAreNeitherGlbNorText) {
  std::string bytes = toGlb(tetrahedronJson(), tetrahedronBuffer());
  bytes[0] = 'x';
  const std::string message = test::refusalOf<FormatError>([&] { readGltf(charsOf(bytes), "test.glb"); });
  EXPECT_TRUE(has(message, "does not begin with \"glTF\"")) << message;
}

TEST(Gltf, EveryTruncationOfAGlbIsRefused) {
  const std::string whole = toGlb(tetrahedronJson(), tetrahedronBuffer());
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const std::vector<char> cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_THROW(readGltf(cut, "test.glb"), FormatError) << size;
  }
  // The header fits the cut, the chunks do not. Its last eight bytes matter, too.
  for (std::size_t size = 12; size < whole.size(); ++size) {
    std::vector<char> cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
    const auto length = static_cast<std::uint32_t>(size);
    std::memcpy(cut.data() + 8, &length, 4);
    EXPECT_THROW(readGltf(cut, "test.glb"), FormatError) << size;
  }
}

}  // namespace
}  // namespace spheretree::formats
