// SPDX-License-Identifier: Apache-2.0
#include "spheretree/core/crc64.h"

#include <array>
#include <bit>
#include <cstring>

namespace spheretree {
namespace {

static_assert(std::endian::native == std::endian::little, "words are taken from the bytes as they stand");

constexpr std::size_t kSlices = 16;
/// [k][b]: the contribution of byte b to the checksum when k more bytes follow it.
using Tables = std::array<std::array<std::uint64_t, 256>, kSlices>;

Tables makeTables() {
  Tables tables{};
  for (std::uint64_t byte = 0; byte < 256; ++byte) {
    std::uint64_t crc = byte;
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1) ? 0xc96c5795d7870f42u : 0u);
    tables[0][byte] = crc;
  }
  for (std::size_t k = 1; k < kSlices; ++k)
    for (std::size_t byte = 0; byte < 256; ++byte) tables[k][byte] = tables[0][tables[k - 1][byte] & 0xff] ^ (tables[k - 1][byte] >> 8);
  return tables;
}

}  // namespace

std::uint64_t crc64(std::span<const std::byte> bytes, std::uint64_t crc) {
  static const Tables kTables = makeTables();  // computed in the first call, so that the library need not contain 32 KiB of tables
  crc = ~crc;
  for (; bytes.size() >= kSlices; bytes = bytes.subspan(kSlices)) {
    std::array<std::uint64_t, 2> words;
    std::memcpy(words.data(), bytes.data(), sizeof words);
    words[0] ^= crc;
    crc = 0;
    for (std::size_t k = 0; k < 8; ++k) crc ^= kTables[15 - k][words[0] >> 8 * k & 0xff] ^ kTables[7 - k][words[1] >> 8 * k & 0xff];
  }
  for (const std::byte b : bytes) crc = kTables[0][(crc ^ static_cast<std::uint64_t>(b)) & 0xff] ^ (crc >> 8);
  return ~crc;
}

}  // namespace spheretree
