// SPDX-License-Identifier: GPL-3.0-or-later
#include "spheretree/builder/certify_cover.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <string>

#include "spheretree/builder/box_tree.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr std::size_t kTrianglesAChunk = 256;
constexpr double kRelative = 0.1;          // share of a growth to which it is the least: without it, pieces grow as the square of a hole
constexpr std::size_t kMostForHoles = 12;  // balls near a piece; with more, it is split first: all pairs are tried

struct Piece {
  std::array<Vector3d, 3> corner;
};

// The balls in slot order of a box tree.
struct BallIndex {
  BoxTree tree;
  std::vector<Ball> balls;

  explicit BallIndex(std::span<const Ball> given) {
    std::vector<Eigen::AlignedBox3d> boxes;
    boxes.reserve(given.size());
    for (const Ball& b : given) {
      const Vector3d half = Vector3d::Constant(b.radius);
      boxes.emplace_back(b.centre - half, b.centre + half);
    }
    tree = BoxTree(boxes, 2);
    balls.reserve(given.size());
    for (const std::uint32_t i : tree.order()) balls.push_back(given[i]);
  }
  std::uint32_t original(std::uint32_t slot) const { return tree.order()[slot]; }
};

Vector3d centroidOf(const Piece& piece) { return (piece.corner[0] + piece.corner[1] + piece.corner[2]) / 3; }

double radiusAbout(const Piece& piece, const Vector3d& c) {
  double most = 0;
  for (const Vector3d& p : piece.corner) most = std::max(most, (p - c).squaredNorm());
  return std::sqrt(most);
}

// Splits one triangle until each piece lies in one ball, or the caller is content with it.
class Splitter {
 public:
  Splitter(const BallIndex& index, double margin) : index_(index), margin_(margin) {}

  // held() for a piece inside a ball; open(piece, its longest side, slots of the balls near) for one that is in no single ball:
  // true if that is the end of it, false to have it split.
  template <class Held, class Open>
  void run(const Piece& triangle, Held held, Open open) {
    frames_.clear();
    near_.clear();
    const Vector3d middle = centroidOf(triangle);
    const double extent = radiusAbout(triangle, middle);
    index_.tree.searchWithin(middle, extent * extent * (1 + 1e-12), [&](std::size_t first, std::size_t count) {
      for (std::size_t s = first; s < first + count; ++s) near_.push_back(static_cast<std::uint32_t>(s));
    });
    frames_.push_back({triangle, 0, near_.size()});
    while (!frames_.empty()) {
      const Frame frame = frames_.back();
      frames_.pop_back();
      near_.resize(frame.near_end);
      const Vector3d centroid = centroidOf(frame.piece);
      const double reach = radiusAbout(frame.piece, centroid);
      // Keep the balls that touch the piece, for its children; stop at one that holds it.
      bool is_held = false;
      const std::size_t begin = near_.size();
      for (std::size_t i = frame.near_begin; i < frame.near_end && !is_held; ++i) {
        const std::uint32_t slot = near_[i];
        const Ball& ball = index_.balls[slot];
        const double distance = (centroid - ball.centre).norm();
        if (distance > ball.radius + reach + margin_) continue;
        near_.push_back(slot);
        is_held = distance <= ball.radius && radiusAbout(frame.piece, ball.centre) + margin_ <= ball.radius;
      }
      if (is_held) {
        held();
        continue;
      }
      std::size_t k = 0;  // opposite the longest side
      for (std::size_t j = 1; j < 3; ++j)
        if (side2(frame.piece, j) > side2(frame.piece, k)) k = j;
      if (open(frame.piece, std::sqrt(side2(frame.piece, k)), std::span<const std::uint32_t>(near_).subspan(begin))) continue;
      // Halve the longest side: slivers become compact, and the two halves share their new corner exactly.
      const Vector3d halfway = 0.5 * (frame.piece.corner[(k + 1) % 3] + frame.piece.corner[(k + 2) % 3]);
      const std::size_t end = near_.size();
      Piece one = frame.piece, two = frame.piece;
      one.corner[(k + 2) % 3] = halfway;
      two.corner[(k + 1) % 3] = halfway;
      frames_.push_back({one, begin, end});
      frames_.push_back({two, begin, end});
    }
  }

 private:
  struct Frame {
    Piece piece;
    std::size_t near_begin, near_end;  // its candidates in near_, which is a stack too
  };
  static double side2(const Piece& p, std::size_t opposite) {
    return (p.corner[(opposite + 1) % 3] - p.corner[(opposite + 2) % 3]).squaredNorm();
  }

  const BallIndex& index_;
  double margin_;
  std::vector<Frame> frames_;
  std::vector<std::uint32_t> near_;
};

Piece pieceOf(const TriangleMesh& mesh, std::size_t t, const Vector3d& origin) {
  return {{mesh.corner(t, 0) - origin, mesh.corner(t, 1) - origin, mesh.corner(t, 2) - origin}};
}

// What rounding can move a split point or a distance by: the split is at most 100 deep, each midpoint is off by half an ulp.
double roundingMargin(const TriangleMesh& mesh, const Vector3d& origin) {
  double most = origin.cwiseAbs().maxCoeff();
  for (const Vector3d& p : mesh.positions) most = std::max(most, p.cwiseAbs().maxCoeff());
  return 1e-13 * most;
}

float roundUp(double x) {
  auto f = static_cast<float>(x);
  return static_cast<double>(f) < x ? std::nextafterf(f, std::numeric_limits<float>::infinity()) : f;
}

// The ball that must grow least to hold a piece, among those near it, or among all if none is near.
struct Growth {
  std::uint32_t slot;
  double need;
};
Growth leastGrowth(const BallIndex& index, const Piece& piece, std::span<const std::uint32_t> near) {
  Growth best{0, std::numeric_limits<double>::infinity()};
  double least = std::numeric_limits<double>::infinity();
  const auto consider = [&](std::uint32_t slot) {
    const double need = radiusAbout(piece, index.balls[slot].centre);
    const double growth = need - index.balls[slot].radius;
    if (growth < least || (growth == least && index.original(slot) < index.original(best.slot))) least = growth, best = {slot, need};
  };
  if (!near.empty()) {
    for (const std::uint32_t slot : near) consider(slot);
  } else {
    for (std::uint32_t slot = 0; slot < index.balls.size(); ++slot) consider(slot);
  }
  return best;
}

// Distance from a point to the nearest ball among those near it; 0 in a ball.
double gapAt(const BallIndex& index, const Vector3d& p, std::span<const std::uint32_t> near) {
  const Growth growth = leastGrowth(index, {{p, p, p}}, near);
  return std::max(0.0, growth.need - index.balls[growth.slot].radius);
}

// The deepest places of the holes that a few balls leave in one piece. In the plane of the piece the balls are discs. A hole has
// corners of the piece, crossings of its sides with a disc or crossings of two discs in its rim; the gap in it is largest at a
// corner, on a side, or at a point as far from three balls.
class HoleFinder {
 public:
  HoleFinder(const BallIndex& index, double tolerance) : index_(index), tolerance_(tolerance) {}

  template <class Report>
  void run(const Piece& piece, std::span<const std::uint32_t> near, Report report) {
    if (near.empty()) {
      Vector3d p = centroidOf(piece);
      double most = gapAt(index_, p, near);
      for (const Vector3d& corner : piece.corner)
        if (const double g = gapAt(index_, corner, near); g > most) p = corner, most = g;
      if (most > tolerance_) report(p, most);
      return;
    }
    near_ = near;
    const Vector3d normal = (piece.corner[1] - piece.corner[0]).cross(piece.corner[2] - piece.corner[0]);
    const double length = normal.norm();
    const Vector3d n = length > 0 ? Vector3d(normal / length) : Vector3d::Zero();
    for (std::size_t k = 0; k < 3; ++k) {
      climb(piece, n, piece.corner[k], report);
      alongSide(piece, n, piece.corner[k], piece.corner[(k + 1) % 3], report);
    }
    if (!(length > 0)) return;
    for (std::size_t i = 0; i < near.size(); ++i)
      for (std::size_t j = i + 1; j < near.size(); ++j) crossings(piece, n, near[i], near[j], report);
  }

 private:
  double gap(const Vector3d& p) const {
    double least = std::numeric_limits<double>::infinity();
    for (const std::uint32_t slot : near_) least = std::min(least, (p - index_.balls[slot].centre).norm() - index_.balls[slot].radius);
    return least;
  }
  // Reports the deepest point of the hole at `p`: as far from three balls, again and again with the three nearest there.
  template <class Report>
  void climb(const Piece& piece, const Vector3d& n, Vector3d p, Report report) const {
    double depth = gap(p);
    for (int round = 0; round < 3 && near_.size() >= 3; ++round) {
      const Vector3d q = equidistant(p, n, threeNearest(p));
      if (!q.allFinite() || !holds(piece, n, q)) break;
      const double g = gap(q);
      if (!(g > depth)) break;
      p = q, depth = g;
    }
    depth = nearestOfAll(p, depth);
    if (depth > tolerance_) report(p, depth);
  }
  // A ball that does not touch the piece may be nearer to a point of it than all that do.
  double nearestOfAll(const Vector3d& p, double depth) const {
    index_.tree.searchWithin(p, std::max(0.0, depth) * depth, [&](std::size_t first, std::size_t count) {
      for (std::size_t s = first; s < first + count; ++s)
        depth = std::min(depth, (p - index_.balls[s].centre).norm() - index_.balls[s].radius);
    });
    return depth;
  }
  std::array<std::uint32_t, 3> threeNearest(const Vector3d& p) const {
    std::array<std::uint32_t, 3> slots{};
    std::array<double, 3> gaps;
    gaps.fill(std::numeric_limits<double>::infinity());
    for (const std::uint32_t slot : near_) {
      const double g = (p - index_.balls[slot].centre).norm() - index_.balls[slot].radius;
      std::size_t i = 3;
      for (; i > 0 && gaps[i - 1] > g; --i)
        if (i < 3) gaps[i] = gaps[i - 1], slots[i] = slots[i - 1];
      if (i < 3) gaps[i] = g, slots[i] = slot;
    }
    return slots;
  }

  // The deepest point of each stretch of a side that no ball holds.
  template <class Report>
  void alongSide(const Piece& piece, const Vector3d& n, const Vector3d& a, const Vector3d& b, Report report) {
    const Vector3d d = b - a;
    const double aa = d.squaredNorm();
    if (!(aa > 0)) return;
    spans_.clear();
    for (const std::uint32_t slot : near_) {
      const Ball& ball = index_.balls[slot];
      const Vector3d m = a - ball.centre;
      const double half_b = m.dot(d), c = m.squaredNorm() - ball.radius * ball.radius, disc = half_b * half_b - aa * c;
      if (!(disc > 0)) continue;
      const double root = std::sqrt(disc);
      if (-half_b + root > 0 && -half_b - root < aa) spans_.push_back({(-half_b - root) / aa, (-half_b + root) / aa});
    }
    std::sort(spans_.begin(), spans_.end());
    spans_.push_back({1.0, 1.0});
    double reached = 0;
    for (const auto& [from, to] : spans_) {
      if (from > reached) {
        constexpr int kSteps = 8;
        double best = 0, best_t = reached;
        for (int k = 0; k <= kSteps; ++k) {
          const double t = reached + (std::min(from, 1.0) - reached) * k / kSteps, g = gap(a + t * d);
          if (g > best) best = g, best_t = t;
        }
        climb(piece, n, a + best_t * d, report);
      }
      reached = std::max(reached, to);
    }
  }

  // Where the discs of two balls cross inside the piece and outside every other ball, a hole begins: go to its deepest point.
  template <class Report>
  void crossings(const Piece& piece, const Vector3d& n, std::uint32_t i, std::uint32_t j, Report report) const {
    const Ball &a = index_.balls[i], &b = index_.balls[j];
    const double height_a = (a.centre - piece.corner[0]).dot(n), height_b = (b.centre - piece.corner[0]).dot(n);
    const double ra2 = a.radius * a.radius - height_a * height_a, rb2 = b.radius * b.radius - height_b * height_b;
    if (!(ra2 > 0) || !(rb2 > 0)) return;
    const Vector3d ca = a.centre - height_a * n, cb = b.centre - height_b * n;
    const double d2 = (cb - ca).squaredNorm();
    if (!(d2 > 0)) return;
    const double along = 0.5 * (1 + (ra2 - rb2) / d2);  // foot of the common chord, as a share of the way from ca to cb
    const double half2 = ra2 - along * along * d2;
    if (!(half2 > 0)) return;
    const Vector3d foot = ca + along * (cb - ca), chord = n.cross(cb - ca) * std::sqrt(half2 / d2);
    for (const double sign : {1.0, -1.0}) {
      const Vector3d p = foot + sign * chord;
      if (!holds(piece, n, p)) continue;
      bool open = true;
      for (const std::uint32_t slot : near_)
        open = open && (slot == i || slot == j ||
                        (p - index_.balls[slot].centre).squaredNorm() > index_.balls[slot].radius * index_.balls[slot].radius);
      // If the hole reaches beyond the piece, its deepest point may lie there: then at least a point just inside the hole is reported.
      if (open) climb(piece, n, p + (2 * sign * tolerance_) * chord.normalized(), report);
    }
  }

  static bool holds(const Piece& piece, const Vector3d& n, const Vector3d& p) {
    for (std::size_t k = 0; k < 3; ++k)
      if ((piece.corner[(k + 1) % 3] - piece.corner[k]).cross(p - piece.corner[k]).dot(n) < 0) return false;
    return true;
  }

  // Newton's method in the plane for the point with the same gap to three balls.
  Vector3d equidistant(Vector3d p, const Vector3d& n, const std::array<std::uint32_t, 3>& slots) const {
    const Vector3d u = n.unitOrthogonal(), v = n.cross(u);
    for (int step = 0; step < 6; ++step) {
      std::array<Vector3d, 3> slope;
      std::array<double, 3> g;
      for (std::size_t m = 0; m < 3; ++m) {
        const Vector3d to = p - index_.balls[slots[m]].centre;
        const double distance = to.norm();
        g[m] = distance - index_.balls[slots[m]].radius;
        slope[m] = distance > 0 ? Vector3d(to / distance) : Vector3d::Zero();
      }
      const Vector3d s1 = slope[0] - slope[1], s2 = slope[0] - slope[2];
      const double a = s1.dot(u), b = s1.dot(v), c = s2.dot(u), d = s2.dot(v), e = g[1] - g[0], f = g[2] - g[0];
      const double determinant = a * d - b * c;
      if (!(std::abs(determinant) > 1e-12)) break;
      p += ((e * d - b * f) / determinant) * u + ((a * f - e * c) / determinant) * v;
    }
    return p;
  }

  const BallIndex& index_;
  double tolerance_;
  std::span<const std::uint32_t> near_;
  std::vector<std::pair<double, double>> spans_;
};

}  // namespace

CertifiedCover certifyCover(const TriangleMesh& mesh, std::span<const Ball> balls, const Vector3d& origin, double resolution,
                            Progress& progress) {
  if (balls.empty()) throw std::invalid_argument("certify: no balls");
  constexpr double kLargest = std::numeric_limits<float>::max() / 4;
  std::vector<Ball> stored;  // what float32 holds
  stored.reserve(balls.size());
  for (std::size_t i = 0; i < balls.size(); ++i) {
    const Vector3d c = balls[i].centre - origin;
    if (!c.allFinite() || !std::isfinite(balls[i].radius) || c.cwiseAbs().maxCoeff() > kLargest || std::abs(balls[i].radius) > kLargest)
      throw std::invalid_argument("certify: ball " + std::to_string(i) + " does not fit into float32");
    const Eigen::Vector3f centre = c.cast<float>();
    const float radius = std::max(static_cast<float>(balls[i].radius), std::numeric_limits<float>::min());
    stored.push_back({centre.cast<double>(), static_cast<double>(radius)});
  }
  const BallIndex index(stored);
  const double margin = roundingMargin(mesh, origin);
  const std::size_t triangles = mesh.triangles.size();
  const std::size_t chunks = (triangles + kTrianglesAChunk - 1) / kTrianglesAChunk;
  // First the depth of the deepest hole, so that no ball grows more than that asks for.
  std::vector<std::uint32_t> all(triangles);
  std::iota(all.begin(), all.end(), 0u);
  std::vector<Ball> in_mesh_frame = stored;
  for (Ball& b : in_mesh_frame) b.centre += origin;
  double largest_gap = 0;
  for (const CoverGap& gap : findCoverGaps(mesh, all, in_mesh_frame, 0.5 * resolution, progress))
    largest_gap = std::max(largest_gap, gap.gap);

  // Then the proof: every piece in one ball, grown by no more than the largest gap asks for. A piece that growth would close is
  // split a little further first: most such pieces lie in two balls that both need none.
  const double allowed = largest_gap + resolution, fine = 50 * resolution;
  struct Part {
    std::vector<Growth> growth;
    std::size_t pieces = 0;
  };
  std::vector<Part> parts(chunks);
  tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t chunk) {
    progress.check();
    Splitter splitter(index, margin);
    Part& part = parts[chunk];
    for (std::size_t t = chunk * kTrianglesAChunk; t < std::min(triangles, (chunk + 1) * kTrianglesAChunk); ++t)
      splitter.run(
          pieceOf(mesh, t, origin), [&] { ++part.pieces; },
          [&](const Piece& piece, double side, std::span<const std::uint32_t> near) {
            if (side > fine) return false;
            Growth growth = leastGrowth(index, piece, near);
            growth.need += margin;
            const double more = growth.need - index.balls[growth.slot].radius;
            if (side > std::max(resolution, kRelative * more) && more > allowed) return false;
            part.growth.push_back(growth);
            ++part.pieces;
            return true;
          });
  });

  CertifiedCover out;
  std::vector<double> radius(stored.size());
  for (std::size_t i = 0; i < stored.size(); ++i) radius[i] = stored[i].radius;
  for (const Part& part : parts) {
    out.pieces += part.pieces;
    for (const Growth& g : part.growth) {
      const std::uint32_t i = index.original(g.slot);
      radius[i] = std::max(radius[i], g.need);
    }
  }
  out.spheres.reserve(stored.size());
  for (std::size_t i = 0; i < stored.size(); ++i) {
    out.largest_growth = std::max(out.largest_growth, radius[i] - stored[i].radius);
    const Eigen::Vector3f c = stored[i].centre.cast<float>();
    out.spheres.push_back({c.x(), c.y(), c.z(), roundUp(radius[i])});
  }
  return out;
}

std::vector<CoverGap> findCoverGaps(const TriangleMesh& mesh, std::span<const std::uint32_t> triangles, std::span<const Ball> balls,
                                    double tolerance, Progress& progress) {
  const BallIndex index(balls);
  const std::size_t chunks = (triangles.size() + kTrianglesAChunk - 1) / kTrianglesAChunk;
  std::vector<std::vector<CoverGap>> parts(chunks);
  tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t chunk) {
    progress.check();
    Splitter splitter(index, 0);
    HoleFinder finder(index, tolerance);
    for (std::size_t i = chunk * kTrianglesAChunk; i < std::min(triangles.size(), (chunk + 1) * kTrianglesAChunk); ++i)
      splitter.run(
          pieceOf(mesh, triangles[i], Vector3d::Zero()), [] {},
          [&](const Piece& piece, double side, std::span<const std::uint32_t> near) {
            if (near.size() > kMostForHoles && side > tolerance) return false;
            finder.run(piece, near, [&](const Vector3d& p, double gap) { parts[chunk].push_back({p, gap, triangles[i]}); });
            return true;
          });
  });
  std::vector<CoverGap> gaps;
  for (const auto& part : parts) gaps.insert(gaps.end(), part.begin(), part.end());
  return gaps;
}

}  // namespace spheretree::builder
