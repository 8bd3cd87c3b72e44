// SPDX-License-Identifier: Apache-2.0
#include "spheretree/core/tissue_codec.h"

#include <gtest/gtest.h>

#include <string>

#include "support/random.h"
#include "support/sample_tissue.h"
#include "support/sample_trees.h"
#include "support/stree_bytes.h"

namespace spheretree {
namespace {

using test::Bytes;

Tissue sample() { return test::twoTetrahedra(test::softTree()); }

LoadStatus softStatusOf(const Bytes& bytes, std::string* found = nullptr) {
  SphereTree tree;
  Tissue tissue;
  std::string fault;
  const LoadStatus status = decodeSoftTree(bytes, tree, tissue, &fault);
  EXPECT_EQ(status == LoadStatus::Ok, fault.empty()) << fault;
  EXPECT_TRUE(status == LoadStatus::Ok || (tissue.empty() && tree.nodeCount() == 0)) << "only Ok changes anything";
  if (found != nullptr) *found = fault;
  return status;
}

TEST(TissueCodec, ReturnsTreeAndTissueBitForBit) {
  const SphereTree tree = test::softTree();
  const Tissue tissue = sample();
  const Bytes bytes = encodeSoftTree(tree, tissue);
  SphereTree tree_again;
  Tissue tissue_again;
  ASSERT_EQ(decodeSoftTree(bytes, tree_again, tissue_again), LoadStatus::Ok);
  EXPECT_EQ(tree_again, tree);
  EXPECT_EQ(tissue_again, tissue);
  EXPECT_EQ(encodeSoftTree(tree_again, tissue_again), bytes);
}

TEST(TissueCodec, AReaderOfTreesGetsTheTreeAtRest) {
  SphereTree tree;
  ASSERT_EQ(decodeSphereTree(encodeSoftTree(test::softTree(), sample()), tree), LoadStatus::Ok);
  EXPECT_EQ(tree, test::softTree());
}

TEST(TissueCodec, ATreeWithoutTissueHasNone) {
  SphereTree tree;
  Tissue tissue = sample();
  ASSERT_EQ(decodeSoftTree(encodeSphereTree(test::softTree()), tree, tissue), LoadStatus::Ok);
  EXPECT_TRUE(tissue.empty());
}

TEST(TissueCodec, RejectsEveryTruncation) {
  const Bytes whole = encodeSoftTree(test::softTree(), sample());
  for (std::size_t size = 0; size < whole.size(); ++size)
    EXPECT_NE(softStatusOf(Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size))), LoadStatus::Ok)
        << "first " << size << " bytes";
}

TEST(TissueCodec, EveryChangedByteOfTheTissueIsRefusedOrGivesSoundTissue) {  // with a correct checksum
  std::vector<test::FileSection> sections = test::takeApart(encodeSoftTree(test::softTree(), sample()));
  test::Random random(1);
  for (const char* name : {"TISS", "TLEA"}) {
    Bytes& bytes = test::sectionOf(sections, name);
    std::size_t refused = 0;
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      const std::byte before = bytes[i];
      bytes[i] ^= static_cast<std::byte>(1 + random.below(255));
      SphereTree tree;
      Tissue tissue;
      if (decodeSoftTree(test::putTogether(sections), tree, tissue) == LoadStatus::Ok)
        EXPECT_EQ(findFault(tissue, tree), "") << name << " byte " << i;
      else
        ++refused;
      bytes[i] = before;
    }
    EXPECT_GT(refused, bytes.size() / 5) << name;
  }
}

TEST(TissueCodec, RefusesWrongSizesAndFlags) {
  const Bytes whole = encodeSoftTree(test::softTree(), sample());
  std::vector<test::FileSection> sections = test::takeApart(whole);
  test::sectionOf(sections, "TISS").push_back(std::byte{0});
  std::string fault;
  EXPECT_EQ(softStatusOf(test::putTogether(sections), &fault), LoadStatus::BadSection);
  EXPECT_NE(fault.find("TISS"), std::string::npos) << fault;
  test::sectionOf(sections, "TISS").resize(3);
  EXPECT_EQ(softStatusOf(test::putTogether(sections)), LoadStatus::BadSection);
  sections = test::takeApart(whole);
  sections.back().flags = 0;
  EXPECT_NE(softStatusOf(test::putTogether(sections)), LoadStatus::Ok);
  sections.pop_back();
  EXPECT_EQ(softStatusOf(test::putTogether(sections), &fault), LoadStatus::BadHeader);
  EXPECT_NE(fault.find("TRES"), std::string::npos) << fault;
  sections = test::takeApart(whole);
  test::sectionOf(sections, "TRES").pop_back();
  EXPECT_EQ(softStatusOf(test::putTogether(sections), &fault), LoadStatus::BadSection);
  EXPECT_NE(fault.find("TRES"), std::string::npos) << fault;
}

TEST(TissueCodec, UnsoundTissueIsNotWritten) {
  Tissue tissue = sample();
  tissue.fixed = {7};
  EXPECT_THROW(encodeSoftTree(test::softTree(), tissue), std::invalid_argument);
}

}  // namespace
}  // namespace spheretree
