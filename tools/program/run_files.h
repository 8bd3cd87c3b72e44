// SPDX-License-Identifier: GPL-3.0-or-later
// The files of one run of a program. Only this class decides whether an output may be written: no output replaces a
// file that the run reads, or another output, under any path (another name, a link, a file that is read because another
// file names it). An output that the command line does not name replaces only what an earlier run of the same command
// wrote there and nobody edited since. To know that, each folder holds a file `.spheretree-files`: a hash of the
// command, the name and the bytes of every such output, one a line. A line is added before its output gets its name, so
// that a run that is killed can be run again.
#pragma once

#include <filesystem>
#include <functional>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>

#include "spheretree/builder/progress.h"

namespace spheretree::tool {

/// While a RunFiles exists, every file that formats::readFile() reads is recorded, and formats::WholeFile refuses to
/// replace it. Several instances share their records: a program has one for the whole run, and functions that write
/// several files have one of their own, so that they are safe in any program.
class RunFiles {
 public:
  RunFiles();
  /// A read that waits for a pipe ends with builder::Cancelled after `progress` is cancelled.
  explicit RunFiles(const builder::Progress& progress);
  /// As above, for the whole run of a command. With `force`, outputs that nobody named replace whatever is there.
  RunFiles(const builder::Progress& progress, const std::string& command, bool force);
  ~RunFiles();
  RunFiles(const RunFiles&) = delete;
  RunFiles& operator=(const RunFiles&) = delete;

  /// Call it for an input before it is read. "-" is standard input, which can be read only once. @throws UsageError for
  /// the second "-".
  void willRead(const std::filesystem::path& input) const;

  /// Call it for an output before long work: it writes nothing, but refuses now what formats::WholeFile would refuse at
  /// the end. "-" is standard output. An empty path means no output.
  /// @throws UsageError if it would replace a file that is read or another output; formats::FileError if it cannot be
  /// written.
  void willWrite(const std::filesystem::path& output) const;

  /// As above, for a file whose name must end in one of `endings`, in any case; "-" and devices are also allowed.
  /// @throws UsageError for another ending, or for binary data on a terminal (`is_text` false).
  void willWrite(const std::filesystem::path& output, std::initializer_list<const char*> endings, const std::string& what,
                 bool is_text = true) const;

  /// As the first, for an output that the command line does not name, such as a file in the folder that -o names.
  /// `bytes`: its content, if it is known beforehand; a file that holds it already is no one's loss.
  /// @throws UsageError, also if it would replace a file that no earlier run of this command wrote, or an edited one.
  void willMake(const std::filesystem::path& output, std::span<const std::byte> bytes = {}) const;

  /// For outputs of willWrite() that people edit, such as a draft: refuses what willMake() refuses.
  void keepEdits(const std::filesystem::path& output) const;

  /// For outputs of willMake() whose names are known only after long work: refuses beforehand what it would refuse for
  /// any file in `folder` whose name `may_be_made`.
  void keepOthers(const std::filesystem::path& folder, const std::function<bool(const std::string& name)>& may_be_made) const;

  /// For a file of willMake() that grows: declares that it is about to hold `text`, which a later run may replace.
  void willHold(const std::filesystem::path& output, std::string_view text) const;

  /// Makes a folder for outputs before long work, with the folders above it. Those that are still empty when the run
  /// ends are removed again, so that a run that is refused or interrupted leaves nothing.
  /// @throws formats::FileError if it cannot be made.
  void makeFolder(const std::filesystem::path& folder) const;
};

/// The extension of a file name in lower case: ".stree", or "".
std::string endingOf(const std::filesystem::path& path);

/// "-": standard input or output.
inline bool isDash(const std::filesystem::path& path) { return path == "-"; }

}  // namespace spheretree::tool
