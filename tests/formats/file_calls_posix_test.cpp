// SPDX-License-Identifier: Apache-2.0
// Whole files with what POSIX has: permissions, links, locks, pipes, devices.
#include "text/file_calls.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <pthread.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "support/scratch_folder.h"
#include "support/whole_files.h"

namespace spheretree::formats {
namespace {

namespace fs = std::filesystem;
using test::entries;
using test::fileError;
using test::makeOlder;
using test::Observing;
using test::textOf;
using test::Told;

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

TEST(ReadFile, RefusesADeviceWithoutEnd) {
  if (!fs::exists("/dev/zero")) GTEST_SKIP() << "no /dev/zero";
  EXPECT_NE(fileError([] { readFile("/dev/zero", 100000); }), "");
}

}  // namespace
}  // namespace spheretree::formats
