// SPDX-License-Identifier: Apache-2.0
// Resolves the URIs of a glTF file's buffers: base64 data within it, or a file beside or below it. Nothing else is
// opened.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "mesh/mesh_assembly.h"

namespace spheretree::formats {

class GltfUris {
 public:
  /// @param folder The folder of the glTF file; empty: only data URIs are opened.
  GltfUris(std::filesystem::path folder, const MeshAssembly& assembly) : folder_(std::move(folder)), assembly_(assembly) {}

  /// @param where The element with the URI, for messages: "buffers[0]".
  /// @throws FormatError for a URI that is refused; FileError for a file that cannot be read, or more than 4 GiB of
  /// files in total.
  std::vector<unsigned char> open(const std::string& uri, const std::string& where);

 private:
  std::vector<unsigned char> decodeBase64(std::string_view text, const std::string& where) const;
  std::string percentDecoded(std::string_view uri, const std::string& where) const;
  /// The file beside or below the glTF file that a URI refers to; links must not lead outside either.
  std::filesystem::path resolve(const std::string& uri, const std::string& where) const;

  std::filesystem::path folder_;
  const MeshAssembly& assembly_;
  std::uint64_t external_bytes_ = 0;
};

}  // namespace spheretree::formats
