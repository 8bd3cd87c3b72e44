// SPDX-License-Identifier: Apache-2.0
// How long 33 .stree files take to check and decode: each with 512 leaves, a skin of about 4,000 triangles and both
// search trees.
//   load_benchmark [ROUNDS]
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>
#include <vector>

#include "spheretree/core/crc64.h"
#include "spheretree/core/sphere_tree_codec.h"
#include "support/sample_skins.h"

int main(int argc, char** argv) {
  using namespace spheretree;
  const int rounds = argc > 1 ? std::max(1, std::atoi(argv[1])) : 20;
  std::vector<std::uint8_t> counts(73, 8);
  counts.resize(73 + 512, 0);
  std::vector<std::vector<std::byte>> files;
  for (std::uint64_t seed = 1; seed <= 33; ++seed)
    files.push_back(encodeSphereTree(test::withSkin(test::withSearch(test::treeOf(counts, seed)), test::gridSkin(45))));

  std::vector<double> decode_ms, checksum_ms;
  const auto now = [] { return 1e3 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC; };  // of the processor, whatever else runs
  for (int round = 0; round < rounds; ++round) {
    const double start = now();
    std::uint64_t sum = 0;
    for (const auto& file : files) sum ^= crc64(file);
    const double middle = now();
    for (const auto& file : files) {
      SphereTree tree;
      std::string fault;
      if (decodeSphereTree(file, tree, &fault) != LoadStatus::Ok || sum == 1) {
        std::fprintf(stderr, "refused: %s\n", fault.c_str());
        return 1;
      }
    }
    checksum_ms.push_back(middle - start);
    decode_ms.push_back(now() - middle);
  }
  std::sort(decode_ms.begin(), decode_ms.end());
  std::sort(checksum_ms.begin(), checksum_ms.end());
  std::printf("33 files of %zu bytes: median %.2f ms, least %.2f ms of the processor's time; the checksum is %.2f ms of it\n",
              files[0].size(), decode_ms[decode_ms.size() / 2], decode_ms[0], checksum_ms[checksum_ms.size() / 2]);
  return 0;
}
