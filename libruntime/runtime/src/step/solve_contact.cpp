// SPDX-License-Identifier: Apache-2.0
// The contact problem of a piece if contacts have friction or objects yield: docs/runtime.md, Friction and Objects that
// give way.
#include <algorithm>
#include <cmath>

#include "contact/contact_forces.h"
#include "state/moving_bodies.h"
#include "step/step_parts.h"

namespace spheretree::runtime {
namespace {

constexpr int kMaxScans = 36;             // rows that enter
constexpr int kMaxNewRows = 4;            // that join the rows of the last piece before the QP without friction is asked
constexpr double kForceTolerance = 1e-6;  // of the residuals: gaps are floats and not known more accurately [mm, scaled]
constexpr double kMaxGive = 0.5;          // share of the smallest distance of two centres: limit by which an object yields
constexpr float kOutOfTheWay = -1e30f;

struct Tangents {
  Eigen::Vector3d first, second;
};

// Two tangents that are perpendicular to the unit vector `n` and to each other.
// Paper: T. Duff et al. Building an orthonormal basis, revisited. Journal of Computer Graphics Techniques 6(1), 2017.
Tangents tangentsOf(const Eigen::Vector3d& n) {
  const double sign = std::copysign(1.0, n[2]), a = -1 / (sign + n[2]), b = n[0] * n[1] * a;
  return {{1 + sign * n[0] * n[0] * a, sign * b, -sign * n[0]}, {b, sign + n[1] * n[1] * a, -n[1]}};
}

class ContactSolver {
 public:
  ContactSolver(StepParts& parts, const PairSet& pairs, RowSet& rows, const Vector6& target, const CarriedPiece* carried)
      : parts_(parts),
        scene_(parts.scene),
        memory_(parts.memory),
        pairs_(pairs),
        rows_(rows),
        target_(target),
        carried_(carried),
        rotation_(parts.contact_pose.orientation.toRotationMatrix()),
        problem_(*parts.memory.contact_problem) {}

  double run();

 private:
  bool isSoft(std::uint32_t object) const { return scene_.objects[object].softness > 0 || memory_.isTissue(object); }
  template <class Work>
  void forSoftRows(const Work& work);
  [[gnu::noinline]] void restoreSoft();
  [[gnu::noinline]] void start();
  bool holdsAsBefore();
  void predict();
  int takeIn(std::uint32_t row, double multiplier, bool is_stop = false);
  [[gnu::noinline]] int placeOf(std::uint32_t row, bool is_stop) const;
  int groupOf(std::uint32_t object);
  void addDisc(int k, const RowName& name);
  bool takeInViolated();
  [[gnu::noinline]] void solve();
  void keep();

  StepParts& parts_;
  const CompiledScene& scene_;
  StepMemory& memory_;
  const PairSet& pairs_;
  RowSet& rows_;
  const Vector6 target_;
  const CarriedPiece* carried_;
  const Eigen::Matrix3d rotation_;  // of the tool, where the rows were made
  ContactProblem& problem_;
  std::array<std::uint32_t, kMaxContactRows> row_;  // index in the scan, of each row of the problem
  std::array<double, kMaxContactRows> pressed_;     // initial multipliers
  std::array<int, kMaxContactRows> disc_;           // of each row, or -1
  std::array<double, kMaxContactRows> friction_;    // coefficient times weight, for each disc's row
  std::array<Tangents, kMaxContactRows> tangents_;  // of each disc
  std::array<std::uint32_t, kMaxGroups> group_object_{};
  std::array<double, kMaxGroups> group_scale_{};  // [mm] of the object for each mm of the coordinate
  std::array<bool, kMaxContactRows> is_stop_;     // for each row: of tissue that has reached its largest displacement
};

template <class Work>
void ContactSolver::forSoftRows(const Work& work) {
  const auto of = [&](const PairSet& set, std::uint32_t first) {
    for (const PairRun& run : set.runs)
      if (isSoft(run.object))
        for (std::uint32_t i = first + run.begin; i < first + run.begin + run.count; ++i) work(run.object, i);
  };
  of(pairs_, 0);
  of(parts_.felt(), rows_.guarded);
}

void ContactSolver::restoreSoft() {
  if (scene_.has_soft) forSoftRows([&](std::uint32_t, std::uint32_t i) { rows_.b[i] = memory_.soft_b[i]; });
}

// The index of a row in the problem; -1: it is not in it.
int ContactSolver::placeOf(std::uint32_t row, bool is_stop) const {
  int k = problem_.row_count;
  while (--k >= 0)
    if (row_[static_cast<std::size_t>(k)] == row && is_stop_[static_cast<std::size_t>(k)] == is_stop) break;
  return k;
}

int ContactSolver::groupOf(std::uint32_t object) {
  for (int g = 0; g < problem_.group_count; ++g)
    if (group_object_[static_cast<std::size_t>(g)] == object) return g;
  if (problem_.group_count == kMaxGroups || problem_.row_count == kMaxContactRows) return -1;
  const int g = problem_.group_count++;
  const auto at = static_cast<std::size_t>(g);
  group_object_[at] = object;
  group_scale_[at] = scene_.objects[object].softness;
  problem_.given[at] = memory_.give[object] / group_scale_[at];
  problem_.rest[at] = carried_ ? problem_.given[at] : 0;
  ContactRow& bound = problem_.rows[static_cast<std::size_t>(problem_.row_count)];
  bound = {};
  bound.group = g;
  bound.give = -1;
  bound.b = -kMaxGive * scene_.min_contact / group_scale_[at];
  pressed_[static_cast<std::size_t>(problem_.row_count)] = 0;
  row_[static_cast<std::size_t>(problem_.row_count)] = ~0u;
  is_stop_[static_cast<std::size_t>(problem_.row_count)] = false;
  disc_[static_cast<std::size_t>(problem_.row_count++)] = -1;
  if (memory_.tissue) memory_.tissue->setRow(problem_, problem_.row_count - 1, object, ~0u, false);
  return g;
}

// Adds a row to the problem and returns its index; -1: the problem is full.
int ContactSolver::takeIn(std::uint32_t row, double multiplier, bool is_stop) {
  if (const int known = placeOf(row, is_stop); known >= 0) return known;
  const RowName name = parts_.nameOfRow(pairs_, row);
  const int group = scene_.objects[name.object].softness > 0 ? groupOf(name.object) : -1;
  int k = problem_.row_count;
  if (k == kMaxContactRows) {  // replaces a row without force and friction
    for (k = 0; k < problem_.row_count; ++k) {
      const auto at = static_cast<std::size_t>(k);
      if (problem_.rows[at].multiplier == 0 && disc_[at] < 0 && row_[at] != ~0u) break;
    }
    if (k == problem_.row_count) return -1;
  } else {
    ++problem_.row_count;
  }
  const auto at = static_cast<std::size_t>(k);
  ContactRow& r = problem_.rows[at];
  for (std::size_t i = 0; i < 6; ++i) r.a[static_cast<Eigen::Index>(i)] = static_cast<double>(rows_.rows.a[i][row]);
  r.group = -1;
  r.give = 0;
  r.b = static_cast<double>(rows_.b[row]);
  r.multiplier = pressed_[at] = multiplier;
  if (group >= 0) {
    r.group = group;
    r.give = static_cast<double>(rows_.weight[row]) * group_scale_[static_cast<std::size_t>(group)];
    // The row is made for the object as it yields now; the coordinate is relative to its shape without force.
    r.b += static_cast<double>(rows_.weight[row]) * memory_.give[name.object];
  }
  row_[at] = row;
  disc_[at] = -1;
  is_stop_[at] = is_stop;
  if (memory_.tissue) memory_.tissue->setRow(problem_, k, name.object, row, is_stop);
  if (parts_.rubs && scene_.objects[name.object].friction > 0) addDisc(k, name);
  return k;
}

void ContactSolver::addDisc(int k, const RowName& name) {
  const auto at = static_cast<std::size_t>(k), d = static_cast<std::size_t>(problem_.disc_count++);
  const double weight = static_cast<double>(rows_.weight[row_[at]]);
  const Eigen::Vector3d* const rubbing = parts_.rubbingOf(name);
  const Eigen::Vector3d normal = problem_.rows[at].a.head<3>() / weight, arm = parts_.armOf(rows_, row_[at], name, normal, rotation_),
                        force = rubbing ? *rubbing : Eigen::Vector3d::Zero();
  disc_[at] = static_cast<int>(d);
  const Tangents& t = tangents_[d] = tangentsOf(normal);
  friction_[d] = scene_.objects[name.object].friction * weight;
  FrictionDisc& disc = problem_.discs[d];
  disc.row = k;
  disc.friction = carried_ ? 0 : friction_[d];  // while bodies move, contact forces stay those of before
  disc.radius = friction_[d] * problem_.rows[at].multiplier;
  for (std::size_t i = 0; i < 2; ++i) {
    const double* const along = (i == 0 ? t.first : t.second).data();
    double* const across = disc.across[i].data();
    for (int j = 0; j < 3; ++j) {
      const int next = (j + 1) % 3, last = (j + 2) % 3;
      across[j] = along[j];
      across[3 + j] = (arm[next] * along[last] - arm[last] * along[next]) / scene_.angle_length;
    }
    disc.force[i] = force[0] * along[0] + force[1] * along[1] + force[2] * along[2];
    disc.origin[i] = 0;
  }
  const MovingBody& body = memory_.bodies[memory_.objects[name.object].body];
  if (carried_ && body.moves) {
    const Vector6 z = parts_.scaledVector(motionAt(body, carried_->share, parts_.contact_pose.position));
    for (std::size_t i = 0; i < 2; ++i) disc.origin[i] = disc.across[i].dot(z);
  }
  if (memory_.tissue) memory_.tissue->setDisc(problem_, static_cast<int>(d), name.object, row_[at], is_stop_[at], {t.first, t.second});
}

// Adds the previously active rows, with their multipliers.
void ContactSolver::start() {
  problem_.row_count = problem_.disc_count = problem_.group_count = 0;
  problem_.target = target_;
  problem_.tolerance = kForceTolerance;
  for (std::size_t k = 0; k < memory_.active_count; ++k) {
    const std::uint32_t row = parts_.rowOf(pairs_, memory_.active_names[k]);
    if (row != ~0u) takeIn(row, memory_.active_multiplier[k]);
  }
}

// Whether the previous contacts still hold the tool, and no other: then no prediction is needed.
bool ContactSolver::holdsAsBefore() {
  if (carried_ || scene_.has_soft || !parts_.rubs || memory_.active_count == 0) return false;
  start();
  for (int scan = 0; scan < kMaxNewRows; ++scan) {
    solve();
    if (!problem_.converged) return false;
    if (!takeInViolated()) return true;
  }
  return false;
}

// Adds the active rows of the QP without friction, with the multipliers that it predicts.
void ContactSolver::predict() {
  const QpAnswer& predicted = memory_.answer;
  for (std::size_t k = 0; k < predicted.active_count; ++k)
    takeIn(predicted.active[k], carried_ ? 0 : predicted.multiplier[k],
           memory_.isTissue(parts_.nameOfRow(pairs_, predicted.active[k]).object));
}

// Adds the row that the solution violates most; false if there is none, or no space for it.
bool ContactSolver::takeInViolated() {
  if (memory_.tissue) memory_.tissue->predict(problem_);
  if (scene_.has_soft)
    forSoftRows([&](std::uint32_t object, std::uint32_t i) {
      bool is_at_stop = false;
      if (memory_.isTissue(object)) {
        rows_.b[i] = memory_.tissue->predictedBound(i, is_at_stop);
        return;
      }
      double give = 0;
      for (int g = 0; g < problem_.group_count; ++g)
        if (group_object_[static_cast<std::size_t>(g)] == object)
          give = problem_.given[static_cast<std::size_t>(g)] * group_scale_[static_cast<std::size_t>(g)];
      rows_.b[i] = memory_.soft_b[i] + static_cast<float>(memory_.give[object] - give) * rows_.weight[i];
    });
  float y[6];
  double largest = 0;
  for (std::size_t k = 0; k < 6; ++k) {
    y[k] = static_cast<float>(problem_.y[static_cast<Eigen::Index>(k)]);
    largest = std::max(largest, std::abs(problem_.y[static_cast<Eigen::Index>(k)]));
  }
  const WorstRow worst = memory_.kernel->worstRow(rows_.rows.a.data(), rows_.rows.b, rows_.rows.count, y);
  parts_.result.work += (rows_.rows.count + 7) / 8;
  bool is_violated = static_cast<double>(worst.slack) < -(kQpTolerance + 1e-6 * largest), is_stop = false;
  if (memory_.tissue && is_violated) {
    const std::uint32_t object = parts_.nameOfRow(pairs_, worst.row).object;
    if (memory_.isTissue(object)) (void)memory_.tissue->predictedBound(worst.row, is_stop);
  }
  is_violated = is_violated && placeOf(worst.row, is_stop) < 0;
  restoreSoft();
  return is_violated && takeIn(worst.row, 0, is_stop) >= 0;
}

void ContactSolver::solve() {
  const std::uint32_t max_work = scene_.step_limits.max_work / 2;  // beyond which a hard problem takes its best forces
  parts_.result.work += solveForces(problem_, memory_.tissue ? &memory_.tissue->compliance() : nullptr, max_work);
  parts_.result.qp_iterations += static_cast<std::uint32_t>(problem_.iterations);
}

void ContactSolver::keep() {
  QpAnswer& answer = memory_.answer;
  answer.y = problem_.y;
  answer.active_count = 0;
  for (int k = 0; k < problem_.row_count; ++k) {
    const auto at = static_cast<std::size_t>(k);
    const double multiplier = carried_ ? pressed_[at] : problem_.rows[at].multiplier;
    if (!(multiplier > 1e-12) || row_[at] == ~0u) continue;
    std::size_t slot = 0;  // a row of tissue and its stop are one contact
    while (slot < answer.active_count && answer.active[slot] != row_[at]) ++slot;
    if (slot == answer.active_count) {
      ++answer.active_count;
      answer.active[slot] = row_[at];
      answer.multiplier[slot] = 0;
      memory_.active_rubbing[slot].setZero();
    }
    answer.multiplier[slot] += multiplier;
    if (disc_[at] < 0) continue;
    const auto d = static_cast<std::size_t>(disc_[at]);
    if (memory_.tissue) memory_.tissue->setStuck(problem_, d, row_[at], friction_[d] * multiplier);
    memory_.active_rubbing[slot] += problem_.discs[d].force[0] * tangents_[d].first + problem_.discs[d].force[1] * tangents_[d].second;
  }
  parts_.result.active = answer.active_count;
  parts_.result.unsolved += problem_.converged ? 0 : 1;
  if (memory_.tissue) memory_.tissue->press(problem_, {answer.active.data(), answer.active_count});
  for (std::size_t i = 0; i < memory_.give.size(); ++i) {
    memory_.give_from[i] = memory_.give[i];
    memory_.give_to[i] = 0;
  }
  for (int g = 0; g < problem_.group_count; ++g) {
    const auto at = static_cast<std::size_t>(g);
    memory_.give_to[group_object_[at]] = std::max(0.0, problem_.given[at] * group_scale_[at]);
  }
}

double ContactSolver::run() {
  if (memory_.tissue) memory_.tissue->begin(pairs_, parts_.felt(), rows_, parts_.contact_pose, carried_ != nullptr);
  if (scene_.has_soft)
    forSoftRows([&](std::uint32_t object, std::uint32_t i) {
      memory_.soft_b[i] = rows_.b[i];
      rows_.b[i] = memory_.isTissue(object) ? memory_.tissue->stop(i) : kOutOfTheWay;
    });
  double back = 0;
  if (holdsAsBefore()) {
    memory_.answer.status = QpStatus::Optimal;
  } else {
    back = parts_.solve(rows_, target_);
    restoreSoft();
    if (memory_.answer.status != QpStatus::Optimal) return back;
    start();
    predict();
    for (int scan = 0; scan < kMaxScans; ++scan) {
      solve();
      if (!problem_.converged || !takeInViolated()) break;
    }
  }
  keep();
  return back;
}

}  // namespace

double StepParts::solveContact(const PairSet& pairs, RowSet& rows, const Vector6& target, const Configuration& at,
                               const CarriedPiece* carried) {
  contact_pose = at;
  return ContactSolver(*this, pairs, rows, target, carried).run();
}

void StepParts::giveWay(double share) {
  for (std::size_t i = 0; i < memory.give.size(); ++i)
    memory.give[i] = memory.give_from[i] + share * (memory.give_to[i] - memory.give_from[i]);
  if (memory.tissue) memory.tissue->giveWay(share);
}

void StepParts::letGo() {
  std::fill(memory.give.begin(), memory.give.end(), 0.0);
  if (memory.tissue) memory.tissue->letGo();
}

void StepParts::shiftSoft(const PairSet& set, std::uint32_t first, RowSet& rows) const {
  for (const PairRun& run : set.runs) {
    const auto give = static_cast<float>(memory.give[run.object]);
    if (!(give > 0)) continue;
    for (std::uint32_t i = first + run.begin; i < first + run.begin + run.count; ++i) rows.b[i] -= give * rows.weight[i];
  }
  float smallest = std::numeric_limits<float>::infinity();
  for (std::uint32_t i = first; i < first + static_cast<std::uint32_t>(set.pairs.size()); ++i)
    if (rows.weight[i] > 0) smallest = std::min(smallest, -rows.b[i] / rows.weight[i]);
  (first == 0 ? rows.smallest_gap : rows.smallest_felt_gap) = smallest;
}

}  // namespace spheretree::runtime
