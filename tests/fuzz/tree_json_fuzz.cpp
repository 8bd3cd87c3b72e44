// SPDX-License-Identifier: Apache-2.0
// Feeds any text to the reader of trees in JSON: it is refused with a reason, or gives a sound tree that survives a
// round trip bit for bit.
#include "fuzz/fuzz_target.h"
#include "spheretree/core/sphere_tree_codec.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/tree_json.h"
#include "support/sample_skins.h"

namespace spheretree::fuzz {

std::vector<std::string> seeds() {
  std::vector<std::string> texts{
      formats::writeTreeJson(test::threeLevelTree()),
      R"({"schema":"spheretree.tree/1","branching":2,"nodes":[{"cover":[0,0,0,1],"child_count":1},{"cover":[1,0,0,2],"child_count":0}]})"};
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const SphereTree tree = test::randomTree(seed, 3, 2);
    texts.push_back(formats::writeTreeJson(tree));
    texts.push_back(formats::writeTreeJson(test::withSkin(test::withSearch(tree), test::boxSkin({1, 2, 3}))));
  }
  return texts;
}

}  // namespace spheretree::fuzz

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace spheretree;
  try {
    const SphereTree tree = formats::parseTreeJson({reinterpret_cast<const char*>(data), size}, "input");
    fuzz::require(findFault(tree).empty(), "an accepted tree is sound");
    fuzz::require(encodeSphereTree(formats::parseTreeJson(formats::writeTreeJson(tree), "again")) == encodeSphereTree(tree),
                  "a round trip returns the tree");
  } catch (const formats::FormatError&) {
  }
  return 0;
}
