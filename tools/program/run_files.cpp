// SPDX-License-Identifier: GPL-3.0-or-later
#include "run_files.h"

#include <algorithm>
#include <fstream>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <vector>

#include "program_end.h"
#include "spheretree/builder/provenance.h"
#include "spheretree/formats/file_io.h"
#include "spheretree/formats/path_name.h"
#include "system_calls.h"

namespace spheretree::tool {
namespace {

namespace fs = std::filesystem;
using formats::FileId;

constexpr const char* kRecordName = ".spheretree-files";

std::mutex mutex;  // protects everything below

std::span<const std::byte> bytesOf(std::string_view text) { return std::as_bytes(std::span<const char>(text.data(), text.size())); }

std::vector<std::byte> contentOf(const fs::path& file) {
  return formats::readFile(file, formats::kMaxFileBytes, formats::FileRole::Working);
}

/// The files that the run has read and written so far, and those that it will write.
class Ledger : public formats::FileObserver {
 public:
  int users = 0;
  const builder::Progress* progress = nullptr;
  std::string command;
  bool force = false;
  bool stdin_used = false, stdout_used = false;

  void onRead(const fs::path& path, const FileId& id) override {
    const std::lock_guard lock(mutex);
    read_.emplace(id, path);
  }

  void onWrite(const fs::path& path, const fs::path& target, const std::optional<FileId>& id, formats::FileRole role) override {
    const std::lock_guard lock(mutex);
    refuseInputs(path, id);
    if (role == formats::FileRole::User && written_.count(target) > 0)
      throw UsageError(formats::toUtf8(path) + ": was written by this run already. Give each output a name of its own.");
  }

  void onComplete(const fs::path& path, const fs::path& target, const fs::path& complete, formats::FileRole role) override {
    if (complete != target) onWrite(path, target, formats::idOf(target), role);
    const std::lock_guard lock(mutex);
    if (made_files_.count(target) > 0) note(target, contentOf(complete));
  }

  void onWritten(const fs::path& target, formats::FileRole role) override {
    const std::lock_guard lock(mutex);
    if (role == formats::FileRole::User) written_.insert(target);
  }

  void checkInterrupted() override {
    if (progress) progress->check();
  }

  void declareRead(const fs::path& path) {
    if (const std::optional<FileId> id = formats::idOf(path)) read_.emplace(*id, path);
  }

  /// The record is only added to, by one write for each line: shards may share a folder.
  void note(const fs::path& target, std::span<const std::byte> bytes) {
    const std::string line = lineOf(target, bytes);
    if (isNoted(target, line)) return;
    const fs::path record = target.parent_path() / kRecordName;
    if (!appendToFile(record, line + '\n'))
      throw formats::FileError(formats::toUtf8(record) + ": cannot be written. Check its permissions and the space on the disk.");
  }

  void declareMade(const fs::path& path, std::span<const std::byte> bytes) {
    const fs::path target = formats::linkTarget(path);
    made_files_.insert(target);
    if (force || !formats::idOf(target)) return;  // a device or a pipe loses nothing
    const std::vector<std::byte> there = contentOf(target);
    if (!bytes.empty() && std::equal(there.begin(), there.end(), bytes.begin(), bytes.end())) return;
    if (isNoted(target, lineOf(target, there))) return;
    throw UsageError(formats::toUtf8(path) +
                     ": is no unedited result of an earlier run of this command, so it is not replaced. Move it away, write to another "
                     "folder, or give --force to replace it.");
  }

  void makeFolder(const fs::path& folder) {
    std::error_code none;
    std::vector<fs::path> missing;
    for (fs::path at = fs::absolute(folder); !at.empty() && !fs::exists(at, none); at = at.parent_path()) missing.push_back(at);
    formats::makeFolder(folder);
    made_.insert(made_.end(), missing.rbegin(), missing.rend());
  }

  void removeEmptyFolders() const {
    std::error_code none;
    for (auto folder = made_.rbegin(); folder != made_.rend(); ++folder)
      if (fs::is_directory(*folder, none) && fs::is_empty(*folder, none)) fs::remove(*folder, none);
  }

  void declareWrite(const fs::path& path) {
    const std::optional<FileId> id = formats::idOf(path);
    refuseInputs(path, id);
    const fs::path target = formats::linkTarget(path);
    const auto other =
        std::find_if(declared_.begin(), declared_.end(), [&](const auto& d) { return d.first == target || (id && d.second.id == id); });
    if (other != declared_.end())
      throw UsageError(formats::toUtf8(path) + ": is named for two outputs (" + formats::toUtf8(other->second.name) +
                       "). Give each a name of its own.");
    formats::checkWritable(path);
    // A device or a pipe may be used for several outputs.
    if (id || !fs::exists(path)) declared_.emplace(target, Output{path, id});
  }

 private:
  struct Output {
    fs::path name;
    std::optional<FileId> id;
  };

  void refuseInputs(const fs::path& path, const std::optional<FileId>& id) const {
    if (!id) return;
    const auto input = read_.find(*id);
    if (input != read_.end())
      throw UsageError(formats::toUtf8(path) + ": would be written over " + formats::toUtf8(input->second) +
                       ", which is read. Give another name.");
  }

  std::string lineOf(const fs::path& target, std::span<const std::byte> bytes) const {
    std::string text = command + '\0' + formats::toUtf8(target.filename()) + '\0' + toHex(builder::bytesHash(bytes));
    return toHex(builder::bytesHash(bytesOf(text)));
  }

  static bool isNoted(const fs::path& target, const std::string& wanted) {
    std::ifstream record(target.parent_path() / kRecordName);
    for (std::string line; std::getline(record, line);)
      if (line == wanted) return true;
    return false;
  }

  std::map<FileId, fs::path> read_;
  std::map<fs::path, Output> declared_;  // by the path with links followed
  std::set<fs::path> written_;
  std::set<fs::path> made_files_;  // outputs that the command line does not name, with links followed
  std::vector<fs::path> made_;     // folders that the run made, each after the one that it is in
};

std::unique_ptr<Ledger> ledger;

void enter(const builder::Progress* progress, const std::string& command = {}, bool force = false) {
  const std::lock_guard lock(mutex);
  if (!ledger) {
    ledger = std::make_unique<Ledger>();
    formats::setFileObserver(ledger.get());
  }
  ++ledger->users;
  if (!ledger->progress) ledger->progress = progress;
  if (ledger->command.empty()) ledger->command = command;
  ledger->force = ledger->force || force;
}

}  // namespace

RunFiles::RunFiles() { enter(nullptr); }

RunFiles::RunFiles(const builder::Progress& progress) { enter(&progress); }

RunFiles::RunFiles(const builder::Progress& progress, const std::string& command, bool force) { enter(&progress, command, force); }

RunFiles::~RunFiles() {
  const std::lock_guard lock(mutex);
  if (--ledger->users > 0) return;
  formats::setFileObserver(nullptr);
  ledger->removeEmptyFolders();
  ledger.reset();
}

void RunFiles::willRead(const fs::path& input) const {
  const std::lock_guard lock(mutex);
  if (!isDash(input)) return ledger->declareRead(input);
  if (ledger->stdin_used) throw UsageError("standard input (-) can be read only once. Give the other input as a file.");
  ledger->stdin_used = true;
}

void RunFiles::willWrite(const fs::path& output) const {
  if (output.empty()) return;
  const std::lock_guard lock(mutex);
  if (!isDash(output)) return ledger->declareWrite(output);
  if (ledger->stdout_used) throw UsageError("standard output (-) can take only one output. Give the other as a file.");
  ledger->stdout_used = true;
}

void RunFiles::willWrite(const fs::path& output, std::initializer_list<const char*> endings, const std::string& what, bool is_text) const {
  if (output.empty()) return;
  std::string all;
  for (const char* ending : endings) all += (all.empty() ? "" : ending == *(endings.end() - 1) ? " or " : ", ") + std::string(ending);
  std::error_code none;
  const bool is_device = fs::exists(output, none) && !fs::is_regular_file(output, none);  // or a folder, which is refused below
  if (!isDash(output) && !is_device && std::find(endings.begin(), endings.end(), endingOf(output)) == endings.end())
    throw UsageError(formats::toUtf8(output) + ": the name of " + what + " must end in " + all + ".");
  if (isDash(output) && !is_text && isTerminal(Stream::Output))
    throw UsageError("standard output is a terminal, and " + what + " is no text. Redirect it, or name a file.");
  willWrite(output);
}

void RunFiles::willMake(const fs::path& output, std::span<const std::byte> bytes) const {
  if (output.empty()) return;
  willWrite(output);
  const std::lock_guard lock(mutex);
  ledger->declareMade(output, bytes);
}

void RunFiles::keepEdits(const fs::path& output) const {
  const std::lock_guard lock(mutex);
  ledger->declareMade(output, {});
}

void RunFiles::keepOthers(const fs::path& folder, const std::function<bool(const std::string&)>& may_be_made) const {
  std::error_code none;
  std::set<fs::path> found;
  for (fs::directory_iterator at(folder.empty() ? "." : folder, none), end; !none && at != end; at.increment(none))
    if (may_be_made(formats::toUtf8(at->path().filename()))) found.insert(folder / at->path().filename());
  for (const fs::path& file : found) keepEdits(file);
}

void RunFiles::willHold(const fs::path& output, std::string_view text) const {
  const std::lock_guard lock(mutex);
  ledger->note(formats::linkTarget(output), bytesOf(text));
}

void RunFiles::makeFolder(const fs::path& folder) const {
  const std::lock_guard lock(mutex);
  ledger->makeFolder(folder);
}

std::string endingOf(const fs::path& path) {
  std::string ending = formats::toUtf8(path.extension());
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return ending;
}

}  // namespace spheretree::tool
