// SPDX-License-Identifier: GPL-3.0-or-later
#include "assimp_mesh.h"

#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <assimp/IOStream.hpp>
#include <assimp/IOSystem.hpp>
#include <assimp/Importer.hpp>
#include <charconv>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "spheretree/formats/errors.h"
#include "spheretree/formats/obj.h"

namespace spheretree::mesh_import {
namespace {

class MemoryStream : public Assimp::IOStream {
 public:
  explicit MemoryStream(std::span<const std::byte> bytes) : bytes_(bytes) {}
  std::size_t Read(void* to, std::size_t size, std::size_t count) override {
    const std::size_t whole = size == 0 ? 0 : std::min(count, (bytes_.size() - at_) / size);
    if (whole > 0) std::memcpy(to, bytes_.data() + at_, whole * size);
    at_ += whole * size;
    return whole;
  }
  std::size_t Write(const void*, std::size_t, std::size_t) override { return 0; }
  aiReturn Seek(std::size_t offset, aiOrigin origin) override {
    const std::size_t from = origin == aiOrigin_SET ? 0 : origin == aiOrigin_CUR ? at_ : bytes_.size();
    const std::size_t to = from + offset;  // relative to the end, offsets are negative
    if (to > bytes_.size()) return aiReturn_FAILURE;
    at_ = to;
    return aiReturn_SUCCESS;
  }
  std::size_t Tell() const override { return at_; }
  std::size_t FileSize() const override { return bytes_.size(); }
  void Flush() override {}

 private:
  std::span<const std::byte> bytes_;
  std::size_t at_ = 0;
};

/// A file system with a single file.
class OneFile : public Assimp::IOSystem {
 public:
  OneFile(std::string name, std::span<const std::byte> bytes) : name_(std::move(name)), bytes_(bytes) {}
  bool Exists(const char* name) const override { return name_ == name; }
  char getOsSeparator() const override { return '/'; }
  Assimp::IOStream* Open(const char* name, const char*) override { return Exists(name) ? new MemoryStream(bytes_) : nullptr; }
  void Close(Assimp::IOStream* stream) override { delete stream; }

 private:
  std::string name_;
  std::span<const std::byte> bytes_;
};

std::string lower(std::string text) {
  for (char& c : text)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return text;
}

/// The name of a part: one line without blanks at its ends.
std::string partName(const aiString& name) {
  std::string text = name.C_Str();
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 0x20) c = '_';
  const std::size_t first = text.find_first_not_of(' ');
  return first == std::string::npos ? "part" : text.substr(first, text.find_last_not_of(' ') - first + 1);
}

Eigen::Affine3d poseOf(const aiMatrix4x4& m) {
  Eigen::Matrix4d matrix;
  matrix << m.a1, m.a2, m.a3, m.a4, m.b1, m.b2, m.b3, m.b4, m.c1, m.c2, m.c3, m.c4, m.d1, m.d2, m.d3, m.d4;
  return Eigen::Affine3d(matrix);
}

double unitOf(const aiScene& scene, const std::string& ending) {
  if (ending == ".dae" || ending == ".zae") return 1000;  // Assimp has converted it to metres
  double centimetres = 1;
  float single = 1;
  if (ending == ".fbx" && scene.mMetaData) {
    if (scene.mMetaData->Get("UnitScaleFactor", centimetres)) return 10 * centimetres;
    if (scene.mMetaData->Get("UnitScaleFactor", single)) return 10.0 * static_cast<double>(single);
  }
  return 1;
}

/// The scene as OBJ, which formats::readObj() then checks like any other file.
class ObjText {
 public:
  explicit ObjText(const aiScene& scene) : scene_(scene) {
    struct Visit {
      const aiNode* node;
      Eigen::Affine3d parent;
    };
    std::vector<Visit> stack{{scene.mRootNode, Eigen::Affine3d::Identity()}};
    while (!stack.empty()) {
      const Visit visit = stack.back();
      stack.pop_back();
      const Eigen::Affine3d pose = visit.parent * poseOf(visit.node->mTransformation);
      if (visit.node->mNumMeshes > 0) text_ += "o " + partName(visit.node->mName) + "\n";
      for (unsigned k = 0; k < visit.node->mNumMeshes; ++k) add(*scene_.mMeshes[visit.node->mMeshes[k]], pose);
      for (unsigned k = visit.node->mNumChildren; k-- > 0;) stack.push_back({visit.node->mChildren[k], pose});
    }
  }
  const std::string& text() const { return text_; }

 private:
  void add(const aiMesh& mesh, const Eigen::Affine3d& pose) {
    for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
      const Eigen::Vector3d p = pose * Eigen::Vector3d(mesh.mVertices[v].x, mesh.mVertices[v].y, mesh.mVertices[v].z);
      text_ += "v";
      for (const double x : p) addNumber(x);
      text_ += "\n";
    }
    const bool is_mirrored = pose.linear().determinant() < 0;
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      const aiFace& face = mesh.mFaces[f];
      if (face.mNumIndices != 3) continue;
      text_ += "f";
      for (const unsigned k : {0u, is_mirrored ? 2u : 1u, is_mirrored ? 1u : 2u})
        text_ += " " + std::to_string(vertices_ + std::size_t{1} + face.mIndices[k]);
      text_ += "\n";
    }
    vertices_ += mesh.mNumVertices;
  }

  void addNumber(double value) {
    char digits[32];
    text_ += " ";
    text_.append(digits, std::to_chars(digits, digits + sizeof digits, value).ptr);
  }

  const aiScene& scene_;
  std::string text_;
  std::size_t vertices_ = 0;
};

}  // namespace

formats::MeshFile readByAssimp(std::span<const std::byte> bytes, const std::filesystem::path& path, std::optional<double> unit_mm) {
  const std::string ending = lower(path.extension().string());
  const std::string inner_name = "mesh" + ending;
  Assimp::Importer importer;
  importer.SetIOHandler(new OneFile(inner_name, bytes));  // the importer owns it
  importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_POINT | aiPrimitiveType_LINE);
  importer.SetPropertyBool(AI_CONFIG_IMPORT_FBX_PRESERVE_PIVOTS, false);
  const aiScene* scene = importer.ReadFile(inner_name, aiProcess_Triangulate | aiProcess_SortByPType);
  if (!scene || !scene->mRootNode || scene->mNumMeshes == 0) {
    const std::string why = importer.GetErrorString();
    throw formats::FormatError(path.string() + ": Assimp cannot read it" + (why.empty() ? "" : ": " + why) +
                               ". Export it again, or as OBJ, STL, PLY or glTF.");
  }
  const ObjText obj(*scene);
  formats::MeshFile file = formats::readObj(obj.text(), path.string(), unit_mm.value_or(unitOf(*scene, ending)));
  file.format = ending.empty() ? "Assimp" : ending.substr(1);
  return file;
}

}  // namespace spheretree::mesh_import
