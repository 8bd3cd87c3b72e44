// SPDX-License-Identifier: Apache-2.0
#include "tissue/bent_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "spheretree/core/float_vector.h"

namespace spheretree::runtime {
namespace {

using Eigen::Vector3f;

constexpr float kFaceShare = 0.5f;  // of the bend of an edge: by its face, not by the normals of its ends
constexpr float kMaxBend =
    1.0f / 8;  // of a side's length: largest bulge beyond that at rest; the normals at its ends then differ by a radian

}  // namespace

float bulgeBound(const SoftModel::Node& v) {
  float sum = 0;
  for (std::size_t k = 0; k < 3; ++k) sum += 4 * v.point.weight[k] * v.point.weight[(k + 1) % 3] * kMaxBend * v.sides[k].length;
  return sum;
}

float swingBound(const SoftModel::Edge& edge) {
  return edge.is_sharp ? 0 : kSwingOfOffset * (lengthOf(edge.rest.position) + kMaxBend * edge.side.length);
}

// The smallest rotation that maps one direction to another.
class BentSurface::Turn {
 public:
  Turn(const Vector3f& from, const Vector3f& to) {
    const float scale = squareOf(from) * squareOf(to);
    if (!(scale > 0)) return;
    const float inverse = 1 / std::sqrt(scale), cosine = inverse * dotOf(from, to);
    if (cosine < -0.99f) return;
    axis_ = inverse * from.cross(to);
    share_ = 1 / (1 + cosine);
  }
  Vector3f operator()(const Vector3f& v) const {
    const Vector3f across = axis_.cross(v);
    return v + across + share_ * axis_.cross(across);
  }

 private:
  Vector3f axis_{0, 0, 0};  // times the sine of the angle
  float share_ = 0;
};

BentSurface::BentSurface(const SoftModel& model, const Vector3f& offset)
    : model_(model),
      offset_(offset),
      vertices_(model.vertices.size()),
      middles_(model.edges.size()),
      fans_(model.fans.size()),
      node_places_(model.node_places) {}

void BentSurface::bend(std::span<const float> shift) {
  for (std::size_t i = 0; i < model_.node_count; ++i)
    node_places_[i] = model_.node_places[i] + Eigen::Map<const Vector3f>(shift.data() + 3 * i);
  ++bends_, ++version_;
}

void BentSurface::reset() {
  node_places_ = model_.node_places;
  ++bends_, ++version_;
}

const Vector3f& BentSurface::fanNormal(std::uint32_t fan) {
  Fan& out = fans_[fan];
  if (out.bend == bends_) return out.normal;
  out.bend = bends_;
  const Vector3f sum = normalOf(model_, model_.fans[fan], node_places_);
  const float square = squareOf(sum);
  out.normal = square > 0 ? Vector3f(sum / std::sqrt(square)) : model_.fans[fan].normal;
  return out.normal;
}

BentSurface::Turn BentSurface::bendNode(const SoftModel::Node& model, Bent& out) {
  out.bend = bends_;
  out.moved.setZero();
  Vector3f node_normal = Vector3f::Zero();
  for (std::size_t k = 0; k < 3; ++k) {
    const float weight = model.point.weight[k];
    const std::uint32_t node = model.point.node[k];
    node_normal += weight * (node == kNone ? model.rest.normal : fanNormal(model.fans[k]));
    if (node != kNone) out.moved += weight * (node_places_[node] - model_.node_places[node]);
  }
  const Turn turn(model.normal, node_normal);
  out.normal = turn(model.rest.normal);
  out.packed = packed(out.normal);
  out.bulge = bulgeOf(model) * out.normal;
  return turn;
}

const BentSurface::Vertex& BentSurface::vertex(std::uint32_t v) {
  Vertex& out = vertices_[v];
  if (out.bend != bends_) bendNode(model_.vertices[v], out);
  return out;
}

// A face of the tetrahedra that was bent is not flat: between its nodes it bulges out according to their normals.
float BentSurface::bulgeOf(const SoftModel::Node& v) const {
  float sum = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t next = (k + 1) % 3;
    const std::uint32_t a = v.point.node[k], b = v.point.node[next];
    const float both = 4 * v.point.weight[k] * v.point.weight[next];
    if (a == kNone || b == kNone || !(both > 0)) continue;
    const float largest = kMaxBend * v.sides[k].length,
                bend = bendOf(node_places_[b] - node_places_[a], fans_[v.fans[k]].normal, fans_[v.fans[next]].normal) - v.sides[k].bend;
    sum += both * std::clamp(bend, -largest, largest);
  }
  return sum;
}

// The middle of an edge bends by the normals of the ends, as in a rigid skin, and it rises and falls with its face, as
// the ends do. Normals alone keep the surface smooth, but are averages over more than a narrow dent; faces alone follow
// the dent, but have creases between them in which a tool catches.
const BentSurface::Middle& BentSurface::middle(std::uint32_t e) {
  Middle& out = middles_[e];
  if (out.bend == bends_) return out;
  const SoftModel::Edge& edge = model_.edges[e];
  const Turn turn = bendNode(edge, out);
  out.offset.setZero();
  if (edge.is_sharp) return out;
  const Vertex &from = vertex(edge.end[0]), &to = vertex(edge.end[1]);
  const Vector3f sag = edge.sag + (out.moved + out.bulge) - 0.5f * (from.moved + from.bulge + to.moved + to.bulge);
  const Vector3f chord = edge.chord + (to.moved - from.moved);
  const float by_face = dotOf(out.normal, sag - turn(edge.sag)), by_normals = bendOf(chord, from.normal, to.normal) - edge.side.bend,
              largest = kMaxBend * edge.side.length,
              bend = std::clamp(kFaceShare * by_face + (1 - kFaceShare) * by_normals, -largest, largest);
  out.offset = turn(edge.rest.position) + bend * out.normal;
  return out;
}

const Vector3f& BentSurface::placeOf(std::uint32_t v, std::span<const float> shift) {
  Vertex& out = vertices_[v];
  if (out.version == version_) return out.place;
  out.version = version_;
  const SoftModel::Vertex& model = model_.vertices[v];
  out.place = model.rest.position + offset_ + model.point.displacementIn(shift).cast<float>() + vertex(v).bulge;
  return out.place;
}

}  // namespace spheretree::runtime
