// SPDX-License-Identifier: Apache-2.0
// The bytes of a glTF file's buffers: from the GLB's binary chunk, from data URIs, or from files beside it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "gltf/gltf_json.h"
#include "gltf/gltf_uris.h"

namespace spheretree::formats {

class GltfBuffers {
 public:
  /// Refers to both, which must outlive it. @param folder The folder of the glTF file; empty: no other file is opened.
  GltfBuffers(const GltfJson& json, std::filesystem::path folder, const MeshAssembly& assembly)
      : json_(json), uris_(std::move(folder), assembly) {}

  /// All announced bytes of a buffer, which is opened once and kept. Views are valid as long as this object and the
  /// file's bytes, or after moveInto() as long as the destination.
  /// @throws FormatError for a buffer without data or with too few; FileError for a file that cannot be read.
  std::span<const unsigned char> bytes(std::uint64_t index);
  /// `length` bytes from `offset`; `where` is the element that refers to them.
  std::span<const unsigned char> part(std::uint64_t index, std::uint64_t offset, std::uint64_t length, const std::string& where);
  void moveInto(std::vector<std::vector<unsigned char>>& buffers);

 private:
  const GltfJson& json_;
  GltfUris uris_;
  std::map<std::uint64_t, std::vector<unsigned char>> opened_;
};

}  // namespace spheretree::formats
