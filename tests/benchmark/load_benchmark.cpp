// SPDX-License-Identifier: Apache-2.0
// Time to check, decode and compile 33 .stree files to a scene: each with 512 leaves, a skin of about 4,000 triangles
// and both search trees; or the named files, including the reading of their bytes.
//   load_benchmark [ROUNDS [FILE.stree...]]
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>
#include <utility>
#include <vector>

#include "spheretree/core/crc64.h"
#include "spheretree/core/sphere_tree_codec.h"
#include "spheretree/runtime/scene.h"
#include "support/sample_skins.h"

namespace {

using namespace spheretree;

using Bytes = std::vector<std::byte>;

Bytes bytesOf(const char* file) {
  std::FILE* const in = std::fopen(file, "rb");
  if (in == nullptr) return {};
  Bytes bytes;
  std::byte part[1 << 16];
  for (std::size_t n; (n = std::fread(part, 1, sizeof part, in)) > 0;) bytes.insert(bytes.end(), part, part + n);
  std::fclose(in);
  return bytes;
}

std::vector<Bytes> builtIn() {
  std::vector<std::uint8_t> counts(73, 8);
  counts.resize(73 + 512, 0);
  std::vector<Bytes> files;
  for (std::uint64_t seed = 1; seed <= 33; ++seed)
    files.push_back(encodeSphereTree(test::withSkin(test::withSearch(test::treeOf(counts, seed)), test::gridSkin(45))));
  return files;
}

double now() { return 1e3 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }  // processor time, independent of other programs [ms]

struct Times {
  std::vector<double> read, checksum, decode, compile, all;
  std::size_t bytes = 0, scene_bytes = 0;
};

// One load of everything; false with a message if a file is refused.
bool load(const std::vector<Bytes>& built_in, const std::vector<const char*>& names, Times& times) {
  const double start = now();
  std::vector<Bytes> files = built_in;
  for (const char* name : names) files.push_back(bytesOf(name));
  const double read = now();
  std::uint64_t sum = 0;
  times.bytes = 0;
  for (const Bytes& file : files) sum ^= crc64(file), times.bytes += file.size();
  const double summed = now();
  runtime::SceneDescription description;
  description.tool = test::withSearch(test::treeOf({0}));
  for (const Bytes& file : files) {
    SphereTree tree;
    std::string fault;
    if (decodeSphereTree(file, tree, &fault) != LoadStatus::Ok || sum == 1) {
      std::fprintf(stderr, "refused: %s\n", fault.c_str());
      return false;
    }
    description.objects.push_back({runtime::SharedTree::sound(std::move(tree)), {}});
  }
  description.step_limits = runtime::defaultLimits(files.size());
  const double decoded = now();
  runtime::Scene scene;
  std::string fault;
  if (!runtime::compileScene(description, scene, fault)) {
    std::fprintf(stderr, "refused: %s\n", fault.c_str());
    return false;
  }
  const double compiled = now();
  times.scene_bytes = scene.byteCount();
  times.read.push_back(read - start);
  times.checksum.push_back(summed - read);
  times.decode.push_back(decoded - summed);
  times.compile.push_back(compiled - decoded);
  times.all.push_back(compiled - start - (summed - read));
  return true;
}

void print(const char* what, std::vector<double> ms) {
  std::sort(ms.begin(), ms.end());
  std::printf("%-9s median %6.2f ms, least %6.2f ms\n", what, ms[ms.size() / 2], ms[0]);
}

}  // namespace

int main(int argc, char** argv) {
  const int rounds = argc > 1 ? std::max(1, std::atoi(argv[1])) : 20;
  const std::vector<const char*> names(argv + std::min(argc, 2), argv + argc);
  const std::vector<Bytes> built_in = names.empty() ? builtIn() : std::vector<Bytes>();
  Times times;
  for (int round = 0; round < rounds; ++round)
    if (!load(built_in, names, times)) return 1;
  std::printf("%zu files of %zu bytes, a scene of %zu bytes; time of the processor:\n", built_in.size() + names.size(), times.bytes,
              times.scene_bytes);
  print("read", times.read);
  print("decode", times.decode);
  print("compile", times.compile);
  print("all", times.all);
  print("a checksum", times.checksum);
  return 0;
}
