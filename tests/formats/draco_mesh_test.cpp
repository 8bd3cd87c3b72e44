// SPDX-License-Identifier: Apache-2.0
#include "gltf/draco_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "gltf/gltf_model.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/gltf.h"
#include "support/compressed_gltf.h"
#include "support/mesh_measures.h"
#include "support/random.h"
#include "support/shapes.h"
#include "support/texts.h"
#include "text/little_endian.h"

namespace spheretree::formats {
namespace {

using test::has;

constexpr int kMethods[] = {draco::MESH_SEQUENTIAL_ENCODING, draco::MESH_EDGEBREAKER_ENCODING};

DracoMesh decode(const std::string& bytes, std::vector<std::uint64_t> ids = {7}, std::uint64_t max_triangles = 4'000'000) {
  return decodeDraco({reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()}, ids, max_triangles,
                     MeshAssembly("test.glb", 1000), "meshes[0].primitives[0]");
}

std::string dracoRefusal(const std::string& bytes, std::vector<std::uint64_t> ids = {7}, std::uint64_t max_triangles = 4'000'000) {
  return test::refusalOf<FormatError>([&] { decode(bytes, std::move(ids), max_triangles); });
}

TriangleMesh placed(const TriangleMesh& mesh, std::uint64_t seed) {
  test::Random random(seed);
  TriangleMesh result = mesh;
  for (Eigen::Vector3d& p : result.positions) p += random.inCube(1);
  return result;
}

/// The positions of each triangle's corners, in a canonical order: Draco may renumber vertices and rotate triangles.
std::vector<std::array<std::array<double, 3>, 3>> trianglesOf(const TriangleMesh& mesh) {
  std::vector<std::array<std::array<double, 3>, 3>> all;
  for (const Triangle& t : mesh.triangles) {
    std::array<std::array<double, 3>, 3> corners;
    for (std::size_t k = 0; k < 3; ++k) corners[k] = {mesh.positions[t[k]].x(), mesh.positions[t[k]].y(), mesh.positions[t[k]].z()};
    std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
    all.push_back(corners);
  }
  std::sort(all.begin(), all.end());
  return all;
}

TEST(DracoMesh, WithoutQuantisationEveryBitIsKept) {
  for (const TriangleMesh& shape : {test::torusMesh(20, 6, 40, 18), test::sphereMesh(30, 4), test::boxMesh({0, 0, 0}, {3, 4, 5})})
    for (const int method : kMethods) {
      const TriangleMesh mesh = placed(shape, 5);
      const MeshFile plain = readGltf(test::charsOf(test::plainGlb(mesh)), "plain.glb");
      const MeshFile file = readGltf(test::charsOf(test::dracoGlb(mesh, method)), "packed.glb");
      EXPECT_EQ(trianglesOf(file.mesh), trianglesOf(plain.mesh));
      EXPECT_EQ(file.mesh.positions.size(), plain.mesh.positions.size());
      EXPECT_TRUE(file.notes.empty());
    }
}

TEST(DracoMesh, QuantisationMovesAVertexByLessThanAStep) {
  const TriangleMesh torus = placed(test::torusMesh(20, 6, 40, 18), 6);
  const double step = 54.0 / 2047;  // of 11 bits over the longest side [mm]
  const MeshFile plain = readGltf(test::charsOf(test::plainGlb(torus)), "plain.glb");
  const MeshFile file = readGltf(test::charsOf(test::dracoGlb(torus, draco::MESH_EDGEBREAKER_ENCODING, 11)), "packed.glb");
  ASSERT_EQ(file.mesh.positions.size(), plain.mesh.positions.size());
  for (const Eigen::Vector3d& p : file.mesh.positions) {
    double nearest = 1e9;
    for (const Eigen::Vector3d& q : plain.mesh.positions) nearest = std::min(nearest, (p - q).norm());
    EXPECT_LT(nearest, step);
  }
}

TEST(DracoMesh, UnpacksSeveralAttributesInTheOrderAsked) {
  const TriangleMesh ball = test::sphereMesh(10, 2);
  test::SkinWeights skin;
  for (std::size_t v = 0; v < ball.positions.size(); ++v) {
    skin.joints.insert(skin.joints.end(), {static_cast<std::uint8_t>(v), 1, 2, 3});
    skin.weights.insert(skin.weights.end(), {0.25f, static_cast<float>(v), 0.5f, 0});
  }
  for (const int method : kMethods) {
    const DracoMesh mesh = decode(test::dracoBytes(ball, method, 0, skin), {9, 7, 8});
    ASSERT_EQ(mesh.vertex_count, ball.positions.size());
    ASSERT_EQ(mesh.attributes.size(), 3u);
    EXPECT_EQ(mesh.attributes[0].component, kFloat32);
    EXPECT_EQ(mesh.attributes[1].components, 3u);
    EXPECT_EQ(mesh.attributes[2].component, kUint8);
    const std::vector<float> positions = test::positionsOf(ball);
    for (std::size_t v = 0; v < mesh.vertex_count; ++v) {
      const std::size_t was = mesh.attributes[2].bytes[4 * v];  // its number before it was packed
      float weight;
      std::memcpy(&weight, mesh.attributes[0].bytes.data() + 16 * v + 4, 4);
      EXPECT_EQ(weight, static_cast<float>(was));
      EXPECT_EQ(std::memcmp(mesh.attributes[1].bytes.data() + 12 * v, positions.data() + 3 * was, 12), 0);
    }
  }
}

TEST(DracoMesh, WhatItAnnouncesIsRefusedBeforeMemoryIsTaken) {
  const TriangleMesh ball = test::sphereMesh(10, 2);
  for (const int method : kMethods) {
    const std::string whole = test::dracoBytes(ball, method);
    EXPECT_EQ(dracoRefusal(whole), "");
    EXPECT_TRUE(has(dracoRefusal(whole, {7}, ball.triangles.size() - 1), "more than the " + std::to_string(ball.triangles.size() - 1)));
    // After 11 bytes of header (and one of the edgebreaker) follow the counts; 4,000,000,000 as a varint.
    for (std::size_t at = 11; at < 14; ++at) {
      std::string bytes = whole;
      bytes.replace(at, 1, "\x80\xd0\xac\xf3\x0e");
      EXPECT_NE(dracoRefusal(bytes), "") << at;
    }
    std::string old = whole;
    old[6] = 1;
    EXPECT_TRUE(has(dracoRefusal(old), "version 2.1; glTF has 2.2"));
    old = whole;
    old[7] = 0;
    EXPECT_TRUE(has(dracoRefusal(old), "not a mesh"));
    EXPECT_TRUE(has(dracoRefusal("GLACO" + whole.substr(5)), "wrong header"));
    EXPECT_TRUE(has(dracoRefusal(whole, {1}), "the attribute with id 1"));
    EXPECT_TRUE(has(dracoRefusal(whole, {~std::uint64_t{0}}), "which its Draco data lack"));
  }
}

// Any damage gives a complete mesh or a refusal.
TEST(DracoMesh, DamageIsRefusedOrHarmless) {
  const TriangleMesh ball = placed(test::sphereMesh(10, 2), 1);
  test::Random random(5);
  std::size_t refused = 0;
  for (const int quantisation : {0, 9})
    for (const int method : kMethods) {
      const std::string whole = test::dracoBytes(ball, method, quantisation);
      for (std::size_t size = 0; size < whole.size(); size += 3) EXPECT_NE(dracoRefusal(whole.substr(0, size)), "") << size;
      for (int k = 0; k < 3000; ++k) {
        std::string bytes = whole;
        // The counts and tables come first.
        const std::size_t reach = random.below(2) ? bytes.size() : std::min<std::size_t>(bytes.size(), 60);
        for (std::uint64_t n = 0; n <= random.below(3); ++n) bytes[random.below(reach)] = static_cast<char>(random.next());
        try {
          const DracoMesh mesh = decode(bytes);
          EXPECT_EQ(mesh.attributes[0].bytes.size() % mesh.vertex_count, 0u);
          for (const std::uint32_t corner : mesh.corners) EXPECT_LT(corner, mesh.vertex_count);
        } catch (const FormatError&) {
          ++refused;
        }
      }
    }
  EXPECT_GT(refused, 1000u);
}

TEST(DracoMesh, AGlbMustNameWhatItsDataHave) {
  const std::string glb = test::dracoGlb(test::sphereMesh(10, 2), draco::MESH_EDGEBREAKER_ENCODING);
  const std::size_t json_size = littleUint32(glb.data() + 12);
  const auto refusal = [&](auto change) {
    nlohmann::json json = nlohmann::json::parse(glb.substr(20, json_size));
    change(json, json["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"]);
    const std::string other = test::toGlb(json, glb.substr(28 + json_size));
    return test::refusalOf<FormatError>([&] { readGltf(test::charsOf(other), "test.glb"); });
  };
  using Json = nlohmann::json;
  EXPECT_EQ(refusal([](Json&, Json&) {}), "");
  EXPECT_EQ(refusal([](Json& json, Json&) {  // the same data, referred to twice, are unpacked once
              json["meshes"][0]["primitives"].push_back(json["meshes"][0]["primitives"][0]);
            }),
            "");
  EXPECT_TRUE(has(refusal([](Json&, Json& draco) { draco["attributes"]["POSITION"] = 8; }), "the attribute with id 8"));
  EXPECT_TRUE(has(refusal([](Json&, Json& draco) { draco["attributes"] = 8; }), "has no object \"attributes\""));
  EXPECT_TRUE(has(refusal([](Json&, Json& draco) { draco["attributes"] = Json::object(); }), "POSITION"));
  EXPECT_TRUE(has(refusal([](Json&, Json& draco) { draco["bufferView"] = 3; }), "bufferViews[3]"));
  EXPECT_TRUE(has(refusal([](Json& json, Json&) { json["bufferViews"][0]["byteLength"] = 1 << 30; }), "reaches beyond"));
  EXPECT_TRUE(has(refusal([](Json& json, Json&) { json["bufferViews"][0]["byteOffset"] = 4; }), "reaches beyond"));
  EXPECT_TRUE(has(refusal([](Json& json, Json&) { json["meshes"][0]["primitives"][0]["mode"] = 6; }), "is a fan"));
}

}  // namespace
}  // namespace spheretree::formats
