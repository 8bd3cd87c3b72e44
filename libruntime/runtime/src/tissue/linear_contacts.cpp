// SPDX-License-Identifier: Apache-2.0
#include "tissue/linear_contacts.h"

#include <algorithm>
#include <cmath>

#include "rows/row_set.h"

namespace spheretree::runtime {
namespace {

constexpr double kSticks = 1 - 1e-6;  // share of its friction limit: with less, a contact does not slip

}  // namespace

using Eigen::Vector3d;

LinearContacts::LinearContacts(StepMemory& memory, const std::vector<std::unique_ptr<SoftSurface>>& surfaces)
    : memory_(memory), scene_(memory.scene), surfaces_(surfaces) {
  std::size_t nodes = 0;
  for (const auto& surface : surfaces_)
    if (surface) nodes = std::max(nodes, surface->forces().size() / 3);
  rows_.resize(2 * (scene_.step_limits.max_pairs + std::size_t{16}));
  for (std::vector<Eigen::Matrix3d>& response : responses_) response.resize(nodes);
  for (std::vector<double>& field : fields_) field.resize(3 * nodes);
  sum_.resize(3 * nodes);
}

void LinearContacts::begin(const PairSet& pairs, const PairSet& felt, const RowSet& rows, const Configuration& tool, bool is_carried) {
  is_carried_ = is_carried;
  for (Pressed& p : pressed_) p.surface = nullptr;
  for (const PairRun& run : pairs.runs)
    if (memory_.isTissue(run.object)) surfaces_[run.object]->response().forgetNear(), addRows(run, pairs, 0, rows, tool);
  for (const PairRun& run : felt.runs)
    if (memory_.isTissue(run.object)) addRows(run, felt, rows.guarded, rows, tool);
}

void LinearContacts::addRows(const PairRun& run, const PairSet& set, std::uint32_t first, const RowSet& rows, const Configuration& tool) {
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
      out.point = surface->skin().pointAt(triangle, turn * Vector3d(ball.x, ball.y, ball.z) + offset - std::min(beside, 1e6) * out.normal);
    }
    out.given = -out.normal.dot(surface->given(out.point));
    // A point moves no farther than maxGive() from its position at rest, in any direction.
    const Vector3d travelled = surface->travelled(out.point);
    const double pressed_in = -out.normal.dot(travelled), max_give = surface->maxGive(out.point),
                 room2 = max_give * max_give - (travelled.squaredNorm() - pressed_in * pressed_in);
    out.stop = out.b - static_cast<float>(out.weight * (room2 > 0 ? std::sqrt(room2) - pressed_in : 0));
    if (first == 0) surface->response().addNear(triangle);
  }
}

// The compliance of the surface between this force, which acts at the point of a row, and the others.
void LinearContacts::addForce(const ContactProblem& qp, std::size_t force, std::size_t row) {
  const Pressed& pressed = pressed_[force];
  if (pressed.surface)
    for (std::size_t i = 0; i < pressed.surface->response().nearCount(); ++i)
      Eigen::Map<Vector3d>(fields_[force].data() + 3 * i) = responses_[row][i] * pressed.pull;
  forForces(qp, [&](std::size_t i, double) {
    const Pressed& other = pressed_[i];
    const bool is_shared = pressed.surface && other.surface == pressed.surface;
    const double give =
        is_shared ? other.pull.dot(pressed.surface->response().meanOf(other.on, fields_[force])) / scene_.pull.translation : 0;
    compliance_[force][i] = compliance_[i][force] = give;
  });
}

void LinearContacts::setRow(ContactProblem& qp, int k, std::uint32_t object, std::uint32_t row, bool is_stop) {
  const auto at = static_cast<std::size_t>(k);
  Pressed& pressed = pressed_[at];
  pressed.surface = nullptr;
  if (memory_.isTissue(object)) {
    const Row& on = rows_[row];
    ContactRow& r = qp.rows[at];
    if (is_stop) {
      r.b = static_cast<double>(on.stop);
    } else {
      pressed = {on.surface, on.surface->response().pressOn(on.point), scene_.pull.translation * on.weight * on.normal};
      on.surface->response().respond(pressed.on, responses_[at]);
    }
    if (!is_stop && !is_carried_)
      r.b += on.weight * on.given;  // forces are relative to the shape at rest; in a carried piece, to the current shape
  }
  addForce(qp, at, at);
}

// A contact moves the surface in tangential directions, too. It slips by the rest of its motion.
void LinearContacts::setDisc(ContactProblem& qp, int d, std::uint32_t object, std::uint32_t row, bool is_stop,
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

void LinearContacts::predict(const ContactProblem& qp) {
  for (const auto& surface : surfaces_) {
    if (!surface || surface->response().nearCount() == 0) continue;
    const std::size_t size = 3 * surface->response().nearCount();
    std::fill_n(sum_.begin(), size, 0.0);
    forForces(qp, [&](std::size_t force, double multiplier) {
      if (pressed_[force].surface != surface.get() || multiplier == 0) return;
      for (std::size_t i = 0; i < size; ++i) sum_[i] -= multiplier * fields_[force][i];
    });
    surface->response().predict(sum_);
  }
}

float LinearContacts::predictedBound(std::uint32_t row, bool& is_stop) const {
  const Row& on = rows_[row];
  const double then = -on.normal.dot(on.surface->response().predicted(on.point)), more = is_carried_ ? then : then - on.given;
  const float bound = on.b - static_cast<float>(on.weight * more);
  is_stop = on.stop > bound;
  return std::max(bound, on.stop);
}

void LinearContacts::press(const ContactProblem& qp, std::span<const std::uint32_t> contacts) {
  for (std::size_t k = 0; k < contacts.size(); ++k) contacts_[k] = rows_[contacts[k]].point;
  for (const auto& s : surfaces_)
    if (s) s->aimAt(is_carried_);
  forForces(qp, [&](std::size_t force, double multiplier) {
    if (const Pressed& p = pressed_[force]; p.surface && multiplier != 0) p.surface->press(p.on, -multiplier * p.pull);
  });
}

void LinearContacts::setStuck(const ContactProblem& qp, std::size_t d, std::uint32_t row, double limit) {
  const Row& on = rows_[row];
  if (is_carried_ || !pressed_[forceOf(d, 0)].surface || !on.is_felt) return;
  const std::array<double, 2>& force = qp.discs[d].force;
  on.surface->skin().setStuck(on.pair, std::hypot(force[0], force[1]) < kSticks * limit);
}

}  // namespace spheretree::runtime
