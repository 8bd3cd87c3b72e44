// SPDX-License-Identifier: Apache-2.0
#include "tissue/soft_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace spheretree::runtime {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

using Pair [[gnu::vector_size(16)]] = double;

constexpr double kArrived = 1e-4;  // if the base is nearer than this to its target, it moves there at once [mm]

// The largest length of `of` over the x, y, z of each node.
template <class Of>
double longest(std::size_t size, const Of& of) {
  float max2 = 0;
  for (std::size_t i = 0; i < size; i += 3) {
    const float x = of(i), y = of(i + 1), z = of(i + 2);
    max2 = std::max(max2, x * x + y * y + z * z);
  }
  return std::sqrt(static_cast<double>(max2));
}

bool anyIn(const std::vector<float>& field) {
  return std::any_of(field.begin(), field.end(), [](float f) { return f != 0; });
}

}  // namespace

SoftSurface::SoftSurface(const SoftModel& model, const CompiledShape& shape)
    : model_(model),
      skin_(model, shape),
      near_at_(model.node_count, ~0u),
      is_near_(model.vertices.size(), 0),
      moved_(model.vertices.size()),
      predicted_(model.vertices.size(), Vector3f::Zero()) {
  for (const SkinTriangle& t : model.tree->skin.triangles) corners_.push_back({t.vertex[0], t.vertex[1], t.vertex[2]});
  for (Field* field : {&force_, &from_, &to_, &now_, &base_, &shift_, &from_now_, &to_now_, &start_force_, &start_, &start_base_, &bent_,
                       &last_bent_, &base_way_})
    *field = Field(3 * model.node_count);
  near_.reserve(model.node_count);
  near_vertices_.reserve(model.vertices.size());
}

void SoftSurface::reset() {
  for (Field* field : {&force_, &from_, &to_, &now_, &base_, &shift_, &from_now_, &to_now_, &start_force_, &start_, &start_base_, &bent_,
                       &last_bent_, &base_way_})
    std::fill(field->begin(), field->end(), 0.0f);
  skin_.reset();
  ++motions_;
  aim_ = {};
  left_ = 0;
  has_moved_ = is_pressed_ = knows_to_ = base_moves_ = false;
  ahead_ = from_ahead_ = motion_so_far_ = 0;
}

bool SoftSurface::isAtRest() const { return !anyIn(shift_); }

Vector3d SoftSurface::fieldAt(const SkinPoint& point, const Field& field) const {
  Vector3d sum = Vector3d::Zero();
  for (std::size_t k = 0; k < 3; ++k)
    if (point.weight[k] > 0) sum += point.weight[k] * model_.vertices[corners_[point.triangle][k]].point.displacementIn(field);
  return sum;
}

const SoftSurface::Moved& SoftSurface::movedVertex(std::uint32_t v) const {
  Moved& out = moved_[v];
  if (out.when != motions_)
    out = {model_.vertices[v].point.displacementIn(now_), model_.vertices[v].point.displacementIn(shift_), motions_};
  return out;
}

Vector3d SoftSurface::meanOf(const SkinPoint& point, Vector3d Moved::*of) const {
  Vector3d sum = Vector3d::Zero();
  for (std::size_t k = 0; k < 3; ++k)
    if (point.weight[k] > 0) sum += point.weight[k] * (movedVertex(corners_[point.triangle][k]).*of);
  return sum;
}

Vector3d SoftSurface::ahead(const SkinPoint& point) const {
  return ahead_ > 0 ? Vector3d(ahead_ * fieldAt(point, base_way_)) : Vector3d(Vector3d::Zero());
}

Vector3d SoftSurface::movedInStep(const SkinPoint& point) const {
  const Vector3d by_forces = fieldAt(point, now_) - fieldAt(point, start_);
  return base_moves_ ? Vector3d(by_forces + fieldAt(point, base_way_)) : by_forces;
}

double SoftSurface::maxGive(const SkinPoint& point) const {
  double sum = 0;
  for (std::size_t k = 0; k < 3; ++k) sum += point.weight[k] * static_cast<double>(model_.vertices[corners_[point.triangle][k]].max_give);
  return sum;
}

SkinPoint SoftSurface::pointAt(std::uint32_t triangle, const Vector3d& p) const {
  const CompiledPatch& patch = skin_.patches()[triangle];
  const auto corner = [&](std::size_t k) { return Vector3d(Eigen::Map<const Vector3f>(patch.position[k]).cast<double>()); };
  const Vector3d a = corner(0), u = corner(1) - a, v = corner(2) - a, normal = u.cross(v), way = p - a;
  const double square = normal.squaredNorm();
  SkinPoint out{triangle, {1.0 / 3, 1.0 / 3, 1.0 / 3}};
  if (!(square > 0)) return out;
  const double w1 = std::max(0.0, normal.dot(way.cross(v)) / square), w2 = std::max(0.0, normal.dot(u.cross(way)) / square),
               w0 = std::max(0.0, 1 - w1 - w2), sum = w0 + w1 + w2;
  out.weight = {w0 / sum, w1 / sum, w2 / sum};
  return out;
}

SoftSurface::Press SoftSurface::pressOn(const SkinPoint& point) const {
  Press out;
  for (std::size_t k = 0; k < 3; ++k) {
    const PressPoint& vertex = model_.vertices[corners_[point.triangle][k]].point;
    for (std::size_t i = 0; i < 3; ++i) {
      const double weight = point.weight[k] * static_cast<double>(vertex.weight[i]);
      if (vertex.node[i] == kNone || !(weight > 0)) continue;
      std::size_t at = 0;
      while (at < out.count && out.node[at] != vertex.node[i]) ++at;
      if (at == out.count) {
        out.node[at] = vertex.node[i];
        out.weight[at] = 0;
        ++out.count;
      }
      out.weight[at] += weight;
    }
  }
  return out;
}

void SoftSurface::forgetNear() {
  for (const std::uint32_t node : near_) near_at_[node] = ~0u;
  for (const std::uint32_t v : near_vertices_) is_near_[v] = 0;
  near_.clear();
  near_vertices_.clear();
}

void SoftSurface::addNear(std::uint32_t triangle) {
  for (const std::uint32_t v : corners_[triangle]) {
    if (is_near_[v]) continue;
    is_near_[v] = 1;
    near_vertices_.push_back(v);
    for (const std::uint32_t node : model_.vertices[v].point.node) {
      if (node == kNone || near_at_[node] != ~0u) continue;
      near_at_[node] = static_cast<std::uint32_t>(near_.size());
      near_.push_back(node);
    }
  }
}

void SoftSurface::respond(const Press& press, std::span<Eigen::Matrix3d> near) const {
  for (std::size_t i = 0; i < near_.size(); ++i) {
    Pair xy[3] = {};
    double z[3] = {};
    for (std::size_t p = 0; p < press.count; ++p) {
      const Pair weight{press.weight[p], press.weight[p]};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const float* const u = model_.column(3 * std::size_t{press.node[p]} + axis) + 3 * std::size_t{near_[i]};
        xy[axis] += weight * Pair{static_cast<double>(u[0]), static_cast<double>(u[1])};
        z[axis] += weight[0] * static_cast<double>(u[2]);
      }
    }
    for (std::size_t axis = 0; axis < 3; ++axis) near[i].col(static_cast<Eigen::Index>(axis)) << xy[axis][0], xy[axis][1], z[axis];
  }
}

Vector3d SoftSurface::meanOf(const Press& of, std::span<const double> near) const {
  Vector3d sum = Vector3d::Zero();
  for (std::size_t p = 0; p < of.count; ++p) sum += of.weight[p] * Vector3d(near.data() + 3 * std::size_t{near_at_[of.node[p]]});
  return sum;
}

void SoftSurface::predict(std::span<const double> near) {
  for (const std::uint32_t v : near_vertices_) {
    const PressPoint& point = model_.vertices[v].point;
    Vector3d sum = Vector3d::Zero();
    for (std::size_t k = 0; k < 3; ++k)
      if (point.node[k] != kNone)
        sum += static_cast<double>(point.weight[k]) * Vector3d(near.data() + 3 * std::size_t{near_at_[point.node[k]]});
    predicted_[v] = sum.cast<float>();
  }
}

Vector3d SoftSurface::predicted(const SkinPoint& point) const {
  Vector3d sum = Vector3d::Zero();
  for (std::size_t k = 0; k < 3; ++k) sum += point.weight[k] * predicted_[corners_[point.triangle][k]].cast<double>();
  return sum;
}

void SoftSurface::applyForces(const Field& forces, Field& out) const {
  std::fill(out.begin(), out.end(), 0.0f);
  const std::size_t size = out.size();
  // A pressed node has three forces: the sums are read and written once for all of them.
  for (std::size_t i = 0; i < forces.size(); i += 3) {
    const float x = forces[i], y = forces[i + 1], z = forces[i + 2];
    if (x == 0 && y == 0 && z == 0) continue;
    const float *const to_x = model_.column(i), *const to_y = model_.column(i + 1), *const to_z = model_.column(i + 2);
    float* const sum = out.data();
    for (std::size_t k = 0; k < size; ++k) sum[k] += x * to_x[k] + y * to_y[k] + z * to_z[k];
  }
}

void SoftSurface::aimAt(bool from_now) {
  from_ahead_ = ahead_;
  if (!is_pressed_) return;
  from_ = force_;
  from_now_ = now_;
  knows_to_ = false;
  if (from_now)
    to_ = force_;
  else
    std::fill(to_.begin(), to_.end(), 0.0f);
}

void SoftSurface::press(const Press& on, const Vector3d& force) {
  if (!is_pressed_) {
    from_ = force_;
    from_now_ = now_;
    is_pressed_ = true;
    knows_to_ = false;
  }
  for (std::size_t p = 0; p < on.count; ++p)
    for (std::size_t axis = 0; axis < 3; ++axis)
      to_[3 * std::size_t{on.node[p]} + axis] += static_cast<float>(on.weight[p] * force[static_cast<Eigen::Index>(axis)]);
}

void SoftSurface::giveWay(double share) {
  ahead_ = (1 - share) * from_ahead_;
  if (!is_pressed_) return;
  if (!knows_to_) applyForces(to_, to_now_);
  knows_to_ = true;
  const auto p = static_cast<float>(share), rest = 1 - p;
  for (std::size_t i = 0; i < force_.size(); ++i) force_[i] = rest * from_[i] + p * to_[i];
  for (std::size_t i = 0; i < now_.size(); ++i) now_[i] = rest * from_now_[i] + p * to_now_[i];
  const double largest = longest(now_.size(), [&](std::size_t i) { return now_[i] - start_[i]; });
  if (largest > motion_) {  // the tissue waits
    const auto allowed = static_cast<float>(motion_ / largest);
    for (std::size_t i = 0; i < force_.size(); ++i) force_[i] = start_force_[i] + allowed * (force_[i] - start_force_[i]);
    for (std::size_t i = 0; i < now_.size(); ++i) now_[i] = start_[i] + allowed * (now_[i] - start_[i]);
  }
  motion_so_far_ = std::max(motion_so_far_, std::min(largest, motion_));
  findShift();
}

void SoftSurface::findShift() {
  for (std::size_t i = 0; i < shift_.size(); ++i) shift_[i] = base_[i] + now_[i];
  has_moved_ = true;
  ++motions_;
  skin_.forget();
}

void SoftSurface::aim(std::span<const float> surface) {
  aim_ = surface;
  left_ = longest(aim_.size(), [&](std::size_t i) { return aim_[i] - base_[i]; });
}

void SoftSurface::followAim(double share, double max_motion) {
  if (left_ == 0 || !std::isfinite(left_)) return;
  if (left_ <= kArrived) share = 1;
  if (share * left_ > max_motion) share = max_motion / left_;
  if (share == 0) return;
  for (std::size_t i = 0; i < base_.size(); ++i) {
    base_way_[i] = static_cast<float>(share) * (aim_[i] - base_[i]);
    base_[i] += base_way_[i];
  }
  base_moves_ = true;
  ahead_ = 1;
  left_ *= 1 - share;
  findShift();
}

void SoftSurface::beginStep(double share, double max_motion, double motion) {
  motion_ = motion;
  base_moves_ = false;
  ahead_ = from_ahead_ = motion_so_far_ = 0;
  start_base_ = base_;
  last_bent_ = bent_;
  if (aim_.size() == base_.size()) followAim(share, max_motion);
  skin_.beginStep();
  if (!has_moved_) return;
  has_moved_ = false;
  start_force_ = force_;
  start_ = now_;
  is_pressed_ = is_pressed_ && (anyIn(force_) || anyIn(to_));
  bent_ = shift_;
  skin_.bend(bent_);
  skin_.refit(shift_);
}

void SoftSurface::takeBack() {
  base_ = start_base_;
  force_ = start_force_;
  now_ = start_;
  base_moves_ = knows_to_ = false;
  ahead_ = from_ahead_ = 0;
  is_pressed_ = is_pressed_ || anyIn(force_);
  if (aim_.size() == base_.size()) aim(aim_);
  findShift();
  bent_ = last_bent_;
  skin_.bend(bent_);
}

}  // namespace spheretree::runtime
