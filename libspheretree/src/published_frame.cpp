// SPDX-License-Identifier: GPL-3.0-or-later
#include "spheretree/builder/published_frame.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <compare>
#include <limits>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <string>

#include "spheretree/builder/adaptive_medial_axis.h"
#include "spheretree/builder/box_tree.h"
#include "spheretree/builder/certify_cover.h"
#include "spheretree/builder/shrinking_balls.h"
#include "spheretree/builder/smallest_ball.h"
#include "spheretree/builder/surface_regions.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::size_t kFirstSites = 300;  // give about 1,000 balls, the paper's initial set
constexpr std::size_t kLeastBalls = 200;  // of a region, as in the paper
constexpr double kErrorFactor = 2;        // medial balls are this much better than the spheres that they become, as in the paper
constexpr int kRefitRounds = 3;           // as in the paper
constexpr std::size_t kFewNodes = 8;      // on a level: there is time to try more for each
constexpr double kNegligible = 1e-6;      // overhang that no child can be asked to improve, of the diagonal
constexpr double kRefitGain = 1.25;       // a refit hardly ever lowers the worst overhang by more

struct Effort {
  std::size_t points_a_leaf, most_points, reducer_points, reducer_balls;
  int gap_rounds;
};

Effort effortOf(Quality quality) {
  switch (quality) {
    case Quality::Quick:
      return {16, 200'000, 500, 600, 1};
    case Quality::Standard:
      break;
    case Quality::Best:
      return {96, 800'000, 2000, 2000, 3};
  }
  return {48, 400'000, 1000, 1200, 2};
}

// Every k-th of a list, so that at most `most` are left.
template <class T>
std::vector<T> thinned(const std::vector<T>& all, std::size_t most) {
  if (all.size() <= most) return all;
  std::vector<T> few;
  for (std::size_t i = 0; i < most; ++i) few.push_back(all[i * all.size() / most]);
  return few;
}

// At most `most` of the points: each the farthest from those before, so that corners come first and the rest is spread evenly.
// A reducer that does not see a corner misses it by far more than the spacing of its points.
std::vector<Vector3d> farthestFirst(const std::vector<Vector3d>& all, std::size_t most) {
  if (all.size() <= most) return all;
  std::vector<double> distance2(all.size(), kInfinity);
  Vector3d mean = Vector3d::Zero();
  for (const Vector3d& p : all) mean += p / static_cast<double>(all.size());
  std::size_t next = 0;
  for (std::size_t i = 1; i < all.size(); ++i)
    if ((all[i] - mean).squaredNorm() > (all[next] - mean).squaredNorm()) next = i;
  std::vector<Vector3d> few;
  for (std::size_t k = 0; k < most; ++k) {
    const Vector3d p = all[next];
    few.push_back(p);
    next = 0;
    for (std::size_t i = 0; i < all.size(); ++i) {
      distance2[i] = std::min(distance2[i], (all[i] - p).squaredNorm());
      if (distance2[i] > distance2[next]) next = i;
    }
  }
  return few;
}

double worstOverhang(std::span<const FittedBall> balls) {
  double worst = 0;
  for (const FittedBall& b : balls) worst = std::max(worst, b.overhang());
  return worst;
}

void dropMarked(std::vector<FittedBall>& balls, std::vector<std::uint32_t>& group, const std::vector<char>& marked) {
  std::size_t kept = 0;
  for (std::size_t b = 0; b < balls.size(); ++b)
    if (!marked[b]) balls[kept] = balls[b], group[kept] = group[b], ++kept;
  balls.resize(kept);
  group.resize(kept);
}

struct Node {
  FittedBall ball;
  std::uint32_t parent = kNoParent;
};

class Frame {
 public:
  Frame(const TriangleMesh& mesh, const DistanceField& field, std::span<const Method> methods, const PublishedSettings& settings,
        Progress& progress)
      : mesh_(mesh), field_(field), methods_(methods), settings_(settings), effort_(effortOf(settings.quality)), progress_(progress) {
    const double leaves = std::pow(settings.branching, settings.levels - 1);
    const auto wanted = static_cast<std::size_t>(std::min(leaves * static_cast<double>(effort_.points_a_leaf), 1e9));
    surface_ = sampleRegions(mesh, field, std::clamp<std::size_t>(wanted, 8000, effort_.most_points), static_cast<std::size_t>(leaves),
                             settings.seed);
    for (const Method& method : methods)
      if (method.uses_medial_axis && !axis_) axis_.emplace(field, farthestFirst(surface_.points, kFirstSites));
  }

  LevelBalls run() {
    LevelBalls out;
    std::vector<Node> nodes{{rootBall(), kNoParent}};
    append(out, nodes);
    std::vector<std::uint32_t> owner(surface_.points.size(), 0);
    for (int level = 1; level < settings_.levels; ++level) {
      progress_.advance(static_cast<double>(level - 1) / static_cast<double>(settings_.levels - 1));
      std::vector<std::uint32_t> active;  // nodes that get children
      for (std::uint32_t n = 0; n < nodes.size(); ++n)
        if (!isGoodEnough(nodes[n].ball)) active.push_back(n);
      trials_ = active.size() <= kFewNodes ? 2 * static_cast<std::size_t>(settings_.branching) : 3;
      const std::vector<std::vector<FittedBall>> children = reduceAll(nodes, active, owner);
      std::vector<FittedBall> balls;
      std::vector<std::uint32_t> parents;
      std::size_t next = 0;
      for (std::uint32_t n = 0; n < nodes.size(); ++n) {
        const bool divided = next < active.size() && active[next] == n && !children[next].empty();
        if (divided)
          for (const FittedBall& child : children[next]) balls.push_back(child), parents.push_back(n);
        else
          ended_.push_back(nodes[n].ball);
        if (next < active.size() && active[next] == n) ++next;
      }
      if (balls.empty()) break;
      settle(balls, parents, nodes.size());
      nodes.clear();
      for (std::size_t b = 0; b < balls.size(); ++b) nodes.push_back({balls[b], parents[b]});
      append(out, nodes);
      if (level + 1 < settings_.levels) owner = divide(balls);
    }
    return out;
  }

 private:
  bool isGoodEnough(const FittedBall& ball) const {
    return ball.overhang() <= std::max(settings_.tolerance_mm, kNegligible * field_.diagonal());
  }

  static void append(LevelBalls& out, const std::vector<Node>& nodes) {
    out.balls.emplace_back();
    out.parents.emplace_back();
    for (const Node& node : nodes) {
      out.balls.back().push_back(node.ball.ball());
      out.parents.back().push_back(node.parent);
    }
  }

  // The better of the smallest ball of all points and the best ball about a centre inside.
  FittedBall rootBall() {
    const Ball smallest = smallestBall(surface_.points);
    std::vector<FittedBall> starts{{smallest.centre, -field_.signedDistance(smallest.centre), smallest.radius}};
    const std::vector<Vector3d> few = farthestFirst(surface_.points, 200);
    FittedBall inner;
    double least = kInfinity;
    for (const Vector3d& p : few) {
      const Ball ball = shrinkingBall(field_, p, field_.pseudonormal(field_.nearest(p)));
      if (!(ball.radius > 0)) continue;
      double reach = 0;
      for (const Vector3d& q : few) reach = std::max(reach, (q - ball.centre).norm());
      if (reach - ball.radius < least) least = reach - ball.radius, inner = {ball.centre, ball.radius, reach};
    }
    if (inner.clearance > 0) starts.push_back(inner);
    FittedBall best;
    least = kInfinity;
    for (const FittedBall& start : starts) {
      std::vector<FittedBall> one{start};
      refitBalls(field_, surface_.points, one, {}, kRefitRounds, progress_);
      if (one[0].overhang() < least) least = one[0].overhang(), best = one[0];
    }
    return best;
  }

  std::vector<std::vector<FittedBall>> reduceAll(const std::vector<Node>& nodes, const std::vector<std::uint32_t>& active,
                                                 const std::vector<std::uint32_t>& owner) {
    std::vector<std::uint32_t> number(nodes.size(), kNoParent);
    for (std::uint32_t a = 0; a < active.size(); ++a) number[active[a]] = a;
    std::vector<std::vector<Vector3d>> points(active.size());
    std::vector<std::vector<MedialBall>> inner(active.size());
    for (std::size_t i = 0; i < owner.size(); ++i) {
      if (owner[i] >= nodes.size() || number[owner[i]] == kNoParent) continue;
      const Ball& ball = surface_.inner[i];
      points[number[owner[i]]].push_back(surface_.points[i]);
      if (ball.radius > 0) inner[number[owner[i]]].push_back({ball.centre, ball.radius, ball.radius});
    }
    std::vector<std::vector<MedialBall>> pools(active.size());
    if (axis_ && !active.empty()) pools = refineAxis(nodes, active, number, owner);
    // Voronoi vertices are rare in plates thinner than the distance between sites, and near sharp edges: inner balls fill up.
    for (std::size_t a = 0; axis_ && a < active.size(); ++a) {
      pools[a] = thinned(pools[a], effort_.reducer_balls / 2);
      inner[a] = thinned(inner[a], effort_.reducer_balls - pools[a].size());
      pools[a].insert(pools[a].end(), inner[a].begin(), inner[a].end());
    }
    std::vector<std::vector<FittedBall>> children(active.size());
    tbb::parallel_for(std::size_t{0}, active.size(), [&](std::size_t a) {
      progress_.check();
      children[a] = reduceOne(points[a], pools[a], nodes[active[a]].ball);
    });
    return children;
  }

  std::vector<std::vector<MedialBall>> refineAxis(const std::vector<Node>& nodes, const std::vector<std::uint32_t>& active,
                                                  const std::vector<std::uint32_t>& number, const std::vector<std::uint32_t>& owner) {
    double mean = 0;
    for (const std::uint32_t n : active) mean += nodes[n].ball.overhang() / static_cast<double>(active.size());
    std::vector<AdaptiveMedialAxis::Target> targets;
    for (const std::uint32_t n : active)
      targets.push_back({std::min(nodes[n].ball.overhang(), mean) / kErrorFactor, kLeastBalls, effort_.reducer_balls});
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
      const std::uint32_t n = owner[nearest];
      return n < number.size() ? number[n] : kNoParent;
    };
    return axis_->refine(region_of, targets, progress_);
  }

  // No balls: one child is all that the region takes, and it would not be better than the node's own ball.
  std::vector<FittedBall> reduceOne(const std::vector<Vector3d>& points, const std::vector<MedialBall>& pool, const FittedBall& own) {
    std::vector<FittedBall> alone{own};
    refitBalls(field_, points, alone, {}, 0, progress_);
    if (points.size() < 2) return alone;
    const std::vector<Vector3d> few_points = farthestFirst(points, effort_.reducer_points);
    std::vector<FittedBall> best;
    double least = kInfinity;
    for (const Method& method : methods_) {
      const double limit = best.empty() ? kInfinity : kRefitGain * least;
      std::vector<FittedBall> balls = cover(method, few_points, pool, static_cast<std::size_t>(settings_.branching), limit);
      if (balls.empty()) continue;
      improve(few_points, balls);
      refitBalls(field_, points, balls, {}, 1, progress_);
      const double worst = worstOverhang(balls);
      if (worst < least) least = worst, best = std::move(balls);
    }
    if (best.empty()) best = alone;
    // The region may be more than the own ball holds, since balls grow for the division: then even one child is needed.
    if (best.size() == 1 && alone[0].radius <= own.radius * (1 + 1e-9) && best[0].overhang() >= own.overhang() * (1 - 1e-6)) best.clear();
    return best;
  }

  std::vector<FittedBall> cover(const Method& method, std::span<const Vector3d> points, const std::vector<MedialBall>& pool,
                                std::size_t most, double limit) {
    Region region{field_, points, {}};
    if (method.uses_medial_axis) region.pool = pool;
    region.most = most;
    region.enough = settings_.tolerance_mm;
    region.limit = limit;
    region.seed = settings_.seed;
    std::vector<FittedBall> balls = method.reduce(region);
    if (balls.empty()) return balls;
    refitBalls(field_, points, balls, {}, kRefitRounds, progress_);
    std::vector<std::uint32_t> group(balls.size(), 0);
    dropMarked(balls, group, findRedundant(points, balls, group, {}));
    return balls;
  }

  // Balls for the parts of a patch: each point goes with the nearest of some ends that lie far from each other.
  std::vector<FittedBall> breakUp(const std::vector<Vector3d>& points, std::size_t parts) {
    const std::vector<Vector3d> ends = farthestFirst(points, parts);
    if (ends.size() < parts) return {};
    std::vector<std::vector<Vector3d>> part(parts);
    for (const Vector3d& p : points) {
      std::size_t nearest = 0;
      for (std::size_t k = 1; k < parts; ++k)
        if ((p - ends[k]).squaredNorm() < (p - ends[nearest]).squaredNorm()) nearest = k;
      part[nearest].push_back(p);
    }
    std::vector<FittedBall> balls;
    for (const auto& own : part) {
      if (own.empty()) continue;
      const Ball smallest = smallestBall(own);
      balls.push_back({smallest.centre, -field_.signedDistance(smallest.centre), smallest.radius});
    }
    refitBalls(field_, points, balls, {}, kRefitRounds, progress_);
    return balls;
  }

  // Splits the worst ball in two; if that makes one too many, takes away the one whose loss costs least. As long as it pays.
  // Greedy reducers need it: they cover a cube by one ball in the middle and seven corners, where eight octants do twice as well.
  void improve(const std::vector<Vector3d>& points, std::vector<FittedBall>& balls) {
    const auto most = static_cast<std::size_t>(settings_.branching);
    for (std::size_t round = 0; round < 3 * most; ++round) {
      progress_.check();
      std::vector<FittedBall> split = balls;
      const std::vector<std::uint32_t> owner = assignDeepest(points, split);
      const auto worst = std::max_element(split.begin(), split.end(),
                                          [](const FittedBall& a, const FittedBall& b) { return a.overhang() < b.overhang(); });
      if (isGoodEnough(*worst)) return;
      std::vector<Vector3d> part;
      for (std::size_t i = 0; i < points.size(); ++i)
        if (owner[i] == static_cast<std::uint32_t>(worst - split.begin())) part.push_back(points[i]);
      const double before = worst->overhang();
      std::vector<FittedBall> halves = breakUp(part, 2);
      // Half a cube reaches out farther than the cube, an octant does not.
      const std::size_t spare = most - std::min(most, balls.size()) + 1;
      if (spare > 2 && (halves.size() < 2 || worstOverhang(halves) >= before)) halves = breakUp(part, spare);
      if (halves.size() < 2 || worstOverhang(halves) >= before) return;
      split.erase(worst);
      split.insert(split.end(), halves.begin(), halves.end());
      std::vector<FittedBall> better;
      double least = before * (1 - 1e-3);
      if (split.size() <= most) {
        refitBalls(field_, points, split, {}, kRefitRounds, progress_);
        better = std::move(split);
      } else {
        // The few whose loss looks cheapest before the others are refitted.
        struct Loss {
          double worst;
          std::size_t ball;
          auto operator<=>(const Loss&) const = default;
        };
        std::vector<Loss> losses;
        const auto without = [&](std::size_t lost) {
          std::vector<FittedBall> rest = split;
          rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(lost));
          return rest;
        };
        for (std::size_t lost = 0; lost < split.size(); ++lost) {
          std::vector<FittedBall> trial = without(lost);
          refitBalls(field_, points, trial, {}, 0, progress_);
          losses.push_back({worstOverhang(trial), lost});
        }
        std::sort(losses.begin(), losses.end());
        for (std::size_t k = 0; k < std::min(trials_, losses.size()); ++k) {
          std::vector<FittedBall> trial = without(losses[k].ball);
          refitBalls(field_, points, trial, {}, kRefitRounds, progress_);
          const double now = worstOverhang(trial);
          if (now < least) least = now, better = std::move(trial);
        }
      }
      if (better.empty()) return;
      balls = std::move(better);
    }
  }

  // Refits the level as a whole, since a ball may serve its neighbours' regions too, and closes the gaps between the points.
  void settle(std::vector<FittedBall>& balls, std::vector<std::uint32_t>& parents, std::size_t families) {
    refitLevel(balls, kRefitRounds);
    dropMarked(balls, parents, findRedundantOfLevel(balls, parents));
    for (int round = 0; round < effort_.gap_rounds; ++round) {
      addGaps(balls);
      refitLevel(balls, kRefitRounds);
      if (round == 0) improveLevel(balls, parents, families);
    }
    // What is left without a point still stands for its parent: as the ball that reaches nowhere out.
    for (FittedBall& ball : balls)
      if (!(ball.radius > 0)) ball.radius = std::max(ball.clearance, kNegligible * field_.diagonal());
  }

  // Owner of each point: among `balls`, then the ended ones, which stay as they are.
  std::vector<std::uint32_t> refitLevel(std::vector<FittedBall>& balls, int rounds) {
    const std::size_t count = balls.size();
    std::vector<char> fixed(count, 0);
    balls.insert(balls.end(), ended_.begin(), ended_.end());
    fixed.resize(balls.size(), 1);
    std::vector<std::uint32_t> owner = refitBalls(field_, surface_.points, balls, fixed, rounds, progress_);
    balls.resize(count);
    return owner;
  }

  std::vector<char> findRedundantOfLevel(const std::vector<FittedBall>& balls, const std::vector<std::uint32_t>& parents) const {
    std::vector<FittedBall> all = balls;
    all.insert(all.end(), ended_.begin(), ended_.end());
    std::vector<std::uint32_t> group = parents;
    group.resize(all.size(), 0);
    std::vector<char> fixed(balls.size(), 0);
    fixed.resize(all.size(), 1);
    std::vector<char> redundant = findRedundant(surface_.points, all, group, fixed);
    redundant.resize(balls.size());
    return redundant;
  }

  void addGaps(const std::vector<FittedBall>& balls) {
    std::vector<Ball> plain;
    for (const FittedBall& b : balls) plain.push_back(b.ball());
    for (const FittedBall& b : ended_) plain.push_back(b.ball());
    std::vector<std::uint32_t> triangles(mesh_.triangles.size());
    std::iota(triangles.begin(), triangles.end(), 0u);
    for (const CoverGap& gap : findCoverGaps(mesh_, triangles, plain, 0.01 * worstOverhang(balls), progress_)) {
      surface_.points.push_back(gap.point);
      surface_.load.push_back(0);
      surface_.inner.emplace_back();
    }
  }

  // Each family of siblings again, on the points that it owns by now.
  void improveLevel(std::vector<FittedBall>& balls, std::vector<std::uint32_t>& parents, std::size_t families) {
    const std::vector<std::uint32_t> owner = refitLevel(balls, 0);
    std::vector<std::vector<FittedBall>> family(families);
    std::vector<std::vector<Vector3d>> points(families);
    for (std::size_t b = 0; b < balls.size(); ++b) family[parents[b]].push_back(balls[b]);
    for (std::size_t i = 0; i < owner.size(); ++i)
      if (owner[i] < balls.size()) points[parents[owner[i]]].push_back(surface_.points[i]);
    tbb::parallel_for(std::size_t{0}, family.size(), [&](std::size_t a) {
      if (family[a].empty() || points[a].empty()) return;
      const std::vector<Vector3d> few_points = farthestFirst(points[a], effort_.reducer_points);
      improve(few_points, family[a]);
    });
    balls.clear();
    parents.clear();
    for (std::uint32_t a = 0; a < family.size(); ++a)
      for (const FittedBall& b : family[a]) balls.push_back(b), parents.push_back(a);
    refitLevel(balls, kRefitRounds);
  }

  // Owners among `balls`, then the ended ones. All balls grow to the worst overhang of the level first: it leaves the division
  // room to give equal parts, and nothing asks a child to stay within the cover ball of its parent.
  std::vector<std::uint32_t> divide(const std::vector<FittedBall>& balls) const {
    std::vector<FittedBall> all = balls;
    const double worst = worstOverhang(balls);
    for (FittedBall& ball : all) ball.radius = std::max(ball.radius, ball.clearance + worst);
    all.insert(all.end(), ended_.begin(), ended_.end());
    std::vector<char> closed(all.size(), 1);
    for (std::size_t b = 0; b < balls.size(); ++b) closed[b] = isGoodEnough(balls[b]);
    return handDown(surface_.points, surface_.load, all, closed);
  }

  const TriangleMesh& mesh_;
  const DistanceField& field_;
  std::span<const Method> methods_;
  const PublishedSettings& settings_;
  Effort effort_;
  Progress& progress_;
  SurfacePoints surface_;
  std::size_t trials_ = 0;  // balls whose loss is tried out in full, on the present level
  std::optional<AdaptiveMedialAxis> axis_;
  std::vector<FittedBall> ended_;  // balls of nodes without children, on all levels so far
};

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
  return Frame(mesh, field, methods, settings, progress).run();
}

}  // namespace spheretree::builder
