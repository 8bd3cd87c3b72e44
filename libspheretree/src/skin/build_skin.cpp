// SPDX-License-Identifier: GPL-3.0-or-later
#include "skin/build_skin.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "mesh/simplify_mesh.h"
#include "skin/build_search_tree.h"
#include "skin/smooth_surface.h"
#include "skin/surface_edges.h"
#include "spheretree/core/mesh_edit.h"
#include "spheretree/core/rounding.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

// A mesh with at most this number of triangles is kept unchanged. Modelled teeth have 1,000 to 6,000; a skin of 10,000
// triangles takes 350 KB.
constexpr std::size_t kManyTriangles = 10000;
// More triangles have too many vertices and edges for 16 bits, even if few edges are sharp.
constexpr std::size_t kMaxTriangles = 30000;
// Share of the tolerance for the simplification of a mesh with many triangles. At a quarter, the remaining vertices are
// so irregular that the felt normals of a smooth body are off by degrees; a tenth removes coplanar triangles and little
// else.
constexpr double kDistanceShare = 0.1;
// Shares of that distance that the quadric error of a collapse may reach: the coarse mesh is taken if its distance is
// proven, else the fine one. The quadric error is a root mean square over planes: if it is at most 0.6 d, few points
// are farther than d.
constexpr double kCoarseShare = 0.6, kFineShare = 0.3;
constexpr double kStepShare = 0.05;  // ... and that a bound may be looser because it is proven in two steps
constexpr double kWorthIt = 0.8;     // of the triangles: if simplification leaves more than this share, the original triangles are kept
constexpr std::size_t kMaxNames = 65536;  // number of vertices or edges that 16 bits can identify
constexpr double kMaxOffset = 127;        // of a packed offset
constexpr double kSwing = 4.0 / 3;        // the largest motion of a patch, as a multiple of its largest offset
constexpr int kCountTries = 8;  // attempts, each with four fifths of the triangles of the previous one, if there are too many elements

struct BaseSurface {
  TriangleMesh mesh;
  double distance = 0;    // proven two-sided distance to the original mesh [mm]
  bool is_given = false;  // its triangles are those of the solid and the sheets, in their order
};

// Removes triangles with a repeated vertex; their area belongs to their neighbours.
std::size_t dropDegenerate(TriangleMesh& mesh) {
  return std::erase_if(mesh.triangles, [](const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; });
}

class SkinBuilder {
 public:
  SkinBuilder(const TriangleMesh& solid, const TriangleMesh& sheets, const DistanceField& field, const SkinSettings& settings,
              Progress& progress, MeshSimplifier* simplifier, double simplified_distance)
      : solid_(solid),
        sheets_(sheets),
        field_(field),
        settings_(settings),
        progress_(progress),
        begun_(simplifier),
        begun_distance_(simplified_distance) {}

  Skin run(const Vector3d& origin) const {
    BaseSurface surface = chooseSurface();
    std::optional<Skin> skin;
    for (int tries = 0; !(skin = pack(surface, origin)); ++tries) {
      const std::size_t triangles = surface.mesh.triangles.size();
      if (tries == kCountTries) return {};
      surface = fewer(triangles > kMaxTriangles ? kMaxTriangles : triangles * 4 / 5);
    }
    sortForSearch(*skin);
    return *std::move(skin);
  }

 private:
  BaseSurface given() const {
    BaseSurface s{joined(solid_, sheets_), 0, true};
    s.mesh.part.clear();
    s.is_given = dropDegenerate(s.mesh) == 0;
    return s;
  }

  BaseSurface chooseSurface() const {
    if (solid_.triangles.size() <= kManyTriangles) return given();
    const double allowed = kDistanceShare * settings_.tolerance;
    std::optional<MeshSimplifier> own;
    const bool goes_on = begun_ && begun_->triangles() > kMaxTriangles;
    MeshSimplifier& simplifier = goes_on ? *begun_ : own.emplace(solid_, progress_);
    // The distance of the solid is at most that from the surface on the way, and of this from the skin. If the first
    // is nearly nothing, the second takes a tenth of the time.
    const bool by_steps = goes_on && begun_distance_ <= kStepShare * allowed;
    const TriangleMesh step = by_steps ? simplifier.reduce(simplifier.triangles()) : TriangleMesh();
    TriangleMesh fine = simplifier.reduce(kManyTriangles / 2, kFineShare * allowed);
    const bool is_still_large = fine.triangles.size() > kMaxTriangles;
    if (is_still_large) fine = simplifier.reduce(kMaxTriangles, kCoarseShare * allowed);
    TriangleMesh coarse = simplifier.reduce(kManyTriangles / 2, kCoarseShare * allowed);
    for (TriangleMesh* mesh : {&coarse, &fine}) {
      const bool is_worth_it = static_cast<double>(mesh->triangles.size()) <= kWorthIt * static_cast<double>(solid_.triangles.size());
      if (!is_worth_it || mesh->triangles.size() > kMaxTriangles) continue;
      const double distance = by_steps ? provenDistance(step, begun_distance_, *mesh, allowed) : provenDistance(solid_, 0, *mesh, allowed);
      if (distance <= allowed) return withSheets(std::move(*mesh), distance);
    }
    if (solid_.triangles.size() <= kMaxSearchItems) return given();
    if (fine.triangles.size() > kMaxTriangles) fine = simplifier.reduce(kMaxTriangles);
    return is_still_large ? measured(std::move(fine)) : fewer(kMaxTriangles);
  }

  BaseSurface withSheets(TriangleMesh simplified, double distance) const {
    BaseSurface s{joined(std::move(simplified), sheets_), distance};
    dropDegenerate(s.mesh);
    return s;
  }

  // Reduces to a number of triangles, however far that moves the surface from the mesh.
  BaseSurface fewer(std::size_t triangles) const { return measured(simplifyMesh(solid_, triangles, progress_)); }

  BaseSurface measured(TriangleMesh simplified) const {
    const double there = distanceBound(solid_, DistanceField(simplified, {}, sheets_), progress_);
    double back = std::numeric_limits<double>::infinity();
    for (double target = 2 * there; !(back < std::numeric_limits<double>::infinity()); target *= 2)
      back = distanceBound(simplified, field_, progress_, target);
    return withSheets(std::move(simplified), std::max(there, back));
  }

  // Two-sided distance between the original solid and a simplified one with the sheets; above `allowed` if it is not
  // proven to be less. No point of the solid is farther than `from_step` from the surface of `step`.
  double provenDistance(const TriangleMesh& step, double from_step, const TriangleMesh& mesh, double allowed) const {
    const double there = from_step + distanceBound(step, DistanceField(mesh, {}, sheets_), progress_, allowed - from_step);
    return there <= allowed ? std::max(there, distanceBound(mesh, field_, progress_, allowed)) : there;
  }

  // Largest allowed swing of the patches over each triangle.
  std::vector<double> allowedSwing(const BaseSurface& surface, double distance) const {
    const auto left = [&](double tolerance) { return std::max(tolerance - distance, 0.5 * tolerance); };
    std::vector<double> allowed(surface.mesh.triangles.size(), left(settings_.tolerance));
    if (settings_.tolerance_of_triangle.empty()) return allowed;
    for (std::uint32_t t = 0; t < allowed.size(); ++t) {
      const Vector3d middle = (surface.mesh.corner(t, 0) + surface.mesh.corner(t, 1) + surface.mesh.corner(t, 2)) / 3;
      const std::uint32_t below = surface.is_given ? t : field_.nearest(middle).triangle;
      if (below < settings_.tolerance_of_triangle.size()) allowed[t] = left(settings_.tolerance_of_triangle[below]);
    }
    return allowed;
  }

  // Empty if there are more elements than 16 bits can identify.
  std::optional<Skin> pack(BaseSurface& surface, const Vector3d& origin) const;

  const TriangleMesh& solid_;
  const TriangleMesh& sheets_;
  const DistanceField& field_;
  const SkinSettings& settings_;
  Progress& progress_;
  MeshSimplifier* begun_;
  double begun_distance_;
};

/// Converts a surface to the integers of a skin.
class Packer {
 public:
  Packer(const TriangleMesh& mesh, const Vector3d& origin) : mesh_(mesh), origin_(origin) {
    Eigen::AlignedBox3d box;
    for (const Triangle& t : mesh.triangles)
      for (const std::uint32_t v : t) box.extend(mesh.positions[v] - origin);
    for (Eigen::Index axis = 0; axis < 3; ++axis) skin_.low[static_cast<std::size_t>(axis)] = roundToFloat(box.min()[axis]);
    skin_.step = roundUp(box.sizes().maxCoeff() / kMaxSkinCoordinate);
    position_.resize(mesh.positions.size());
    place_.resize(mesh.positions.size());
    for (const Triangle& t : mesh.triangles)
      for (const std::uint32_t v : t) placeVertex(v);
  }

  /// Rounding moved no vertex by more than this [mm].
  double vertexError() const { return vertex_error_; }

  /// Packs the offsets of the middles, reduced where patches would swing out of a triangle by more than `allowed`
  /// (triangles) [mm].
  void packOffsets(const SurfaceEdges& edges, const SmoothSurface& smooth, const std::vector<double>& allowed) {
    const double max_allowed = *std::max_element(allowed.begin(), allowed.end());
    const double rounding =
        std::sqrt(0.75) * max_allowed / (kSwing * kMaxOffset);  // of an offset whose components are rounded to half a step each
    std::vector<Vector3d> offset(edges.kind.size(), Vector3d::Zero());
    double largest = 0;
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t)
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t e = edges.edge[t][k];
        if (edges.kind[e] != EdgeKind::Smooth || edges.triangle[e][0] != t) continue;
        const std::uint32_t a = mesh_.triangles[t][k], b = mesh_.triangles[t][(k + 1) % 3];
        offset[e] = 0.5 * (mesh_.positions[a] + mesh_.positions[b]) - origin_ + smooth.offset[e] - 0.5 * (place_[a] + place_[b]);
        const double limit = std::max(std::min(allowed[t], allowed[edges.triangle[e][1]]) / kSwing - rounding, 0.0);
        if (const double length = offset[e].norm(); length > limit) offset[e] *= limit / length;
        largest = std::max(largest, offset[e].cwiseAbs().maxCoeff());
      }
    skin_.offset_step = roundUp(largest / kMaxOffset);
    offset_.assign(offset.size(), {});
    if (!(skin_.offset_step > 0)) return;
    for (std::size_t e = 0; e < offset.size(); ++e)
      for (std::size_t axis = 0; axis < 3; ++axis)
        offset_[e][axis] =
            static_cast<std::int8_t>(std::lround(offset[e][static_cast<Eigen::Index>(axis)] / static_cast<double>(skin_.offset_step)));
  }

  /// Adds each vertex and edge once for each of its normals; false if there are more than 16 bits can identify.
  bool packElements(const SurfaceEdges& edges, const SmoothSurface& smooth) {
    NameList vertices, sides;
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t)
      for (std::size_t k = 0; k < 3; ++k) {
        vertices.add(mesh_.triangles[t][k], packNormal(smooth.corner_normal[t][k]));
        sides.add(edges.edge[t][k], packNormal(smooth.side_normal[t][k]));
      }
    if (vertices.finish() > kMaxNames || sides.finish() > kMaxNames || mesh_.triangles.size() > kMaxSearchItems) return false;
    for (const auto& [v, normal] : vertices.list) skin_.vertices.push_back({position_[v], normal});
    for (const auto& [e, normal] : sides.list)
      skin_.edges.push_back({offset_[e], static_cast<std::uint8_t>(edges.kind[e] == EdgeKind::Sharp), normal});
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
      SkinTriangle triangle{};
      for (std::size_t k = 0; k < 3; ++k) {
        triangle.vertex[k] = vertices.find(mesh_.triangles[t][k], packNormal(smooth.corner_normal[t][k]));
        triangle.edge[k] = sides.find(edges.edge[t][k], packNormal(smooth.side_normal[t][k]));
      }
      skin_.triangles.push_back(triangle);
    }
    return true;
  }

  Skin& skin() { return skin_; }

 private:
  struct NameList {  // pairs of an element and a normal, sorted
    std::vector<std::pair<std::uint32_t, PackedNormal>> list;
    void add(std::uint32_t element, const PackedNormal& normal) { list.emplace_back(element, normal); }
    std::size_t finish() {
      std::sort(list.begin(), list.end());
      list.erase(std::unique(list.begin(), list.end()), list.end());
      return list.size();
    }
    std::uint16_t find(std::uint32_t element, const PackedNormal& normal) const {
      return static_cast<std::uint16_t>(std::lower_bound(list.begin(), list.end(), std::pair(element, normal)) - list.begin());
    }
  };

  void placeVertex(std::uint32_t v) {
    const Vector3d p = mesh_.positions[v] - origin_;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto i = static_cast<Eigen::Index>(axis);
      const double steps = std::round((p[i] - static_cast<double>(skin_.low[axis])) / static_cast<double>(skin_.step));
      position_[v][axis] = static_cast<std::uint32_t>(std::clamp(steps, 0.0, double{kMaxSkinCoordinate}));
    }
    place_[v] = positionOf(skin_, position_[v]).cast<double>();  // as a reader of the file computes it
    vertex_error_ = std::max(vertex_error_, (place_[v] - p).norm());
  }

  const TriangleMesh& mesh_;
  const Vector3d& origin_;
  Skin skin_;
  std::vector<std::array<std::uint32_t, 3>> position_;  // (vertices)
  std::vector<Vector3d> place_;                         // (vertices) position in the skin [mm], frame of the tree
  std::vector<std::array<std::int8_t, 3>> offset_;      // (edges)
  double vertex_error_ = 0;
};

std::optional<Skin> SkinBuilder::pack(BaseSurface& surface, const Vector3d& origin) const {
  TriangleMesh& mesh = surface.mesh;
  if (mesh.triangles.size() > kMaxSearchItems) return {};
  progress_.check();
  SurfaceEdges edges = classifyEdges(mesh, settings_.crease_angle);
  const SmoothSurface smooth = smoothSurface(mesh, edges);
  Packer packer(mesh, origin);
  // Rounding moves a point of a triangle by at most as much as it moves a vertex.
  const double distance = surface.distance + packer.vertexError();
  packer.packOffsets(edges, smooth, allowedSwing(surface, distance));
  if (!packer.packElements(edges, smooth)) return {};
  Skin& skin = packer.skin();
  skin.mesh_distance = roundUp(distance);
  skin.crease_angle = roundToFloat(settings_.crease_angle);
  for (const SkinEdge& e : skin.edges) skin.tolerance = std::max(skin.tolerance, swingOf(skin, e));
  return std::move(skin);
}

}  // namespace

Skin buildSkin(const TriangleMesh& solid, const TriangleMesh& sheets, const DistanceField& field, const Vector3d& origin,
               const SkinSettings& settings, Progress& progress, MeshSimplifier* simplifier, double simplified_distance) {
  return SkinBuilder(solid, sheets, field, settings, progress, simplifier, simplified_distance).run(origin);
}

}  // namespace spheretree::builder
