// SPDX-License-Identifier: Apache-2.0
// Feeds any text to the reader of .sph: it is refused with a reason, or gives a sound tree that survives writing and
// reading.
#include "fuzz/fuzz_target.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/sph_text.h"
#include "support/sample_trees.h"

namespace spheretree::fuzz {

std::vector<std::string> seeds() {
  std::vector<std::string> texts{formats::writeSph(test::threeLevelTree(), SphereKind::Cover), "1 2\n0 0 0 1 1\n"};
  for (std::uint64_t seed = 1; seed <= 4; ++seed) texts.push_back(formats::writeSph(test::randomTree(seed, 3, 3), SphereKind::Bound));
  return texts;
}

}  // namespace spheretree::fuzz

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace spheretree;
  try {
    const SphereTree tree = formats::parseSph({reinterpret_cast<const char*>(data), size}, "input");
    fuzz::require(findFault(tree).empty(), "an accepted tree is sound");
    const SphereTree again = formats::parseSph(formats::writeSph(tree, SphereKind::Cover), "again");
    fuzz::require(again.child_count == tree.child_count, "the topology survives a round trip");
  } catch (const formats::FormatError&) {
  }
  return 0;
}
