// SPDX-License-Identifier: Apache-2.0
// Soft tissue in a step: docs/runtime.md, Soft tissue.
#include <algorithm>
#include <cmath>
#include <utility>

#include "rows/row_set.h"
#include "search/find_pairs.h"
#include "spheretree/runtime/scene.h"
#include "spheretree/runtime/step.h"
#include "state/soft_tissue.h"
#include "state/step_memory.h"
#include "tissue/linear_contacts.h"
#include "tissue/soft_rows.h"
#include "tissue/soft_surface.h"

namespace spheretree::runtime {
namespace {

using Eigen::Vector3d;

constexpr double kAimSeconds = 0.04;  // time in which the surface covers most of the way to its target
constexpr double kSqueezed = 0.02;    // if the tool is deeper than this in something, it is squeezed, and tissue waits [mm]
constexpr double kAimMotion = 0.1;    // largest motion of a node towards its target in a step [mm]

/// (object) null: rigid.
std::vector<std::unique_ptr<SoftSurface>> surfacesOf(const CompiledScene& scene) {
  std::vector<std::unique_ptr<SoftSurface>> surfaces;
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    const CompiledShape& shape = scene.shapeOf(i);
    const auto* const model = static_cast<const SoftModel*>(shape.tissue.get());
    surfaces.push_back(model ? std::make_unique<SoftSurface>(*model, shape) : nullptr);
  }
  return surfaces;
}

class LinearTissue final : public SoftTissue {
 public:
  explicit LinearTissue(StepMemory& memory)
      : memory_(memory),
        scene_(memory.scene),
        kernel_(memory.kernel == &scalarKernel() ? scalarSoftKernel() : avx2SoftKernel()),
        share_(std::min(1.0, scene_.step_time / kAimSeconds)),
        frozen_(scene_.objects.size(), false),
        surfaces_(surfacesOf(scene_)),
        contacts_(memory, surfaces_),
        in_front_(scene_.tool.spheres.size()) {
    for (const auto& surface : surfaces_) is_tissue_.push_back(surface != nullptr);
  }

  void reset() override {
    std::fill(frozen_.begin(), frozen_.end(), false);
    waits_ = false;
    for (std::size_t i = 0; i < surfaces_.size(); ++i)
      if (surfaces_[i]) surfaces_[i]->reset(), placeView(i);
  }
  bool isAtRest(std::size_t object) const override { return surfaces_[object]->isAtRest(); }
  std::uint32_t beginStep(const Configuration& hand) override {
    const Displacement way = displacementBetween(memory_.aim, hand);
    const double hand_way = way.translation.norm() + scene_.tool.reach * way.rotation.norm();
    motion_ = std::min(kMaxTissueMotion, kTissueMotion + kHandShare * hand_way);
    // While the tool cannot escape, it is not pressed in farther.
    const double max_motion = memory_.depth > kSqueezed || waits_ ? 0 : kAimMotion;
    waits_ = false;
    for (std::size_t i = 0; i < surfaces_.size(); ++i)
      if (surfaces_[i]) surfaces_[i]->beginStep(share_, max_motion, motion_), placeView(i);
    return std::find(frozen_.begin(), frozen_.end(), true) == frozen_.end() ? kNoFault : kTissueFrozen;
  }
  void takeBack() override {
    for (std::size_t i = 0; i < surfaces_.size(); ++i)
      if (surfaces_[i]) surfaces_[i]->takeBack(), placeView(i);
    waits_ = true;
  }
  void placeView(std::size_t object) override;
  std::uint32_t keepNear(const Configuration& pose, double margin, PairSet& set) override;
  void placePatches(const PairSet& set) override;
  void findFront(const RowRequest& request) const override { kernel_.findFront(request); }
  float patchRows(const RowRequest& request) const override { return kernel_.rows(request); }
  void giveWay(double share) override {
    for (const auto& s : surfaces_)
      if (s) s->giveWay(share);
  }
  void letGo() override {
    for (const auto& s : surfaces_) {
      if (!s) continue;
      s->aimAt(false);
      s->giveWay(1);
    }
  }
  TissueContacts& contacts() override { return contacts_; }
  bool aim(std::size_t object, std::span<const float> surface, bool is_frozen) override;
  std::span<const float> forces(std::size_t object) const override { return surfaces_[object]->forces(); }

 private:
  StepMemory& memory_;
  const CompiledScene& scene_;
  const SoftKernel& kernel_;
  const double share_;                                  // share of the way to a target in a step
  double motion_ = kTissueMotion;                       // largest motion of a point in this step by forces [mm]
  bool waits_ = false;                                  // after takeBack()
  std::vector<bool> frozen_;                            // (object) the solver that sets its target has failed
  std::vector<std::unique_ptr<SoftSurface>> surfaces_;  // (object) null: rigid
  LinearContacts contacts_;
  std::vector<float> in_front_;  // of the views
};

void LinearTissue::placeView(std::size_t object) {
  SoftSurface* const surface = surfaces_[object].get();
  if (!surface || !memory_.feelsSkin(object)) return;
  MovedSkin& skin = surface->skin();
  ObjectView& view = memory_.views[object];
  view.bound = skin.bound();
  view.patches = skin.patches();
  view.still_patches = nullptr;
  view.allowance = skin.allowance();
  view.points = skin.points();
  view.step = skin.step();
  view.motion = static_cast<float>(motion_ + kRefitMm);
  view.behind = static_cast<float>(kBehind);
  view.in_front = in_front_.data();
  memory_.placeRoot(object, static_cast<float>(skin.radius() * (1 + 1e-6)) + view.motion);
}

std::uint32_t LinearTissue::keepNear(const Configuration& pose, double margin, PairSet& set) {
  if (set.coarse) return 0;
  const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> rotation = pose.orientation.normalized().toRotationMatrix();
  std::uint32_t count = 0, tested = 0;
  for (PairRun& run : memory_.runs) {
    std::uint32_t *const pairs = memory_.pairs.data() + run.begin, *const kept = memory_.pairs.data() + count;
    if (memory_.isTissue(run.object)) {
      SoftSurface& surface = *surfaces_[run.object];
      const ObjectView& view = memory_.views[run.object];
      surface.putTriangles({pairs, run.count});
      RowRequest request{};
      request.pairs = pairs;
      request.count = run.count;
      request.tool = scene_.tool.spheres.data();
      request.pose = relativePose(view, rotation.data(), pose.position.data());
      request.patches = view.patches;
      request.items = view.items;
      const double reach = margin + motion_ + surface.motionSoFar() + static_cast<double>(surface.skin().largestSwing()),
                   lengths = scene_.tool.reach + 2 * surface.skin().radius() + reach;
      tested += run.count;
      run.count = kernel_.keepNear(request, static_cast<float>(reach + kFloatRounding * lengths), kept);
    } else {
      std::copy_n(pairs, run.count, kept);
    }
    run.begin = count;
    count += run.count;
  }
  std::erase_if(memory_.runs, [](const PairRun& run) { return run.count == 0; });
  set.pairs = {memory_.pairs.data(), count};
  set.runs = memory_.runs;
  return (tested + 7) / 8;
}

void LinearTissue::placePatches(const PairSet& set) {
  if (set.coarse) return;
  for (const PairRun& run : set.runs) {
    if (!memory_.isTissue(run.object)) continue;
    surfaces_[run.object]->putPatches(set.pairs.subspan(run.begin, run.count));
    memory_.views[run.object].allowance = surfaces_[run.object]->skin().allowance();
  }
}

bool LinearTissue::aim(std::size_t object, std::span<const float> surface, bool is_frozen) {
  if (surface.size() != surfaces_[object]->forces().size()) return false;
  surfaces_[object]->aim(surface);
  frozen_[object] = is_frozen;
  return true;
}

std::unique_ptr<SoftTissue> makeLinearTissue(StepMemory& memory) { return std::make_unique<LinearTissue>(memory); }

}  // namespace

std::shared_ptr<const TissueModel> tissueModel(const SharedTree& tree, std::shared_ptr<const Tissue> tissue, std::string& fault) {
  fault = findFault(*tree);
  if (fault.empty()) fault = findFault(*tissue, *tree);
  if (fault.empty() && tissue->response.empty())
    fault = "the tissue has no response to forces: it has too many nodes. Soften it with fewer tetrahedra";
  if (fault.empty() && tree->skin.empty()) fault = "the tree has no skin, which is what is felt of tissue. Build it with one";
  if (!fault.empty()) return nullptr;
  auto model = softModel(tree, std::move(tissue));
  model->make = makeLinearTissue;
  return model;
}

const Tissue* Scene::tissue(std::size_t object) const {
  const TissueModel* const model = compiled_->shapeOf(object).tissue.get();
  return model ? model->tissue.get() : nullptr;
}

bool aimTissue(std::size_t object, std::span<const float> surface, bool is_frozen, Workspace& workspace) noexcept {
  SoftTissue* const tissue = workspace.memory().tissue.get();
  return tissue && tissue->has(object) && tissue->aim(object, surface, is_frozen);
}

std::span<const float> tissueForces(std::size_t object, const Workspace& workspace) noexcept {
  const SoftTissue* const tissue = workspace.memory().tissue.get();
  return tissue && tissue->has(object) ? tissue->forces(object) : std::span<const float>();
}

}  // namespace spheretree::runtime
