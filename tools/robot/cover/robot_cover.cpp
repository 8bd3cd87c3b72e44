// SPDX-License-Identifier: GPL-3.0-or-later
#include "robot/cover/robot_cover.h"

#include <fnmatch.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "base/useful_threads.h"
#include "pipeline/batch/batch_items.h"
#include "pipeline/batch/error_curve.h"
#include "pipeline/sound_mesh.h"
#include "program_end.h"
#include "robot/cover/capsule_row.h"
#include "spheretree/builder/build_sphere_tree.h"
#include "spheretree/core/rounding.h"

namespace spheretree::robot {
namespace {

using builder::Quality;

constexpr std::size_t kBranching = 8;
constexpr std::size_t kMaxLeaves = 4096;    // for one element: the deepest tree that is useful for a planner
constexpr int kRounds = 3;                  // rounds of redistribution by the errors of the final trees
constexpr std::size_t kProbes[] = {4, 16};  // numbers of leaves of the quick trees that show how an error decreases

/// Spheres of one element, with their proven bounds.
struct ElementCover {
  std::vector<std::vector<LinkBall>> levels;  // from the root to the leaves
  std::vector<double> overhang_bounds;        // (levels) [mm]
  bool is_tolerance_met = true;
};

/// A collision element while it is converted to spheres.
struct Element {
  ShapedElement shaped;
  builder::RepairedMesh solid;
  std::vector<std::string> notes;
  std::map<std::size_t, ElementCover> covers;  // by the requested number of leaves
  std::size_t leaves = 0;                      // number of leaves of the chosen cover
  const LinkShape& shape() const { return shaped.shape; }
  bool isBall() const { return shape().capsule && shape().capsule->a == shape().capsule->b; }
  const ElementCover& chosen() const { return covers.at(leaves); }
};

/// Elements that share a number of spheres.
struct Group {
  std::string name;
  std::vector<std::size_t> elements;
  std::size_t spheres = 0;  // 0: given by the tolerance
};

/// The balls of a tree about a surface within `padding` of its mesh.
ElementCover coverOf(const builder::BuildResult& result, double padding) {
  const SphereTree& tree = result.tree;
  const Eigen::Vector3d origin(tree.origin_mm[0], tree.origin_mm[1], tree.origin_mm[2]);
  ElementCover out;
  out.is_tolerance_met = result.statistics.tolerance_met;
  for (int level = 0; level < tree.levelCount(); ++level) {
    std::vector<LinkBall>& balls = out.levels.emplace_back();
    for (const std::uint32_t node : levelSet(tree, level))
      balls.push_back({origin + centreOf(tree.cover[node]), tree.cover[node].radius + padding});
    out.overhang_bounds.push_back(tree.statistics[static_cast<std::size_t>(level)].overhang_bound + padding);
  }
  return out;
}

/// Rows of balls, with as many levels as a tree of this number of leaves.
ElementCover coverOf(const LinkCapsule& capsule, std::size_t leaves) {
  ElementCover out;
  for (std::size_t count = 1;; count = std::min(leaves, count * kBranching)) {
    BallRow row = ballRow(capsule, count);
    out.levels.push_back(std::move(row.balls));
    out.overhang_bounds.push_back(row.overhang);
    if (count == leaves) return out;
  }
}

class RobotCoverer {
 public:
  RobotCoverer(const Robot& robot, std::vector<ShapedElement> shapes, const CoverSettings& settings, builder::Progress& progress)
      : robot_(robot), settings_(settings), progress_(progress) {
    for (ShapedElement& shaped : shapes) elements_.emplace_back().shaped = std::move(shaped);
  }

  RobotCover run() {
    const std::vector<Group> groups = groupElements();
    checkClips();
    progress_.stage("check meshes");
    inParallel(elements_.size(), [&](std::size_t e, builder::Progress& progress) { makeSolid(elements_[e], progress); });
    for (const Group& group : groups) {
      progress_.stage("cover " + group.name);
      if (group.spheres == 0)
        coverByTolerance(group);
      else
        coverByCount(group);
    }
    return collect();
  }

 private:
  std::string nameOf(const Element& e) const {
    return robot_.links[e.shaped.link].name + (e.shaped.name.empty() ? "" : " (" + e.shaped.name + ")");
  }

  /// The largest coordinate of the link's shapes along an axis [mm]; empty without shapes.
  std::optional<double> highest(const std::string& link, const Eigen::Vector3d& axis) const {
    std::optional<double> out;
    for (const Element& e : elements_) {
      if (robot_.links[e.shaped.link].name != link) continue;
      const auto reach = [&](const Eigen::Vector3d& p, double radius) { out = std::max(out.value_or(-INFINITY), axis.dot(p) + radius); };
      for (const Eigen::Vector3d& p : e.shape().mesh.positions) reach(p, e.shape().padding);
      if (const auto& capsule = e.shape().capsule) reach(capsule->a, capsule->radius), reach(capsule->b, capsule->radius);
    }
    return out;
  }

  void checkClips() const {
    for (const ClipPlane& clip : settings_.clips) {
      const std::optional<double> top = highest(clip.link, clip.axis);
      if (!top) throw tool::UsageError("--clip " + clip.link + ": no link with a collision element has this name.");
      if (*top <= clip.value) refuseClip(clip.link);
    }
  }

  [[noreturn]] static void refuseClip(const std::string& link) {
    throw tool::UsageError("--clip removes every sphere of the link " + link + ". Give another VALUE, or the opposite AXIS (such as -z).");
  }

  const LinkCount* countOf(std::size_t link) const {
    for (const LinkCount& count : settings_.counts)
      if (fnmatch(count.pattern.c_str(), robot_.links[link].name.c_str(), 0) == 0) return &count;
    return nullptr;
  }

  std::vector<Group> groupElements() const {
    std::map<std::size_t, Group> of_link;
    Group rest{"the links", {}, settings_.budget};
    std::set<const LinkCount*> used;
    for (std::size_t e = 0; e < elements_.size(); ++e) {
      const std::size_t link = elements_[e].shaped.link;
      const LinkCount* count = countOf(link);
      if (!count) {
        rest.elements.push_back(e);
        continue;
      }
      used.insert(count);
      Group& group = of_link.try_emplace(link, Group{robot_.links[link].name, {}, count->spheres}).first->second;
      group.elements.push_back(e);
    }
    for (const LinkCount& count : settings_.counts)
      if (!used.contains(&count))
        throw tool::UsageError("--links " + count.pattern +
                               " names no link with a collision element, or only links that an earlier pattern names.");
    std::vector<Group> groups;
    if (!rest.elements.empty()) groups.push_back(rest);
    for (const auto& [link, group] : of_link) groups.push_back(group);
    for (const Group& group : groups)
      if (group.spheres > 0 && group.spheres < group.elements.size())
        throw tool::UsageError(std::to_string(group.spheres) + " sphere" + (group.spheres == 1 ? "" : "s") + " for " + group.name +
                               " is less than one for each of " + std::to_string(group.elements.size()) +
                               " collision elements. Allow more.");
    return groups;
  }

  /// Calls `work(index, progress)` for each index; rethrows the first exception. Stages of parallel builds are not
  /// shown; Ctrl-C reaches each of them.
  template <class Work>
  void inParallel(std::size_t count, Work&& work) const {
    tbb::task_arena arena(builder::usefulThreads(settings_.threads));
    std::vector<std::exception_ptr> errors(count);
    arena.execute([&] {
      tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
        builder::Progress progress(&progress_);
        try {
          progress_.check();
          work(i, progress);
        } catch (...) {
          errors[i] = std::current_exception();
        }
      });
    });
    progress_.check();
    for (const std::exception_ptr& error : errors)
      if (error) std::rethrow_exception(error);
  }

  void makeSolid(Element& e, builder::Progress& progress) const {
    if (e.shape().capsule) return;
    std::vector<std::string> steps;
    e.solid = pipeline::soundMesh(e.shape().mesh, nameOf(e), settings_.repair, steps, progress);
    steps.insert(steps.begin(), e.shape().notes.begin(), e.shape().notes.end());
    for (const std::string& text : steps) e.notes.push_back(nameOf(e) + ": " + text);
  }

  builder::BuildSettings buildSettings(std::size_t leaves, Quality quality) const {
    builder::BuildSettings s;
    s.skin = false;
    s.quality = quality;
    s.seed = settings_.seed;
    s.threads = settings_.threads;
    s.branching = static_cast<int>(kBranching);
    if (leaves > 0) pipeline::limitLeaves(s, leaves);
    return s;
  }

  ElementCover buildElement(const Element& e, const builder::BuildSettings& s, builder::Progress& progress) const {
    return coverOf(builder::buildSphereTree(e.solid.mesh, s, progress, e.solid.to_cover), e.shape().padding);
  }

  ElementCover coverByLeaves(const Element& e, std::size_t leaves, Quality quality, builder::Progress& progress) const {
    if (e.shape().capsule) return coverOf(*e.shape().capsule, leaves);
    return buildElement(e, buildSettings(leaves, quality), progress);
  }

  /// > 0
  static double errorOf(const ElementCover& cover) {
    return std::max<double>(cover.overhang_bounds.back(), std::numeric_limits<float>::min());
  }

  void coverByTolerance(const Group& group) {
    inParallel(group.elements.size(), [&](std::size_t i, builder::Progress& progress) {
      Element& e = elements_[group.elements[i]];
      e.leaves = 0;
      if (e.shape().capsule) {
        const std::size_t count = ballsForOverhang(*e.shape().capsule, settings_.tolerance_mm, kMaxLeaves);
        ElementCover cover = coverOf(*e.shape().capsule, count);
        cover.is_tolerance_met = cover.overhang_bounds.back() <= settings_.tolerance_mm;
        e.covers.emplace(0, std::move(cover));
      } else {
        builder::BuildSettings s = buildSettings(0, settings_.quality);
        s.levels = 5;  // 4096 leaves
        s.tolerance_mm = std::max(settings_.tolerance_mm - e.shape().padding, 0.01 * settings_.tolerance_mm);
        e.covers.emplace(0, buildElement(e, s, progress));
      }
      if (!e.chosen().is_tolerance_met)
        e.notes.push_back(nameOf(e) + ": the tolerance is not met; the best result of " + std::to_string(kMaxLeaves) + " spheres is kept.");
    });
  }

  /// Quick trees show how the error of each element decreases with its leaves; the final trees correct the estimate.
  void coverByCount(const Group& group) {
    const std::vector<std::size_t>& members = group.elements;
    std::vector<pipeline::ErrorCurve> curves(members.size());
    std::vector<std::size_t> largest;
    for (const std::size_t e : members) largest.push_back(elements_[e].isBall() ? 1 : kMaxLeaves);
    if (members.size() > 1) probe(members, largest, group.spheres, curves);
    std::vector<std::size_t> best;
    double best_error = std::numeric_limits<double>::infinity();
    for (int round = 0; round < (members.size() > 1 ? kRounds : 1); ++round) {
      const std::vector<std::size_t> leaves = pipeline::shareLeaves(curves, largest, group.spheres).leaves;
      inParallel(members.size(), [&](std::size_t i, builder::Progress& progress) {
        Element& e = elements_[members[i]];
        if (!e.covers.contains(leaves[i])) e.covers.emplace(leaves[i], coverByLeaves(e, leaves[i], settings_.quality, progress));
      });
      double worst = 0;
      bool is_known = !best.empty();
      for (std::size_t i = 0; i < members.size(); ++i) {
        const double error = errorOf(elements_[members[i]].covers.at(leaves[i]));
        worst = std::max(worst, error);
        is_known = is_known && leaves[i] == best[i];
        if (round == 0)
          curves[i].moveTo(static_cast<double>(leaves[i]), error);
        else
          curves[i].add(static_cast<double>(leaves[i]), error);
      }
      if (worst < best_error) best = leaves, best_error = worst;
      if (is_known) break;
    }
    for (std::size_t i = 0; i < members.size(); ++i) elements_[members[i]].leaves = best[i];
  }

  void probe(const std::vector<std::size_t>& members, const std::vector<std::size_t>& largest, std::size_t total,
             std::vector<pipeline::ErrorCurve>& curves) {
    for (const std::size_t asked : kProbes) {
      std::vector<double> errors(members.size());
      const auto leavesOf = [&](std::size_t i) { return std::min({asked, total, largest[i]}); };
      inParallel(members.size(), [&](std::size_t i, builder::Progress& progress) {
        errors[i] = errorOf(coverByLeaves(elements_[members[i]], leavesOf(i), Quality::Quick, progress));
      });
      for (std::size_t i = 0; i < members.size(); ++i) curves[i].add(static_cast<double>(leavesOf(i)), errors[i]);
    }
  }

  /// The last level where the element has fewer.
  static std::size_t levelAt(const Element& e, std::size_t depth) { return std::min(depth, e.chosen().levels.size() - 1); }

  RobotCover collect() {
    RobotCover out;
    for (std::size_t first = 0, last = 0; first < elements_.size(); first = last) {
      LinkCover& link = out.links.emplace_back();
      link.link = elements_[first].shaped.link;
      std::size_t depth = 1;
      for (; last < elements_.size() && elements_[last].shaped.link == link.link; ++last) {
        const Element& e = elements_[last];
        depth = std::max(depth, e.chosen().levels.size());
        link.notes.insert(link.notes.end(), e.notes.begin(), e.notes.end());
      }
      for (std::size_t d = 0; d < depth; ++d) {
        std::vector<LinkBall> balls;
        double bound = 0;
        for (std::size_t e = first; e < last; ++e) {
          const std::size_t level = levelAt(elements_[e], d);
          const std::vector<LinkBall>& own = elements_[e].chosen().levels[level];
          balls.insert(balls.end(), own.begin(), own.end());
          bound = std::max(bound, elements_[e].chosen().overhang_bounds[level]);
        }
        moved_ = 0;
        link.levels.push_back(written(balls, link));
        link.overhang_bounds_mm.push_back(bound + moved_);
      }
    }
    return out;
  }

  /// Clipped and rounded spheres. A ball that crosses the plane is moved back; one whose centre lies beyond the plane
  /// shrinks to its cap.
  std::vector<MetreSphere> written(const std::vector<LinkBall>& balls, LinkCover& link) {
    std::vector<MetreSphere> out;
    for (LinkBall ball : balls) {
      const double slack = 1e-6 * (ball.centre.norm() + ball.radius);  // larger than the rounding to float
      bool is_gone = false;
      for (const ClipPlane& clip : settings_.clips) {
        if (clip.link != robot_.links[link.link].name) continue;
        link.is_clipped = true;
        const double height = clip.axis.dot(ball.centre) - clip.value;
        if (height - ball.radius >= slack) continue;
        if (height < 0) {
          const double cap = height + ball.radius - 2 * slack;
          if (!(cap > 2 * slack)) is_gone = true;
          ball.centre += (slack + cap / 2 - height) * clip.axis;
          ball.radius = cap / 2;
        } else {
          const double back = ball.radius - height + slack;
          ball.centre += back * clip.axis;
          moved_ = std::max(moved_, back);
        }
      }
      if (!is_gone) out.push_back(metreSphere(ball));
    }
    if (out.empty()) refuseClip(robot_.links[link.link].name);
    return out;
  }

  const Robot& robot_;
  const CoverSettings& settings_;
  builder::Progress& progress_;
  std::vector<Element> elements_;
  double moved_ = 0;  // largest motion of a ball by clipping [mm]
};

}  // namespace

std::size_t usualBudget(const Robot& robot) {
  constexpr std::size_t kSpheresEach = 8;  // on average for each collision element
  std::size_t elements = 0;
  for (const Link& link : robot.links) elements += link.collisions.size();
  return kSpheresEach * std::max<std::size_t>(1, elements);
}

std::size_t RobotCover::sphereCount() const {
  std::size_t count = 0;
  for (const LinkCover& link : links) count += link.spheres().size();
  return count;
}

const LinkCover* RobotCover::of(std::size_t link) const {
  const auto found = std::find_if(links.begin(), links.end(), [&](const LinkCover& cover) { return cover.link == link; });
  return found == links.end() ? nullptr : &*found;
}

RobotCover coverRobot(const Robot& robot, std::vector<ShapedElement> shapes, const CoverSettings& settings, builder::Progress& progress) {
  return RobotCoverer(robot, std::move(shapes), settings, progress).run();
}

MetreSphere metreSphere(const LinkBall& ball) {
  constexpr double kHalfUlp = 0x1p-24;  // relative error of rounding to float
  const Eigen::Vector3d centre = ball.centre / 1000;
  const Eigen::Vector3f rounded = roundToFloat(centre);
  // The decimals differ from the float that they represent by at most half a unit, in each coordinate and the radius.
  const double off = (rounded.cast<double>() - centre).norm() + kHalfUlp * rounded.cast<double>().norm();
  const double radius = (ball.radius / 1000 + off) * (1 + 2 * kHalfUlp);
  return {rounded.x(), rounded.y(), rounded.z(), roundUp(radius)};
}

LinkBall linkBall(const MetreSphere& s) { return {1000 * Eigen::Vector3d(s.x, s.y, s.z), 1000.0 * s.radius}; }

}  // namespace spheretree::robot
