// SPDX-License-Identifier: Apache-2.0
// Soft tissue in a step: docs/runtime.md, Soft tissue.
#include <algorithm>
#include <cmath>
#include <utility>

#include "soft_rows.h"
#include "soft_surface.h"
#include "soft_tissue.h"
#include "spheretree/runtime/scene.h"
#include "spheretree/runtime/step.h"
#include "step_memory.h"

namespace spheretree::runtime {
namespace {

using Eigen::Vector3d;

constexpr double kDependentGive = 1e-9;  // share of the row's own compliance: a smaller remainder depends on the rows before it
constexpr double kAimSeconds = 0.04;     // time in which the surface covers most of the way to its target
constexpr double kSqueezed = 0.02;       // if the tool is deeper than this in something, it is squeezed, and tissue waits [mm]
constexpr double kAimMotion = 0.1;       // largest motion of a node towards its target in a step [mm]

class LinearTissue final : public SoftTissue {
 public:
  explicit LinearTissue(StepMemory& memory) : memory_(memory), scene_(memory.scene), part_(std::min(1.0, scene_.step_time / kAimSeconds)) {
    std::size_t nodes = 0;
    for (std::size_t i = 0; i < scene_.objects.size(); ++i) {
      const CompiledShape& shape = scene_.shapeOf(i);
      is_tissue_.push_back(shape.tissue != nullptr);
      frozen_.push_back(false);
      const auto* const model = static_cast<const SoftModel*>(shape.tissue.get());
      surfaces_.push_back(model ? std::make_unique<SoftSurface>(*model, shape) : nullptr);
      if (model) nodes = std::max(nodes, model->node_count);
    }
    rows_.resize(2 * (scene_.step_limits.max_pairs + std::size_t{16}));
    for (std::vector<double>& field : fields_) field.resize(3 * nodes);
    sum_.resize(3 * nodes);
  }

  void reset() override {
    std::fill(frozen_.begin(), frozen_.end(), false);
    for (std::size_t i = 0; i < surfaces_.size(); ++i)
      if (surfaces_[i]) surfaces_[i]->reset(), placeView(i);
  }
  bool isAtRest(std::size_t object) const override { return surfaces_[object]->isAtRest(); }
  std::uint32_t beginStep() override {
    const double most = memory_.depth > kSqueezed ? 0 : kAimMotion;  // while the tool cannot escape, it is not pressed in farther
    for (std::size_t i = 0; i < surfaces_.size(); ++i)
      if (surfaces_[i]) surfaces_[i]->beginStep(part_, most), placeView(i);
    return std::find(frozen_.begin(), frozen_.end(), true) == frozen_.end() ? kNoFault : kTissueFrozen;
  }
  void placeView(std::size_t object) override;
  void placePatches(const PairRun& run, const PairSet& set) override;
  float patchRows(const RowRequest& request) const override {
    return memory_.kernel == avx2Kernel() ? softRowsAvx2(request) : softRowsScalar(request);
  }
  bool solveRows(ContactQp& qp) const override { return solveRowsAlone(qp); }
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
  void begin(const PairSet& pairs, const PairSet& felt, const RowSet& rows, const Configuration& tool, bool is_carried) override;
  float stop(std::uint32_t row) const override { return rows_[row].stop; }
  void setRow(ContactQp& qp, int k, std::uint32_t object, std::uint32_t row, bool is_stop) override;
  void predict(const ContactQp& qp) override;
  float predictedBound(std::uint32_t row, bool& is_stop) const override;
  void press(const ContactQp& qp) override;
  bool aim(std::size_t object, std::span<const float> surface, bool is_frozen) override;
  std::span<const float> forces(std::size_t object) const override { return surfaces_[object]->forces(); }

 private:
  /// For each row that the QP may use.
  struct Row {
    SoftSurface* surface;
    SkinPoint point;  // the point of contact
    Vector3d normal;  // axes of the object
    double given;     // current displacement along the normal [mm]
    double weight;
    float b, stop;  // current right-hand side; and that at which the tissue has reached its largest displacement
  };
  // A row of the problem, and the coordinate that was made for it.
  struct Pressed {
    SoftSurface* surface = nullptr;  // null: rigid, or a stop
    SoftSurface::Press on;
    Vector3d pull{0, 0, 0};  // its force for a multiplier of 1, axes of the object [N]
  };
  struct Coordinate {
    Pressed row;
    std::array<double, kMostContactRows> factor{};
  };

  void addRows(const PairRun& run, const PairSet& set, std::uint32_t first, const RowSet& rows, const Configuration& tool);

  StepMemory& memory_;
  const CompiledScene& scene_;
  const double part_;                                   // share of the way to a target in a step
  std::vector<bool> frozen_;                            // (object) the solver that sets its target has failed
  std::vector<std::unique_ptr<SoftSurface>> surfaces_;  // (object) null: rigid
  std::vector<Row> rows_;                               // (row) of the rows on tissue
  bool is_carried_ = false;
  std::array<Pressed, kMostContactRows> pressed_;
  std::array<std::vector<double>, kMostContactRows> fields_;  // (row of the problem) displacements of the near nodes for a multiplier of 1
  std::array<Coordinate, kMostContactRows> coordinates_;
  std::vector<double> sum_;  // scratch
};

void LinearTissue::placeView(std::size_t object) {
  SoftSurface* const surface = surfaces_[object].get();
  if (!surface || !memory_.feelsSkin(object)) return;
  MovedSkin& skin = surface->skin();
  ObjectView& view = memory_.views[object];
  view.bound = skin.bound();
  view.patches = skin.patches();
  view.allowance = skin.allowance();
  view.points = skin.points();
  view.step = skin.step();
  view.is_found = false;
  view.motion = static_cast<float>(kTissueMotion);
  view.behind = static_cast<float>(kBehind);
  put(memory_.object_roots[object / 8], object % 8, memory_.objects[object].anchor, static_cast<float>(skin.radius() * (1 + 1e-6)));
}

void LinearTissue::placePatches(const PairRun& run, const PairSet& set) {
  surfaces_[run.object]->putPatches(set.pairs.subspan(run.begin, run.count));
  memory_.views[run.object].allowance = surfaces_[run.object]->skin().allowance();
  memory_.views[run.object].is_found = surfaces_[run.object]->skin().pointsStay();
}

void LinearTissue::begin(const PairSet& pairs, const PairSet& felt, const RowSet& rows, const Configuration& tool, bool is_carried) {
  is_carried_ = is_carried;
  for (Pressed& p : pressed_) p.surface = nullptr;
  for (const PairRun& run : pairs.runs)
    if (memory_.isTissue(run.object)) surfaces_[run.object]->forgetNear(), addRows(run, pairs, 0, rows, tool);
  for (const PairRun& run : felt.runs)
    if (memory_.isTissue(run.object)) addRows(run, felt, rows.guarded, rows, tool);
}

void LinearTissue::addRows(const PairRun& run, const PairSet& set, std::uint32_t first, const RowSet& rows, const Configuration& tool) {
  SoftSurface* const surface = surfaces_[run.object].get();
  const CompiledObject& object = memory_.objects[run.object];
  const Eigen::Matrix3d to_object = object.rotation.transpose(), turn = to_object * tool.orientation.toRotationMatrix();
  const Vector3d offset = to_object * (tool.position - object.anchor);
  for (std::uint32_t i = run.begin; i < run.begin + run.count; ++i) {
    const std::uint32_t pair = set.pairs[i], triangle = scene_.shapeOf(run.object).skin.tree.item[pair & 0xffff], row = first + i;
    Row& out = rows_[row];
    out.surface = surface;
    out.weight = static_cast<double>(rows.weight[row]);
    out.b = rows.b[row];
    out.normal = to_object * Vector3d(rows.rows.a[0][row], rows.rows.a[1][row], rows.rows.a[2][row]) / out.weight;
    if (const SoftPoint& known = surface->skin().points()[pair & 0xffff]; first > 0 && known.tool == pair >> 16) {
      const double u = static_cast<double>(known.u), v = static_cast<double>(known.v);
      out.point = {triangle, {1 - u - v, u, v}};
    } else {
      const Sphere& ball = scene_.tool.spheres[pair >> 16];
      const double beside = static_cast<double>(ball.radius) + std::max(-1.0, -static_cast<double>(out.b) / out.weight);
      out.point = surface->pointAt(triangle, turn * Vector3d(ball.x, ball.y, ball.z) + offset - std::min(beside, 1e6) * out.normal);
    }
    out.given = -out.normal.dot(surface->given(out.point));
    // A point moves no farther than mostGive() from its position at rest, in any direction.
    const Vector3d travelled = surface->travelled(out.point);
    const double pressed_in = -out.normal.dot(travelled), most = surface->mostGive(out.point),
                 room2 = most * most - (travelled.squaredNorm() - pressed_in * pressed_in);
    out.stop = out.b - static_cast<float>(out.weight * (room2 > 0 ? std::sqrt(room2) - pressed_in : 0));
    if (first == 0) surface->addNear(triangle);
  }
}

// The compliance of the surface at the points of the rows, as a Cholesky factor that grows by a row. A row whose
// displacement depends on those of the rows before it needs no coordinate of its own.
void LinearTissue::setRow(ContactQp& qp, int k, std::uint32_t object, std::uint32_t row, bool is_stop) {
  const auto at = static_cast<std::size_t>(k);
  Pressed& pressed = pressed_[at];
  std::array<double, kMostContactRows>& entry = qp.tissue[at];
  pressed.surface = nullptr;
  entry.fill(0);
  if (!memory_.isTissue(object)) return;
  const Row& on = rows_[row];
  ContactRow& r = qp.rows[at];
  if (is_stop) {
    r.b = static_cast<double>(on.stop);
    return;
  }
  const double stiffness = scene_.pull.translation;
  pressed = {on.surface, on.surface->pressOn(on.point), stiffness * on.weight * on.normal};
  if (!is_carried_)
    r.b += on.weight * on.given;  // the coordinates are relative to the shape at rest; in a carried piece, to the current shape
  on.surface->respond(pressed.on, pressed.pull, fields_[at]);
  const auto give = [&](const Pressed& other) { return other.pull.dot(on.surface->meanOf(other.on, fields_[at])) / stiffness; };
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
  for (const auto& surface : surfaces_) {
    if (!surface || surface->nearCount() == 0) continue;
    const std::size_t size = 3 * surface->nearCount();
    std::fill_n(sum_.begin(), size, 0.0);
    for (std::size_t k = 0; k < static_cast<std::size_t>(qp.row_count); ++k) {
      if (pressed_[k].surface != surface.get() || !(qp.rows[k].multiplier > 0)) continue;
      for (std::size_t i = 0; i < size; ++i) sum_[i] -= qp.rows[k].multiplier * fields_[k][i];
    }
    surface->predict(sum_);
  }
}

float LinearTissue::predictedBound(std::uint32_t row, bool& is_stop) const {
  const Row& on = rows_[row];
  const double then = -on.normal.dot(on.surface->predicted(on.point)), more = is_carried_ ? then : then - on.given;
  const float bound = on.b - static_cast<float>(on.weight * more);
  is_stop = on.stop > bound;
  return std::max(bound, on.stop);
}

void LinearTissue::press(const ContactQp& qp) {
  for (const auto& s : surfaces_)
    if (s) s->aimAt(is_carried_);
  for (std::size_t k = 0; k < static_cast<std::size_t>(qp.row_count); ++k)
    if (const Pressed& p = pressed_[k]; p.surface && qp.rows[k].multiplier > 0) p.surface->press(p.on, -qp.rows[k].multiplier * p.pull);
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
