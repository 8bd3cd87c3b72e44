// SPDX-License-Identifier: Apache-2.0
#include "spheretree/formats/file_io.h"

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <set>
#include <string>
#include <system_error>
#include <utility>

#include "spheretree/formats/errors.h"
#include "spheretree/formats/path_name.h"
#include "text/file_calls.h"
#include "text/temporary_file.h"

namespace spheretree::formats {
namespace {

std::string reason(int error) { return std::generic_category().message(error); }

std::atomic<FileObserver*> observer{nullptr};

bool isDash(const std::filesystem::path& path) { return path == "-"; }

[[noreturn]] void failRead(const std::filesystem::path& path, int error) {
  const std::string advice =
      error == EISDIR ? "Name files in it, such as " + toUtf8(path / "*") + " does." : "Check the name and the permissions.";
  throw FileError(shownName(path) + ": cannot be read: " + reason(error) + ". " + advice);
}

[[noreturn]] void failWrite(const std::filesystem::path& path, int error) {
  const char* advice = isFullDisk(error)                     ? "Free some space or write elsewhere."
                       : error == ENOENT || error == ENOTDIR ? "Create the folder first."
                       : error == EISDIR                     ? "Name a file, not a folder."
                       : error == EFBIG ? "It would be larger than the limit of the shell (ulimit -f) or the file system."
                       : error == EPIPE ? "Its reader has ended."
                       : error == ELOOP ? "Its links lead in a circle."
                                        : "Check the folder's permissions or write elsewhere.";
  throw FileError((isDash(path) ? "standard output" : toUtf8(path)) + ": cannot be written: " + reason(error) + ". " + advice);
}

/// What one call reads or writes.
unsigned portion(std::size_t bytes) { return static_cast<unsigned>(std::min<std::size_t>(bytes, std::size_t{1} << 30)); }

/// Returns 0 or an errno.
int writeAll(int fd, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(fd, bytes.data(), portion(bytes.size()));
    if (written < 0) {
      if (errno == EINTR) continue;
      return errno;
    }
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
  return 0;
}

/// Whether `path` exists; throws for targets that cannot be written to.
bool statTarget(const std::filesystem::path& path, FileStatus& status) {
  if (const int error = findStatus(path, status)) {
    if (error != ENOENT) failWrite(path, error);
    return false;
  }
  if (status.kind == FileKind::Folder) failWrite(path, EISDIR);
  if (const int error = checkReplaceable(path)) failWrite(path, error);
  return true;
}

/// Reads to the end into `bytes`, at most `max_bytes`. Returns 0 or an errno.
int readAll(int fd, std::vector<std::byte>& bytes, std::uint64_t max_bytes) {
  std::size_t used = 0;
  for (;;) {
    if (used == bytes.size()) bytes.resize(bytes.size() * 2);
    const ssize_t count = ::read(fd, bytes.data() + used, portion(bytes.size() - used));
    if (count < 0) {
      if (errno != EINTR) return errno;
      if (FileObserver* o = observer.load()) o->checkInterrupted();
      continue;
    }
    if (count == 0) break;
    used += static_cast<std::size_t>(count);
    if (used > max_bytes) break;
  }
  bytes.resize(used);
  return 0;
}

/// Opening a named pipe waits for its writer.
int openInput(const std::filesystem::path& path) {
  if (isDash(path)) return duplicateStandard(STDIN_FILENO);
  for (;;) {
    if (FileObserver* o = observer.load()) o->checkInterrupted();
    const int fd = openToRead(path);
    if (fd >= 0 || errno != EINTR) return fd;
  }
}

/// Whether `path` is a regular file with exactly these bytes.
bool holds(const std::filesystem::path& path, std::span<const std::byte> bytes) {
  const Descriptor file(openAtOnce(path));
  FileStatus status;
  if (file.get() < 0 || findStatus(file.get(), status) != 0 || status.kind != FileKind::Regular) return false;
  if (status.size != bytes.size()) return false;
  std::vector<std::byte> there(bytes.size() + 1);
  return readAll(file.get(), there, bytes.size()) == 0 && std::equal(there.begin(), there.end(), bytes.begin(), bytes.end());
}

}  // namespace

std::string shownName(const std::filesystem::path& path) { return isDash(path) ? "standard input" : toUtf8(path); }

FileObserver* setFileObserver(FileObserver* next) noexcept { return observer.exchange(next); }

std::optional<FileId> idOf(const std::filesystem::path& path) {
  FileStatus status;
  if (findStatus(path, status) != 0 || status.kind != FileKind::Regular) return std::nullopt;
  return FileId{status.device, status.inode};
}

std::vector<std::byte> readFile(const std::filesystem::path& path, std::uint64_t max_bytes, FileRole role) {
  const Descriptor file(openInput(path));
  if (file.get() < 0) failRead(path, errno);
  FileStatus status;
  if (const int error = findStatus(file.get(), status)) failRead(path, error);
  if (status.kind == FileKind::Folder) failRead(path, EISDIR);
  const bool is_regular = status.kind == FileKind::Regular;
  FileObserver* const told = observer.load();
  if (told && role == FileRole::User && is_regular) told->onRead(path, {status.device, status.inode});
  const auto refuseSize = [&] {
    throw FileError(shownName(path) + ": has more than " + std::to_string(max_bytes) + " bytes, the limit for such a file.");
  };
  if (is_regular && status.size > max_bytes) refuseSize();

  // The size is only a first guess: pipes have none, and a file may change while it is read.
  std::vector<std::byte> bytes(is_regular ? static_cast<std::size_t>(status.size) + 1 : std::size_t{1} << 16);
  if (const int error = readAll(file.get(), bytes, max_bytes)) failRead(path, error);
  if (bytes.size() > max_bytes) refuseSize();
  return bytes;
}

std::filesystem::path linkTarget(const std::filesystem::path& path) {
  std::filesystem::path target = path;
  std::error_code none;
  for (int links = 0; std::filesystem::is_symlink(target, none); ++links) {
    if (links == 40) failWrite(path, ELOOP);  // the limit of Linux
    target = target.parent_path() / std::filesystem::read_symlink(target);
  }
  const std::filesystem::path folder = std::filesystem::weakly_canonical(std::filesystem::absolute(target).parent_path(), none);
  return none || !target.has_filename() ? target : folder / target.filename();
}

void checkWritable(const std::filesystem::path& path) {
  if (isDash(path)) return;
  FileStatus status;
  if (statTarget(path, status)) return;
  if (!path.has_filename()) failWrite(path, EISDIR);
  if (const int error = checkFolder(linkTarget(path).parent_path())) failWrite(path, error);
}

void makeFolder(const std::filesystem::path& path) {
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (error) throw FileError(toUtf8(path) + ": cannot be made: " + error.message() + ". Choose another folder.");
}

struct WholeFile::State {
  std::filesystem::path path, target, temporary;  // as requested; with links followed; the file that is written, empty: written directly
  Descriptor file;
  FileRole role;
  bool keep_permissions;
  unsigned permissions;

  const bool is_straight = temporary.empty();
  std::filesystem::path folder() const;  // the folder of the target
  void finish(bool sync);                // no bytes may be appended afterwards
  void publish();                        // gives the file its name
};

WholeFile::WholeFile(const std::filesystem::path& path, FileRole role) {
  FileStatus status;
  const bool exists = !isDash(path) && statTarget(path, status);
  if (isDash(path) || (exists && status.kind != FileKind::Regular)) {  // standard output, a device or a pipe
    const int fd = isDash(path) ? duplicateStandard(STDOUT_FILENO) : openToWrite(path);
    if (fd < 0) failWrite(path, errno);
    state_.reset(new State{path, path, {}, Descriptor(fd), role, false, 0});
    return;
  }
  std::filesystem::path target = linkTarget(path);
  if (!target.has_filename()) failWrite(path, EISDIR);
  if (FileObserver* o = observer.load()) o->onWrite(path, target, idOf(target), role);
  const std::filesystem::path folder = target.has_parent_path() ? target.parent_path() : std::filesystem::path(".");
  TemporaryFile temporary = createTemporary(folder);
  if (temporary.file.get() < 0) failWrite(path, temporary.error);
  state_.reset(new State{path, std::move(target), std::move(temporary.path), std::move(temporary.file), role, exists, status.permissions});
}

WholeFile::~WholeFile() {
  if (!state_ || state_->temporary.empty()) return;
  { const Descriptor closed = std::move(state_->file); }  // Windows removes no open file
  std::error_code ignored;
  std::filesystem::remove(state_->temporary, ignored);
}

void WholeFile::append(std::span<const std::byte> bytes) {
  if (const int error = writeAll(state_->file.get(), bytes)) failWrite(state_->path, error);
}

void WholeFile::append(std::string_view text) { append(std::as_bytes(std::span<const char>(text.data(), text.size()))); }

void WholeFile::State::finish(bool sync) {
  int error = 0;
  if (!is_straight && keep_permissions) error = setPermissions(file.get(), permissions);
  if (!is_straight && (sync || !canSyncDisk()) && !error) error = syncFile(file.get());
  const int close_error = file.close();
  if (!error) error = close_error;
  if (error) failWrite(path, error);
}

void WholeFile::State::publish() {
  if (is_straight) return;
  FileObserver* const told = observer.load();
  if (told) told->onComplete(path, target, temporary, role);
  if (const int error = replaceFile(temporary, target)) failWrite(path, error);
  temporary.clear();
  if (told) told->onWritten(target, role);
}

std::filesystem::path WholeFile::State::folder() const {
  return target.has_parent_path() ? target.parent_path() : std::filesystem::path(".");
}

void WholeFile::commit() {
  state_->finish(true);
  state_->publish();
  if (!state_->is_straight) syncFolder(state_->folder());
}

WholeFiles::WholeFiles() = default;
WholeFiles::~WholeFiles() = default;

void WholeFiles::add(const std::filesystem::path& path, std::span<const std::byte> bytes, FileRole role) {
  auto file = std::make_unique<WholeFile>(path, role);
  if (holds(file->state_->target, bytes)) {
    if (FileObserver* o = observer.load()) o->onComplete(path, file->state_->target, file->state_->target, role);
    return;
  }
  file->append(bytes);
  file->state_->finish(false);
  files_.push_back(std::move(file));
}

void WholeFiles::commit() {
  std::set<std::filesystem::path> folders;
  for (const auto& file : files_)
    if (!file->state_->is_straight) folders.insert(file->state_->folder());
  for (const std::filesystem::path& folder : folders)
    if (const int error = syncDisk(folder)) failWrite(folder, error);
  for (const auto& file : files_) file->state_->publish();
  for (const std::filesystem::path& folder : folders) syncFolder(folder);
  files_.clear();
}

void writeWhole(const std::filesystem::path& path, std::span<const std::byte> bytes, FileRole role) {
  WholeFile file(path, role);
  file.append(bytes);
  file.commit();
}

void writeWhole(const std::filesystem::path& path, std::string_view text, FileRole role) {
  writeWhole(path, std::as_bytes(std::span<const char>(text.data(), text.size())), role);
}

}  // namespace spheretree::formats
