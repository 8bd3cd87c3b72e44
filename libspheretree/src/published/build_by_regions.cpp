// SPDX-License-Identifier: GPL-3.0-or-later
#include "published/build_by_regions.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "base/negligible.h"
#include "base/thinned.h"
#include "geometry/box_tree.h"
#include "geometry/surface_samples.h"
#include "medial/shrinking_balls.h"
#include "spheretree/core/smallest_enclosing_ball.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

// What the authors call the quality of a tree. At standard, the values of their program.
struct Sampling {
  std::size_t points;        // on the surface, for each ball that the deepest level may have
  std::size_t root_balls;    // medial balls, at least, before the root is divided
  std::size_t region_balls;  // ... and in the region of each node
};
constexpr std::size_t kMinLeaves = 512;      // a tree of fewer leaves has the points of a tree of this number: 10,000 at standard
constexpr double kErrorFactor = 2;           // ratio of the overhangs of a node and of the medial balls in its region, as in the paper
constexpr std::size_t kFirstSites = 64;      // of the adaptive medial axis; it grows from them
constexpr std::size_t kStaticSamples = 500;  // points of the static medial axis beside the vertices of the mesh, as in the paper
constexpr std::size_t kMaxVertices = 2000;   // of the mesh in the static medial axis
constexpr std::size_t kSitesFrom = 8;        // the first sites are the farthest from each other of this multiple of points
constexpr int kRefits = 3;                   // rounds, as in the paper
constexpr std::size_t kSitesABall = 4;       // of the adaptive medial axis are inserted at most, for each ball that is wanted

Sampling samplingOf(Quality quality) {
  switch (quality) {
    case Quality::Quick:
      return {.points = 10, .root_balls = 500, .region_balls = 100};
    case Quality::Standard:
      return {.points = 20, .root_balls = 1000, .region_balls = 200};
    case Quality::Best:
      return {.points = 80, .root_balls = 4000, .region_balls = 800};
  }
  return {};
}

// Spread by area, on sharp edges, and the vertices of the mesh as far as they are not too many.
std::vector<Vector3d> surfacePoints(const TriangleMesh& mesh, std::size_t count, std::uint64_t seed) {
  SampleSettings sampling;
  sampling.count = count;
  sampling.seed = seed;
  std::vector<Vector3d> points;
  for (const SurfaceSample& s : sampleSurface(mesh, sampling)) points.push_back(s.point);
  const std::vector<Vector3d> corners = thinned(mesh.positions, count);
  points.insert(points.end(), corners.begin(), corners.end());
  return points;
}

// The authors promote Voronoi vertices outside of the solid where the inner ones leave the surface uncovered. Here the
// largest inner ball that touches the surface at the point with the largest gap enters, until no gap exceeds `target`
// and there are as many balls as wanted.
void addCoverBalls(const DistanceField& field, std::span<const Vector3d> points, double target, std::size_t wanted,
                   std::vector<FittedBall>& pool) {
  std::vector<double> gap(points.size(), kInfinity);
  const auto add = [&](const FittedBall& ball) {
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double reach = gap[i] + ball.clearance, square = (points[i] - ball.centre).squaredNorm();
      if (reach > 0 && square < reach * reach) gap[i] = std::sqrt(square) - ball.clearance;
    }
  };
  for (const FittedBall& ball : pool) add(ball);
  while (true) {
    const auto worst = std::ranges::max_element(gap);
    if (worst == gap.end() || !(*worst > 0) || (*worst <= target && pool.size() >= wanted)) return;
    const Ball touching = touchingBall(field, points[static_cast<std::size_t>(worst - gap.begin())]);
    *worst = 0;  // at a sharp convex edge no ball touches
    if (!(touching.radius > 0)) continue;
    pool.push_back({touching.centre, touching.radius, touching.radius});
    add(pool.back());
  }
}

struct Node {
  FittedBall ball;
  std::uint32_t parent = kNone;
  std::vector<std::uint32_t> points;  // of the region
};

class TreeBuilder {
 public:
  TreeBuilder(const TriangleMesh& mesh, const DistanceField& field, std::span<const Method> methods, const BuildSettings& settings,
              Progress& progress)
      : field_(field), methods_(methods), settings_(settings), sampling_(samplingOf(settings.quality)), progress_(progress) {
    std::size_t leaves = 1;
    for (int level = 1; level < settings.levels; ++level) leaves *= static_cast<std::size_t>(settings.branching);
    points_ = surfacePoints(mesh, sampling_.points * std::max(leaves, kMinLeaves), settings.seed);
    const bool wants_static = std::ranges::any_of(methods, [&](const Method& m) { return isStatic(m); });
    const bool wants_adaptive =
        std::ranges::any_of(methods, [&](const Method& m) { return m.axis == Method::Axis::Asked && !isStatic(m); });
    if (wants_adaptive) {
      adaptive_.emplace(field, farthestFirst(thinned(points_, kSitesFrom * kFirstSites), kFirstSites));
    }
    if (wants_static) {
      std::vector<Vector3d> sites = thinned(points_, kStaticSamples);
      const std::vector<Vector3d> vertices = thinned(mesh.positions, kMaxVertices);
      sites.insert(sites.end(), vertices.begin(), vertices.end());
      static_.emplace(field, sites);
    }
    std::vector<Eigen::AlignedBox3d> boxes;
    for (const Vector3d& p : points_) boxes.emplace_back(p, p);
    nearest_ = BoxTree(boxes, 8);
  }

  LevelBalls run() {
    std::vector<Node> level{root()};
    LevelBalls out;
    for (int depth = 0; !level.empty(); ++depth) {
      out.balls.emplace_back();
      out.parents.emplace_back();
      for (const Node& node : level) {
        out.balls.back().push_back({node.ball.centre, std::max(node.ball.radius, kNegligible * field_.diagonal())});
        out.parents.back().push_back(node.parent);
      }
      if (depth + 1 == settings_.levels) break;
      progress_.advance(static_cast<double>(depth) / (settings_.levels - 1));
      level = childrenOf(level);
    }
    return out;
  }

 private:
  bool isStatic(const Method& m) const {
    return m.axis == Method::Axis::Static || (m.axis == Method::Axis::Asked && settings_.medial_axis == MedialAxis::Static);
  }
  bool isGoodEnough(const FittedBall& ball) const {
    return ball.overhang() <= std::max(settings_.tolerance_mm, kNegligible * field_.diagonal());
  }

  Node root() const {
    const Ball ball = smallestEnclosing(points_);
    Node node{{ball.centre, ball.radius, -field_.signedDistance(ball.centre)}, kNone, std::vector<std::uint32_t>(points_.size())};
    for (std::uint32_t i = 0; i < points_.size(); ++i) node.points[i] = i;
    return node;
  }

  std::vector<Node> childrenOf(const std::vector<Node>& level) {
    std::vector<std::uint32_t> open;  // nodes that get children
    for (std::uint32_t n = 0; n < level.size(); ++n)
      if (!isGoodEnough(level[n].ball) && level[n].points.size() > 1) open.push_back(n);
    std::vector<std::uint32_t> region(points_.size(), kNone);  // of each point, an index in `open`
    for (std::uint32_t k = 0; k < open.size(); ++k)
      for (const std::uint32_t i : level[open[k]].points) region[i] = k;
    double mean = 0;  // of the overhangs of the level
    for (const Node& node : level) mean += node.ball.overhang() / static_cast<double>(level.size());
    std::vector<AdaptiveMedialAxis::Target> refined_to, as_it_is(open.size());
    const std::size_t wanted = level.size() == 1 ? sampling_.root_balls : sampling_.region_balls;
    for (const std::uint32_t n : open)
      refined_to.push_back({std::min(level[n].ball.overhang(), mean) / kErrorFactor, wanted, kSitesABall * wanted});
    const std::vector<std::vector<FittedBall>> refined = ballsOf(adaptive_, refined_to, region), fixed = ballsOf(static_, as_it_is, region);
    std::vector<std::vector<Node>> families(open.size());
    tbb::parallel_for(std::size_t{0}, open.size(), [&](std::size_t k) {
      progress_.check();
      families[k] = divide(level[open[k]], open[k], refined_to[k], refined[k], fixed[k]);
    });
    std::vector<Node> children;
    for (std::vector<Node>& family : families) std::ranges::move(family, std::back_inserter(children));
    return children;
  }

  // The children of a node. None if the methods find nothing better than the node itself.
  std::vector<Node> divide(const Node& node, std::uint32_t number, const AdaptiveMedialAxis::Target& target,
                           std::vector<FittedBall> refined, std::vector<FittedBall> fixed) const {
    std::vector<Vector3d> points;
    for (const std::uint32_t i : node.points) points.push_back(points_[i]);
    if (adaptive_) addCoverBalls(field_, points, target.overhang, target.min_balls, refined);
    if (static_) addCoverBalls(field_, points, target.overhang, 0, fixed);
    Region region{field_, points, {}};
    region.max_balls = static_cast<std::size_t>(settings_.branching);
    region.target_overhang = settings_.tolerance_mm;
    std::vector<std::span<const FittedBall>> pools;
    for (const Method& m : methods_) pools.push_back(isStatic(m) ? fixed : refined);
    std::vector<FittedBall> balls = reduceRegion(region, methods_, pools, progress_);
    if (balls.size() < 2 && (balls.empty() || balls[0].overhang() >= node.ball.overhang())) return {};
    const std::vector<std::uint32_t> deepest = assignDeepest(points, balls), owner = assignToRegions(points, balls);
    std::vector<Node> children;
    for (const FittedBall& ball : balls) children.push_back({ball, number, {}});
    for (std::size_t i = 0; i < owner.size(); ++i)  // a point on the rim of a ball may be outside of it by rounding
      children[owner[i] == kNone ? deepest[i] : owner[i]].points.push_back(node.points[i]);
    return children;
  }

  // The region of the point nearest to a place on the surface.
  std::uint32_t regionOf(const Vector3d& p, const std::vector<std::uint32_t>& region) const {
    double limit2 = kInfinity;
    std::uint32_t nearest = 0;
    nearest_.searchNearest(p, limit2, [&](std::size_t first, std::size_t count) {
      for (std::size_t slot = first; slot < first + count; ++slot) {
        const std::uint32_t i = nearest_.order()[slot];
        const double d2 = (points_[i] - p).squaredNorm();
        if (d2 < limit2) limit2 = d2, nearest = i;
      }
    });
    return region[nearest];
  }

  // The balls of a medial axis in each region, after it has been refined there; none without an axis.
  std::vector<std::vector<FittedBall>> ballsOf(std::optional<AdaptiveMedialAxis>& axis, std::span<const AdaptiveMedialAxis::Target> targets,
                                               const std::vector<std::uint32_t>& region) {
    if (!axis) return std::vector<std::vector<FittedBall>>(targets.size());
    return axis->refine([&](const Vector3d& p) { return regionOf(p, region); }, targets, progress_);
  }

  const DistanceField& field_;
  std::span<const Method> methods_;
  const BuildSettings& settings_;
  Sampling sampling_;
  Progress& progress_;
  std::vector<Vector3d> points_;
  BoxTree nearest_;  // over the points
  std::optional<AdaptiveMedialAxis> adaptive_, static_;
};

void dropRedundant(std::span<const Vector3d> points, std::vector<FittedBall>& balls) {
  const std::vector<std::uint32_t> one_group(balls.size(), 0);
  const std::vector<char> redundant = maybeRedundant(findHolders(points, balls), balls, one_group, {}, {});
  std::size_t kept = 0;
  for (std::size_t b = 0; b < balls.size(); ++b)
    if (!redundant[b]) balls[kept++] = balls[b];
  balls.resize(kept);
}

}  // namespace

std::vector<FittedBall> reduceRegion(const Region& region, std::span<const Method> methods,
                                     std::span<const std::span<const FittedBall>> pools, Progress& progress) {
  std::vector<FittedBall> best;
  for (std::size_t m = 0; m < methods.size(); ++m) {
    Region own = region;
    own.pool = pools[m];
    std::vector<FittedBall> balls = methods[m].reduce(own);
    if (balls.empty()) continue;
    if (methods[m].refits) {
      refitBalls(region.field, region.points, balls, kRefits, progress);
      std::erase_if(balls, [](const FittedBall& b) { return !(b.radius > 0); });
      if (balls.empty()) continue;
      dropRedundant(region.points, balls);
    }
    if (best.empty() || worstOverhang(balls) < worstOverhang(best)) best = std::move(balls);
  }
  return best;
}

LevelBalls buildByRegions(const TriangleMesh& mesh, const DistanceField& field, std::span<const Method> methods,
                          const BuildSettings& settings, Progress& progress) {
  if (methods.empty()) throw std::invalid_argument("published builders: no method given");
  return TreeBuilder(mesh, field, methods, settings, progress).run();
}

}  // namespace spheretree::builder
