// SPDX-License-Identifier: Apache-2.0
// What the writers of GLB share: binary data behind accessors, and the container.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

namespace spheretree::formats {

using Json = nlohmann::ordered_json;

template <class T>
void append(std::vector<std::byte>& bytes, const T& value) {
  const auto* first = reinterpret_cast<const std::byte*>(&value);
  bytes.insert(bytes.end(), first, first + sizeof value);
}

inline constexpr double kMetre = 0.001;  // [m/mm]: glTF is in metres

// Numbers of the glTF 2.0 specification.
inline constexpr int kFloat = 5126, kUnsignedInt = 5125, kArrayBuffer = 34962, kElementArrayBuffer = 34963;

/// Appends a buffer view and its accessor to `document`; returns the accessor's index.
inline std::size_t addAccessor(Json& document, std::size_t begin, std::size_t end, int target, int component, std::size_t count,
                               const char* type) {
  document["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", begin}, {"byteLength", end - begin}, {"target", target}});
  document["accessors"].push_back(
      {{"bufferView", document["bufferViews"].size() - 1}, {"componentType", component}, {"count", count}, {"type", type}});
  return document["accessors"].size() - 1;
}

/// The file: `document` gets its one buffer.
inline std::vector<std::byte> packGlb(Json& document, const std::vector<std::byte>& buffer) {
  document["buffers"] = Json::array({{{"byteLength", buffer.size()}}});

  std::string text = document.dump();
  text.resize((text.size() + 3) / 4 * 4, ' ');
  constexpr std::uint32_t kMagic = 0x46546c67, kVersion = 2, kJsonChunk = 0x4e4f534a, kBinaryChunk = 0x004e4942;
  std::vector<std::byte> bytes;
  bytes.reserve(28 + text.size() + buffer.size());
  append(bytes, std::array<std::uint32_t, 3>{kMagic, kVersion, static_cast<std::uint32_t>(28 + text.size() + buffer.size())});
  append(bytes, std::array<std::uint32_t, 2>{static_cast<std::uint32_t>(text.size()), kJsonChunk});
  const std::span<const std::byte> text_bytes = std::as_bytes(std::span<const char>(text.data(), text.size()));
  bytes.insert(bytes.end(), text_bytes.begin(), text_bytes.end());
  append(bytes, std::array<std::uint32_t, 2>{static_cast<std::uint32_t>(buffer.size()), kBinaryChunk});
  bytes.insert(bytes.end(), buffer.begin(), buffer.end());
  return bytes;
}

}  // namespace spheretree::formats
