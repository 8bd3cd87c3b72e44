// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/mesh_store.h"

#include "spheretree/builder/provenance.h"
#include "spheretree/formats/file_io.h"

namespace spheretree::pipeline {

std::shared_ptr<const MeshStore::File> MeshStore::read(const formats::SceneFile& scene, const std::filesystem::path& scene_path,
                                                       const formats::SceneItem& item) {
  const std::filesystem::path path = formats::scenePath(scene_path, item.mesh);
  if (item.unit.empty()) return read(path, formats::unitInMm(scene.unit), formats::unitInMm("m"));
  return read(path, formats::unitInMm(item.unit), formats::unitInMm(item.unit));
}

void MeshStore::hold(const std::filesystem::path& path, double unit_mm, TriangleMesh mesh, std::span<const std::byte> bytes) {
  auto file = std::make_shared<File>();
  file->mesh.mesh = std::move(mesh);
  file->mesh.unit_mm = unit_mm;
  file->mesh.format = "OBJ";
  file->hash = builder::bytesHash(bytes);
  auto entry = std::make_unique<Entry>();
  entry->file = std::move(file);
  const std::lock_guard lock(mutex_);
  entries_[{path, unit_mm, unit_mm}] = std::move(entry);
}

std::shared_ptr<const MeshStore::File> MeshStore::read(const std::filesystem::path& path, double unit_mm, double gltf_unit_mm) {
  Entry* entry = nullptr;
  {
    const std::lock_guard lock(mutex_);
    std::unique_ptr<Entry>& slot = entries_[{path, unit_mm, gltf_unit_mm}];
    if (!slot) slot = std::make_unique<Entry>();
    entry = slot.get();
  }
  const std::lock_guard lock(entry->reading);  // other threads can read other files
  if (!entry->file) {
    auto file = std::make_shared<File>();
    file->mesh = formats::readMesh(path, unit_mm, gltf_unit_mm);
    // A .gltf may have its numbers in other files, and a change of those does not change its own bytes.
    file->hash = file->mesh.format == "glTF" ? builder::meshHash(file->mesh.mesh) : builder::bytesHash(formats::readFile(path));
    entry->file = std::move(file);
  }
  return entry->file;
}

}  // namespace spheretree::pipeline
