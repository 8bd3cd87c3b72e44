// SPDX-License-Identifier: Apache-2.0
#include "spheretree/runtime/step.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "kernel.h"
#include "spheretree/runtime/collide.h"
#include "spheretree/runtime/contact.h"
#include "spheretree/runtime/force.h"
#include "spheretree/runtime/qp6.h"

namespace spheretree::runtime {
namespace {

constexpr double kPathTolerance = 0.01;  // deepest a leaf may dip in the middle of a step [mm]
constexpr double kLeastMargin = 0.01;    // [mm]
constexpr double kContactMargin = 1;     // most with something near: beyond, searching again is cheaper than the rows of far pairs [mm]
constexpr double kConverged = 2e-5;      // the graphic tool rests if the next step would be shorter [mm, scaled]
constexpr double kRounding = 3e-4;       // steps below this that no longer shrink are float rounding of the gaps [mm, scaled]
constexpr double kForceStep = 0.1;       // [N] a change of force by less than this, or by the part below, is hardly felt
constexpr double kForceStepPart = 0.07;  // of the force
constexpr int kMostLinearisations = 48;  // of one step
constexpr int kMostRelaxations = 16;     // of one QP with rows that conflict
constexpr int kMostHalvings = 5;
constexpr double kPiecesAhead = 8;  // that the pairs in the list are meant to last for
constexpr int kPatience = 8;        // pieces that bring the graphic tool
constexpr double kProgress = 1e-3;  // nearer by less than this are the last of a step: it goes to and fro [mm, scaled]

constexpr double kFarthest = 1e7;  // of a haptic pose from the origin [mm]

class Stage {
 public:
  explicit Stage(std::uint64_t* total) : total_(total), start_(total ? now() : 0) {}
  ~Stage() {
    if (total_) *total_ += now() - start_;
  }
  Stage(const Stage&) = delete;
  Stage& operator=(const Stage&) = delete;

 private:
  static std::uint64_t now() {
    return static_cast<std::uint64_t>(
        std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch()).count());
  }
  std::uint64_t* total_;
  std::uint64_t start_;
};

Displacement scaled(const Displacement& d, double factor) { return {factor * d.translation, factor * d.rotation}; }

// Searches, rows and QPs of one step, with their counts.
class Stepper {
 public:
  Stepper(const Scene& scene, Workspace& workspace, StageTimes* times, StepResult& result)
      : scene_(scene), workspace_(workspace), times_(times), result_(result) {}

  bool workLeft() const { return result_.work < scene_.step_limits.max_work; }

  PairSet search(const Configuration& pose, double margin, bool exact) {
    const Stage stage(times_ ? &times_->find : nullptr);
    const std::uint32_t most = scene_.step_limits.max_work;
    const PairSet set = findPairs(scene_, pose, margin, exact, most > result_.work ? most - result_.work : 0, workspace_);
    result_.work += set.work;
    ++result_.searches;
    result_.pairs = static_cast<std::uint32_t>(set.pairs.size());
    return set;
  }

  RowSet rows(const PairSet& set, const Configuration& pose, RowForm form, const Eigen::Matrix3d& axes) {
    const Stage stage(times_ ? &times_->rows : nullptr);
    result_.work += 2 * groups(set.pairs.size());
    ++result_.linearisations;
    result_.rows = static_cast<std::uint32_t>(set.pairs.size());
    return makeRows(scene_, set, pose, form, axes, workspace_);
  }
  RowSet rows(const PairSet& set, const Configuration& pose) { return rows(set, pose, RowForm::TrueDistance, Eigen::Matrix3d::Identity()); }

  // The bridges that can be touched within `margin` of a pose at which search() was not coarse.
  void searchBridges(const Configuration& pose, double margin) {
    bridges_ = {};
    if (scene_.bridges.empty()) return;
    const Stage stage(times_ ? &times_->find : nullptr);
    const std::uint32_t most = scene_.step_limits.max_work;
    bridges_ = findNearBridges(scene_, pose, margin, most > result_.work ? most - result_.work : 0, workspace_);
    result_.work += bridges_.work;
  }
  // Only what is within `margin` of the pose at which `rows` were made stays; the active rows keep their names.
  void narrowTo(double margin, const RowSet& rows, const Configuration& pose, PairSet& set) {
    const Stage stage(times_ ? &times_->find : nullptr);
    result_.work += groups(set.pairs.size()) + 3 * groups(bridges_.pairs.size());
    narrow(scene_, rows, pose, margin, set, bridges_, workspace_);
    findActive(set);
  }
  bool isFree(const PairSet& set) const { return set.pairs.empty() && bridges_.pairs.empty(); }

  // Rows of pairs and of bridges.
  RowSet allRows(const PairSet& set, const Configuration& pose, double margin) {
    RowSet out = rows(set, pose);
    const Stage stage(times_ ? &times_->rows : nullptr);
    addBridgeRows(scene_, bridges_, pose, margin, out, workspace_);
    result_.rows = out.rows.count;
    result_.work += 3 * groups(bridges_.pairs.size());
    return out;
  }

  // The point nearest to `target` that all rows allow. Rows that contradict each other are moved back by the same distance [mm], the least
  // that lets them agree: those of bridges first, for they are there for comfort only, and then all. Returns the distance of the latter.
  // Each certificate is a lower bound of it (its rows, moved back by less, still contradict each other), and the first bound at which the
  // QP has an answer is therefore the least.
  double solve(const RowSet& set, const Vector6& target) {
    const Stage stage(times_ ? &times_->qp : nullptr);
    QpAnswer& answer = workspace_.answer;
    double back = 0;
    for (int round = 0;; ++round) {
      solveQp6(*workspace_.kernel, set.rows, target, answer);
      result_.qp_iterations += answer.iterations;
      result_.work += (answer.iterations + 1u) * groups(set.rows.count);
      if (answer.status != QpStatus::Infeasible) break;
      float* const b = const_cast<float*>(set.rows.b);  // the workspace's own row memory
      if (round == kMostRelaxations || !workLeft()) {
        // No time to find the least. Where the rows forbid even to stay, allow staying: then y = 0 satisfies all.
        for (std::uint32_t i = 0; i < set.rows.count; ++i) b[i] = std::min(b[i], 0.0f);
        solveQp6(*workspace_.kernel, set.rows, target, answer);
        back = std::max(back, static_cast<double>(-set.smallest_gap));
        break;
      }
      double sum = 0, weights = 0, bridge_weights = 0;
      for (std::size_t k = 0; k < answer.certificate_count; ++k) {
        const double weight = answer.certificate_weight[k] * static_cast<double>(set.weight[answer.certificate[k]]);
        sum += answer.certificate_weight[k] * static_cast<double>(b[answer.certificate[k]]);
        (answer.certificate[k] < set.leaf_count ? weights : bridge_weights) += weight;
      }
      const bool bridges_alone = bridge_weights > 0;
      const double further = std::max(sum / (bridges_alone ? bridge_weights : weights), 1e-6) * (1 + 1e-6);
      for (std::uint32_t i = bridges_alone ? set.leaf_count : 0; i < set.rows.count; ++i)
        b[i] -= static_cast<float>(further) * set.weight[i];
      if (!bridges_alone) back += further;
    }
    if (answer.status == QpStatus::IterationLimit) {
      result_.faults |= kQpStopped;
      answer.y.setZero();
      answer.active_count = 0;
    }
    if (back > kGapTolerance) result_.faults |= kRowsConflict;
    result_.active = answer.active_count;
    return back;
  }

  static PairName nameOf(const PairSet& set, std::uint32_t row) {
    const PairRun* run = set.runs.data();
    while (row >= run->begin + run->count) ++run;
    return {run->object, set.pairs[row], false};
  }
  // Names of the active rows, which the next step starts from.
  void keepActive(const PairSet& set) {
    workspace_.active_count = workspace_.answer.active_count;
    for (std::size_t k = 0; k < workspace_.active_count; ++k) {
      const std::uint32_t row = workspace_.answer.active[k];
      const bool is_bridge = row >= set.pairs.size();
      workspace_.active_names[k] = is_bridge ? nameOf(bridges_, row - static_cast<std::uint32_t>(set.pairs.size())) : nameOf(set, row);
      workspace_.active_names[k].is_bridge = is_bridge;
    }
  }
  void findActive(const PairSet& set) {
    QpAnswer& answer = workspace_.answer;
    answer.active_count = 0;
    for (std::size_t k = 0; k < workspace_.active_count; ++k) {
      const PairName& name = workspace_.active_names[k];
      const PairSet& from = name.is_bridge ? bridges_ : set;
      for (const PairRun& run : from.runs) {
        if (run.object != name.object) continue;
        const auto begin = from.pairs.begin() + run.begin, end = begin + run.count, found = std::find(begin, end, name.pair);
        if (found != end)
          answer.active[answer.active_count++] =
              static_cast<std::uint32_t>((found - from.pairs.begin()) + static_cast<std::ptrdiff_t>(name.is_bridge ? set.pairs.size() : 0));
        break;
      }
    }
  }

  Vector6 scaledVector(const Displacement& d) const {
    Vector6 y;
    y << d.translation, scene_.angle_length * d.rotation;
    return y;
  }
  Displacement displacement(const Vector6& y) const {
    return {Eigen::Vector3d(y[0], y[1], y[2]), Eigen::Vector3d(y[3], y[4], y[5]) / scene_.angle_length};
  }
  // No point of the tool moves farther than this on the way [mm].
  double reach(const Displacement& d) const { return d.translation.norm() + scene_.tool.reach * d.rotation.norm(); }

  void constrained(const Configuration& haptic);
  void paper(const Configuration& haptic);

 private:
  double mostChange(const Configuration& haptic);
  double partWithin(const Configuration& now, const Configuration& haptic, const Vector6& way, double change, double most) const;
  static std::uint32_t groups(std::size_t rows) { return static_cast<std::uint32_t>((rows + 7) / 8); }
  void accelerate(const RowSet& set, const Vector6& want, const Vector6& plain);
  void coarseMove(PairSet set, const Configuration& haptic, double path_tolerance, double largest_turn);

  const Scene& scene_;
  Workspace& workspace_;
  StageTimes* times_;
  StepResult& result_;
  PairSet bridges_;                // near the pose of the last searchBridges()
  Vector6 stretch_before_;         // of the springs, when the last step ended [mm, scaled]
  Vector6 last_plain_, last_way_;  // the piece before this one: what the QP wanted, and what was done
  bool has_last_ = false;
};

// Along a curved contact the plain steps shrink (or grow) by about the same factor each time: the rows are tangents, and the deeper the
// haptic tool is below a bump, the slower. The last two of them tell the factor (a secant, as in Anderson's mixing), and the sum of the
// series. The QP aims there instead; its rows are the same, so the step is as safe as the plain one.
void Stepper::accelerate(const RowSet& set, const Vector6& want, const Vector6& plain) {
  if (!has_last_) return;
  const Vector6 change = plain - last_plain_;
  const double shrink = -change.dot(last_way_), square = last_way_.squaredNorm();
  if (!(plain.dot(last_plain_) > 0.1 * plain.norm() * last_plain_.norm())) return;  // a corner lies between
  Vector6 further = 3 * plain;                                                      // off a ridge, where steps grow
  if (shrink > 0.05 * square) further = -(plain.dot(change) / change.squaredNorm()) * (last_way_ + change);
  solve(set, want + further);
}

// Where the nearest free pose is not continuous in the pose of the hand, the graphic tool slides to the new one over several steps, so that
// the force changes by no more than the hand moved and what can hardly be felt; never where it had not yet arrived for want of work.
double Stepper::mostChange(const Configuration& haptic) {
  stretch_before_ = scaledVector(displacementBetween(workspace_.graphic, workspace_.haptic));
  if (workspace_.is_behind) return std::numeric_limits<double>::infinity();
  const double hand = std::max(scaledVector(displacementBetween(workspace_.haptic, haptic)).norm(),
                               (scaledVector(displacementBetween(workspace_.graphic, haptic)) - stretch_before_).norm());
  const double hardly_felt = std::max(kForceStep / scene_.coupling.translation, kForceStepPart * stretch_before_.head<3>().norm());
  return std::max(hand, (haptic.position - workspace_.haptic.position).norm() + hardly_felt);
}

// The largest part, up to `most`, of the piece `way` from `now` at whose end the stretch of the springs has changed by `change` or less.
double Stepper::partWithin(const Configuration& now, const Configuration& haptic, const Vector6& way, double change, double most) const {
  if (change == std::numeric_limits<double>::infinity()) return most;
  const Vector6 so_far = scaledVector(displacementBetween(now, haptic)) - stretch_before_;
  if ((so_far - most * way).norm() <= change) return most;
  const double square = way.squaredNorm(), along = so_far.dot(way), left = change * change - so_far.squaredNorm();
  return std::clamp((along + std::sqrt(std::max(0.0, along * along + square * left))) / square, 0.0, most);
}

// Each piece of the way is safe as a whole. All pairs that can meet within it are in the list, since no point of the tool moves farther
// than the margin. A row holds along the piece from its start (gap >= 0) to its end (a . y >= b), and the true gap is the row's value
// plus a convex function of the translation, less at most |r| angle^2 / 2 for the turn. So no pair is ever deeper than that.
void Stepper::constrained(const Configuration& haptic) {
  const double path_tolerance = std::min(kPathTolerance, 0.1 * scene_.smallest_radius_sum);
  const double largest_turn = std::sqrt(1.6 * path_tolerance / std::max(scene_.tool.reach, 1e-6));
  Configuration now = workspace_.graphic;
  Configuration best = now;
  double best_depth = std::numeric_limits<double>::infinity();
  const double motion = reach(displacementBetween(workspace_.haptic, haptic));
  double margin_limit = std::numeric_limits<double>::infinity();
  double margin = std::max(kLeastMargin, std::min(reach(displacementBetween(now, haptic)), 1.5 * motion + 0.05));
  if (workspace_.active_count > 0) margin = std::min(margin, kContactMargin);
  PairSet pairs;
  RowSet set;
  double depth = 0, used = 0;
  bool stale = true;  // the pairs are not those of `margin` about `now`
  const auto record = [&] {
    if (depth < best_depth || depth <= 0.5 * kGapTolerance) {
      best = now;
      best_depth = depth;
    }
  };
  double change = mostChange(haptic);  // of the stretch of the springs in this step [mm, scaled]
  bool settled = false;
  double nearest = std::numeric_limits<double>::infinity();
  int pieces = 0;
  while (!settled) {
    if (result_.linearisations >= kMostLinearisations || !workLeft()) {
      result_.faults |= kWorkLimit;
      break;
    }
    if (stale) {
      pairs = search(now, margin, false);
      while (margin > (pairs.coarse ? kLeastMargin : kContactMargin) && !pairs.pairs.empty() &&
             workLeft()) {  // a shorter way has fewer pairs
        margin = std::max(pairs.coarse ? kLeastMargin : kContactMargin, margin / 4);
        if (pairs.coarse) margin_limit = margin;
        pairs = search(now, margin, false);
      }
      if (pairs.coarse) {
        result_.faults |= workLeft() ? kPairsFull : kWorkLimit;
        if (workLeft() && best_depth == std::numeric_limits<double>::infinity()) coarseMove(pairs, haptic, path_tolerance, largest_turn);
        break;
      }
      searchBridges(now, margin);
      if (margin > kContactMargin && !bridges_.pairs.empty()) {
        margin = kContactMargin;
        searchBridges(now, margin);
      }
      findActive(pairs);
      set = allRows(pairs, now, margin);
      depth = std::max(0.0, -static_cast<double>(set.smallest_gap));
      if (depth > kGapTolerance) change = std::numeric_limits<double>::infinity();
      used = 0;
      stale = false;
      record();
    }
    const Displacement want = displacementBetween(now, haptic);
    double length = reach(want);
    const double left = std::max(0.0, margin - used);
    if (isFree(pairs)) {
      workspace_.active_count = 0;
      result_.active = 0;
      const double part = partWithin(now, haptic, scaledVector(want), change, std::min(1.0, length > left ? left / length : 1.0));
      if (part == 1) {
        now = haptic;
        settled = true;
      } else {
        settled = part * length < left * (1 - 1e-9);
        now = moved(now, scaled(want, part));
        margin = std::min({4 * margin, length, margin_limit});
        stale = true;
      }
      record();
      continue;
    }
    const double back = solve(set, scaledVector(want));
    const Vector6 plain = workspace_.answer.y;
    if (plain.norm() < kConverged || (has_last_ && plain.norm() < kRounding && plain.norm() > 0.7 * last_way_.norm())) {
      keepActive(pairs);
      settled = true;
      break;
    }
    if (back == 0 && workspace_.answer.active_count > 0) accelerate(set, scaledVector(want), plain);
    const Displacement step = displacement(workspace_.answer.y);
    const bool straight = workspace_.answer.active_count == 0 && back == 0 && workspace_.answer.status == QpStatus::Optimal;
    length = reach(step);
    const double turn = step.rotation.norm();
    double part = std::min(1.0, length > left ? left / length : 1.0);
    const bool short_of_margin = part < 1;
    if (turn * part > largest_turn) part = largest_turn / turn;
    const double most = part;
    part = partWithin(now, haptic, workspace_.answer.y, change, most);
    const bool is_held_back = part < most;
    const Configuration from = now;
    const double depth_before = depth;
    keepActive(pairs);
    // Pieces shrink, and so does what the next few of them can meet.
    if (const double enough = kPiecesAhead * part * length + kLeastMargin; back == 0 && enough < 0.5 * left) {
      narrowTo(enough, set, now, pairs);
      margin = enough;
      used = 0;
    }
    bool accepted = false;
    for (int halving = 0; halving <= kMostHalvings && !accepted; ++halving) {
      now = straight && part == 1 ? haptic : moved(from, scaled(step, part));
      set = allRows(pairs, now, margin);
      depth = std::max(0.0, -static_cast<double>(set.smallest_gap));
      accepted = depth <= std::max(path_tolerance, depth_before + 1e-6);
      if (!accepted) part /= 2;
    }
    if (!accepted) break;  // rows that conflict: no way on from here in this step
    last_plain_ = plain;
    last_way_ = part * workspace_.answer.y;
    has_last_ = true;
    used += part * length;
    record();
    bool is_idle = false;
    if (++pieces % kPatience == 0) {
      const double left_over = scaledVector(displacementBetween(now, haptic)).norm();
      is_idle = nearest - left_over < kProgress;
      nearest = left_over;
    }
    if ((straight && part == 1) || is_held_back || is_idle) {
      settled = true;
    } else if (short_of_margin && margin - used < 0.5 * (1 - part) * length) {
      const double wish = std::max(margin, std::min({4 * margin, 1.1 * (1 - part) * length + kLeastMargin, kContactMargin}));
      margin = std::max(kLeastMargin, std::min(wish, margin_limit));
      stale = true;
    }
  }
  workspace_.is_behind = !settled;
  // A way that ends with a turn may end a little inside. Push straight out, or fall back to the last pose that was free.
  for (int attempt = 0; attempt < 2 && !isFree(pairs) && !stale && !pairs.coarse && depth > 0.5 * kGapTolerance && depth <= path_tolerance;
       ++attempt) {
    solve(set, Vector6::Zero());
    const Displacement step = displacement(workspace_.answer.y);
    used += reach(step);
    if (used > margin) break;
    now = moved(now, step);
    set = allRows(pairs, now, margin);
    depth = std::max(0.0, -static_cast<double>(set.smallest_gap));
    record();
  }
  if (best_depth < std::numeric_limits<double>::infinity()) {
    workspace_.graphic = best;
    result_.penetration = best_depth;
  }
  if (result_.penetration > kGapTolerance) result_.faults |= kPenetrating;
}

// The list is full even for the shortest way. Whole branches stand in, as the balls about their leaves: none may come closer than it is.
// That steers, and proves nothing; so the step is tiny, and is taken only if a search for leaf pairs that overlap comes back in full and
// finds none.
void Stepper::coarseMove(PairSet pairs, const Configuration& haptic, double path_tolerance, double largest_turn) {
  const Configuration from = workspace_.graphic;
  findActive(pairs);
  const RowSet set = rows(pairs, from);
  float* const b = const_cast<float*>(set.rows.b);  // the workspace's own row memory
  for (std::uint32_t i = 0; i < set.rows.count; ++i) b[i] = std::min(b[i], 0.0f);
  solve(set, scaledVector(displacementBetween(from, haptic)));
  keepActive(pairs);
  const Displacement step = displacement(workspace_.answer.y);
  const double most = std::min({kLeastMargin, path_tolerance, 0.25 * scene_.smallest_radius_sum}), length = reach(step),
               turn = step.rotation.norm();
  double part = 1;
  if (length > most) part = most / length;
  if (turn * part > largest_turn) part = largest_turn / turn;
  const Configuration to = moved(from, scaled(step, part));
  pairs = search(to, 0, false);
  if (pairs.coarse) return;
  const double depth = std::max(0.0, -static_cast<double>(rows(pairs, to).smallest_gap));
  if (depth > 0.5 * kGapTolerance) return;
  workspace_.graphic = to;
  result_.penetration = depth;
}

// Gamma, beta, alpha of R = Rz(alpha) Ry(beta) Rx(gamma).
Eigen::Vector3d eulerAngles(const Quaternion& q) {
  const Eigen::Matrix3d m = q.toRotationMatrix();
  const double level = std::sqrt(m(0, 0) * m(0, 0) + m(1, 0) * m(1, 0));
  return {std::atan2(m(2, 1), m(2, 2)), std::atan2(-m(2, 0), level), std::atan2(m(1, 0), m(0, 0))};
}
Quaternion fromEuler(const Eigen::Vector3d& e) {
  const Eigen::Array3d half = 0.5 * e.array(), c = half.cos(), s = half.sin();
  return {c[2] * c[1] * c[0] + s[2] * s[1] * s[0], c[2] * c[1] * s[0] - s[2] * s[1] * c[0], c[2] * s[1] * c[0] + s[2] * c[1] * s[0],
          s[2] * c[1] * c[0] - c[2] * s[1] * s[0]};
}

void Stepper::paper(const Configuration& haptic) {
  Eigen::Vector3d before(workspace_.euler[0], workspace_.euler[1], workspace_.euler[2]);
  Eigen::Vector3d angles = eulerAngles(haptic.orientation);
  for (int k = 0; k < 3; ++k)  // the turn count that is nearest to the graphic tool's: no jump at +-pi
    angles[k] += 2 * M_PI * std::round((before[k] - angles[k]) / (2 * M_PI));

  const PairSet pairs = search(haptic, 0, true);
  if (pairs.coarse) result_.faults |= kPairsFull;
  Eigen::Vector3d position = haptic.position, after = angles;
  workspace_.answer.active_count = 0;
  if (!pairs.pairs.empty()) {
    // Gamma turns about the tool's own x axis, alpha about the world's z, beta about the y axis that alpha has turned.
    Eigen::Matrix3d axes;
    axes << workspace_.graphic.orientation * Eigen::Vector3d::UnitX(), Eigen::Vector3d(-std::sin(before[2]), std::cos(before[2]), 0),
        Eigen::Vector3d::UnitZ();
    const RowSet set = rows(pairs, workspace_.graphic, RowForm::SquaredDistance, axes);
    findActive(pairs);
    solve(set, scaledVector({haptic.position - workspace_.graphic.position, angles - before}));
    keepActive(pairs);
    const Displacement step = displacement(workspace_.answer.y);
    position = workspace_.graphic.position + step.translation;
    after = before + step.rotation;
  } else {
    workspace_.active_count = 0;
  }
  workspace_.euler = {after[0], after[1], after[2]};
  workspace_.graphic = pairs.pairs.empty() ? haptic : Configuration{position, fromEuler(after)};
  workspace_.wrench = {scene_.coupling.translation * (position - haptic.position), scene_.coupling.rotation * (after - angles)};
}

}  // namespace

StepResult step(const Scene& scene, const Configuration& haptic_tool, Mode mode, Workspace& workspace, StageTimes* times) noexcept {
  StepResult result;
  if (times) *times = {};
  if (!isFinite(haptic_tool) || !(haptic_tool.position.cwiseAbs().maxCoeff() <= kFarthest)) {
    result.faults = kBadInput;
    workspace.wrench.force *= 0.9;
    workspace.wrench.torque *= 0.9;
  } else {
    const Configuration haptic{haptic_tool.position, haptic_tool.orientation.normalized()};
    if (!workspace.started) resetTo(haptic, workspace);
    Stepper stepper(scene, workspace, times, result);
    if (mode == Mode::Paper) {
      stepper.paper(haptic);
    } else {
      stepper.constrained(haptic);
      workspace.wrench = couplingWrench(scene.coupling, haptic, workspace.graphic);
      const Eigen::Vector3d angles = eulerAngles(workspace.graphic.orientation);
      workspace.euler = {angles[0], angles[1], angles[2]};
    }
    workspace.haptic = haptic;
  }
  result.graphic = workspace.graphic;
  result.wrench = workspace.wrench;
  result.limited_wrench = limited(workspace.wrench, scene.wrench_limits);
  return result;
}

void reset(Workspace& workspace) noexcept {
  workspace.started = false;
  workspace.is_behind = false;
  workspace.active_count = 0;
  workspace.answer = {};
  workspace.wrench = {};
  workspace.haptic = workspace.graphic = {};
  workspace.euler = {};
}

void resetTo(const Configuration& graphic_tool, Workspace& workspace) noexcept {
  reset(workspace);
  if (!isFinite(graphic_tool)) return;
  workspace.started = true;
  workspace.haptic = workspace.graphic = {graphic_tool.position, graphic_tool.orientation.normalized()};
  const Eigen::Vector3d angles = eulerAngles(workspace.graphic.orientation);
  workspace.euler = {angles[0], angles[1], angles[2]};
}

}  // namespace spheretree::runtime
