// SPDX-License-Identifier: Apache-2.0
// Joints and weights that Draco compressed.
#include <gtest/gtest.h>

#include "spheretree/formats/gltf.h"
#include "spheretree/formats/mesh_file.h"
#include "support/compressed_gltf.h"
#include "support/mesh_measures.h"
#include "support/texts.h"

namespace spheretree::formats {
namespace {

TEST(GltfNodes, DracoMayHoldJointsAndWeights) {
  test::Bent bent(false);
  const std::string draco = test::dracoBytes(bent.rod, draco::MESH_EDGEBREAKER_ENCODING, 0, bent.skin);
  const MeshFile plain = bent.document.read();
  nlohmann::json& json = bent.document.json;
  json["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", bent.document.buffer.size()}, {"byteLength", draco.size()}});
  bent.document.buffer += draco;
  json["buffers"][0]["byteLength"] = bent.document.buffer.size();
  json["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"] = {
      {"bufferView", json["bufferViews"].size() - 1}, {"attributes", {{"POSITION", 7}, {"JOINTS_0", 8}, {"WEIGHTS_0", 9}}}};
  const MeshFile packed = bent.document.read();
  EXPECT_EQ(packed.mesh.positions.size(), plain.mesh.positions.size());
  EXPECT_NEAR(test::volumeOf(packed.mesh), test::volumeOf(plain.mesh), 1e-9 * test::volumeOf(plain.mesh));
  json["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"]["attributes"]["JOINTS_0"] = 9;
  EXPECT_TRUE(test::has(bent.document.refusal(), "joints are of a type that does not fit"));
}

}  // namespace
}  // namespace spheretree::formats
