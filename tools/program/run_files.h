// SPDX-License-Identifier: GPL-3.0-or-later
// The files of one run of a program. This is the one place that decides whether an output may be written: none replaces
// a file that the run reads, or another of its outputs, whatever the path looks like (another name, a link, a file that
// is read because another names it).
#pragma once

#include <filesystem>
#include <initializer_list>
#include <string>

#include "spheretree/builder/progress.h"

namespace spheretree::tool {

/// While one lives, every file that formats::readFile() reads is remembered, and formats::WholeFile refuses to replace
/// it. Where several live, they share what they remember: a program has one around a run, and functions that write
/// several files have one of their own, so that they are safe in any program.
class RunFiles {
 public:
  RunFiles();
  /// Reading that waits for a pipe ends with builder::Cancelled once `progress` is cancelled.
  explicit RunFiles(const builder::Progress& progress);
  ~RunFiles();
  RunFiles(const RunFiles&) = delete;
  RunFiles& operator=(const RunFiles&) = delete;

  /// An input, before it is read. "-" is standard input, which can be read once. @throws UsageError for the second "-".
  void willRead(const std::filesystem::path& input) const;

  /// An output, before long work: nothing is written, but what formats::WholeFile would refuse at the end is refused
  /// now. "-" is standard output. An empty path is no output.
  /// @throws UsageError if it would replace a file that is read or another output; formats::FileError if it cannot be
  /// written.
  void willWrite(const std::filesystem::path& output) const;

  /// The same for a file whose name must end in one of `endings`, in any case; "-" and devices may stand for it.
  /// @throws UsageError for another ending, or for binary data on a terminal (`is_text` false).
  void willWrite(const std::filesystem::path& output, std::initializer_list<const char*> endings, const std::string& what,
                 bool is_text = true) const;
};

/// The ending of a file's name in lower case: ".stree", or "".
std::string endingOf(const std::filesystem::path& path);

/// "-": standard input or output.
inline bool isDash(const std::filesystem::path& path) { return path.native() == "-"; }

}  // namespace spheretree::tool
