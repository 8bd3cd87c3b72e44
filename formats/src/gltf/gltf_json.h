// SPDX-License-Identifier: Apache-2.0
// The JSON of an untrusted glTF or GLB file, and the elements that it refers to: every access is checked.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>

#include "mesh/mesh_assembly.h"

namespace spheretree::formats {

bool isGlb(std::span<const char> bytes);
std::string place(const std::string& key, std::uint64_t index);  // for example "meshes[3]"
/// Refuses an element such as "meshes[3].primitives[0]".
[[noreturn]] void refuseElement(const MeshAssembly& assembly, const std::string& where, const std::string& what);

class GltfJson {
 public:
  using Json = nlohmann::json;

  /// @throws FormatError for anything but a GLB or the JSON of a .gltf, or for deeper nesting than glTF needs.
  GltfJson(std::span<const char> bytes, const MeshAssembly& assembly);

  const Json& root() const { return root_; }
  std::span<const char> binaryChunk() const { return binary_chunk_; }  // of a GLB; may be empty
  std::size_t bytesAfterEnd() const { return bytes_after_end_; }       // number of bytes after the announced end of a GLB

  [[noreturn]] void refuse(const std::string& where, const std::string& what) const { refuseElement(assembly_, where, what); }

  static const Json* find(const Json& object, const char* key);
  static std::string findText(const Json& object, const char* key);  // empty if it is missing or not a string
  /// An object within `object.extensions`; null if there is none.
  const Json* findExtension(const Json& object, const char* name) const;
  const Json& array(const char* key) const;  // at the top level; empty if it is missing
  /// `from`: the element that refers to it, for messages.
  const Json& element(const char* key, std::uint64_t index, const std::string& from) const;
  std::uint64_t asUnsigned(const Json& value, const std::string& where) const;
  std::optional<std::uint64_t> findUnsigned(const Json& object, const char* key, const std::string& where) const;
  std::uint64_t getUnsigned(const Json& object, const char* key, const std::string& where) const;
  const Json& getObject(const Json& object, const char* key, const std::string& where) const;

 private:
  std::span<const char> openContainer(std::span<const char> bytes);
  void parse(std::span<const char> text);

  const MeshAssembly& assembly_;
  std::span<const char> binary_chunk_;
  std::size_t bytes_after_end_ = 0;
  Json root_;
};

}  // namespace spheretree::formats
