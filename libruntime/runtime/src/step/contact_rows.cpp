// SPDX-License-Identifier: Apache-2.0
#include "step/contact_rows.h"

#include <algorithm>
#include <cmath>

#include "state/moving_bodies.h"

namespace spheretree::runtime {
namespace {

constexpr double kMaxGive = 0.5;  // share of the smallest distance of two centres: limit by which an object yields

// Two tangents that are perpendicular to the unit vector `n` and to each other.
// Paper: T. Duff et al. Building an orthonormal basis, revisited. Journal of Computer Graphics Techniques 6(1), 2017.
ContactRows::Tangents tangentsOf(const Eigen::Vector3d& n) {
  const double sign = std::copysign(1.0, n[2]), a = -1 / (sign + n[2]), b = n[0] * n[1] * a;
  return {{1 + sign * n[0] * n[0] * a, sign * b, -sign * n[0]}, {b, sign + n[1] * n[1] * a, -n[1]}};
}

}  // namespace

int ContactRows::placeOf(std::uint32_t row, bool is_stop) const {
  int k = problem_.row_count;
  while (--k >= 0)
    if (row_[static_cast<std::size_t>(k)] == row && is_stop_[static_cast<std::size_t>(k)] == is_stop) break;
  return k;
}

int ContactRows::groupOf(std::uint32_t object) {
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
  if (tissue_) tissue_->setRow(problem_, problem_.row_count - 1, object, ~0u, false);
  return g;
}

int ContactRows::takeIn(std::uint32_t row, double multiplier, bool is_stop) {
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
  if (tissue_) tissue_->setRow(problem_, k, name.object, row, is_stop);
  if (parts_.rubs && scene_.objects[name.object].friction > 0) addDisc(k, name);
  return k;
}

void ContactRows::addDisc(int k, const RowName& name) {
  const auto at = static_cast<std::size_t>(k), d = static_cast<std::size_t>(problem_.disc_count++);
  const double weight = static_cast<double>(rows_.weight[row_[at]]);
  const Eigen::Vector3d* const rubbing = parts_.rubbingOf(name);
  const Eigen::Vector3d normal = problem_.rows[at].a.head<3>() / weight, arm = armOf(scene_, rows_, row_[at], name, normal, rotation_),
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
  if (tissue_) tissue_->setDisc(problem_, static_cast<int>(d), name.object, row_[at], is_stop_[at], {t.first, t.second});
}

void ContactRows::keep() {
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
    if (tissue_) tissue_->setStuck(problem_, d, row_[at], friction_[d] * multiplier);
    memory_.active_rubbing[slot] += problem_.discs[d].force[0] * tangents_[d].first + problem_.discs[d].force[1] * tangents_[d].second;
  }
  for (std::size_t i = 0; i < memory_.give.size(); ++i) {
    memory_.give_from[i] = memory_.give[i];
    memory_.give_to[i] = 0;
  }
  for (int g = 0; g < problem_.group_count; ++g) {
    const auto at = static_cast<std::size_t>(g);
    memory_.give_to[group_object_[at]] = std::max(0.0, problem_.given[at] * group_scale_[at]);
  }
}

double ContactRows::giveOf(std::uint32_t object) const {
  double give = 0;
  for (int g = 0; g < problem_.group_count; ++g)
    if (group_object_[static_cast<std::size_t>(g)] == object)
      give = problem_.given[static_cast<std::size_t>(g)] * group_scale_[static_cast<std::size_t>(g)];
  return give;
}

}  // namespace spheretree::runtime
