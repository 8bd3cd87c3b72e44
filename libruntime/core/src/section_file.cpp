// SPDX-License-Identifier: Apache-2.0
#include "section_file.h"

#include <algorithm>
#include <cstring>

#include "describe.h"
#include "spheretree/core/crc64.h"

namespace spheretree {
namespace {

constexpr std::array<std::uint8_t, 8> kMagic{0x89, 'S', 'T', 'R', 'E', 'E', '\r', '\n'};  // not text; reveals damage by converted line ends

// Every field is naturally aligned, so there is no padding.
struct Header {
  std::array<std::uint8_t, 8> magic;
  std::uint16_t major, minor;
  std::uint32_t section_count;
  std::uint64_t file_bytes;
  std::uint64_t checksum;  // CRC-64 of the whole file with these 8 bytes set to zero
};
static_assert(sizeof(Header) == 32 && offsetof(Header, checksum) == 24);

struct Entry {
  SectionId id;
  std::uint32_t flags;  // 1: optional; 0: required
  std::uint64_t offset, bytes;
};
static_assert(sizeof(Entry) == 24);

std::uint64_t alignUp(std::uint64_t offset) { return (offset + kSectionAlignment - 1) / kSectionAlignment * kSectionAlignment; }

std::uint64_t checksumOf(std::span<const std::byte> file) {
  const std::array<std::byte, sizeof(Header::checksum)> zero{};
  const std::uint64_t crc = crc64(zero, crc64(file.first(offsetof(Header, checksum))));
  return crc64(file.subspan(sizeof(Header)), crc);
}

bool isZero(std::span<const std::byte> bytes) {
  return std::all_of(bytes.begin(), bytes.end(), [](std::byte b) { return b == std::byte{0}; });
}

/// Reads the header of a complete file with a version that this reader knows.
LoadStatus readHeader(std::span<const std::byte> file, Header& header, std::string& fault) {
  const std::size_t known = std::min(file.size(), kMagic.size());
  if (known == 0 || std::memcmp(file.data(), kMagic.data(), known) != 0) {
    fault = "offset 0: does not start with the 8 bytes of a sphere-tree file";
    return LoadStatus::BadMagic;
  }
  const auto tooShort = [&](std::uint64_t wanted) {
    fault = describe("has %zu bytes of %llu", file.size(), static_cast<unsigned long long>(wanted));
    return LoadStatus::Truncated;
  };
  // Magic and version are the only fields that all versions share.
  if (file.size() < offsetof(Header, section_count)) return tooShort(sizeof header);
  std::memcpy(&header, file.data(), std::min(file.size(), sizeof header));
  if (header.major != kFormatMajor) {
    fault = describe("offset 8: version %d.%d, this reader knows %d.x", header.major, header.minor, kFormatMajor);
    return LoadStatus::UnsupportedVersion;
  }
  if (file.size() < sizeof header) return tooShort(sizeof header);
  if (file.size() < header.file_bytes) return tooShort(header.file_bytes);
  if (file.size() > header.file_bytes) {
    fault = describe("has %zu bytes behind its end at %zu", file.size() - header.file_bytes, std::size_t{header.file_bytes});
    return LoadStatus::TrailingBytes;
  }
  if (checksumOf(file) != header.checksum) {
    fault = describe("offset 24: the checksum of the %zu bytes differs from the one stored", file.size());
    return LoadStatus::BadChecksum;
  }
  return LoadStatus::Ok;
}

}  // namespace

std::string nameOf(const Section& section) {
  std::array<char, 5> id{};
  std::transform(section.id.begin(), section.id.end(), id.begin(), [](char c) { return c >= 0x20 && c < 0x7f ? c : '?'; });
  return describe("section '%s' at offset %llu", id.data(), static_cast<unsigned long long>(section.offset));
}

LoadStatus openSections(std::span<const std::byte> file, std::vector<Section>& sections, std::string& fault) {
  Header header{};
  if (const LoadStatus status = readHeader(file, header, fault); status != LoadStatus::Ok) return status;
  const auto bad = [&](std::uint64_t offset, const char* what) {
    fault = describe("offset %zu: %s", std::size_t{offset}, what);
    return LoadStatus::BadHeader;
  };
  std::uint64_t end = sizeof header + std::uint64_t{header.section_count} * sizeof(Entry);  // end of everything before the next section
  if (header.section_count > kMaxSections) return bad(12, "there are more than 64 sections");
  if (end > file.size()) return bad(12, "there are more sections than the file has room for");
  for (std::size_t i = 0; i < header.section_count; ++i) {
    const std::uint64_t entry_at = sizeof header + i * sizeof(Entry);
    Entry entry;
    std::memcpy(&entry, file.data() + entry_at, sizeof entry);
    const Section section{entry.id, entry.flags != 0, entry.offset, {}};
    const auto badEntry = [&](const char* what) { return bad(entry_at, (nameOf(section) + what).c_str()); };
    if (entry.flags > 1) return badEntry(" has unknown flags");
    if (std::any_of(sections.begin(), sections.end(), [&](const Section& s) { return s.id == entry.id; }))
      return badEntry(" repeats an earlier one");
    if (entry.offset != alignUp(end)) return badEntry(" does not stand behind the one before it, at the next multiple of 64");
    if (entry.offset > file.size() || entry.bytes > file.size() - entry.offset) return badEntry(" ends behind the file");
    if (!isZero(file.subspan(end, entry.offset - end))) return bad(end, "padding is not zero");
    sections.push_back(section);
    sections.back().bytes = file.subspan(entry.offset, entry.bytes);
    end = entry.offset + entry.bytes;
  }
  if (end != file.size()) return bad(end, "bytes that belong to no section");
  return LoadStatus::Ok;
}

std::vector<std::byte> SectionWriter::finish() const {
  std::vector<Entry> entries;
  std::uint64_t end = sizeof(Header) + parts_.size() * sizeof(Entry);
  for (const Part& part : parts_) {
    entries.push_back({part.id, std::uint32_t{part.is_optional}, alignUp(end), part.bytes.size()});
    end = entries.back().offset + part.bytes.size();
  }
  Header header{kMagic, kFormatMajor, kFormatMinor, static_cast<std::uint32_t>(parts_.size()), end, 0};
  std::vector<std::byte> file(end);
  std::memcpy(file.data(), &header, sizeof header);
  if (!entries.empty()) std::memcpy(file.data() + sizeof header, entries.data(), entries.size() * sizeof(Entry));
  for (std::size_t i = 0; i < parts_.size(); ++i)
    std::copy(parts_[i].bytes.begin(), parts_[i].bytes.end(), file.begin() + static_cast<std::ptrdiff_t>(entries[i].offset));
  header.checksum = checksumOf(file);
  std::memcpy(file.data(), &header, sizeof header);
  return file;
}

}  // namespace spheretree
