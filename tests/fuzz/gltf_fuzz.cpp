// SPDX-License-Identifier: Apache-2.0
// Feeds any bytes to the reader of glTF and GLB files.
#include "spheretree/formats/gltf.h"

#include "fuzz/mesh_fuzz.h"
#include "support/compressed_gltf.h"
#include "support/sample_gltf.h"
#include "support/shapes.h"

namespace spheretree::fuzz {

std::vector<std::string> seeds() {
  nlohmann::json json = test::tetrahedronJson();
  const std::string plain = test::toGlb(json, test::tetrahedronBuffer());
  json["nodes"] =
      nlohmann::json::parse(R"([{"children": [1], "scale": [-1, 2, 1]}, {"mesh": 0, "rotation": [0, 0, 0, 1], "translation": [1, 0, 0]}])");
  json["meshes"][0]["primitives"][0]["mode"] = 5;
  json["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", 50}, {"byteLength", 4}});
  json["accessors"][0]["sparse"] = {
      {"count", 2}, {"indices", {{"bufferView", 2}, {"componentType", 5121}}}, {"values", {{"bufferView", 0}, {"byteOffset", 4}}}};
  json["buffers"][0]["uri"] =
      "data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAAIA/AAACAAEAAAABAAMAAAADAAIAAQACAAMA";
  const TriangleMesh box = test::quartered(test::boxMesh({0, 0, 0}, {3, 4, 5}));
  nlohmann::json instances = test::tetrahedronJson();
  instances["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"] = 0;  // four
  return {plain,
          json.dump(),
          test::tetrahedronJson().dump(),
          test::toGlb(instances, test::tetrahedronBuffer()),
          test::meshoptGlb(box),
          test::meshoptGlb(box, "INDICES"),
          test::dracoGlb(box, draco::MESH_EDGEBREAKER_ENCODING, 8),
          test::dracoGlb(box, draco::MESH_SEQUENTIAL_ENCODING)};
}

}  // namespace spheretree::fuzz

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  spheretree::fuzz::feedMesh(data, size, [](auto bytes, const std::string& name) { return spheretree::formats::readGltf(bytes, name); });
  return 0;
}
