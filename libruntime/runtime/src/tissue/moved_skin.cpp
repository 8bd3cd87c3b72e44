// SPDX-License-Identifier: Apache-2.0
#include "tissue/moved_skin.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "spheretree/core/float_vector.h"

namespace spheretree::runtime {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr float kFaceShare = 0.5f;  // of the bend of an edge: by its face, not by the normals of its ends
constexpr float kMaxBend =
    1.0f / 8;  // of a side's length: largest bulge beyond that at rest; the normals at its ends then differ by a radian

// Inverts a list of lists of indices.
void invert(const std::vector<std::uint32_t>& begin, const std::vector<std::uint32_t>& members, std::size_t count,
            std::vector<std::uint32_t>& out_begin, std::vector<std::uint32_t>& out) {
  out_begin.assign(count + 1, 0);
  for (const std::uint32_t m : members)
    if (m != kNone) ++out_begin[m + 1];
  for (std::size_t i = 0; i < count; ++i) out_begin[i + 1] += out_begin[i];
  out.resize(out_begin.back());
  std::vector<std::uint32_t> next = out_begin;
  for (std::uint32_t list = 0; list + 1 < begin.size(); ++list)
    for (std::uint32_t i = begin[list]; i < begin[list + 1]; ++i)
      if (members[i] != kNone) out[next[members[i]]++] = list;
}

// The largest value of MovedSkin::bulgeOf(), however the tissue is bent.
float bulgeBound(const SoftModel::Node& v) {
  float sum = 0;
  for (std::size_t k = 0; k < 3; ++k) sum += 4 * v.point.weight[k] * v.point.weight[(k + 1) % 3] * kMaxBend * v.sides[k].length;
  return sum;
}

// The farthest that the patches beside an edge swing out of their flat triangles, however it is bent.
float swingBound(const SoftModel::Edge& edge) {
  return edge.is_sharp ? 0 : kSwingOfOffset * (lengthOf(edge.rest.position) + kMaxBend * edge.side.length);
}

}  // namespace

// The smallest rotation that maps one direction to another.
class MovedSkin::Turn {
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

MovedSkin::MovedSkin(const SoftModel& model, const CompiledShape& shape)
    : model_(model),
      shape_(shape),
      skin_(model.tree->skin),
      offset_((Vector3d(model.tree->origin_mm.data()) - shape.centre).cast<float>()),
      rest_allowance_(shape.skin.tolerance),
      parents_(shape.skin.tree.bound.size(), kNoItem),
      put_shift_(3 * model.node_count),
      block_marked_(shape.skin.tree.bound.size(), 0),
      vertices_(model.vertices.size()),
      middles_(model.edges.size()),
      fans_(model.fans.size()),
      patch_states_(shape.skin.patch.size()),
      node_places_(model.node_places),
      points_(kPointSets * kPointWays) {
  for (const SoftModel::Edge& e : model.edges) largest_swing_ = std::max(largest_swing_, swingBound(e));
  const CompiledTree& tree = shape.skin.tree;
  rest_ = tree.bound;
  block_begin_.push_back(0);
  for (std::size_t b = 0; b < tree.bound.size(); ++b) {
    std::vector<std::uint32_t> nodes;
    for (std::size_t slot = 8 * b; slot < 8 * b + 8; ++slot) {
      if (slot % 8 < tree.links[b].inner) parents_[tree.links[b].first_child + slot % 8] = static_cast<std::uint32_t>(slot);
      if (tree.item[slot] == kNoItem) continue;
      const SkinTriangle& triangle = skin_.triangles[tree.item[slot]];
      float bulge = 0, swing = 0;
      for (const std::uint32_t v : triangle.vertex) {
        bulge = std::max(bulge, bulgeBound(model.vertices[v]));
        for (std::size_t k = 0; k < 3; ++k)
          if (const PressPoint& point = model.vertices[v].point; point.weight[k] > 0) nodes.push_back(point.node[k]);
      }
      for (const std::uint32_t e : triangle.edge) swing = std::max(swing, swingBound(model.edges[e]));
      rest_[b].r[slot % 8] += rest_allowance_ + bulge + swing;
    }
    std::sort(nodes.begin(), nodes.end());
    nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
    nodes_of_.insert(nodes_of_.end(), nodes.begin(), nodes.end());
    block_begin_.push_back(static_cast<std::uint32_t>(nodes_of_.size()));
  }
  invert(block_begin_, nodes_of_, model.node_count, node_begin_, blocks_of_);
  reset();
}

void MovedSkin::reset() {
  std::fill(put_shift_.begin(), put_shift_.end(), 0.0f);
  bend(put_shift_);
  patches_ = shape_.skin.patch;
  bound_ = rest_;
  std::fill(block_marked_.begin(), block_marked_.end(), 1);
  encloseBlocks();
  beginStep();
}

void MovedSkin::bend(std::span<const float> shift) {
  for (std::size_t i = 0; i < model_.node_count; ++i)
    node_places_[i] = model_.node_places[i] + Eigen::Map<const Vector3f>(shift.data() + 3 * i);
  ++bends_;
  allowance_ = rest_allowance_;
  forget();
}

const Vector3f& MovedSkin::fanNormal(std::uint32_t fan) {
  Fan& out = fans_[fan];
  if (out.bend == bends_) return out.normal;
  out.bend = bends_;
  const Vector3f sum = normalOf(model_, model_.fans[fan], node_places_);
  const float square = squareOf(sum);
  out.normal = square > 0 ? Vector3f(sum / std::sqrt(square)) : model_.fans[fan].normal;
  return out.normal;
}

MovedSkin::Turn MovedSkin::bendNode(const SoftModel::Node& model, Bent& out) {
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

const MovedSkin::Vertex& MovedSkin::bentVertex(std::uint32_t v) {
  Vertex& out = vertices_[v];
  if (out.bend != bends_) bendNode(model_.vertices[v], out);
  return out;
}

// A face of the tetrahedra that was bent is not flat: between its nodes it bulges out according to their normals.
float MovedSkin::bulgeOf(const SoftModel::Node& v) const {
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
const MovedSkin::Middle& MovedSkin::bentMiddle(std::uint32_t e) {
  Middle& out = middles_[e];
  if (out.bend == bends_) return out;
  const SoftModel::Edge& edge = model_.edges[e];
  const Turn turn = bendNode(edge, out);
  out.offset.setZero();
  if (edge.is_sharp) return out;
  const Vertex &from = bentVertex(edge.end[0]), &to = bentVertex(edge.end[1]);
  const Vector3f sag = edge.sag + (out.moved + out.bulge) - 0.5f * (from.moved + from.bulge + to.moved + to.bulge);
  const Vector3f chord = edge.chord + (to.moved - from.moved);
  const float by_face = dotOf(out.normal, sag - turn(edge.sag)), by_normals = bendOf(chord, from.normal, to.normal) - edge.side.bend,
              largest = kMaxBend * edge.side.length,
              bend = std::clamp(kFaceShare * by_face + (1 - kFaceShare) * by_normals, -largest, largest);
  out.offset = turn(edge.rest.position) + bend * out.normal;
  return out;
}

const Vector3f& MovedSkin::placeOf(std::uint32_t v, std::span<const float> shift) {
  Vertex& out = vertices_[v];
  if (out.version == version_) return out.place;
  out.version = version_;
  const SoftModel::Vertex& model = model_.vertices[v];
  out.place = model.rest.position + offset_ + model.point.displacementIn(shift).cast<float>() + bentVertex(v).bulge;
  return out.place;
}

// What stays within a step: the normals, and how far the patch swings out of its flat triangle.
void MovedSkin::bendPatch(std::uint32_t t) {
  const SkinTriangle& triangle = skin_.triangles[t];
  CompiledPatch& out = patches_[t];
  const Vector3f& first = bentVertex(triangle.vertex[0]).normal;
  float swing2 = 0, turn2 = 0;
  out.flags = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vertex& corner = bentVertex(triangle.vertex[k]);
    const Middle& middle = bentMiddle(triangle.edge[k]);
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
  if (state.version == version_) return;
  state.version = version_;
  if (state.bend != bends_) bendPatch(t);
  state.bend = bends_;
  const SkinTriangle& triangle = skin_.triangles[t];
  SkinPatch patch;
  for (std::size_t k = 0; k < 3; ++k) {
    patch.position[k] = placeOf(triangle.vertex[k], shift);
    patch.normal[k] = vertices_[triangle.vertex[k]].normal;
    patch.normal[3 + k] = middles_[triangle.edge[k]].normal;
  }
  for (std::size_t k = 0; k < 3; ++k)
    patch.position[3 + k] = 0.5f * (patch.position[k] + patch.position[(k + 1) % 3]) + middles_[triangle.edge[k]].offset;
  CompiledPatch& out = patches_[t];
  for (std::size_t k = 0; k < 6; ++k) Eigen::Map<Vector3f>(out.position[k]) = patch.position[k];
  const std::uint32_t stay = out.flags & ((1u << kSwingShift) - 1);
  out.flags = stay | swingBits(state.swing / allowance_) | leanBits(leanOf(patch));
}

void MovedSkin::putTriangles(std::span<const std::uint32_t> pairs, std::span<const float> shift) {
  for (const std::uint32_t pair : pairs) {
    const std::uint32_t t = shape_.skin.tree.item[pair & 0xffff];
    if (patch_states_[t].corners_version == version_) continue;
    patch_states_[t].corners_version = version_;
    for (std::size_t k = 0; k < 3; ++k) Eigen::Map<Vector3f>(patches_[t].position[k]) = placeOf(skin_.triangles[t].vertex[k], shift);
  }
}

void MovedSkin::put(std::span<const std::uint32_t> pairs, std::span<const float> shift) {
  for (const std::uint32_t pair : pairs)
    if (const std::uint32_t t = shape_.skin.tree.item[pair & 0xffff]; t != kNoItem) putPatch(t, shift);
}

void MovedSkin::refit(std::span<const float> shift) {
  bool any = false;
  for (std::uint32_t node = 0; node < model_.node_count; ++node) {
    const float* const now = shift.data() + 3 * node;
    float* const was = put_shift_.data() + 3 * node;
    const float x = now[0] - was[0], y = now[1] - was[1], z = now[2] - was[2];
    if (!(x * x + y * y + z * z > static_cast<float>(kRefitMm * kRefitMm))) continue;
    std::copy_n(now, 3, was);
    for (std::uint32_t i = node_begin_[node]; i < node_begin_[node + 1]; ++i) block_marked_[blocks_of_[i]] = 1;
    any = true;
  }
  if (any) encloseBlocks();
}

// A point of a triangle moves by a weighted mean of the displacements of the nodes that move the block. None of these
// is farther from the centre of their bounding box than half of its diagonal.
void MovedSkin::shiftBlock(std::size_t b) {
  Eigen::Array3f low = Eigen::Array3f::Constant(std::numeric_limits<float>::infinity()), high = -low;
  for (std::uint32_t i = block_begin_[b]; i < block_begin_[b + 1]; ++i) {
    Eigen::Array3f u = Eigen::Array3f::Zero();
    if (nodes_of_[i] != kNone) u = Eigen::Map<const Eigen::Array3f>(put_shift_.data() + 3 * std::size_t{nodes_of_[i]});
    low = low.min(u), high = high.max(u);
  }
  const Eigen::Array3f middle = 0.5f * (low + high);
  const float more = lengthOf((high - middle).matrix());
  const Block& rest = rest_[b];
  Block& block = bound_[b];
  for (std::size_t lane = shape_.skin.tree.links[b].inner; lane < 8; ++lane) {
    if (rest.x[lane] == kFarAway) continue;
    block.x[lane] = rest.x[lane] + middle.x();
    block.y[lane] = rest.y[lane] + middle.y();
    block.z[lane] = rest.z[lane] + middle.z();
    block.r[lane] = (rest.r[lane] + more) * (1 + 1e-6f);
  }
}

// Encloses everything below inner nodes in balls; the blocks of children follow that of their parent.
void MovedSkin::encloseBlocks() {
  for (std::size_t b = bound_.size(); b-- > 1;) {
    if (!block_marked_[b]) continue;
    block_marked_[b] = 0;
    if (block_begin_[b + 1] > block_begin_[b]) shiftBlock(b);
    const Block& block = bound_[b];
    Eigen::Array3f low = Eigen::Array3f::Constant(std::numeric_limits<float>::infinity()), high = -low;
    for (std::size_t lane = 0; lane < 8; ++lane) {
      if (block.x[lane] == kFarAway) continue;
      const Eigen::Array3f c(block.x[lane], block.y[lane], block.z[lane]);
      low = low.min(c), high = high.max(c);
    }
    const Vector3d centre = (0.5f * (low + high)).matrix().cast<double>();
    double radius = 0;
    for (std::size_t lane = 0; lane < 8; ++lane)
      if (block.x[lane] != kFarAway)
        radius =
            std::max(radius, (Vector3d(block.x[lane], block.y[lane], block.z[lane]) - centre).norm() + static_cast<double>(block.r[lane]));
    const std::uint32_t parent = parents_[b];
    runtime::put(bound_[parent / 8], parent % 8, centre, static_cast<float>(radius * (1 + 1e-6)));
    block_marked_[parent / 8] = 1;
  }
  block_marked_[0] = 0;
  const Block& root = bound_[0];
  radius_ = std::max(shape_.radius, Vector3d(root.x[0], root.y[0], root.z[0]).norm() + static_cast<double>(root.r[0]));
}

}  // namespace spheretree::runtime
