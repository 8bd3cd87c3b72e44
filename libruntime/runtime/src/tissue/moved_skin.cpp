// SPDX-License-Identifier: Apache-2.0
#include "tissue/moved_skin.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "spheretree/core/float_vector.h"

namespace spheretree::runtime {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

// How far the patch of each triangle may reach beyond the flat triangle, however the tissue is bent.
std::vector<float> roomOf(const SoftModel& model, float tolerance) {
  std::vector<float> room;
  for (const SkinTriangle& triangle : model.tree->skin.triangles) {
    float bulge = 0, swing = 0;
    for (const std::uint32_t v : triangle.vertex) bulge = std::max(bulge, bulgeBound(model.vertices[v]));
    for (const std::uint32_t e : triangle.edge) swing = std::max(swing, swingBound(model.edges[e]));
    room.push_back(tolerance + bulge + swing);
  }
  return room;
}

}  // namespace

MovedSkin::MovedSkin(const SoftModel& model, const CompiledShape& shape)
    : model_(model),
      shape_(shape),
      skin_(model.tree->skin),
      rest_allowance_(shape.skin.tolerance),
      bent_(model, (Vector3d(model.tree->origin_mm.data()) - shape.centre).cast<float>()),
      balls_(model, shape, roomOf(model, shape.skin.tolerance)),
      patch_states_(shape.skin.patch.size()),
      points_(kPointSets * kPointWays) {
  for (const SoftModel::Edge& e : model.edges) largest_swing_ = std::max(largest_swing_, swingBound(e));
  reset();
}

void MovedSkin::reset() {
  bent_.reset();
  allowance_ = rest_allowance_;
  patches_ = shape_.skin.patch;
  balls_.reset();
  beginStep();
}

void MovedSkin::bend(std::span<const float> shift) {
  bent_.bend(shift);
  allowance_ = rest_allowance_;
}

// What stays within a step: the normals, and how far the patch swings out of its flat triangle.
void MovedSkin::bendPatch(std::uint32_t t) {
  const SkinTriangle& triangle = skin_.triangles[t];
  CompiledPatch& out = patches_[t];
  const Vector3f& first = bent_.vertex(triangle.vertex[0]).normal;
  float swing2 = 0, turn2 = 0;
  out.flags = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const BentSurface::Vertex& corner = bent_.vertex(triangle.vertex[k]);
    const BentSurface::Middle& middle = bent_.middle(triangle.edge[k]);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      out.normal[k][axis] = corner.packed[axis];
      out.normal[3 + k][axis] = middle.packed[axis];
    }
    out.flags |= static_cast<std::uint32_t>(model_.edges[triangle.edge[k]].is_sharp) << k;
    swing2 = std::max(swing2, squareOf(middle.offset));
    turn2 = std::max({turn2, squareOf(corner.normal - first), squareOf(middle.normal - first)});
  }
  if (swing2 > 0 || turn2 > static_cast<float>(4 * kNormalError * kNormalError)) out.flags |= kCurved;
  patch_states_[t].swing = kSwingOfOffset * std::sqrt(swing2);
  allowance_ = std::max(allowance_, patch_states_[t].swing);
}

void MovedSkin::putPatch(std::uint32_t t, std::span<const float> shift) {
  Patch& state = patch_states_[t];
  if (state.version == bent_.version()) return;
  state.version = bent_.version();
  if (state.bend != bent_.bends()) bendPatch(t);
  state.bend = bent_.bends();
  const SkinTriangle& triangle = skin_.triangles[t];
  SkinPatch patch;
  for (std::size_t k = 0; k < 3; ++k) {
    patch.position[k] = bent_.placeOf(triangle.vertex[k], shift);
    patch.normal[k] = bent_.vertex(triangle.vertex[k]).normal;
    patch.normal[3 + k] = bent_.middle(triangle.edge[k]).normal;
  }
  for (std::size_t k = 0; k < 3; ++k)
    patch.position[3 + k] = 0.5f * (patch.position[k] + patch.position[(k + 1) % 3]) + bent_.middle(triangle.edge[k]).offset;
  CompiledPatch& out = patches_[t];
  for (std::size_t k = 0; k < 6; ++k) Eigen::Map<Vector3f>(out.position[k]) = patch.position[k];
  const std::uint32_t stay = out.flags & ((1u << kSwingShift) - 1);
  out.flags = stay | swingBits(state.swing / allowance_) | leanBits(leanOf(padded(patch)));
}

void MovedSkin::putTriangles(std::span<const std::uint32_t> pairs, std::span<const float> shift) {
  for (const std::uint32_t pair : pairs) {
    const std::uint32_t t = shape_.skin.tree.item[pair & 0xffff];
    if (patch_states_[t].corners_version == bent_.version()) continue;
    patch_states_[t].corners_version = bent_.version();
    for (std::size_t k = 0; k < 3; ++k) Eigen::Map<Vector3f>(patches_[t].position[k]) = bent_.placeOf(skin_.triangles[t].vertex[k], shift);
  }
}

void MovedSkin::put(std::span<const std::uint32_t> pairs, std::span<const float> shift) {
  for (const std::uint32_t pair : pairs)
    if (const std::uint32_t t = shape_.skin.tree.item[pair & 0xffff]; t != kNoItem) putPatch(t, shift);
}

SkinPoint MovedSkin::pointAt(std::uint32_t triangle, const Vector3d& p) const {
  const CompiledPatch& patch = patches_[triangle];
  const auto corner = [&](std::size_t k) { return Vector3d(Eigen::Map<const Vector3f>(patch.position[k]).cast<double>()); };
  const Vector3d a = corner(0), u = corner(1) - a, v = corner(2) - a, normal = u.cross(v), way = p - a;
  const double square = normal.squaredNorm();
  SkinPoint out{triangle, {1.0 / 3, 1.0 / 3, 1.0 / 3}};
  if (!(square > 0)) return out;
  const double w1 = std::max(0.0, normal.dot(way.cross(v)) / square), w2 = std::max(0.0, normal.dot(u.cross(way)) / square),
               w0 = std::max(0.0, 1 - w1 - w2), sum = w0 + w1 + w2;
  out.weight = {w0 / sum, w1 / sum, w2 / sum};
  return out;
}

}  // namespace spheretree::runtime
