// SPDX-License-Identifier: Apache-2.0
#include "spheretree/core/sphere_tree_codec.h"

#include <gtest/gtest.h>

#include <cstring>
#include <functional>
#include <string>
#include <string_view>

#include "spheretree/core/crc64.h"
#include "support/sample_skins.h"
#include "support/stree_bytes.h"

namespace spheretree {
namespace {

using test::Bytes;
using test::FileSection;
using test::put;
using test::resealed;

LoadStatus statusOf(const Bytes& bytes, std::string* found = nullptr) {
  SphereTree tree;
  std::string fault;
  const LoadStatus status = decodeSphereTree(bytes, tree, &fault);
  EXPECT_EQ(status == LoadStatus::Ok, fault.empty()) << fault;
  EXPECT_EQ(status == LoadStatus::Ok, tree.nodeCount() > 0) << "only Ok changes the tree";
  if (found != nullptr) *found = fault;
  return status;
}

/// Six nodes with all optional sections.
SphereTree fullTree() { return test::withSkin(test::withSearch(test::threeLevelTree(), 2), test::boxSkin({1, 2, 3})); }

std::vector<SphereTree> sampleTrees() {
  std::vector<SphereTree> trees{test::threeLevelTree(), test::treeOf({0}), fullTree()};
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    const SphereTree tree = test::randomTree(seed, 1 + static_cast<int>(seed % 6), 2 + static_cast<int>(seed % 7));
    trees.push_back(tree);
    trees.push_back(test::withSearch(tree, 2 + seed % 7));
    trees.push_back(test::withSkin(tree, test::randomSkin(seed)));
    trees.push_back(test::withSkin(test::withSearch(tree), test::randomSkin(seed + 1000)));
  }
  return trees;
}

TEST(SphereTreeCodec, ReturnsEveryTreeBitForBit) {
  for (const SphereTree& tree : sampleTrees()) {
    const Bytes bytes = encodeSphereTree(tree);
    SphereTree again;
    std::string fault;
    ASSERT_EQ(decodeSphereTree(bytes, again, &fault), LoadStatus::Ok) << fault;
    EXPECT_EQ(again, tree);
    EXPECT_EQ(std::memcmp(again.cover.data(), tree.cover.data(), tree.cover.size() * sizeof(Sphere)), 0);
    EXPECT_EQ(encodeSphereTree(again), bytes);
  }
}

TEST(SphereTreeCodec, KeepsToTheSizesThatArePromised) {
  for (const SphereTree& tree : sampleTrees()) {
    if (tree.search.empty() && tree.skin.empty()) {
      EXPECT_LE(encodeSphereTree(tree).size(), 1024 + 40 * tree.nodeCount());
    }
  }

  std::vector<std::uint8_t> counts(73, 8);
  counts.resize(73 + 512, 0);
  const SphereTree molar = test::withSkin(test::withSearch(test::treeOf(counts)), test::gridSkin(45));
  ASSERT_EQ(molar.skin.triangles.size(), 4050u);
  ASSERT_EQ(molar.skin.vertices.size(), 2116u);
  ASSERT_EQ(molar.skin.edges.size(), 6165u);
  EXPECT_LE(encodeSphereTree(molar).size(), 160'000u);
}

TEST(SphereTreeCodec, ReadsBytesAtAnyAddress) {
  for (std::size_t shift = 1; shift < 8; ++shift) {
    Bytes bytes = encodeSphereTree(fullTree());
    bytes.insert(bytes.begin(), shift, std::byte{0});
    SphereTree tree;
    EXPECT_EQ(decodeSphereTree(std::span<const std::byte>(bytes).subspan(shift), tree), LoadStatus::Ok);
    EXPECT_EQ(tree, fullTree());
  }
}

TEST(SphereTreeCodec, RejectsEveryTruncation) {
  const Bytes whole = encodeSphereTree(fullTree());
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const Bytes cut(whole.data(), whole.data() + size);  // own buffer: ASan sees an over-read
    EXPECT_NE(statusOf(cut), LoadStatus::Ok) << "first " << size << " bytes";
  }
}

TEST(SphereTreeCodec, RejectsEveryTruncationWithACorrectChecksum) {
  const Bytes whole = encodeSphereTree(fullTree());
  for (std::size_t size = 32; size < whole.size(); ++size) {
    Bytes cut(whole.data(), whole.data() + size);
    put(cut, 16, std::uint64_t{size});
    EXPECT_NE(statusOf(resealed(cut)), LoadStatus::Ok) << "first " << size << " bytes";
  }
}

TEST(SphereTreeCodec, RejectsEveryFlippedBit) {
  const Bytes whole = encodeSphereTree(fullTree());
  Bytes bytes = whole;
  for (std::size_t bit = 0; bit < 8 * whole.size(); ++bit) {
    bytes[bit / 8] ^= static_cast<std::byte>(1u << bit % 8);
    EXPECT_NE(statusOf(bytes), LoadStatus::Ok) << "byte " << bit / 8;
    bytes[bit / 8] = whole[bit / 8];
  }
}

TEST(SphereTreeCodec, RejectsTrailingBytes) {
  Bytes bytes = encodeSphereTree(fullTree());
  bytes.push_back(std::byte{0});
  EXPECT_EQ(statusOf(bytes), LoadStatus::TrailingBytes);
  put(bytes, 16, std::uint64_t{bytes.size()});
  EXPECT_EQ(statusOf(resealed(bytes)), LoadStatus::BadHeader);
}

/// A root with two leaves, with a search tree and a skin of one triangle: 905 bytes, written by hand from
/// docs/file_format.md, with the checksum by another program. All other bytes are zero.
Bytes goldenFile() {
  struct Run {
    std::size_t at;
    std::string_view hex;
  };
  const std::vector<Run> runs{
      {0, "89 53 54 52 45 45 0D 0A 01 00 00 00 07 00 00 00 89 03 00 00 00 00 00 00 89 E6 EC CF 6F 28 C4 51"},
      {32, "54 4F 50 4F 00 00 00 00 00 01 00 00 00 00 00 00 01 00 00 00 00 00 00 00"},
      {56, "43 4F 56 52 00 00 00 00 40 01 00 00 00 00 00 00 30 00 00 00 00 00 00 00"},
      {80, "42 4E 44 53 00 00 00 00 80 01 00 00 00 00 00 00 10 00 00 00 00 00 00 00"},
      {104, "4C 45 56 4C 00 00 00 00 C0 01 00 00 00 00 00 00 20 00 00 00 00 00 00 00"},
      {128, "50 52 4F 56 00 00 00 00 00 02 00 00 00 00 00 00 B8 00 00 00 00 00 00 00"},
      {152, "53 52 43 48 01 00 00 00 C0 02 00 00 00 00 00 00 25 00 00 00 00 00 00 00"},
      {176, "53 4B 49 4E 01 00 00 00 00 03 00 00 00 00 00 00 89 00 00 00 00 00 00 00"},
      {256, "01"},
      {320, "00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 40"},
      {336, "00 00 80 3F 00 00 00 00 00 00 00 00 00 00 80 3F"},
      {352, "00 00 80 BF 00 00 00 00 00 00 00 00 00 00 80 3F"},
      {384, "00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 40"},
      {448, "01 00 00 00 00 00 80 BF 00 00 00 40 00 00 00 40"},
      {464, "02 00 00 00 00 00 00 3F 00 00 80 3F 00 00 80 3F"},
      {536, "00 00 00 00 00 00 F0 3F"},
      {584, "07 00 00 00 00 00 00 00"},
      {624, "63 6F 76 65 72"},
      {692, "02"},
      {704, "01 00 00 00 02 00 00 00"},
      {720, "00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 40"},
      {736, "01 00 00 00"},
      {740, "01"},
      {780, "00 00 00 3F 00 00 80 3E 00 00 40 3F 00 00 80 3D 00 00 00 3F"},
      {800, "01 00 00 00 01 00 00 00 03 00 00 00 03 00 00 00"},
      {816, "00 00 00 3F 00 00 00 3F 00 00 00 00 00 00 80 3F"},
      {832, "00 00 01 00 02 00 02 00 01 00 00 00"},
      {844, "00 00 00 00 00 00 00 00 00 00 00 00"},
      {856, "02 00 00 00 00 00 00 00 FF 7F 00 00"},
      {868, "00 00 40 00 00 00 00 00 00 00 01 80"},
      {880, "00 00 01 00 00 00 00 00"},
      {888, "00 00 00 01 FF 7F FF 7F"},
      {896, "FF 01 FF 00 00 40 00 C0"},
      {904, "00"},
  };
  Bytes bytes(905);
  for (const Run& run : runs)
    for (std::size_t i = 0; 3 * i < run.hex.size(); ++i)
      bytes[run.at + i] = static_cast<std::byte>(std::stoi(std::string(run.hex.substr(3 * i, 2)), nullptr, 16));
  return bytes;
}

SphereTree goldenTree() {
  SphereTree tree;
  tree.branching = 2;
  tree.cover = {{0, 0, 0, 2}, {1, 0, 0, 1}, {-1, 0, 0, 1}};
  tree.bound = {{0, 0, 0, 2}};
  tree.child_count = {2, 0, 0};
  EXPECT_TRUE(linkNodes(tree));
  countLevels(tree);
  tree.statistics[1].overhang_bound = 0.5f;
  tree.provenance.builder = "cover";
  tree.provenance.seed = 7;
  tree.search = {.inner = {{0, 0, 0, 2}}, .inner_children = {0}, .item_children = {2}, .item = {1, 0}};
  tree.skin = {.low = {0, 0, 0},
               .step = 0.5f,
               .offset_step = 0.25f,
               .tolerance = 0.75f,
               .mesh_distance = 0.0625f,
               .crease_angle = 0.5f,
               .vertices = {{{0, 0, 0}, {0, 0}}, {{2, 0, 0}, {32767, 0}}, {{0, 2, 0}, {0, -32767}}},
               .edges = {{{0, 0, 1}, 0, {0, 0}}, {{0, 0, 0}, 1, {32767, 32767}}, {{-1, 1, -1}, 0, {16384, -16384}}},
               .triangles = {{{0, 1, 2}, {2, 1, 0}}},
               .search = {.inner = {{0.5f, 0.5f, 0, 1}}, .inner_children = {0}, .item_children = {1}, .item = {}}};
  return tree;
}

TEST(SphereTreeCodec, WritesAndReadsTheBytesOfTheDocument) {
  EXPECT_EQ(encodeSphereTree(goldenTree()), goldenFile());
  SphereTree tree;
  std::string fault;
  EXPECT_EQ(decodeSphereTree(goldenFile(), tree, &fault), LoadStatus::Ok) << fault;
  EXPECT_EQ(tree, goldenTree());
}

TEST(SphereTreeCodec, NamesWhatIsWrongInTheHeaderAndTheTable) {
  struct Case {
    LoadStatus status;
    const char* words;
    std::function<void(Bytes&)> damage;
  };
  const std::vector<Case> cases{
      {LoadStatus::BadMagic, "offset 0", [](Bytes& b) { put(b, 1, 'X'); }},
      {LoadStatus::UnsupportedVersion, "version 2.0", [](Bytes& b) { put(b, 8, std::uint16_t{2}); }},
      {LoadStatus::UnsupportedVersion, "version 0.0", [](Bytes& b) { put(b, 8, std::uint16_t{0}); }},
      {LoadStatus::BadHeader, "'TOPO' is missing", [](Bytes& b) { b = test::putTogether({}); }},
      {LoadStatus::BadHeader, "more than 64 sections", [](Bytes& b) { put(b, 12, std::uint32_t{65}); }},
      {LoadStatus::BadHeader, "more than 64 sections", [](Bytes& b) { put(b, 12, ~std::uint32_t{0}); }},
      {LoadStatus::BadHeader, "at offset 1 does not stand", [](Bytes& b) { put(b, 12, std::uint32_t{8}), put(b, 208, char{1}); }},
      {LoadStatus::Truncated, "905 bytes of 906", [](Bytes& b) { put(b, 16, std::uint64_t{906}); }},
      {LoadStatus::TrailingBytes, "1 bytes behind", [](Bytes& b) { put(b, 16, std::uint64_t{904}); }},
      {LoadStatus::UnknownSection, "'COVS' at offset 320 is required", [](Bytes& b) { put(b, 59, 'S'); }},
      {LoadStatus::BadHeader, "'TOPO' at offset 320 repeats", [](Bytes& b) { std::memcpy(b.data() + 56, "TOPO", 4); }},
      {LoadStatus::BadHeader, "'COVR' at offset 320 has unknown flags", [](Bytes& b) { put(b, 60, std::uint32_t{2}); }},
      {LoadStatus::BadHeader, "'COVR' at offset 320 has a wrong flag", [](Bytes& b) { put(b, 60, std::uint32_t{1}); }},
      {LoadStatus::BadHeader, "'SRCH' at offset 704 has a wrong flag", [](Bytes& b) { put(b, 156, std::uint32_t{0}); }},
      {LoadStatus::BadHeader, "'COVR' at offset 256 does not stand", [](Bytes& b) { put(b, 64, std::uint64_t{256}); }},
      {LoadStatus::BadHeader, "'COVR' at offset 384 does not stand", [](Bytes& b) { put(b, 64, std::uint64_t{384}); }},
      {LoadStatus::BadHeader, "'COVR' at offset 321 does not stand", [](Bytes& b) { put(b, 64, std::uint64_t{321}); }},
      {LoadStatus::BadHeader, "'SKIN' at offset 768 ends behind the file", [](Bytes& b) { put(b, 192, std::uint64_t{138}); }},
      {LoadStatus::BadHeader, "'SKIN' at offset 768 ends behind the file", [](Bytes& b) { put(b, 192, ~std::uint64_t{0}); }},
      {LoadStatus::BadHeader, "belong to no section", [](Bytes& b) { put(b, 192, std::uint64_t{136}); }},
      {LoadStatus::BadHeader, "offset 257: padding", [](Bytes& b) { put(b, 300, 'x'); }},
      {LoadStatus::BadHeader, "offset 200: padding", [](Bytes& b) { put(b, 255, 'x'); }},
  };
  for (const Case& c : cases) {
    Bytes bytes = goldenFile();
    c.damage(bytes);
    std::string fault;
    EXPECT_EQ(statusOf(resealed(bytes), &fault), c.status) << c.words << "\nfound: " << fault;
    EXPECT_NE(fault.find(c.words), std::string::npos) << c.words << "\nfound: " << fault;
  }
}

TEST(SphereTreeCodec, NamesWhatIsWrongInASection) {
  constexpr std::uint64_t kNan = std::uint64_t{0x7ff8} << 48;
  struct Case {
    LoadStatus status;
    const char *id, *words;
    std::function<void(Bytes&)> damage;
  };
  const auto longer = [](Bytes& b) { b.push_back(std::byte{0}); };
  const auto empty = [](Bytes& b) { b.clear(); };
  const std::vector<Case> cases{
      {LoadStatus::BadTopology, "TOPO", "children of inner node 0 is out of range", [](Bytes& b) { put(b, 0, std::uint8_t{0x08}); }},
      {LoadStatus::BadTopology, "TOPO", "children of inner node 0 is out of range", [](Bytes& b) { put(b, 0, std::uint8_t{0x31}); }},
      {LoadStatus::BadTopology, "TOPO", "fewer inner nodes", [](Bytes& b) { put(b, 0, std::uint8_t{0x11}); }},
      {LoadStatus::BadTopology, "TOPO", "more inner nodes than the children", longer},
      {LoadStatus::BadTopology, "TOPO", "more inner nodes than a tree", [](Bytes& b) { b.resize(kMaxNodes); }},
      {LoadStatus::BadTopology, "TOPO", "more nodes than a tree", [](Bytes& b) { b.assign(10000, std::byte{0x87}); }},
      {LoadStatus::BadSection, "TOPO", "'COVR' at offset 320 has 48 bytes, not 64", [](Bytes& b) { put(b, 0, std::uint8_t{0x02}); }},
      {LoadStatus::BadSection, "COVR", "49 bytes, not 48", longer},
      {LoadStatus::BadTree, "COVR", "node 0: radius 0", [](Bytes& b) { put(b, 12, 0.0f); }},
      {LoadStatus::BadSection, "BNDS", "0 bytes, not 16", empty},
      {LoadStatus::BadTree, "BNDS", "does not enclose", [](Bytes& b) { put(b, 12, 1.9f); }},
      {LoadStatus::BadSection, "LEVL", "33 bytes, not 32", longer},
      {LoadStatus::BadTree, "LEVL", "statistics of level 1", [](Bytes& b) { put(b, 16, std::uint32_t{3}); }},
      {LoadStatus::BadSection, "PROV", "185 bytes, not 184", longer},
      {LoadStatus::BadTree, "PROV", "origin", [](Bytes& b) { put(b, 8, kNan); }},
      {LoadStatus::BadSection, "PROV", "builder's name is not closed", [](Bytes& b) { put(b, 127, 'x'); }},
      {LoadStatus::BadSection, "PROV", "quality's name is not closed", [](Bytes& b) { put(b, 129, 'x'); }},
      {LoadStatus::BadSection, "PROV", "generator's name is not closed", [](Bytes& b) { put(b, 175, 'x'); }},
      {LoadStatus::BadTree, "PROV", "outside printable ASCII", [](Bytes& b) { put(b, 112, '\n'); }},
      {LoadStatus::BadTree, "PROV", "branching 9", [](Bytes& b) { put(b, 180, std::uint8_t{9}); }},
      {LoadStatus::BadSection, "PROV", "reserved bytes", [](Bytes& b) { put(b, 183, 'x'); }},
      {LoadStatus::BadSection, "SRCH", "0 bytes, not 16", empty},
      {LoadStatus::BadSection, "SRCH", "38 bytes, not 37", longer},
      {LoadStatus::BadSection, "SRCH", "37 bytes, not 73014444035", [](Bytes& b) { put(b, 0, ~std::uint32_t{0}); }},
      {LoadStatus::BadSection, "SRCH", "no root", [](Bytes& b) { b.assign(16, std::byte{0}); }},
      {LoadStatus::BadSection, "SRCH", "reserved bytes", [](Bytes& b) { put(b, 15, 'x'); }},
      {LoadStatus::BadTopology, "SRCH", "children of inner node 0 is out of range",
       [](Bytes& b) { put(b, 36, std::uint8_t{0x21 + 0x10}); }},
      {LoadStatus::BadTree, "SRCH", "do not make one tree", [](Bytes& b) { put(b, 36, std::uint8_t{0x11}); }},
      {LoadStatus::BadTree, "SRCH", "taken twice", [](Bytes& b) { put(b, 34, std::uint16_t{1}); }},
      {LoadStatus::BadTree, "SRCH", "sphere 0 of the search tree does not enclose", [](Bytes& b) { put(b, 16, 0.1f); }},
      {LoadStatus::BadSection, "SKIN", "0 bytes, not 48", empty},
      {LoadStatus::BadSection, "SKIN", "138 bytes, not 137", longer},
      {LoadStatus::BadSection, "SKIN", "137 bytes, not", [](Bytes& b) { put(b, 32, ~std::uint32_t{0}); }},
      {LoadStatus::BadSection, "SKIN", "no triangles", [](Bytes& b) { put(b, 36, std::uint32_t{0}), b.resize(b.size() - 12); }},
      {LoadStatus::BadTopology, "SKIN", "children of inner node 0 is out of range", [](Bytes& b) { put(b, 136, std::uint8_t{0xff}); }},
      {LoadStatus::BadTree, "SKIN", "crease angle", [](Bytes& b) { put(b, 28, 4.0f); }},
      {LoadStatus::BadTree, "SKIN", "vertex 0 of the skin: its position", [](Bytes& b) { put(b, 83, std::uint8_t{0x80}); }},
      {LoadStatus::BadTree, "SKIN", "triangle 0 of the skin", [](Bytes& b) { put(b, 64, std::uint16_t{3}); }},
      {LoadStatus::BadTree, "SKIN", "sphere 0 of the search tree does not enclose", [](Bytes& b) { put(b, 60, 0.7f); }},
  };
  for (const Case& c : cases) {
    std::vector<FileSection> sections = test::takeApart(goldenFile());
    c.damage(test::sectionOf(sections, c.id));
    std::string fault;
    EXPECT_EQ(statusOf(test::putTogether(sections), &fault), c.status) << c.words << "\nfound: " << fault;
    EXPECT_NE(fault.find(c.words), std::string::npos) << c.words << "\nfound: " << fault;
  }
}

TEST(SphereTreeCodec, RefusesSectionsThatAreMissingOrOutOfOrder) {
  const std::vector<FileSection> sections = test::takeApart(goldenFile());
  ASSERT_EQ(test::putTogether(sections), goldenFile());
  for (std::size_t i = 0; i < sections.size(); ++i) {
    std::vector<FileSection> fewer = sections;
    fewer.erase(fewer.begin() + static_cast<std::ptrdiff_t>(i));
    EXPECT_EQ(statusOf(test::putTogether(fewer)), i < 5 ? LoadStatus::BadHeader : LoadStatus::Ok) << sections[i].id;
    if (i + 1 == sections.size()) continue;
    std::vector<FileSection> swapped = sections;
    std::swap(swapped[i], swapped[i + 1]);
    EXPECT_EQ(statusOf(test::putTogether(swapped)), LoadStatus::BadHeader) << sections[i].id;
  }
}

TEST(SphereTreeCodec, SkipsUnknownOptionalSectionsAndRefusesRequiredOnes) {
  const std::vector<FileSection> sections = test::takeApart(goldenFile());
  for (std::size_t at = 0; at <= sections.size(); ++at)
    for (const std::size_t size : {0, 1, 64, 1000}) {
      std::vector<FileSection> more = sections;
      more.insert(more.begin() + static_cast<std::ptrdiff_t>(at), {"TISS", 1, Bytes(size, std::byte{0xaa})});
      Bytes bytes = test::putTogether(more);
      put(bytes, 10, std::uint16_t{kFormatMinor + 1});
      bytes = resealed(bytes);
      SphereTree tree;
      std::string fault;
      ASSERT_EQ(decodeSphereTree(bytes, tree, &fault), LoadStatus::Ok) << fault;
      EXPECT_EQ(tree, goldenTree());
      more[at].flags = 0;
      EXPECT_EQ(statusOf(test::putTogether(more)), LoadStatus::UnknownSection);
      more[at].flags = 1;
      more.insert(more.begin() + static_cast<std::ptrdiff_t>(at), more[at]);
      EXPECT_EQ(statusOf(test::putTogether(more)), LoadStatus::BadHeader) << "twice";
    }
}

TEST(SphereTreeCodec, SurvivesMutationsBehindARightChecksum) {
  test::Random random(7);
  const std::vector<Bytes> files{goldenFile(), encodeSphereTree(fullTree()), encodeSphereTree(test::randomTree(3, 3, 4))};
  int accepted = 0;
  for (int i = 0; i < 60000; ++i) {
    Bytes bytes = files[random.below(files.size())];
    for (std::uint64_t k = 0; k <= random.below(3); ++k) bytes[random.below(bytes.size())] = static_cast<std::byte>(random.next());
    bytes = resealed(bytes);
    SphereTree tree;
    if (decodeSphereTree(bytes, tree) != LoadStatus::Ok) continue;
    ++accepted;  // a mutation may be harmless, such as another seed; then the tree must be sound and store again
    ASSERT_EQ(findFault(tree), "");
    put(bytes, 10, kFormatMinor);
    const Bytes again = encodeSphereTree(tree);
    if (test::takeApart(bytes).size() != test::takeApart(again).size()) continue;  // an optional section has become an unknown one
    ASSERT_EQ(again, resealed(bytes)) << "one tree, one file";
  }
  EXPECT_GT(accepted, 100);
}

TEST(SphereTreeCodec, RefusesToStoreAnUnsoundTree) {
  for (const auto& damage : std::vector<std::function<void(SphereTree&)>>{
           [](SphereTree& t) { t.cover[3].radius = -1; }, [](SphereTree& t) { t.search.item[0] = 9; },
           [](SphereTree& t) { t.skin.step = 0; }, [](SphereTree& t) { t.skin.triangles.clear(); }}) {
    SphereTree tree = fullTree();
    damage(tree);
    EXPECT_THROW(encodeSphereTree(tree), std::invalid_argument);
  }
}

TEST(LoadStatus, HasASentenceForEachValue) {
  for (int i = 0; i <= static_cast<int>(LoadStatus::OutOfMemory); ++i) {
    EXPECT_GT(explain(static_cast<LoadStatus>(i)).size(), 10u);
    EXPECT_NE(explain(static_cast<LoadStatus>(i)), "unknown status");
  }
}

}  // namespace
}  // namespace spheretree
