// SPDX-License-Identifier: Apache-2.0
#include "spheretree/core/sphere_tree_codec.h"

#include <gtest/gtest.h>

#include <bit>
#include <cstring>
#include <functional>
#include <string_view>

#include "support/sample_trees.h"

namespace spheretree {
namespace {

using Bytes = std::vector<std::byte>;

void put(Bytes& bytes, std::size_t offset, auto value) { std::memcpy(bytes.data() + offset, &value, sizeof value); }

/// Sets the checksum right, so that a test reaches what lies behind it.
Bytes resealed(Bytes bytes) {
  put(bytes, 24, std::uint64_t{0});
  put(bytes, 24, crc64(bytes));
  return bytes;
}

LoadStatus statusOf(const Bytes& bytes) {
  SphereTree tree;
  std::string fault;
  const LoadStatus status = decodeSphereTree(bytes, tree, &fault);
  EXPECT_EQ(status == LoadStatus::Ok, fault.empty()) << fault;
  EXPECT_EQ(status == LoadStatus::Ok, tree.nodeCount() > 0) << "only Ok changes the tree";
  return status;
}

TEST(Crc64, GivesTheCatalogueValueWholeAndInPieces) {
  const std::string_view digits = "123456789";
  const auto bytes = std::as_bytes(std::span<const char>(digits.data(), digits.size()));
  EXPECT_EQ(crc64(bytes), 0x995dc9bbdf1939fau);
  EXPECT_EQ(crc64(bytes.subspan(4), crc64(bytes.first(4))), 0x995dc9bbdf1939fau);
  EXPECT_EQ(crc64({}), 0u);
}

TEST(SphereTreeCodec, ReturnsEveryTreeBitForBit) {
  std::vector<SphereTree> trees{test::threeLevelTree(), test::treeOf({0})};
  for (std::uint64_t seed = 1; seed <= 60; ++seed)
    trees.push_back(test::randomTree(seed, 1 + static_cast<int>(seed % 6), 2 + static_cast<int>(seed % 7)));
  for (const SphereTree& tree : trees) {
    const Bytes bytes = encodeSphereTree(tree);
    SphereTree again;
    std::string fault;
    ASSERT_EQ(decodeSphereTree(bytes, again, &fault), LoadStatus::Ok) << fault;
    EXPECT_EQ(again, tree);
    EXPECT_EQ(std::memcmp(again.cover.data(), tree.cover.data(), tree.cover.size() * sizeof(Sphere)), 0);
    EXPECT_EQ(encodeSphereTree(again), bytes);
    EXPECT_LE(bytes.size(), 512 + 16 * (tree.cover.size() + tree.bound.size()));
  }
}

TEST(SphereTreeCodec, ReadsBytesAtAnyAddress) {
  Bytes bytes = encodeSphereTree(test::threeLevelTree());
  bytes.insert(bytes.begin(), std::byte{0});
  SphereTree tree;
  EXPECT_EQ(decodeSphereTree(std::span<const std::byte>(bytes).subspan(1), tree), LoadStatus::Ok);
  EXPECT_EQ(tree, test::threeLevelTree());
}

TEST(SphereTreeCodec, RejectsEveryTruncation) {
  const Bytes whole = encodeSphereTree(test::threeLevelTree());
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const Bytes cut(whole.data(), whole.data() + size);  // own buffer: ASan sees an over-read
    EXPECT_NE(statusOf(cut), LoadStatus::Ok) << "first " << size << " bytes";
  }
}

TEST(SphereTreeCodec, RejectsEveryChangedByte) {
  const Bytes whole = encodeSphereTree(test::threeLevelTree());
  for (std::size_t at = 0; at < whole.size(); ++at)
    for (const unsigned flip : {0x01u, 0x10u, 0x80u, 0xffu}) {
      Bytes bytes = whole;
      bytes[at] ^= static_cast<std::byte>(flip);
      EXPECT_NE(statusOf(bytes), LoadStatus::Ok) << "byte " << at;
    }
}

TEST(SphereTreeCodec, RejectsTrailingBytes) {
  Bytes bytes = encodeSphereTree(test::threeLevelTree());
  bytes.push_back(std::byte{0});
  EXPECT_EQ(statusOf(bytes), LoadStatus::TrailingBytes);
}

TEST(SphereTreeCodec, NamesWhatIsWrongBehindARightChecksum) {
  const SphereTree tree = test::threeLevelTree();
  const Bytes whole = encodeSphereTree(tree);
  const std::size_t bound_at = whole.size() - 2 * sizeof(Sphere);
  struct Case {
    LoadStatus status;
    std::function<void(Bytes&)> damage;
  };
  const std::vector<Case> cases{
      {LoadStatus::BadMagic, [](Bytes& b) { put(b, 1, 'X'); }},
      {LoadStatus::UnsupportedVersion, [](Bytes& b) { put(b, 8, std::uint16_t{2}); }},
      {LoadStatus::UnsupportedVersion, [](Bytes& b) { put(b, 8, std::uint16_t{0}); }},
      {LoadStatus::BadHeader, [](Bytes& b) { put(b, 12, std::uint32_t{384}); }},
      {LoadStatus::BadHeader, [](Bytes& b) { put(b, 12, std::uint32_t{256}); }},
      {LoadStatus::BadHeader, [](Bytes& b) { put(b, 16, std::uint64_t{1}); }},
      {LoadStatus::BadHeader, [](Bytes& b) { put(b, 32, std::uint32_t{0}); }},
      {LoadStatus::BadHeader, [](Bytes& b) { put(b, 32, ~std::uint32_t{0}); }},
      {LoadStatus::BadHeader, [](Bytes& b) { put(b, 36, std::uint32_t{6}); }},
      {LoadStatus::BadHeader, [](Bytes& b) { put(b, 36, ~std::uint32_t{0}); }},
      {LoadStatus::BadHeader, [](Bytes& b) { put(b, 40, std::uint8_t{2}); }},            // levels
      {LoadStatus::BadTree, [](Bytes& b) { put(b, 41, std::uint8_t{0}); }},              // branching
      {LoadStatus::BadHeader, [](Bytes& b) { put(b, 43, 'x'); }},                        // reserved
      {LoadStatus::BadTree, [](Bytes& b) { put(b, 48, std::uint64_t{0x7ff8} << 48); }},  // origin: NaN
      {LoadStatus::BadHeader, [](Bytes& b) { put(b, 160 + 15, 'x'); }},                  // text without end
      {LoadStatus::BadHeader, [](Bytes& b) { put(b, 160 + 9, 'x'); }},                   // text behind its end
      {LoadStatus::BadTree, [](Bytes& b) { put(b, 160, '\n'); }},
      {LoadStatus::BadHeader, [](Bytes& b) { put(b, 224 + 3 * 16, std::uint32_t{1}); }},  // statistics of level 3
      {LoadStatus::BadTree, [](Bytes& b) { put(b, 224, std::uint32_t{2}); }},
      {LoadStatus::BadTree, [](Bytes& b) { put(b, 320 + 12, 0.0f); }},                          // radius of the root
      {LoadStatus::BadHeader, [=](Bytes& b) { put(b, bound_at - 1, 'x'); }},                    // padding
      {LoadStatus::BadTopology, [=](Bytes& b) { put(b, bound_at + 12, std::uint8_t{0x13}); }},  // 4 children
      {LoadStatus::BadTopology, [=](Bytes& b) { put(b, bound_at + 12, std::uint8_t{0x02}); }},  // none of them inner
      {LoadStatus::BadTopology, [=](Bytes& b) { put(b, bound_at + 12, std::uint8_t{0x32}); }},  // all of them inner
      {LoadStatus::BadTopology, [=](Bytes& b) { put(b, bound_at + 12, std::uint8_t{0x42}); }},  // more than there are
      {LoadStatus::BadTopology, [=](Bytes& b) { put(b, bound_at + 12, std::uint8_t{0x1f}); }},  // 16 children
      {LoadStatus::BadTree, [=](Bytes& b) { put(b, bound_at + 13, std::uint8_t{0}); }},         // does not enclose
  };
  for (std::size_t i = 0; i < cases.size(); ++i) {
    Bytes bytes = whole;
    cases[i].damage(bytes);
    EXPECT_EQ(statusOf(resealed(bytes)), cases[i].status) << "case " << i;
  }
}

TEST(SphereTreeCodec, SurvivesMutationsBehindARightChecksum) {
  test::Random random(7);
  const Bytes whole = encodeSphereTree(test::randomTree(3, 3, 4));
  int accepted = 0;
  for (int i = 0; i < 20000; ++i) {
    Bytes bytes = whole;
    for (std::uint64_t k = 0; k <= random.below(3); ++k) bytes[random.below(bytes.size())] = static_cast<std::byte>(random.next());
    bytes = resealed(bytes);
    SphereTree tree;
    if (decodeSphereTree(bytes, tree) != LoadStatus::Ok) continue;
    ++accepted;  // a mutation may be harmless, such as another seed; then the tree must be sound and store again
    ASSERT_EQ(findFault(tree), "");
    ASSERT_EQ(encodeSphereTree(tree).size(), bytes.size());
  }
  EXPECT_GT(accepted, 0);
}

TEST(SphereTreeCodec, ReadsANewerMinorVersionWithALongerHeader) {
  const SphereTree tree = test::threeLevelTree();
  Bytes bytes = encodeSphereTree(tree);
  bytes.insert(bytes.begin() + kHeaderBytes, 64, std::byte{0xaa});
  put(bytes, 10, std::uint16_t{kFormatMinor + 1});
  put(bytes, 12, std::uint32_t{kHeaderBytes + 64});
  put(bytes, 16, std::uint64_t{bytes.size()});
  SphereTree again;
  std::string fault;
  ASSERT_EQ(decodeSphereTree(resealed(bytes), again, &fault), LoadStatus::Ok) << fault;
  EXPECT_EQ(again, tree);
}

TEST(SphereTreeCodec, RefusesToStoreAnUnsoundTree) {
  SphereTree tree = test::threeLevelTree();
  tree.cover[3].radius = -1;
  EXPECT_THROW(encodeSphereTree(tree), std::invalid_argument);
}

TEST(LoadStatus, HasASentenceForEachValue) {
  for (int i = 0; i <= static_cast<int>(LoadStatus::OutOfMemory); ++i) EXPECT_GT(explain(static_cast<LoadStatus>(i)).size(), 10u);
}

}  // namespace
}  // namespace spheretree
