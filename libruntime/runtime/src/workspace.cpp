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
    objects.views.push_back({o.tree.bound.data(), o.tree.links.data(), o.tree.exact.data(), o.anchor.data(), {}});
  for (const CompiledBridges& b : scene.bridges)
    bridges.views.push_back({b.tree.bound.data(), b.tree.links.data(), nullptr, scene.objects[b.object].anchor.data(), {}});
  for (Targets* targets : {&objects, &bridges}) {
    const std::size_t count = targets->views.size();
    targets->near_views.resize(count);
    targets->near.resize(count + 16);
    targets->near_counts.resize(count);
    targets->pairs.resize(count > 0 ? capacity : 0);
    targets->runs.reserve(count);
  }
  for (auto* list : {&leaves, &open_tool, &open_object}) list->resize(2 * capacity + 4096);
  const std::size_t row_count = scene.bridges.empty() ? capacity : 2 * capacity;
  row_stride = (row_count + 15) / 16 * 16 + 16;  // not a power of two: eight arrays would share cache sets
  row_memory.reset(static_cast<float*>(::operator new[](8 * row_stride * sizeof(float), kRowAlignment)));
  std::fill_n(row_memory.get(), 8 * row_stride, 0.0f);
}

Workspace::~Workspace() = default;

}  // namespace spheretree::runtime
