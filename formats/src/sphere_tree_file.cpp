// SPDX-License-Identifier: Apache-2.0
#include "spheretree/formats/sphere_tree_file.h"

#include <new>

#include "spheretree/core/sphere_tree_codec.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/file_io.h"

namespace spheretree::formats {

SphereTree readSphereTree(const std::filesystem::path& path) {
  // The largest tree, search tree and skin take 2.6 MB. The cap leaves room for later sections, and keeps a wrong file
  // from filling the memory.
  constexpr std::uint64_t kMostTreeBytes = 16 << 20;
  return parseSphereTree(readFile(path, kMostTreeBytes), path.string());
}

SphereTree parseSphereTree(std::span<const std::byte> bytes, const std::string& name) {
  SphereTree tree;
  std::string fault;
  const LoadStatus status = decodeSphereTree(bytes, tree, &fault);
  if (status == LoadStatus::OutOfMemory) throw std::bad_alloc();
  if (status != LoadStatus::Ok) throw FormatError(name + ": " + fault + ": " + std::string(explain(status)) + ".");
  return tree;
}

void writeSphereTree(const std::filesystem::path& path, const SphereTree& tree) { writeWhole(path, encodeSphereTree(tree)); }

}  // namespace spheretree::formats
