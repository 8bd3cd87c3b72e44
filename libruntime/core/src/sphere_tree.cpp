// SPDX-License-Identifier: Apache-2.0
#include "spheretree/core/sphere_tree.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <limits>
#include <span>

namespace spheretree {

std::string toHex(const Hash128& hash) {
  constexpr char kDigits[] = "0123456789abcdef";
  std::string text;
  for (const std::uint8_t byte : hash) text += {kDigits[byte >> 4], kDigits[byte & 15]};
  return text;
}

namespace {

struct Ball {
  Eigen::Vector3d centre;
  double radius;
};

Ball ballOf(const Sphere& s) { return {{s.x, s.y, s.z}, s.radius}; }

/// Radius about `centre` that holds all of `ball`. The writer and the reader evaluate this same expression, and each of its
/// operations is rounded correctly everywhere, so that what one proved the other finds.
double reach(const Eigen::Vector3d& centre, const Ball& ball) {
  const double dx = ball.centre.x() - centre.x(), dy = ball.centre.y() - centre.y(), dz = ball.centre.z() - centre.z();
  return std::sqrt(dx * dx + dy * dy + dz * dz) + ball.radius;
}

/// Calls `visit(first, last)` for the descendants of `node`, itself included, one range of nodes a level: breadth first, the
/// descendants on one level are consecutive.
template <class Visit>
void forEachRange(const SphereTree& tree, std::uint32_t node, Visit&& visit) {
  std::uint32_t first = node, last = node + 1;
  while (first < last) {
    visit(first, last);
    std::uint32_t next_first = 0, next_last = 0;
    for (std::uint32_t i = first; i < last; ++i) {
      if (tree.child_count[i] == 0) continue;
      if (next_last == 0) next_first = tree.first_child[i];
      next_last = tree.first_child[i] + tree.child_count[i];
    }
    first = next_first, last = next_last;
  }
}

constexpr double kFlat = 1e-15;  // square of the area or volume of edges, over the product of their squares, that counts as none

/// Centres of the balls that touch all of `support` (1 to 4 balls) from outside, with the least radius first: up to two.
/// With q_i = c_i - c_0 and d_i = r_i - r_0, a centre c_0 + x at s = R - r_0 satisfies |x| = s and 2 q_i . x = |q_i|^2 - d_i^2 + 2 d_i s:
/// x is linear in s, and s solves a quadratic.
int tangentCentres(std::span<const Ball* const> support, std::array<Eigen::Vector3d, 2>& centres) {
  const Ball& origin = *support[0];
  if (support.size() == 1) {
    centres[0] = origin.centre;
    return 1;
  }
  const std::size_t count = support.size() - 1;
  std::array<Eigen::Vector3d, 3> q;
  std::array<double, 3> constant, slope;  // of the right side in s
  for (std::size_t i = 0; i < count; ++i) {
    const Ball& ball = *support[i + 1];
    q[i] = ball.centre - origin.centre;
    slope[i] = ball.radius - origin.radius;
    constant[i] = 0.5 * (q[i].squaredNorm() - slope[i] * slope[i]);
  }
  // With the dual basis in the span of q, in which p_i . q_i = 1 and p_i . q_k = 0, x is the sum of p_i times the right sides.
  std::array<Eigen::Vector3d, 3> dual;
  double square = q[0].squaredNorm(), least = 0;
  if (count == 1) {
    dual[0] = q[0];
  } else if (count == 2) {
    const Eigen::Vector3d normal = q[0].cross(q[1]);
    dual = {q[1].cross(normal), normal.cross(q[0])};
    least = kFlat * square * q[1].squaredNorm();
    square = normal.squaredNorm();
  } else {
    dual = {q[1].cross(q[2]), q[2].cross(q[0]), q[0].cross(q[1])};
    const double volume = dual[0].dot(q[0]);
    least = kFlat * square * q[1].squaredNorm() * q[2].squaredNorm();
    square = volume * volume;
    for (Eigen::Vector3d& p : dual) p *= volume;
  }
  if (!(square > least)) return 0;
  Eigen::Vector3d a = Eigen::Vector3d::Zero(), b = a;  // x = a + b s
  for (std::size_t i = 0; i < count; ++i) {
    a += dual[i] * (constant[i] / square);
    b += dual[i] * (slope[i] / square);
  }
  const double qa = b.squaredNorm() - 1, qb = a.dot(b), qc = a.squaredNorm();  // qa s^2 + 2 qb s + qc = 0
  std::array<double, 2> roots{};
  int root_count = 0;
  if (std::abs(qa) < 1e-14) {
    if (qb != 0) roots[static_cast<std::size_t>(root_count++)] = -qc / (2 * qb);
  } else if (const double discriminant = qb * qb - qa * qc; discriminant >= 0) {
    const double sum = -(qb + std::copysign(std::sqrt(discriminant), qb));
    roots[static_cast<std::size_t>(root_count++)] = sum / qa;
    if (sum != 0) roots[static_cast<std::size_t>(root_count++)] = qc / sum;
  }
  int found = 0;
  for (int i = 0; i < root_count; ++i) {
    const Eigen::Vector3d centre = origin.centre + a + b * roots[static_cast<std::size_t>(i)];
    if (centre.allFinite()) centres[static_cast<std::size_t>(found++)] = centre;
  }
  return found;
}

double reachAll(const Eigen::Vector3d& centre, std::span<const Ball* const> balls) {
  double radius = 0;
  for (const Ball* ball : balls) radius = std::max(radius, reach(centre, *ball));
  return radius;
}

/// Centre of the smallest ball that encloses `balls`. A basis of at most four balls determines the ball; as long as some ball sticks
/// out, the farthest one enters, and the best basis among the five is found by trying all. Rounding can only make the result a
/// little large, since the caller measures the radius about the centre found.
Eigen::Vector3d enclosingCentre(std::span<const Ball> balls) {
  std::vector<const Ball*> basis{&balls[0]};
  for (const Ball& ball : balls)
    if (ball.radius > basis[0]->radius) basis[0] = &ball;
  Eigen::Vector3d centre = basis[0]->centre, best_centre = centre;
  double basis_radius = basis[0]->radius, best_radius = std::numeric_limits<double>::infinity();
  constexpr int kMostExchanges = 1000;  // about 10 are usual; the radius grows with each, so that only rounding can cycle
  for (int exchange = 0; exchange < kMostExchanges; ++exchange) {
    const Ball* farthest = nullptr;
    double radius = 0;
    for (const Ball& ball : balls)
      if (const double r = reach(centre, ball); r > radius) radius = r, farthest = &ball;
    if (radius < best_radius) best_radius = radius, best_centre = centre;
    if (farthest == nullptr || radius <= basis_radius * (1 + 1e-12) || std::find(basis.begin(), basis.end(), farthest) != basis.end())
      break;

    basis.insert(basis.begin(), farthest);  // must be part of the new basis
    std::vector<const Ball*> next;
    double next_radius = std::numeric_limits<double>::infinity();
    for (unsigned subset = 1; subset < (1u << basis.size()); subset += 2) {
      if (std::popcount(subset) > 4) continue;
      std::vector<const Ball*> support;
      for (std::size_t i = 0; i < basis.size(); ++i)
        if (subset >> i & 1) support.push_back(basis[i]);
      std::array<Eigen::Vector3d, 2> centres;
      const int count = tangentCentres(support, centres);
      for (int i = 0; i < count; ++i) {
        const double r = reachAll(centres[static_cast<std::size_t>(i)], basis);
        if (r < next_radius) next_radius = r, centre = centres[static_cast<std::size_t>(i)], next = support;
      }
    }
    if (!(next_radius > basis_radius)) break;
    basis_radius = next_radius;
    basis = std::move(next);
  }
  return best_centre;
}

struct Enclosure {
  Eigen::Vector3f centre;  // as it is stored
  double radius;           // about it
};

Enclosure enclose(std::span<const Ball> balls) {
  Enclosure out{enclosingCentre(balls).cast<float>(), 0};
  const Eigen::Vector3d centre = out.centre.cast<double>();
  for (const Ball& ball : balls) out.radius = std::max(out.radius, reach(centre, ball));
  return out;
}

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.9g", value);
  return text;
}

unsigned innerChildren(const SphereTree& tree, std::uint32_t node) {
  unsigned inner = 0;
  for (std::uint32_t c = 0; c < tree.child_count[node]; ++c) inner += tree.child_count[tree.first_child[node] + c] > 0;
  return inner;
}

std::string faultInSphere(const Sphere& s, const std::string& name) {
  if (!std::isfinite(s.x) || !std::isfinite(s.y) || !std::isfinite(s.z))
    return name + ": centre (" + number(s.x) + ", " + number(s.y) + ", " + number(s.z) + ") is not finite";
  if (!std::isfinite(s.radius) || !(s.radius > 0)) return name + ": radius " + number(s.radius) + " is not finite and above 0";
  return "";
}

std::string faultInTopology(const SphereTree& tree) {
  const std::size_t n = tree.nodeCount();
  if (n == 0) return "the tree has no nodes";
  if (n > kMaxNodes) return "the tree has " + std::to_string(n) + " nodes, more than " + std::to_string(kMaxNodes);
  if (tree.branching < kMinBranching || tree.branching > kMaxBranching)
    return "branching " + std::to_string(tree.branching) + " is not within 2 to 8";
  if (tree.child_count.size() != n || tree.first_child.size() != n || tree.bound_index.size() != n)
    return "the arrays of nodes differ in length";
  for (std::size_t i = 0; i < n; ++i)
    if (tree.child_count[i] > tree.branching)
      return "node " + std::to_string(i) + ": " + std::to_string(tree.child_count[i]) + " children are more than the branching " +
             std::to_string(tree.branching);
  SphereTree expected;
  expected.cover.resize(n);
  expected.child_count = tree.child_count;
  if (!linkNodes(expected)) return "the numbers of children do not make one tree of at most 6 levels, inner siblings ahead of leaves";
  for (std::size_t i = 0; i < n; ++i) {
    if (tree.first_child[i] != expected.first_child[i])
      return "node " + std::to_string(i) + ": first child " + std::to_string(tree.first_child[i]) + ", but breadth-first order makes it " +
             std::to_string(expected.first_child[i]);
    if (tree.bound_index[i] != expected.bound_index[i])
      return "node " + std::to_string(i) + ": bounding sphere " + std::to_string(tree.bound_index[i]) +
             ", but the order of the inner nodes makes it " + std::to_string(expected.bound_index[i]);
  }
  if (tree.level_begin != expected.level_begin) return "the level boundaries do not fit the numbers of children";
  const std::size_t inner = n - static_cast<std::size_t>(std::count(tree.child_count.begin(), tree.child_count.end(), 0));
  if (tree.bound.size() != inner)
    return std::to_string(tree.bound.size()) + " bounding spheres for " + std::to_string(inner) + " inner nodes";
  return "";
}

std::string faultInSpheres(const SphereTree& tree) {
  for (std::uint32_t i = 0; i < tree.nodeCount(); ++i) {
    const std::string node = "node " + std::to_string(i);
    if (std::string fault = faultInSphere(tree.cover[i], node); !fault.empty()) return fault;
    if (tree.isLeaf(i)) continue;
    const Sphere& bound = tree.bound[tree.bound_index[i]];
    if (std::string fault = faultInSphere(bound, node + ", bounding sphere"); !fault.empty()) return fault;
    const std::uint32_t bits = std::bit_cast<std::uint32_t>(bound.radius) & 0xff;
    const std::uint32_t tag = radiusTag(tree.child_count[i], innerChildren(tree, i));
    if (bits != tag)
      return node + ", bounding sphere: the low 8 bits of the radius are " + std::to_string(bits) + ", but its children make them " +
             std::to_string(tag);
  }
  for (std::uint32_t i = 0; i < tree.nodeCount(); ++i) {
    if (tree.isLeaf(i)) continue;
    const Ball bound = ballOf(tree.bound[tree.bound_index[i]]);
    std::string fault;
    forEachRange(tree, i, [&](std::uint32_t first, std::uint32_t last) {
      for (std::uint32_t k = first; k < last && fault.empty(); ++k)
        if (const double r = reach(bound.centre, ballOf(tree.cover[k])); !(r <= bound.radius))
          fault = "node " + std::to_string(i) + ": the bounding sphere of radius " + number(bound.radius) +
                  " does not enclose the cover sphere of node " + std::to_string(k) + ", which reaches to " + number(r);
    });
    if (!fault.empty()) return fault;
  }
  return "";
}

std::string faultInStatistics(const SphereTree& tree) {
  if (tree.statistics.size() != static_cast<std::size_t>(tree.levelCount()))
    return std::to_string(tree.statistics.size()) + " levels of statistics for " + std::to_string(tree.levelCount()) + " levels of nodes";
  SphereTree expected;
  expected.cover = tree.cover, expected.child_count = tree.child_count, expected.level_begin = tree.level_begin;
  countLevels(expected);
  for (std::size_t level = 0; level < tree.statistics.size(); ++level) {
    const LevelStatistics &found = tree.statistics[level], &right = expected.statistics[level];
    const std::string where = "statistics of level " + std::to_string(level) + ": ";
    if (found.sphere_count != right.sphere_count)
      return where + std::to_string(found.sphere_count) + " spheres, but the level set has " + std::to_string(right.sphere_count);
    if (found.smallest_radius != right.smallest_radius || found.largest_radius != right.largest_radius)
      return where + "radii from " + number(found.smallest_radius) + " to " + number(found.largest_radius) + ", but the level set has " +
             number(right.smallest_radius) + " to " + number(right.largest_radius);
    if (found.overhang_bound != kUnproven && !(std::isfinite(found.overhang_bound) && found.overhang_bound >= 0))
      return where + "overhang bound " + number(found.overhang_bound) + " is neither finite and >= 0 nor -1 (not proven)";
  }
  return "";
}

std::string faultInText(const std::string& text, std::size_t most, const char* name) {
  if (text.size() > most)
    return std::string(name) + " has " + std::to_string(text.size()) + " characters, more than " + std::to_string(most);
  for (const char c : text)
    if (c < 0x20 || c > 0x7e) return std::string(name) + " has a character outside printable ASCII";
  return "";
}

std::string faultInProvenance(const SphereTree& tree) {
  const Provenance& p = tree.provenance;
  for (const double x : tree.origin_mm)
    if (!std::isfinite(x)) return "the origin is not finite";
  if (!std::isfinite(p.unit_mm) || !(p.unit_mm > 0)) return "the unit " + number(p.unit_mm) + " mm is not finite and above 0";
  struct Quantity {
    double value;
    const char* name;
  };
  for (const Quantity& q : {Quantity{p.diagonal_mm, "diagonal"}, Quantity{p.volume_mm3, "volume"}, Quantity{p.area_mm2, "area"},
                            Quantity{p.tolerance_mm, "tolerance"}, Quantity{static_cast<double>(p.work_overhang_mm), "overhang at work"}})
    if (!std::isfinite(q.value) || !(q.value >= 0)) return std::string("the ") + q.name + " " + number(q.value) + " is not finite and >= 0";
  if (std::string fault = faultInText(p.builder, 15, "the builder's name"); !fault.empty()) return fault;
  if (std::string fault = faultInText(p.quality, 15, "the quality's name"); !fault.empty()) return fault;
  return faultInText(p.generator, 31, "the generator's name");
}

}  // namespace

std::vector<std::uint32_t> levelSet(const SphereTree& tree, int level) {
  std::vector<std::uint32_t> nodes;
  const std::uint32_t first = tree.level_begin[static_cast<std::size_t>(level)],
                      last = tree.level_begin[static_cast<std::size_t>(level) + 1];
  for (std::uint32_t i = 0; i < last; ++i)
    if (i >= first || tree.isLeaf(i)) nodes.push_back(i);
  return nodes;
}

float taggedRadius(double radius, std::uint8_t tag) {
  constexpr float kMost = std::numeric_limits<float>::max();
  if (!(radius <= kMost)) return std::numeric_limits<float>::infinity();
  float rounded = static_cast<float>(radius);
  if (rounded < radius) rounded = std::nextafter(rounded, std::numeric_limits<float>::infinity());
  std::uint32_t bits = std::bit_cast<std::uint32_t>(rounded);
  if ((bits & 0xff) > tag) bits += 0x100;
  bits = (bits & ~std::uint32_t{0xff}) | tag;
  const float tagged = std::bit_cast<float>(bits);
  return tagged <= kMost ? tagged : std::numeric_limits<float>::infinity();
}

bool linkNodes(SphereTree& tree) {
  const std::size_t n = tree.child_count.size();
  tree.first_child.assign(n, 0);
  tree.bound_index.assign(n, kNoBound);
  tree.level_begin.assign(1, 0);
  if (n == 0 || n > kMaxNodes || n != tree.cover.size()) return false;
  std::uint32_t next_child = 1, next_bound = 0, level_end = 1;
  for (std::uint32_t i = 0; i < n; ++i) {
    if (i == next_child) return false;  // no node has it as a child
    if (i == level_end) {
      if (tree.level_begin.size() == static_cast<std::size_t>(kMaxLevels)) return false;
      tree.level_begin.push_back(i);
      level_end = next_child;
    }
    const std::uint32_t count = tree.child_count[i];
    if (count == 0) continue;
    if (count > n - next_child) return false;
    for (std::uint32_t c = next_child + 1; c < next_child + count; ++c)
      if (tree.child_count[c] > 0 && tree.child_count[c - 1] == 0) return false;
    tree.first_child[i] = next_child;
    tree.bound_index[i] = next_bound++;
    next_child += count;
  }
  if (next_child != n) return false;
  tree.level_begin.push_back(static_cast<std::uint32_t>(n));
  return true;
}

Sphere smallestEnclosing(std::span<const Sphere> spheres) {
  std::vector<Ball> balls;
  for (const Sphere& s : spheres) balls.push_back(ballOf(s));
  const Enclosure e = enclose(balls);
  float radius = static_cast<float>(e.radius);
  if (radius < e.radius) radius = std::nextafter(radius, std::numeric_limits<float>::infinity());
  return {e.centre.x(), e.centre.y(), e.centre.z(), radius};
}

void encloseDescendants(SphereTree& tree) {
  tree.bound.clear();
  std::vector<Ball> balls;
  for (std::uint32_t i = 0; i < tree.nodeCount(); ++i) {
    if (tree.isLeaf(i)) continue;
    balls.clear();
    forEachRange(tree, i, [&](std::uint32_t first, std::uint32_t last) {
      for (std::uint32_t k = first; k < last; ++k) balls.push_back(ballOf(tree.cover[k]));
    });
    const Enclosure e = enclose(balls);
    tree.bound.push_back(
        {e.centre.x(), e.centre.y(), e.centre.z(), taggedRadius(e.radius, radiusTag(tree.child_count[i], innerChildren(tree, i)))});
  }
}

void countLevels(SphereTree& tree) {
  tree.statistics.resize(static_cast<std::size_t>(tree.levelCount()));
  for (std::size_t level = 0; level < tree.statistics.size(); ++level) {
    LevelStatistics& s = tree.statistics[level];
    const std::vector<std::uint32_t> nodes = levelSet(tree, static_cast<int>(level));
    s.sphere_count = static_cast<std::uint32_t>(nodes.size());
    s.smallest_radius = s.largest_radius = tree.cover[nodes[0]].radius;
    for (const std::uint32_t i : nodes) {
      s.smallest_radius = std::min(s.smallest_radius, tree.cover[i].radius);
      s.largest_radius = std::max(s.largest_radius, tree.cover[i].radius);
    }
  }
}

std::string findFault(const SphereTree& tree) {
  if (std::string fault = faultInTopology(tree); !fault.empty()) return fault;
  if (std::string fault = faultInSpheres(tree); !fault.empty()) return fault;
  if (std::string fault = faultInStatistics(tree); !fault.empty()) return fault;
  return faultInProvenance(tree);
}

}  // namespace spheretree
