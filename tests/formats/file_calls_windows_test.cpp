// SPDX-License-Identifier: Apache-2.0
// Whole files with what Windows has: open files that nobody removes, names of any letters, read-only files, NUL.
#include "text/file_calls.h"

#include <gtest/gtest.h>

#include <cerrno>
#include <fstream>
#include <string>
#include <vector>

#include "spheretree/formats/path_name.h"
#include "support/scratch_folder.h"
#include "support/whole_files.h"
#include "text/temporary_file.h"

namespace spheretree::formats {
namespace {

namespace fs = std::filesystem;
using test::entries;
using test::fileError;
using test::makeOlder;
using test::Observing;
using test::textOf;
using test::Told;

TEST(WholeFile, RemovesWhatKilledProgramsLeftBehindAndNothingElse) {
  const test::ScratchFolder folder;
  const fs::path kept[] = {folder.path() / ".spheretree-1-0.tmp", folder.path() / ".spheretree-notes", folder.path() / "x.tmp",
                           folder.path() / ".spheretree-folder.tmp"};
  const fs::path leftover = folder.path() / ".spheretree-999999-7.tmp", held = folder.path() / ".spheretree-2-0.tmp";
  for (const fs::path& path : {kept[0], kept[1], kept[2], leftover}) std::ofstream(path) << "x";
  Descriptor holder(openNew(held));
  ASSERT_GE(holder.get(), 0);
  fs::create_directory(kept[3]);
  for (const fs::path& path : {kept[1], kept[2], leftover}) makeOlder(path, 3600);
  writeWhole(folder.path() / "a", "x");
  EXPECT_FALSE(fs::exists(leftover));
  EXPECT_TRUE(fs::exists(held)) << "another program holds it";
  for (const fs::path& path : kept) EXPECT_TRUE(fs::exists(path)) << path;
}

TEST(WholeFile, HoldsItsTemporaryFileUntilItIsDone) {
  const test::ScratchFolder folder;
  WholeFile file(folder.path() / "a");
  const fs::path temporary = fs::directory_iterator(folder.path())->path();
  constexpr std::time_t kLater = 4'000'000'000;
  EXPECT_FALSE(isAbandoned(temporary, kLater)) << "a sweep could take it away";
  file.commit();
  EXPECT_TRUE(isAbandoned(folder.path() / "a", kLater));
  EXPECT_FALSE(isAbandoned(folder.path() / "a", 1'000'000'000)) << "too young";
}

TEST(FileObserver, HearsOfUserFilesThatAreReadAndOfAllThatAreWritten) {
  const test::ScratchFolder folder;
  Told told;
  {
    const Observing observing(told);
    writeWhole(folder.path() / "a", "x");
    (void)readFile(folder.path() / "a");
    (void)readFile(folder.path() / "a", 10, FileRole::Working);
    writeWhole(folder.path() / "a", "y", FileRole::Working);
  }
  const std::vector<std::string> expected{"write a as a",         "complete a: x", "written a", "read a",
                                          "write a as a over it", "complete a: y", "written a"};
  EXPECT_EQ(told.lines, expected);
}

TEST(FileId, IsThatOfTheFileUnderAnyName) {
  const test::ScratchFolder folder;
  writeWhole(folder.path() / "name", "x");
  EXPECT_EQ(idOf(folder.path() / "name"), idOf(folder.path() / "NAME")) << "letters of either case name one file";
  EXPECT_EQ(idOf(folder.path() / "none"), std::nullopt);
  EXPECT_EQ(idOf(folder.path()), std::nullopt);
  EXPECT_EQ(idOf("NUL"), std::nullopt);
}

TEST(WriteWhole, TakesNamesOfAnyLetters) {
  const test::ScratchFolder folder;
  const std::string name = "Z\xc3\xa4hne \xe7\x89\x99.stree";  // UTF-8
  const fs::path path = folder.path() / toPath(name);
  writeWhole(path, "tooth");
  EXPECT_EQ(textOf(readFile(path)), "tooth");
  EXPECT_EQ(fs::directory_iterator(folder.path())->path().filename().wstring(), L"Z\u00e4hne \u7259.stree");
  EXPECT_NE(fileError([&] { readFile(folder.path() / "none" / toPath(name)); }).find(name), std::string::npos) << "messages are UTF-8";
}

TEST(WriteWhole, KeepsLineEndsAndZeros) {
  const test::ScratchFolder folder;
  const std::string text("a\nb\r\nc\x1a\0d", 10);
  writeWhole(folder.path() / "a", text);
  EXPECT_EQ(fs::file_size(folder.path() / "a"), 10u);
  EXPECT_EQ(textOf(readFile(folder.path() / "a")), text);
}

TEST(WriteWhole, WritesToNul) {
  EXPECT_EQ(fileError([] { writeWhole("NUL", "x"); }), "");
}

TEST(WriteWhole, RefusesReadOnlyFiles) {
  const test::ScratchFolder folder;
  const fs::path path = folder.path() / "a";
  writeWhole(path, "old");
  fs::permissions(path, fs::perms::owner_read, fs::perm_options::replace);
  EXPECT_NE(fileError([&] { writeWhole(path, "new"); }), "");
  EXPECT_EQ(textOf(readFile(path)), "old");
  EXPECT_EQ(entries(folder.path()), 1u);
  fs::permissions(path, fs::perms::owner_all, fs::perm_options::replace);
}

}  // namespace
}  // namespace spheretree::formats
