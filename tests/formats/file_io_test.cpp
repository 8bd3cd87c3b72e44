// SPDX-License-Identifier: Apache-2.0
#include "spheretree/formats/file_io.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdio>
#include <string>
#include <thread>

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
  makeFolder(folder.path() / "a");  // there already
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
