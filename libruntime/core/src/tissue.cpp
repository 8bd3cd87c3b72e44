// SPDX-License-Identifier: Apache-2.0
#include "spheretree/core/tissue.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "describe.h"
#include "sphere_checks.h"
#include "spheretree/core/rounding.h"

namespace spheretree {
namespace {

using Eigen::Vector3d;

Vector3d vectorOf(const std::array<double, 3>& p) { return {p[0], p[1], p[2]}; }

bool isFinite(const std::array<double, 3>& p) { return std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]); }

std::string findNodeFault(const Tissue& tissue) {
  if (tissue.nodes.size() < 4 || tissue.nodes.size() > kMaxTissueNodes)
    return describe("there are %zu nodes, not 4 to %u", tissue.nodes.size(), kMaxTissueNodes);
  for (std::size_t i = 0; i < tissue.nodes.size(); ++i)
    if (!isFinite(tissue.nodes[i])) return describe("node %zu is not finite", i);
  for (std::size_t i = 0; i < tissue.fixed.size(); ++i) {
    if (tissue.fixed[i] >= tissue.nodes.size()) return describe("fixed node %u does not exist", tissue.fixed[i]);
    if (i > 0 && tissue.fixed[i] <= tissue.fixed[i - 1]) return describe("fixed node %u is out of order", tissue.fixed[i]);
  }
  return {};
}

std::string findTetrahedronFault(const Tissue& tissue) {
  for (std::size_t t = 0; t < tissue.tetrahedra.size(); ++t) {
    std::array<Vector3d, 4> p;
    for (std::size_t k = 0; k < 4; ++k) {
      const std::uint32_t node = tissue.tetrahedra[t][k];
      if (node >= tissue.nodes.size()) return describe("tetrahedron %zu names node %u, which does not exist", t, node);
      p[k] = vectorOf(tissue.nodes[node]);
    }
    const double volume6 = (p[1] - p[0]).cross(p[2] - p[0]).dot(p[3] - p[0]);
    if (!(volume6 > 0)) return describe("tetrahedron %zu has the volume %g mm^3, which is not positive", t, volume6 / 6);
  }
  return {};
}

std::string findLeafFault(const Tissue& tissue) {
  const TissueLeaves& leaves = tissue.leaves;
  const auto isTriangle = [&](const std::array<std::uint32_t, 3>& vertex) {
    return std::all_of(vertex.begin(), vertex.end(), [&](std::uint32_t v) { return v < tissue.surface.size(); });
  };
  for (std::size_t i = 0; i < leaves.cuts.size(); ++i)
    if (!isTriangle(leaves.cuts[i].vertex) || !std::isfinite(leaves.cuts[i].weight[0]) || !std::isfinite(leaves.cuts[i].weight[1]) ||
        leaves.cuts[i].reserved != 0)
      return describe("cut %zu is out of range", i);
  for (std::size_t i = 0; i < leaves.anchors.size(); ++i) {
    const LeafAnchor& anchor = leaves.anchors[i];
    const bool is_finite = std::isfinite(anchor.weight[0]) && std::isfinite(anchor.weight[1]) && std::isfinite(anchor.depth) &&
                           anchor.depth >= 0 && std::isfinite(anchor.direction[0]) && std::isfinite(anchor.direction[1]) &&
                           std::isfinite(anchor.direction[2]);
    if (!is_finite || !isTriangle(anchor.vertex) || anchor.tetrahedron >= tissue.tetrahedra.size())
      return describe("the anchor of leaf %zu is out of range", i);
  }
  if (leaves.begin.empty() && leaves.anchors.empty() && leaves.corners.empty()) return {};  // not yet computed
  if (leaves.begin.size() != leaves.anchors.size() + 1 || leaves.begin.front() != 0 || leaves.begin.back() != leaves.corners.size() ||
      !std::is_sorted(leaves.begin.begin(), leaves.begin.end()))
    return "the runs of the leaves' corners do not follow each other";
  for (std::size_t i = 0; i < leaves.corners.size(); ++i)
    if (leaves.corners[i] >= tissue.surface.size() + leaves.cuts.size()) return describe("corner %zu of the leaves does not exist", i);
  return {};
}

std::string findResponseFault(const Tissue& tissue) {
  const TissueResponse& response = tissue.response;
  const std::size_t pressed = response.pressed.size(), nodes = tissue.nodes.size();
  if ((pressed == 0 && !response.points.empty()) || response.matrix.size() != 9 * pressed * pressed)
    return "the response to forces does not have the size that its nodes give it";
  for (std::size_t i = 0; i < pressed; ++i)
    if (response.pressed[i] >= nodes || (i > 0 && response.pressed[i] <= response.pressed[i - 1]))
      return describe("pressed node %zu is out of range or out of order", i);
  for (std::size_t i = 0; i < response.points.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t node = response.points[i].node[k];
      const float weight = response.points[i].weight[k];
      if ((node >= pressed && node != kNone) || !(weight >= 0 && weight <= 1))
        return describe("the point that vertex %zu of the skin goes with is out of range", i);
    }
  if (!std::all_of(response.matrix.begin(), response.matrix.end(), [](float x) { return std::isfinite(x); }))
    return "the response to forces is not finite";
  return {};
}

Vector3d combined(const std::array<std::uint32_t, 3>& vertex, double w1, double w2, std::span<const Vector3d> positions) {
  return (1 - w1 - w2) * positions[vertex[0]] + w1 * positions[vertex[1]] + w2 * positions[vertex[2]];
}

// The cofactor matrix of the moved edges times that of the inverse edges at rest transforms a vector like a normal.
Vector3d movedCentre(const Tissue& tissue, const LeafAnchor& anchor, std::span<const Vector3d> displacements,
                     std::span<const Vector3d> positions) {
  const Vector3d point = combined(anchor.vertex, static_cast<double>(anchor.weight[0]), static_cast<double>(anchor.weight[1]), positions);
  const std::array<std::uint32_t, 4>& corner = tissue.tetrahedra[anchor.tetrahedron];
  const auto at = [&](std::size_t k) { return Vector3d(vectorOf(tissue.nodes[corner[k]]) + displacements[corner[k]]); };
  const Vector3d first = at(0), a = at(1) - first, b = at(2) - first, c = at(3) - first;
  const Vector3d direction = static_cast<double>(anchor.direction[0]) * b.cross(c) + static_cast<double>(anchor.direction[1]) * c.cross(a) +
                             static_cast<double>(anchor.direction[2]) * a.cross(b);
  const double length = direction.norm();
  if (!(length > 0)) return point;
  return point + static_cast<double>(anchor.depth) / length * direction;
}

bool sameLeaves(const TissueLeaves& a, const TissueLeaves& b) {
  const auto sameCut = [](const TissueCut& u, const TissueCut& v) { return u.vertex == v.vertex && u.weight == v.weight; };
  const auto sameAnchor = [](const LeafAnchor& u, const LeafAnchor& v) {
    return std::tie(u.vertex, u.weight, u.tetrahedron, u.direction, u.depth) ==
           std::tie(v.vertex, v.weight, v.tetrahedron, v.direction, v.depth);
  };
  return a.begin == b.begin && a.corners == b.corners && std::equal(a.cuts.begin(), a.cuts.end(), b.cuts.begin(), b.cuts.end(), sameCut) &&
         std::equal(a.anchors.begin(), a.anchors.end(), b.anchors.begin(), b.anchors.end(), sameAnchor);
}

bool sameResponse(const TissueResponse& a, const TissueResponse& b) {
  const auto same = [](const PressPoint& u, const PressPoint& v) { return u.node == v.node && u.weight == v.weight; };
  return a.pressed == b.pressed && a.matrix == b.matrix &&
         std::equal(a.points.begin(), a.points.end(), b.points.begin(), b.points.end(), same);
}

// Centred at the middle of the bounding box of the centres.
Sphere aroundAll(std::span<const Sphere> spheres) {
  Eigen::Array3d low = Eigen::Array3d::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (const Sphere& s : spheres) {
    const Eigen::Array3d c = Eigen::Array3f(s.x, s.y, s.z).cast<double>();
    low = low.min(c), high = high.max(c);
  }
  const Eigen::Vector3f centre = roundToFloat(Vector3d(0.5 * (low + high)));
  Sphere around{centre.x(), centre.y(), centre.z(), 0};
  double radius = 0;
  for (const Sphere& s : spheres) radius = std::max(radius, reach(around, s));
  around.radius =
      roundUp(radius * (1 + 0x1p-40));  // a margin for readers, which evaluate enclosure over several levels at once, with rounding
  return around;
}

void encloseItems(SearchTree& search, std::span<const Sphere> items) {
  std::size_t next_inner = search.inner.size(), next_item = search.item.empty() ? items.size() : search.item.size();
  std::vector<Sphere> below;
  for (std::size_t i = search.inner.size(); i-- > 0;) {  // children follow their parents
    next_inner -= search.inner_children[i], next_item -= search.item_children[i];
    below.assign(search.inner.begin() + static_cast<std::ptrdiff_t>(next_inner),
                 search.inner.begin() + static_cast<std::ptrdiff_t>(next_inner + search.inner_children[i]));
    for (std::size_t k = next_item; k < next_item + search.item_children[i]; ++k)
      below.push_back(items[search.item.empty() ? k : search.item[k]]);
    search.inner[i] = aroundAll(below);
  }
}

}  // namespace

bool operator==(const Tissue& a, const Tissue& b) {
  const auto same = [](const TissueVertex& u, const TissueVertex& v) {
    return u.rest == v.rest && u.tetrahedron == v.tetrahedron && u.weight == v.weight;
  };
  return a.material == b.material && a.nodes == b.nodes && a.tetrahedra == b.tetrahedra && a.fixed == b.fixed &&
         std::equal(a.surface.begin(), a.surface.end(), b.surface.begin(), b.surface.end(), same) && sameLeaves(a.leaves, b.leaves) &&
         sameResponse(a.response, b.response);
}

std::string findFault(const TissueMaterial& material) {
  if (!(material.young_kpa >= kMinYoungKpa && material.young_kpa <= kMaxYoungKpa)) {
    const char* hint =
        material.young_kpa > kMaxYoungKpa ? "a value in Pa is to be divided by 1000" : "a value in MPa is to be multiplied by 1000";
    return describe("Young's modulus of %g kPa is out of the range of tissue, %g to %g kPa; %s", material.young_kpa, kMinYoungKpa,
                    kMaxYoungKpa, hint);
  }
  if (!(material.poisson >= 0 && material.poisson <= kMaxPoisson))
    return describe("Poisson's ratio of %g is out of range, 0 to %g; tissue, which hardly changes its volume, has 0.45 to 0.49",
                    material.poisson, kMaxPoisson);
  if (!(material.density_kg_m3 >= kMinDensity && material.density_kg_m3 <= kMaxDensity))
    return describe("a density of %g kg/m^3 is out of range, %g to %g kg/m^3; a value in g/cm^3 is to be multiplied by 1000",
                    material.density_kg_m3, kMinDensity, kMaxDensity);
  return {};
}

std::string findFault(const Tissue& tissue) {
  if (std::string fault = findFault(tissue.material); !fault.empty()) return fault;
  if (std::string fault = findNodeFault(tissue); !fault.empty()) return fault;
  if (tissue.tetrahedra.empty()) return "there are no tetrahedra";
  if (std::string fault = findTetrahedronFault(tissue); !fault.empty()) return fault;
  if (tissue.surface.empty()) return "there are no vertices of the surface";
  for (std::size_t v = 0; v < tissue.surface.size(); ++v) {
    const TissueVertex& vertex = tissue.surface[v];
    if (vertex.tetrahedron >= tissue.tetrahedra.size())
      return describe("vertex %zu of the surface names tetrahedron %u, which does not exist", v, vertex.tetrahedron);
    if (!isFinite(vertex.rest) || !std::all_of(vertex.weight.begin(), vertex.weight.end(), [](float w) { return std::isfinite(w); }))
      return describe("vertex %zu of the surface is not finite", v);
  }
  if (std::string fault = findLeafFault(tissue); !fault.empty()) return fault;
  return findResponseFault(tissue);
}

std::string findFault(const Tissue& tissue, const SphereTree& tree) {
  if (std::string fault = findFault(tissue); !fault.empty()) return fault;
  const std::size_t leaves = levelSet(tree, tree.levelCount() - 1).size();
  if (tissue.leaves.anchors.size() != leaves)
    return describe("the tissue has %zu leaves, the tree %zu", tissue.leaves.anchors.size(), leaves);
  const std::size_t nodes = tree.skin.vertices.size() + tree.skin.edges.size();
  if (!tissue.response.empty() && tissue.response.points.size() != nodes)
    return describe("the tissue moves %zu vertices and edges of a skin, the tree has %zu", tissue.response.points.size(), nodes);
  return {};
}

std::vector<std::array<std::uint32_t, 3>> outerFaces(const Tissue& tissue) {
  std::vector<std::pair<std::array<std::uint32_t, 3>, std::array<std::uint32_t, 3>>> faces;  // sorted nodes; the face with its winding
  for (const std::array<std::uint32_t, 4>& c : tissue.tetrahedra)
    for (const std::array<std::size_t, 3>& k : kTetrahedronFaces) {
      const std::array<std::uint32_t, 3> face{c[k[0]], c[k[1]], c[k[2]]};
      faces.emplace_back(face, face);
      std::sort(faces.back().first.begin(), faces.back().first.end());
    }
  std::sort(faces.begin(), faces.end());
  std::vector<std::array<std::uint32_t, 3>> outer;
  for (std::size_t i = 0; i < faces.size(); ++i)
    if ((i == 0 || faces[i - 1].first != faces[i].first) && (i + 1 == faces.size() || faces[i + 1].first != faces[i].first))
      outer.push_back(faces[i].second);
  return outer;
}

void moveSurface(const Tissue& tissue, std::span<const Vector3d> displacements, std::span<Vector3d> positions) noexcept {
  for (std::size_t v = 0; v < positions.size(); ++v) {
    const TissueVertex& vertex = tissue.surface[v];
    const std::array<std::uint32_t, 4>& corner = tissue.tetrahedra[vertex.tetrahedron];
    const double w0 = static_cast<double>(vertex.weight[0]), w1 = static_cast<double>(vertex.weight[1]),
                 w2 = static_cast<double>(vertex.weight[2]);
    positions[v] = vectorOf(vertex.rest) + w0 * displacements[corner[0]] + w1 * displacements[corner[1]] + w2 * displacements[corner[2]] +
                   (1 - w0 - w1 - w2) * displacements[corner[3]];
  }
}

void moveLeaves(const Tissue& tissue, std::span<const Vector3d> displacements, std::span<const Vector3d> positions,
                std::span<Sphere> leaves) noexcept {
  // A position is a sum of about a dozen rounded products, with an error of a few times 1e-16 of the largest of them.
  // Weights above 1, which extrapolate, are at most about 10 in practice; `kRounding` allows for 1000.
  constexpr double kPoint = 1e-6;
  const auto vertices = static_cast<std::uint32_t>(tissue.surface.size());
  for (std::size_t leaf = 0; leaf < leaves.size(); ++leaf) {
    const Eigen::Vector3f centre = roundToFloat(movedCentre(tissue, tissue.leaves.anchors[leaf], displacements, positions));
    const Vector3d from = centre.cast<double>();
    double farthest2 = 0;
    for (std::uint32_t i = tissue.leaves.begin[leaf]; i < tissue.leaves.begin[leaf + 1]; ++i) {
      const std::uint32_t corner = tissue.leaves.corners[i];
      Vector3d at;
      if (corner < vertices) {
        at = positions[corner];
      } else {
        const TissueCut& cut = tissue.leaves.cuts[corner - vertices];
        at = combined(cut.vertex, cut.weight[0], cut.weight[1], positions);
      }
      farthest2 = std::max(farthest2, (at - from).squaredNorm());
    }
    const double farthest = std::sqrt(farthest2), extent = from.cwiseAbs().maxCoeff() + farthest;  // no coordinate is larger
    leaves[leaf] = {centre.x(), centre.y(), centre.z(), roundUp(std::max(farthest, kPoint) + kRounding * extent)};
  }
}

SphereTree movedTree(const SphereTree& tree, std::span<const Sphere> leaves) {
  SphereTree moved = tree;
  moved.skin = {};
  const std::vector<std::uint32_t> order = levelSet(tree, tree.levelCount() - 1);
  for (std::size_t i = 0; i < order.size(); ++i) moved.cover[order[i]] = leaves[i];
  for (std::size_t node = tree.nodeCount(); node-- > 0;) {  // children follow their parents
    if (tree.isLeaf(node)) continue;
    moved.cover[node] = aroundAll(std::span(moved.cover).subspan(tree.first_child[node], tree.child_count[node]));
  }
  for (std::size_t node = 0; node < tree.nodeCount(); ++node)
    if (!tree.isLeaf(node)) moved.bound[tree.bound_index[node]] = moved.cover[node];
  encloseItems(moved.search, leaves);
  for (LevelStatistics& level : moved.statistics) level.overhang_bound = kUnproven;
  countLevels(moved);
  return moved;
}

}  // namespace spheretree
