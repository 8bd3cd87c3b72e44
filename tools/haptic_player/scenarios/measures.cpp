// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenarios/measures.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace spheretree::player {
namespace {

constexpr double kNear = 0.5;       // pairs up to this distance are tested at every pose [mm]
constexpr double kRounding = 1e-9;  // more than the error of a signed distance [mm]
constexpr double kBurrShare = 0.1;  // a leaf is of the burr within a ball that is larger by this share, or twice the overhang
constexpr double kInLine = 1e-3;    // steps of a burr whose centres are this near to a line are one capsule [mm]
constexpr double kAxisStep = 0.05;  // distance of tested points of an axis, and of its tested places [mm]
constexpr double kAxis = 10;        // length of the axis that is tested [mm of the scenario]
constexpr int kBallPoints = 400;    // by which the depth of a ball is found: 0.4 % of its radius

Eigen::Vector3d place(const Configuration& pose, const Eigen::Vector3d& p) { return pose.orientation * p + pose.position; }
Eigen::Vector3d placeBack(const Configuration& pose, const Eigen::Vector3d& p) {
  return pose.orientation.conjugate() * (p - pose.position);
}

/// Applies `value(before, after)` to consecutive elements and returns the largest result.
template <class Value>
double largestOverSteps(std::span<const RecordedStep> rows, const Value& value) {
  double largest = 0;
  for (std::size_t i = 1; i < rows.size(); ++i) largest = std::max(largest, value(rows[i - 1], rows[i]));
  return largest;
}

}  // namespace

LeafPenetration::LeafPenetration(const SphereTree& tool, const Eigen::Vector3d& reference_point, std::span<const PlacedBody> objects,
                                 runtime::ContactSurface contact)
    : tool_(leavesOf(tool, {-reference_point, {1, 0, 0, 0}})) {
  for (const Ball& b : tool_) reach_ = std::max(reach_, b.centre.norm());
  for (const PlacedBody& object : objects) {
    if (object.body->soft) {  // it has moved
      objects_.push_back({object.body, object.pose, false, {}, {Eigen::Vector3d::Zero(), 0}});
      continue;
    }
    const bool has_skin = contact == runtime::ContactSurface::Skin && !object.body->tree.skin.empty();
    Object made{object.body, object.pose, has_skin, leavesOf(object.body->tree, object.pose), {Eigen::Vector3d::Zero(), 0}};
    for (const Ball& b : made.balls) made.around.centre += b.centre / static_cast<double>(made.balls.size());
    for (const Ball& b : made.balls) made.around.radius = std::max(made.around.radius, (b.centre - made.around.centre).norm() + b.radius);
    objects_.push_back(std::move(made));
  }
}

std::vector<LeafPenetration::Ball> LeafPenetration::leavesOf(const SphereTree& tree, const Configuration& pose) {
  std::vector<Ball> leaves;
  const Eigen::Vector3d origin(tree.origin_mm[0], tree.origin_mm[1], tree.origin_mm[2]);
  for (std::size_t n = 0; n < tree.nodeCount(); ++n)
    if (tree.isLeaf(n)) {
      const Sphere& s = tree.cover[n];
      leaves.push_back({place(pose, centreOf(s) + origin), static_cast<double>(s.radius)});
    }
  return leaves;
}

void LeafPenetration::listNear(const Configuration& pose) {
  near_.clear();
  near_pose_ = pose;
  std::vector<Eigen::Vector3d> centres;
  for (const Ball& t : tool_) centres.push_back(place(pose, t.centre));
  for (std::uint32_t i = 0; i < objects_.size(); ++i) {
    const Ball& around = objects_[i].around;
    for (std::uint32_t t = 0; t < tool_.size(); ++t) {
      if ((centres[t] - around.centre).norm() > around.radius + tool_[t].radius + kNear) continue;
      if (objects_[i].has_skin) {
        if (depthIn(objects_[i], centres[t], tool_[t].radius + kNear) > 0) near_.push_back({i, t, kMesh});
        continue;
      }
      for (std::uint32_t o = 0; o < objects_[i].balls.size(); ++o) {
        const Ball& ball = objects_[i].balls[o];
        const double near = tool_[t].radius + ball.radius + kNear;
        if ((centres[t] - ball.centre).squaredNorm() < near * near) near_.push_back({i, t, o});
      }
    }
  }
}

// Depth of a ball in the mesh, minus the tolerances of the skin.
double LeafPenetration::depthIn(const Object& object, const Eigen::Vector3d& centre, double radius) const {
  const Skin& skin = object.body->tree.skin;
  return radius - object.body->field.signedDistance(placeBack(object.pose, centre)) - static_cast<double>(skin.tolerance) -
         static_cast<double>(skin.mesh_distance);
}

double LeafPenetration::at(const Configuration& pose, int only) {
  const auto farthest = [&](const Displacement& way) { return way.translation.norm() + reach_ * way.rotation.norm(); };
  if (!near_pose_ || !(farthest(displacementBetween(*near_pose_, pose)) < kNear)) listNear(pose);
  double deepest = 0;
  for (const Pair& pair : near_) {
    if (only >= 0 && pair.object != static_cast<std::uint32_t>(only)) continue;
    const Ball& t = tool_[pair.tool_ball];
    if (pair.object_ball == kMesh) {
      deepest = std::max(deepest, depthIn(objects_[pair.object], place(pose, t.centre), t.radius));
      continue;
    }
    const Ball& o = objects_[pair.object].balls[pair.object_ball];
    const Eigen::Vector3d between = place(pose, t.centre) - o.centre;
    const double touch = t.radius + o.radius - deepest;
    if (touch > 0 && between.squaredNorm() < touch * touch) deepest = t.radius + o.radius - between.norm();
  }
  return deepest;
}

void LeafPenetration::moveObject(std::size_t object, const Eigen::Vector3d& way) {
  for (Ball& b : objects_[object].balls) b.centre += way;
  objects_[object].around.centre += way;
  objects_[object].pose.position += way;
  near_pose_.reset();
}

CutPenetration::CutPenetration(const Body& tool, const Eigen::Vector3d& reference_point, const PlacedBody& object, std::vector<Ball> burr)
    : field_(object.body->field),
      place_(object.pose),
      burr_(std::move(burr)),
      along_(tool.frame.turn * Eigen::Vector3d::UnitZ()),
      length_(kAxis * tool.frame.scale),
      growing_(burr_.size()) {
  const Eigen::Vector3d origin(tool.tree.origin_mm[0], tool.tree.origin_mm[1], tool.tree.origin_mm[2]);
  const double overhang = static_cast<double>(tool.tree.statistics.back().overhang_bound);
  for (std::size_t n = 0; n < tool.tree.nodeCount(); ++n) {
    if (!tool.tree.isLeaf(n)) continue;
    const Ball leaf{centreOf(tool.tree.cover[n]) + origin - reference_point, static_cast<double>(tool.tree.cover[n].radius)};
    const auto isWithin = [&](const Ball& b) {
      return (leaf.centre - b.centre).norm() + leaf.radius <= b.radius + std::max(kBurrShare * b.radius, 2 * overhang);
    };
    if (std::none_of(burr_.begin(), burr_.end(), isWithin)) firm_.push_back(leaf);
  }
}

double CutPenetration::depthAt(const Eigen::Vector3d& point) const {
  double depth = -field_.signedDistance(point);
  for (const builder::Capsule& c : capsules_) depth = std::min(depth, (point - builder::nearestOnAxis(c, point)).norm() - c.radius);
  return depth;
}

void CutPenetration::sweep(std::size_t ball, const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  constexpr std::size_t kLongest = 256;  // steps in a capsule: bounds the cost of a burr that rests
  Growing& last = growing_[ball];
  bool goes_on = !last.centres.empty() && last.centres.size() < kLongest && last.centres.back() == from;
  if (goes_on) {
    builder::Capsule longer = capsules_[last.capsule];
    longer.to = to;
    for (const Eigen::Vector3d& p : last.centres) goes_on = goes_on && (p - builder::nearestOnAxis(longer, p)).norm() <= kInLine;
    if (goes_on) capsules_[last.capsule] = longer;
  }
  if (!goes_on) {
    last = {capsules_.size(), {from}};
    capsules_.push_back({from, to, burr_[ball].radius});
  }
  last.centres.push_back(to);
}

bool CutPenetration::isAxisInside(const Configuration& pose) const {
  const Eigen::Vector3d from = place(pose, burr_[0].centre), along = pose.orientation * along_;
  for (double at = 0; at <= length_;) {
    const double depth = depthAt(from + at * along);
    if (depth > 0) return true;
    at += std::max(kAxisStep, -depth);
  }
  return false;
}

void CutPenetration::moveTo(const Configuration& world, bool cuts) {
  const Configuration pose{placeBack(place_, world.position), place_.orientation.conjugate() * world.orientation};
  cuts_ = cuts;
  if (pose_ && cuts)
    for (std::size_t ball = 0; ball < burr_.size(); ++ball) sweep(ball, place(*pose_, burr_[ball].centre), place(pose, burr_[ball].centre));
  if (pose_) {
    const Displacement way = displacementBetween(*pose_, pose);
    const double longest = way.translation.norm() + (length_ + burr_[0].centre.norm()) * way.rotation.norm();
    const int places = 1 + static_cast<int>(longest / kAxisStep);
    bool is_inside = false;
    for (int k = 1; k <= places && !is_inside; ++k) {
      const double share = double(k) / places;
      is_inside = isAxisInside(moved(*pose_, {share * way.translation, share * way.rotation}));
    }
    passages_ += is_inside;
  }
  pose_ = pose;
}

// The deepest of points of its surface, or its centre. A ball whose centre is farther outside than its radius is free.
double CutPenetration::depthOf(const Eigen::Vector3d& centre, double radius) const {
  static const std::vector<Eigen::Vector3d> directions = [] {
    std::vector<Eigen::Vector3d> out;
    for (int i = 0; i < kBallPoints; ++i) {  // the spiral of equal areas
      const double z = 1 - (2 * i + 1.0) / kBallPoints, around = std::numbers::pi * (3 - std::sqrt(5.0)) * i, r = std::sqrt(1 - z * z);
      out.emplace_back(r * std::cos(around), r * std::sin(around), z);
    }
    return out;
  }();
  const double middle = depthAt(centre);
  if (middle + radius <= 0) return 0;
  std::vector<std::pair<double, const builder::Capsule*>> near;
  double nearest = radius;
  for (const builder::Capsule& c : capsules_) {
    near.emplace_back((centre - builder::nearestOnAxis(c, centre)).norm() - c.radius, &c);
    nearest = std::min(nearest, near.back().first);
  }
  std::erase_if(near, [&](const auto& c) { return c.first > nearest + 2 * radius; });
  std::sort(near.begin(), near.end());
  double deepest = std::max(0.0, middle);
  for (const Eigen::Vector3d& direction : directions) {
    const Eigen::Vector3d p = centre + radius * direction;
    double depth = radius + std::max(0.0, middle);
    for (const auto& [gap, c] : near) {
      depth = std::min(depth, (p - builder::nearestOnAxis(*c, p)).norm() - c->radius);
      if (depth <= deepest) break;
    }
    if (depth > deepest) deepest = std::max(deepest, std::min(depth, -field_.signedDistance(p)));
  }
  return deepest;
}

double CutPenetration::depth() const {
  double deepest = 0;
  const auto look = [&](const Ball& ball) { deepest = std::max(deepest, depthOf(place(*pose_, ball.centre), ball.radius)); };
  if (!pose_) return 0;
  for (const Ball& leaf : firm_) look(leaf);
  if (!cuts_)
    for (const Ball& ball : burr_) look(ball);
  return deepest;
}

std::vector<Eigen::Vector3d> surfacePoints(const TriangleMesh& mesh, double spacing) {
  std::vector<Eigen::Vector3d> points = mesh.positions;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Eigen::Vector3d &a = mesh.corner(t, 0), &b = mesh.corner(t, 1), &c = mesh.corner(t, 2);
    const int n = static_cast<int>(std::ceil(std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()}) / spacing));
    for (int i = 0; i <= n; ++i)
      for (int j = 0; i + j <= n; ++j)
        if (i != n && j != n && i + j != 0) points.push_back(a + (b - a) * (double(i) / n) + (c - a) * (double(j) / n));
  }
  return points;
}

MeshPenetration::MeshPenetration(const Body& tool, const Eigen::Vector3d& reference_point, std::vector<PlacedBody> objects, double spacing)
    : tool_(tool), reference_point_(reference_point), objects_(std::move(objects)), tool_points_(surfacePoints(tool.mesh, spacing)) {
  for (const PlacedBody& object : objects_) object_points_.emplace_back(surfacePoints(object.body->mesh, spacing));
}

double MeshPenetration::at(const Configuration& pose) const {
  double deepest = 0;
  // Whether a point within `radius` of `p` may be deeper than the deepest so far: the signed distance changes by no
  // more than the way. The box comes first, since it decides most places.
  const auto mayBeDeeper = [&](const Body& body, const Eigen::Vector3d& p, double radius) {
    const Eigen::AlignedBox3d& box = body.field.box();
    const double least = deepest - radius - kRounding;
    if ((p - box.min()).minCoeff() <= least || (box.max() - p).minCoeff() <= least) return false;
    return -body.field.signedDistance(p) > least;
  };
  const auto look = [&](const Body& body, const Points& points, const auto& inBody) {
    points.tree.visit([&](const Eigen::Vector3d& centre, double radius) { return mayBeDeeper(body, inBody(centre), radius); },
                      [&](std::uint32_t i) { deepest = std::max(deepest, -body.field.signedDistance(inBody(points.places[i]))); });
  };
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    const PlacedBody& object = objects_[i];
    look(*object.body, tool_points_,
         [&](const Eigen::Vector3d& p) -> Eigen::Vector3d { return placeBack(object.pose, place(pose, p - reference_point_)); });
    look(tool_, object_points_[i],
         [&](const Eigen::Vector3d& p) -> Eigen::Vector3d { return placeBack(pose, place(object.pose, p)) + reference_point_; });
  }
  return deepest;
}

double largestLRatio(std::span<const RecordedStep> rows, const runtime::Coupling& k) {
  return largestOverSteps(rows, [&](const RecordedStep& a, const RecordedStep& b) {
    const Displacement way = displacementBetween(a.haptic, b.haptic);
    const double hand = std::sqrt(k.translation * way.translation.squaredNorm() + k.rotation * way.rotation.squaredNorm());
    const double wrench = std::sqrt((b.wrench.force - a.wrench.force).squaredNorm() / k.translation +
                                    (b.wrench.torque - a.wrench.torque).squaredNorm() / k.rotation);
    return hand < 1e-9 ? 0.0 : wrench / hand;
  });
}

double largestForceJump(std::span<const RecordedStep> rows, const runtime::Coupling& k) {
  return largestOverSteps(rows, [&](const RecordedStep& a, const RecordedStep& b) {
    const double allowed = std::max(0.1, 0.07 * std::max(a.wrench.force.norm(), b.wrench.force.norm()));
    const double hand = k.translation * (b.haptic.position - a.haptic.position).norm();
    return ((b.wrench.force - a.wrench.force).norm() - hand) / allowed;
  });
}

double largestTorqueJump(std::span<const RecordedStep> rows, const runtime::Coupling& k) {
  return largestOverSteps(rows, [&](const RecordedStep& a, const RecordedStep& b) {
    const double allowed = std::max(5.0, 0.13 * std::max(a.wrench.torque.norm(), b.wrench.torque.norm()));
    const double hand = k.rotation * displacementBetween(a.haptic, b.haptic).rotation.norm();
    return ((b.wrench.torque - a.wrench.torque).norm() - hand) / allowed;
  });
}

Eigen::Vector3d offsetEdge(const Eigen::Vector3d& h, double r) {
  const Eigen::Vector2d p(h.x(), h.z()), nearest = p.cwiseMin(0.0), way = p - nearest;
  if (way.norm() >= r) return h;
  if (p.x() > 0 && p.y() > 0) return {p.x() * r / p.norm(), h.y(), p.y() * r / p.norm()};
  // Beside or inside the solid: the nearer face, except where the arc is nearer.
  if (p.y() >= p.x()) return {p.x(), h.y(), r};
  return {r, h.y(), p.y()};
}

Eigen::Vector3d offsetGroove(const Eigen::Vector3d& h, double r, double half_angle) {
  // Free: cos(a) |x| - sin(a) z <= -r, that is, inside both half planes of the walls, moved in by r.
  const double c = std::cos(half_angle), s = std::sin(half_angle), x = std::abs(h.x()), sign = h.x() < 0 ? -1 : 1;
  const double bottom = r / s, depth = c * x - s * h.z() + r;
  if (depth <= 0) return h;
  const double px = x - depth * c, pz = h.z() + depth * s;  // nearest point on this wall
  if (px >= 0) return {sign * px, h.y(), pz};
  return {0, h.y(), bottom};
}

}  // namespace spheretree::player
