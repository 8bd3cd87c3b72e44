// SPDX-License-Identifier: Apache-2.0
#include "scene/compiled_skin.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "spheretree/core/float_vector.h"

namespace spheretree::runtime {
namespace {

std::vector<PackedDirection> packedNormals(std::span<const SkinNode> nodes) {
  std::vector<PackedDirection> out(nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) out[i] = packed(nodes[i].normal);
  return out;
}

std::vector<float> swingsOf(const Skin& skin) {
  std::vector<float> out;
  out.reserve(skin.edges.size());
  for (const SkinEdge& e : skin.edges) out.push_back(swingOf(skin, e));
  return out;
}

void putPosition(const Eigen::Vector3f& p, float (&out)[3]) { out[0] = p.x(), out[1] = p.y(), out[2] = p.z(); }
Eigen::Vector3d vectorOf(const float (&p)[3]) { return {p[0], p[1], p[2]}; }

// A cone may touch a triangle at a side, a slab at a corner. Of the triangles that share one, the first answers for it.
// The felt row of a curved patch is that of its first smooth side, and each sharp side has one of its own.
class HullWays {
 public:
  explicit HullWays(const Skin& skin) : side_taken_(skin.edges.size()), corner_taken_(skin.vertices.size()) {}
  std::uint8_t of(const SkinTriangle& triangle, std::uint32_t flags) {
    std::uint32_t sides = 0, corners = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      if (!std::exchange(side_taken_[triangle.edge[k]], char{1})) sides |= 1u << k;
      if (!std::exchange(corner_taken_[triangle.vertex[k]], char{1})) corners |= 1u << k;
    }
    const std::uint32_t sharp = flags & 7, felt = (flags & kCurved) == 0 ? 0 : sharp | (~sharp & (sharp + 1) & 7);
    return static_cast<std::uint8_t>((sides | felt) | (corners | felt) << 3);
  }

 private:
  std::vector<char> side_taken_, corner_taken_;
};

}  // namespace

// The normals are averages of six control vectors: those of the corners, and the Bezier control vectors of the sides. A
// ball about the unit normal u of the triangle that contains these contains all of them, and a ball of radius s about u
// has an angle of sine s, seen from the origin.
float leanOf(const SkinPatch& patch) {
  const Eigen::Vector3f across = (patch.position[1] - patch.position[0]).cross(patch.position[2] - patch.position[0]),
                        upright = across / std::sqrt(std::max(squareOf(across), std::numeric_limits<float>::min()));
  float square = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const Eigen::Vector3f &a = patch.normal[k], &b = patch.normal[(k + 1) % 3], &middle = patch.normal[3 + k];
    square = std::max({square, squareOf(a - upright), squareOf(2 * middle - 0.5f * (a + b) - upright)});
  }
  return std::sqrt(square);
}

// Children have their blocks after that of their parent.
std::vector<FarFace> farFaces(const CompiledTree& tree, std::span<const CompiledPatch> patches) {
  std::vector<FarFace> out(tree.bound.size());
  std::vector<double> areas(out.size());
  for (std::size_t b = out.size(); b-- > 0;) {
    struct Part {
      Eigen::Vector3d centre;
      double area, radius;
    };
    std::array<Part, 8> parts;
    std::size_t count = 0;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero(), moment = sum;
    for (std::size_t lane = 0; lane < 8; ++lane) {
      if (const std::size_t child = tree.links[b].first_child + lane; tree.isInner(8 * b + lane)) {
        parts[count++] = {vectorOf(out[child].centre), areas[child], static_cast<double>(out[child].radius)};
        sum += vectorOf(out[child].area);
      } else if (const std::uint32_t item = tree.item[8 * b + lane]; item != kNoItem) {
        const auto& p = patches[item].position;
        const Eigen::Vector3d a = vectorOf(p[0]), u = vectorOf(p[1]) - a, v = vectorOf(p[2]) - a, across = 0.5 * u.cross(v),
                              to_centre = (u + v) / 3;
        parts[count++] = {a + to_centre, across.norm(), std::max({to_centre.norm(), (u - to_centre).norm(), (v - to_centre).norm()})};
        sum += across;
      } else {
        continue;
      }
      const Part& part = parts[count - 1];
      areas[b] += part.area;
      moment += part.area * part.centre;
    }
    const Eigen::Vector3d centre = moment / std::max(areas[b], std::numeric_limits<double>::min());
    double radius = 0;
    for (std::size_t k = 0; k < count; ++k) radius = std::max(radius, (parts[k].centre - centre).norm() + parts[k].radius);
    putPosition(sum.cast<float>(), out[b].area);
    putPosition(centre.cast<float>(), out[b].centre);
    out[b].radius = static_cast<float>(radius);
  }
  return out;
}

CompiledSkin compileSkin(const Skin& skin, const Eigen::Vector3d& origin) {
  CompiledSkin out;
  if (skin.empty()) return out;
  out.tolerance = skin.tolerance;
  // Shared data is computed once: a vertex is shared by six triangles, an edge by two.
  const SkinNodes nodes(skin);
  const std::vector<PackedDirection> vertex_normals = packedNormals(nodes.ofVertices()), edge_normals = packedNormals(nodes.ofEdges());
  const std::vector<float> swings = swingsOf(skin);
  const Eigen::Vector3f shift = origin.cast<float>();
  std::vector<Sphere> spheres(skin.triangles.size());
  HullWays ways(skin);
  out.patch.reserve(skin.triangles.size());
  for (std::size_t t = 0; t < skin.triangles.size(); ++t) {
    const SkinTriangle& triangle = skin.triangles[t];
    const SkinPatch patch = nodes.patchOf(t);
    CompiledPatch& to = out.patch.emplace_back();
    spheres[t] = enclose(patch);
    for (std::size_t i = 0; i < 6; ++i) putPosition(patch.position[i] + shift, to.position[i]);
    to.flags = allowanceOf(patch, 1) > 0 ? kCurved : 0;
    float swing = 0;  // of the side with the largest swing
    for (std::size_t k = 0; k < 3; ++k) {
      std::copy_n(vertex_normals[triangle.vertex[k]].begin(), 3, to.normal[k]);
      std::copy_n(edge_normals[triangle.edge[k]].begin(), 3, to.normal[3 + k]);
      to.flags |= static_cast<std::uint32_t>(patch.is_sharp[k]) << k;
      swing = std::max(swing, swings[triangle.edge[k]]);
    }
    out.ways.push_back(ways.of(triangle, to.flags));
    to.flags |= swingBits(swing / skin.tolerance) | leanBits(leanOf(patch));
  }
  out.tree = compileTree(skin.search, spheres, origin, TreeOver::Triangles);
  out.far = farFaces(out.tree, out.patch);
  return out;
}

}  // namespace spheretree::runtime
