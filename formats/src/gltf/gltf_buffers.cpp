// SPDX-License-Identifier: Apache-2.0
#include "gltf/gltf_buffers.h"

namespace spheretree::formats {

std::span<const unsigned char> GltfBuffers::bytes(std::uint64_t index) {
  const GltfJson::Json& object = json_.element("buffers", index, "");
  const std::string where = place("buffers", index);
  const std::uint64_t announced = json_.getUnsigned(object, "byteLength", where);
  if (announced == 0) json_.refuse(where, "has no bytes");
  const GltfJson::Json* uri = GltfJson::find(object, "uri");
  if (uri && !uri->is_string()) json_.refuse(where + ".uri", "is not text");
  const std::span<const char> chunk = json_.binaryChunk();
  if (!uri && (index != 0 || chunk.empty()))
    json_.refuse(where, "has no data" + std::string(GltfJson::find(object, "extensions") ? " without its extensions" : ""));
  std::span<const unsigned char> all(reinterpret_cast<const unsigned char*>(chunk.data()), chunk.size());
  if (uri) {
    const auto [entry, is_new] = opened_.try_emplace(index);
    if (is_new) entry->second = uris_.open(uri->get_ref<const std::string&>(), where);
    all = entry->second;
  }
  if (all.size() < announced)
    json_.refuse(where, "announces " + std::to_string(announced) + " bytes, but has " + std::to_string(all.size()));
  return all.first(announced);
}

std::span<const unsigned char> GltfBuffers::part(std::uint64_t index, std::uint64_t offset, std::uint64_t length,
                                                 const std::string& where) {
  const std::span<const unsigned char> all = bytes(index);
  if (offset > all.size() || length > all.size() - offset)
    json_.refuse(where, "(offset " + std::to_string(offset) + ", length " + std::to_string(length) + ") reaches beyond the " +
                            std::to_string(all.size()) + " bytes of " + place("buffers", index));
  return all.subspan(offset, length);
}

void GltfBuffers::moveInto(std::vector<std::vector<unsigned char>>& buffers) {
  for (auto& [index, bytes] : opened_) buffers.push_back(std::move(bytes));
  opened_.clear();
}

}  // namespace spheretree::formats
