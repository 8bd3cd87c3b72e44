// SPDX-License-Identifier: Apache-2.0
#include "spheretree/core/sphere_tree_codec.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <new>
#include <stdexcept>
#include <utility>

namespace spheretree {
namespace {

static_assert(std::endian::native == std::endian::little, "arrays are copied as they stand in the file");

constexpr std::array<std::uint8_t, 8> kMagic{0x89, 'S', 'T', 'R', 'E', 'E', '\r', '\n'};  // not text; shows line-end damage

struct LevelRecord {
  std::uint32_t sphere_count;
  float overhang_bound, smallest_radius, largest_radius;
};

// Every field at its natural alignment: no padding.
struct Header {
  std::array<std::uint8_t, 8> magic;
  std::uint16_t major, minor;
  std::uint32_t header_bytes;
  std::uint64_t file_bytes;
  std::uint64_t checksum;  // CRC-64 of the whole file with these 8 bytes zero
  std::uint32_t node_count, inner_count;
  std::uint8_t level_count, branching;
  std::array<std::uint8_t, 2> reserved;
  float work_overhang_mm;
  std::array<double, 3> origin_mm;
  double unit_mm, diagonal_mm, volume_mm3, area_mm2, tolerance_mm;
  std::uint64_t triangle_count, seed;
  Hash128 mesh_hash, settings_hash;
  std::array<char, 16> builder, quality;
  std::array<char, 32> generator;
  std::array<LevelRecord, kMaxLevels> levels;
};
static_assert(sizeof(Header) == kHeaderBytes && kHeaderBytes % kArrayAlignment == 0);
static_assert(offsetof(Header, checksum) == 24 && offsetof(Header, origin_mm) == 48 && offsetof(Header, mesh_hash) == 128 &&
              offsetof(Header, builder) == 160 && offsetof(Header, levels) == 224);
constexpr std::size_t kMostHeaderBytes = 4096;  // of a newer minor version

std::uint64_t alignUp(std::uint64_t offset) { return (offset + kArrayAlignment - 1) / kArrayAlignment * kArrayAlignment; }

constexpr std::array<std::uint64_t, 256> makeCrcTable() {
  std::array<std::uint64_t, 256> table{};
  for (std::uint64_t i = 0; i < 256; ++i) {
    std::uint64_t crc = i;
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1) ? 0xc96c5795d7870f42u : 0u);
    table[i] = crc;
  }
  return table;
}
constexpr std::array<std::uint64_t, 256> kCrcTable = makeCrcTable();

std::uint64_t checksumOf(std::span<const std::byte> bytes) {
  constexpr std::array<std::byte, 8> kZero{};
  std::uint64_t crc = crc64(bytes.first(offsetof(Header, checksum)));
  crc = crc64(kZero, crc);
  return crc64(bytes.subspan(offsetof(Header, checksum) + 8), crc);
}

template <std::size_t N>
std::array<char, N> fixedText(const std::string& text) {
  std::array<char, N> field{};
  std::copy(text.begin(), text.end(), field.begin());
  return field;
}

template <std::size_t N>
bool readText(const std::array<char, N>& field, std::string& text) {
  const auto end = std::find(field.begin(), field.end(), '\0');
  if (end == field.end() || std::any_of(end, field.end(), [](char c) { return c != 0; })) return false;
  text.assign(field.begin(), end);
  return true;
}

/// Bit for bit: -0.0 would not be written back.
bool isZero(const LevelRecord& r) { return std::bit_cast<std::array<std::uint8_t, sizeof r>>(r) == std::array<std::uint8_t, sizeof r>{}; }

/// child_count from the tags in the bounding radii: node by node, each inner node says how many of the next nodes are its own.
bool readTags(SphereTree& tree) {
  const std::size_t n = tree.nodeCount();
  tree.child_count.assign(n, 0);
  std::vector<bool> inner(n, false);
  inner[0] = !tree.bound.empty();
  std::size_t next_child = 1, next_bound = 0;
  for (std::size_t i = 0; i < n; ++i) {
    if (!inner[i]) continue;
    if (next_bound == tree.bound.size()) return false;
    const std::uint32_t tag = std::bit_cast<std::uint32_t>(tree.bound[next_bound++].radius) & 0xff;
    const std::size_t count = (tag & 0xf) + 1, inner_count = tag >> 4;
    if (count > static_cast<std::size_t>(kMaxBranching) || inner_count > count || count > n - next_child) return false;
    tree.child_count[i] = static_cast<std::uint8_t>(count);
    for (std::size_t c = 0; c < inner_count; ++c) inner[next_child + c] = true;
    next_child += count;
  }
  return next_child == n && next_bound == tree.bound.size() && linkNodes(tree);
}

/// Where the arrays stand in a file.
struct Layout {
  std::uint64_t cover_at, cover_bytes, bound_at, bound_bytes, file_bytes;
};

Layout layoutOf(std::uint64_t header_bytes, std::uint64_t node_count, std::uint64_t inner_count) {
  Layout l{header_bytes, node_count * sizeof(Sphere), 0, inner_count * sizeof(Sphere), 0};
  l.bound_at = alignUp(l.cover_at + l.cover_bytes);
  l.file_bytes = l.bound_at + l.bound_bytes;
  return l;
}

LoadStatus badHeader(std::size_t offset, const std::string& what, std::string& fault) {
  fault = "offset " + std::to_string(offset) + ": " + what;
  return LoadStatus::BadHeader;
}

/// The header of a file that is whole and of a version that this reader knows; `layout` lies within `bytes`.
LoadStatus readHeader(std::span<const std::byte> bytes, Header& header, Layout& layout, std::string& fault) {
  const std::size_t known = std::min(bytes.size(), kMagic.size());
  if (known == 0 || std::memcmp(bytes.data(), kMagic.data(), known) != 0) {
    fault = "offset 0: does not start with the 8 bytes of a sphere-tree file";
    return LoadStatus::BadMagic;
  }
  const auto tooShort = [&](std::uint64_t wanted) {
    fault = "has " + std::to_string(bytes.size()) + " bytes of " + std::to_string(wanted);
    return LoadStatus::Truncated;
  };
  constexpr std::size_t kPrefixBytes = 12;  // magic and version: the only fields that every version shares
  if (bytes.size() < kPrefixBytes) return tooShort(kHeaderBytes);
  std::memcpy(&header, bytes.data(), std::min(bytes.size(), sizeof header));
  if (header.major != kFormatMajor) {
    fault = "offset 8: version " + std::to_string(header.major) + "." + std::to_string(header.minor) + ", this reader knows " +
            std::to_string(kFormatMajor) + ".x";
    return LoadStatus::UnsupportedVersion;
  }
  if (bytes.size() < sizeof header) return tooShort(kHeaderBytes);

  const bool newer = header.minor > kFormatMinor;
  if (header.header_bytes % kArrayAlignment != 0 || header.header_bytes < kHeaderBytes || header.header_bytes > kMostHeaderBytes ||
      (!newer && header.header_bytes != kHeaderBytes))
    return badHeader(12, "header of " + std::to_string(header.header_bytes) + " bytes", fault);
  if (header.node_count < 1 || header.node_count > kMaxNodes)
    return badHeader(32, std::to_string(header.node_count) + " nodes, not 1 to " + std::to_string(kMaxNodes), fault);
  if (header.inner_count >= header.node_count)
    return badHeader(36, std::to_string(header.inner_count) + " inner nodes of " + std::to_string(header.node_count), fault);
  layout = layoutOf(header.header_bytes, header.node_count, header.inner_count);
  if (header.file_bytes != layout.file_bytes)
    return badHeader(
        16, "a file of " + std::to_string(header.file_bytes) + " bytes, but the counts make it " + std::to_string(layout.file_bytes),
        fault);
  if (bytes.size() < layout.file_bytes) return tooShort(layout.file_bytes);
  if (bytes.size() > layout.file_bytes) {
    fault = "has " + std::to_string(bytes.size() - layout.file_bytes) + " bytes behind its end at " + std::to_string(layout.file_bytes);
    return LoadStatus::TrailingBytes;
  }
  if (checksumOf(bytes) != header.checksum) {
    fault = "offset 24: the checksum of the " + std::to_string(layout.file_bytes) + " bytes differs from the one stored";
    return LoadStatus::BadChecksum;
  }
  const std::size_t padding_at = layout.cover_at + layout.cover_bytes;
  const auto padding = bytes.subspan(padding_at, layout.bound_at - padding_at);
  if (std::any_of(padding.begin(), padding.end(), [](std::byte b) { return b != std::byte{0}; }))
    return badHeader(padding_at, "padding is not zero", fault);
  if (!newer && std::any_of(header.reserved.begin(), header.reserved.end(), [](std::uint8_t b) { return b != 0; }))
    return badHeader(42, "reserved bytes are not zero", fault);
  return LoadStatus::Ok;
}

LoadStatus readProvenance(const Header& header, Provenance& p, std::string& fault) {
  p.unit_mm = header.unit_mm, p.diagonal_mm = header.diagonal_mm, p.volume_mm3 = header.volume_mm3, p.area_mm2 = header.area_mm2;
  p.tolerance_mm = header.tolerance_mm, p.work_overhang_mm = header.work_overhang_mm;
  p.triangle_count = header.triangle_count, p.seed = header.seed;
  p.mesh_hash = header.mesh_hash, p.settings_hash = header.settings_hash;
  if (!readText(header.builder, p.builder)) return badHeader(160, "the builder's name is not closed by zeros", fault);
  if (!readText(header.quality, p.quality)) return badHeader(176, "the quality's name is not closed by zeros", fault);
  if (!readText(header.generator, p.generator)) return badHeader(192, "the generator's name is not closed by zeros", fault);
  return LoadStatus::Ok;
}

LoadStatus readStatistics(const Header& header, SphereTree& tree, std::string& fault) {
  if (tree.levelCount() != header.level_count)
    return badHeader(40, std::to_string(header.level_count) + " levels, but the nodes make " + std::to_string(tree.levelCount()), fault);
  for (std::size_t level = 0; level < header.levels.size(); ++level) {
    const LevelRecord& r = header.levels[level];
    if (level < header.level_count)
      tree.statistics.push_back({r.sphere_count, r.overhang_bound, r.smallest_radius, r.largest_radius});
    else if (!isZero(r))
      return badHeader(offsetof(Header, levels) + level * sizeof r, "statistics of a level that is not there", fault);
  }
  return LoadStatus::Ok;
}

LoadStatus decode(std::span<const std::byte> bytes, SphereTree& out, std::string& fault) {
  Header header{};
  Layout layout{};
  if (const LoadStatus status = readHeader(bytes, header, layout, fault); status != LoadStatus::Ok) return status;
  SphereTree tree;
  tree.branching = header.branching;
  tree.origin_mm = header.origin_mm;
  if (const LoadStatus status = readProvenance(header, tree.provenance, fault); status != LoadStatus::Ok) return status;
  tree.cover.resize(header.node_count);
  tree.bound.resize(header.inner_count);
  std::memcpy(tree.cover.data(), bytes.data() + layout.cover_at, layout.cover_bytes);
  if (layout.bound_bytes > 0) std::memcpy(tree.bound.data(), bytes.data() + layout.bound_at, layout.bound_bytes);
  if (!readTags(tree)) {
    fault = "offset " + std::to_string(layout.bound_at) + ": the low bits of the bounding radii do not make a tree of " +
            std::to_string(header.node_count) + " nodes with " + std::to_string(header.inner_count) + " inner ones";
    return LoadStatus::BadTopology;
  }
  if (const LoadStatus status = readStatistics(header, tree, fault); status != LoadStatus::Ok) return status;
  fault = findFault(tree);
  if (!fault.empty()) return LoadStatus::BadTree;
  out = std::move(tree);
  return LoadStatus::Ok;
}

}  // namespace

std::uint64_t crc64(std::span<const std::byte> bytes, std::uint64_t crc) {
  crc = ~crc;
  for (const std::byte b : bytes) crc = kCrcTable[(crc ^ static_cast<std::uint64_t>(b)) & 0xff] ^ (crc >> 8);
  return ~crc;
}

std::string_view explain(LoadStatus status) {
  switch (status) {
    case LoadStatus::Ok:
      return "the file is sound";
    case LoadStatus::BadMagic:
      return "this is not a sphere-tree file; name a .stree file, or convert to one";
    case LoadStatus::UnsupportedVersion:
      return "the file is of a format version that this program does not know; use a newer program or build the tree again";
    case LoadStatus::Truncated:
      return "the file ends too early; copy it again";
    case LoadStatus::TrailingBytes:
      return "the file is too long; copy it again";
    case LoadStatus::BadChecksum:
      return "the file is damaged; copy it again or build the tree again";
    case LoadStatus::BadHeader:
      return "the header contradicts itself; build the tree again";
    case LoadStatus::BadTopology:
      return "the nodes do not make a tree; build the tree again";
    case LoadStatus::BadTree:
      return "the tree breaks a rule that its users rely on; build the tree again";
    case LoadStatus::OutOfMemory:
      return "there is not enough memory; close other programs";
  }
  return "unknown status";
}

std::vector<std::byte> encodeSphereTree(const SphereTree& tree) {
  if (const std::string fault = findFault(tree); !fault.empty()) throw std::invalid_argument("sphere-tree cannot be stored: " + fault);
  const Layout layout = layoutOf(kHeaderBytes, tree.cover.size(), tree.bound.size());
  std::vector<std::byte> bytes(layout.file_bytes);

  const Provenance& p = tree.provenance;
  Header header{};
  header.magic = kMagic;
  header.major = kFormatMajor, header.minor = kFormatMinor;
  header.header_bytes = kHeaderBytes;
  header.file_bytes = bytes.size();
  header.node_count = static_cast<std::uint32_t>(tree.cover.size()), header.inner_count = static_cast<std::uint32_t>(tree.bound.size());
  header.level_count = static_cast<std::uint8_t>(tree.levelCount()), header.branching = tree.branching;
  header.origin_mm = tree.origin_mm;
  header.unit_mm = p.unit_mm, header.diagonal_mm = p.diagonal_mm, header.volume_mm3 = p.volume_mm3, header.area_mm2 = p.area_mm2;
  header.tolerance_mm = p.tolerance_mm, header.work_overhang_mm = p.work_overhang_mm;
  header.triangle_count = p.triangle_count, header.seed = p.seed;
  header.mesh_hash = p.mesh_hash, header.settings_hash = p.settings_hash;
  header.builder = fixedText<16>(p.builder), header.quality = fixedText<16>(p.quality), header.generator = fixedText<32>(p.generator);
  for (std::size_t level = 0; level < tree.statistics.size(); ++level) {
    const LevelStatistics& s = tree.statistics[level];
    header.levels[level] = {s.sphere_count, s.overhang_bound, s.smallest_radius, s.largest_radius};
  }
  std::memcpy(bytes.data(), &header, sizeof header);
  std::memcpy(bytes.data() + layout.cover_at, tree.cover.data(), layout.cover_bytes);
  if (layout.bound_bytes > 0) std::memcpy(bytes.data() + layout.bound_at, tree.bound.data(), layout.bound_bytes);
  header.checksum = checksumOf(bytes);
  std::memcpy(bytes.data(), &header, sizeof header);
  return bytes;
}

LoadStatus decodeSphereTree(std::span<const std::byte> bytes, SphereTree& tree, std::string* fault) noexcept try {
  std::string ignored;
  return decode(bytes, tree, fault != nullptr ? *fault : ignored);
} catch (const std::bad_alloc&) {
  return LoadStatus::OutOfMemory;
}

}  // namespace spheretree
