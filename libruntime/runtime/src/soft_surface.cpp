// SPDX-License-Identifier: Apache-2.0
#include "soft_surface.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace spheretree::runtime {
namespace {

using Eigen::Vector3d;
using Eigen::Vector4d;

constexpr double kMostShare = 0.5;    // of the distance to what holds the tissue: it gives way by this at most
constexpr double kArrived = 1e-4;     // of its aim the base goes the rest at once [mm]
constexpr double kLoadPart = 0.75;    // of a change of the load, that the base follows in the next step
constexpr double kMostLoad = 2;       // of that of the state: beyond, the base stays
constexpr double kSteadyLoad = 1e-6;  // a smaller change waits for more

Vector3d vectorOf(const std::array<double, 3>& p) { return {p[0], p[1], p[2]}; }
Vector4d vectorOf(const Sphere& s) { return {s.x, s.y, s.z, s.radius}; }

// Part of the distance from the point of a leaf to the nearest node that stays.
float mostGiveOf(const Tissue& tissue, std::uint32_t leaf) {
  const PressPoint& point = tissue.response.points[leaf];
  Vector3d at = Vector3d::Zero();
  double held = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    if (point.node[k] == kHeldNode)
      held += static_cast<double>(point.weight[k]);
    else
      at += static_cast<double>(point.weight[k]) * vectorOf(tissue.nodes[tissue.response.pressed[point.node[k]]]);
  }
  if (held > 0.999) return 0;
  at /= 1 - held;
  double nearest = std::numeric_limits<double>::infinity();
  for (const std::uint32_t node : tissue.fixed) nearest = std::min(nearest, (vectorOf(tissue.nodes[node]) - at).norm());
  return static_cast<float>(std::min(kMostShare * nearest, 1e6));
}

}  // namespace

LinearModel linearModel(std::shared_ptr<const Tissue> tissue) {
  LinearModel out;
  out.node_count = tissue->response.pressed.size();
  out.points = tissue->response.points;
  out.matrix = tissue->response.matrix;
  for (std::uint32_t leaf = 0; leaf < out.points.size(); ++leaf) out.most_give.push_back(mostGiveOf(*tissue, leaf));
  out.tissue = std::move(tissue);
  out.bytes = out.points.size() * sizeof(PressPoint) + (out.most_give.size() + out.matrix.size()) * sizeof(float);
  return out;
}

SoftSurface::SoftSurface(const LinearModel& model, const CompiledShape& shape)
    : model_(model),
      shape_(shape),
      offset_(Vector3d(model.tree->origin_mm.data()) - shape.centre),
      slots_(model.points.size()),
      parents_(shape.leaves.bound.size(), kNoItem),
      bound_(shape.leaves.bound),
      spheres_(shape.leaves.spheres) {
  const CompiledTree& leaves = shape.leaves;
  for (std::size_t slot = 0; slot < leaves.item.size(); ++slot) {
    if (leaves.item[slot] != kNoItem) slots_[leaves.item[slot]] = static_cast<std::uint32_t>(slot);
    const BlockLinks& links = leaves.links[slot / 8];
    if (slot % 8 < links.inner) parents_[links.first_child + slot % 8] = static_cast<std::uint32_t>(slot);
  }
  for (Field* field : {&force_, &from_, &to_, &now_, &start_force_, &start_, &predicted_}) *field = Field(3 * model.node_count);
  for (std::uint32_t leaf = 0; leaf < model.points.size(); ++leaf) base_.push_back(restOf(leaf));
  block_marked_.assign(bound_.size(), 0);
  near_.reserve(model.node_count);
  near_at_.assign(model.node_count, ~0u);
  reset();
}

void SoftSurface::reset() {
  for (Field* field : {&force_, &from_, &to_, &now_, &start_force_, &start_}) std::fill(field->begin(), field->end(), 0.0f);
  bound_ = shape_.leaves.bound;
  spheres_ = shape_.leaves.spheres;
  for (std::uint32_t leaf = 0; leaf < base_.size(); ++leaf) base_[leaf] = restOf(leaf);
  put_ = base_;
  aim_ = {};
  load_ = {};
  rates_ = {};
  amount_ = 1;
  left_ = 0;
  radius_ = shape_.radius;
  has_moved_ = false;
}

Vector3d SoftSurface::response(std::uint32_t of, std::uint32_t on, const Vector3d& force) const {
  const PressPoint &from = model_.points[on], &to = model_.points[of];
  Vector3d sum = Vector3d::Zero();
  for (std::size_t i = 0; i < 3; ++i) {
    if (from.node[i] == kHeldNode) continue;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float* const column = model_.column(3 * from.node[i] + axis);
      const double f = static_cast<double>(from.weight[i]) * force[static_cast<Eigen::Index>(axis)];
      for (std::size_t k = 0; k < 3; ++k) {
        if (to.node[k] == kHeldNode) continue;
        const float* const u = column + 3 * std::size_t{to.node[k]};
        sum += f * static_cast<double>(to.weight[k]) * Vector3d(u[0], u[1], u[2]);
      }
    }
  }
  return sum;
}

void SoftSurface::forgetNear() {
  for (const std::uint32_t node : near_) near_at_[node] = ~0u;
  near_.clear();
}

void SoftSurface::addNear(std::uint32_t leaf) {
  if (leaf == kNoItem) return;
  for (const std::uint32_t node : model_.points[leaf].node) {
    if (node == kHeldNode || near_at_[node] != ~0u) continue;
    near_at_[node] = static_cast<std::uint32_t>(near_.size());
    near_.push_back(node);
  }
}

void SoftSurface::predictNothing() { std::fill_n(predicted_.begin(), 3 * near_.size(), 0.0f); }

void SoftSurface::predict(std::uint32_t leaf, const Vector3d& force) {
  const PressPoint& point = model_.points[leaf];
  for (std::size_t k = 0; k < 3; ++k) {
    if (point.node[k] == kHeldNode) continue;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float* const column = model_.column(3 * point.node[k] + axis);
      const auto f = static_cast<float>(static_cast<double>(point.weight[k]) * force[static_cast<Eigen::Index>(axis)]);
      for (std::size_t i = 0; i < near_.size(); ++i) {
        const float* const u = column + 3 * std::size_t{near_[i]};
        for (std::size_t c = 0; c < 3; ++c) predicted_[3 * i + c] += f * u[c];
      }
    }
  }
}

Vector3d SoftSurface::predicted(std::uint32_t leaf) const {
  const PressPoint& point = model_.points[leaf];
  Vector3d sum = Vector3d::Zero();
  for (std::size_t k = 0; k < 3; ++k) {
    if (point.node[k] == kHeldNode) continue;
    const float* const u = predicted_.data() + 3 * std::size_t{near_at_[point.node[k]]};
    sum += static_cast<double>(point.weight[k]) * Vector3d(u[0], u[1], u[2]);
  }
  return sum;
}

void SoftSurface::respond(const Field& forces, Field& out) const {
  std::fill(out.begin(), out.end(), 0.0f);
  const std::size_t size = out.size();
  for (std::size_t i = 0; i < forces.size(); ++i) {
    const float f = forces[i];
    if (f == 0) continue;
    const float* const column = model_.column(i);
    float* const sum = out.data();
    for (std::size_t k = 0; k < size; ++k) sum[k] += f * column[k];
  }
}

void SoftSurface::aimAt(bool from_now) {
  from_ = force_;
  if (from_now)
    to_ = force_;
  else
    std::fill(to_.begin(), to_.end(), 0.0f);
}

void SoftSurface::press(std::uint32_t leaf, const Vector3d& force) {
  const PressPoint& point = model_.points[leaf];
  for (std::size_t k = 0; k < 3; ++k) {
    if (point.node[k] == kHeldNode) continue;
    for (std::size_t axis = 0; axis < 3; ++axis)
      to_[3 * point.node[k] + axis] += static_cast<float>(static_cast<double>(point.weight[k]) * force[static_cast<Eigen::Index>(axis)]);
  }
}

void SoftSurface::giveWay(double part) {
  const auto anyIn = [](const Field& field) { return std::any_of(field.begin(), field.end(), [](float f) { return f != 0; }); };
  if (!anyIn(force_) && !anyIn(from_) && !anyIn(to_) && !anyIn(start_force_)) return;  // at rest, and stays there
  has_moved_ = true;
  const auto p = static_cast<float>(part);
  for (std::size_t i = 0; i < force_.size(); ++i) force_[i] = from_[i] + p * (to_[i] - from_[i]);
  respond(force_, now_);
  float most2 = 0;
  for (std::size_t i = 0; i < now_.size(); i += 3) {
    const float x = now_[i] - start_[i], y = now_[i + 1] - start_[i + 1], z = now_[i + 2] - start_[i + 2];
    most2 = std::max(most2, x * x + y * y + z * z);
  }
  const float most = std::sqrt(most2);
  if (!(most > static_cast<float>(kTissueMotion))) return;
  const float share = static_cast<float>(kTissueMotion) / most;  // the tissue waits
  for (std::size_t i = 0; i < force_.size(); ++i) force_[i] = start_force_[i] + share * (force_[i] - start_force_[i]);
  for (std::size_t i = 0; i < now_.size(); ++i) now_[i] = start_[i] + share * (now_[i] - start_[i]);
}

SoftSurface::Ball SoftSurface::restOf(std::uint32_t leaf) const {
  const std::array<double, 3>& c = shape_.leaves.exact[slots_[leaf]];
  return {{c[0], c[1], c[2]}, static_cast<double>(shape_.leaves.spheres[slots_[leaf]].radius)};
}

double SoftSurface::loadOf(const Field& forces) const {
  if (load_.empty()) return 1;
  double sum = 0;
  for (std::size_t i = 0; i < load_.size(); ++i) sum += static_cast<double>(load_[i]) * static_cast<double>(forces[i]);
  return std::clamp(sum, 0.0, kMostLoad);
}

Vector4d SoftSurface::rateOf(std::size_t leaf) const { return rates_.empty() ? Vector4d(Vector4d::Zero()) : vectorOf(rates_[leaf]); }

// From the base to where the aim has it under the load that it follows.
Vector4d SoftSurface::leftOf(std::size_t leaf) const {
  Vector4d left = vectorOf(aim_[leaf]) + (amount_ - 1) * rateOf(leaf);
  left.head<3>() += offset_ - base_[leaf].centre;
  left[3] -= base_[leaf].radius;
  return left;
}

void SoftSurface::aim(std::span<const Sphere> leaves, const TissueTangent& tangent) {
  aim_ = leaves;
  load_ = tangent.load;
  rates_ = tangent.rates;
  amount_ = loadOf(force_);
  left_ = most_rate_ = 0;
  for (std::size_t leaf = 0; leaf < base_.size(); ++leaf) {
    left_ = std::max(left_, leftOf(leaf).lpNorm<1>());
    most_rate_ = std::max(most_rate_, rateOf(leaf).lpNorm<1>());
  }
}

// With the load at once; of what is then left, a part.
void SoftSurface::followAim(double part, double most) {
  const double change = kLoadPart * (loadOf(force_) - amount_);
  if (left_ == 0 && std::abs(change) < kSteadyLoad) return;
  if (left_ <= kArrived) part = 1;
  const double farthest = std::abs(change) * most_rate_ + part * left_, share = farthest > most ? most / farthest : 1;
  if (!std::isfinite(farthest)) return;
  for (std::size_t leaf = 0; leaf < base_.size(); ++leaf) {
    const Vector4d way = share * (change * rateOf(leaf) + part * leftOf(leaf));
    base_[leaf].centre += way.head<3>();
    base_[leaf].radius += way[3];
  }
  amount_ += share * change;
  left_ *= 1 - share * part;
  has_moved_ = true;
}

void SoftSurface::beginStep(double part, double most) {
  if (aim_.size() == base_.size()) followAim(part, most);
  if (!has_moved_) return;
  has_moved_ = false;
  start_force_ = force_;
  start_ = now_;
  bool any = false;
  for (std::uint32_t leaf = 0; leaf < put_.size(); ++leaf) {
    const double still = kRefitMm - std::abs(grownSinceRefit(leaf));
    if (still > 0 && !(sinceRefit(leaf).squaredNorm() > still * still)) continue;
    putLeaf(leaf);
    any = true;
  }
  if (any) encloseBlocks();
}

void SoftSurface::putLeaf(std::uint32_t leaf) {
  const Vector3d centre = base_[leaf].centre + displacement(leaf);
  put_[leaf] = {centre, base_[leaf].radius};
  const std::uint32_t slot = slots_[leaf];
  const auto radius = static_cast<float>(base_[leaf].radius);
  spheres_[slot] = {static_cast<float>(centre.x()), static_cast<float>(centre.y()), static_cast<float>(centre.z()), radius};
  put(bound_[slot / 8], slot % 8, centre, radius);
  block_marked_[slot / 8] = 1;
}

// Balls about what is below inner nodes; the blocks of children stand behind that of their parent.
void SoftSurface::encloseBlocks() {
  for (std::size_t b = bound_.size(); b-- > 1;) {
    if (!block_marked_[b]) continue;
    block_marked_[b] = 0;
    const Block& block = bound_[b];
    Eigen::Array3f low = Eigen::Array3f::Constant(std::numeric_limits<float>::infinity()), high = -low;
    for (std::size_t lane = 0; lane < 8; ++lane) {
      if (block.x[lane] == kFarAway) continue;
      const Eigen::Array3f c(block.x[lane], block.y[lane], block.z[lane]);
      low = low.min(c), high = high.max(c);
    }
    const Vector3d centre = (0.5f * (low + high)).matrix().cast<double>();
    double radius = 0;
    for (std::size_t lane = 0; lane < 8; ++lane)
      if (block.x[lane] != kFarAway)
        radius =
            std::max(radius, (Vector3d(block.x[lane], block.y[lane], block.z[lane]) - centre).norm() + static_cast<double>(block.r[lane]));
    const std::uint32_t parent = parents_[b];
    put(bound_[parent / 8], parent % 8, centre, static_cast<float>(radius * (1 + 1e-6)));
    spheres_[parent] = {static_cast<float>(centre.x()), static_cast<float>(centre.y()), static_cast<float>(centre.z()),
                        static_cast<float>(radius * (1 + 1e-6))};
    block_marked_[parent / 8] = 1;
  }
  block_marked_[0] = 0;
  const Block& root = bound_[0];
  radius_ = std::max(shape_.radius, Vector3d(root.x[0], root.y[0], root.z[0]).norm() + static_cast<double>(root.r[0]));
}

}  // namespace spheretree::runtime
