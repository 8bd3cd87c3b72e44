// SPDX-License-Identifier: Apache-2.0
#include "section_file.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "support/random.h"
#include "support/stree_bytes.h"
#include "support/texts.h"

namespace spheretree {
namespace {

using test::Bytes;
using test::FileSection;
using test::put;
using test::resealed;

/// Sections with these sizes, of random bytes, named S00, S01, ...; every other one is optional.
std::vector<FileSection> sectionsOf(const std::vector<std::size_t>& sizes) {
  test::Random random(4);
  std::vector<FileSection> sections;
  for (const std::size_t size : sizes) {
    const std::size_t i = sections.size();
    sections.push_back(
        {"S0" + std::string{static_cast<char>('0' + i / 10), static_cast<char>('0' + i % 10)}, i % 2 ? 1u : 0u, Bytes(size)});
    for (std::byte& b : sections.back().bytes) b = static_cast<std::byte>(random.below(256));
  }
  return sections;
}

Bytes written(const std::vector<FileSection>& sections) {
  SectionWriter writer;
  for (const FileSection& s : sections) writer.add({s.id[0], s.id[1], s.id[2], s.id[3]}, s.flags != 0, s.bytes);
  return writer.finish();
}

/// The status, and the fault that explains it.
std::pair<LoadStatus, std::string> opened(const Bytes& file) {
  std::vector<Section> sections;
  std::string fault;
  const LoadStatus status = openSections(file, sections, fault);
  EXPECT_EQ(status == LoadStatus::Ok, fault.empty()) << fault;
  return {status, fault};
}

TEST(SectionFile, ReturnsTheSectionsThatWereWritten) {
  const std::vector<std::vector<std::size_t>> cases{{}, {0}, {1}, {64, 63, 65, 0, 128, 1}, std::vector<std::size_t>(kMaxSections, 3)};
  for (const std::vector<std::size_t>& sizes : cases) {
    const std::vector<FileSection> wanted = sectionsOf(sizes);
    const Bytes file = written(wanted);
    std::vector<Section> found;
    std::string fault;
    ASSERT_EQ(openSections(file, found, fault), LoadStatus::Ok) << fault;
    ASSERT_EQ(found.size(), wanted.size());
    for (std::size_t i = 0; i < found.size(); ++i) {
      EXPECT_EQ(std::string(found[i].id.begin(), found[i].id.end()), wanted[i].id);
      EXPECT_EQ(found[i].is_optional, wanted[i].flags != 0);
      EXPECT_EQ(found[i].offset % kSectionAlignment, 0u);
      EXPECT_EQ(found[i].bytes.data(), file.data() + found[i].offset) << "it views the file";
      EXPECT_TRUE(std::equal(found[i].bytes.begin(), found[i].bytes.end(), wanted[i].bytes.begin(), wanted[i].bytes.end()));
    }
  }
}

// test::putTogether() follows docs/file_format.md and shares no code with the writer.
TEST(SectionFile, WritesTheBytesOfTheDocument) {
  for (const std::vector<std::size_t>& sizes : {std::vector<std::size_t>{}, {5}, {64, 63, 65, 0, 128, 1}})
    EXPECT_EQ(written(sectionsOf(sizes)), test::putTogether(sectionsOf(sizes)));
}

TEST(SectionFile, RefusesEveryFlippedBitAndEveryTruncation) {
  const Bytes whole = written(sectionsOf({5, 70, 0}));
  Bytes bytes = whole;
  for (std::size_t bit = 0; bit < 8 * whole.size(); ++bit) {
    bytes[bit / 8] ^= static_cast<std::byte>(1u << bit % 8);
    EXPECT_NE(opened(bytes).first, LoadStatus::Ok) << "byte " << bit / 8;
    bytes[bit / 8] = whole[bit / 8];
  }
  for (std::size_t size = 0; size < whole.size(); ++size)
    EXPECT_NE(opened(Bytes(whole.data(), whole.data() + size)).first, LoadStatus::Ok) << "first " << size << " bytes";
}

TEST(SectionFile, NamesThePlaceOfAFault) {
  const Bytes good = written(sectionsOf({5, 70}));  // table at 32 and 56, sections at 128 and 192, end at 262
  ASSERT_EQ(good.size(), 262u);
  const auto with = [&](std::size_t offset, auto value) {
    Bytes bytes = good;
    put(bytes, offset, value);
    return resealed(bytes);
  };
  const auto first = [&](std::size_t size) { return Bytes(good.data(), good.data() + size); };
  Bytes longer = good, unsealed = good, loose = good;
  longer.push_back({});
  unsealed[130] ^= std::byte{1};
  loose.push_back({});
  put(loose, 16, std::uint64_t{263});
  const std::vector<std::tuple<Bytes, LoadStatus, std::string>> cases{
      {{}, LoadStatus::BadMagic, "offset 0: does not start with the 8 bytes of a sphere-tree file"},
      {with(0, 'S'), LoadStatus::BadMagic, "offset 0: does not start"},
      {first(5), LoadStatus::Truncated, "has 5 bytes of 32"},
      {first(31), LoadStatus::Truncated, "has 31 bytes of 32"},
      {first(100), LoadStatus::Truncated, "has 100 bytes of 262"},
      {with(8, std::uint32_t{0x00030002}), LoadStatus::UnsupportedVersion, "offset 8: version 2.3, this reader knows 1.x"},
      {longer, LoadStatus::TrailingBytes, "has 1 bytes behind its end at 262"},
      {unsealed, LoadStatus::BadChecksum, "offset 24: the checksum of the 262 bytes differs"},
      {with(12, std::uint32_t{65}), LoadStatus::BadHeader, "offset 12: there are more than 64 sections"},
      {with(12, std::uint32_t{10}), LoadStatus::BadHeader, "offset 12: there are more sections than the file has room for"},
      {with(36, std::uint32_t{2}), LoadStatus::BadHeader, "offset 32: section 'S000' at offset 128 has unknown flags"},
      {with(56 + 3, '0'), LoadStatus::BadHeader, "offset 56: section 'S000' at offset 192 repeats an earlier one"},
      {with(56 + 8, std::uint64_t{256}), LoadStatus::BadHeader, "offset 56: section 'S001' at offset 256 does not stand behind"},
      {with(56 + 16, std::uint64_t{71}), LoadStatus::BadHeader, "offset 56: section 'S001' at offset 192 ends behind the file"},
      {with(56 + 16, ~std::uint64_t{0}), LoadStatus::BadHeader, "ends behind the file"},
      {with(191, '!'), LoadStatus::BadHeader, "offset 133: padding is not zero"},
      {resealed(loose), LoadStatus::BadHeader, "offset 262: bytes that belong to no section"}};
  for (const auto& [bytes, status, message] : cases) {
    const auto [found, fault] = opened(bytes);
    EXPECT_EQ(found, status) << message;
    EXPECT_TRUE(test::has(fault, message)) << fault << " instead of " << message;
  }
  EXPECT_EQ(opened(with(10, std::uint16_t{7})).first, LoadStatus::Ok) << "a newer minor version only adds optional sections";
}

TEST(SectionFile, NamesOfSectionsArePrintable) {
  EXPECT_EQ(nameOf({{'C', 'O', 'V', 'R'}, false, 256, {}}), "section 'COVR' at offset 256");
  EXPECT_EQ(nameOf({{'\n', 'A', '\x7f', 'B'}, true, 0, {}}), "section '?A?B' at offset 0");
}

}  // namespace
}  // namespace spheretree
