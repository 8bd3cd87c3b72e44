// SPDX-License-Identifier: Apache-2.0
#include "cut/cutter.h"

#include <algorithm>

#include "cut/compile_surface.h"
#include "piece/force_rate_limit.h"
#include "state/moving_bodies.h"

namespace spheretree::runtime {
namespace {

using Eigen::Vector3d;

// The lattice, in shares of the radius of the smallest ball of the burr, and what follows from its spacing: the reach
// of its fields is the largest motion of a burr in a step.
constexpr double kSpacingShare = 1.0 / 8, kFinest = 0.03, kCoarsest = 0.1;  // [mm]
constexpr double kReachSpacings = 4;
constexpr std::size_t kMaxBlocks = 8192;  // of all objects: 49 MB

}  // namespace

Cutter::Cutter(StepMemory& memory)
    : memory_(memory),
      scene_(memory.scene),
      storage_(kMaxBlocks),
      works_(makeWorks()),
      facets_(memory, works_),
      walls_(memory, works_, storage_) {}

std::vector<CutWork> Cutter::makeWorks() {
  float smallest = scene_.burr[0].radius;
  for (const Sphere& ball : scene_.burr) smallest = std::min(smallest, ball.radius);
  const double spacing = std::clamp(kSpacingShare * static_cast<double>(smallest), kFinest, kCoarsest);
  std::vector<CutWork> works;
  for (std::uint32_t i = 0; i < scene_.objects.size(); ++i) {
    const CompiledShape& shape = scene_.shapeOf(i);
    if (!shape.cut) continue;
    CutWork& work = works.emplace_back(CutWork{
        i,
        shape,
        *shape.cut,
        CutLayers(shape.skin),
        CutLattice(spacing, kReachSpacings * spacing, i, storage_, memory_.kernel == &scalarKernel() ? scalarCutKernel() : avx2CutKernel()),
        {},
        CutState::kNone,
        {}});
    for (const CutLayer& layer : shape.cut->material.inner) work.layers.add(compileSurface(*layer.surface, -shape.centre));
    work.removed = std::vector<double>(work.layers.count());
    work.burr = std::vector<NearBall>(scene_.burr.size());
  }
  return works;
}

void Cutter::mend() {
  facets_.forget();
  storage_.clear();
  for (CutWork& work : works_) {
    work.lattice.mend();
    std::fill(work.removed.begin(), work.removed.end(), 0.0);
    std::fill(work.burr.begin(), work.burr.end(), NearBall{});
    work.layer = CutState::kNone;
  }
}

CutState Cutter::stateOf(std::size_t object) const {
  CutState state;
  if (const CutWork* work = workOf(works_, object)) {
    std::copy(work->removed.begin(), work->removed.end(), state.removed.begin());
    state.layer = work->layer;
  }
  return state;
}

bool Cutter::isRemoved(std::size_t object, const Vector3d& point) const {
  const CutWork* const work = workOf(works_, object);
  return work && work->lattice.isRemoved(point);
}

Configuration Cutter::resisted(const Configuration& aim, StepResult& result) {
  const Displacement to_aim = displacementBetween(memory_.graphic, aim);
  if (spins_)
    for (const CutWork& work : works_)
      if (memory_.isActive(work.object)) follow(work.object, memory_);
  if (!facets_.find(to_aim, spins_, result)) {
    result.faults |= kWorkLimit;
    return memory_.graphic;
  }
  const auto scaled = [&](const Displacement& d) {
    Vector6 out;
    out << d.translation, scene_.angle_length * d.rotation;
    return out;
  };
  const Vector6 target = scaled(to_aim);
  if (facets_.empty()) facets_.forget();
  const Vector6 step = facets_.empty() ? target : facets_.step(target, result);
  // The force of cutting is what the tool lags behind the hand beyond its contacts. It changes as forces may elsewhere:
  // a burr that slips off, comes out or stops springs back over several steps.
  const Vector6 lag = scaled(displacementBetween(memory_.haptic, memory_.aim)), hand = scaled(displacementBetween(memory_.aim, aim));
  const ForceRateLimit limit(scene_.pull, scene_.angle_length, lag, hand, lag + hand);
  const double share = limit.shareWithin(target, step, facets_.shareWithin(step));
  if (share == 1 && facets_.empty()) return aim;
  const Vector6 y = share * step;
  return moved(memory_.graphic, {y.head<3>(), y.tail<3>() / scene_.angle_length});
}

void Cutter::remove(StepResult& result) {
  if (!spins_) return;
  for (CutWork& work : works_) {
    if (std::ranges::none_of(work.burr, &NearBall::is_near)) continue;
    follow(work.object, memory_);
    for (std::size_t ball = 0; ball < work.burr.size(); ++ball)
      if (work.burr[ball].is_near)
        result.work += work.lattice.remove(work.burr[ball].at, work.localOf(placeOf(memory_.graphic, scene_.burr[ball]), memory_),
                                           static_cast<double>(scene_.burr[ball].radius), work.removed);
  }
}

}  // namespace spheretree::runtime
