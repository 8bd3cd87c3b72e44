// SPDX-License-Identifier: Apache-2.0
#include "probe_arcs.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <set>

namespace spheretree::runtime {
namespace {

using Eigen::Vector3d;

constexpr double kBeside = 0.5;  // leaves no farther apart than this many median radii are side by side: another may lie low between them
constexpr double kTieBreak = 1e-6;  // median radii by which the probe that rolls takes a leaf for smaller at most, each by another part

Vector3d axisOf(const Leaf& a, const Leaf& b) { return (b.c - a.c).normalized(); }

// In [0, 1), another one for each, and without a pattern that rows and columns of leaves could follow.
double partOf(std::uint32_t leaf) {
  std::uint32_t bits = (leaf + 1) * 2654435761u;
  bits = (bits ^ bits >> 15) * 2246822519u;
  return static_cast<double>(bits ^ bits >> 13) * 0x1p-32;
}

}  // namespace

double pairDepth(const Leaf& a, const Leaf& b) {
  const double length = (b.c - a.c).norm(), slope = (a.r - b.r) / length;
  const double along = 0.5 * (length + (a.r * a.r - b.r * b.r) / length), high = std::sqrt(std::max(0.0, a.r * a.r - along * along));
  return a.r - (slope * along + std::sqrt(std::max(0.0, 1 - slope * slope)) * high);
}

// Of the centre of a probe that touches one or two leaves, with angles about `axis` from `from`.
struct ProbeArcs::Circle {
  std::uint32_t i, j;
  double probe, rho;
  Vector3d middle, axis, from, across;
  double inverse = 0.5 / rho;

  Vector3d at(double angle) const { return middle + rho * (from * std::cos(angle) + across * std::sin(angle)); }

  // A ball is in the way of the probe where u . (x, y) > most, u the unit vector of an angle.
  struct Obstacle {
    double x, y, q, most;
  };
  // Of a ball that together with the probe reaches `reach`.
  Obstacle obstacle(const Vector3d& c, double reach) const {
    const Vector3d w = c - middle;
    const double q = (rho - reach) * (rho + reach) + w.squaredNorm();
    return {w.dot(from), w.dot(across), q, q * inverse};
  }
  // Square angles between which it is; false if nowhere. All round: 0 to 0.
  bool blocks(const Obstacle& b, double& low, double& high) const {
    const double off = std::sqrt(b.x * b.x + b.y * b.y), scale = 2 * rho * off;
    if (b.q >= scale) return false;
    low = high = 0;
    if (b.q <= -scale) return true;
    const double cosine = b.q / scale, sine = std::sqrt(1 - cosine * cosine);
    low = pseudoAngle(b.x * cosine + b.y * sine, b.y * cosine - b.x * sine);
    high = pseudoAngle(b.x * cosine - b.y * sine, b.y * cosine + b.x * sine);
    return true;
  }
};

struct ProbeArcs::Contact {
  std::uint32_t leaf = kNone;
  CirclePart before{0, 4};  // how far it comes
};

ProbeArcs::ProbeArcs(std::span<const Sphere> leaves) : tree_(leaves) {
  std::vector<double> radii;
  for (const Sphere& s : leaves) {
    leaves_.push_back({{s.x, s.y, s.z}, static_cast<double>(s.radius)});
    radii.push_back(leaves_.back().r);
  }
  std::nth_element(radii.begin(), radii.begin() + static_cast<std::ptrdiff_t>(radii.size() / 2), radii.end());
  median_ = radii[radii.size() / 2];
  passed_over_.assign(leaves_.size(), false);
  neighbours_.resize(leaves_.size());
  std::vector<std::pair<double, std::uint32_t>> order;
  for (std::uint32_t i = 0; i < leaves_.size(); ++i) {
    order.clear();
    tree_.visit(leaves_[i].c, leaves_[i].r + kBeside * median_, [&](std::uint32_t j) {
      const double inside = leaves_[i].r - leaves_[j].r;
      if (j != i && (leaves_[i].c - leaves_[j].c).squaredNorm() > inside * inside) order.push_back({pairDepth(leaves_[i], leaves_[j]), j});
    });
    std::sort(order.begin(), order.end());
    for (const auto& [depth, j] : order) neighbours_[i].push_back(j);
  }
}

std::vector<Arc> ProbeArcs::ofNeighbours(double probe) const {
  std::vector<Arc> arcs;
  FreeArcs left;
  for (std::uint32_t i = 0; i < leaves_.size(); ++i)
    for (const std::uint32_t j : neighbours_[i])
      if (i < j) addArcs(i, j, probe, left, arcs);
  return arcs;
}

void ProbeArcs::addArcs(std::uint32_t i, std::uint32_t j, double probe, FreeArcs& left, std::vector<Arc>& arcs) const {
  const Leaf &a = leaves_[i], &b = leaves_[j];
  const double ra = a.r + probe, rb = b.r + probe, length = (b.c - a.c).norm();
  const double along = 0.5 * (length + (ra * ra - rb * rb) / length), rho2 = ra * ra - along * along;
  if (!(rho2 > 1e-12 * ra * ra)) return;
  const Vector3d axis = (b.c - a.c) / length, from = axis.unitOrthogonal();
  const Circle circle{i, j, probe, std::sqrt(rho2), a.c + along * axis, axis, from, axis.cross(from)};
  left.start();
  for (const std::uint32_t k : neighbours_[b.r < a.r ? j : i]) {  // the first of them hide most circles
    if (k == i || k == j) continue;
    const Circle::Obstacle ball = circle.obstacle(leaves_[k].c, leaves_[k].r + probe);
    double low, high;
    if (!left.reaches(ball.x, ball.y, ball.most) || !circle.blocks(ball, low, high)) continue;
    if (low == high) return;
    left.take(low, high, k);
    if (left.empty()) return;
  }
  for (const FreeArcs::Piece& p : left.whole())
    arcs.push_back({i, j, {p.low_end, p.high_end}, {trueAngle(p.low), trueAngle(p.high)}, from});
}

Vector3d ProbeArcs::directionAt(const Arc& arc, double angle) const {
  return arc.across * std::cos(angle) + axisOf(leaves_[arc.i], leaves_[arc.j]).cross(arc.across) * std::sin(angle);
}

Triple ProbeArcs::tripleAt(const Arc& arc, std::size_t end) const {
  Triple t{{arc.i, arc.j, arc.end[end]}, false};
  std::sort(t.leaf.begin(), t.leaf.end());
  const Vector3d& a = leaves_[t.leaf[0]].c;
  const Vector3d up = (leaves_[t.leaf[1]].c - a).cross(leaves_[t.leaf[2]].c - a);
  // At its end the probe is on the side to which the arc's direction points, against the third leaf.
  const Vector3d third = leaves_[arc.end[end]].c - leaves_[arc.i].c, axis = axisOf(leaves_[arc.i], leaves_[arc.j]);
  const Vector3d towards = third - axis * axis.dot(third), normal = axis.cross(towards);
  t.above = directionAt(arc, arc.angle[end]).dot(normal) * up.dot(normal) > 0;
  return t;
}

ProbeArcs::Circle ProbeArcs::circleOf(std::uint32_t i, std::uint32_t j, double probe, const Vector3d& through) const {
  const Leaf &a = leaves_[i], &b = leaves_[j];
  const Vector3d axis = axisOf(a, b);
  const Vector3d middle = a.c + axis * axis.dot(through - a.c), out = through - middle, from = out.normalized();
  return {i, j, probe, out.norm(), middle, axis, from, axis.cross(from)};
}

// Where the probe that sets out at 0 first meets a leaf. It touches `behind` there and leaves it.
ProbeArcs::Contact ProbeArcs::firstContact(const Circle& circle, std::uint32_t behind) const {
  Contact first;
  meet(circle, behind, tree_.levels().size(), 0, first);
  return first;
}

// Of what is in one group of the tree (above the last level: of all); what the probe meets sooner first, so that little else is looked at.
void ProbeArcs::meet(const Circle& circle, std::uint32_t behind, std::size_t level, std::size_t at, Contact& first) const {
  const std::vector<Sphere>& parts = tree_.levels()[level - 1];
  std::array<std::pair<double, std::size_t>, 8> ahead;
  std::size_t count = 0;
  for (std::size_t k = 8 * at; k < std::min(parts.size(), 8 * at + 8); ++k) {
    const bool is_leaf = level == 1;
    const std::uint32_t leaf = is_leaf ? tree_.order()[k] : kNone;
    if (is_leaf && (leaf == circle.i || leaf == circle.j || passed_over_[leaf])) continue;
    const double smaller = is_leaf ? kTieBreak * median_ * partOf(leaf) : 0;
    const Sphere& s = parts[k];
    const Circle::Obstacle ball = circle.obstacle({s.x, s.y, s.z}, static_cast<double>(s.radius) - smaller + circle.probe);
    double low, high;
    if (!first.before.reaches(ball.x, ball.y, ball.most) || !circle.blocks(ball, low, high)) continue;
    const double angle = low < high || (is_leaf && leaf == behind) ? low : 0;  // over 0: it is there from the start
    if (angle >= first.before.high) continue;
    if (is_leaf) {
      first = {leaf, {0, angle}};
      continue;
    }
    std::size_t n = count++;
    for (; n > 0 && angle < ahead[n - 1].first; --n) ahead[n] = ahead[n - 1];
    ahead[n] = {angle, k};
  }
  for (std::size_t n = 0; n < count && ahead[n].first < first.before.high; ++n) meet(circle, behind, level - 1, ahead[n].second, first);
}

std::vector<Arc> ProbeArcs::ofTheOutside(double probe) const {
  struct Corner {
    std::array<std::uint32_t, 3> leaf;
    Vector3d centre;  // of the probe
  };
  std::vector<Arc> arcs;
  std::vector<Corner> corners;
  std::set<Triple> seen;
  // A probe on top of the topmost leaf touches no other. It rolls over that leaf towards the nearest to a second, and over both to a third.
  std::uint32_t top = kNone, nearest = kNone;
  const auto height = [&](std::uint32_t i) { return leaves_[i].c.z() + leaves_[i].r; };
  for (std::uint32_t i = 0; i < leaves_.size(); ++i)
    if (!passed_over_[i] && (top == kNone || height(i) > height(top))) top = i;
  if (top == kNone) return arcs;
  const Leaf& first = leaves_[top];
  const auto away = [&](std::uint32_t i) { return (leaves_[i].c - first.c).norm(); };
  for (std::uint32_t i = 0; i < leaves_.size(); ++i)
    if (!passed_over_[i] && away(i) > std::abs(first.r - leaves_[i].r) && (nearest == kNone || away(i) < away(nearest))) nearest = i;
  if (nearest == kNone) return arcs;
  const Vector3d up = Vector3d::UnitZ(), to = leaves_[nearest].c - first.c, aside = to - up * to.z();
  const Vector3d across = aside.norm() > 1e-9 * to.norm() ? Vector3d(aside.normalized()) : Vector3d(Vector3d::UnitX());
  const Circle over{top, top, probe, first.r + probe, first.c, up.cross(across), up, across};
  const Contact second = firstContact(over, kNone);
  if (second.leaf == kNone) return arcs;
  const Circle about = circleOf(top, second.leaf, probe, over.at(trueAngle(second.before.high)));
  const Contact third = firstContact(about, kNone);
  if (third.leaf == kNone) return {{top, second.leaf, {kNone, kNone}, {0, kWholeTurn}, about.from}};
  corners.push_back({{top, second.leaf, third.leaf}, about.at(trueAngle(third.before.high))});
  const std::size_t most = 4 * leaves_.size();  // a surface without handles has 2 n - 4
  for (std::size_t n = 0; n < corners.size() && n < most; ++n) {
    const Corner corner = corners[n];
    for (std::size_t e = 0; e < 3; ++e) {
      const std::uint32_t i = corner.leaf[e], j = corner.leaf[(e + 1) % 3], k = corner.leaf[(e + 2) % 3];
      Circle circle = circleOf(i, j, probe, corner.centre);
      if (circle.across.dot(leaves_[k].c - circle.middle) > 0) circle = circleOf(j, i, probe, corner.centre);
      const Contact next = firstContact(circle, k);
      if (next.leaf == kNone) continue;
      const double angle = trueAngle(next.before.high);
      const Arc arc{circle.i, circle.j, {k, next.leaf}, {0, angle}, circle.from};
      const Triple here = tripleAt(arc, 0), there = tripleAt(arc, 1);
      seen.insert(here);
      if (here < there) arcs.push_back(arc);  // and not once more from the other end
      if (seen.insert(there).second) corners.push_back({{circle.i, circle.j, next.leaf}, circle.at(angle)});
    }
  }
  return arcs;
}

}  // namespace spheretree::runtime
