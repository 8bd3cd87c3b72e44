// SPDX-License-Identifier: Apache-2.0
#include "spheretree/formats/sphere_tree_file.h"

#include <new>

#include "spheretree/core/sphere_tree_codec.h"
#include "spheretree/core/tissue_codec.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/file_io.h"
#include "spheretree/formats/path_name.h"

namespace spheretree::formats {

namespace {

[[noreturn]] void refuse(const std::string& name, LoadStatus status, const std::string& fault) {
  if (status == LoadStatus::OutOfMemory) throw std::bad_alloc();
  throw FormatError(name + ": " + fault + ": " + std::string(explain(status)) + ".");
}

}  // namespace

SphereTree readSphereTree(const std::filesystem::path& path) {
  return parseSphereTree(readFile(path, path.extension() == ".soft" ? kMaxSoftBytes : kMaxTreeBytes), toUtf8(path));
}

SphereTree parseSphereTree(std::span<const std::byte> bytes, const std::string& name) {
  SphereTree tree;
  std::string fault;
  const LoadStatus status = decodeSphereTree(bytes, tree, &fault);
  if (status != LoadStatus::Ok) refuse(name, status, fault);
  return tree;
}

SphereTree readSoftTree(const std::filesystem::path& path, Tissue& tissue) {
  return parseSoftTree(readFile(path, kMaxSoftBytes), shownName(path), tissue);
}

SphereTree parseSoftTree(std::span<const std::byte> bytes, const std::string& name, Tissue& tissue) {
  SphereTree tree;
  std::string fault;
  const LoadStatus status = decodeSoftTree(bytes, tree, tissue, &fault);
  if (status != LoadStatus::Ok) refuse(name, status, fault);
  return tree;
}

void writeSphereTree(const std::filesystem::path& path, const SphereTree& tree) { writeWhole(path, encodeSphereTree(tree)); }

}  // namespace spheretree::formats
