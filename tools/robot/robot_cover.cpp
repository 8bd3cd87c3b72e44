// SPDX-License-Identifier: GPL-3.0-or-later
#include "robot/robot_cover.h"

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
#include "spheretree/builder/build_sphere_tree.h"
#include "spheretree/core/rounding.h"

namespace spheretree::robot {
namespace {

using builder::Quality;

constexpr std::size_t kMaxLeaves = 4096;    // for one element: the deepest tree that is useful for a planner
constexpr int kRounds = 3;                  // rounds of redistribution by the errors of the final trees
constexpr std::size_t kProbes[] = {4, 16};  // numbers of leaves of the quick trees that show how an error decreases

/// A collision element while it is converted to spheres.
struct Element {
  std::size_t link = 0;
  std::string name;
  LinkShape shape;
  builder::RepairedMesh solid;
  std::vector<std::string> notes;
  std::map<std::size_t, builder::BuildResult> built;  // by the requested number of leaves
  std::size_t leaves = 0;                             // number of leaves of the chosen tree
  bool isBall() const { return shape.ball.has_value(); }
  const builder::BuildResult& chosen() const { return built.at(leaves); }
};

/// Elements that share a number of spheres.
struct Group {
  std::string name;
  std::vector<std::size_t> elements;
  std::size_t spheres = 0;  // 0: given by the tolerance
};

class RobotCoverer {
 public:
  RobotCoverer(const Robot& robot, const CoverSettings& settings, builder::Progress& progress)
      : robot_(robot), settings_(settings), progress_(progress) {}

  RobotCover run() {
    progress_.stage("read meshes");
    readElements();
    const std::vector<Group> groups = groupElements();
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
  std::string nameOf(const Element& e) const { return robot_.links[e.link].name + (e.name.empty() ? "" : " (" + e.name + ")"); }

  void readElements() {
    for (std::size_t l = 0; l < robot_.links.size(); ++l)
      for (const CollisionElement& collision : robot_.links[l].collisions) {
        progress_.check();
        Element& e = elements_.emplace_back();
        e.link = l;
        const auto* file = std::get_if<MeshFile>(&collision.shape);
        e.name = !collision.name.empty() ? collision.name : file ? file->path.filename().string() : "";
        e.shape = shapeOf(collision);
      }
    if (elements_.empty())
      throw tool::UsageError(robot_.path.string() + ": no link has a <collision> element, so that there is nothing to cover.");
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
      const LinkCount* count = countOf(elements_[e].link);
      if (!count) {
        rest.elements.push_back(e);
        continue;
      }
      used.insert(count);
      Group& group = of_link.try_emplace(elements_[e].link, Group{robot_.links[elements_[e].link].name, {}, count->spheres}).first->second;
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
    if (e.isBall()) return;
    std::vector<std::string> steps;
    e.solid = pipeline::soundMesh(e.shape.mesh, nameOf(e), settings_.repair, steps, progress);
    for (std::vector<std::string>* texts : {&e.shape.notes, &steps})
      for (const std::string& text : *texts) e.notes.push_back(nameOf(e) + ": " + text);
  }

  builder::BuildSettings buildSettings(std::size_t leaves, Quality quality) const {
    builder::BuildSettings s;
    s.skin = false;
    s.quality = quality;
    s.seed = settings_.seed;
    s.threads = settings_.threads;
    if (leaves > 0) pipeline::limitLeaves(s, leaves);
    return s;
  }

  builder::BuildResult buildElement(const Element& e, const builder::BuildSettings& s, builder::Progress& progress) const {
    return builder::buildSphereTree(e.solid.mesh, s, progress, e.solid.to_cover);
  }

  static double errorOf(const builder::BuildResult& result) { return result.tree.statistics.back().overhang_bound; }

  void coverByTolerance(const Group& group) {
    inParallel(group.elements.size(), [&](std::size_t i, builder::Progress& progress) {
      Element& e = elements_[group.elements[i]];
      if (e.isBall()) return;
      builder::BuildSettings s = buildSettings(0, settings_.quality);
      s.levels = 5;  // 4096 leaves
      s.tolerance_mm = std::max(settings_.tolerance_mm - e.shape.padding, 0.01 * settings_.tolerance_mm);
      e.leaves = 0;
      const auto at = e.built.emplace(0, buildElement(e, s, progress)).first;
      if (!at->second.statistics.tolerance_met)
        e.notes.push_back(nameOf(e) + ": the tolerance is not met; the best result of " + std::to_string(kMaxLeaves) + " spheres is kept.");
    });
  }

  /// Quick trees show how the error of each element decreases with its leaves; the final trees correct the estimate.
  void coverByCount(const Group& group) {
    std::vector<std::size_t> meshes;
    for (const std::size_t e : group.elements)
      if (!elements_[e].isBall()) meshes.push_back(e);
    const std::size_t total = group.spheres - (group.elements.size() - meshes.size());
    if (meshes.empty()) return;
    std::vector<pipeline::ErrorCurve> curves(meshes.size());
    const std::vector<std::size_t> largest(meshes.size(), kMaxLeaves);
    if (meshes.size() > 1) probe(meshes, total, curves);
    std::vector<std::size_t> best;
    double best_error = std::numeric_limits<double>::infinity();
    for (int round = 0; round < (meshes.size() > 1 ? kRounds : 1); ++round) {
      const std::vector<std::size_t> leaves = pipeline::shareLeaves(curves, largest, total).leaves;
      inParallel(meshes.size(), [&](std::size_t i, builder::Progress& progress) {
        Element& e = elements_[meshes[i]];
        if (!e.built.contains(leaves[i]))
          e.built.emplace(leaves[i], buildElement(e, buildSettings(leaves[i], settings_.quality), progress));
      });
      double worst = 0;
      bool is_known = !best.empty();
      for (std::size_t i = 0; i < meshes.size(); ++i) {
        const double error = std::max(errorOf(elements_[meshes[i]].built.at(leaves[i])), std::numeric_limits<float>::min() * 1.0);
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
    for (std::size_t i = 0; i < meshes.size(); ++i) elements_[meshes[i]].leaves = best[i];
  }

  void probe(const std::vector<std::size_t>& meshes, std::size_t total, std::vector<pipeline::ErrorCurve>& curves) {
    for (const std::size_t asked : kProbes) {
      const std::size_t leaves = std::min(asked, total);
      std::vector<double> errors(meshes.size());
      inParallel(meshes.size(), [&](std::size_t i, builder::Progress& progress) {
        errors[i] = errorOf(buildElement(elements_[meshes[i]], buildSettings(leaves, Quality::Quick), progress));
      });
      for (std::size_t i = 0; i < meshes.size(); ++i)
        curves[i].add(static_cast<double>(leaves), std::max(errors[i], std::numeric_limits<float>::min() * 1.0));
    }
  }

  static double boundOf(const Element& e, std::size_t depth) {
    if (e.isBall()) return 0;
    const std::vector<LevelStatistics>& levels = e.chosen().tree.statistics;
    return levels[std::min(depth, levels.size() - 1)].overhang_bound + e.shape.padding;
  }

  /// The spheres of one element at one depth; beyond its last level those of the last level.
  std::vector<LinkBall> ballsOf(const Element& e, std::size_t depth) const {
    if (e.isBall()) return {*e.shape.ball};
    const SphereTree& tree = e.chosen().tree;
    const int level = std::min(static_cast<int>(depth), tree.levelCount() - 1);
    const Eigen::Vector3d origin(tree.origin_mm[0], tree.origin_mm[1], tree.origin_mm[2]);
    std::vector<LinkBall> balls;
    for (const std::uint32_t node : levelSet(tree, level)) {
      const Sphere& s = tree.cover[node];
      balls.push_back({origin + centreOf(s), s.radius + e.shape.padding});
    }
    return balls;
  }

  RobotCover collect() {
    RobotCover out;
    for (std::size_t first = 0, last = 0; first < elements_.size(); first = last) {
      LinkCover& link = out.links.emplace_back();
      link.link = elements_[first].link;
      std::size_t depth = 1;
      while (last < elements_.size() && elements_[last].link == link.link) {
        Element& e = elements_[last++];
        if (e.isBall()) continue;
        depth = std::max(depth, static_cast<std::size_t>(e.chosen().tree.levelCount()));
        link.notes.insert(link.notes.end(), e.notes.begin(), e.notes.end());
      }
      for (std::size_t d = 0; d < depth; ++d) {
        std::vector<LinkBall> balls;
        for (std::size_t e = first; e < last; ++e)
          for (const LinkBall& ball : ballsOf(elements_[e], d)) balls.push_back(ball);
        moved_ = 0;
        link.levels.push_back(written(balls, link));
        double bound = 0;
        for (std::size_t e = first; e < last; ++e) bound = std::max(bound, boundOf(elements_[e], d));
        link.overhang_bounds_mm.push_back(bound + moved_);
      }
    }
    for (const ClipPlane& clip : settings_.clips)
      if (std::none_of(out.links.begin(), out.links.end(), [&](const LinkCover& l) { return robot_.links[l.link].name == clip.link; }))
        throw tool::UsageError("--clip " + clip.link + ": no link with a collision element has this name.");
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
    if (out.empty())
      throw tool::UsageError("--clip removes every sphere of the link " + robot_.links[link.link].name +
                             ". Give another VALUE, or the opposite AXIS (such as -z).");
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

RobotCover coverRobot(const Robot& robot, const CoverSettings& settings, builder::Progress& progress) {
  return RobotCoverer(robot, settings, progress).run();
}

MetreSphere metreSphere(const LinkBall& ball) {
  constexpr double kHalfUlp = 0x1p-24;  // relative error of rounding to float
  const Eigen::Vector3d centre = ball.centre / 1000;
  const Eigen::Vector3f rounded = centre.cast<float>();
  // The decimals differ from the float that they represent by at most half a unit, in each coordinate and the radius.
  const double off = (rounded.cast<double>() - centre).norm() + kHalfUlp * rounded.cast<double>().norm();
  const double radius = (ball.radius / 1000 + off) * (1 + 2 * kHalfUlp);
  return {rounded.x(), rounded.y(), rounded.z(), roundUp(radius)};
}

LinkBall linkBall(const MetreSphere& s) { return {1000 * Eigen::Vector3d(s.x, s.y, s.z), 1000.0 * s.radius}; }

}  // namespace spheretree::robot
