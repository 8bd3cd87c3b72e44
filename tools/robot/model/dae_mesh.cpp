// SPDX-License-Identifier: GPL-3.0-or-later
#include "robot/model/dae_mesh.h"

#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <Eigen/Geometry>
#include <assimp/Importer.hpp>
#include <string>

#include "spheretree/core/mesh_edit.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/file_io.h"

namespace spheretree::robot {
namespace {

Eigen::Affine3d frameOf(const aiMatrix4x4& m) {
  Eigen::Affine3d frame = Eigen::Affine3d::Identity();
  frame.matrix().topRows<3>() << m.a1, m.a2, m.a3, m.a4, m.b1, m.b2, m.b3, m.b4, m.c1, m.c2, m.c3, m.c4;
  return frame;
}

void addMesh(const aiMesh& part, const Eigen::Affine3d& frame, double unit_mm, TriangleMesh& mesh) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (unsigned v = 0; v < part.mNumVertices; ++v) {
    const aiVector3D& p = part.mVertices[v];
    mesh.positions.push_back(unit_mm * (frame * Eigen::Vector3d(p.x, p.y, p.z)));
  }
  const bool is_mirrored = frame.linear().determinant() < 0;
  for (unsigned f = 0; f < part.mNumFaces; ++f) {
    const aiFace& face = part.mFaces[f];
    if (face.mNumIndices != 3) continue;  // points and lines
    Triangle triangle{first + face.mIndices[0], first + face.mIndices[1], first + face.mIndices[2]};
    if (is_mirrored) std::swap(triangle[1], triangle[2]);
    mesh.triangles.push_back(triangle);
  }
}

void addNode(const aiScene& scene, const aiNode& node, const Eigen::Affine3d& above, double unit_mm, TriangleMesh& mesh) {
  const Eigen::Affine3d frame = above * frameOf(node.mTransformation);
  for (unsigned i = 0; i < node.mNumMeshes; ++i) addMesh(*scene.mMeshes[node.mMeshes[i]], frame, unit_mm, mesh);
  for (unsigned i = 0; i < node.mNumChildren; ++i) addNode(scene, *node.mChildren[i], frame, unit_mm, mesh);
}

}  // namespace

TriangleMesh readDae(const std::filesystem::path& path, double unit_mm) {
  const std::vector<std::byte> bytes = formats::readFile(path);
  Assimp::Importer importer;
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
  const aiScene* scene = importer.ReadFileFromMemory(bytes.data(), bytes.size(), aiProcess_Triangulate, "dae");
  if (!scene || !scene->mRootNode)
    throw formats::FormatError(path.string() + ": is not a Collada file that can be read (" + importer.GetErrorString() +
                               "). Export it again, or as STL.");
  TriangleMesh mesh;
  addNode(*scene, *scene->mRootNode, Eigen::Affine3d::Identity(), unit_mm, mesh);
  for (std::size_t v = 0; v < mesh.positions.size(); ++v)
    if (!mesh.positions[v].allFinite())
      throw formats::FormatError(path.string() + ": vertex " + std::to_string(v) + " is not finite. Export it again.");
  if (mesh.triangles.empty()) throw formats::NoTriangleError(path.string() + ": has no triangle. A solid needs faces.");
  weldEqualVertices(mesh);
  return mesh;
}

}  // namespace spheretree::robot
