// SPDX-License-Identifier: Apache-2.0
// The container of a .stree file: a header, a table of sections, and the sections, each at a multiple of 64 bytes. It
// does not interpret the content of sections; the codec does. The layout: docs/file_format.md
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "spheretree/core/file_format.h"

namespace spheretree {

using SectionId = std::array<char, 4>;  // capital letters and digits

struct Section {
  SectionId id;
  bool is_optional;                  // a reader that does not know the section skips it
  std::uint64_t offset;              // in the file
  std::span<const std::byte> bytes;  // within the file
};

/// For example "section 'COVR' at offset 256".
std::string nameOf(const Section& section);

/// Finds the sections of a complete file. Checks magic, version, size, checksum, table, order, gaps and padding.
/// `fault` receives the place and the values if the result is not Ok.
LoadStatus openSections(std::span<const std::byte> file, std::vector<Section>& sections, std::string& fault);

/// Assembles a file.
class SectionWriter {
 public:
  /// Adds a section; the file keeps the order of the calls. At most kMaxSections.
  void add(SectionId id, bool is_optional, std::vector<std::byte> bytes) { parts_.push_back({id, is_optional, std::move(bytes)}); }
  std::vector<std::byte> finish() const;

 private:
  struct Part {
    SectionId id;
    bool is_optional;
    std::vector<std::byte> bytes;
  };
  std::vector<Part> parts_;
};

}  // namespace spheretree
