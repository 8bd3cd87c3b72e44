// SPDX-License-Identifier: Apache-2.0
// What all parts of the file format share: its version, its limits, and the result of reading it. The layout:
// docs/file_format.md
#pragma once

#include <cstddef>
#include <cstdint>

namespace spheretree {

inline constexpr std::uint16_t kFormatMajor = 1;      // a reader refuses any other
inline constexpr std::uint16_t kFormatMinor = 0;      // a newer minor version only adds optional sections
inline constexpr std::size_t kSectionAlignment = 64;  // of the start of a section in the file: one cache line
inline constexpr std::uint32_t kMaxSections = 64;     // there are 10 kinds; the limit keeps the table small and its check fast

enum class LoadStatus {
  Ok,
  BadMagic,
  UnsupportedVersion,
  Truncated,
  TrailingBytes,
  BadChecksum,
  BadHeader,       // the header or the table of sections is out of range, or a section is missing
  UnknownSection,  // a mandatory section that this reader does not know
  BadSection,      // the size or a field of a section is out of range
  BadTopology,     // the numbers of children do not make a tree
  BadTree,         // findFault() found a fault
  OutOfMemory,
};

}  // namespace spheretree
