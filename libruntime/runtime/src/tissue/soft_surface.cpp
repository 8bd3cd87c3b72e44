// SPDX-License-Identifier: Apache-2.0
#include "tissue/soft_surface.h"

#include <Eigen/Geometry>
#include <algorithm>

namespace spheretree::runtime {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

bool anyIn(const std::vector<float>& field) {
  return std::any_of(field.begin(), field.end(), [](float f) { return f != 0; });
}

}  // namespace

SoftSurface::SoftSurface(const SoftModel& model, const CompiledShape& shape)
    : model_(model), skin_(model, shape), response_(model), base_(model.node_count), moved_(model.vertices.size()) {
  for (Field* field : fields()) *field = Field(3 * model.node_count);
}

void SoftSurface::reset() {
  for (Field* field : fields()) std::fill(field->begin(), field->end(), 0.0f);
  skin_.reset();
  ++motions_;
  base_.reset();
  has_moved_ = is_pressed_ = knows_to_ = false;
  ahead_ = from_ahead_ = motion_so_far_ = 0;
}

bool SoftSurface::isAtRest() const { return !anyIn(shift_); }

Vector3d SoftSurface::fieldAt(const SkinPoint& point, const Field& field) const {
  Vector3d sum = Vector3d::Zero();
  for (std::size_t k = 0; k < 3; ++k)
    if (point.weight[k] > 0) sum += point.weight[k] * model_.vertices[response_.corners(point.triangle)[k]].point.displacementIn(field);
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
    if (point.weight[k] > 0) sum += point.weight[k] * (movedVertex(response_.corners(point.triangle)[k]).*of);
  return sum;
}

Vector3d SoftSurface::ahead(const SkinPoint& point) const {
  return ahead_ > 0 ? Vector3d(ahead_ * fieldAt(point, base_.way())) : Vector3d(Vector3d::Zero());
}

Vector3d SoftSurface::movedInStep(const SkinPoint& point) const {
  const Vector3d by_forces = fieldAt(point, now_) - fieldAt(point, start_);
  return base_.moves() ? Vector3d(by_forces + fieldAt(point, base_.way())) : by_forces;
}

double SoftSurface::maxGive(const SkinPoint& point) const {
  double sum = 0;
  for (std::size_t k = 0; k < 3; ++k)
    sum += point.weight[k] * static_cast<double>(model_.vertices[response_.corners(point.triangle)[k]].max_give);
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

void SoftSurface::press(const SurfaceResponse::Press& on, const Vector3d& force) {
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
  const double largest = longestOf(now_.size(), [&](std::size_t i) { return now_[i] - start_[i]; });
  if (largest > motion_) {  // the tissue waits
    const auto allowed = static_cast<float>(motion_ / largest);
    for (std::size_t i = 0; i < force_.size(); ++i) force_[i] = start_force_[i] + allowed * (force_[i] - start_force_[i]);
    for (std::size_t i = 0; i < now_.size(); ++i) now_[i] = start_[i] + allowed * (now_[i] - start_[i]);
  }
  motion_so_far_ = std::max(motion_so_far_, std::min(largest, motion_));
  findShift();
}

void SoftSurface::findShift() {
  for (std::size_t i = 0; i < shift_.size(); ++i) shift_[i] = base_.place()[i] + now_[i];
  has_moved_ = true;
  ++motions_;
  skin_.forget();
}

void SoftSurface::beginStep(double share, double max_motion, double motion) {
  motion_ = motion;
  ahead_ = from_ahead_ = motion_so_far_ = 0;
  last_bent_ = bent_;
  if (base_.follow(share, max_motion)) {
    ahead_ = 1;
    findShift();
  }
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
  base_.takeBack();
  force_ = start_force_;
  now_ = start_;
  knows_to_ = false;
  ahead_ = from_ahead_ = 0;
  is_pressed_ = is_pressed_ || anyIn(force_);
  findShift();
  bent_ = last_bent_;
  skin_.bend(bent_);
}

}  // namespace spheretree::runtime
