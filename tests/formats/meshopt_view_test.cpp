// SPDX-License-Identifier: Apache-2.0
#include "gltf/meshopt_view.h"

#include <gtest/gtest.h>
#include <meshoptimizer.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

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

std::vector<unsigned char> decode(const MeshoptView& view) { return decodeMeshopt(view, MeshAssembly("test.glb", 1000), "bufferViews[0]"); }

std::string viewRefusal(const MeshoptView& view) {
  return test::refusalOf<FormatError>([&] { decode(view); });
}

/// Vertices of `stride` random bytes each.
std::vector<unsigned char> randomVertices(std::size_t count, std::size_t stride) {
  test::Random random(count + stride);
  std::vector<unsigned char> bytes(count * stride);
  for (unsigned char& byte : bytes) byte = static_cast<unsigned char>(random.below(7) == 0 ? random.next() : 3);
  return bytes;
}

std::vector<unsigned char> encoded(const std::vector<unsigned char>& vertices, std::size_t count, std::size_t stride) {
  std::vector<unsigned char> bytes(meshopt_encodeVertexBufferBound(count, stride));
  bytes.resize(meshopt_encodeVertexBuffer(bytes.data(), bytes.size(), vertices.data(), count, stride));
  return bytes;
}

TEST(MeshoptView, UnpacksWhatTheLibraryPacked) {
  for (const std::size_t stride : {4u, 12u, 24u, 256u})
    for (const std::size_t count : {1u, 15u, 16u, 257u, 3000u}) {
      const std::vector<unsigned char> vertices = randomVertices(count, stride), packed = encoded(vertices, count, stride);
      EXPECT_EQ(decode({.bytes = packed, .count = count, .stride = stride, .mode = "ATTRIBUTES", .filter = "NONE"}), vertices);
    }
  // The smallest possible data: only zeros, 64 bytes of which take one.
  const std::vector<unsigned char> zeros(256 * 256 * 16), packed = encoded(zeros, 256 * 16 * 4, 64);
  EXPECT_EQ(decode({.bytes = packed, .count = 256 * 16 * 4, .stride = 64, .mode = "ATTRIBUTES", .filter = "NONE"}), zeros);
}

TEST(MeshoptView, FiltersGiveUnitVectorsQuaternionsAndFloats) {
  const std::size_t count = 100;
  test::Random random(3);
  std::vector<float> vectors, quaternions, numbers;
  for (std::size_t i = 0; i < count; ++i) {
    Eigen::Vector4f q;
    for (int axis = 0; axis < 4; ++axis) q[axis] = static_cast<float>(random.between(-1, 1));
    const Eigen::Vector3f v = q.head<3>().normalized();
    q.normalize();
    vectors.insert(vectors.end(), {v.x(), v.y(), v.z(), 0});
    quaternions.insert(quaternions.end(), {q.x(), q.y(), q.z(), q.w()});
    numbers.insert(numbers.end(), {q.x() * 1e6f, q.y() * 1e-6f});
  }
  const auto packed = [&](auto encode, const std::vector<float>& values, int bits) {
    std::vector<unsigned char> filtered(count * 8);
    encode(filtered.data(), count, 8, bits, values.data());
    return encoded(filtered, count, 8);
  };
  const auto unpacked = [&](const std::vector<unsigned char>& bytes, const std::string& filter) {
    return decode({.bytes = bytes, .count = count, .stride = 8, .mode = "ATTRIBUTES", .filter = filter});
  };
  const auto short_at = [](const std::vector<unsigned char>& bytes, std::size_t k) {
    return static_cast<std::int16_t>(bytes[2 * k] | bytes[2 * k + 1] << 8) / 32767.0;
  };
  const auto octahedral = unpacked(packed(&meshopt_encodeFilterOct, vectors, 16), "OCTAHEDRAL");
  const auto turns = unpacked(packed(&meshopt_encodeFilterQuat, quaternions, 16), "QUATERNION");
  const auto floats = unpacked(packed(&meshopt_encodeFilterExp, numbers, 24), "EXPONENTIAL");
  for (std::size_t i = 0; i < count; ++i) {
    double same = 0;
    for (std::size_t axis = 0; axis < 4; ++axis) {
      if (axis < 3) {
        EXPECT_NEAR(short_at(octahedral, 4 * i + axis), vectors[4 * i + axis], 2e-4);
      }
      same += short_at(turns, 4 * i + axis) * quaternions[4 * i + axis];
    }
    EXPECT_NEAR(std::abs(same), 1, 1e-3);  // q and -q are the same rotation
    for (std::size_t axis = 0; axis < 2; ++axis) {
      float value;
      std::memcpy(&value, floats.data() + 8 * i + 4 * axis, 4);
      EXPECT_NEAR(value, numbers[2 * i + axis], 1.0);  // both share one exponent: that of the larger, below 2^20
    }
  }
}

TEST(MeshoptView, RefusesWhatItsBytesCannotHold) {
  const std::vector<unsigned char> vertices = randomVertices(100, 12), packed = encoded(vertices, 100, 12);
  const MeshoptView view{.bytes = packed, .count = 100, .stride = 12, .mode = "ATTRIBUTES", .filter = "NONE"};
  const auto with = [&](auto change) {
    MeshoptView other = view;
    change(other);
    return viewRefusal(other);
  };
  for (const std::uint64_t count : {std::uint64_t{1} << 32, ~std::uint64_t{0}, ~std::uint64_t{0} / 12 + 2})
    EXPECT_TRUE(has(with([&](MeshoptView& v) { v.count = count; }), "bufferViews[0] announces " + std::to_string(count))) << count;
  for (const std::uint64_t stride : {0, 2, 13, 260, 1 << 30})
    EXPECT_TRUE(has(with([&](MeshoptView& v) { v.stride = stride; }), "byteStride of " + std::to_string(stride)));
  EXPECT_TRUE(has(with([](MeshoptView& v) { v.count = 200; }), "does not unpack"));
  EXPECT_TRUE(has(with([](MeshoptView& v) { v.count = 0; }), "no element"));
  EXPECT_TRUE(has(with([](MeshoptView& v) { v.bytes = {}; }), "no element"));
  EXPECT_TRUE(has(with([](MeshoptView& v) { v.mode = "POINTS"; }), "\"POINTS\""));
  EXPECT_TRUE(has(with([](MeshoptView& v) { v.filter = "COLOR"; }), "\"COLOR\""));
  EXPECT_TRUE(has(with([](MeshoptView& v) { v.filter = "QUATERNION"; }), "does not fit its filter"));
  EXPECT_TRUE(has(with([](MeshoptView& v) { v.filter = "OCTAHEDRAL"; }), "does not fit its filter"));
  EXPECT_TRUE(has(with([](MeshoptView& v) { v.mode = "INDICES"; }), "byteStride of 12, not 2 or 4"));
  EXPECT_TRUE(has(with([](MeshoptView& v) { v.mode = "TRIANGLES", v.stride = 4; }), "not a multiple of 3"));
  EXPECT_TRUE(has(with([](MeshoptView& v) { v.mode = "TRIANGLES", v.stride = 4, v.count = 3 << 28; }), "announces 805306368"));
  EXPECT_TRUE(has(with([](MeshoptView& v) { v.mode = "INDICES", v.stride = 4, v.count = 1 << 30; }), "announces 1073741824"));
  EXPECT_TRUE(has(with([](MeshoptView& v) { v.mode = "INDICES", v.stride = 4, v.filter = "EXPONENTIAL"; }), "only attributes"));
  std::vector<unsigned char> newer = packed;
  newer[0] = 0xa1;
  EXPECT_TRUE(has(with([&](MeshoptView& v) { v.bytes = newer; }), "gltfpack -ce ext"));
}

// Any damage gives the announced number of bytes or a refusal; a sanitizer also proves that it reads only its own
// bytes.
TEST(MeshoptView, DamageIsRefusedOrHarmless) {
  const TriangleMesh ball = test::sphereMesh(10, 3);
  const std::vector<std::uint32_t> indices = test::indicesOf(ball);
  std::vector<unsigned char> triangles(meshopt_encodeIndexBufferBound(indices.size(), ball.positions.size()));
  triangles.resize(meshopt_encodeIndexBuffer(triangles.data(), triangles.size(), indices.data(), indices.size()));
  std::vector<unsigned char> sequence(meshopt_encodeIndexSequenceBound(indices.size(), ball.positions.size()));
  sequence.resize(meshopt_encodeIndexSequence(sequence.data(), sequence.size(), indices.data(), indices.size()));
  const std::vector<unsigned char> vertices = encoded(randomVertices(300, 12), 300, 12);
  const MeshoptView views[] = {{.bytes = vertices, .count = 300, .stride = 12, .mode = "ATTRIBUTES", .filter = "EXPONENTIAL"},
                               {.bytes = triangles, .count = indices.size(), .stride = 4, .mode = "TRIANGLES", .filter = "NONE"},
                               {.bytes = sequence, .count = indices.size(), .stride = 2, .mode = "INDICES", .filter = "NONE"}};
  test::Random random(11);
  std::size_t refused = 0;
  for (const MeshoptView& whole : views) {
    for (std::size_t size = 0; size < whole.bytes.size(); ++size) {
      const std::vector<unsigned char> cut(whole.bytes.begin(), whole.bytes.begin() + static_cast<std::ptrdiff_t>(size));
      MeshoptView view = whole;
      view.bytes = cut;
      EXPECT_THROW(decode(view), FormatError) << whole.mode << " " << size;
    }
    for (int k = 0; k < 2000; ++k) {
      std::vector<unsigned char> bytes(whole.bytes.begin(), whole.bytes.end());
      for (std::uint64_t n = 0; n <= random.below(3); ++n) bytes[random.below(bytes.size())] = static_cast<unsigned char>(random.next());
      MeshoptView view = whole;
      view.bytes = bytes;
      try {
        EXPECT_EQ(decode(view).size(), view.count * view.stride);
      } catch (const FormatError&) {
        ++refused;
      }
    }
  }
  EXPECT_GT(refused, 500u);
}

TEST(MeshoptView, AGlbOfItIsTheMeshItself) {
  const TriangleMesh torus = test::torusMesh(20, 6, 40, 18);
  const MeshFile plain = readGltf(test::charsOf(test::plainGlb(torus)), "plain.glb");
  for (const char* extension : {"EXT_meshopt_compression", "KHR_meshopt_compression"})
    for (const char* mode : {"TRIANGLES", "INDICES"}) {
      const std::string glb = test::meshoptGlb(torus, mode, extension);
      const MeshFile file = readGltf(test::charsOf(glb), "packed.glb");
      EXPECT_TRUE(file.notes.empty());
      EXPECT_EQ(file.mesh.part_names, plain.mesh.part_names);
      ASSERT_EQ(file.mesh.triangles.size(), plain.mesh.triangles.size());
      if (std::string_view(mode) == "INDICES") {
        EXPECT_EQ(file.mesh.positions, plain.mesh.positions);
        EXPECT_EQ(file.mesh.triangles, plain.mesh.triangles);
      } else {
        EXPECT_DOUBLE_EQ(test::volumeOf(file.mesh), test::volumeOf(plain.mesh));
      }
    }
}

TEST(MeshoptView, AGlbMayNotUnpackTheSameBytesTwiceNorLieAboutTheirSize) {
  const TriangleMesh torus = test::torusMesh(20, 6, 12, 8);
  const std::string glb = test::meshoptGlb(torus);
  const std::size_t json_size = littleUint32(glb.data() + 12);
  const auto refusal = [&](auto change) {
    nlohmann::json json = nlohmann::json::parse(glb.substr(20, json_size));
    change(json);
    const std::string other = test::toGlb(json, glb.substr(28 + json_size));
    return test::refusalOf<FormatError>([&] { readGltf(test::charsOf(other), "test.glb"); });
  };
  EXPECT_EQ(refusal([](nlohmann::json&) {}), "");
  EXPECT_TRUE(has(refusal([](nlohmann::json& json) {
                    json["bufferViews"].push_back(json["bufferViews"][0]);
                    json["accessors"].push_back(json["accessors"][0]);
                    json["accessors"][2]["bufferView"] = 2;
                    json["meshes"][0]["primitives"].push_back(json["meshes"][0]["primitives"][0]);
                    json["meshes"][0]["primitives"][1]["attributes"]["POSITION"] = 2;
                  }),
                  "bufferViews[2] unpacks bytes that another view unpacks"));
  const auto view = [](nlohmann::json& json, int k) -> nlohmann::json& {
    return json["bufferViews"][k]["extensions"]["EXT_meshopt_compression"];
  };
  EXPECT_TRUE(has(refusal([&](nlohmann::json& json) { json["bufferViews"][0]["byteLength"] = 96 * 12 + 4; }), "but unpacks to 1152"));
  EXPECT_TRUE(has(refusal([&](nlohmann::json& json) { view(json, 0)["byteOffset"] = ~std::uint64_t{0}; }), "reaches beyond"));
  EXPECT_TRUE(has(refusal([&](nlohmann::json& json) { view(json, 0)["byteLength"] = std::uint64_t{1} << 40; }), "reaches beyond"));
  EXPECT_TRUE(has(refusal([&](nlohmann::json& json) { view(json, 0)["buffer"] = 7; }), "buffers[7]"));
  EXPECT_TRUE(has(refusal([&](nlohmann::json& json) { view(json, 0)["buffer"] = 1; }), "buffers[1] has no data without its extensions"));
  EXPECT_TRUE(has(refusal([&](nlohmann::json& json) { view(json, 0).erase("count"); }), "has no \"count\""));
  EXPECT_TRUE(
      has(refusal([&](nlohmann::json& json) { view(json, 0)["count"] = std::uint64_t{1} << 60; }), "announces 1152921504606846976"));
}

}  // namespace
}  // namespace spheretree::formats
