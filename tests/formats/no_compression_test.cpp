// SPDX-License-Identifier: Apache-2.0
// The reader of glTF where it was built without SPHERETREE_COMPRESSED_GLTF.
#include <gtest/gtest.h>

#include "spheretree/formats/errors.h"
#include "spheretree/formats/gltf.h"
#include "support/sample_gltf.h"
#include "support/texts.h"

namespace spheretree::formats {
namespace {

using Json = nlohmann::json;

std::string refusalOfGltf(const Json& json) {
  const std::string glb = test::toGlb(json, test::tetrahedronBuffer());
  return test::refusalOf<FormatError>([&] { readGltf(test::charsOf(glb), "test.glb"); });
}

TEST(NoCompression, CompressedPartsAreRefusedByName) {
  Json draco = test::tetrahedronJson();
  draco["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"] = {{"bufferView", 0}, {"attributes", {{"POSITION", 0}}}};
  EXPECT_NE(refusalOfGltf(draco).find("is compressed by Draco, which this program was built without"), std::string::npos)
      << refusalOfGltf(draco);
  Json packed = test::tetrahedronJson();
  packed["bufferViews"][0]["extensions"]["EXT_meshopt_compression"] = {
      {"buffer", 0}, {"byteLength", 20}, {"byteStride", 12}, {"count", 4}, {"mode", "ATTRIBUTES"}};
  EXPECT_NE(refusalOfGltf(packed).find("is compressed by meshoptimizer, which this program was built without"), std::string::npos)
      << refusalOfGltf(packed);
}

}  // namespace
}  // namespace spheretree::formats
