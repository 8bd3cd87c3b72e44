// SPDX-License-Identifier: Apache-2.0
#include "spheretree/formats/file_io.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <pthread.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "spheretree/formats/errors.h"
#include "support/scratch_folder.h"
#include "support/texts.h"

namespace spheretree::formats {
namespace {

namespace fs = std::filesystem;

std::string textOf(const std::vector<std::byte>& bytes) { return {reinterpret_cast<const char*>(bytes.data()), bytes.size()}; }

/// Message of the FileError that `call` throws; "" if it throws none.
template <class Call>
std::string fileError(Call&& call) {
  return test::refusalOf<FileError>(call);
}

std::size_t entries(const fs::path& folder) {
  return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

TEST(WriteWhole, IsReadBackAndLeavesNothingElse) {
  const test::ScratchFolder folder;
  const fs::path path = folder.path() / "a.bin";
  std::string large(300000, 'x');
  large[1] = '\0';
  for (const std::string& text : {std::string(), std::string("first"), large, std::string("shorter")}) {
    writeWhole(path, text);
    EXPECT_EQ(textOf(readFile(path)), text);
    EXPECT_EQ(entries(folder.path()), 1u);
  }
}

TEST(WriteWhole, ReplacesAtOnceSoThatAReaderNeverSeesAPart) {
  const test::ScratchFolder folder;
  const fs::path path = folder.path() / "a.bin";
  const std::string a(200000, 'a'), b(100000, 'b');
  writeWhole(path, a);
  std::thread writer([&] {
    for (int i = 0; i < 20; ++i) writeWhole(path, i % 2 ? a : b);
  });
  int torn = 0;
  for (int i = 0; i < 200; ++i) {
    const std::string seen = textOf(readFile(path));
    torn += seen != a && seen != b;
  }
  writer.join();
  EXPECT_EQ(torn, 0);
}

TEST(WriteWhole, KeepsPermissionsAndFollowsLinks) {
  const test::ScratchFolder folder;
  const fs::path path = folder.path() / "real", link = folder.path() / "link";
  writeWhole(path, "old");
  ASSERT_EQ(::chmod(path.c_str(), 0640), 0);
  fs::create_symlink(path, link);
  writeWhole(link, "new");
  EXPECT_TRUE(fs::is_symlink(link));
  EXPECT_EQ(textOf(readFile(path)), "new");
  EXPECT_EQ(static_cast<int>(fs::status(path).permissions()), 0640);
}

TEST(WriteWhole, FollowsLinksThatLeadNowhereYet) {
  const test::ScratchFolder folder;
  fs::create_directory(folder.path() / "there");
  fs::create_symlink("there/real", folder.path() / "first");
  fs::create_symlink("first", folder.path() / "link");
  writeWhole(folder.path() / "link", "new");
  EXPECT_TRUE(fs::is_symlink(folder.path() / "link"));
  EXPECT_EQ(textOf(readFile(folder.path() / "there" / "real")), "new");
  EXPECT_EQ(entries(folder.path() / "there"), 1u);
  fs::create_symlink("circle", folder.path() / "circle");
  EXPECT_NE(fileError([&] { writeWhole(folder.path() / "circle", "x"); }), "");
  EXPECT_NE(fileError([&] { checkWritable(folder.path() / "circle"); }), "");
  fs::create_symlink("no/such/folder", folder.path() / "away");
  EXPECT_NE(fileError([&] { checkWritable(folder.path() / "away"); }).find("Create the folder"), std::string::npos);
}

/// Makes `path` look as if it was last written `age` seconds ago.
void makeOlder(const fs::path& path, int age) { fs::last_write_time(path, fs::file_time_type::clock::now() - std::chrono::seconds(age)); }

TEST(WholeFile, RemovesWhatKilledProgramsLeftBehindAndNothingElse) {
  const test::ScratchFolder folder;
  const fs::path kept[] = {folder.path() / ".spheretree-1-0.tmp", folder.path() / ".spheretree-notes", folder.path() / "x.tmp",
                           folder.path() / ".spheretree-folder.tmp"};
  const fs::path leftover = folder.path() / ".spheretree-999999-7.tmp", held = folder.path() / ".spheretree-2-0.tmp";
  for (const fs::path& path : {kept[0], kept[1], kept[2], leftover, held}) std::ofstream(path) << "x";
  fs::create_directory(kept[3]);
  for (const fs::path& path : {kept[1], kept[2], leftover, held, kept[3]}) makeOlder(path, 3600);
  const int fd = ::open(held.c_str(), O_RDONLY);
  ASSERT_EQ(::flock(fd, LOCK_EX), 0);
  writeWhole(folder.path() / "a", "x");
  EXPECT_FALSE(fs::exists(leftover));
  EXPECT_TRUE(fs::exists(held)) << "another program holds it";
  for (const fs::path& path : kept) EXPECT_TRUE(fs::exists(path)) << path;
  ::close(fd);
}

TEST(WholeFile, HoldsItsTemporaryFileUntilItIsDone) {
  const test::ScratchFolder folder;
  WholeFile file(folder.path() / "a");
  const fs::path temporary = fs::directory_iterator(folder.path())->path();
  const int fd = ::open(temporary.c_str(), O_RDONLY);
  EXPECT_NE(::flock(fd, LOCK_EX | LOCK_NB), 0) << "a sweep could take it away";
  file.commit();
  EXPECT_EQ(::flock(fd, LOCK_EX | LOCK_NB), 0);
  ::close(fd);
}

struct Told : FileObserver {
  std::vector<std::string> lines;
  std::atomic<bool> interrupted = false;
  void onRead(const fs::path& path, const FileId&) override { lines.push_back("read " + path.filename().string()); }
  void onWrite(const fs::path& path, const fs::path& target, const std::optional<FileId>& id, FileRole) override {
    lines.push_back("write " + path.filename().string() + " as " + target.filename().string() + (id ? " over it" : ""));
    if (path.filename() == "refused") throw std::logic_error("refused");
  }
  void onComplete(const fs::path& path, const fs::path& target, const fs::path& complete, FileRole) override {
    const std::vector<std::byte> bytes = readFile(complete, 10, FileRole::Working);
    lines.push_back("complete " + path.filename().string() + (complete == target ? " there already: " : ": ") +
                    std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
  }
  void onWritten(const fs::path& target, FileRole) override { lines.push_back("written " + target.filename().string()); }
  void checkInterrupted() override {
    if (interrupted) throw std::runtime_error("interrupted");
  }
};

/// Sets an observer during its own lifetime.
struct Observing {
  explicit Observing(FileObserver& observer) : before(setFileObserver(&observer)) {}
  ~Observing() { setFileObserver(before); }
  FileObserver* before;
};

TEST(FileObserver, HearsOfUserFilesThatAreReadAndOfAllThatAreWritten) {
  const test::ScratchFolder folder;
  Told told;
  {
    const Observing observing(told);
    writeWhole(folder.path() / "a", "x");
    fs::create_symlink("a", folder.path() / "link");
    (void)readFile(folder.path() / "link");
    (void)readFile(folder.path() / "a", 10, FileRole::Working);
    writeWhole(folder.path() / "link", "y", FileRole::Working);
    writeWhole("/dev/null", "z");
    EXPECT_THROW(writeWhole(folder.path() / "refused", "x"), std::logic_error);
    WholeFiles files;
    const std::byte y{'y'};
    files.add(folder.path() / "a", {&y, 1});
  }
  writeWhole(folder.path() / "unheard", "x");
  const std::vector<std::string> expected{"write a as a",
                                          "complete a: x",
                                          "written a",
                                          "read link",
                                          "write link as a over it",
                                          "complete link: y",
                                          "written a",
                                          "write refused as refused",
                                          "write a as a over it",
                                          "complete a there already: y"};
  EXPECT_EQ(told.lines, expected);
  EXPECT_EQ(entries(folder.path()), 3u);
}

TEST(FileObserver, EndsWaitingForAPipeWhenASignalComes) {
  const test::ScratchFolder folder;
  const fs::path pipe = folder.path() / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  struct sigaction action {
  }, before{};
  action.sa_handler = [](int) {};
  ::sigaction(SIGUSR1, &action, &before);
  Told told;
  const Observing observing(told);
  const pthread_t waiting = ::pthread_self();
  std::thread other([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    told.interrupted = true;
    for (int i = 0; i < 100 && told.interrupted; ++i) {  // again, if it came before the wait
      ::pthread_kill(waiting, SIGUSR1);
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  });
  EXPECT_THROW(readFile(pipe), std::runtime_error);
  told.interrupted = false;
  other.join();
  ::sigaction(SIGUSR1, &before, nullptr);
}

TEST(FileIo, SaysHowToNameTheFilesOfAFolder) {
  const test::ScratchFolder folder;
  try {
    (void)readFile(folder.path());
    ADD_FAILURE() << "a folder was read";
  } catch (const FileError& e) {
    EXPECT_NE(std::string(e.what()).find("Name files in it, such as " + (folder.path() / "*").string()), std::string::npos) << e.what();
  }
}

TEST(WholeFiles, AppearTogetherOrNotAtAll) {
  const test::ScratchFolder folder;
  const auto path = [&](int k) { return folder.path() / std::to_string(k); };
  const auto bytes = [](const std::string& text) { return std::as_bytes(std::span<const char>(text.data(), text.size())); };
  const auto entries = [&] { return std::distance(std::filesystem::directory_iterator(folder.path()), {}); };
  writeWhole(path(0), std::string_view("old"));
  {
    WholeFiles files;
    for (int k = 0; k < 300; ++k) files.add(path(k), bytes("new " + std::to_string(k)));
    EXPECT_FALSE(std::filesystem::exists(path(1)));
    EXPECT_EQ(entries(), 301);
  }
  EXPECT_EQ(entries(), 1) << "without commit() nothing is left";
  const auto text = [&](int k) {
    const std::vector<std::byte> read = readFile(path(k));
    return std::string(reinterpret_cast<const char*>(read.data()), read.size());
  };
  EXPECT_EQ(text(0), "old");
  WholeFiles files;
  for (int k = 0; k < 300; ++k) files.add(path(k), bytes("new " + std::to_string(k)));
  files.commit();
  EXPECT_EQ(entries(), 300);
  for (int k = 0; k < 300; ++k) EXPECT_EQ(text(k), "new " + std::to_string(k));
}

TEST(WholeFiles, LeaveAFileThatHoldsTheSameAsItIs) {
  const test::ScratchFolder folder;
  const std::filesystem::path same = folder.path() / "same", other = folder.path() / "other";
  writeWhole(same, std::string_view("abc"));
  writeWhole(other, std::string_view("abd"));
  const auto before = idOf(same), other_before = idOf(other);
  WholeFiles files;
  const std::string text = "abc";
  for (const std::filesystem::path& path : {same, other}) files.add(path, std::as_bytes(std::span<const char>(text.data(), text.size())));
  files.commit();
  EXPECT_EQ(idOf(same), before);
  EXPECT_NE(idOf(other), other_before);
}

TEST(WriteWhole, FailsWithAReasonAndLeavesNothing) {
  const test::ScratchFolder folder;
  EXPECT_NE(fileError([&] { writeWhole(folder.path(), "x"); }).find("folder"), std::string::npos);
  EXPECT_NE(fileError([&] { writeWhole(folder.path() / "no" / "a", "x"); }).find("Create the folder"), std::string::npos);
  EXPECT_NE(fileError([&] { writeWhole(folder.path() / std::string(300, 'n'), "x"); }), "") << "name too long";
  EXPECT_NE(fileError([&] { writeWhole(folder.path() / "file" / "", "x"); }), "");
  EXPECT_EQ(entries(folder.path()), 0u);
}

TEST(CheckWritable, RefusesWhatCannotBeWrittenAndWritesNothing) {
  const test::ScratchFolder folder;
  EXPECT_NE(fileError([&] { checkWritable(folder.path()); }).find("folder"), std::string::npos);
  EXPECT_NE(fileError([&] { checkWritable(folder.path() / "no" / "a"); }).find("Create the folder"), std::string::npos);
  EXPECT_NE(fileError([&] { checkWritable(folder.path() / "file" / ""); }), "");
  checkWritable(folder.path() / "a");
  EXPECT_EQ(entries(folder.path()), 0u);
  writeWhole(folder.path() / "a", "x");
  checkWritable(folder.path() / "a");
  EXPECT_EQ(textOf(readFile(folder.path() / "a")), "x");
}

TEST(MakeFolder, MakesWhatIsMissingAndRefusesFiles) {
  const test::ScratchFolder folder;
  makeFolder(folder.path() / "a" / "b");
  EXPECT_TRUE(fs::is_directory(folder.path() / "a" / "b"));
  makeFolder(folder.path() / "a");  // exists already
  writeWhole(folder.path() / "file", "x");
  EXPECT_NE(fileError([&] { makeFolder(folder.path() / "file"); }).find("cannot be made"), std::string::npos);
  EXPECT_NE(fileError([&] { makeFolder(folder.path() / "file" / "c"); }).find("cannot be made"), std::string::npos);
}

TEST(WriteWhole, WritesDevicesStraight) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "no /dev/full";
  EXPECT_NE(fileError([] { writeWhole("/dev/full", "x"); }).find("space"), std::string::npos);
  EXPECT_TRUE(fs::is_character_file("/dev/full")) << "a device must not be replaced";
  writeWhole("/dev/null", "x");
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

TEST(WriteWhole, RefusesReadOnlyFilesAndFolders) {
  if (::geteuid() == 0) GTEST_SKIP() << "root may write everywhere";
  const test::ScratchFolder folder;
  const fs::path path = folder.path() / "a";
  writeWhole(path, "old");
  ASSERT_EQ(::chmod(path.c_str(), 0444), 0);
  EXPECT_NE(fileError([&] { writeWhole(path, "new"); }), "");
  ASSERT_EQ(::chmod(folder.path().c_str(), 0555), 0);
  EXPECT_NE(fileError([&] { writeWhole(folder.path() / "b", "new"); }), "");
  ASSERT_EQ(::chmod(folder.path().c_str(), 0755), 0);
  EXPECT_EQ(textOf(readFile(path)), "old");
  EXPECT_EQ(entries(folder.path()), 1u);
}

TEST(ReadFile, RefusesFoldersMissingFilesAndWhatIsTooLarge) {
  const test::ScratchFolder folder;
  EXPECT_NE(fileError([&] { readFile(folder.path()); }), "");
  EXPECT_NE(fileError([&] { readFile(folder.path() / "missing"); }).find("missing"), std::string::npos);
  writeWhole(folder.path() / "ten", "0123456789");
  EXPECT_EQ(readFile(folder.path() / "ten", 10).size(), 10u);
  EXPECT_NE(fileError([&] { readFile(folder.path() / "ten", 9); }).find("more than 9 bytes"), std::string::npos);
  if (fs::exists("/dev/zero")) {
    EXPECT_NE(fileError([] { readFile("/dev/zero", 100000); }), "") << "endless, yet it ends";
  }
}

TEST(ReadFile, ReadsAPipeToItsEnd) {
  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  const std::string text(200000, 'p');
  std::thread writer([&] {
    for (std::size_t at = 0; at < text.size();) {
      const ssize_t count = ::write(ends[1], text.data() + at, text.size() - at);
      if (count <= 0) break;
      at += static_cast<std::size_t>(count);
    }
    ::close(ends[1]);
  });
  EXPECT_EQ(textOf(readFile("/dev/fd/" + std::to_string(ends[0]))), text);
  writer.join();
  ::close(ends[0]);
}

}  // namespace
}  // namespace spheretree::formats
