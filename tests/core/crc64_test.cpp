// SPDX-License-Identifier: Apache-2.0
#include "spheretree/core/crc64.h"

#include <gtest/gtest.h>

#include <span>
#include <string_view>
#include <vector>

#include "support/sample_trees.h"

namespace spheretree {
namespace {

/// By the definition, bit by bit.
std::uint64_t bitByBit(std::span<const std::byte> bytes) {
  std::uint64_t crc = ~std::uint64_t{0};
  for (const std::byte byte : bytes) {
    crc ^= static_cast<std::uint64_t>(byte);
    for (int bit = 0; bit < 8; ++bit) crc = crc & 1 ? crc >> 1 ^ 0xc96c5795d7870f42u : crc >> 1;
  }
  return ~crc;
}

TEST(Crc64, GivesTheCatalogueValue) {
  const std::string_view digits = "123456789";
  EXPECT_EQ(crc64(std::as_bytes(std::span<const char>(digits.data(), digits.size()))), 0x995dc9bbdf1939fau);
  EXPECT_EQ(crc64({}), 0u);
}

TEST(Crc64, IsThatOfTheDefinitionForEveryLengthAndEveryCut) {
  test::Random random(1);
  std::vector<std::byte> bytes;
  for (std::size_t size = 0; size <= 300; ++size) {  // from 64 bytes on by another method, four blocks of 16 at a time
    const std::uint64_t expected = bitByBit(bytes);
    EXPECT_EQ(crc64(bytes), expected) << size << " bytes";
    for (std::size_t cut = 0; cut <= size; ++cut) {
      const std::span<const std::byte> whole(bytes);
      EXPECT_EQ(crc64(whole.subspan(cut), crc64(whole.first(cut))), expected) << size << " bytes, cut at " << cut;
    }
    bytes.push_back(static_cast<std::byte>(random.next()));
  }
}

}  // namespace
}  // namespace spheretree
