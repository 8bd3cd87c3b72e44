// SPDX-License-Identifier: GPL-3.0-or-later
#include "simplified_input.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <span>
#include <utility>

#include "mesh/canonical_order.h"
#include "mesh/simplify_mesh.h"
#include "spheretree/builder/mesh_checks.h"
#include "spheretree/core/mesh_edit.h"
#include "tissue/inner_sheet.h"

namespace spheretree::builder {

namespace {

// Number of triangles that the search needs: with 200 for each leaf, the simplified surface differs by a few hundredths
// of the leaves' overhang.
constexpr std::size_t kTrianglesALeaf = 200, kMinTriangles = 20000;
constexpr std::size_t kMaxCrossings = 1000;  // pairs of crossing triangles: with more, the walls are thinner than the triangles
constexpr int kRemovals = 8;                 // times that the corners of crossing triangles are removed
constexpr double kMaxOfTolerance = 0.1;      // share of the tolerance that simplification may use
constexpr double kSliver =
    16;  // height in units of the rounding, up to which rounding may turn over a triangle, so that it overlaps its neighbours

bool hasSlivers(const TriangleMesh& posed) {
  for (std::size_t t = 0; t < posed.triangles.size(); ++t) {
    const Eigen::Vector3d ab = posed.corner(t, 1) - posed.corner(t, 0), ac = posed.corner(t, 2) - posed.corner(t, 0);
    const double longest2 = std::max({ab.squaredNorm(), ac.squaredNorm(), (ac - ab).squaredNorm()});
    const double smallest = kSliver * kPoseRounding;  // the height is twice the area divided by the longest side
    if (!(ab.cross(ac).squaredNorm() > smallest * smallest * longest2)) return true;
  }
  return false;
}

// Whether the simplified mesh is sound. Where it crosses itself, as in the folds of a noisy scan, the corners of the
// triangles that cross are removed, each time with one more ring of vertices around them.
bool isSound(MeshSimplifier& simplifier, TriangleMesh& simplified, Progress& progress) {
  for (int round = 0;; ++round) {
    const MeshReport report = checkMesh(simplified, kMaxCrossings, progress);
    if (report.clean()) return true;
    std::vector<char> is_removed(simplified.positions.size(), 0);
    const auto remove = [&](const Triangle& t) {
      for (const std::uint32_t v : t) is_removed[v] = 1;
    };
    for (const Defect& defect : report.defects) {
      if (round == kRemovals || defect.kind != DefectKind::SelfIntersection || defect.count > defect.first.size()) return false;
      for (const Place& place : defect.first)
        for (const std::uint32_t t : place.triangles) remove(simplified.triangles[t]);
    }
    for (int ring = 0; ring < round; ++ring) {
      const std::vector<char> inner = is_removed;
      for (const Triangle& t : simplified.triangles)
        if (inner[t[0]] || inner[t[1]] || inner[t[2]]) remove(t);
    }
    std::vector<std::uint32_t> vertices;
    for (std::uint32_t v = 0; v < is_removed.size(); ++v)
      if (is_removed[v]) vertices.push_back(v);
    simplified = simplifier.remove(vertices);
  }
}

// Reduces the triangles and computes their field; false if that is impossible or not worthwhile.
bool simplify(SimplifiedInput& search, const TriangleMesh& mesh, std::span<const std::uint32_t> vertex, const TriangleMesh& sheets,
              const BuildSettings& settings, Progress& progress) {
  std::size_t wanted = kTrianglesALeaf;
  for (int level = 1; level < settings.levels; ++level) wanted *= static_cast<std::size_t>(settings.branching);
  wanted = std::max(wanted, kMinTriangles);
  if (!settings.simplify || search.mesh.triangles.size() <= 2 * wanted) return false;
  progress.stage("simplify");
  search.simplifier = std::make_unique<MeshSimplifier>(search.mesh, progress);
  TriangleMesh simplified = search.simplifier->reduce(wanted);
  const bool is_sound = isSound(*search.simplifier, simplified, progress);
  search.simplifier->moveTo(mesh, vertex, search.pose.scale);
  if (!is_sound) return false;
  progress.check();
  DistanceField field(simplified);
  const double bound = search.pose.scale * (distanceBound(search.mesh, field, progress) + kPoseRounding);
  search.simplifier_distance_mm = bound + search.pose.scale * kPoseRounding;  // its vertices are not those of the pose
  if (settings.tolerance_mm > 0 && 2 * bound > kMaxOfTolerance * settings.tolerance_mm) return false;
  search.simplified_triangles = simplified.triangles.size();
  search.distance_bound_mm = bound;
  search.mesh = std::move(simplified);
  search.field = sheets.triangles.empty() ? std::move(field) : DistanceField(search.mesh, {}, sheets);
  return true;
}

// For soft tissue: no ball may be deeper than a share of the thickness. The stand-off of the balls from which the sheet
// is made is about that of the later leaves: a patch of width w on a ball of radius r has a stand-off of w^2 / (8 r).
TriangleMesh sheetForTissue(const SimplifiedInput& search, const BuildSettings& settings) {
  const DistanceField& field = search.field;
  double leaves = 1;
  for (int level = 1; level < settings.levels; ++level) leaves *= settings.branching;
  if (settings.max_leaves > 0) leaves = std::min(leaves, static_cast<double>(settings.max_leaves));
  const double radius = settings.soft_share * 3 * field.volume() / field.area();
  const double stand_off =
      settings.tolerance_mm > 0 ? settings.tolerance_mm / search.pose.scale : 1.2 * field.area() / leaves / (8 * radius);
  return innerSheet(search.mesh, field, settings.soft_share, stand_off, std::sqrt(8 * radius * stand_off));
}

}  // namespace

SimplifiedInput simplifyInput(const TriangleMesh& mesh, const TriangleMesh& sheets, const TriangleMesh& cover_too,
                              const BuildSettings& settings, Progress& progress) {
  SimplifiedInput search;
  search.pose = canonicalPose(mesh);
  TriangleMesh posed = inPose(mesh, search.pose);
  // Inside and outside must stay certain: a single fold caused by rounding can flip the sign of distances far outside.
  if (hasSlivers(posed) && !checkMesh(posed, kPlacesListed, progress).clean()) search.pose = {}, posed = mesh;
  OrderedMesh ordered = inCanonicalOrder(posed);
  posed = {};
  search.mesh = std::move(ordered.mesh);
  std::vector<double> slack;
  if (!settings.tolerance_of_triangle_mm.empty())
    for (const std::uint32_t t : ordered.triangle)
      slack.push_back((settings.tolerance_of_triangle_mm[t] - settings.tolerance_mm) / search.pose.scale);
  const auto posedToo = [&](const TriangleMesh& more) { return inCanonicalOrder(inPose(more, search.pose)).mesh; };
  const TriangleMesh posed_sheets = posedToo(sheets);
  if (!slack.empty() || !simplify(search, mesh, ordered.vertex, posed_sheets, settings, progress))
    search.field = DistanceField(search.mesh, slack, posed_sheets);
  if (settings.soft_share > 0) search.field = DistanceField(search.mesh, slack, joined(sheetForTissue(search, settings), posed_sheets));
  search.mesh = joined(std::move(search.mesh), posedToo(cover_too));
  return search;
}

LevelBalls inFrameOfMesh(LevelBalls balls, const Pose& pose) {
  for (std::vector<Ball>& level : balls.balls)
    for (Ball& b : level) b = {pose.toMesh(b.centre), pose.scale * b.radius};
  return balls;
}

}  // namespace spheretree::builder
