// SPDX-License-Identifier: Apache-2.0
#include "soft_model.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace spheretree::runtime {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr double kMaxShare = 0.5;  // share of the distance to the nearest fixed node: limit of the displacement

Vector3d vectorOf(const std::array<double, 3>& p) { return {p[0], p[1], p[2]}; }

// kMaxShare of the distance from a point to the nearest fixed node.
float maxGiveOf(const Tissue& tissue, const PressPoint& point) {
  Vector3d at = Vector3d::Zero();
  double held = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    if (point.node[k] == kHeldNode)
      held += static_cast<double>(point.weight[k]);
    else
      at += static_cast<double>(point.weight[k]) * vectorOf(tissue.nodes[tissue.response.pressed[point.node[k]]]);
  }
  if (held > 0.999) return 0;
  at /= 1 - held;
  double nearest = std::numeric_limits<double>::infinity();
  for (const std::uint32_t node : tissue.fixed) nearest = std::min(nearest, (vectorOf(tissue.nodes[node]) - at).norm());
  return static_cast<float>(std::min(kMaxShare * nearest, 1e6));
}

void addFaces(const Tissue& tissue, SoftModel& out) {
  const std::vector<std::uint32_t>& pressed = tissue.response.pressed;
  for (const std::uint32_t node : pressed) out.node_places.push_back(vectorOf(tissue.nodes[node]).cast<float>());
  for (const std::array<std::uint32_t, 3>& corners : outerFaces(tissue)) {
    SoftModel::Face& face = out.faces.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) {
      const auto found = std::lower_bound(pressed.begin(), pressed.end(), corners[k]);
      face.node[k] = found != pressed.end() && *found == corners[k] ? static_cast<std::uint32_t>(found - pressed.begin()) : kHeldNode;
      face.rest[k] = vectorOf(tissue.nodes[corners[k]]).cast<float>();
    }
  }
}

Vector3f flatNormal(const SoftModel::Face& face) { return (face.rest[1] - face.rest[0]).cross(face.rest[2] - face.rest[0]).normalized(); }

bool shareASide(const SoftModel::Face& a, const SoftModel::Face& b) {
  std::size_t shared = 0;
  for (const Vector3f& p : a.rest) shared += static_cast<std::size_t>(std::count(b.rest.begin(), b.rest.end(), p));
  return shared >= 2;
}

// The faces around each node, from one to the next across sides that are not sharp.
void addFans(float crease_angle, SoftModel& out) {
  std::vector<std::vector<std::uint32_t>> round(out.node_count);
  for (std::uint32_t f = 0; f < out.faces.size(); ++f)
    for (const std::uint32_t node : out.faces[f].node)
      if (node != kHeldNode) round[node].push_back(f);
  const float min_cosine = std::cos(crease_angle);
  for (std::uint32_t node = 0; node < out.node_count; ++node) {
    std::vector<std::uint32_t>& left = round[node];
    while (!left.empty()) {
      SoftModel::Fan& fan = out.fans.emplace_back();
      fan.node = node;
      fan.faces = {left.front()};
      left.erase(left.begin());
      for (std::size_t i = 0; i < fan.faces.size(); ++i)
        for (std::size_t k = 0; k < left.size();) {
          const SoftModel::Face &a = out.faces[fan.faces[i]], &b = out.faces[left[k]];
          const bool goes_on = shareASide(a, b) && flatNormal(a).dot(flatNormal(b)) >= min_cosine;
          if (goes_on) fan.faces.push_back(left[k]), left.erase(left.begin() + static_cast<std::ptrdiff_t>(k));
          k += !goes_on;
        }
    }
  }
  const std::vector<float> rest(3 * out.node_count, 0.0f);
  for (SoftModel::Fan& fan : out.fans) fan.normal = normalOf(out, fan, rest).normalized();
}

// Chooses, at each node of a vertex, the fan whose normal is nearest to that of the vertex.
void chooseFans(SoftModel& out) {
  std::vector<std::uint32_t> first(out.node_count + 1, 0);
  for (const SoftModel::Fan& fan : out.fans) ++first[fan.node + 1];
  for (std::size_t i = 0; i < out.node_count; ++i) first[i + 1] += first[i];
  for (std::size_t v = 0; v < out.points.size(); ++v) {
    const Vector3f& own = out.vertices[v].normal;
    std::array<std::uint32_t, 3>& chosen = out.vertex_fans.emplace_back();
    Vector3f normal = Vector3f::Zero();
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t node = out.points[v].node[k];
      chosen[k] = kHeldNode;
      if (node != kHeldNode) {
        chosen[k] = first[node];
        for (std::uint32_t fan = first[node]; fan < first[node + 1]; ++fan)
          if (out.fans[fan].normal.dot(own) > out.fans[chosen[k]].normal.dot(own)) chosen[k] = fan;
      }
      normal += out.points[v].weight[k] * (node == kHeldNode ? own : out.fans[chosen[k]].normal);
    }
    out.vertex_normals.push_back(normal);
  }
}

void addSkin(const Skin& skin, SoftModel& out) {
  const SkinNodes nodes(skin);
  out.vertices.assign(nodes.ofVertices().begin(), nodes.ofVertices().end());
  out.edge_middles.assign(nodes.ofEdges().begin(), nodes.ofEdges().end());
  out.edges.resize(skin.edges.size());
  for (std::size_t t = skin.triangles.size(); t-- > 0;)  // an edge takes its ends from the first triangle that has it
    for (std::size_t k = 0; k < 3; ++k)
      out.edges[skin.triangles[t].edge[k]].end = {skin.triangles[t].vertex[k], skin.triangles[t].vertex[(k + 1) % 3]};
  for (SoftModel::Edge& edge : out.edges) {
    const SkinNode &from = out.vertices[edge.end[0]], &to = out.vertices[edge.end[1]];
    edge.bend = bendOf(to.position - from.position, from.normal, to.normal);
  }
}

}  // namespace

// If the nodes lie on a sphere, this is its normal, for any shapes of the faces.
// Paper: N. Max. Weights for computing vertex normals from facet normals. Journal of Graphics Tools 4(2), 1999.
Vector3f normalOf(const SoftModel& model, const SoftModel::Fan& fan, std::span<const float> shift) {
  Vector3f sum = Vector3f::Zero();
  for (const std::uint32_t f : fan.faces) {
    const SoftModel::Face& face = model.faces[f];
    std::array<Vector3f, 3> p = face.rest;
    std::size_t own = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      if (face.node[k] == kHeldNode) continue;
      if (face.node[k] == fan.node) own = k;
      const float* const u = shift.data() + 3 * std::size_t{face.node[k]};
      p[k] += Vector3f(u[0], u[1], u[2]);
    }
    const Vector3f a = p[(own + 1) % 3] - p[own], b = p[(own + 2) % 3] - p[own];
    const float squares = a.squaredNorm() * b.squaredNorm();
    if (squares > 0) sum += a.cross(b) / squares;
  }
  return sum;
}

// On a circle of radius R the normals at the ends of a chord of length l differ by the angle l / R, and the middle of
// the arc is l^2 / (8 R) away from the chord.
float bendOf(const Vector3f& chord, const Vector3f& from_normal, const Vector3f& to_normal) {
  return 0.125f * chord.dot(to_normal - from_normal);
}

std::shared_ptr<SoftModel> softModel(const SharedTree& tree, std::shared_ptr<const Tissue> tissue) {
  auto out = std::make_shared<SoftModel>();
  const TissueResponse& response = tissue->response;
  out->node_count = response.pressed.size();
  out->points = response.points;
  out->matrix = response.matrix;
  for (const PressPoint& point : response.points) out->max_give.push_back(maxGiveOf(*tissue, point));
  addFaces(*tissue, *out);
  addSkin(tree->skin, *out);
  addFans(tree->skin.crease_angle, *out);
  chooseFans(*out);
  out->tree = tree;
  out->bytes = out->points.size() * (sizeof(PressPoint) + sizeof(float) + sizeof(SkinNode) + sizeof(Vector3f) + 12) +
               out->matrix.size() * sizeof(float) + out->edges.size() * (sizeof(SoftModel::Edge) + sizeof(SkinNode)) +
               out->faces.size() * (sizeof(SoftModel::Face) + 3 * sizeof(std::uint32_t)) + out->fans.size() * sizeof(SoftModel::Fan);
  out->tissue = std::move(tissue);
  return out;
}

}  // namespace spheretree::runtime
