// SPDX-License-Identifier: Apache-2.0
#include "spheretree/formats/mesh_writer.h"

#include <array>
#include <bit>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <string>

namespace spheretree::formats {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers are written as they stand in memory");

std::vector<std::byte> bytesOf(const std::string& text) {
  std::vector<std::byte> bytes(text.size());
  std::memcpy(bytes.data(), text.data(), text.size());
  return bytes;
}

}  // namespace

std::vector<std::byte> encodePly(const TriangleMesh& mesh) {
  std::vector<std::byte> out =
      bytesOf("ply\nformat binary_little_endian 1.0\ncomment unit mm\nelement vertex " + std::to_string(mesh.positions.size()) +
              "\nproperty double x\nproperty double y\nproperty double z\nelement face " + std::to_string(mesh.triangles.size()) +
              "\nproperty list uchar uint vertex_indices\nend_header\n");
  std::size_t at = out.size();
  out.resize(at + 24 * mesh.positions.size() + 13 * mesh.triangles.size());
  for (const Eigen::Vector3d& p : mesh.positions) {
    std::memcpy(out.data() + at, p.data(), 24);
    at += 24;
  }
  for (const Triangle& t : mesh.triangles) {
    out[at] = std::byte{3};
    std::memcpy(out.data() + at + 1, t.data(), 12);
    at += 13;
  }
  return out;
}

std::vector<std::byte> encodeObj(const TriangleMesh& mesh) {
  std::string out = "# unit: mm\n";
  for (const Eigen::Vector3d& p : mesh.positions) {
    out += 'v';
    for (const double x : p) {
      std::array<char, 32> digits;
      out += ' ';
      out.append(digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), x).ptr);
    }
    out += '\n';
  }
  std::uint32_t part = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (!mesh.part.empty() && (t == 0 || mesh.part[t] != part)) {
      part = mesh.part[t];
      if (!mesh.part_names[part].empty()) out.append("g ").append(mesh.part_names[part]).append("\n");
    }
    out += 'f';
    for (const std::uint32_t v : mesh.triangles[t]) out.append(" ").append(std::to_string(v + 1));
    out += '\n';
  }
  return bytesOf(out);
}

}  // namespace spheretree::formats
