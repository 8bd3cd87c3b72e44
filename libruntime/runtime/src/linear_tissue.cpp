// SPDX-License-Identifier: Apache-2.0
// Soft tissue under small motion: docs/runtime.md, Soft tissue.
#include <algorithm>
#include <cmath>
#include <utility>

#include "soft_surface.h"
#include "soft_tissue.h"
#include "spheretree/runtime/scene.h"
#include "spheretree/runtime/step.h"
#include "step_memory.h"

namespace spheretree::runtime {
namespace {

using Eigen::Vector3d;

constexpr double kDependentGive = 1e-9;  // of its own give: less is what the rows before it say already
constexpr double kAimSeconds = 0.04;     // in which the leaves go most of the way to where they are aimed
constexpr double kSqueezed = 0.02;       // deeper in something the tool is squeezed, and tissue waits [mm]
constexpr double kAimShare = 0.25;       // of the least distance of two centres that touch: in a step they go no farther

class LinearTissue final : public SoftTissue {
 public:
  explicit LinearTissue(StepMemory& memory)
      : memory_(memory),
        scene_(memory.scene),
        part_(std::min(1.0, scene_.step_time / kAimSeconds)),
        most_(std::min(kTissueMotion, kAimShare * scene_.least_contact)) {
    for (std::size_t i = 0; i < scene_.objects.size(); ++i) {
      const CompiledShape& shape = scene_.shapeOf(i);
      is_tissue_.push_back(shape.tissue != nullptr);
      frozen_.push_back(false);
      surfaces_.push_back(shape.tissue ? std::make_unique<SoftSurface>(static_cast<const LinearModel&>(*shape.tissue), shape) : nullptr);
    }
  }

  void reset() override {
    std::fill(frozen_.begin(), frozen_.end(), false);
    for (std::size_t i = 0; i < surfaces_.size(); ++i)
      if (surfaces_[i]) surfaces_[i]->reset(), placeView(i);
  }
  std::uint32_t beginStep() override {
    const double most = memory_.depth > kSqueezed ? 0 : most_;  // while the tool has no way out it is not pressed farther in
    for (std::size_t i = 0; i < surfaces_.size(); ++i)
      if (surfaces_[i]) surfaces_[i]->beginStep(part_, most), placeView(i);
    return std::find(frozen_.begin(), frozen_.end(), true) == frozen_.end() ? kNoFault : kTissueFrozen;
  }
  void placeView(std::size_t object) override;
  void shiftRows(const PairRun& run, const PairSet& set, RowSet& rows) const override;
  void giveWay(double part) override {
    for (const auto& s : surfaces_)
      if (s) s->giveWay(part);
  }
  void letGo() override {
    for (const auto& s : surfaces_) {
      if (!s) continue;
      s->aimAt(false);
      s->giveWay(1);
    }
  }
  void begin(const PairSet& pairs, const RowSet& rows, bool is_carried) override;
  float stop(std::uint32_t object, std::uint32_t row) const override { return rowOn(object, row).stop; }
  void setRow(ContactQp& qp, int k, std::uint32_t object, std::uint32_t row, bool is_stop) override;
  void predict(const ContactQp& qp) override;
  float predictedBound(std::uint32_t object, std::uint32_t row, bool& is_stop) const override;
  void press(const ContactQp& qp) override;
  void aim(std::size_t object, std::span<const Sphere> leaves, const TissueTangent& tangent, bool is_frozen) override {
    surfaces_[object]->aim(leaves, tangent);
    frozen_[object] = is_frozen;
  }
  std::span<const float> forces(std::size_t object) const override { return surfaces_[object]->forces(); }

 private:
  struct Row {
    SoftSurface* surface;
    std::uint32_t leaf;
    Vector3d normal;  // axes of the object
    double given;     // by now, along the normal [mm]
    float stop;       // b where the tissue gives way no farther
  };
  // A row of the problem, and a coordinate that was made for one.
  struct Pressed {
    SoftSurface* surface = nullptr;  // null: rigid, or a stop
    std::uint32_t leaf = 0;
    Vector3d pull{0, 0, 0};  // what it presses with for a multiplier of 1, axes of the object [N]
  };
  struct Coordinate {
    Pressed row;
    std::array<double, kMostContactRows> factor{};
  };

  Row rowOn(std::uint32_t object, std::uint32_t row) const;

  StepMemory& memory_;
  const CompiledScene& scene_;
  const double part_, most_;                            // of the way to an aim, and of it the most [mm], in a step
  std::vector<bool> frozen_;                            // (object) who aims it is at a loss
  std::vector<std::unique_ptr<SoftSurface>> surfaces_;  // (object) null: rigid
  PairSet pairs_;
  RowSet rows_;
  bool is_carried_ = false;
  std::array<Pressed, kMostContactRows> pressed_;
  std::array<Coordinate, kMostContactRows> coordinates_;
};

void LinearTissue::placeView(std::size_t object) {
  const SoftSurface* const surface = surfaces_[object].get();
  if (!surface) return;
  ObjectView& view = memory_.views[object];
  view.bound = surface->bound();
  view.spheres = surface->spheres();
  view.allowance = static_cast<float>(kTissueMotion);  // it may come that much nearer itself, and go as far away before
  put(memory_.object_roots[object / 8], object % 8, memory_.objects[object].anchor, static_cast<float>(surface->radius() * (1 + 1e-6)));
}

void LinearTissue::shiftRows(const PairRun& run, const PairSet& set, RowSet& rows) const {
  const Eigen::Matrix3d& rotation = memory_.objects[run.object].rotation;
  const std::vector<std::uint32_t>& item = scene_.shapeOf(run.object).leaves.item;
  for (std::uint32_t i = run.begin; i < run.begin + run.count; ++i) {
    const std::uint32_t leaf = item[set.pairs[i] & 0xffff];
    if (leaf == kNoItem) continue;
    const SoftSurface& surface = *surfaces_[run.object];
    const Vector3d moved = rotation * surface.sinceRefit(leaf), a(rows.rows.a[0][i], rows.rows.a[1][i], rows.rows.a[2][i]);
    rows.b[i] += static_cast<float>(a.dot(moved) + static_cast<double>(rows.weight[i]) * surface.grownSinceRefit(leaf));
  }
}

void LinearTissue::begin(const PairSet& pairs, const RowSet& rows, bool is_carried) {
  pairs_ = pairs;
  rows_ = rows;
  is_carried_ = is_carried;
  for (Pressed& p : pressed_) p.surface = nullptr;
  for (const PairRun& run : pairs.runs) {
    SoftSurface* const surface = surfaces_[run.object].get();
    if (!surface) continue;
    surface->forgetNear();
    for (std::uint32_t i = run.begin; i < run.begin + run.count; ++i)
      surface->addNear(scene_.shapeOf(run.object).leaves.item[pairs.pairs[i] & 0xffff]);
  }
}

LinearTissue::Row LinearTissue::rowOn(std::uint32_t object, std::uint32_t row) const {
  Row out;
  out.surface = surfaces_[object].get();
  const auto weight = static_cast<double>(rows_.weight[row]);
  const Vector3d a(rows_.rows.a[0][row], rows_.rows.a[1][row], rows_.rows.a[2][row]);
  out.leaf = scene_.shapeOf(object).leaves.item[pairs_.pairs[row] & 0xffff];
  out.normal = memory_.objects[object].rotation.transpose() * a / weight;
  out.given = -out.normal.dot(out.surface->displacement(out.leaf));
  const double gone = -out.normal.dot(out.surface->travelled(out.leaf));
  out.stop = memory_.soft_b[row] - rows_.weight[row] * static_cast<float>(std::max(0.0, out.surface->mostGive(out.leaf) - gone));
  return out;
}

// The compliance of the surface at the points of the rows, as a Cholesky factor that grows by a row. A row that gives
// way no otherwise than those before it needs no coordinate of its own.
void LinearTissue::setRow(ContactQp& qp, int k, std::uint32_t object, std::uint32_t row, bool is_stop) {
  const auto at = static_cast<std::size_t>(k);
  Pressed& pressed = pressed_[at];
  std::array<double, kMostContactRows>& entry = qp.tissue[at];
  pressed.surface = nullptr;
  entry.fill(0);
  if (!has(object)) return;
  const Row on = rowOn(object, row);
  ContactRow& r = qp.rows[at];
  if (is_stop) {
    r.b = static_cast<double>(on.stop);
    return;
  }
  const double weight = static_cast<double>(rows_.weight[row]), stiffness = scene_.pull.translation;
  pressed = {on.surface, on.leaf, stiffness * weight * on.normal};
  if (!is_carried_) r.b += weight * on.given;  // the coordinates count from rest; in a piece that is carried, from now
  const auto give = [&](const Pressed& other) {
    return pressed.pull.dot(on.surface->response(on.leaf, other.leaf, other.pull)) / stiffness;
  };
  const double own = give(pressed);
  double left = own;
  const auto count = static_cast<std::size_t>(qp.tissue_count);
  for (std::size_t m = 0; m < count; ++m) {
    const Coordinate& c = coordinates_[m];
    if (c.row.surface != on.surface) continue;
    double sum = give(c.row);
    for (std::size_t l = 0; l < m; ++l) sum -= entry[l] * c.factor[l];
    entry[m] = sum / c.factor[m];
    left -= entry[m] * entry[m];
  }
  if (!(left > kDependentGive * own) || count == kMostContactRows) {
    r.compliance = std::max(left, 0.0);
    return;
  }
  entry[count] = std::sqrt(left);
  coordinates_[count] = {pressed, entry};
  qp.tissue_given[count] = 0;
  ++qp.tissue_count;
}

void LinearTissue::predict(const ContactQp& qp) {
  for (const PairRun& run : pairs_.runs)
    if (has(run.object)) surfaces_[run.object]->predictNothing();
  for (std::size_t k = 0; k < static_cast<std::size_t>(qp.row_count); ++k)
    if (const Pressed& p = pressed_[k]; p.surface && qp.rows[k].multiplier > 0) p.surface->predict(p.leaf, -qp.rows[k].multiplier * p.pull);
}

float LinearTissue::predictedBound(std::uint32_t object, std::uint32_t row, bool& is_stop) const {
  const Row on = rowOn(object, row);
  const double then = -on.normal.dot(on.surface->predicted(on.leaf)), more = is_carried_ ? then : then - on.given;
  const float bound = memory_.soft_b[row] - rows_.weight[row] * static_cast<float>(more);
  is_stop = on.stop > bound;
  return std::max(bound, on.stop);
}

void LinearTissue::press(const ContactQp& qp) {
  for (const auto& s : surfaces_)
    if (s) s->aimAt(is_carried_);
  for (std::size_t k = 0; k < static_cast<std::size_t>(qp.row_count); ++k)
    if (const Pressed& p = pressed_[k]; p.surface && qp.rows[k].multiplier > 0) p.surface->press(p.leaf, -qp.rows[k].multiplier * p.pull);
}

std::unique_ptr<SoftTissue> makeLinearTissue(StepMemory& memory) { return std::make_unique<LinearTissue>(memory); }

}  // namespace

std::shared_ptr<const TissueModel> tissueModel(const SharedTree& tree, std::shared_ptr<const Tissue> tissue, std::string& fault) {
  fault = findFault(*tree);
  if (fault.empty()) fault = findFault(*tissue, *tree);
  if (fault.empty() && tissue->response.empty())
    fault = "the tissue has no response to forces: it has too many nodes. Soften it with fewer tetrahedra";
  if (!fault.empty()) return nullptr;
  auto model = std::make_shared<LinearModel>(linearModel(std::move(tissue)));
  model->tree = tree;
  model->make = makeLinearTissue;
  return model;
}

const Tissue* Scene::tissue(std::size_t object) const {
  const TissueModel* const model = compiled_->shapeOf(object).tissue.get();
  return model ? model->tissue.get() : nullptr;
}

bool aimTissue(std::size_t object, std::span<const Sphere> leaves, const TissueTangent& tangent, bool is_frozen,
               Workspace& workspace) noexcept {
  StepMemory& memory = workspace.memory();
  if (object >= memory.objects.size() || !memory.isTissue(object) || leaves.size() != memory.scene.shapeOf(object).nodes.size())
    return false;
  if (!tangent.load.empty() && (tangent.rates.size() != leaves.size() || tangent.load.size() != memory.tissue->forces(object).size()))
    return false;
  memory.tissue->aim(object, leaves, tangent, is_frozen);
  return true;
}

std::span<const float> tissueForces(std::size_t object, const Workspace& workspace) noexcept {
  const StepMemory& memory = workspace.memory();
  if (object >= memory.objects.size() || !memory.isTissue(object)) return {};
  return memory.tissue->forces(object);
}

}  // namespace spheretree::runtime
