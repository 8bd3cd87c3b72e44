// SPDX-License-Identifier: Apache-2.0
// Soft tissue in a step: docs/runtime.md, Soft tissue.
#include <algorithm>
#include <cmath>
#include <utility>

#include "contact/contact_problem.h"
#include "rows/row_set.h"
#include "search/find_pairs.h"
#include "spheretree/runtime/scene.h"
#include "spheretree/runtime/step.h"
#include "state/soft_tissue.h"
#include "state/step_memory.h"
#include "tissue/soft_rows.h"
#include "tissue/soft_surface.h"

namespace spheretree::runtime {
namespace {

using Eigen::Vector3d;

constexpr double kAimSeconds = 0.04;  // time in which the surface covers most of the way to its target
constexpr double kSticks = 1 - 1e-6;  // share of its friction limit: with less, a contact does not slip
constexpr double kSqueezed = 0.02;    // if the tool is deeper than this in something, it is squeezed, and tissue waits [mm]
constexpr double kAimMotion = 0.1;    // largest motion of a node towards its target in a step [mm]

class LinearTissue final : public SoftTissue {
 public:
  explicit LinearTissue(StepMemory& memory)
      : memory_(memory),
        scene_(memory.scene),
        kernel_(memory.kernel == &scalarKernel() ? scalarSoftKernel() : avx2SoftKernel()),
        share_(std::min(1.0, scene_.step_time / kAimSeconds)) {
    std::size_t nodes = 0;
    for (std::size_t i = 0; i < scene_.objects.size(); ++i) {
      const CompiledShape& shape = scene_.shapeOf(i);
      is_tissue_.push_back(shape.tissue != nullptr);
      frozen_.push_back(false);
      const auto* const model = static_cast<const SoftModel*>(shape.tissue.get());
      surfaces_.push_back(model ? std::make_unique<SoftSurface>(*model, shape) : nullptr);
      if (model) nodes = std::max(nodes, model->node_count);
    }
    in_front_.resize(scene_.tool.spheres.size());
    rows_.resize(2 * (scene_.step_limits.max_pairs + std::size_t{16}));
    for (std::vector<Eigen::Matrix3d>& response : responses_) response.resize(nodes);
    for (std::vector<double>& field : fields_) field.resize(3 * nodes);
    sum_.resize(3 * nodes);
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
  const SurfaceCompliance& compliance() const override { return compliance_; }
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
  void begin(const PairSet& pairs, const PairSet& felt, const RowSet& rows, const Configuration& tool, bool is_carried) override;
  float stop(std::uint32_t row) const override { return rows_[row].stop; }
  void setRow(ContactProblem& qp, int k, std::uint32_t object, std::uint32_t row, bool is_stop) override;
  void setDisc(ContactProblem& qp, int d, std::uint32_t object, std::uint32_t row, bool is_stop,
               const std::array<Vector3d, 2>& along) override;
  void predict(const ContactProblem& qp) override;
  float predictedBound(std::uint32_t row, bool& is_stop) const override;
  void press(const ContactProblem& qp, std::span<const std::uint32_t> contacts) override;
  void setStuck(const ContactProblem& qp, std::size_t d, std::uint32_t row, double limit) override {
    const Row& on = rows_[row];
    if (is_carried_ || !pressed_[forceOf(d, 0)].surface || !on.is_felt) return;
    const std::array<double, 2>& force = qp.discs[d].force;
    on.surface->skin().setStuck(on.pair, std::hypot(force[0], force[1]) < kSticks * limit);
  }
  Vector3d movedInStep(std::size_t object, std::size_t k) const override {
    return memory_.objects[object].rotation * surfaces_[object]->movedInStep(contacts_[k]);
  }
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
    std::uint32_t pair;
    bool is_felt;  // the row of the patch, not of the flat triangle
  };
  // A force of the problem.
  struct Pressed {
    SoftSurface* surface = nullptr;  // null: rigid, or a stop
    SoftSurface::Press on;
    Vector3d pull{0, 0, 0};  // its force for a multiplier of 1, axes of the object [N]
  };

  void addRows(const PairRun& run, const PairSet& set, std::uint32_t first, const RowSet& rows, const Configuration& tool);
  void addForce(const ContactProblem& qp, std::size_t force, std::size_t row);
  /// Calls `work` with each force and its multiplier.
  template <class Work>
  void forForces(const ContactProblem& qp, const Work& work) const {
    for (std::size_t k = 0; k < static_cast<std::size_t>(qp.row_count); ++k) work(k, qp.rows[k].multiplier);
    for (std::size_t d = 0; d < static_cast<std::size_t>(qp.disc_count); ++d)
      for (std::size_t axis = 0; axis < 2; ++axis) work(forceOf(d, axis), qp.discs[d].force[axis]);
  }

  StepMemory& memory_;
  const CompiledScene& scene_;
  const SoftKernel& kernel_;
  const double share_;                                  // share of the way to a target in a step
  double motion_ = kTissueMotion;                       // largest motion of a point in this step by forces [mm]
  bool waits_ = false;                                  // after takeBack()
  std::vector<bool> frozen_;                            // (object) the solver that sets its target has failed
  std::vector<std::unique_ptr<SoftSurface>> surfaces_;  // (object) null: rigid
  std::vector<float> in_front_;                         // of the views
  std::vector<Row> rows_;                               // (row) of the rows on tissue
  std::array<SkinPoint, kMaxContactRows> contacts_;     // of the step
  bool is_carried_ = false;
  std::array<Pressed, kMaxForces> pressed_;
  std::array<std::vector<Eigen::Matrix3d>, kMaxContactRows> responses_;  // (row) of the near nodes, to a force at its point
  std::array<std::vector<double>, kMaxForces> fields_;                   // (force) displacements of the near nodes for a multiplier of 1
  SurfaceCompliance compliance_{};
  std::vector<double> sum_;  // scratch
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
    out.pair = pair;
    out.is_felt = first > 0;
    out.weight = static_cast<double>(rows.weight[row]);
    out.b = rows.b[row];
    out.normal = to_object * Vector3d(rows.rows.a[0][row], rows.rows.a[1][row], rows.rows.a[2][row]) / out.weight;
    if (const SoftPoint& known = pointOf(surface->skin().points(), pair); out.is_felt && known.pair == pair) {
      const double u = static_cast<double>(known.u), v = static_cast<double>(known.v);
      out.point = {triangle, {1 - u - v, u, v}};
    } else {
      const Sphere& ball = scene_.tool.spheres[pair >> 16];
      const double beside = static_cast<double>(ball.radius) + std::max(-1.0, -static_cast<double>(out.b) / out.weight);
      out.point = surface->pointAt(triangle, turn * Vector3d(ball.x, ball.y, ball.z) + offset - std::min(beside, 1e6) * out.normal);
    }
    out.given = -out.normal.dot(surface->given(out.point));
    // A point moves no farther than maxGive() from its position at rest, in any direction.
    const Vector3d travelled = surface->travelled(out.point);
    const double pressed_in = -out.normal.dot(travelled), max_give = surface->maxGive(out.point),
                 room2 = max_give * max_give - (travelled.squaredNorm() - pressed_in * pressed_in);
    out.stop = out.b - static_cast<float>(out.weight * (room2 > 0 ? std::sqrt(room2) - pressed_in : 0));
    if (first == 0) surface->addNear(triangle);
  }
}

// The compliance of the surface between this force, which acts at the point of a row, and the others.
void LinearTissue::addForce(const ContactProblem& qp, std::size_t force, std::size_t row) {
  const Pressed& pressed = pressed_[force];
  if (pressed.surface)
    for (std::size_t i = 0; i < pressed.surface->nearCount(); ++i)
      Eigen::Map<Vector3d>(fields_[force].data() + 3 * i) = responses_[row][i] * pressed.pull;
  forForces(qp, [&](std::size_t i, double) {
    const Pressed& other = pressed_[i];
    const bool is_shared = pressed.surface && other.surface == pressed.surface;
    const double give = is_shared ? other.pull.dot(pressed.surface->meanOf(other.on, fields_[force])) / scene_.pull.translation : 0;
    compliance_[force][i] = compliance_[i][force] = give;
  });
}

void LinearTissue::setRow(ContactProblem& qp, int k, std::uint32_t object, std::uint32_t row, bool is_stop) {
  const auto at = static_cast<std::size_t>(k);
  Pressed& pressed = pressed_[at];
  pressed.surface = nullptr;
  if (memory_.isTissue(object)) {
    const Row& on = rows_[row];
    ContactRow& r = qp.rows[at];
    if (is_stop) {
      r.b = static_cast<double>(on.stop);
    } else {
      pressed = {on.surface, on.surface->pressOn(on.point), scene_.pull.translation * on.weight * on.normal};
      on.surface->respond(pressed.on, responses_[at]);
    }
    if (!is_stop && !is_carried_)
      r.b += on.weight * on.given;  // forces are relative to the shape at rest; in a carried piece, to the current shape
  }
  addForce(qp, at, at);
}

// A contact moves the surface in tangential directions, too. It slips by the rest of its motion.
void LinearTissue::setDisc(ContactProblem& qp, int d, std::uint32_t object, std::uint32_t row, bool is_stop,
                           const std::array<Vector3d, 2>& along) {
  const auto at = static_cast<std::size_t>(d), of = static_cast<std::size_t>(qp.discs[at].row);
  for (std::size_t axis = 0; axis < 2; ++axis) pressed_[forceOf(at, axis)].surface = nullptr;
  if (memory_.isTissue(object) && !is_stop) {
    const Row& on = rows_[row];
    const Vector3d start = is_carried_ ? Vector3d(Vector3d::Zero()) : on.surface->given(on.point),
                   moved = on.surface->ahead(on.point) - start;
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const Vector3d t = memory_.objects[object].rotation.transpose() * along[axis];
      pressed_[forceOf(at, axis)] = {on.surface, pressed_[of].on, scene_.pull.translation * t};
      qp.discs[at].origin[axis] += t.dot(moved);
    }
  }
  for (std::size_t axis = 0; axis < 2; ++axis) addForce(qp, forceOf(at, axis), of);
}

void LinearTissue::predict(const ContactProblem& qp) {
  for (const auto& surface : surfaces_) {
    if (!surface || surface->nearCount() == 0) continue;
    const std::size_t size = 3 * surface->nearCount();
    std::fill_n(sum_.begin(), size, 0.0);
    forForces(qp, [&](std::size_t force, double multiplier) {
      if (pressed_[force].surface != surface.get() || multiplier == 0) return;
      for (std::size_t i = 0; i < size; ++i) sum_[i] -= multiplier * fields_[force][i];
    });
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

void LinearTissue::press(const ContactProblem& qp, std::span<const std::uint32_t> contacts) {
  for (std::size_t k = 0; k < contacts.size(); ++k) contacts_[k] = rows_[contacts[k]].point;
  for (const auto& s : surfaces_)
    if (s) s->aimAt(is_carried_);
  forForces(qp, [&](std::size_t force, double multiplier) {
    if (const Pressed& p = pressed_[force]; p.surface && multiplier != 0) p.surface->press(p.on, -multiplier * p.pull);
  });
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
