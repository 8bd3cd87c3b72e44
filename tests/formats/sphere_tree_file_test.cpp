// SPDX-License-Identifier: Apache-2.0
#include "spheretree/formats/sphere_tree_file.h"

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>

#include "spheretree/core/sphere_tree_codec.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/file_io.h"
#include "support/sample_trees.h"
#include "support/scratch_folder.h"

namespace spheretree::formats {
namespace {

TEST(SphereTreeFile, ReturnsTheTreeBitForBit) {
  const test::ScratchFolder folder;
  for (const SphereTree& tree : {test::threeLevelTree(), test::treeOf({0}), test::randomTree(9, 5, 6)}) {
    writeSphereTree(folder.path() / "a.stree", tree);
    EXPECT_EQ(readSphereTree(folder.path() / "a.stree"), tree);
  }
}

TEST(SphereTreeFile, NamesFilePlaceAndRemedyOfADamagedFile) {
  const test::ScratchFolder folder;
  const auto path = folder.path() / "damaged.stree";
  std::vector<std::byte> bytes = encodeSphereTree(test::threeLevelTree());
  bytes[100] ^= std::byte{1};
  writeWhole(path, bytes);
  try {
    (void)readSphereTree(path);
    FAIL() << "a damaged file was accepted";
  } catch (const FormatError& error) {
    const std::string message = error.what();
    for (const char* part : {"damaged.stree", "offset 24", "checksum", "copy it again"})
      EXPECT_NE(message.find(part), std::string::npos) << message;
  }
  writeWhole(path, "v 0 0 0\n");
  EXPECT_THROW((void)readSphereTree(path), FormatError);
  writeWhole(path, "");
  EXPECT_THROW((void)readSphereTree(path), FormatError);
  EXPECT_THROW((void)readSphereTree(folder.path() / "missing.stree"), FileError);
}

TEST(SphereTreeFile, WritesNothingForAnUnsoundTree) {
  const test::ScratchFolder folder;
  SphereTree tree = test::threeLevelTree();
  tree.bound[0].radius = 1;
  EXPECT_THROW(writeSphereTree(folder.path() / "a.stree", tree), std::invalid_argument);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

}  // namespace
}  // namespace spheretree::formats
