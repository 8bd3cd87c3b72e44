// SPDX-License-Identifier: Apache-2.0
#include "spheretree/core/skin.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "search_tree_spheres.h"

namespace spheretree {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr double kOctahedral = 32767;  // largest coordinate
constexpr int kMostOffset = 127;       // of an edge's middle, in steps; -128 is not used

bool inRange(float value, float low, float high) { return value >= low && value <= high; }

float signOf(float x) { return x < 0 ? -1.0f : 1.0f; }

// The two further points whose hull with the corners holds a quadratic side: Bezier's control point of the side with the middle `m`.
Vector3f controlPoint(const Vector3f& a, const Vector3f& b, const Vector3f& m) { return 2.0f * m - 0.5f * (a + b); }

std::string at(const char* what, std::size_t i) { return std::string(what) + " " + std::to_string(i) + " of the skin: "; }

std::string findNumberFault(const Skin& skin) {
  for (const float x : skin.low)
    if (!inRange(x, -1e7f, 1e7f)) return "the skin lies beyond 1e7 mm from its frame's origin";
  if (!inRange(skin.step, 1e-30f, 1e4f)) return "the skin's step of positions is not within 1e-30 .. 1e4 mm";
  if (!inRange(skin.offset_step, 0, 1e4f) || !inRange(skin.tolerance, 0, 1e7f) || !inRange(skin.mesh_distance, 0, 1e7f))
    return "a length of the skin is negative, too large or not finite";
  if (!inRange(skin.crease_angle, 0, 3.1416f)) return "the skin's crease angle is not within 0 .. pi";
  return {};
}

std::string findElementFault(const Skin& skin) {
  const auto bad = [](const PackedNormal& n) {
    return n[0] == std::numeric_limits<std::int16_t>::min() || n[1] == std::numeric_limits<std::int16_t>::min();
  };
  for (std::size_t i = 0; i < skin.vertices.size(); ++i)
    if (bad(skin.vertices[i].normal)) return at("vertex", i) + "its normal is out of range";
  for (std::size_t i = 0; i < skin.edges.size(); ++i) {
    const SkinEdge& e = skin.edges[i];
    if (bad(e.normal)) return at("edge", i) + "its normal is out of range";
    if (e.is_sharp > 1) return at("edge", i) + "its flag is neither 0 nor 1";
    for (const std::int8_t x : e.offset)
      if (x < -kMostOffset || (e.is_sharp && x != 0)) return at("edge", i) + "its offset is out of range";
  }
  for (std::size_t i = 0; i < skin.triangles.size(); ++i) {
    const SkinTriangle& t = skin.triangles[i];
    for (std::size_t k = 0; k < 3; ++k) {
      if (t.vertex[k] >= skin.vertices.size() || t.edge[k] >= skin.edges.size())
        return at("triangle", i) + "it names a vertex or an edge that is not there";
      if (t.vertex[k] == t.vertex[(k + 1) % 3] || t.edge[k] == t.edge[(k + 1) % 3]) return at("triangle", i) + "it names one twice";
    }
  }
  return {};
}

// Positions of the nodes of a patch.
std::array<Vector3f, 6> positionsOf(const Skin& skin, std::size_t triangle) {
  const SkinTriangle& t = skin.triangles[triangle];
  std::array<Vector3f, 6> position;
  for (std::size_t k = 0; k < 3; ++k)
    for (std::size_t axis = 0; axis < 3; ++axis)
      position[k][static_cast<Eigen::Index>(axis)] =
          skin.low[axis] + skin.step * static_cast<float>(skin.vertices[t.vertex[k]].position[axis]);
  for (std::size_t k = 0; k < 3; ++k) {
    const std::array<std::int8_t, 3>& e = skin.edges[t.edge[k]].offset;
    const Vector3f offset(static_cast<float>(e[0]), static_cast<float>(e[1]), static_cast<float>(e[2]));
    position[3 + k] = 0.5f * (position[k] + position[(k + 1) % 3]) + skin.offset_step * offset;
  }
  return position;
}

// Whether `sphere` encloses the corners of a patch and the control points of its sides, whose hull holds the patch and the flat triangle.
// The square of a float is exact in double.
bool encloses(const Sphere& sphere, const Skin& skin, std::size_t triangle) {
  const std::array<Vector3f, 6> position = positionsOf(skin, triangle);
  const Vector3d centre(double{sphere.x}, double{sphere.y}, double{sphere.z});
  const double square = double{sphere.radius} * double{sphere.radius};
  const auto holds = [&](const Vector3d& p) {
    const double dx = p.x() - centre.x(), dy = p.y() - centre.y(), dz = p.z() - centre.z();
    return dx * dx + dy * dy + dz * dz <= square;
  };
  bool all = true;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vector3d a = position[k].cast<double>(), b = position[(k + 1) % 3].cast<double>(), m = position[3 + k].cast<double>();
    all = holds(a) & holds(2 * m - 0.5 * (a + b)) & all;
  }
  return all;
}

}  // namespace

bool operator==(const Skin& a, const Skin& b) {
  const auto same = [](const auto& x, const auto& y, auto&& equal) {
    return x.size() == y.size() && std::equal(x.begin(), x.end(), y.begin(), equal);
  };
  return a.low == b.low && a.step == b.step && a.offset_step == b.offset_step && a.tolerance == b.tolerance &&
         a.mesh_distance == b.mesh_distance && a.crease_angle == b.crease_angle && a.search == b.search &&
         same(a.vertices, b.vertices,
              [](const SkinVertex& x, const SkinVertex& y) { return x.position == y.position && x.normal == y.normal; }) &&
         same(a.edges, b.edges,
              [](const SkinEdge& x, const SkinEdge& y) {
                return x.offset == y.offset && x.is_sharp == y.is_sharp && x.normal == y.normal;
              }) &&
         same(a.triangles, b.triangles,
              [](const SkinTriangle& x, const SkinTriangle& y) { return x.vertex == y.vertex && x.edge == y.edge; });
}

PackedNormal packNormal(const Vector3d& unit) {
  Vector3d n = unit / unit.cwiseAbs().sum();
  if (n.z() < 0) {
    const double x = (1 - std::abs(n.y())) * (n.x() < 0 ? -1 : 1), y = (1 - std::abs(n.x())) * (n.y() < 0 ? -1 : 1);
    n.x() = x, n.y() = y;
  }
  return {static_cast<std::int16_t>(std::lround(n.x() * kOctahedral)), static_cast<std::int16_t>(std::lround(n.y() * kOctahedral))};
}

Vector3f unpackNormal(const PackedNormal& packed) {
  constexpr auto kScale = static_cast<float>(1 / kOctahedral);
  const float x = static_cast<float>(packed[0]) * kScale, y = static_cast<float>(packed[1]) * kScale, z = 1 - std::abs(x) - std::abs(y),
              fold = std::max(-z, 0.0f);
  const Vector3f n(x - signOf(x) * fold, y - signOf(y) * fold, z);
  return n / std::sqrt(n.squaredNorm());
}

SkinPatch patchOf(const Skin& skin, std::size_t triangle) {
  const SkinTriangle& t = skin.triangles[triangle];
  SkinPatch patch;
  patch.position = positionsOf(skin, triangle);
  for (std::size_t k = 0; k < 3; ++k) {
    const SkinEdge& e = skin.edges[t.edge[k]];
    patch.normal[k] = unpackNormal(skin.vertices[t.vertex[k]].normal);
    patch.normal[3 + k] = unpackNormal(e.normal);
    patch.is_sharp[k] = e.is_sharp != 0;
  }
  return patch;
}

// The smallest circle about the flat triangle, made large enough for the control points of the patch, whose hull holds it.
Sphere enclose(const SkinPatch& patch) {
  const Vector3f &a = patch.position[0], &b = patch.position[1], &c = patch.position[2];
  Vector3f centre = Vector3f::Zero();
  float least = std::numeric_limits<float>::infinity();
  const auto offer = [&](const Vector3f& middle) {
    const float square = std::max({(a - middle).squaredNorm(), (b - middle).squaredNorm(), (c - middle).squaredNorm()});
    if (square < least) least = square, centre = middle;
  };
  offer(0.5f * (a + b));
  offer(0.5f * (b + c));
  offer(0.5f * (c + a));
  const Vector3f u = b - a, v = c - a, n = u.cross(v);
  if (n.squaredNorm() > 0) offer(a + (n.cross(u) * v.squaredNorm() + v.cross(n) * u.squaredNorm()) / (2 * n.squaredNorm()));
  double radius = 0;
  const auto hold = [&](const Vector3f& p) { radius = std::max(radius, (p - centre).cast<double>().norm()); };
  for (std::size_t k = 0; k < 3; ++k) {
    hold(patch.position[k]);
    hold(controlPoint(patch.position[k], patch.position[(k + 1) % 3], patch.position[3 + k]));
  }
  // (p - centre) is rounded once for each axis, the norm a few times in double, the result once: 4 units in the last place hold it all.
  const double size = std::max({radius, static_cast<double>(centre.cwiseAbs().maxCoeff())});
  return {centre.x(), centre.y(), centre.z(), static_cast<float>(radius + 4 * size * std::numeric_limits<float>::epsilon())};
}

std::string findFault(const Skin& skin) {
  if (std::string fault = findNumberFault(skin); !fault.empty()) return fault;
  if (skin.triangles.empty() || skin.triangles.size() > kMaxSearchItems)
    return "the skin has " + std::to_string(skin.triangles.size()) + " triangles, not 1 to " + std::to_string(kMaxSearchItems);
  constexpr std::size_t kMost = 65536;  // that 16 bits name
  if (skin.vertices.size() > kMost || skin.edges.size() > kMost) return "the skin has more vertices or edges than 65536";
  if (std::string fault = findElementFault(skin); !fault.empty()) return fault;
  if (!skin.search.item.empty()) return "the triangles of a skin stand in the order of its search tree, which needs no list of items";
  if (std::string fault = findTopologyFault(skin.search, skin.triangles.size()); !fault.empty()) return "skin: " + fault;
  const std::string fault = findSphereFault(skin.search, [&](const Sphere& s, std::size_t t) { return encloses(s, skin, t); });
  return fault.empty() ? fault : "skin: " + fault;
}

}  // namespace spheretree
