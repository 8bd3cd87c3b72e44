// SPDX-License-Identifier: Apache-2.0
// A document of glTF that tests build up, and one whose mesh hangs on joints.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "spheretree/core/triangle_mesh.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/gltf.h"
#include "support/sample_gltf.h"
#include "support/shapes.h"
#include "support/texts.h"

namespace spheretree::test {

/// Four joints and weights for each vertex, if there are any.
struct SkinWeights {
  std::vector<std::uint8_t> joints;
  std::vector<float> weights;
};

inline std::vector<float> positionsOf(const TriangleMesh& mesh) {  // [m]
  std::vector<float> numbers;
  for (const Eigen::Vector3d& p : mesh.positions)
    for (int axis = 0; axis < 3; ++axis) numbers.push_back(static_cast<float>(p[axis] / 1000));
  return numbers;
}

inline std::vector<std::uint32_t> indicesOf(const TriangleMesh& mesh) {
  std::vector<std::uint32_t> indices;
  for (const Triangle& t : mesh.triangles) indices.insert(indices.end(), t.begin(), t.end());
  return indices;
}

template <class T>
std::string rawBytes(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

/// A document to which accessors of floats are added.
struct Document {
  nlohmann::json json = tetrahedronJson();
  std::string buffer = tetrahedronBuffer();

  template <class T>
  int add(const std::vector<T>& values, const char* type, std::size_t components, int component = 5126, bool normalised = false) {
    const std::string bytes = rawBytes(values);
    json["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", buffer.size()}, {"byteLength", bytes.size()}});
    json["accessors"].push_back({{"bufferView", json["bufferViews"].size() - 1},
                                 {"componentType", component},
                                 {"normalized", normalised},
                                 {"count", values.size() / components},
                                 {"type", type}});
    buffer += bytes;
    buffer.resize((buffer.size() + 3) / 4 * 4);
    json["buffers"][0]["byteLength"] = buffer.size();
    return static_cast<int>(json["accessors"].size()) - 1;
  }
  formats::MeshFile read() const { return formats::readGltf(charsOf(toGlb(json, buffer)), "test.glb"); }
  std::string refusal() const {
    return refusalOf<formats::FormatError>([&] { read(); });
  }
};

/// A bent rod: every vertex is moved by its joints, computed here by the formula of the specification alone.
struct Bent {
  TriangleMesh rod = boxMesh({0, 0, 0}, {1000, 100, 100});
  std::vector<Eigen::Vector3d> expected;
  SkinWeights skin;
  Document document;

  explicit Bent(bool quantised) {
    rod = quartered(quartered(rod));
    const Eigen::Affine3d hip = Eigen::Translation3d(0.2, 0, 1) * Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitY());
    const Eigen::Affine3d knee = hip * Eigen::Translation3d(0.5, 0, 0) * Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ());
    const Eigen::Affine3d bind[2] = {Eigen::Affine3d::Identity(), Eigen::Affine3d(Eigen::Translation3d(-0.5, 0, 0))};
    std::vector<float> positions = positionsOf(rod), matrices;
    std::vector<std::uint8_t> weight_bytes;
    for (const Eigen::Affine3d& m : bind)
      for (int k = 0; k < 16; ++k) matrices.push_back(static_cast<float>(m.matrix().data()[k]));
    for (const Eigen::Vector3d& p : rod.positions) {
      const double share = std::round(std::clamp(p.x() / 1000, 0.0, 1.0) * 255) / 255;
      skin.joints.insert(skin.joints.end(), {1, 0, 0, 0});
      skin.weights.insert(skin.weights.end(), {static_cast<float>(share), static_cast<float>(1 - share), 0, 0});
      weight_bytes.insert(weight_bytes.end(), {static_cast<std::uint8_t>(std::lround(255 * share)),
                                               static_cast<std::uint8_t>(std::lround(255 * (1 - share))), 0, 0});
      const Eigen::Vector3d metres = p / 1000;
      expected.push_back(1000 * (share * (knee * bind[1] * metres) + (1 - share) * (hip * bind[0] * metres)));
    }
    document.json["accessors"][0] = {};
    nlohmann::json& primitive = document.json["meshes"][0]["primitives"][0];
    primitive["attributes"]["POSITION"] = document.add(positions, "VEC3", 3);
    primitive["indices"] = document.add(indicesOf(rod), "SCALAR", 1, 5125);
    primitive["attributes"]["JOINTS_0"] = document.add(skin.joints, "VEC4", 4, 5121);
    primitive["attributes"]["WEIGHTS_0"] =
        quantised ? document.add(weight_bytes, "VEC4", 4, 5121, true) : document.add(skin.weights, "VEC4", 4);
    document.json["skins"] = {{{"joints", {1, 2}}, {"inverseBindMatrices", document.add(matrices, "MAT4", 16)}}};
    const Eigen::Quaterniond first(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitY()));
    const Eigen::Quaterniond second(Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ()));
    const auto turn = [](const Eigen::Quaterniond& q) { return nlohmann::json{q.x(), q.y(), q.z(), q.w()}; };
    document.json["nodes"] = {{{"mesh", 0}, {"skin", 0}, {"translation", {50, 60, 70}}},  // has no effect: joints place the mesh
                              {{"children", {2}}, {"translation", {0.2, 0, 1}}, {"rotation", turn(first)}},
                              {{"translation", {0.5, 0, 0}}, {"rotation", turn(second)}}};
    document.json["scenes"] = {{{"nodes", {0, 1}}}};
  }
};

}  // namespace spheretree::test
