// SPDX-License-Identifier: GPL-3.0-or-later
#include "hulls/fit_hulls.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Regular_triangulation_3.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <queue>
#include <set>
#include <span>
#include <tuple>

#include "certify/triangle_piece.h"
#include "hulls/hull_cover.h"
#include "hulls/hull_overhang.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using VertexBase = CGAL::Triangulation_vertex_base_with_info_3<std::uint32_t, Kernel, CGAL::Regular_triangulation_vertex_base_3<Kernel>>;
using Triangulation =
    CGAL::Regular_triangulation_3<Kernel,
                                  CGAL::Triangulation_data_structure_3<VertexBase, CGAL::Regular_triangulation_cell_base_3<Kernel>>>;

constexpr std::size_t kMaxSamples = 40000;       // of the surface
constexpr std::size_t kMinSamples = 16;          // fewer say nothing of the shape
constexpr double kSampleArea = 2;                // for each of them, as a multiple of the tolerance times the radius of the ball below it
constexpr std::size_t kMaxBalls = 1000;          // that are joined
constexpr double kFirstGap = 8;                  // of the first balls, as a multiple of the tolerance
constexpr int kRounds = 8;                       // of more balls
constexpr double kBetween = 0.04;                // share of the tolerance for what lies between samples
constexpr double kGap = 0.8;                     // largest gap between a ball and the sample it is for, as a share of the tolerance
constexpr double kPull = 0.2;                    // of that gap, against the radius, while balls are centred
constexpr double kSteepest = 0.99;               // of a hull: well below kSteepestHull, so that rounding cannot reach that
constexpr double kAccuracy = 0.02;               // of the overhang of a hull, as a share of the tolerance
constexpr std::size_t kEstimate = 8;             // steps along a side for the estimate of the overhang; a power of two
constexpr double kThinnest = 0.05;               // height of a slab's triangle over its longest side
constexpr double kDeeper = 1.3;                  // factor from depth to depth below a point of the surface
constexpr double kMove = 0.3, kLastMove = 1e-3;  // steps of the centring of balls, as shares of their radii
constexpr int kHalvings = 7;                     // of the search for a depth
constexpr double kTried = 4;                     // cost of a collapse that is tried, with the balls around it moved thereafter
constexpr std::size_t kNear = 8;                 // balls that are moved at a time
constexpr int kRepeats = 3;                      // of the collapse, with more samples
constexpr int kSweeps = 2;                       // over them, for each length of moves
constexpr double kLastMend = 0.01;               // smallest of these lengths, as a share of the radius
constexpr double kGain = 0.999;                  // of such a move: of the energy before
constexpr double kWorse = 4;                     // power of the cost of a hull in that energy
constexpr double kCostSteps = 20;                // collapses whose costs are in one such part of the limit are taken by their lengths
constexpr double kPlastic = 0.7548776662466927;  // its multiples and those of its square fill a square evenly
constexpr int kMends = 4;                        // rounds of moves for places that are not held
constexpr int kFailures = 8;                     // of such collapses one after the other, then no more are tried
constexpr std::size_t kHopeless = 2;             // times the allowed number of hulls: so many do not become few enough
constexpr int kMoves = 3;                        // at most, of each length

double areaOf(const Piece& piece) { return 0.5 * (piece.corner[1] - piece.corner[0]).cross(piece.corner[2] - piece.corner[0]).norm(); }

// Strips parallel to the shortest side. Halving alone would cut a sliver into many more pieces, each thinner than it.
std::vector<Piece> stripsOf(const Piece& piece, double width) {
  const std::size_t k = shortestSide(piece);
  const Vector3d &apex = piece.corner[k], &b = piece.corner[(k + 1) % 3], &c = piece.corner[(k + 2) % 3];
  const double count = std::ceil(std::sqrt(side2(piece, longestSide(piece))) / width);
  std::vector<Piece> strips;
  Vector3d b_before = apex, c_before = apex;
  for (double i = 1; i <= count; ++i) {
    const Vector3d b_here = i < count ? Vector3d(apex + i / count * (b - apex)) : b,
                   c_here = i < count ? Vector3d(apex + i / count * (c - apex)) : c;
    strips.push_back({{b_before, b_here, c_here}});
    if (i > 1) strips.push_back({{b_before, c_here, c_before}});
    b_before = b_here, c_before = c_here;
  }
  return strips;
}

// The deepest ball below a point of the surface that leaves at most `tolerance` between them; radius 0 if there is
// none. Balls that touch the surface would be far smaller below flat facets than the surface is thick.
Ball ballBelowPoint(const DistanceField& field, const Vector3d& point, const Vector3d& normal, double tolerance) {
  Ball best{point, 0};
  const auto reaches = [&](double depth) {
    const Vector3d c = point - depth * normal;
    const double radius = -field.signedDistance(c);
    if (!(radius >= depth - tolerance && radius > 0)) return false;
    best = {c, radius};
    return true;
  };
  double low = tolerance, high = kDeeper * low;
  while (reaches(high)) low = high, high *= kDeeper;
  for (int halving = 0; halving < kHalvings; ++halving) {
    const double middle = 0.5 * (low + high);
    (reaches(middle) ? low : high) = middle;
  }
  return best;
}

// Across: towards the nearest surface. Along: towards the point, as far as that is across the former.
Eigen::Matrix3d axesAt(const DistanceField& field, const Ball& ball, const Vector3d& point) {
  Vector3d out = field.nearest(ball.centre).point - ball.centre;
  if (!(out.norm() > 0)) return Eigen::Matrix3d::Identity();
  out.normalize();
  Vector3d along = point - ball.centre;
  along -= along.dot(out) * out;
  along = along.norm() > kThinnest * ball.radius ? along.normalized() : out.unitOrthogonal();
  Eigen::Matrix3d axes;
  axes << out, along, out.cross(along);
  return axes;
}

// Moved to where the surface is farther away, but not farther than `gap` from the point: a long cone is within the
// tolerance only if it is centred. Of balls of one size, the one nearest to the point, so that borders are reached.
Ball centred(const DistanceField& field, Ball ball, const Vector3d& point, double gap) {
  const auto valueOf = [&](const Ball& b) { return (1 + kPull) * b.radius - kPull * (point - b.centre).norm(); };
  for (double step = kMove; step > kLastMove; step *= 0.5)
    for (int move = 0; move < kMoves; ++move) {
      const Eigen::Matrix3d axes = axesAt(field, ball, point);
      Ball best = ball;
      for (Eigen::Index axis = 0; axis < 3; ++axis)
        for (const double sign : {1.0, -1.0}) {
          const Vector3d c = ball.centre + sign * step * ball.radius * axes.col(axis);
          const Ball moved{c, -field.signedDistance(c)};
          if (valueOf(moved) > valueOf(best) && (point - c).norm() - moved.radius <= gap) best = moved;
        }
      if (best.centre == ball.centre) break;
      ball = best;
    }
  return ball;
}

// A ball, a cone or a slab of the complex.
struct Simplex {
  std::array<std::uint32_t, 3> corner{};  // balls, ascending, `hull.count` of them
  Hull hull{};                            // of the inscribed balls
  double overhang = 0;                    // of the hull, about [mm]
  std::optional<HullDistance> distance{};
  std::vector<std::uint32_t> samples{};  // that it holds best
  bool is_alive = true;
  std::span<const std::uint32_t> corners() const { return {corner.data(), hull.count}; }
  double costOf(const Vector3d& p) const { return std::max(0.0, (*distance)(p)) + overhang; }
  bool has(std::uint32_t v) const { return std::ranges::find(corners(), v) != corners().end(); }
  bool isIn(const Simplex& other) const {
    return std::ranges::all_of(corners(), [&](std::uint32_t v) { return other.has(v); });
  }
};

struct Sample {
  Vector3d point, normal;
  double cost = kInfinity;  // how far the best hull has to grow to hold it, plus the overhang of that hull [mm]
};

// The balls and hulls, and the hull that holds each sample best.
struct Complex {
  std::vector<Ball> balls{};  // inscribed
  std::vector<Simplex> simplices{};
  std::vector<std::vector<std::uint32_t>> of{};  // (ball) its simplices, and some that are gone
  std::vector<Sample> samples{};
};

// Balls replaced by one.
struct Change {
  std::vector<std::uint32_t> from{};
  std::uint32_t to = 0;  // the number of balls for a new one
  Ball ball{};
  double cost = kInfinity;    // largest of the hulls and samples that are worse for it [mm]
  double energy = kInfinity;  // of all hulls around it
  std::vector<Simplex> made{};
  std::vector<std::pair<std::uint32_t, double>> costs{};        // (sample, new cost)
  std::vector<std::pair<std::uint32_t, std::uint32_t>> kept{};  // (simplex, sample) for simplices that stay
};

class HullFit {
 public:
  HullFit(const TriangleMesh& mesh, const DistanceField& field, const FitSettings& settings, Progress& progress)
      : mesh_(mesh),
        field_(field),
        settings_(settings),
        progress_(progress),
        margin_(kAccuracy * settings.tolerance + settings.rounding),
        most_((1 - kBetween) * settings.tolerance - 2 * margin_) {}

  // Nothing if the solid is nowhere thicker than the tolerance.
  std::optional<std::vector<Hull>> run() {
    cutPieces();
    sample();
    if (now_.samples.size() < kMinSamples) return std::nullopt;
    addBalls(kFirstGap * settings_.tolerance, kMaxBalls / 4);
    if (now_.balls.empty()) addBalls(most_, 1);
    if (now_.balls.empty()) return std::nullopt;
    for (int repeat = 0;; ++repeat) {
      const std::vector<Ball> balls = joinedBalls();
      collapseAll();
      prune();
      if (now_.simplices.size() > kHopeless * settings_.max_hulls) return std::vector<Hull>();
      if (!hasBare() || repeat == kRepeats) break;
      now_.balls = balls;
    }
    most_ = settings_.tolerance - 2 * margin_;
    tryCollapses();
    std::vector<Hull> hulls = chosen();
    fill(hulls);
    hulls = withoutRedundant(hulls);
    if (hulls.size() > settings_.max_hulls) hulls.clear();
    return hulls;
  }
  // Whether it is so in places, which single balls hold then.
  bool isThin() const { return is_thin_; }

 private:
  static Vector3d normalOf(const Piece& piece) {
    return (piece.corner[1] - piece.corner[0]).cross(piece.corner[2] - piece.corner[0]).normalized();
  }
  Ball ballBelow(const Piece& piece) const { return ballBelowPoint(field_, centroidOf(piece), normalOf(piece), 0.5 * settings_.tolerance); }

  // Joins the balls, and adds more of them, until all samples are held. All these balls.
  std::vector<Ball> joinedBalls() {
    for (int round = 0;; ++round) {
      joinBalls();
      holdSamples();
      const std::size_t before = now_.balls.size();
      if (round < kRounds) addBalls(most_, before + before / 2);
      if (now_.balls.size() == before) break;
    }
    std::erase_if(now_.simplices, [](const Simplex& s) { return s.samples.empty(); });
    compact();
    return now_.balls;
  }

  // The triangles, cut to pieces that are no longer than the balls below them are wide.
  void cutPieces() {
    std::vector<std::vector<CutPiece>> cut(mesh_.triangles.size());
    tbb::parallel_for(std::size_t{0}, cut.size(), [&](std::size_t t) {
      const Piece triangle = pieceOf(mesh_, t, Vector3d::Zero());
      if (!(areaOf(triangle) > 0)) return;
      const auto radiusOf = [&](const Piece& p) { return std::max(ballBelow(p).radius, settings_.tolerance); };
      double radius = radiusOf(triangle);
      std::vector<Piece> stack = stripsOf(triangle, 2 * radius);
      for (const bool is_whole = stack.size() == 1; !stack.empty();) {
        const Piece piece = stack.back();
        stack.pop_back();
        const std::size_t k = longestSide(piece);
        if (!is_whole) radius = radiusOf(piece);
        if (side2(piece, k) > 4 * radius * radius)
          for (const Piece& half : halvesOf(piece, k)) stack.push_back(half);
        else
          cut[t].push_back({piece, areaOf(piece) / (kSampleArea * radius * settings_.tolerance)});
      }
    });
    for (const auto& of_triangle : cut) pieces_.insert(pieces_.end(), of_triangle.begin(), of_triangle.end());
  }

  // More samples where the surface is more curved. Their places in a piece are those of a sequence that is even there.
  void sample() {
    double wanted = 0;
    for (const CutPiece& cut : pieces_) wanted += cut.samples;
    const double share = std::min(1.0, kMaxSamples / wanted);
    double sum = 0.5;
    for (const CutPiece& cut : pieces_) {
      sum += share * cut.samples;
      const auto& [a, b, c] = cut.piece.corner;
      for (; sum >= 1; --sum) {
        const std::size_t n = now_.samples.size();
        double u = std::fmod(static_cast<double>(n) * kPlastic, 1.0), v = std::fmod(static_cast<double>(n) * kPlastic * kPlastic, 1.0);
        if (u + v > 1) u = 1 - u, v = 1 - v;
        now_.samples.push_back({n % 2 == 0 ? cut.piece.corner[n / 2 % 3] : Vector3d(a + u * (b - a) + v * (c - a)), normalOf(cut.piece)});
      }
    }
  }

  // Adds balls, each below the sample that needs the most, until none needs more than `enough`.
  void addBalls(double enough, std::size_t most) {
    while (now_.balls.size() < std::min(most, kMaxBalls)) {
      const auto next = std::ranges::max_element(now_.samples, {}, &Sample::cost);
      if (!(next->cost > enough)) break;
      next->cost = -kInfinity;
      const double gap = kGap * settings_.tolerance;
      Ball ball = ballBelowPoint(field_, next->point, next->normal, gap);
      if (!(ball.radius > 0)) continue;
      ball = centred(field_, ball, next->point, gap);
      now_.balls.push_back(ball);
      for (Sample& s : now_.samples) s.cost = std::min(s.cost, (s.point - ball.centre).norm() - ball.radius);
    }
  }

  // The triangles and sides of the regular triangulation of the balls whose hulls are within the tolerance.
  void joinBalls() {
    std::vector<std::pair<Kernel::Weighted_point_3, std::uint32_t>> points;
    for (std::uint32_t i = 0; i < now_.balls.size(); ++i) {
      const Ball& b = now_.balls[i];
      points.push_back({{{b.centre.x(), b.centre.y(), b.centre.z()}, b.radius * b.radius}, i});
    }
    const Triangulation triangulation(points.begin(), points.end());
    now_.simplices.clear();
    now_.of.assign(now_.balls.size(), {});
    std::vector<std::vector<std::uint32_t>> corners;
    for (auto facet = triangulation.finite_facets_begin(); facet != triangulation.finite_facets_end(); ++facet) {
      corners.emplace_back();
      for (int k = 0; k < 4; ++k)
        if (k != facet->second) corners.back().push_back(facet->first->vertex(k)->info());
    }
    for (auto edge = triangulation.finite_edges_begin(); edge != triangulation.finite_edges_end(); ++edge)
      corners.push_back({edge->first->vertex(edge->second)->info(), edge->first->vertex(edge->third)->info()});
    for (std::uint32_t i = 0; i < now_.balls.size(); ++i) corners.push_back({i});
    std::vector<std::vector<Simplex>> made(corners.size());
    const auto ballOf = [&](std::uint32_t v) { return now_.balls[v]; };
    tbb::parallel_for(std::size_t{0}, made.size(), [&](std::size_t i) { made[i] = madeOf(corners[i], ballOf, most_); });
    // In an order that is the same in each run, unlike that of the triangulation; no hull before those that it is in.
    std::vector<Simplex> all;
    for (auto& some : made) all.insert(all.end(), some.begin(), some.end());
    std::ranges::sort(all, {}, [](const Simplex& s) { return std::pair(3 - s.hull.count, s.corner); });
    for (const Simplex& s : all)
      if (std::ranges::none_of(now_.of[s.corner[0]], [&](std::uint32_t i) { return s.isIn(now_.simplices[i]); })) add(s);
  }

  void add(Simplex s) {
    for (const std::uint32_t v : s.corners()) now_.of[v].push_back(static_cast<std::uint32_t>(now_.simplices.size()));
    now_.simplices.push_back(std::move(s));
  }

  // The hull of these balls if its overhang is below `limit` and it is neither thin nor steep; else those of its sides.
  template <class BallOf>
  std::vector<Simplex> madeOf(std::vector<std::uint32_t> corners, const BallOf& ballOf, double limit) const {
    std::ranges::sort(corners);
    Simplex s;
    s.hull.count = corners.size();
    for (std::size_t k = 0; k < corners.size(); ++k) s.corner[k] = corners[k], s.hull.ball[k] = ballOf(corners[k]);
    if (steepness(s.hull) < kSteepest && !isThin(s.hull)) {
      s.overhang = overhangOf(s.hull, limit);
      s.distance.emplace(s.hull);
      if (s.overhang <= limit) return {s};
    }
    std::vector<Simplex> sides;
    for (std::size_t k = 0; corners.size() > 1 && k < corners.size(); ++k) {
      if (corners.size() == 2) {
        sides.push_back(madeOf({corners[k]}, ballOf, limit).front());
        continue;
      }
      for (const Simplex& side : madeOf({corners[k], corners[(k + 1) % 3]}, ballOf, limit)) sides.push_back(side);
    }
    return sides;
  }

  static bool isThin(const Hull& hull) {
    if (hull.count < 3) return false;
    const Vector3d a = hull.ball[1].centre - hull.ball[0].centre, b = hull.ball[2].centre - hull.ball[0].centre;
    return a.cross(b).norm() < kThinnest * std::max({a.squaredNorm(), b.squaredNorm(), (b - a).squaredNorm()});
  }

  static Hull grownBy(Hull hull, double by) {
    for (std::size_t k = 0; k < hull.count; ++k) hull.ball[k].radius += by;
    return hull;
  }

  // The largest overhang of some balls of the hull; infinite once it exceeds the limit.
  double overhangOf(const Hull& hull, double limit) const {
    double largest = 0;
    const auto isWithin = [&](double w1, double w2) {
      const double w0 = 1 - w1 - w2;
      const auto& [a, b, c] = hull.ball;
      largest = std::max(
          largest, w0 * a.radius + w1 * b.radius + w2 * c.radius + field_.signedDistance(w0 * a.centre + w1 * b.centre + w2 * c.centre));
      return largest <= limit;
    };
    // The middles first, since the overhang is largest there for most hulls that reach out too far.
    for (std::size_t steps = 2; hull.count > 1 && steps <= kEstimate; steps *= 2)
      for (std::size_t i = 0; i <= steps; ++i)
        for (std::size_t j = 0; j <= (hull.count == 3 ? steps - i : 0); ++j) {
          if (i % 2 == 0 && j % 2 == 0) continue;  // done in the round before, or a corner
          const double share = 1 / static_cast<double>(steps);
          if (!isWithin(share * static_cast<double>(i), share * static_cast<double>(j))) return kInfinity;
        }
    return largest;
  }

  void holdSamples() {
    std::vector<Eigen::AlignedBox3d> box;
    for (const Simplex& s : now_.simplices) box.push_back(boxOf(grownBy(s.hull, settings_.tolerance)));
    std::vector<std::uint32_t> best(now_.samples.size(), 0);
    tbb::parallel_for(std::size_t{0}, best.size(), [&](std::size_t i) {
      Sample& sample = now_.samples[i];
      sample.cost = kInfinity;
      for (std::uint32_t s = 0; s < box.size(); ++s) {
        if (!now_.simplices[s].is_alive || !box[s].contains(sample.point)) continue;
        const double cost = now_.simplices[s].costOf(sample.point);
        if (cost < sample.cost) sample.cost = cost, best[i] = s;
      }
      if (sample.cost < kInfinity) return;
      for (std::uint32_t s = 0; s < box.size(); ++s)
        if (now_.simplices[s].is_alive)
          if (const double cost = now_.simplices[s].costOf(sample.point); cost < sample.cost) sample.cost = cost, best[i] = s;
    });
    for (Simplex& s : now_.simplices) s.samples.clear();
    for (std::uint32_t i = 0; i < best.size(); ++i) now_.simplices[best[i]].samples.push_back(i);
  }

  std::vector<std::uint32_t> around(std::uint32_t v) const {
    std::vector<std::uint32_t> out;
    if (v < now_.of.size())
      for (const std::uint32_t i : now_.of[v])
        if (now_.simplices[i].is_alive) out.push_back(i);
    return out;
  }

  std::vector<std::uint32_t> neighbours(std::uint32_t v) const {
    std::vector<std::uint32_t> out;
    for (const std::uint32_t i : around(v))
      for (const std::uint32_t w : now_.simplices[i].corners())
        if (w != v) out.push_back(w);
    std::ranges::sort(out);
    out.erase(std::unique(out.begin(), out.end()), out.end());
    return out;
  }

  // The hulls that take the place of those around the balls `from`. With `to`, hulls of one ball less may be in others.
  std::vector<Simplex> madeBy(const Change& c, std::span<const std::uint32_t> old, double limit) const {
    const auto ballOf = [&](std::uint32_t v) { return v == c.to ? c.ball : now_.balls[v]; };
    const std::vector<std::uint32_t> other = around(c.to);
    std::vector<Simplex> made;
    for (const std::uint32_t i : old) {
      std::vector<std::uint32_t> corners;
      for (const std::uint32_t v : now_.simplices[i].corners()) {
        const std::uint32_t w = std::ranges::find(c.from, v) != c.from.end() ? c.to : v;
        if (std::ranges::find(corners, w) == corners.end()) corners.push_back(w);
      }
      for (const Simplex& s : madeOf(corners, ballOf, limit)) {
        if (std::ranges::any_of(made, [&](const Simplex& m) { return s.isIn(m); })) continue;
        if (std::ranges::any_of(other,
                                [&](std::uint32_t k) { return std::ranges::find(old, k) == old.end() && s.isIn(now_.simplices[k]); }))
          continue;
        std::erase_if(made, [&](const Simplex& m) { return m.isIn(s); });
        made.push_back(s);
      }
    }
    return made;
  }

  // The change that puts `ball` in the place of the balls `from`; its cost is infinite if it exceeds the limit.
  Change changeOf(std::vector<std::uint32_t> from, std::uint32_t to, const Ball& ball, double limit) const {
    Change c{.from = std::move(from), .to = to, .ball = ball};
    std::vector<std::uint32_t> old, near;
    for (const std::uint32_t v : c.from)
      for (const std::uint32_t i : around(v)) insert(old, i);
    c.made = madeBy(c, old, limit);
    for (const std::uint32_t i : old)
      for (const std::uint32_t v : now_.simplices[i].corners())
        for (const std::uint32_t k : around(v))
          if (std::ranges::find(old, k) == old.end()) insert(near, k);
    std::vector<const Simplex*> offered;
    std::vector<Eigen::AlignedBox3d> box;
    std::vector<double> worst;
    const auto offer = [&](const Simplex& s) {
      offered.push_back(&s), worst.push_back(s.overhang);
      box.push_back(boxOf(grownBy(s.hull, std::max(0.0, limit - s.overhang))));
    };
    double cost = 0;
    for (const Simplex& s : c.made) offer(s), cost = std::max(cost, s.overhang);
    for (const std::uint32_t i : near) offer(now_.simplices[i]);
    for (const std::uint32_t i : old)
      for (const std::uint32_t p : now_.simplices[i].samples) {
        double least = kInfinity;
        std::size_t best = 0;
        for (std::size_t k = 0; k < offered.size(); ++k) {
          if (!box[k].contains(now_.samples[p].point)) continue;
          if (const double at = offered[k]->costOf(now_.samples[p].point); at < least) least = at, best = k;
        }
        if (least > limit && now_.samples[p].cost <= limit) return c;
        if (least == kInfinity)
          least = now_.samples[p].cost;
        else
          worst[best] = std::max(worst[best], least);
        if (least > now_.samples[p].cost) cost = std::max(cost, least);
        c.costs.push_back({p, least});
        if (best >= c.made.size())
          c.kept.push_back({near[best - c.made.size()], p});
        else if (best < c.made.size())
          c.made[best].samples.push_back(p);
      }
    c.cost = cost;
    c.energy = 0;
    for (const double w : worst) c.energy += std::pow(w / most_, kWorse);
    return c;
  }

  static void insert(std::vector<std::uint32_t>& list, std::uint32_t i) {
    if (std::ranges::find(list, i) == list.end()) list.push_back(i);
  }

  void apply(const Change& c) {
    for (const std::uint32_t v : c.from)
      for (const std::uint32_t i : around(v)) now_.simplices[i].is_alive = false, now_.simplices[i].samples.clear();
    if (c.to == now_.balls.size()) now_.balls.push_back(c.ball), now_.of.emplace_back();
    for (const auto& [p, cost] : c.costs) now_.samples[p].cost = cost;
    for (const auto& [s, p] : c.kept) now_.simplices[s].samples.push_back(p);
    for (const Simplex& s : c.made) add(s);
  }

  // The changes that make one ball of two neighbours, those within the limit.
  std::vector<Change> collapsesOf(const std::vector<std::pair<std::uint32_t, std::uint32_t>>& pairs, double limit) const {
    std::vector<Change> found(pairs.size());
    tbb::parallel_for(std::size_t{0}, pairs.size(), [&](std::size_t i) {
      const auto [from, to] = pairs[i];
      found[i] = changeOf({from}, to, now_.balls[to], limit);
      found[i].costs.clear(), found[i].kept.clear(), found[i].made.clear();
    });
    std::erase_if(found, [&](const Change& c) { return c.cost > limit; });
    return found;
  }

  // Makes one ball of two neighbours, the least costly first, as long as hulls and samples stay within the tolerance.
  void collapseAll() {
    struct Entry {
      double cost, length;
      std::uint32_t from, to;
      auto key() const { return std::tuple(std::floor(cost), length, from, to); }
      bool operator>(const Entry& other) const { return key() > other.key(); }
    };
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
    const auto tryAll = [&](const std::vector<std::pair<std::uint32_t, std::uint32_t>>& pairs) {
      for (const Change& c : collapsesOf(pairs, most_))
        queue.push({kCostSteps * c.cost / most_, (now_.balls[c.from[0]].centre - c.ball.centre).norm(), c.from[0], c.to});
    };
    std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
    for (std::uint32_t v = 0; v < now_.balls.size(); ++v)
      for (const std::uint32_t w : neighbours(v)) pairs.push_back({v, w});
    tryAll(pairs);
    while (!queue.empty()) {
      progress_.check();
      const Entry e = queue.top();
      queue.pop();
      if (around(e.from).empty() || around(e.to).empty()) continue;
      const Change c = changeOf({e.from}, e.to, now_.balls[e.to], most_);
      if (c.cost > most_) continue;
      if (std::floor(kCostSteps * c.cost / most_) > std::floor(e.cost)) {
        queue.push({kCostSteps * c.cost / most_, e.length, e.from, e.to});
        continue;
      }
      apply(c);
      pairs.clear();
      for (const std::uint32_t w : neighbours(e.to)) pairs.push_back({e.to, w}), pairs.push_back({w, e.to});
      tryAll(pairs);
    }
  }

  // Leaves out what is gone, and hulls that hold nothing.
  void compact() {
    std::erase_if(now_.simplices, [](const Simplex& s) { return !s.is_alive; });
    now_.of.assign(now_.balls.size(), {});
    for (std::uint32_t i = 0; i < now_.simplices.size(); ++i)
      for (const std::uint32_t v : now_.simplices[i].corners()) now_.of[v].push_back(i);
  }

  // Leaves out hulls whose samples others hold, those with the fewest first.
  void prune() {
    std::vector<std::uint32_t> order;
    for (std::uint32_t i = 0; i < now_.simplices.size(); ++i)
      if (now_.simplices[i].is_alive) order.push_back(i);
    std::ranges::stable_sort(order, {}, [&](std::uint32_t i) { return now_.simplices[i].samples.size(); });
    for (const std::uint32_t i : order) {
      Simplex& gone = now_.simplices[i];
      std::vector<std::pair<std::uint32_t, double>> best(gone.samples.size(), {0, kInfinity});
      tbb::parallel_for(std::size_t{0}, best.size(), [&](std::size_t k) {
        for (const std::uint32_t j : order)
          if (j != i && now_.simplices[j].is_alive)
            if (const double cost = now_.simplices[j].costOf(now_.samples[gone.samples[k]].point); cost < best[k].second)
              best[k] = {j, cost};
      });
      if (std::ranges::any_of(best, [&](const auto& b) { return b.second > most_; })) continue;
      gone.is_alive = false;
      for (std::size_t k = 0; k < best.size(); ++k) {
        now_.samples[gone.samples[k]].cost = best[k].second;
        now_.simplices[best[k].first].samples.push_back(gone.samples[k]);
      }
      gone.samples.clear();
    }
    compact();
  }

  // Along the line from the nearest neighbour to the one opposite to it, so that balls stay on a round border; towards
  // the neighbour that is farthest from that line; and across both.
  Eigen::Matrix3d axesOf(const Vector3d& c, std::span<const std::uint32_t> neighbours) const {
    std::vector<Vector3d> to;
    for (const std::uint32_t v : neighbours) to.push_back(now_.balls[v].centre - c);
    const Vector3d next = std::ranges::min_element(to, {}, [](const Vector3d& p) { return p.squaredNorm(); })->normalized();
    const Vector3d opposite = std::ranges::min_element(to, {}, [&](const Vector3d& p) { return p.normalized().dot(next); })->normalized();
    const Vector3d along = opposite.dot(next) < 0 && (next - opposite).norm() > kThinnest ? (next - opposite).normalized() : next;
    for (Vector3d& p : to) p -= p.dot(along) * along;
    Vector3d across = *std::ranges::max_element(to, {}, [](const Vector3d& p) { return p.squaredNorm(); });
    across = across.norm() > 0 ? across.normalized() : along.unitOrthogonal();
    Eigen::Matrix3d axes;
    axes << along, across, along.cross(across);
    return axes;
  }

  // Moves ball `v` to where the hulls around it cost less. Its new number.
  std::uint32_t moved(std::uint32_t v, double step, double limit) {
    const Ball ball = now_.balls[v];
    const std::vector<std::uint32_t> other = neighbours(v);
    if (other.empty()) return v;
    const Eigen::Matrix3d axes = axesOf(ball.centre, other);
    std::vector<Change> tried(7);
    tbb::parallel_for(std::size_t{0}, tried.size(), [&](std::size_t i) {
      const Vector3d c =
          i == 6 ? ball.centre : Vector3d(ball.centre + (i % 2 ? step : -step) * ball.radius * axes.col(static_cast<Eigen::Index>(i / 2)));
      const double radius = i == 6 ? ball.radius : -field_.signedDistance(c);
      if (radius > 0) tried[i] = changeOf({v}, static_cast<std::uint32_t>(now_.balls.size()), {c, radius}, limit);
    });
    const auto best = std::ranges::min_element(tried, {}, &Change::energy);
    if (!(best->energy < kGain * tried[6].energy)) return v;
    apply(*best);
    return best->to;
  }

  // Moves the balls nearest to ball `centre` until the hulls there are within the tolerance.
  void relax(std::uint32_t centre, double limit) {
    std::vector<std::uint32_t> ring{centre};
    for (std::size_t k = 0, rings = 0; rings < kNear / 2; ++rings)
      for (const std::size_t end = ring.size(); k < end; ++k)
        for (const std::uint32_t w : neighbours(ring[k])) insert(ring, w);
    const Vector3d middle = now_.balls[centre].centre;
    std::ranges::stable_sort(ring, {}, [&](std::uint32_t v) { return (now_.balls[v].centre - middle).squaredNorm(); });
    ring.resize(std::min(ring.size(), kNear));
    for (double step = kMove; step > kLastMend; step *= 0.5)
      for (int sweep = 0; sweep < kSweeps; ++sweep) {
        bool has_moved = false;
        for (std::uint32_t& v : ring) {
          const std::uint32_t w = moved(v, step, limit);
          has_moved |= w != v;
          v = w;
        }
        if (worstNear(ring) <= most_) return;
        if (!has_moved) break;
      }
  }

  double worstNear(std::span<const std::uint32_t> ring) const {
    double worst = 0;
    for (const std::uint32_t v : ring)
      for (const std::uint32_t i : around(v)) {
        const Simplex& s = now_.simplices[i];
        worst = std::max(worst, s.overhang);
        for (const std::uint32_t p : s.samples) worst = std::max(worst, now_.samples[p].cost);
      }
    return worst;
  }

  std::size_t misses() const {
    std::size_t count = 0;
    for (const Sample& s : now_.samples) count += s.cost > most_;
    for (const Simplex& s : now_.simplices) count += s.is_alive && s.overhang > most_;
    return count;
  }

  // Collapses that cost too much, with the balls around moved thereafter so that they no longer do.
  void tryCollapses() {
    const double limit = kTried * most_;
    std::set<std::pair<std::uint32_t, std::uint32_t>> failed;
    for (int failures = 0; failures < kFailures;) {
      compact();
      std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
      for (std::uint32_t v = 0; v < now_.balls.size(); ++v)
        for (const std::uint32_t w : neighbours(v))
          if (!failed.contains({v, w})) pairs.push_back({v, w});
      std::vector<Change> changes = collapsesOf(pairs, limit);
      std::ranges::stable_sort(changes, {}, &Change::cost);
      bool has_changed = false;
      for (std::size_t i = 0; i < changes.size() && !has_changed && failures < kFailures; ++i) {
        progress_.check();
        const Change& tried = changes[i];
        Complex before = now_;
        const std::size_t missed = misses();
        apply(changeOf(tried.from, tried.to, tried.ball, limit));
        relax(tried.to, limit);
        has_changed = misses() <= missed && (isCovered() || missed > 0);
        failures = has_changed ? 0 : failures + 1;
        if (has_changed) break;
        // Samples that were added stay.
        before.samples.insert(before.samples.end(), now_.samples.begin() + static_cast<std::ptrdiff_t>(before.samples.size()),
                              now_.samples.end());
        now_ = std::move(before);
        holdSamples();
        failed.insert({tried.from[0], tried.to});
      }
      if (!has_changed) break;
    }
  }

  // Greedily, the hulls that hold the most samples that none before holds, with all the growth that the tolerance
  // leaves them.
  std::vector<Hull> chosen() {
    compact();
    std::vector<Hull> all(now_.simplices.size()), out;
    std::vector<std::vector<std::uint32_t>> holds(all.size());
    tbb::parallel_for(std::size_t{0}, all.size(), [&](std::size_t i) {
      const Hull& hull = now_.simplices[i].hull;
      const HullOverhangSettings search{.absolute = kAccuracy * settings_.tolerance};
      const double left = settings_.tolerance - settings_.rounding - std::max(0.0, hullOverhang(field_, hull, search).bound);
      if (!(left > 0)) return;
      all[i] = grownBy(hull, left);
      const HullDistance distance(all[i]);
      const Eigen::AlignedBox3d box = boxOf(all[i]);
      for (std::uint32_t k = 0; k < now_.samples.size(); ++k)
        if (box.contains(now_.samples[k].point) && distance(now_.samples[k].point) <= -margin_) holds[i].push_back(k);
    });
    std::vector<char> held(now_.samples.size(), 0);
    for (;;) {
      std::size_t best = 0, most = 0;
      for (std::size_t i = 0; i < all.size(); ++i) {
        const auto gain = static_cast<std::size_t>(std::ranges::count_if(holds[i], [&](std::uint32_t k) { return !held[k]; }));
        if (gain > most) most = gain, best = i;
      }
      if (most == 0) break;
      out.push_back(all[best]);
      for (const std::uint32_t k : holds[best]) held[k] = 1;
    }
    return out;
  }

  // Pieces that the hulls do not hold, and a place of each that they do not.
  std::vector<std::pair<Piece, Vector3d>> bareOf(const HullCover& cover) const {
    std::vector<char> held(pieces_.size(), 0);
    std::vector<Vector3d> place(pieces_.size());
    tbb::parallel_for(std::size_t{0}, held.size(), [&](std::size_t i) { held[i] = cover.holds(pieces_[i].piece, kNone, &place[i]); });
    std::vector<std::pair<Piece, Vector3d>> bare;
    for (std::size_t i = 0; i < held.size(); ++i)
      if (!held[i]) bare.push_back({pieces_[i].piece, place[i]});
    return bare;
  }

  // Adds samples where the hulls leave pieces bare. Whether there are such places.
  bool hasBare() {
    std::vector<Hull> hulls;
    for (const Simplex& s : now_.simplices)
      if (s.is_alive && s.overhang < most_) hulls.push_back(grownBy(s.hull, settings_.tolerance - 2 * margin_ - s.overhang));
    const auto bare = bareOf(HullCover(hulls, margin_));
    for (const auto& [piece, place] : bare) now_.samples.push_back({place, normalOf(piece)});
    if (!bare.empty()) holdSamples();
    return !bare.empty();
  }

  // Moves balls where samples are not held. If that does not help, they are where they were.
  void mend() {
    std::vector<std::uint32_t> nearest;
    for (const Sample& s : now_.samples)
      if (s.cost > most_) insert(nearest, nearestTo(s.point));
    for (const std::uint32_t v : nearest) {
      if (around(v).empty()) continue;
      const Complex before = now_;
      const std::size_t missed = misses();
      relax(v, kTried * most_);
      if (misses() > missed) now_ = before;
    }
  }

  // Whether the hulls now hold all pieces, perhaps after balls have been moved.
  bool isCovered() {
    for (int round = 0; round < kMends; ++round) {
      if (!hasBare()) return true;
      if (misses() > 0) mend();
      if (misses() > 0) return false;
    }
    return false;
  }

  std::uint32_t nearestTo(const Vector3d& p) const {
    std::uint32_t nearest = 0;
    double least = kInfinity;
    for (std::uint32_t v = 0; v < now_.balls.size(); ++v)
      if (const double far = (p - now_.balls[v].centre).norm() - now_.balls[v].radius; far < least && !around(v).empty())
        least = far, nearest = v;
    return nearest;
  }

  // Balls below the pieces that no hull holds.
  void fill(std::vector<Hull>& hulls) {
    const HullCover cover(hulls, margin_);
    std::vector<Piece> open;
    for (const auto& [piece, place] : bareOf(cover)) open.push_back(piece);
    std::vector<HullDistance> added;
    const auto holds = [&](const HullDistance& d, const Piece& p) {
      return std::ranges::all_of(p.corner, [&](const Vector3d& q) { return d(q) <= -margin_; });
    };
    while (!open.empty() && hulls.size() < 4 * settings_.max_hulls) {
      progress_.check();
      const Piece piece = open.back();
      open.pop_back();
      if (std::ranges::any_of(added, [&](const HullDistance& d) { return holds(d, piece); }) || cover.holds(piece)) continue;
      Hull hull;
      hull.ball[0] = ballBelow(piece);
      for (double depth = 0.25 * settings_.tolerance; !(hull.ball[0].radius > 0) && depth > margin_; depth *= 0.5) {
        is_thin_ = true;
        hull.ball[0] = ballBelowPoint(field_, centroidOf(piece), normalOf(piece), depth);
      }
      const bool has_ball = hull.ball[0].radius > 0;
      hull = grownBy(hull, settings_.tolerance - settings_.rounding);
      if (has_ball && holds(HullDistance(hull), piece)) {
        hulls.push_back(hull);
        added.emplace_back(hull);
        continue;
      }
      const std::size_t k = longestSide(piece);
      if (side2(piece, k) < margin_ * margin_) continue;  // the solid has no thickness here: the proof of the cover says so
      for (const Piece& half : halvesOf(piece, k)) open.push_back(half);
    }
  }

  std::vector<Hull> withoutRedundant(std::vector<Hull> hulls) const {
    for (std::size_t i = hulls.size(); i-- > 0;) {
      const HullCover cover(hulls, 0.5 * margin_);
      const Eigen::AlignedBox3d box = boxOf(hulls[i]);
      std::vector<char> bare(mesh_.triangles.size(), 0);
      tbb::parallel_for(std::size_t{0}, bare.size(), [&](std::size_t t) {
        const Piece triangle = pieceOf(mesh_, t, Vector3d::Zero());
        Eigen::AlignedBox3d own;
        for (const Vector3d& p : triangle.corner) own.extend(p);
        if (box.intersects(own)) bare[t] = !cover.holds(triangle, i);
      });
      if (std::ranges::count(bare, 1) == 0) hulls.erase(hulls.begin() + static_cast<std::ptrdiff_t>(i));
    }
    return hulls;
  }

  struct CutPiece {
    Piece piece;
    double samples;  // that it should have
  };

  const TriangleMesh& mesh_;
  const DistanceField& field_;
  const FitSettings& settings_;
  Progress& progress_;
  double margin_;  // how deep a point has to lie in a hull to count as held [mm]
  bool is_thin_ = false;
  double most_;  // that a hull and a sample may cost [mm]
  std::vector<CutPiece> pieces_;
  Complex now_;
};

}  // namespace

std::vector<Hull> fitHulls(const TriangleMesh& mesh, const DistanceField& field, const FitSettings& settings, Progress& progress) {
  // Hulls for a smaller tolerance are within one that is larger than the solid is thick, and may be fewer.
  std::vector<Hull> fewest;
  for (FitSettings tried = settings; kAccuracy * tried.tolerance >= tried.rounding; tried.tolerance /= 2) {
    HullFit fit(mesh, field, tried, progress);
    std::optional<std::vector<Hull>> hulls = fit.run();
    if (!hulls) continue;
    if (!hulls->empty() && (fewest.empty() || hulls->size() < fewest.size())) fewest = std::move(*hulls);
    if (!fit.isThin()) break;
  }
  return fewest;
}

}  // namespace spheretree::builder
