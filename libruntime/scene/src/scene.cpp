// SPDX-License-Identifier: Apache-2.0
#include "spheretree/scene/scene.h"

#include <algorithm>
#include <atomic>
#include <cstring>
#include <exception>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "c_handles.h"
#include "spheretree/scene/describe_scene.h"
#include "spheretree/scene/tissue_exchange.h"

namespace rt = spheretree::runtime;
using rt::fromC, rt::guarded, rt::toC;
using spheretree::SphereTree;

struct st_tissue {
  st_renderer* renderer;
  std::unique_ptr<spheretree::scene::TissueExchange> exchange;
  std::atomic<bool> is_asked{false};  // which thread may use the exchange: that of st_tissue_solve() while it is true
};

namespace {

/// What a scene file says beside the description: st_scene::file.
struct SceneNames {
  std::vector<std::string> objects, bodies;
  std::vector<spheretree::scene::BodyPath> paths;  // (body - 1)
};

const SceneNames& namesOf(const st_scene* scene) {
  static const SceneNames none;
  return scene->file ? *static_cast<const SceneNames*>(scene->file.get()) : none;
}

const SphereTree* treeOf(const st_scene* scene, std::size_t object) {
  const rt::SceneDescription& d = scene->description;
  const SphereTree* const tree = object == ST_TOOL ? &d.tool : object < d.objects.size() ? &*d.objects[object].tree : nullptr;
  return tree && !tree->cover.empty() ? tree : nullptr;
}

}  // namespace

extern "C" {

int st_scene_load(st_scene* scene, const char* path) {
  return guarded(scene, [&]() -> std::string {
    if (!path) return "no path of a scene file was given";
    const std::u8string_view utf8(reinterpret_cast<const char8_t*>(path));
    const std::filesystem::path file_path = spheretree::scene::sceneFileAt(utf8);
    const spheretree::formats::SceneFile file = spheretree::formats::readScene(file_path);
    rt::SceneDescription description = spheretree::scene::describeScene(file, file_path);
    auto names = std::make_shared<SceneNames>();
    for (const auto& object : file.objects) names->objects.push_back(object.name);
    for (const auto& body : file.bodies) names->bodies.push_back(body.name);
    names->paths = spheretree::scene::readBodyPaths(file, file_path);
    scene->description = std::move(description);
    scene->file = std::move(names);
    return {};
  });
}

int st_scene_add_tissue(st_scene* scene, const void* bytes, size_t size, const st_pose* pose) {
  return guarded(scene, [&]() -> std::string {
    const std::string name = "object " + std::to_string(scene->description.objects.size());
    if (!bytes) return name + ": no bytes were given";
    if (!pose) return name + ": no pose was given";
    spheretree::scene::LoadedTree loaded = spheretree::scene::parseTree({static_cast<const std::byte*>(bytes), size}, name);
    if (!loaded.tissue) return name + ": the bytes hold a tree without tissue; give those of a .soft file";
    rt::SceneObject object;
    object.tree = std::move(loaded.tree);
    object.pose = fromC(*pose);
    object.tissue = std::move(loaded.tissue);
    scene->description.objects.push_back(std::move(object));
    return {};
  });
}

size_t st_scene_object_count(const st_scene* scene) { return scene->description.objects.size(); }

const char* st_scene_object_name(const st_scene* scene, size_t object) {
  const std::vector<std::string>& names = namesOf(scene).objects;
  return object < names.size() ? names[object].c_str() : "";
}

uint32_t st_scene_body_count(const st_scene* scene) { return static_cast<uint32_t>(namesOf(scene).bodies.size()); }

const char* st_scene_body_name(const st_scene* scene, uint32_t body) {
  const std::vector<std::string>& names = namesOf(scene).bodies;
  return body > 0 && body <= names.size() ? names[body - 1].c_str() : "";
}

int st_scene_body_pose(const st_scene* scene, uint32_t body, double seconds, st_pose* pose) {
  const std::vector<spheretree::scene::BodyPath>& paths = namesOf(scene).paths;
  if (body == 0 || body > paths.size()) return -1;
  *pose = toC(paths[body - 1].at(seconds));
  return 0;
}

int st_scene_level_count(const st_scene* scene, size_t object) {
  const SphereTree* const tree = treeOf(scene, object);
  return tree ? tree->levelCount() : 0;
}

size_t st_scene_spheres(const st_scene* scene, size_t object, int level, const st_pose* frame, float* xyzr, size_t capacity) {
  const SphereTree* const tree = treeOf(scene, object);
  if (!tree || level < -1 || level >= tree->levelCount()) return 0;
  Eigen::Vector3d origin(tree->origin_mm.data());
  if (object == ST_TOOL) origin -= scene->description.reference_point;
  spheretree::Configuration pose = frame ? fromC(*frame) : spheretree::Configuration{};
  pose.orientation.normalize();
  const Eigen::Matrix3d turn = pose.orientation.toRotationMatrix();
  const std::size_t k = static_cast<std::size_t>(level < 0 ? tree->levelCount() - 1 : level);
  size_t count = 0;
  for (std::uint32_t node = 0; node < tree->level_begin[k + 1]; ++node) {  // as levelSet() of core, which allocates
    if (node < tree->level_begin[k] && !tree->isLeaf(node)) continue;
    if (count < capacity) {
      const spheretree::Sphere& sphere = tree->cover[node];
      const Eigen::Vector3d centre = turn * (centreOf(sphere) + origin) + pose.position;
      for (int axis = 0; axis < 3; ++axis) xyzr[4 * count + static_cast<std::size_t>(axis)] = static_cast<float>(centre[axis]);
      xyzr[4 * count + 3] = sphere.radius;
    }
    ++count;
  }
  return count;
}

int st_renderer_object_pose(const st_renderer* renderer, size_t object, st_pose* pose) {
  if (object >= renderer->scene.objectCount()) return -1;
  *pose = toC(rt::objectPose(object, renderer->workspace));
  return 0;
}

int st_renderer_distance(const st_renderer* renderer, size_t object, const st_pose* tool, double limit_mm, st_distance* out) {
  rt::Distance found;
  if (!rt::distance(object, fromC(*tool), limit_mm, renderer->workspace, found)) return -1;
  const st_distance distance = {.struct_size = out->struct_size,
                                .lower_mm = found.lower,
                                .upper_mm = found.upper,
                                .tool_point_mm = {found.on_tool.x(), found.on_tool.y(), found.on_tool.z()},
                                .object_point_mm = {found.on_object.x(), found.on_object.y(), found.on_object.z()}};
  std::memcpy(out, &distance, std::min(out->struct_size, sizeof distance));
  return 0;
}

int st_renderer_set_spindle(st_renderer* renderer, int turns) { return rt::setSpindle(turns != 0, renderer->workspace) ? 0 : -1; }

size_t st_renderer_removed(const st_renderer* renderer, size_t object, double* removed_mm3, size_t capacity) {
  if (object >= renderer->scene.objectCount()) return 0;
  const std::size_t layers = renderer->scene.cutLayers(object);
  const rt::CutState state = rt::cutState(object, renderer->workspace);
  std::copy_n(state.removed.begin(), std::min(layers, capacity), removed_mm3);
  return layers;
}

int st_renderer_cut_layer(const st_renderer* renderer, size_t object) {
  const rt::CutState state = rt::cutState(object, renderer->workspace);
  return state.layer == rt::CutState::kNone ? -1 : static_cast<int>(state.layer);
}

void st_renderer_mend(st_renderer* renderer) { rt::mend(renderer->workspace); }

st_tissue* st_tissue_create(st_renderer* renderer, char* error, size_t size) {
  std::string fault;
  st_tissue* tissue = nullptr;
  try {
    std::unique_ptr<spheretree::scene::TissueExchange> exchange = spheretree::scene::TissueExchange::make(renderer->scene, fault);
    if (exchange && !exchange->empty()) tissue = new st_tissue{renderer, std::move(exchange)};
  } catch (const std::exception& failed) {
    fault = failed.what();
  }
  if (error && size > 0) error[fault.copy(error, size - 1)] = '\0';
  return tissue;
}

void st_tissue_destroy(st_tissue* tissue) { delete tissue; }

int st_tissue_exchange(st_tissue* tissue) {
  if (tissue->is_asked.load(std::memory_order_acquire)) return 0;
  const bool is_asked = tissue->exchange->exchange(tissue->renderer->workspace);
  if (is_asked) tissue->is_asked.store(true, std::memory_order_release);
  return is_asked;
}

int st_tissue_solve(st_tissue* tissue) {
  if (!tissue->is_asked.load(std::memory_order_acquire)) return 0;
  tissue->exchange->solve();
  tissue->is_asked.store(false, std::memory_order_release);
  return 1;
}

void st_tissue_reset(st_tissue* tissue) {
  tissue->exchange->restart();
  tissue->is_asked.store(false, std::memory_order_release);
}

}  // extern "C"
