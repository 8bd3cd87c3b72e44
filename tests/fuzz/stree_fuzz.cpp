// SPDX-License-Identifier: Apache-2.0
// Feeds any bytes to the decoders of .stree and .soft files: they are refused, or give a sound tree, and sound tissue,
// that are stored as the same bytes.
#include "fuzz/fuzz_target.h"
#include "spheretree/core/tissue_codec.h"
#include "support/sample_skins.h"
#include "support/sample_tissue.h"
#include "support/stree_bytes.h"

namespace spheretree::fuzz {
namespace {

void feed(test::Bytes bytes) {
  SphereTree tree;
  std::string fault;
  if (decodeSphereTree(bytes, tree, &fault) != LoadStatus::Ok) {
    require(!fault.empty() && tree.nodeCount() == 0, "a refusal has a reason and leaves the tree alone");
    return;
  }
  require(findFault(tree).empty(), "an accepted tree is sound");
  const test::Bytes again = encodeSphereTree(tree);
  if (test::takeApart(again).size() != test::takeApart(bytes).size()) return;  // an unknown optional section was skipped
  test::put(bytes, 10, kFormatMinor);
  require(again == test::resealed(bytes), "one tree, one file");
}

void feedSoft(test::Bytes bytes) {
  SphereTree tree;
  Tissue tissue;
  std::string fault;
  if (decodeSoftTree(bytes, tree, tissue, &fault) != LoadStatus::Ok) {
    require(!fault.empty() && tree.nodeCount() == 0 && tissue.empty(), "a refusal has a reason and leaves tree and tissue alone");
    return;
  }
  if (tissue.empty()) return;
  require(findFault(tree).empty() && findFault(tissue, tree).empty(), "accepted tissue is sound");
  const test::Bytes again = encodeSoftTree(tree, tissue);
  if (test::takeApart(again).size() != test::takeApart(bytes).size()) return;  // an unknown optional section was skipped
  test::put(bytes, 10, kFormatMinor);
  require(again == test::resealed(bytes), "one tissue, one file");
}

std::string asText(const test::Bytes& bytes) { return {reinterpret_cast<const char*>(bytes.data()), bytes.size()}; }

}  // namespace

std::vector<std::string> seeds() {
  std::vector<SphereTree> trees{test::threeLevelTree(), test::treeOf({0})};
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const SphereTree tree = test::randomTree(seed, 4, 3);
    trees.push_back(tree);
    trees.push_back(test::withSearch(tree, 2 + seed));
    trees.push_back(test::withSkin(test::withSearch(tree), test::randomSkin(seed)));
  }
  trees.push_back(test::withSkin(test::treeOf({0}), test::gridSkin(1)));
  std::vector<std::string> texts;
  for (const SphereTree& tree : trees) texts.push_back(asText(encodeSphereTree(tree)));
  std::vector<test::FileSection> more = test::takeApart(encodeSphereTree(trees[0]));
  more.push_back({"TISS", 1, test::Bytes(100)});
  const SphereTree soft = test::softTree();
  texts.push_back(asText(encodeSoftTree(soft, test::twoTetrahedra(soft))));
  texts.push_back(asText(test::putTogether(more)));
  return texts;
}

}  // namespace spheretree::fuzz

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace spheretree;
  const auto* first = reinterpret_cast<const std::byte*>(data);
  test::Bytes bytes(first, first + size);
  fuzz::feed(bytes);
  fuzz::feedSoft(bytes);
  if (bytes.size() < 32) return 0;
  // With a new checksum, since otherwise no mutation would pass the size and the checksum.
  test::put(bytes, 16, std::uint64_t{size});
  fuzz::feed(test::resealed(bytes));
  fuzz::feedSoft(test::resealed(bytes));
  return 0;
}
