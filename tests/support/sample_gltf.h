// SPDX-License-Identifier: Apache-2.0
// A tetrahedron with legs of 1 m as glTF, to be changed by tests.
#pragma once

#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>

namespace spheretree::test {

/// Positions (4 x 3 float32), then 12 indices (uint16).
inline std::string tetrahedronBuffer() {
  const float places[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
  const std::uint16_t indices[12] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
  std::string bytes(reinterpret_cast<const char*>(places), sizeof places);
  bytes.append(reinterpret_cast<const char*>(indices), sizeof indices);
  return bytes;
}

inline nlohmann::json tetrahedronJson() {
  return nlohmann::json::parse(R"({
    "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0, "name": "tooth"}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
                  {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"}],
    "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 24}],
    "buffers": [{"byteLength": 72}]})");
}

inline std::string toGlb(const nlohmann::json& json, std::string buffer) {
  std::string text = json.dump();
  while (text.size() % 4) text += ' ';
  while (buffer.size() % 4) buffer += '\0';
  const auto number = [](std::size_t value) {
    const auto bits = static_cast<std::uint32_t>(value);
    char bytes[4];
    std::memcpy(bytes, &bits, 4);
    return std::string(bytes, 4);
  };
  std::string chunks = number(text.size()) + "JSON" + text;
  if (!buffer.empty()) chunks += number(buffer.size()) + std::string("BIN\0", 4) + buffer;
  return "glTF" + number(2) + number(12 + chunks.size()) + chunks;
}

}  // namespace spheretree::test
