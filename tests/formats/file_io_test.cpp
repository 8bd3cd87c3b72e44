// SPDX-License-Identifier: Apache-2.0
#include "spheretree/formats/file_io.h"

#include <gtest/gtest.h>

#include <string>
#include <thread>
#include <vector>

#include "spheretree/formats/errors.h"
#include "spheretree/formats/path_name.h"
#include "support/scratch_folder.h"
#include "support/whole_files.h"

namespace spheretree::formats {
namespace {

namespace fs = std::filesystem;

using test::entries;
using test::fileError;
using test::textOf;

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

TEST(FileIo, SaysHowToNameTheFilesOfAFolder) {
  const test::ScratchFolder folder;
  try {
    (void)readFile(folder.path());
    ADD_FAILURE() << "a folder was read";
  } catch (const FileError& e) {
    EXPECT_NE(std::string(e.what()).find("Name files in it, such as " + toUtf8(folder.path() / "*")), std::string::npos) << e.what();
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

TEST(ReadFile, RefusesFoldersMissingFilesAndWhatIsTooLarge) {
  const test::ScratchFolder folder;
  EXPECT_NE(fileError([&] { readFile(folder.path()); }), "");
  EXPECT_NE(fileError([&] { readFile(folder.path() / "missing"); }).find("missing"), std::string::npos);
  writeWhole(folder.path() / "ten", "0123456789");
  EXPECT_EQ(readFile(folder.path() / "ten", 10).size(), 10u);
  EXPECT_NE(fileError([&] { readFile(folder.path() / "ten", 9); }).find("more than 9 bytes"), std::string::npos);
}

}  // namespace
}  // namespace spheretree::formats
