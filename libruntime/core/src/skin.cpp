// SPDX-License-Identifier: Apache-2.0
#include "spheretree/core/skin.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "describe.h"
#include "search_tree_spheres.h"
#include "spheretree/core/float_vector.h"
#include "spheretree/core/rounding.h"

namespace spheretree {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;
using Eigen::Vector4f;

constexpr double kOctahedral = 32767;  // largest coordinate

bool inRange(float value, float low, float high) { return value >= low && value <= high; }

// The hull of a quadratic side is that of its corners and its Bezier control point. This is the control point of the
// side with the middle `m`.
Vector4f controlPoint(const Vector4f& a, const Vector4f& b, const Vector4f& m) { return 2.0f * m - 0.5f * (a + b); }

std::string faultOf(const char* element, std::size_t i, const char* what) { return describe("%s %zu of the skin: %s", element, i, what); }

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
  for (std::size_t i = 0; i < skin.vertices.size(); ++i) {
    const SkinVertex& v = skin.vertices[i];
    if (bad(v.normal)) return faultOf("vertex", i, "its normal is out of range");
    if (std::max({v.position[0], v.position[1], v.position[2]}) > kMaxSkinCoordinate)
      return faultOf("vertex", i, "its position is out of range");
  }
  for (std::size_t i = 0; i < skin.edges.size(); ++i) {
    const SkinEdge& e = skin.edges[i];
    if (bad(e.normal)) return faultOf("edge", i, "its normal is out of range");
    if (e.is_sharp > 1) return faultOf("edge", i, "its flag is neither 0 nor 1");
    for (const std::int8_t x : e.offset)
      if (x == std::numeric_limits<std::int8_t>::min() || (e.is_sharp && x != 0)) return faultOf("edge", i, "its offset is out of range");
    if (!(swingOf(skin, e) <= skin.tolerance)) return faultOf("edge", i, "it swings out farther than the tolerance of the skin");
  }
  for (std::size_t i = 0; i < skin.triangles.size(); ++i) {
    const SkinTriangle& t = skin.triangles[i];
    for (std::size_t k = 0; k < 3; ++k) {
      if (t.vertex[k] >= skin.vertices.size() || t.edge[k] >= skin.edges.size())
        return faultOf("triangle", i, "it names a vertex or an edge that is not there");
      if (t.vertex[k] == t.vertex[(k + 1) % 3] || t.edge[k] == t.edge[(k + 1) % 3]) return faultOf("triangle", i, "it names one twice");
    }
  }
  return {};
}

// From the middle of a side's chord to the middle of the side.
Vector3f offsetOf(const Skin& skin, const SkinEdge& edge) {
  const Vector3f steps(static_cast<float>(edge.offset[0]), static_cast<float>(edge.offset[1]), static_cast<float>(edge.offset[2]));
  return skin.offset_step * steps;
}

// Checks whether spheres enclose patches, that is their corners and the control points of their sides, whose hull
// contains the patch and the flat triangle.
class PatchCheck {
 public:
  explicit PatchCheck(const Skin& skin) : skin_(skin) {
    corners_.reserve(skin.vertices.size());
    for (const SkinVertex& v : skin.vertices) pad(positionOf(skin, v.position), corners_.emplace_back());
    bends_.reserve(skin.edges.size());
    for (const SkinEdge& e : skin.edges) pad(2 * offsetOf(skin, e), bends_.emplace_back());
    nodes_.reserve(skin.triangles.size());
    for (const SkinTriangle& triangle : skin.triangles) {
      const Vector4f &a = corners_[triangle.vertex[0]], &b = corners_[triangle.vertex[1]], &c = corners_[triangle.vertex[2]];
      Eigen::Matrix4f first, second;
      first.col(0) = a, first.col(1) = b, first.col(2) = c, first.col(3) = 0.5f * (a + b) + bends_[triangle.edge[0]];
      second.col(0) = 0.5f * (b + c) + bends_[triangle.edge[1]], second.col(1) = 0.5f * (c + a) + bends_[triangle.edge[2]];
      second.col(2) = second.col(3) = a;
      first.transposeInPlace(), second.transposeInPlace();
      nodes_.push_back({first, second});
    }
    const auto largest = [](const std::vector<Vector4f>& all) {
      Vector4f size = Vector4f::Zero();
      for (const Vector4f& v : all) size = size.cwiseMax(v.cwiseAbs());
      return size.maxCoeff();
    };
    doubt_ = 4 * std::numeric_limits<float>::epsilon() * (largest(corners_) + largest(bends_));
  }

  // In float if the result is certain: a control point has a relative error of at most 2^-23 of its coordinates; a
  // difference, its square and the sum together have fewer than 8 roundings. Nodes nearer to the sphere are decided in
  // double: most spheres touch a corner that several triangles share.
  bool encloses(const Sphere& sphere, std::size_t triangle) const {
    const std::array<Vector4f, 2> squares{squaresFrom(sphere, nodes_[triangle][0]), squaresFrom(sphere, nodes_[triangle][1])};
    const float radius = std::max((1 - 1e-5f) * sphere.radius - doubt_, 0.0f), certain = radius * radius;
    if (squares[0].cwiseMax(squares[1]).maxCoeff() < certain) return true;
    for (int k = 0; k < 6; ++k)
      if (!(squares[static_cast<std::size_t>(k / 4)][k % 4] < certain) && !enclosesExactly(sphere, skin_.triangles[triangle], k))
        return false;
    return true;
  }

 private:
  static Vector4f squaresFrom(const Sphere& sphere, const Eigen::Matrix4f& nodes) {
    return ((nodes.col(0).array() - sphere.x).square() + (nodes.col(1).array() - sphere.y).square() +
            (nodes.col(2).array() - sphere.z).square())
        .matrix();
  }

  [[gnu::noinline]] bool enclosesExactly(const Sphere& sphere, const SkinTriangle& t, int node) const {
    const auto k = static_cast<std::size_t>(node % 3);
    const Vector4f &a = corners_[t.vertex[k]], &b = corners_[t.vertex[(k + 1) % 3]], &bend = bends_[t.edge[k]];
    const std::array<double, 3> centre{double{sphere.x}, double{sphere.y}, double{sphere.z}};
    double square = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double p = node < 3 ? double{a[axis]} : 0.5 * (double{a[axis]} + double{b[axis]}) + double{bend[axis]};
      const double d = p - centre[static_cast<std::size_t>(axis)];
      square += d * d;
    }
    return square <= double{sphere.radius} * double{sphere.radius};  // of a float: exact
  }

  const Skin& skin_;
  std::vector<Vector4f> corners_;  // (vertices) x, y, z, 0
  std::vector<Vector4f> bends_;    // (edges) from the middle of the chord to the control point, 0
  // (triangles) columns x, y, z, 0; rows: corners 0, 1, 2, control point 01, then 12, 20, and corner 0 twice
  std::vector<std::array<Eigen::Matrix4f, 2>> nodes_;
  float doubt_ = 0;  // [mm]
};

}  // namespace

[[gnu::cold]] bool operator==(const Skin& a, const Skin& b) {  // small code, not fast
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
  const auto scale = static_cast<float>(1 / kOctahedral);
  const float x = static_cast<float>(packed[0]) * scale, y = static_cast<float>(packed[1]) * scale, z = 1 - std::abs(x) - std::abs(y),
              fold = std::max(-z, 0.0f);
  const Vector3f n(x - std::copysign(fold, x), y - std::copysign(fold, y), z);
  return n / lengthOf(n);
}

SkinNode nodeOf(const Skin& skin, const SkinVertex& vertex) { return {positionOf(skin, vertex.position), unpackNormal(vertex.normal)}; }
SkinNode nodeOf(const Skin& skin, const SkinEdge& edge) { return {offsetOf(skin, edge), unpackNormal(edge.normal)}; }

PaddedPatch padded(const SkinPatch& patch) {
  PaddedPatch out;
  for (std::size_t k = 0; k < 6; ++k) pad(patch.position[k], out.position[k]), pad(patch.normal[k], out.normal[k]);
  return out;
}

Vector3f positionOf(const Skin& skin, const SkinPosition& steps) {
  Vector3f position;
  for (std::size_t axis = 0; axis < 3; ++axis)
    position[static_cast<Eigen::Index>(axis)] = skin.low[axis] + skin.step * static_cast<float>(steps[axis]);
  return position;
}

SkinPatch patchOf(const Skin& skin, std::size_t triangle) {
  const SkinTriangle& t = skin.triangles[triangle];
  SkinPatch patch;
  for (std::size_t k = 0; k < 3; ++k) {
    const SkinNode node = nodeOf(skin, skin.vertices[t.vertex[k]]);
    patch.position[k] = node.position;
    patch.normal[k] = node.normal;
  }
  for (std::size_t k = 0; k < 3; ++k) {
    const SkinEdge& edge = skin.edges[t.edge[k]];
    const SkinNode node = nodeOf(skin, edge);
    patch.position[3 + k] = 0.5f * (patch.position[k] + patch.position[(k + 1) % 3]) + node.position;
    patch.normal[3 + k] = node.normal;
    patch.is_sharp[k] = edge.is_sharp != 0;
  }
  return patch;
}

SkinNodes::SkinNodes(const Skin& skin) {
  vertices_.reserve(skin.vertices.size());
  edges_.reserve(skin.edges.size());
  for (const SkinVertex& v : skin.vertices) vertices_.push_back(nodeOf(skin, v));
  for (const SkinEdge& e : skin.edges) edges_.push_back(nodeOf(skin, e));
}

// Four units in the last place cover the rounding errors of the constant, the root and the two products.
float swingOf(const Skin& skin, const SkinEdge& edge) {
  constexpr float kSwing = 4.0f / 3.0f * (1 + 4 * std::numeric_limits<float>::epsilon());
  int square = 0;
  for (const std::int8_t x : edge.offset) square += int{x} * int{x};
  return kSwing * skin.offset_step * std::sqrt(static_cast<float>(square));
}

bool isFlat(const PaddedPatch& patch) {
  const auto same = static_cast<float>(2 * kNormalError);  // largest distance of two packed forms of one direction
  for (std::size_t k = 0; k < 6; ++k)
    if (squareOfPadded(patch.normal[k] - patch.normal[0]) > same * same) return false;
  for (std::size_t k = 0; k < 3; ++k)  // rounded like a middle without an offset in patchOf()
    if (patch.position[3 + k] != 0.5f * (patch.position[k] + patch.position[(k + 1) % 3])) return false;
  return true;
}

float allowanceOf(const SkinPatch& patch, float tolerance) { return isFlat(padded(patch)) ? 0 : tolerance; }

// The smallest circle around the flat triangle, enlarged to contain the control points of the patch, whose hull
// contains the patch. Its centre is the middle of the longest side, or the circumcentre of an acute triangle.
Sphere enclose(const PaddedPatch& patch) {
  const Vector4f &a = patch.position[0], &b = patch.position[1], &c = patch.position[2];
  const Vector4f ab = b - a, ac = c - a;
  const float ab2 = squareOfPadded(ab), ac2 = squareOfPadded(ac), bc2 = squareOfPadded(c - b);
  Vector4f centre;
  if (ab2 + ac2 <= bc2) {
    centre = 0.5f * (b + c);
  } else if (ab2 + bc2 <= ac2) {
    centre = 0.5f * (a + c);
  } else if (ac2 + bc2 <= ab2) {
    centre = 0.5f * (a + b);
  } else {
    const float at_a = bc2 * (ab2 + ac2 - bc2), at_b = ac2 * (ab2 + bc2 - ac2), at_c = ab2 * (ac2 + bc2 - ab2), sum = at_a + at_b + at_c;
    centre = a;
    if (sum > 0) centre += (at_b * ab + at_c * ac) / sum;  // otherwise it underflows
  }
  float square = 16 * std::numeric_limits<float>::min();  // more than the underflow of the squares below
  for (std::size_t k = 0; k < 3; ++k) {
    const Vector4f control = controlPoint(patch.position[k], patch.position[(k + 1) % 3], patch.position[3 + k]);
    square = std::max(square, std::max(squareOfPadded(patch.position[k] - centre), squareOfPadded(control - centre)));
  }
  // A control point and a difference are rounded a few times for each axis, and the norm as often: 8 units in the last
  // place cover all of that.
  const float radius = std::sqrt(square), size = std::max(radius, centre.cwiseAbs().maxCoeff());
  return {centre.x(), centre.y(), centre.z(), radius + 8 * size * std::numeric_limits<float>::epsilon()};
}

Sphere enclose(const SkinPatch& patch) { return enclose(padded(patch)); }

std::string findFault(const Skin& skin) {
  if (std::string fault = findNumberFault(skin); !fault.empty()) return fault;
  if (skin.triangles.empty() || skin.triangles.size() > kMaxSearchItems)
    return describe("the skin has %zu triangles, not 1 to %zu", skin.triangles.size(), kMaxSearchItems);
  const std::size_t last = std::numeric_limits<std::uint16_t>::max();  // index that 16 bits can hold
  if (std::max(skin.vertices.size(), skin.edges.size()) > last + 1) return "the skin has more vertices or edges than 65536";
  if (std::string fault = findElementFault(skin); !fault.empty()) return fault;
  if (!skin.search.item.empty()) return "the triangles of a skin stand in the order of its search tree, which needs no list of items";
  if (std::string fault = findTopologyFault(skin.search, skin.triangles.size()); !fault.empty()) return fault.insert(0, "skin: ");
  const PatchCheck check(skin);
  std::string fault = findSphereFault(skin.search, [&](const Sphere& s, std::size_t t) { return check.encloses(s, t); });
  return fault.empty() ? fault : fault.insert(0, "skin: ");
}

}  // namespace spheretree
