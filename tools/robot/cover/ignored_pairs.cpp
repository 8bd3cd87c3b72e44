// SPDX-License-Identifier: GPL-3.0-or-later
#include "robot/cover/ignored_pairs.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <stdexcept>

namespace spheretree::robot {
namespace {

/// The kinematic chain between two links: the joints from their common ancestor down to each link, and the variables
/// that move them.
class Chain {
 public:
  Chain(const Robot& robot, std::size_t a, std::size_t b) : robot_(robot) {
    std::vector<std::size_t> to_a = jointsTo(a), to_b = jointsTo(b);
    std::size_t shared = 0;
    while (shared < to_a.size() && shared < to_b.size() && to_a[shared] == to_b[shared]) ++shared;
    side_[0].assign(to_a.begin() + static_cast<std::ptrdiff_t>(shared), to_a.end());
    side_[1].assign(to_b.begin() + static_cast<std::ptrdiff_t>(shared), to_b.end());
    for (const std::vector<std::size_t>& side : side_)
      for (const std::size_t j : side) addVariable(j);
  }

  /// False for joints whose positions are not an interval.
  bool isBounded() const { return is_bounded_; }
  std::size_t size() const { return low_.size(); }
  double low(std::size_t v) const { return low_[v]; }
  double high(std::size_t v) const { return high_[v]; }

  /// The frame of b in the frame of a.
  Eigen::Isometry3d frame(const std::vector<double>& at) const { return frameOf(side_[0], at).inverse() * frameOf(side_[1], at); }

  /// Upper bound of the motion of a point on a side, for a unit of each variable. The point is at most `reach_a` or
  /// `reach_b` from the origin of its link.
  std::vector<double> speeds(double reach_a, double reach_b) const {
    std::vector<double> speed(low_.size(), 0);
    for (int s = 0; s < 2; ++s) {
      double reach = s == 0 ? reach_a : reach_b;  // distance from the frame of the joint's child to the farthest point
      for (auto j = side_[s].rbegin(); j != side_[s].rend(); ++j) {
        const Joint& joint = robot_.joints[*j];
        const auto variable = variableOf(*j);
        if (variable) speed[variable->index] += std::abs(variable->factor) * (joint.kind == JointKind::Prismatic ? 1 : reach);
        if (variable && joint.kind == JointKind::Prismatic)
          reach += std::max(std::abs(position(*variable, low_)), std::abs(position(*variable, high_)));
        reach += joint.origin.translation().norm();
      }
    }
    return speed;
  }

 private:
  struct Variable {
    std::size_t index;
    double factor, offset;
  };

  std::vector<std::size_t> jointsTo(std::size_t link) const {
    std::vector<std::size_t> joints;
    for (std::size_t at = link; robot_.parent_joint[at]; at = robot_.joints[*robot_.parent_joint[at]].parent)
      joints.push_back(*robot_.parent_joint[at]);
    std::reverse(joints.begin(), joints.end());
    return joints;
  }

  void addVariable(std::size_t j) {
    const Joint& joint = robot_.joints[j];
    if (joint.kind == JointKind::Fixed) return;
    const std::size_t master = joint.mimic ? joint.mimic->joint : j;
    const Joint& leading = robot_.joints[master];
    is_bounded_ = is_bounded_ && joint.kind != JointKind::Floating && joint.kind != JointKind::Planar;
    if (index_.contains(master)) return;
    index_.emplace(master, low_.size());
    const bool turns = leading.kind == JointKind::Continuous;
    low_.push_back(turns ? -std::numbers::pi : leading.lower);
    high_.push_back(turns ? std::numbers::pi : leading.upper);
    // A continuous joint that others follow with another factor does not return to the same configuration after a full
    // turn.
    for (const Joint& other : robot_.joints)
      if (turns && other.mimic && other.mimic->joint == master) is_bounded_ = false;
  }

  std::optional<Variable> variableOf(std::size_t j) const {
    const Joint& joint = robot_.joints[j];
    if (joint.kind == JointKind::Fixed) return std::nullopt;
    return Variable{index_.at(joint.mimic ? joint.mimic->joint : j), joint.mimic ? joint.mimic->factor : 1,
                    joint.mimic ? joint.mimic->offset : 0};
  }

  static double position(const Variable& v, const std::vector<double>& at) { return v.factor * at[v.index] + v.offset; }

  Eigen::Isometry3d frameOf(const std::vector<std::size_t>& side, const std::vector<double>& at) const {
    Eigen::Isometry3d frame = Eigen::Isometry3d::Identity();
    for (const std::size_t j : side) {
      const auto variable = variableOf(j);
      frame = frame * jointFrame(robot_.joints[j], variable ? position(*variable, at) : 0);
    }
    return frame;
  }

  const Robot& robot_;
  std::vector<std::size_t> side_[2];
  std::map<std::size_t, std::size_t> index_;  // index of the variable that moves a joint
  std::vector<double> low_, high_;
  bool is_bounded_ = true;
};

struct JointBox {
  std::vector<double> middle, half;
};

/// The smallest gap of two sets of balls, with b moved by `frame`; negative if they overlap.
double minGap(const std::vector<LinkBall>& a, const std::vector<LinkBall>& b, const Eigen::Isometry3d& frame) {
  double smallest = std::numeric_limits<double>::infinity();
  for (const LinkBall& of_b : b) {
    const Eigen::Vector3d centre = frame * of_b.centre;
    for (const LinkBall& of_a : a) smallest = std::min(smallest, (centre - of_a.centre).norm() - of_a.radius - of_b.radius);
  }
  return smallest;
}

double reachOf(const std::vector<LinkBall>& balls) {
  double reach = 0;
  for (const LinkBall& ball : balls) reach = std::max(reach, ball.centre.norm());
  return reach;
}

/// Always, Never or neither: determined at the middle of the limits, and then proven box by box.
std::optional<PairReason> decide(const Chain& chain, const std::vector<LinkBall>& a, const std::vector<LinkBall>& b, std::size_t max_boxes,
                                 const builder::Progress& progress) {
  if (!chain.isBounded()) return std::nullopt;
  const std::vector<double> speed = chain.speeds(reachOf(a), reachOf(b));
  JointBox whole;
  for (std::size_t v = 0; v < chain.size(); ++v) {
    whole.middle.push_back((chain.low(v) + chain.high(v)) / 2);
    whole.half.push_back((chain.high(v) - chain.low(v)) / 2);
  }
  const double rounding = 1e-9 * (1 + reachOf(a) + reachOf(b));  // generous bound of the rounding errors of frames and distances [mm]
  const bool touches = minGap(a, b, chain.frame(whole.middle)) < 0;
  std::vector<JointBox> boxes{whole};
  for (std::size_t looked = 0; !boxes.empty(); ++looked) {
    if (looked == max_boxes) return std::nullopt;
    if (looked % 256 == 0) progress.check();
    const JointBox box = std::move(boxes.back());
    boxes.pop_back();
    const double gap = minGap(a, b, chain.frame(box.middle));
    if ((gap < 0) != touches) return std::nullopt;  // they touch in one configuration and not in another
    double swing = rounding;
    std::size_t widest = 0;
    for (std::size_t v = 0; v < speed.size(); ++v) {
      swing += speed[v] * box.half[v];
      if (speed[v] * box.half[v] > speed[widest] * box.half[widest]) widest = v;
    }
    if (std::abs(gap) > swing) continue;
    if (speed.empty() || !(speed[widest] * box.half[widest] > rounding)) return std::nullopt;
    for (const double side : {-0.5, 0.5}) {
      boxes.push_back(box);
      boxes.back().half[widest] /= 2;
      boxes.back().middle[widest] += side * box.half[widest];
    }
  }
  return touches ? PairReason::Always : PairReason::Never;
}

/// The nearest ancestor link with spheres; empty if there is none.
std::optional<std::size_t> coveredAbove(const Robot& robot, const std::vector<const LinkCover*>& cover_of, std::size_t link) {
  for (std::size_t at = link; robot.parent_joint[at];) {
    at = robot.joints[*robot.parent_joint[at]].parent;
    if (cover_of[at]) return at;
  }
  return std::nullopt;
}

}  // namespace

std::vector<IgnoredPair> findIgnoredPairs(const Robot& robot, const RobotCover& cover, const PairSearch& search,
                                          builder::Progress& progress) {
  progress.stage("pairs of links");
  std::vector<const LinkCover*> cover_of(robot.links.size(), nullptr);
  std::vector<std::vector<LinkBall>> balls(robot.links.size());
  for (const LinkCover& link : cover.links) {
    cover_of[link.link] = &link;
    for (const MetreSphere& sphere : link.spheres()) balls[link.link].push_back(linkBall(sphere));
  }
  struct Candidate {
    std::size_t a, b;
    std::optional<PairReason> reason;
  };
  std::vector<Candidate> candidates;
  for (std::size_t a = 0; a < robot.links.size(); ++a)
    for (std::size_t b = a + 1; b < robot.links.size(); ++b) {
      if (!cover_of[a] || !cover_of[b]) continue;
      const bool is_adjacent = coveredAbove(robot, cover_of, a) == b || coveredAbove(robot, cover_of, b) == a;
      candidates.push_back({a, b, is_adjacent ? std::optional(PairReason::Adjacent) : std::nullopt});
    }
  tbb::parallel_for(std::size_t{0}, candidates.size(), [&](std::size_t c) {
    Candidate& pair = candidates[c];
    if (pair.reason || progress.cancelled()) return;
    try {
      pair.reason = decide(Chain(robot, pair.a, pair.b), balls[pair.a], balls[pair.b], search.max_boxes, progress);
    } catch (const builder::Cancelled&) {  // reported below, by the calling thread
    }
  });
  progress.check();
  std::vector<IgnoredPair> out;
  for (const Candidate& pair : candidates)
    if (pair.reason) out.push_back({pair.a, pair.b, *pair.reason});
  return out;
}

}  // namespace spheretree::robot
