// SPDX-License-Identifier: Apache-2.0
// Instances and skins, as the reader of glTF places them.
#include "gltf/gltf_nodes.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "spheretree/formats/errors.h"
#include "spheretree/formats/gltf.h"
#include "spheretree/formats/mesh_file.h"
#include "support/gltf_document.h"
#include "support/mesh_measures.h"
#include "support/random.h"
#include "support/shapes.h"
#include "support/texts.h"

namespace spheretree::formats {
namespace {

constexpr const char* kInstancing = "EXT_mesh_gpu_instancing";

using Json = nlohmann::json;
using test::Bent;
using test::Document;
using test::has;

TEST(GltfNodes, EachInstanceIsAPartWhereItStands) {
  Document document;
  test::Random random(4);
  std::vector<float> translations, rotations, scales;
  std::vector<Eigen::Affine3d> expected;
  const Eigen::Affine3d node = Eigen::Translation3d(1, 2, 3) * Eigen::AngleAxisd(0.5, Eigen::Vector3d(0.6, 0, 0.8));
  for (int i = 0; i < 5; ++i) {
    const Eigen::Vector3d t = random.inCube(5);
    const Eigen::Quaterniond q(Eigen::AngleAxisd(random.between(-3, 3), random.direction()));
    const Eigen::Vector3d s = i == 3 ? Eigen::Vector3d(-1, 2, 1) : random.inBox({0.5, 0.5, 0.5}, {2, 2, 2});  // one is mirrored
    for (int axis = 0; axis < 3; ++axis) translations.push_back(static_cast<float>(t[axis])), scales.push_back(static_cast<float>(s[axis]));
    for (int axis = 0; axis < 4; ++axis) rotations.push_back(static_cast<float>(q.coeffs()[axis]));
    expected.push_back(node * Eigen::Translation3d(t) * q * Eigen::Scaling(s));
  }
  const Eigen::Quaterniond q(node.rotation());
  document.json["nodes"][0]["translation"] = {1, 2, 3};
  document.json["nodes"][0]["rotation"] = {q.x(), q.y(), q.z(), q.w()};
  Json& attributes = document.json["nodes"][0]["extensions"][kInstancing]["attributes"];
  attributes["TRANSLATION"] = document.add(translations, "VEC3", 3);
  attributes["ROTATION"] = document.add(rotations, "VEC4", 4);
  attributes["SCALE"] = document.add(scales, "VEC3", 3);
  attributes["_ID"] = 999;  // has no effect
  document.json["extensionsRequired"] = {kInstancing};
  const MeshFile file = document.read();
  EXPECT_EQ(file.mesh.part_names, (std::vector<std::string>{"tooth_0", "tooth_1", "tooth_2", "tooth_3", "tooth_4"}));
  ASSERT_EQ(file.mesh.triangles.size(), 20u);
  for (std::size_t i = 0; i < 5; ++i) {
    const TriangleMesh part = selectPart(file.mesh, "tooth_" + std::to_string(i));
    EXPECT_NEAR(test::volumeOf(part), std::abs(expected[i].linear().determinant()) * 1e9 / 6, 1e4);
    for (const Eigen::Vector3d& corner :
         {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(0, 0, 1)}) {
      double nearest = 1e9;
      for (const Eigen::Vector3d& p : part.positions) nearest = std::min(nearest, (p - 1000 * (expected[i] * corner)).norm());
      EXPECT_LT(nearest, 0.02) << i;
    }
  }
}

TEST(GltfNodes, InstancesMayBeQuantisedAndMustAgree) {
  Document document;
  Json& attributes = document.json["nodes"][0]["extensions"][kInstancing]["attributes"];
  attributes["ROTATION"] = document.add(std::vector<std::int8_t>{0, 0, 90, 90, 0, 0, 0, 127}, "VEC4", 4, 5120, true);  // 90 degrees; none
  EXPECT_EQ(document.read().mesh.triangles.size(), 8u);
  Document wrong = document;
  wrong.json["nodes"][0]["extensions"][kInstancing]["attributes"]["SCALE"] = wrong.add(std::vector<float>(9, 1), "VEC3", 3);
  EXPECT_TRUE(has(wrong.refusal(), "attributes of 2 and 3 instances")) << wrong.refusal();
  wrong = document;
  wrong.json["nodes"][0]["extensions"][kInstancing]["attributes"] = {{"ROTATION", 0}};
  EXPECT_TRUE(has(wrong.refusal(), "accessors[0] is used by nodes[0].EXT_mesh_gpu_instancing, but is not of type VEC4"));
  wrong.json["nodes"][0]["extensions"][kInstancing]["attributes"] = {{"ROTATION", 77}};
  EXPECT_TRUE(has(wrong.refusal(), "accessors[77]"));
  wrong.json["nodes"][0]["extensions"][kInstancing]["attributes"] = Json::object();
  EXPECT_TRUE(has(wrong.refusal(), "neither TRANSLATION nor ROTATION nor SCALE"));
  wrong.json["nodes"][0]["extensions"][kInstancing]["attributes"] = {{"ROTATION", wrong.add(std::vector<float>(8, 1), "VEC4", 4)}};
  EXPECT_TRUE(has(wrong.refusal(), "not a unit quaternion"));
  wrong = document;
  wrong.json["nodes"][0]["extensions"][kInstancing]["attributes"] = {
      {"TRANSLATION", wrong.add(std::vector<std::int8_t>(3'000'003, 0), "VEC3", 3, 5120)}};
  EXPECT_TRUE(has(wrong.refusal(), "4000000 triangles")) << "a million and one instances of four triangles";
}

TEST(GltfNodes, ASkinStandsInItsRestPose) {
  for (const bool quantised : {false, true}) {
    const Bent bent(quantised);
    const MeshFile file = bent.document.read();
    ASSERT_EQ(file.mesh.triangles.size(), bent.rod.triangles.size());
    ASSERT_EQ(file.mesh.positions.size(), bent.expected.size());
    for (const Eigen::Vector3d& p : bent.expected) {
      double nearest = 1e9;
      for (const Eigen::Vector3d& q : file.mesh.positions) nearest = std::min(nearest, (p - q).norm());
      EXPECT_LT(nearest, 1e-2);
    }
    EXPECT_GT(test::volumeOf(file.mesh), 0);
    ASSERT_EQ(file.notes.size(), 1u);
    EXPECT_EQ(file.notes[0], "1 skin was read in the rest pose.");
  }
}

TEST(GltfNodes, WrongSkinsAreRefused) {
  const auto with = [](const char* pointer, Json value) {
    Bent bent(false);
    bent.document.json[Json::json_pointer(pointer)] = std::move(value);
    return bent.document.refusal();
  };
  EXPECT_EQ(with("/nodes/0/name", "rod"), "");
  EXPECT_TRUE(has(with("/nodes/0/skin", 1), "skins[1]"));
  EXPECT_TRUE(has(with("/skins/0/joints", Json::array()), "has no joints"));
  EXPECT_TRUE(has(with("/skins/0/joints", {1, 9}), "nodes[9]"));
  EXPECT_TRUE(has(with("/skins/0/joints", {1}), "names joint 1 for vertex"));
  EXPECT_TRUE(has(with("/skins/0/joints", {1, 2, 2}), "has 3 joints, but 2 matrices"));
  EXPECT_TRUE(has(with("/skins/0/inverseBindMatrices", 2), "not of type MAT4"));
  EXPECT_TRUE(has(with("/scenes/0/nodes", {0}), "that is not in the scene"));
  EXPECT_TRUE(has(with("/accessors/4/count", 3), "fewer joints or weights"));
  EXPECT_TRUE(has(with("/meshes/0/primitives/0/attributes/JOINTS_0", 2), "VEC4"));
  Bent bent(false);
  bent.document.json["meshes"][0]["primitives"][0]["attributes"].erase("WEIGHTS_0");
  const MeshFile stored = bent.document.read();
  EXPECT_TRUE(has(stored.notes.back(), "no joints and weights")) << stored.notes.back();
}

}  // namespace
}  // namespace spheretree::formats
