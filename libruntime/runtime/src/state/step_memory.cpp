// SPDX-License-Identifier: Apache-2.0
#include "state/step_memory.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <utility>

namespace spheretree::runtime {
namespace {

const KernelTable* choose(Kernel kernel) {
  const KernelTable* const fast = kernel == Kernel::Scalar ? nullptr : avx2Kernel();
  return fast ? fast : &scalarKernel();
}
constexpr std::align_val_t kRowAlignment{64};

ObjectView viewOf(const CompiledObject& object, const CompiledTree& tree) {
  ObjectView view{};
  view.bound = tree.bound.data();
  view.links = tree.links.data();
  view.exact = tree.exact.data();
  view.spheres = tree.spheres.empty() ? nullptr : tree.spheres.data();
  view.anchor = object.anchor.data();
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) view.to_world[3 * r + c] = object.rotation(r, c);
  return view;
}

}  // namespace

void StepMemory::FreeFloats::operator()(float* p) const { ::operator delete[](p, kRowAlignment); }

StepMemory::StepMemory(const CompiledScene& of_scene, Kernel wanted)
    : scene(of_scene),
      kernel(choose(wanted)),
      objects(scene.objects),
      at_home(scene.objects),
      bodies(scene.body_count),
      moving(scene.body_count) {
  // A pair with a hull may become three, beside which it is kept.
  const std::size_t capacity = scene.step_limits.max_pairs * (scene.hulls.empty() ? 1 : 4) + 16, count = objects.size();
  const std::size_t blocks = std::max(scene.tool.bound.size(), scene.hulls.tree.bound.size());
  turned_tool = std::vector<Block>(blocks);
  turned_when = std::vector<std::uint32_t>(blocks);
  bool any_skin = false;
  object_roots = std::vector<Block>((count + 7) / 8, emptyBlock());
  leaf_views = std::vector<ObjectView>(count);
  views = std::vector<ObjectView>(count);
  if (scene.make_tissue) tissue = scene.make_tissue(*this);
  for (std::size_t i = 0; i < count; ++i) {
    const CompiledSkin& skin = scene.shapeOf(i).skin;
    any_skin = any_skin || !skin.empty();
    views[i].patches = skin.empty() ? nullptr : skin.patch.data();
    placeViews(i);
    at_home[i].next_of_body = std::exchange(bodies[objects[i].body].first_object, static_cast<std::uint32_t>(i));
  }
  near = std::vector<std::uint32_t>(count + 16);
  near_counts = std::vector<std::uint32_t>(count);
  pairs = std::vector<std::uint32_t>(capacity);
  runs.reserve(scene.make_cutting ? 2 * count : count);
  if (any_skin) {
    part_settled = std::vector<char>(scene.tool_part_count);
    felt_pairs = std::vector<std::uint32_t>(capacity);
    felt_runs.reserve(count);
  }
  for (auto* list : {&leaves, &open_tool, &open_object}) *list = std::vector<HitGroup>(2 * capacity + 4096);
  const std::size_t row_count = any_skin ? 2 * capacity : capacity;
  row_stride = (row_count + 15) / 16 * 16 + 16;  // not a power of two, since the arrays would then share cache sets
  row_memory.reset(static_cast<float*>(::operator new[](kRowArrays* row_stride * sizeof(float), kRowAlignment)));
  std::fill_n(row_memory.get(), kRowArrays * row_stride, 0.0f);
  active_rubbing.fill(Eigen::Vector3d::Zero());
  if (scene.has_friction || scene.has_soft) contact_problem = std::make_unique<ContactProblem>();
  if (scene.make_cutting) cutting = scene.make_cutting(*this);
  if (!scene.has_soft) return;
  for (auto* list : {&give, &give_before, &give_from, &give_to}) *list = std::vector<double>(count);
  soft_b = std::vector<float>(row_stride);
}

void StepMemory::placeViews(std::size_t i) {
  const CompiledObject& object = objects[i];
  const CompiledShape& shape = scene.shapes[object.shape];
  placeRoot(i, static_cast<float>(shape.radius * (1 + 1e-6)));
  farthest_anchor = std::max(farthest_anchor, object.anchor.norm());
  leaf_views[i] = viewOf(object, shape.leaves);
  views[i] = feelsSkin(i) ? skinView(i) : leaf_views[i];
  if (tissue) tissue->placeView(i);
}

void StepMemory::placeRoot(std::size_t i, float radius) {
  put(object_roots[i / 8], i % 8, objects[i].anchor, isActive(i) ? radius : std::numeric_limits<float>::quiet_NaN());
}

bool StepMemory::isActive(std::size_t i) const { return !std::isnan(object_roots[i / 8].r[i % 8]); }

void StepMemory::switchOff(std::size_t i) { object_roots[i / 8].r[i % 8] = std::numeric_limits<float>::quiet_NaN(); }

void StepMemory::switchOn(std::size_t i) {
  object_roots[i / 8].r[i % 8] = 0;
  placeViews(i);
}

ObjectView StepMemory::skinView(std::size_t object) const {
  const CompiledSkin& skin = scene.shapeOf(object).skin;
  ObjectView view = viewOf(objects[object], skin.tree);
  view.patches = view.still_patches = skin.patch.data();
  view.items = skin.tree.item.data();
  view.allowance = skin.tolerance;
  return view;
}

void StepMemory::feelLeaves(std::size_t object) {
  if (!feelsSkin(object)) return;
  views[object] = leaf_views[object];
  ++leaves_felt;
}

void StepMemory::feelSkin(std::size_t object) {
  if (scene.shapeOf(object).skin.empty() || feelsSkin(object)) return;
  views[object] = skinView(object);
  --leaves_felt;
}

bool isAvailable(Kernel kernel) { return kernel != Kernel::Avx2 || avx2Kernel() != nullptr; }

}  // namespace spheretree::runtime
