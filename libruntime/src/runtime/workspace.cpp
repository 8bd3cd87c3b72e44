// SPDX-License-Identifier: Apache-2.0
#include "spheretree/runtime/workspace.h"

#include <algorithm>
#include <new>

#include "kernel.h"

namespace spheretree::runtime {
namespace {

const KernelTable* choose(Kernel kernel) {
  const KernelTable* const fast = kernel == Kernel::Scalar ? nullptr : avx2Kernel();
  return fast ? fast : &scalarKernel();
}
constexpr std::align_val_t kRowAlignment{64};

}  // namespace

void Workspace::FreeFloats::operator()(float* p) const { ::operator delete[](p, kRowAlignment); }

Workspace::Workspace(const Scene& scene, Kernel wanted) : kernel(choose(wanted)) {
  const std::size_t capacity = scene.step_limits.max_pairs + 16;
  turned_tool.resize(scene.tool.bound.size());
  turned_when.resize(scene.tool.bound.size());
  for (const CompiledObject& o : scene.objects)
    object_views.push_back({o.tree.bound.data(), o.tree.links.data(), o.tree.exact.data(), o.anchor.data(), {}});
  near_views.resize(scene.objects.size());
  near_objects.resize(scene.objects.size() + 16);
  near_counts.resize(scene.objects.size());
  for (auto* list : {&leaves, &open_tool, &open_object}) list->resize(2 * capacity + 4096);
  pairs.resize(capacity);
  runs.reserve(scene.objects.size());
  const std::size_t row_count = capacity + (scene.deepest_bridge > 0 ? kMostBridgeRows : 0);
  bridge_rows.reserve(scene.deepest_bridge > 0 ? kMostBridgeRows : 0);
  near_bridges.reserve(scene.deepest_bridge > 0 ? kMostNearBridges : 0);
  row_stride = (row_count + 15) / 16 * 16 + 16;  // not a power of two: eight arrays would share cache sets
  row_memory.reset(static_cast<float*>(::operator new[](8 * row_stride * sizeof(float), kRowAlignment)));
  std::fill_n(row_memory.get(), 8 * row_stride, 0.0f);
}

Workspace::~Workspace() = default;

}  // namespace spheretree::runtime
