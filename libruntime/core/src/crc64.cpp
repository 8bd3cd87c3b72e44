// SPDX-License-Identifier: Apache-2.0
#include "spheretree/core/crc64.h"

#include <array>
#include <bit>
#include <cstring>
#if defined(__x86_64__)
#include <cpuid.h>
#include <immintrin.h>
#endif

namespace spheretree {
namespace {

static_assert(std::endian::native == std::endian::little, "words are taken from the bytes as they stand");

constexpr std::size_t kBlock = 16;  // bytes of a round: two words, or a register that the instruction multiplies
/// [k][b]: the contribution of byte b to the checksum when k more bytes follow it.
using Tables = std::array<std::array<std::uint64_t, 256>, kBlock>;

/// A polynomial of degree 63, its highest power in bit 0, times x, modulo that of the checksum.
std::uint64_t timesX(std::uint64_t polynomial) { return (polynomial >> 1) ^ ((polynomial & 1) ? 0xc96c5795d7870f42u : 0u); }

Tables makeTables() {
  Tables tables{};
  for (std::uint64_t byte = 0; byte < 256; ++byte) {
    std::uint64_t crc = byte;
    for (int bit = 0; bit < 8; ++bit) crc = timesX(crc);
    tables[0][byte] = crc;
  }
  for (std::size_t k = 1; k < kBlock; ++k)
    for (std::size_t byte = 0; byte < 256; ++byte) tables[k][byte] = tables[0][tables[k - 1][byte] & 0xff] ^ (tables[k - 1][byte] >> 8);
  return tables;
}

/// From the register after some bytes to that after `bytes`.
std::uint64_t byTables(std::span<const std::byte> bytes, std::uint64_t crc) {
  static const Tables kTables = makeTables();  // computed in the first call, so that the library need not contain 32 KiB of tables
  for (; bytes.size() >= kBlock; bytes = bytes.subspan(kBlock)) {
    std::array<std::uint64_t, 2> words;
    std::memcpy(words.data(), bytes.data(), sizeof words);
    words[0] ^= crc;
    crc = 0;
    for (std::size_t k = 0; k < 8; ++k) crc ^= kTables[15 - k][words[0] >> 8 * k & 0xff] ^ kTables[7 - k][words[1] >> 8 * k & 0xff];
  }
  for (const std::byte b : bytes) crc = kTables[0][(crc ^ static_cast<std::uint64_t>(b)) & 0xff] ^ (crc >> 8);
  return crc;
}

#if defined(__x86_64__)

constexpr std::size_t kLanes = 4;

/// A block counts as much as the sum of its halves, each times its power of x, in a block that comes later. The
/// instruction's product contains one more factor x.
struct Products {
  bool are_there;                 // the processor has the instruction
  std::uint64_t far[2], near[2];  // powers of x for kLanes blocks later and for the next block
  Products() {
    unsigned a = 0, b = 0, c = 0, d = 0;
    are_there = __get_cpuid(1, &a, &b, &c, &d) != 0 && (c & bit_PCLMUL) != 0;
    std::uint64_t power = std::uint64_t{1} << 63;
    for (int exponent = 0; exponent < 128 * static_cast<int>(kLanes) + 64; ++exponent, power = timesX(power)) {
      if (exponent == 128 + 63) near[0] = power;
      if (exponent == 128 - 1) near[1] = power;
      if (exponent == 128 * kLanes + 63) far[0] = power;
      if (exponent == 128 * kLanes - 1) far[1] = power;
    }
  }
};

[[gnu::target("pclmul")]] __m128i fold(__m128i block, __m128i by, __m128i next) {
  return _mm_xor_si128(next, _mm_xor_si128(_mm_clmulepi64_si128(block, by, 0x00), _mm_clmulepi64_si128(block, by, 0x11)));
}

/// The same as byTables() by products of polynomials.
/// Paper: V. Gopal et al. Fast CRC computation for generic polynomials using PCLMULQDQ instruction. Intel, 2009.
[[gnu::target("pclmul")]] std::uint64_t byProducts(const Products& products, std::span<const std::byte> bytes, std::uint64_t crc) {
  const auto load = [](const void* p) { return _mm_loadu_si128(static_cast<const __m128i*>(p)); };
  const __m128i far = load(products.far), near = load(products.near);
  __m128i lanes[kLanes];
  for (std::size_t k = 0; k < kLanes; ++k) lanes[k] = load(bytes.data() + kBlock * k);
  lanes[0] = _mm_xor_si128(lanes[0], _mm_set_epi64x(0, static_cast<long long>(crc)));
  bytes = bytes.subspan(kBlock * kLanes);
  for (; bytes.size() >= kBlock * kLanes; bytes = bytes.subspan(kBlock * kLanes))
    for (std::size_t k = 0; k < kLanes; ++k) lanes[k] = fold(lanes[k], far, load(bytes.data() + kBlock * k));
  for (std::size_t k = 1; k < kLanes; ++k) lanes[k] = fold(lanes[k - 1], near, lanes[k]);
  std::array<std::byte, kBlock> last;
  std::memcpy(last.data(), &lanes[kLanes - 1], kBlock);
  return byTables(bytes, byTables(last, 0));
}

#endif

}  // namespace

std::uint64_t crc64(std::span<const std::byte> bytes, std::uint64_t crc) {
#if defined(__x86_64__)
  static const Products kProducts;
  if (kProducts.are_there && bytes.size() >= kBlock * kLanes) return ~byProducts(kProducts, bytes, ~crc);
#endif
  return ~byTables(bytes, ~crc);
}

}  // namespace spheretree
