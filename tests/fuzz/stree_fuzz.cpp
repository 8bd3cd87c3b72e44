// SPDX-License-Identifier: Apache-2.0
// Any bytes into the decoder of .stree files: refused, or a sound tree that is stored as the same bytes again.
#include <cstring>

#include "fuzz/fuzz_target.h"
#include "spheretree/core/sphere_tree_codec.h"
#include "support/sample_trees.h"

namespace spheretree::fuzz {
namespace {

void feed(const std::vector<std::byte>& bytes) {
  SphereTree tree;
  std::string fault;
  if (decodeSphereTree(bytes, tree, &fault) != LoadStatus::Ok) {
    require(!fault.empty() && tree.nodeCount() == 0, "a refusal has a reason and leaves the tree alone");
    return;
  }
  require(findFault(tree).empty(), "an accepted tree is sound");
  std::uint16_t minor = 0;
  std::memcpy(&minor, bytes.data() + 10, sizeof minor);
  if (minor == kFormatMinor) require(encodeSphereTree(tree) == bytes, "one tree, one file");
}

std::string asText(const std::vector<std::byte>& bytes) { return {reinterpret_cast<const char*>(bytes.data()), bytes.size()}; }

}  // namespace

std::vector<std::string> seeds() {
  std::vector<std::string> texts{asText(encodeSphereTree(test::threeLevelTree())), asText(encodeSphereTree(test::treeOf({0})))};
  for (std::uint64_t seed = 1; seed <= 6; ++seed) texts.push_back(asText(encodeSphereTree(test::randomTree(seed, 4, 3))));
  return texts;
}

}  // namespace spheretree::fuzz

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto* first = reinterpret_cast<const std::byte*>(data);
  std::vector<std::byte> bytes(first, first + size);
  spheretree::fuzz::feed(bytes);
  if (bytes.size() < spheretree::kHeaderBytes) return 0;
  // Sealed anew, since no mutation would ever get past the checksum.
  std::memset(bytes.data() + 24, 0, 8);
  const std::uint64_t crc = spheretree::crc64(bytes);
  std::memcpy(bytes.data() + 24, &crc, sizeof crc);
  spheretree::fuzz::feed(bytes);
  return 0;
}
