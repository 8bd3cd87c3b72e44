// SPDX-License-Identifier: Apache-2.0
#include "scene/compiled_skin.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <span>
#include <type_traits>

#include "spheretree/core/float_vector.h"

namespace spheretree::runtime {
namespace {

/// A vertex or an edge. It is shared by six triangles, or by two: what is computed of it is computed once.
struct Node {
  Eigen::Vector4f position, normal;  // of an edge: from the middle of its chord to its middle
  PackedDirection packed_normal;
  float swing;  // of an edge
};

template <class Element>
std::vector<Node> nodesOf(const Skin& skin, const std::vector<Element>& elements) {
  std::vector<Node> out;
  out.reserve(elements.size());
  for (const Element& element : elements) {
    const SkinNode node = nodeOf(skin, element);
    Node& to = out.emplace_back();
    pad(node.position, to.position), pad(node.normal, to.normal);
    to.packed_normal = packed(node.normal);
    if constexpr (std::is_same_v<Element, SkinEdge>) to.swing = swingOf(skin, element);
  }
  return out;
}

void putPosition(const Eigen::Vector4f& p, float (&out)[3]) { out[0] = p.x(), out[1] = p.y(), out[2] = p.z(); }

// What is computed of each patch alone is computed of four at once, to the last bit as of one. By vectors of the
// compiler, since Eigen handles a row of arrays one by one, and takes roots by an approximation.
typedef float Four __attribute__((vector_size(16)));
struct FourVectors {
  Four x, y, z;
  friend FourVectors operator+(const FourVectors& a, const FourVectors& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend FourVectors operator-(const FourVectors& a, const FourVectors& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend FourVectors operator*(const Four& s, const FourVectors& a) { return {s * a.x, s * a.y, s * a.z}; }
  friend FourVectors operator/(const FourVectors& a, const Four& s) { return {a.x / s, a.y / s, a.z / s}; }
};

Four all(float v) { return Four{v, v, v, v}; }
Four larger(const Four& a, const Four& b) { return a < b ? b : a; }
Four squareOf(const FourVectors& v) { return v.x * v.x + (v.y * v.y + v.z * v.z); }
Four rootOf(Four square) {
  for (int k = 0; k < 4; ++k) square[k] = std::sqrt(square[k]);
  return square;
}

FourVectors transposed(const Eigen::Vector4f& a, const Eigen::Vector4f& b, const Eigen::Vector4f& c, const Eigen::Vector4f& d) {
  Four p, q, r, s;
  std::memcpy(&p, a.data(), sizeof p), std::memcpy(&q, b.data(), sizeof q);
  std::memcpy(&r, c.data(), sizeof r), std::memcpy(&s, d.data(), sizeof s);
  const Four pq = __builtin_shufflevector(p, q, 0, 4, 1, 5), rs = __builtin_shufflevector(r, s, 0, 4, 1, 5);
  return {__builtin_shufflevector(pq, rs, 0, 1, 4, 5), __builtin_shufflevector(pq, rs, 2, 3, 6, 7),
          __builtin_shufflevector(__builtin_shufflevector(p, q, 2, 6, 3, 7), __builtin_shufflevector(r, s, 2, 6, 3, 7), 0, 1, 4, 5)};
}

struct FourPatches {
  std::array<FourVectors, 6> position, normal;
  explicit FourPatches(const std::array<PaddedPatch, 4>& p) {
    for (std::size_t i = 0; i < 6; ++i) {
      position[i] = transposed(p[0].position[i], p[1].position[i], p[2].position[i], p[3].position[i]);
      normal[i] = transposed(p[0].normal[i], p[1].normal[i], p[2].normal[i], p[3].normal[i]);
    }
  }
};

// leanOf() of each.
Four leansOf(const FourPatches& patches) {
  const auto& [p, n] = patches;
  const FourVectors u = p[1] - p[0], v = p[2] - p[0], across{u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x};
  const Four length = rootOf(larger(squareOf(across), all(std::numeric_limits<float>::min())));
  const FourVectors upright = across / length;
  Four square{};
  for (std::size_t k = 0; k < 3; ++k) {
    square = larger(square, squareOf(n[k] - upright));
    square = larger(square, squareOf(all(2) * n[3 + k] - all(0.5f) * (n[k] + n[(k + 1) % 3]) - upright));
  }
  return rootOf(square);
}

// enclose() of each.
std::array<Sphere, 4> spheresAround(const FourPatches& patches) {
  const auto& p = patches.position;
  const FourVectors &a = p[0], &b = p[1], &c = p[2], ab = b - a, ac = c - a;
  const Four ab2 = squareOf(ab), ac2 = squareOf(ac), bc2 = squareOf(c - b);
  const Four at_b = ac2 * (ab2 + bc2 - ac2), at_c = ab2 * (ac2 + bc2 - ab2), sum = bc2 * (ab2 + ac2 - bc2) + at_b + at_c;
  FourVectors centre = a;
  const auto putWhere = [&](const auto& mask, const FourVectors& v) {
    centre = {mask ? v.x : centre.x, mask ? v.y : centre.y, mask ? v.z : centre.z};
  };
  putWhere(sum > all(0), a + (at_b * ab + at_c * ac) / sum);
  putWhere(ac2 + bc2 <= ab2, all(0.5f) * (a + b));
  putWhere(ab2 + bc2 <= ac2, all(0.5f) * (a + c));
  putWhere(ab2 + ac2 <= bc2, all(0.5f) * (b + c));
  Four square = all(16 * std::numeric_limits<float>::min());
  for (std::size_t k = 0; k < 3; ++k) {
    const FourVectors control = all(2) * p[3 + k] - all(0.5f) * (p[k] + p[(k + 1) % 3]);
    square = larger(square, larger(squareOf(p[k] - centre), squareOf(control - centre)));
  }
  const auto size = [](const Four& v) { return larger(v, -v); };
  const Four radius = rootOf(square), largest = larger(larger(radius, size(centre.x)), larger(size(centre.y), size(centre.z))),
             enough = radius + all(8) * largest * all(std::numeric_limits<float>::epsilon());
  std::array<Sphere, 4> spheres;
  for (std::size_t k = 0; k < 4; ++k) spheres[k] = {centre.x[k], centre.y[k], centre.z[k], enough[k]};
  return spheres;
}

// isFlat() of each: all bits of a lane, or none.
auto areFlat(const FourPatches& patches) {
  const auto& [p, n] = patches;
  const auto same = static_cast<float>(2 * kNormalError);
  Four square{};
  for (std::size_t k = 1; k < 6; ++k) square = larger(square, squareOf(n[k] - n[0]));
  auto flat = square <= all(same * same);
  for (std::size_t k = 0; k < 3; ++k) {
    const FourVectors middle = all(0.5f) * (p[k] + p[(k + 1) % 3]);
    flat &= (p[3 + k].x == middle.x) & (p[3 + k].y == middle.y) & (p[3 + k].z == middle.z);
  }
  return flat;
}

}  // namespace

// The normals are averages of six control vectors: those of the corners, and the Bezier control vectors of the sides. A
// ball about the unit normal u of the triangle that contains these contains all of them, and a ball of radius s about u
// has an angle of sine s, seen from the origin.
float leanOf(const PaddedPatch& patch) {
  const Eigen::Vector4f across = (patch.position[1] - patch.position[0]).cross3(patch.position[2] - patch.position[0]),
                        upright = across / std::sqrt(std::max(squareOfPadded(across), std::numeric_limits<float>::min()));
  float square = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const Eigen::Vector4f &a = patch.normal[k], &b = patch.normal[(k + 1) % 3], &middle = patch.normal[3 + k];
    square = std::max(square, std::max(squareOfPadded(a - upright), squareOfPadded(2 * middle - 0.5f * (a + b) - upright)));
  }
  return std::sqrt(square);
}

// Children have their blocks after that of their parent.
std::vector<FarFace> farFaces(const CompiledTree& tree, std::span<const CompiledPatch> patches) {
  // Written out by axes: Eigen handles two of three doubles together, and each change to one at a time waits.
  using Vector = std::array<double, 3>;
  const auto squared = [](const Vector& v) { return v[0] * v[0] + v[1] * v[1] + v[2] * v[2]; };
  const auto difference = [](const auto& a, const auto& b) {
    return Vector{double{a[0]} - double{b[0]}, double{a[1]} - double{b[1]}, double{a[2]} - double{b[2]}};
  };
  const double third = 1.0 / 3;
  std::vector<FarFace> out(tree.bound.size());
  std::vector<double> areas(out.size());
  for (std::size_t b = out.size(); b-- > 0;) {
    struct Part {
      Vector centre;
      double area, radius;
    };
    std::array<Part, 8> parts;
    std::size_t count = 0;
    Vector sum{}, moment{};
    for (std::size_t lane = 0; lane < 8; ++lane) {
      Part& part = parts[count];
      Vector across;
      if (const std::size_t child = tree.links[b].first_child + lane; tree.isInner(8 * b + lane)) {
        const FarFace& face = out[child];
        part = {difference(face.centre, Vector{}), areas[child], static_cast<double>(face.radius)};
        across = difference(face.area, Vector{});
      } else if (const std::uint32_t item = tree.item[8 * b + lane]; item != kNoItem) {
        const auto& p = patches[item].position;
        const Vector u = difference(p[1], p[0]), v = difference(p[2], p[0]),
                     to_centre{third * (u[0] + v[0]), third * (u[1] + v[1]), third * (u[2] + v[2])};
        across = {0.5 * (u[1] * v[2] - u[2] * v[1]), 0.5 * (u[2] * v[0] - u[0] * v[2]), 0.5 * (u[0] * v[1] - u[1] * v[0])};
        for (std::size_t k = 0; k < 3; ++k) part.centre[k] = double{p[0][k]} + to_centre[k];
        part.area = std::sqrt(squared(across));
        part.radius = std::sqrt(std::max({squared(to_centre), squared(difference(u, to_centre)), squared(difference(v, to_centre))}));
      } else {
        continue;
      }
      ++count;
      areas[b] += part.area;
      for (std::size_t k = 0; k < 3; ++k) sum[k] += across[k], moment[k] += part.area * part.centre[k];
    }
    const double area = std::max(areas[b], std::numeric_limits<double>::min());
    const Vector centre{moment[0] / area, moment[1] / area, moment[2] / area};
    double radius = 0;
    for (std::size_t k = 0; k < count; ++k)
      radius = std::max(radius, std::sqrt(squared(difference(parts[k].centre, centre))) + parts[k].radius);
    for (std::size_t k = 0; k < 3; ++k) out[b].area[k] = static_cast<float>(sum[k]), out[b].centre[k] = static_cast<float>(centre[k]);
    out[b].radius = static_cast<float>(radius);
  }
  return out;
}

CompiledSkin compileSkin(const Skin& skin, const Eigen::Vector3d& origin) {
  CompiledSkin out;
  if (skin.empty()) return out;
  out.tolerance = skin.tolerance;
  const std::vector<Node> vertices = nodesOf(skin, skin.vertices), edges = nodesOf(skin, skin.edges);
  Eigen::Vector4f shift;
  pad(origin.cast<float>(), shift);
  std::vector<Sphere> spheres(skin.triangles.size());
  out.patch.resize(skin.triangles.size());
  std::array<PaddedPatch, 4> patches{};
  for (std::size_t t = 0; t < skin.triangles.size(); ++t) {
    PaddedPatch& patch = patches[t % 4];
    const SkinTriangle& triangle = skin.triangles[t];
    CompiledPatch& to = out.patch[t];
    const auto putNormal = [&](std::size_t i, const Node& node) {
      patch.normal[i] = node.normal;
      std::memcpy(to.normal[i], node.packed_normal.data(), sizeof to.normal[i]);
    };
    for (std::size_t k = 0; k < 3; ++k) {
      const Node& corner = vertices[triangle.vertex[k]];
      patch.position[k] = corner.position;
      putNormal(k, corner);
    }
    float swing = 0;  // of the side with the largest swing
    for (std::size_t k = 0; k < 3; ++k) {
      const Node& side = edges[triangle.edge[k]];
      patch.position[3 + k] = 0.5f * (patch.position[k] + patch.position[(k + 1) % 3]) + side.position;
      putNormal(3 + k, side);
      to.flags |= static_cast<std::uint32_t>(skin.edges[triangle.edge[k]].is_sharp != 0) << k;
      swing = std::max(swing, side.swing);
    }
    for (std::size_t i = 0; i < 6; ++i) putPosition(patch.position[i] + shift, to.position[i]);
    to.flags |= swingBits(swing / skin.tolerance);
    if (t % 4 < 3 && t + 1 < skin.triangles.size()) continue;
    const FourPatches four(patches);
    const Four leans = leansOf(four);
    const auto flat = areFlat(four);
    const std::array<Sphere, 4> around = spheresAround(four);
    for (std::size_t k = 0, of = t - t % 4; of <= t; ++k, ++of) {
      std::uint32_t& flags = out.patch[of].flags;
      if (!flat[k]) flags |= kCurved;
      flags |= leanBits(leans[k]);
      spheres[of] = around[k];
    }
  }
  out.tree = compileTree(skin.search, spheres, origin, TreeOver::Triangles);
  out.far = farFaces(out.tree, out.patch);
  return out;
}

}  // namespace spheretree::runtime
