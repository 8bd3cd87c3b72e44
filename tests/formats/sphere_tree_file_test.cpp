// SPDX-License-Identifier: Apache-2.0
#include "spheretree/formats/sphere_tree_file.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>

#include "spheretree/core/sphere_tree_codec.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/file_io.h"
#include "spheretree/formats/tree_json.h"
#include "support/sample_skins.h"
#include "support/scratch_folder.h"

namespace spheretree::formats {
namespace {

TEST(SphereTreeFile, ReturnsTheTreeBitForBit) {
  const test::ScratchFolder folder;
  const SphereTree plain = test::randomTree(9, 5, 6);
  for (const SphereTree& tree :
       {test::threeLevelTree(), test::treeOf({0}), plain, test::withSearch(plain), test::withSkin(plain, test::roundSkin(2))}) {
    writeSphereTree(folder.path() / "a.stree", tree);
    EXPECT_EQ(readSphereTree(folder.path() / "a.stree"), tree);
  }
}

/// Positions and normals of the nodes of each patch, as read_stree.py takes them.
std::string patchesOf(const Skin& skin) {
  nlohmann::json patches = nlohmann::json::array();
  for (std::size_t t = 0; t < skin.triangles.size(); ++t) {
    const SkinPatch patch = patchOf(skin, t);
    nlohmann::json positions = nlohmann::json::array(), normals = positions;
    for (const Eigen::Vector3f& p : patch.position) positions.push_back({p.x(), p.y(), p.z()});
    for (const Eigen::Vector3f& n : patch.normal) normals.push_back({n.x(), n.y(), n.z()});
    patches.push_back({positions, normals});
  }
  return patches.dump();
}

TEST(SphereTreeFile, IsReadByTheDocumentAlone) {
  const std::string reader = READ_STREE;
  if (reader.empty()) GTEST_SKIP() << "no Python";
  const test::ScratchFolder folder;
  const std::string base = (folder.path() / "a").string();
  const auto read = [&] {
    return std::system((reader + " " + base + ".stree " + base + ".json " + base + ".patches.json >" + base + ".log 2>&1").c_str());
  };
  std::vector<SphereTree> trees{test::withSkin(test::withSearch(test::threeLevelTree(), 2), test::roundSkin(1))};
  for (std::uint64_t seed = 1; seed <= 2; ++seed)
    trees.push_back(test::withSkin(test::withSearch(test::randomTree(seed, 4, 5)), test::randomSkin(seed)));
  for (const SphereTree& tree : trees) {
    writeSphereTree(base + ".stree", tree);
    writeWhole(base + ".json", writeTreeJson(tree));
    writeWhole(base + ".patches.json", patchesOf(tree.skin));
    ASSERT_EQ(read(), 0) << std::ifstream(base + ".log").rdbuf();
  }
  // Shows that the comparison can fail: a change of an edge by one step of its packed normal is detected.
  SphereTree other = trees.back();
  other.skin.edges[0].normal[0] ^= 1;
  writeWhole(base + ".json", writeTreeJson(other));
  EXPECT_NE(read(), 0);
  writeWhole(base + ".json", writeTreeJson(trees.back()));
  other.skin.edges[0].normal[0] ^= 4096;
  writeWhole(base + ".patches.json", patchesOf(other.skin));
  EXPECT_NE(read(), 0);
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
