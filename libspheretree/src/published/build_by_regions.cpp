// SPDX-License-Identifier: GPL-3.0-or-later
#include "published/build_by_regions.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>

#include "base/thinned.h"
#include "cover/cover_search.h"
#include "geometry/box_tree.h"
#include "medial/adaptive_medial_axis.h"
#include "medial/shrinking_balls.h"
#include "medial/surface_regions.h"
#include "spheretree/core/smallest_enclosing_ball.h"
#include "tree/hierarchy.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr std::size_t kFirstSites = 300;  // give about 1,000 balls, the initial set of the paper
constexpr std::size_t kMinBalls = 200;    // for a region, as in the paper
constexpr double kErrorFactor = 2;        // ratio of the overhangs of the resulting spheres and the medial balls, as in the paper
constexpr int kRootRefits = 3;            // as in the paper
constexpr double kNegligible = 1e-6;      // as a share of the diagonal: radius of a ball that no point needs
constexpr std::size_t kMinPoints = 1000;
constexpr std::size_t kExtraWorkBalls = 64;  // fewer balls have more points each: the work of a level is that of so many balls more
constexpr std::size_t kSitesFrom = 20;       // the first sites are the farthest from each other of this multiple of points
constexpr std::size_t kRootPoints = 200;     // with inner balls, one of which may be the best root
constexpr std::size_t kPointsFrom = 4;       // as kSitesFrom, for the points of a region

struct Effort {
  std::size_t points_a_ball, max_points, reducer_points, reducer_balls;
  double search_moves;  // for each ball
  double search_step, last_step;
  std::uint64_t search_work;  // for each ball
  double gap_tolerance;
  double removal_moves;  // for each ball
  int removal_failures;
};

Effort effortOf(Quality quality) {
  switch (quality) {
    case Quality::Quick:
      return {.points_a_ball = 8,
              .max_points = 200'000,
              .reducer_points = 26,
              .reducer_balls = 26,
              .search_moves = 0.27,
              .search_step = 0.07,
              .last_step = 0.07,
              .search_work = 40'000,
              .gap_tolerance = 0.04,
              .removal_moves = 8,
              .removal_failures = 3};
    case Quality::Standard:
      return {.points_a_ball = 12,
              .max_points = 400'000,
              .reducer_points = 28,
              .reducer_balls = 28,
              .search_moves = 0.43,
              .search_step = 0.06,
              .last_step = 0.06,
              .search_work = 60'000,
              .gap_tolerance = 0.04,
              .removal_moves = 25,
              .removal_failures = 3};
    case Quality::Best:
      return {.points_a_ball = 48,
              .max_points = 800'000,
              .reducer_points = 500,
              .reducer_balls = 500,
              .search_moves = 0.6,
              .search_step = 0.04,
              .last_step = 0.004,
              .search_work = 100'000,
              .gap_tolerance = 0.01,
              .removal_moves = 60,
              .removal_failures = 6};
  }
  return {};
}

double worstOverhang(std::span<const FittedBall> balls) {
  double worst = 0;
  for (const FittedBall& b : balls) worst = std::max(worst, b.overhang());
  return worst;
}

using Levels = std::vector<std::vector<FittedBall>>;

// One method, from the root down.
class TopDownBuilder {
 public:
  TopDownBuilder(const TriangleMesh& mesh, const DistanceField& field, const SurfacePoints& surface, const Method& method,
                 const PublishedSettings& settings, Progress& progress)
      : mesh_(mesh),
        field_(field),
        surface_(surface),
        method_(method),
        settings_(settings),
        effort_(effortOf(settings.quality)),
        progress_(progress) {
    if (method.uses_medial_axis) axis_.emplace(field, farthestFirst(thinned(surface_.points, kSitesFrom * kFirstSites), kFirstSites));
  }

  Levels run(double done, double share) {
    Levels levels{{rootBall()}};
    std::size_t count = 1;
    for (int level = 1; level < settings_.levels; ++level) {
      progress_.advance(done + share * (level - 1) / (settings_.levels - 1));
      if (isGoodEnough(levels.back())) break;
      count *= static_cast<std::size_t>(settings_.branching);
      levels.push_back(reduceAll(levels.back()));
      evenOut(levels.back(), count, settings_.tolerance_mm);
    }
    if (settings_.tolerance_mm > 0 && isGoodEnough(levels.back())) thinAbove(levels);
    return levels;
  }

 private:
  bool isGoodEnough(const std::vector<FittedBall>& balls) const {
    return worstOverhang(balls) <= std::max(settings_.tolerance_mm, kNegligible * field_.diagonal());
  }

  // The better of the smallest ball of all points and the best ball about a centre inside.
  FittedBall rootBall() {
    const Ball smallest = smallestEnclosing(surface_.points);
    std::vector<FittedBall> starts{{smallest.centre, smallest.radius, -field_.signedDistance(smallest.centre)}};
    const std::vector<Vector3d> sparse = farthestFirst(thinned(surface_.points, kMinPoints), kRootPoints);
    FittedBall inner;
    double lowest = kInfinity;
    for (const Vector3d& p : sparse) {
      const Ball ball = shrinkingBall(field_, p, field_.pseudonormal(field_.nearest(p)));
      if (!(ball.radius > 0)) continue;
      double reach = 0;
      for (const Vector3d& q : sparse) reach = std::max(reach, (q - ball.centre).norm());
      if (reach - ball.radius < lowest) lowest = reach - ball.radius, inner = {ball.centre, reach, ball.radius};
    }
    if (inner.clearance > 0) starts.push_back(inner);
    FittedBall best;
    lowest = kInfinity;
    for (const FittedBall& start : starts) {
      std::vector<FittedBall> one{start};
      refitBalls(field_, surface_.points, one, kRootRefits, progress_);
      if (one[0].overhang() < lowest) lowest = one[0].overhang(), best = one[0];
    }
    return best;
  }

  // The children of all nodes; each node's region is reduced by itself.
  std::vector<FittedBall> reduceAll(const std::vector<FittedBall>& nodes) {
    const std::vector<std::uint32_t> owner = divide(nodes);
    std::vector<std::vector<Vector3d>> points(nodes.size());
    std::vector<std::vector<FittedBall>> inner(nodes.size());
    for (std::size_t i = 0; i < owner.size(); ++i) {
      if (owner[i] == kNoParent) continue;
      const Ball& ball = surface_.inner[i];
      points[owner[i]].push_back(surface_.points[i]);
      if (ball.radius > 0) inner[owner[i]].push_back({ball.centre, ball.radius, ball.radius});
    }
    std::vector<std::vector<FittedBall>> pools(nodes.size());
    if (axis_) pools = refineAxis(nodes, owner);
    // Voronoi vertices are rare in plates thinner than the distance between sites, and near sharp edges: inner balls
    // complete the pool.
    for (std::size_t n = 0; axis_ && n < nodes.size(); ++n) {
      pools[n] = thinned(pools[n], effort_.reducer_balls / 2);
      inner[n] = thinned(inner[n], effort_.reducer_balls - pools[n].size());
      pools[n].insert(pools[n].end(), inner[n].begin(), inner[n].end());
    }
    std::vector<std::vector<FittedBall>> children(nodes.size());
    tbb::parallel_for(std::size_t{0}, nodes.size(), [&](std::size_t n) {
      progress_.check();
      children[n] = reduceOne(points[n], pools[n], nodes[n]);
    });
    std::vector<FittedBall> all;
    for (const auto& family : children) all.insert(all.end(), family.begin(), family.end());
    return all;
  }

  std::vector<FittedBall> reduceOne(const std::vector<Vector3d>& points, const std::vector<FittedBall>& pool, const FittedBall& own) {
    if (points.size() < 2) return {own};
    const std::vector<Vector3d> sparse = farthestFirst(thinned(points, kPointsFrom * effort_.reducer_points), effort_.reducer_points);
    Region region{field_, sparse, pool};
    region.max_balls = static_cast<std::size_t>(settings_.branching);
    region.target_overhang = settings_.tolerance_mm;
    region.seed = settings_.seed;
    std::vector<FittedBall> balls = method_.reduce(region);
    if (balls.empty()) return {own};
    refitBalls(field_, sparse, balls, 1, progress_);
    std::erase_if(balls, [](const FittedBall& b) { return !(b.radius > 0); });
    return balls;
  }

  std::vector<std::vector<FittedBall>> refineAxis(const std::vector<FittedBall>& nodes, const std::vector<std::uint32_t>& owner) {
    double mean = 0;
    for (const FittedBall& node : nodes) mean += node.overhang() / static_cast<double>(nodes.size());
    std::vector<AdaptiveMedialAxis::Target> targets;
    for (const FittedBall& node : nodes)
      targets.push_back({std::min(node.overhang(), mean) / kErrorFactor, kMinBalls, effort_.reducer_balls});
    std::vector<Eigen::AlignedBox3d> boxes;
    for (const Vector3d& p : surface_.points) boxes.emplace_back(p, p);
    const BoxTree tree(boxes, 8);
    const auto region_of = [&](const Vector3d& p) {
      double limit2 = kInfinity;
      std::uint32_t nearest = 0;
      tree.searchNearest(p, limit2, [&](std::size_t first, std::size_t count) {
        for (std::size_t slot = first; slot < first + count; ++slot) {
          const std::uint32_t i = tree.order()[slot];
          const double d2 = (surface_.points[i] - p).squaredNorm();
          if (d2 < limit2) limit2 = d2, nearest = i;
        }
      });
      return owner[nearest];
    };
    return axis_->refine(region_of, targets, progress_);
  }

  // Evens out the level as a whole, since a ball may also serve its neighbours' regions: the cover search distributes
  // at most `count` balls, covers the surface between the points, and lowers the common stand-off. With a tolerance, it
  // finds the fewest balls that keep it.
  void evenOut(std::vector<FittedBall>& balls, std::size_t count, double tolerance) {
    std::vector<Ball> inscribed;
    for (const FittedBall& b : balls) inscribed.push_back({b.centre, b.clearance});
    SearchSettings search_settings;
    search_settings.step = effort_.search_step;
    search_settings.moves = kMovesBeside + static_cast<int>(effort_.search_moves * static_cast<double>(count));
    search_settings.work = effort_.search_work * (count + kExtraWorkBalls);
    search_settings.last_step = effort_.last_step;
    search_settings.failures = effort_.removal_failures;
    search_settings.gap_tolerance = effort_.gap_tolerance;
    search_settings.removal_moves = effort_.removal_moves;
    ChosenBalls start{
        .balls = std::move(inscribed), .samples = levelPoints(count), .count = tolerance > 0 ? 0 : count, .seed = settings_.seed};
    CoverSearch search(mesh_, field_, std::move(start), search_settings, progress_);
    if (tolerance > 0)
      search.fit(tolerance, count, progress_);
    else
      search.lower(kNegligible * field_.diagonal(), progress_);
    balls.clear();
    for (const Ball& b : search.balls()) balls.push_back({b.centre, b.radius + search.standOff(), b.radius});
  }

  // Few points for few balls: a subset of the evenly spread ones and of those at corners and on sharp edges.
  std::vector<Vector3d> levelPoints(std::size_t balls) const {
    std::vector<Vector3d> even, special;
    for (std::size_t i = 0; i < surface_.points.size(); ++i) (surface_.ball_density[i] > 0 ? even : special).push_back(surface_.points[i]);
    const std::size_t wanted = std::max(kMinPoints, balls * effort_.points_a_ball);
    even = thinned(even, wanted);
    special = thinned(special, wanted);
    even.insert(even.end(), special.begin(), special.end());
    return even;
  }

  // First grows all balls to the worst overhang of the level: this gives the division the freedom to make equal parts.
  // A child need not stay within the cover ball of its parent.
  std::vector<std::uint32_t> divide(const std::vector<FittedBall>& balls) const {
    if (balls.size() == 1) return std::vector<std::uint32_t>(surface_.points.size(), 0);
    std::vector<FittedBall> all = balls;
    const double worst = worstOverhang(balls);
    for (FittedBall& ball : all) ball.radius = std::max(ball.radius, ball.clearance + worst);
    return assignToRegions(surface_.points, surface_.ball_density, all);
  }

  // The levels above get only as many balls as the deepest level needs as parents.
  void thinAbove(Levels& levels) {
    const std::vector<std::size_t> counts = levelCounts(levels.back().size(), settings_.branching);
    for (std::size_t level = 1; level + 1 < counts.size(); ++level)
      if (levels[level].size() > counts[level]) evenOut(levels[level], counts[level], 0);
    std::swap(levels[counts.size() - 1], levels.back());
    levels.resize(counts.size());
  }

  const TriangleMesh& mesh_;
  const DistanceField& field_;
  const SurfacePoints& surface_;
  const Method& method_;
  const PublishedSettings& settings_;
  Effort effort_;
  Progress& progress_;
  std::optional<AdaptiveMedialAxis> axis_;
};

std::size_t countAll(const Levels& levels) {
  std::size_t count = 0;
  for (const auto& level : levels) count += level.size();
  return count;
}

// If trees keep the tolerance, the one with the fewest balls; otherwise, level by level, the one with the smallest
// worst overhang. On ties the first.
Levels pickBest(const std::vector<Levels>& members, double tolerance) {
  const Levels* smallest = nullptr;
  for (const Levels& member : members)
    if (tolerance > 0 && worstOverhang(member.back()) <= tolerance && (!smallest || countAll(member) < countAll(*smallest)))
      smallest = &member;
  if (smallest) return *smallest;
  Levels best;
  for (const Levels& member : members) best.resize(std::max(best.size(), member.size()));
  for (std::size_t level = best.size(); level-- > 0;) {
    const std::vector<FittedBall>* found = nullptr;
    for (const Levels& member : members)
      if (level < member.size() && (!found || worstOverhang(member[level]) < worstOverhang(*found))) found = &member[level];
    best[level] = *found;
  }
  return best;
}

}  // namespace

void checkSettings(const PublishedSettings& settings) {
  if (settings.levels < kMinLevels || settings.levels > kMaxLevels)
    throw std::invalid_argument("published builders: levels is " + std::to_string(settings.levels) + ", must be 2 to 6");
  if (settings.branching < kMinBranching || settings.branching > kMaxBranching)
    throw std::invalid_argument("published builders: branching is " + std::to_string(settings.branching) + ", must be 2 to 8");
  if (!(settings.tolerance_mm >= 0) || !std::isfinite(settings.tolerance_mm))
    throw std::invalid_argument("published builders: the tolerance must be a length of 0 mm or more");
}

LevelBalls buildByRegions(const TriangleMesh& mesh, const DistanceField& field, std::span<const Method> methods,
                          const PublishedSettings& settings, Progress& progress) {
  if (methods.empty()) throw std::invalid_argument("published builders: no method given");
  checkSettings(settings);
  std::size_t leaves = 1;
  for (int level = 1; level < settings.levels; ++level) leaves *= static_cast<std::size_t>(settings.branching);
  const Effort effort = effortOf(settings.quality);
  const std::size_t points = std::clamp<std::size_t>(leaves * effort.points_a_ball, 2 * kMinPoints, effort.max_points);
  const SurfacePoints surface =
      sampleRegions(mesh, field, points, leaves, settings.seed, std::ranges::any_of(methods, &Method::uses_medial_axis));
  std::vector<Levels> members;
  const double share = 1.0 / static_cast<double>(methods.size());
  for (const Method& method : methods)
    members.push_back(
        TopDownBuilder(mesh, field, surface, method, settings, progress).run(share * static_cast<double>(members.size()), share));
  LevelBalls out;
  for (const auto& level : pickBest(members, settings.tolerance_mm)) {
    out.balls.emplace_back();
    for (const FittedBall& b : level) out.balls.back().push_back({b.centre, std::max(b.radius, kNegligible * field.diagonal())});
  }
  return out;
}

}  // namespace spheretree::builder
