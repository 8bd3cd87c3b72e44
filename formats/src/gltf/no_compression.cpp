// SPDX-License-Identifier: Apache-2.0
// In place of draco_mesh.cpp and meshopt_view.cpp where their libraries are not (SPHERETREE_COMPRESSED_GLTF).
#include "gltf/draco_mesh.h"
#include "gltf/gltf_json.h"
#include "gltf/meshopt_view.h"

namespace spheretree::formats {

constexpr const char* kAdvice = ", which this program was built without. Unpack the file: gltf-transform copy IN.glb OUT.glb";

DracoMesh decodeDraco(std::span<const unsigned char>, std::span<const std::uint64_t>, std::uint64_t, const MeshAssembly& assembly,
                      const std::string& where) {
  refuseElement(assembly, where, std::string("is compressed by Draco") + kAdvice);
}

std::vector<unsigned char> decodeMeshopt(const MeshoptView&, const MeshAssembly& assembly, const std::string& where) {
  refuseElement(assembly, where, std::string("is compressed by meshoptimizer") + kAdvice);
}

}  // namespace spheretree::formats
