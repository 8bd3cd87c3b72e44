// SPDX-License-Identifier: GPL-3.0-or-later
#include "certify/certify_cover.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "certify/power_cells.h"
#include "certify/triangle_piece.h"
#include "spheretree/core/rounding.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr double kRelative = 0.1;      // relative accuracy of a growth: without it, the number of pieces would grow as the square of a gap
constexpr double kSame = 1e-3;         // as a share of the gap: corners of a gap this near to each other are one corner, of two cells
constexpr double kFine = 50;           // pieces of sides up to this multiple of the resolution are not split further to avoid a growth
constexpr std::size_t kFewBalls = 32;  // pieces that more balls touch are not cut into power cells, since rounding displaces each cut

Vector3d farthestCorner(const Piece& piece, const Vector3d& c) {
  return *std::max_element(piece.corner.begin(), piece.corner.end(),
                           [&](const Vector3d& a, const Vector3d& b) { return (a - c).squaredNorm() < (b - c).squaredNorm(); });
}

// A corner of a power cell that is outside the ball of the cell.
struct Hole {
  Vector3d at;
  std::uint32_t slot;
};

// Splits one triangle until balls cover each piece or the caller accepts it. As soon as few balls touch a piece, it is
// cut into their power cells, which shows whether they cover it together, and how far they would have to grow. A piece
// with a gap that the caller does not close is only halved from there on, since most of its parts have a gap as well.
class Splitter {
 public:
  explicit Splitter(const BallIndex& index) : index_(index), cells_(index) {}

  // Calls held(number of parts, each in one ball) for a piece that balls cover. For one that was cut into cells and has
  // a gap, calls close(holes): the result is true if the balls of the cells will grow to contain the holes, and with
  // them the piece. For any other, calls open(piece, its longest side, slots of the balls nearby): the result is true
  // if the piece is finished, false if it has to be split.
  template <class Held, class Close, class Open>
  void run(const Piece& triangle, Held held, Close close, Open open) {
    if (isCoveredAsBefore(triangle)) {  // consecutive triangles are often neighbours
      held(held_by_.size());
      return;
    }
    frames_.clear();
    near_.clear();
    const Vector3d middle = centroidOf(triangle);
    const double extent = radiusAbout(triangle, middle);
    index_.tree.searchWithin(middle, extent * extent * (1 + 1e-12), [&](std::size_t first, std::size_t count) {
      for (std::size_t s = first; s < first + count; ++s) near_.push_back(static_cast<std::uint32_t>(s));
    });
    frames_.push_back({triangle, 0, near_.size(), false});
    while (!frames_.empty()) {
      const Frame frame = frames_.back();
      frames_.pop_back();
      near_.resize(frame.near_end);
      const Vector3d centroid = centroidOf(frame.piece);
      const double reach = radiusAbout(frame.piece, centroid);
      // Keeps the balls that touch the piece, for its children; stops at a ball that contains it.
      bool is_held = false;
      const std::size_t begin = near_.size();
      for (std::size_t i = frame.near_begin; i < frame.near_end && !is_held; ++i) {
        const std::uint32_t slot = near_[i];
        const Ball& ball = index_.balls[slot];
        const double d2 = (centroid - ball.centre).squaredNorm();
        if (!(ball.radius + reach >= 0) || d2 > (ball.radius + reach) * (ball.radius + reach)) continue;
        near_.push_back(slot);
        is_held = d2 <= ball.radius * ball.radius && cells_.suffice(frame.piece.corner, std::span(&slot, 1));
        if (is_held) held_by_.assign(1, slot);
      }
      if (is_held) {
        held(1);
        continue;
      }
      const std::span<const std::uint32_t> near = std::span<const std::uint32_t>(near_).subspan(begin);
      const bool is_cut = !frame.is_cut && near.size() <= kFewBalls;
      if (is_cut && near.size() > 1) {
        holes_.clear();
        if (cells_.suffice(frame.piece.corner, near, [&](const Vector3d& p, std::uint32_t slot) { holes_.push_back({p, slot}); })) {
          held_by_.assign(cells_.heldBy().begin(), cells_.heldBy().end());
          held(held_by_.size());
          continue;
        }
        if (!holes_.empty() && close(holes_)) continue;
      }
      const std::size_t k = longestSide(frame.piece);
      if (open(frame.piece, std::sqrt(side2(frame.piece, k)), near)) continue;
      const std::size_t end = near_.size();
      for (const Piece& half : halvesOf(frame.piece, k)) frames_.push_back({half, begin, end, frame.is_cut || is_cut});
    }
  }

 private:
  struct Frame {
    Piece piece;
    std::size_t near_begin, near_end;  // range of its candidates in the stack near_
    bool is_cut;                       // whether it is part of a piece that was cut into power cells and has a gap
  };
  bool isCoveredAsBefore(const Piece& piece) { return cells_.suffice(piece.corner, held_by_); }

  const BallIndex& index_;
  PowerCells cells_;
  std::vector<std::uint32_t> held_by_;  // the balls that cover the last piece
  std::vector<Frame> frames_;
  std::vector<std::uint32_t> near_;
  std::vector<Hole> holes_;
};

// The ball that needs the smallest growth to contain a piece, among those near it, or among all if none is near. Ties
// go to the lower number.
struct Growth {
  std::uint32_t slot;
  double need;  // its radius after the growth
  double more;  // increase of its radius: no point of the piece has a larger gap
};
Growth minGrowth(const BallIndex& index, const Piece& piece, std::span<const std::uint32_t> near) {
  Growth best{0, 0, std::numeric_limits<double>::infinity()};
  const auto consider = [&](std::uint32_t slot) {
    const Ball& ball = index.balls[slot];
    const double target = ball.radius + best.more;
    if ((piece.corner[0] - ball.centre).squaredNorm() > target * target) return;
    const double need = radiusAbout(piece, ball.centre), more = need - ball.radius;
    if (more < best.more || (more == best.more && index.original(slot) < index.original(best.slot))) best = {slot, need, more};
  };
  if (!near.empty()) {
    for (const std::uint32_t slot : near) consider(slot);
  } else {
    for (std::uint32_t slot = 0; slot < index.balls.size(); ++slot) consider(slot);
  }
  return best;
}

// Distance from a point to the nearest ball, 0 in a ball; at most `limit`.
double gapAt(const BallIndex& index, const Vector3d& p, double limit) {
  double gap = limit;
  index.tree.searchWithin(p, limit * limit, [&](std::size_t first, std::size_t count) {
    for (std::size_t s = first; s < first + count; ++s) gap = std::min(gap, (p - index.balls[s].centre).norm() - index.balls[s].radius);
  });
  return std::max(0.0, gap);
}

// The balls as float32 stores them, relative to `origin`.
std::vector<Ball> storedBalls(std::span<const Ball> balls, const Vector3d& origin) {
  constexpr double kLargest = std::numeric_limits<float>::max() / 4;
  std::vector<Ball> stored;
  stored.reserve(balls.size());
  for (std::size_t i = 0; i < balls.size(); ++i) {
    const Vector3d c = balls[i].centre - origin;
    if (!c.allFinite() || !std::isfinite(balls[i].radius) || c.cwiseAbs().maxCoeff() > kLargest || std::abs(balls[i].radius) > kLargest)
      throw std::invalid_argument("certify: ball " + std::to_string(i) + " does not fit into float32");
    const Eigen::Vector3f centre = roundToFloat(c);
    const float radius = std::max(roundToFloat(balls[i].radius), std::numeric_limits<float>::min());
    stored.push_back({centre.cast<double>(), static_cast<double>(radius)});
  }
  return stored;
}

// The growths that cover the pieces of some triangles, at last one for each ball that grows.
struct ChunkCover {
  std::vector<Growth> growth;
  std::size_t pieces = 0;
};

// Branch and bound for the deepest gap gives the proof as well: a piece is finished when none of its points can have a
// gap larger than the deepest one found so far, and the growth that this bound requires contains it. A piece that would
// need growth is first split a little further: most such pieces lie in two balls, neither of which has to grow.
ChunkCover coverChunk(const TriangleMesh& mesh, std::size_t first, std::size_t last, const BallIndex& index, const Vector3d& origin,
                      double margin, double resolution) {
  const double fine = kFine * resolution;
  Splitter splitter(index);
  ChunkCover out;
  double deepest = 0;  // deepest gap found in this chunk
  const auto isSmall = [&](double growth) { return growth <= (1 + kRelative) * deepest + resolution; };
  for (std::size_t t = first; t < last; ++t)
    splitter.run(
        pieceOf(mesh, t, origin), [&](std::size_t parts) { out.pieces += parts; },
        [&](const std::vector<Hole>& holes) {
          const std::size_t before = out.growth.size();
          for (const auto& [at, slot] : holes) {
            const double need = (at - index.balls[slot].centre).norm(), more = need - index.balls[slot].radius;
            const double gap = gapAt(index, at, more);
            deepest = std::max(deepest, gap);
            out.growth.push_back({slot, need + margin, more});
            if (more <= gap + resolution) continue;
            out.growth.resize(before);
            return false;
          }
          return ++out.pieces, true;
        },
        [&](const Piece& piece, double side, std::span<const std::uint32_t> near) {
          const bool coarse = side > fine;
          if (coarse && near.size() != 1) return false;
          Growth growth = minGrowth(index, piece, near);
          // If only one ball is near, and no other is nearer to the farthest corner, that ball has to grow this far,
          // whether the piece is split or not.
          if (coarse && gapAt(index, farthestCorner(piece, index.balls[growth.slot].centre), growth.more) < growth.more) return false;
          if (!coarse && !isSmall(growth.more)) {
            deepest = std::max(deepest, gapAt(index, centroidOf(piece), growth.more));
            if (!isSmall(growth.more)) return false;
          }
          growth.need += margin;
          out.growth.push_back(growth);
          ++out.pieces;
          return true;
        });
  std::sort(out.growth.begin(), out.growth.end(),
            [](const Growth& a, const Growth& b) { return a.slot < b.slot || (a.slot == b.slot && a.need > b.need); });
  const auto last_kept =
      std::unique(out.growth.begin(), out.growth.end(), [](const Growth& a, const Growth& b) { return a.slot == b.slot; });
  out.growth.erase(last_kept, out.growth.end());
  out.growth.shrink_to_fit();
  return out;
}

// For each ball, the triangles that may reach into it.
std::vector<std::vector<std::uint32_t>> trianglesAt(const TriangleMesh& mesh, std::span<const Ball> balls, const Vector3d& origin,
                                                    Progress& progress) {
  std::vector<std::vector<std::uint32_t>> at(balls.size());
  if (balls.empty()) return at;
  const BallIndex index(balls);
  const std::size_t triangles = mesh.triangles.size();
  std::vector<std::vector<std::array<std::uint32_t, 2>>> chunks((triangles + kTrianglesAChunk - 1) / kTrianglesAChunk);
  tbb::parallel_for(std::size_t{0}, chunks.size(), [&](std::size_t chunk) {
    progress.check();
    for (std::size_t t = chunk * kTrianglesAChunk; t < std::min(triangles, (chunk + 1) * kTrianglesAChunk); ++t) {
      const Piece piece = pieceOf(mesh, t, origin);
      const Vector3d middle = centroidOf(piece);
      const double extent = radiusAbout(piece, middle);
      index.tree.searchWithin(middle, extent * extent * (1 + 1e-12), [&](std::size_t first, std::size_t count) {
        for (std::size_t s = first; s < first + count; ++s)
          if ((middle - index.balls[s].centre).norm() <= (index.balls[s].radius + extent) * (1 + 1e-12))
            chunks[chunk].push_back({index.original(static_cast<std::uint32_t>(s)), static_cast<std::uint32_t>(t)});
      });
    }
  });
  for (const auto& chunk : chunks)
    for (const auto& [ball, triangle] : chunk) at[ball].push_back(triangle);
  return at;
}

}  // namespace

CertifiedCover certifyCover(const TriangleMesh& mesh, std::span<const Ball> balls, const Vector3d& origin, double resolution,
                            Progress& progress) {
  if (balls.empty()) throw std::invalid_argument("certify: no balls");
  const std::vector<Ball> stored = storedBalls(balls, origin);
  const double margin = roundingMargin(mesh, origin);
  std::vector<Ball> smaller = stored;  // by what distances and corners may be off
  for (Ball& ball : smaller) ball.radius = ball.radius * (1 - 4e-16) - margin;
  const BallIndex index(smaller);
  const std::size_t triangles = mesh.triangles.size();
  std::vector<ChunkCover> chunks((triangles + kTrianglesAChunk - 1) / kTrianglesAChunk);
  tbb::parallel_for(std::size_t{0}, chunks.size(), [&](std::size_t chunk) {
    progress.check();
    const std::size_t first = chunk * kTrianglesAChunk;
    chunks[chunk] = coverChunk(mesh, first, std::min(triangles, first + kTrianglesAChunk), index, origin, margin, resolution);
  });

  CertifiedCover out;
  std::vector<double> radius(stored.size());
  for (std::size_t i = 0; i < stored.size(); ++i) radius[i] = stored[i].radius;
  for (const ChunkCover& chunk : chunks) {
    out.pieces += chunk.pieces;
    for (const Growth& g : chunk.growth) {
      const std::uint32_t i = index.original(g.slot);
      radius[i] = std::max(radius[i], g.need);
    }
  }
  out.spheres.reserve(stored.size());
  for (std::size_t i = 0; i < stored.size(); ++i) {
    out.largest_growth = std::max(out.largest_growth, radius[i] - stored[i].radius);
    const Eigen::Vector3f c = roundToFloat(stored[i].centre);
    out.spheres.push_back({c.x(), c.y(), c.z(), roundUp(radius[i])});
  }
  return out;
}

std::vector<char> provenRedundant(const TriangleMesh& mesh, std::span<const Sphere> spheres, const Vector3d& origin,
                                  std::span<const std::uint32_t> candidates, Progress& progress) {
  std::vector<Ball> stored;
  stored.reserve(spheres.size());
  for (const Sphere& s : spheres) stored.push_back({Vector3d(s.x, s.y, s.z), s.radius});
  const double margin = roundingMargin(mesh, origin);
  const BallIndex index(stored, -margin);
  std::vector<std::uint32_t> slot(stored.size());
  for (std::uint32_t s = 0; s < slot.size(); ++s) slot[index.original(s)] = s;
  std::vector<Ball> balls;
  for (const std::uint32_t candidate : candidates) balls.push_back(stored[candidate]);
  const std::vector<std::vector<std::uint32_t>> near = trianglesAt(mesh, balls, origin, progress);

  std::vector<char> absent(stored.size(), 0), redundant(stored.size(), 0);
  PowerCells cells(index, &absent);
  std::vector<Piece> open;
  // Tests a triangle that was covered with the ball, without it: pieces outside the ball are still covered. Pieces of
  // the size of the ball intersect few other balls.
  const auto staysCovered = [&](const Piece& triangle, const Ball& ball) {
    open.assign(1, triangle);
    while (!open.empty()) {
      const Piece piece = open.back();
      open.pop_back();
      const Vector3d centroid = centroidOf(piece);
      const double extent = radiusAbout(piece, centroid);
      if ((centroid - ball.centre).norm() > (ball.radius + extent) * (1 + 1e-12)) continue;
      if (extent > std::max(ball.radius, margin)) {
        for (const Piece& half : halvesOf(piece, longestSide(piece))) open.push_back(half);
      } else if (!cells.holes(piece.corner, [](const Vector3d&, std::uint32_t) {})) {
        return false;
      }
    }
    return true;
  };
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    progress.check();
    const std::uint32_t candidate = candidates[i];
    absent[slot[candidate]] = 1;
    const bool covered =
        std::ranges::all_of(near[i], [&](std::uint32_t t) { return staysCovered(pieceOf(mesh, t, origin), stored[candidate]); });
    absent[slot[candidate]] = redundant[candidate] = covered;
  }
  return redundant;
}

std::vector<CoverGap> findCoverGaps(const TriangleMesh& mesh, std::span<const std::uint32_t> triangles, std::span<const Ball> balls,
                                    double tolerance, Progress& progress, std::span<HeldBy> held_by) {
  const BallIndex index(balls, tolerance);
  std::vector<std::uint32_t> slot_of(held_by.empty() ? 0 : balls.size());
  for (std::uint32_t slot = 0; slot < slot_of.size(); ++slot) slot_of[index.original(slot)] = slot;
  const std::size_t chunks = (triangles.size() + kTrianglesAChunk - 1) / kTrianglesAChunk;
  std::vector<std::vector<CoverGap>> parts(chunks);
  tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t chunk) {
    progress.check();
    PowerCells cells(index);
    std::vector<std::uint32_t> slots, held_before;
    std::vector<CoverGap>& found = parts[chunk];
    for (std::size_t i = chunk * kTrianglesAChunk; i < std::min(triangles.size(), (chunk + 1) * kTrianglesAChunk); ++i) {
      const std::size_t first = found.size();
      const Piece triangle = pieceOf(mesh, triangles[i], Vector3d::Zero());
      if (!held_by.empty()) {
        slots.clear();
        for (const std::uint32_t ball : held_by[triangles[i]])
          if (ball < slot_of.size()) slots.push_back(slot_of[ball]);
        if (cells.suffice(triangle.corner, slots)) {
          held_before = slots;
          continue;
        }
      }
      // Consecutive triangles are often neighbours: the balls of the last one mostly suffice, too.
      const bool is_held =
          cells.suffice(triangle.corner, held_before) || cells.holes(triangle.corner, [&](const Vector3d& p, std::uint32_t slot) {
            for (std::size_t k = first; k < found.size(); ++k)
              if ((p - found[k].point).norm() <= kSame * found[k].gap) return;
            const double limit = slot == PowerCells::kNone ? std::numeric_limits<double>::infinity()
                                                           : (p - index.balls[slot].centre).norm() - index.balls[slot].radius;
            found.push_back({p, tolerance + gapAt(index, p, limit), triangles[i]});
          });
      if (is_held) held_before.assign(cells.heldBy().begin(), cells.heldBy().end());
      if (held_by.empty()) continue;
      HeldBy& now = held_by[triangles[i]];
      now.fill(kNoBall);
      if (is_held && cells.heldBy().size() <= now.size())
        std::ranges::transform(cells.heldBy(), now.begin(), [&](std::uint32_t slot) { return index.original(slot); });
    }
  });
  std::vector<CoverGap> gaps;
  for (const auto& part : parts) gaps.insert(gaps.end(), part.begin(), part.end());
  return gaps;
}

TriangleMesh subdivided(const TriangleMesh& mesh, double longest) {
  TriangleMesh out;
  const auto add = [&](const Vector3d& a, const Vector3d& b, const Vector3d& c) {
    const auto first = static_cast<std::uint32_t>(out.positions.size());
    out.positions.insert(out.positions.end(), {a, b, c});
    out.triangles.push_back({first, first + 1, first + 2});
  };
  std::vector<Piece> open;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    open.assign(1, pieceOf(mesh, t, Vector3d::Zero()));
    while (!open.empty()) {
      const Piece piece = open.back();
      open.pop_back();
      const std::size_t k = longestSide(piece);
      if (!(side2(piece, k) > longest * longest)) {
        add(piece.corner[0], piece.corner[1], piece.corner[2]);
        continue;
      }
      const std::size_t tip = shortestSide(piece);
      const double base = std::sqrt(side2(piece, tip));
      if (base > 0.5 * longest) {
        const std::array<Piece, 2> halves = halvesOf(piece, k);
        open.insert(open.end(), {halves[1], halves[0]});
        continue;
      }
      // A slender triangle, as in a rod, is cut into slices at once: repeated halving would leave three layers across
      // it, then nine, and so on.
      const Vector3d &a = piece.corner[tip], &b = piece.corner[(tip + 1) % 3], &c = piece.corner[(tip + 2) % 3];
      const double slices = std::ceil(std::sqrt(side2(piece, k)) / (longest - base));
      const auto onto = [&](const Vector3d& corner, double i) { return Vector3d(a + (corner - a) * (i / slices)); };
      add(a, onto(b, 1), onto(c, 1));
      for (double i = 1; i < slices; ++i) {
        const Vector3d next = i + 1 < slices ? onto(b, i + 1) : b;
        add(onto(b, i), next, onto(c, i));
        add(next, i + 1 < slices ? onto(c, i + 1) : c, onto(c, i));
      }
    }
  }
  return out;
}

}  // namespace spheretree::builder
