// SPDX-License-Identifier: Apache-2.0
#include "tissue/soft_model.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "spheretree/core/float_vector.h"

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
    if (point.node[k] == kNone)
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
  std::vector<std::uint32_t> index(tissue.nodes.size(), kNone);
  const auto add = [&](std::uint32_t node) {
    index[node] = static_cast<std::uint32_t>(out.node_places.size());
    out.node_places.push_back(vectorOf(tissue.nodes[node]).cast<float>());
  };
  for (const std::uint32_t node : pressed) add(node);
  for (const std::array<std::uint32_t, 3>& corners : outerFaces(tissue)) {
    for (const std::uint32_t node : corners)
      if (index[node] == kNone) add(node);
    out.faces.push_back({index[corners[0]], index[corners[1]], index[corners[2]]});
  }
}

using Face = std::array<std::uint32_t, 3>;

Vector3f unit(const Vector3f& v) {
  const float square = squareOf(v);
  return square > 0 ? Vector3f(v / std::sqrt(square)) : v;
}

Vector3f flatNormal(const SoftModel& model, const Face& face) {
  const auto place = [&](std::size_t k) { return model.node_places[face[k]]; };
  return unit((place(1) - place(0)).cross(place(2) - place(0)));
}

bool shareASide(const Face& a, const Face& b) {
  std::ptrdiff_t shared = 0;
  for (const std::uint32_t node : a) shared += std::count(b.begin(), b.end(), node);
  return shared >= 2;
}

// The faces around each node, from one to the next across sides that are not sharp.
void addFans(float crease_angle, SoftModel& out) {
  std::vector<std::vector<std::uint32_t>> round(out.node_count);
  for (std::uint32_t f = 0; f < out.faces.size(); ++f)
    for (const std::uint32_t node : out.faces[f])
      if (node < out.node_count) round[node].push_back(f);
  const float min_cosine = std::cos(crease_angle);
  for (std::uint32_t node = 0; node < out.node_count; ++node) {
    std::vector<std::uint32_t>& left = round[node];
    while (!left.empty()) {
      std::vector<std::uint32_t> faces = {left.front()};
      left.erase(left.begin());
      for (std::size_t i = 0; i < faces.size(); ++i)
        for (std::size_t k = 0; k < left.size();) {
          const Face &a = out.faces[faces[i]], &b = out.faces[left[k]];
          const bool goes_on = shareASide(a, b) && dotOf(flatNormal(out, a), flatNormal(out, b)) >= min_cosine;
          if (goes_on) faces.push_back(left[k]), left.erase(left.begin() + static_cast<std::ptrdiff_t>(k));
          k += !goes_on;
        }
      out.fans.push_back({node, static_cast<std::uint32_t>(out.fan_sides.size()), static_cast<std::uint32_t>(faces.size())});
      for (const std::uint32_t f : faces) {
        const Face& face = out.faces[f];
        const auto own = static_cast<std::size_t>(std::find(face.begin(), face.end(), node) - face.begin());
        out.fan_sides.push_back({face[(own + 1) % 3], face[(own + 2) % 3]});
      }
    }
  }
  for (SoftModel::Fan& fan : out.fans) fan.normal = unit(normalOf(out, fan, out.node_places));
}

// Chooses, at each node of a vertex, the fan whose normal is nearest to that of the vertex.
void chooseFans(SoftModel& out) {
  std::vector<std::uint32_t> first(out.node_count + 1, 0);
  for (const SoftModel::Fan& fan : out.fans) ++first[fan.node + 1];
  for (std::size_t i = 0; i < out.node_count; ++i) first[i + 1] += first[i];
  const auto choose = [&](SoftModel::Node& vertex) {
    const Vector3f& own = vertex.rest.normal;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t node = vertex.point.node[k];
      vertex.fans[k] = kNone;
      if (node != kNone) {
        vertex.fans[k] = first[node];
        for (std::uint32_t fan = first[node]; fan < first[node + 1]; ++fan)
          if (dotOf(out.fans[fan].normal, own) > dotOf(out.fans[vertex.fans[k]].normal, own)) vertex.fans[k] = fan;
      }
      vertex.normal += vertex.point.weight[k] * (node == kNone ? own : out.fans[vertex.fans[k]].normal);
    }
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t from = vertex.fans[k], to = vertex.fans[(k + 1) % 3];
      if (from == kNone || to == kNone) continue;
      const Vector3f chord = out.node_places[out.fans[to].node] - out.node_places[out.fans[from].node];
      vertex.sides[k] = {lengthOf(chord), bendOf(chord, out.fans[from].normal, out.fans[to].normal)};
    }
  };
  for (SoftModel::Vertex& vertex : out.vertices) choose(vertex);
  for (SoftModel::Edge& edge : out.edges) choose(edge);
}

// The place of a point at rest. False if it hangs on held nodes.
bool placeOf(const PressPoint& point, const SoftModel& model, Vector3f& out) {
  out.setZero();
  for (std::size_t k = 0; k < 3; ++k) {
    if (point.node[k] == kNone && point.weight[k] > 0) return false;
    if (point.node[k] != kNone) out += point.weight[k] * model.node_places[point.node[k]];
  }
  return true;
}

void addSkin(const Skin& skin, const Tissue& tissue, SoftModel& out) {
  const SkinNodes nodes(skin);
  const std::vector<PressPoint>& points = tissue.response.points;
  for (std::size_t v = 0; v < skin.vertices.size(); ++v)
    out.vertices.push_back({{points[v], nodes.ofVertices()[v], {}, {}}, maxGiveOf(tissue, points[v])});
  for (std::size_t e = 0; e < skin.edges.size(); ++e)
    out.edges.push_back({{points[skin.vertices.size() + e], nodes.ofEdges()[e], {}, {}}, {}, skin.edges[e].is_sharp != 0, {}});
  for (std::size_t t = skin.triangles.size(); t-- > 0;)  // an edge takes its ends from the first triangle that has it
    for (std::size_t k = 0; k < 3; ++k)
      out.edges[skin.triangles[t].edge[k]].end = {skin.triangles[t].vertex[k], skin.triangles[t].vertex[(k + 1) % 3]};
  for (SoftModel::Edge& edge : out.edges) {
    const SoftModel::Vertex &from = out.vertices[edge.end[0]], &to = out.vertices[edge.end[1]];
    edge.chord = to.rest.position - from.rest.position;
    edge.side = {lengthOf(edge.chord), bendOf(edge.chord, from.rest.normal, to.rest.normal)};
    Vector3f start, end, middle;
    if (placeOf(from.point, out, start) && placeOf(to.point, out, end) && placeOf(edge.point, out, middle))
      edge.sag = middle - 0.5f * (start + end);
  }
}

}  // namespace

// If the nodes lie on a sphere, this is its normal, for any shapes of the faces.
// Paper: N. Max. Weights for computing vertex normals from facet normals. Journal of Graphics Tools 4(2), 1999.
Vector3f normalOf(const SoftModel& model, const SoftModel::Fan& fan, std::span<const Vector3f> places) {
  Vector3f sum = Vector3f::Zero();
  for (std::uint32_t i = fan.first; i < fan.first + fan.count; ++i) {
    const auto& [from, to] = model.fan_sides[i];
    const Vector3f a = places[from] - places[fan.node], b = places[to] - places[fan.node];
    const float squares = squareOf(a) * squareOf(b);
    if (squares > 0) sum += a.cross(b) / squares;
  }
  return sum;
}

// On a circle of radius R the normals at the ends of a chord of length l differ by the angle l / R, and the middle of
// the arc is l^2 / (8 R) away from the chord.
float bendOf(const Vector3f& chord, const Vector3f& from_normal, const Vector3f& to_normal) {
  return 0.125f * dotOf(chord, to_normal - from_normal);
}

std::shared_ptr<SoftModel> softModel(const SharedTree& tree, std::shared_ptr<const Tissue> tissue) {
  auto out = std::make_shared<SoftModel>();
  const TissueResponse& response = tissue->response;
  out->node_count = response.pressed.size();
  out->matrix = response.matrix;
  addFaces(*tissue, *out);
  addSkin(tree->skin, *tissue, *out);
  addFans(tree->skin.crease_angle, *out);
  chooseFans(*out);
  out->tree = tree;
  out->bytes = out->vertices.size() * sizeof(SoftModel::Vertex) + out->edges.size() * sizeof(SoftModel::Edge) +
               out->matrix.size() * sizeof(float) + (out->faces.size() + out->fan_sides.size()) * sizeof(Face) +
               out->fans.size() * sizeof(SoftModel::Fan);
  out->tissue = std::move(tissue);
  return out;
}

}  // namespace spheretree::runtime
