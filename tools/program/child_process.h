// SPDX-License-Identifier: GPL-3.0-or-later
// Other programs as child processes, and the folder in which files are exchanged with them.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

namespace spheretree::tool {

/// A folder of our own below the system's folder for temporary files; it is removed with its content at the end.
class ScratchFolder {
 public:
  /// @throws formats::FileError if it cannot be made.
  ScratchFolder();
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  std::filesystem::path operator/(const char* name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

/// A running child without input and output; it is killed if the object is destroyed before it ends. It is a process
/// group of its own: Ctrl-C reaches this program, which ends the child.
class ChildProcess {
 public:
  /// Starts `program`, from PATH unless it names a folder; what it writes to standard error goes to the file
  /// `messages`. @throws std::system_error if it cannot be run.
  ChildProcess(const std::filesystem::path& program, const std::vector<std::string>& arguments, const std::filesystem::path& messages);
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  bool hasEnded();
  int status() const { return status_; }  // once it has ended: as waitpid() gives it

 private:
  pid_t process_ = -1;
  int status_ = 0;
  bool has_ended_ = false;
};

}  // namespace spheretree::tool
