// SPDX-License-Identifier: GPL-3.0-or-later
#include "spheretree/builder/build_sphere_tree.h"

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <numbers>
#include <utility>

#include "base/run_beside.h"
#include "base/useful_threads.h"
#include "build_levels.h"
#include "certify/certify_levels.h"
#include "certify/overhang_bound.h"
#include "certify/prove_tree.h"
#include "cover/relax_cover.h"
#include "geometry/distance_field.h"
#include "hulls/build_hulls.h"
#include "level_search.h"
#include "mesh/canonical_order.h"
#include "mesh/surface_with_sheets.h"
#include "simplified_input.h"
#include "skin/build_search_tree.h"
#include "skin/build_skin.h"
#include "spheretree/builder/provenance.h"
#include "spheretree/core/mesh_edit.h"
#include "spheretree/core/rounding.h"
#include "spheretree/core/sphere_tree_codec.h"
#include "tree/assemble_tree.h"
#include "tree/hierarchy.h"
#include "tree/promote_leaves.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr double kFar = 16;  // distance from the origin of the mesh's frame, in diagonals, beyond which the tree gets an origin of its own

constexpr double kMaxSkinReach = 9e6;  // farthest coordinate of a mesh from the origin of its tree that has a skin [mm]

// Measures the times of consecutive stages.
class StageClock {
 public:
  explicit StageClock(BuildStatistics& statistics) : statistics_(statistics) {}
  void finish(const char* stage) {
    const auto now = std::chrono::steady_clock::now();
    statistics_.stages.push_back({stage, std::chrono::duration<double>(now - begun_).count()});
    begun_ = now;
  }

 private:
  BuildStatistics& statistics_;
  std::chrono::steady_clock::time_point begun_ = std::chrono::steady_clock::now();
};

// Float32 has 7 digits: far from the origin they would be used up by the position of the mesh instead of its shape.
Vector3d chooseOrigin(const DistanceField& field) {
  const double farthest = std::max(field.box().min().cwiseAbs().maxCoeff(), field.box().max().cwiseAbs().maxCoeff());
  return farthest > kFar * field.diagonal() ? Vector3d(field.box().center()) : Vector3d::Zero();
}

// The distance field that limits the balls of a graded tree; it has no triangles if the tree is not graded.
DistanceField gradedField(const TriangleMesh& mesh, const TriangleMesh& sheets, const BuildSettings& settings) {
  if (settings.tolerance_of_triangle_mm.empty()) return DistanceField();
  std::vector<double> slack = settings.tolerance_of_triangle_mm;
  for (double& s : slack) s -= settings.tolerance_mm;
  return DistanceField(mesh, slack, sheets);
}

// Where the simplified surface is off by a share of the stand-off, as if the mesh is noisy, the balls move to where
// they cover the mesh itself. With a tolerance, the search has kept that much in reserve.
void relax(LevelBalls& levels, const SimplifiedInput& search, const BuildSettings& settings, const CertificationTarget& target,
           Progress& progress) {
  if (search.simplified_triangles == 0 || !settings.searches() || settings.tolerance_mm > 0 || settings.soft_share > 0) return;
  std::vector<char> is_used(target.mesh.positions.size(), 0);
  for (const Triangle& t : target.mesh.triangles)
    for (const std::uint32_t v : t) is_used[v] = 1;
  std::vector<Vector3d> points;
  for (std::size_t v = 0; v < is_used.size(); ++v)
    if (is_used[v]) points.push_back(target.mesh.positions[v]);
  for (std::vector<Ball>& balls : levels.balls) relaxCover(target.field, points, search.distance_bound_mm, balls, progress);
}

// The levels for the settings, searched on the simplified input and certified against the target.
CertifiedLevels certifiedLevels(const SimplifiedInput& search, const BuildSettings& settings, const CertificationTarget& target,
                                StageClock& clock, Progress& progress) {
  // Balls that cover the simplified surface with a stand-off h cover the original mesh after they have grown by the
  // distance bound d of the simplification. Their overhang over the mesh is then at most h + 2 d, since the distance of
  // the mesh from their centres may also be smaller by d.
  const double tolerance = std::max(0.0, settings.tolerance_mm - 2 * search.distance_bound_mm) / search.pose.scale;
  LevelBuilder builder(search.mesh, search.field);
  return searchLevels(settings, tolerance, [&](const BuildSettings& tried, std::size_t max_levels) {
    progress.stage("balls");
    LevelBalls levels = inFrameOfMesh(builder.build(tried, progress), search.pose);
    if (levels.balls.size() > max_levels) levels.balls.resize(max_levels);
    relax(levels, search, tried, target, progress);
    clock.finish("balls");
    progress.stage("certify");
    CertifiedLevels out = certifyLevels(target, levels, progress);
    if (!tried.searches()) out.uncertified = std::move(levels);
    clock.finish("certify");
    return out;
  });
}

// Groups the levels if the builder has not done so, and makes the tree.
SphereTree treeOf(CertifiedLevels& levels, const BuildSettings& settings, const CertificationTarget& target, Progress& progress) {
  std::vector<std::vector<std::uint32_t>> parents = std::move(levels.parents);
  if (parents.empty()) {
    const bool counts_nodes = settings.tolerance_mm > 0;
    std::vector<std::size_t> parent_count;
    if (counts_nodes) parent_count = promoteLeaves(target.mesh, target.origin, settings.branching, settings.seed, levels.spheres, progress);
    parents = groupLevels(levels.spheres, settings.branching, counts_nodes ? SpareParents::Omit : SpareParents::Fill, parent_count);
  }
  SphereTree tree = assembleTree(levels.spheres, parents, settings.branching);
  tree.origin_mm = {target.origin.x(), target.origin.y(), target.origin.z()};
  return tree;
}

// The spheres of a method as it made them: they contain the points that it samples, and little is known between.
SphereTree treeOf(const LevelBalls& levels, const BuildSettings& settings, const Vector3d& origin) {
  std::vector<std::vector<Sphere>> spheres;
  for (const std::vector<Ball>& level : levels.balls) {
    spheres.emplace_back();
    for (const Ball& ball : level) {
      const Eigen::Vector3f centre = roundToFloat(Vector3d(ball.centre - origin));
      spheres.back().push_back({centre.x(), centre.y(), centre.z(), roundUp(ball.radius)});
    }
  }
  SphereTree tree = assembleTree(spheres, levels.parents, settings.branching);
  tree.origin_mm = {origin.x(), origin.y(), origin.z()};
  return tree;
}

// The smallest tolerance that the leaves keep: their worst overhang, in the graded field if there is one.
double minTolerance(const SphereTree& tree, const CertificationTarget& target) {
  double worst = 0;
  for (const std::uint32_t leaf : levelSet(tree, tree.levelCount() - 1))
    worst = std::max(worst, overhangBound(target.field, target.origin, tree.cover[leaf]));
  return worst;
}

struct SkinOrNote {
  Skin skin;
  std::string note;  // why there is none
};

// The tolerance of the skin does not depend on the overhang of the leaves, since the tool rests on the skin.
// A file holds a skin within 1e7 mm of its origin (skin.h); patches that swing out of the box need some of that.
SkinOrNote makeSkin(const TriangleMesh& mesh, const SurfaceWithSheets& surface, const BuildSettings& settings,
                    const SimplifiedInput& search, const Vector3d& origin, Progress& progress) {
  if (!settings.skin) return {};
  const Eigen::AlignedBox3d& box = surface.field.box();
  const double reach = std::max((box.min() - origin).cwiseAbs().maxCoeff(), (box.max() - origin).cwiseAbs().maxCoeff());
  if (reach > kMaxSkinReach)
    return {{}, "no skin: the mesh is larger than the 10 km that a skin can have. If its numbers are not mm, give --unit."};
  SkinSettings skin;
  skin.tolerance = settings.skin_tolerance_mm > 0 ? settings.skin_tolerance_mm
                   : settings.tolerance_mm > 0    ? settings.tolerance_mm
                                                  : kSkinTolerance * surface.field.diagonal();
  skin.crease_angle = settings.crease_angle_deg * std::numbers::pi / 180;
  std::vector<double> graded = settings.tolerance_of_triangle_mm;
  for (double& tolerance : graded) tolerance += skin.tolerance - settings.tolerance_mm;
  skin.tolerance_of_triangle = graded;
  return {buildSkin(mesh, surface.sheets, surface.field, origin, skin, progress, search.simplifier.get(), search.simplifier_distance_mm),
          {}};
}

// The search tree over the leaves, for traversals that go down to them.
void addSearchTree(SphereTree& tree) {
  std::vector<Sphere> leaves;
  for (const std::uint32_t leaf : levelSet(tree, tree.levelCount() - 1)) leaves.push_back(tree.cover[leaf]);
  tree.search = buildSearchTree(leaves);
}

void addHulls(const TriangleMesh& to_cover, const DistanceField& field, const BuildSettings& settings, SphereTree& tree,
              std::vector<std::string>& notes, Progress& progress) {
  const HullSettings hulls{settings.hull_tolerance_mm, static_cast<std::size_t>(settings.max_hulls)};
  const Vector3d origin(tree.origin_mm[0], tree.origin_mm[1], tree.origin_mm[2]);
  tree.hulls = buildHulls(to_cover, field, origin, hulls, progress);
  if (tree.hulls.empty())
    notes.push_back("no hulls: more than " + std::to_string(settings.max_hulls) +
                    " would be needed, so the tree has its balls alone. Allow a larger overhang or more hulls.");
}

void recordProvenance(const TriangleMesh& mesh, const DistanceField& field, const BuildSettings& settings, Provenance& from) {
  from.builder = std::string(name(settings.builder)) + (settings.search ? "+search" : "");
  from.quality = name(settings.quality);
  from.generator = "spheretree " SPHERETREE_VERSION;
  from.unit_mm = settings.unit_mm;
  from.diagonal_mm = field.diagonal();
  from.volume_mm3 = field.volume();
  from.area_mm2 = field.area();
  from.tolerance_mm = settings.tolerance_mm;
  from.triangle_count = mesh.triangles.size();
  from.seed = settings.seed;
}

// Proves the tree that a reader decodes from the bytes of the file.
void prove(const TriangleMesh& mesh, const DistanceField& field, const SphereTree& tree, Progress& progress) {
  SphereTree decoded;
  std::string fault = findFault(tree);
  if (fault.empty() && decodeSphereTree(encodeSphereTree(tree), decoded, &fault) == LoadStatus::Ok && !(decoded == tree))
    fault = "its file holds another tree";
  if (fault.empty()) fault = findUnproven(mesh, field, decoded, progress);
  const Vector3d origin(tree.origin_mm[0], tree.origin_mm[1], tree.origin_mm[2]);
  if (fault.empty() && !decoded.hulls.empty()) fault = findUnproven(mesh, field, decoded.hulls, origin, progress);
  if (!fault.empty()) throw std::logic_error("build: the tree is unsound, please report this: " + fault);
}

BuildResult build(const TriangleMesh& mesh, const BuildSettings& settings, Progress& progress, const TriangleMesh& cover_too) {
  BuildResult result;
  BuildStatistics& statistics = result.statistics;
  StageClock clock(statistics);

  progress.stage("distances");
  const SurfaceWithSheets surface = surfaceWithSheets(mesh, cover_too);
  const DistanceField& field = surface.field;
  if (!(field.volume() > 0)) throw BuildError("the mesh encloses no volume: it is flat, open or inside out");
  clock.finish("distances");

  const DistanceField graded = gradedField(mesh, surface.sheets, settings);
  const bool is_graded = graded.triangleCount() > 0;
  const SimplifiedInput search = simplifyInput(mesh, surface.sheets, cover_too, settings, progress);
  statistics.simplification = {search.simplified_triangles, search.distance_bound_mm};
  clock.finish("search mesh");

  const TriangleMesh to_cover = joined(mesh, cover_too);  // triangles of both; it does not matter whether they share vertices
  const CertificationTarget target{to_cover, is_graded ? graded : field, chooseOrigin(field), settings.seed};
  CertifiedLevels levels;
  SkinOrNote skin;
  runBeside(
      progress, [&] { levels = certifiedLevels(search, settings, target, clock, progress); },
      [&](Progress& part) { skin = makeSkin(mesh, surface, settings, search, target.origin, part); });
  clock.finish("skin");
  statistics.certified_pieces = levels.pieces;

  progress.stage("hierarchy");
  if (!levels.uncertified.balls.empty()) result.uncertified = treeOf(levels.uncertified, settings, target.origin);
  SphereTree& tree = result.tree = treeOf(levels, settings, target, progress);
  const std::vector<double> overhang = stateOverhang(field, tree);
  for (std::size_t level = 0; level < overhang.size(); ++level)
    statistics.levels.push_back({tree.statistics[level].sphere_count, overhang[level], levels.largest_growth[level]});
  statistics.min_tolerance_mm = is_graded ? minTolerance(tree, target) : overhang.back();
  statistics.tolerance_met = !(settings.tolerance_mm > 0) || statistics.min_tolerance_mm <= settings.tolerance_mm;
  recordProvenance(mesh, field, settings, tree.provenance);
  if (is_graded) tree.provenance.work_overhang_mm = roundUp(statistics.min_tolerance_mm);
  addSearchTree(tree);
  clock.finish("hierarchy");

  tree.skin = std::move(skin.skin);
  if (!skin.note.empty()) statistics.notes.push_back(skin.note);
  if (settings.hulls) {
    progress.stage("hulls");
    addHulls(to_cover, field, settings, tree, statistics.notes, progress);
    clock.finish("hulls");
  }
  progress.stage("proof");
  prove(to_cover, field, tree, progress);
  clock.finish("proof");
  return result;
}

}  // namespace

BuildResult buildSphereTree(const TriangleMesh& mesh, const BuildSettings& settings, Progress& progress, const TriangleMesh& cover_too) {
  validate(settings);
  if (mesh.triangles.empty()) throw BuildError("the mesh has no triangles");
  if (!settings.tolerance_of_triangle_mm.empty() && settings.tolerance_of_triangle_mm.size() != mesh.triangles.size())
    throw std::invalid_argument("build: there must be one tolerance for each triangle");
  const int threads = settings.threads > 0 ? usefulThreads(settings.threads) : tbb::this_task_arena::max_concurrency();
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(std::max(threads, 1)));
  tbb::task_arena arena(threads);
  const OrderedMesh ordered = inCanonicalOrder(mesh);
  BuildSettings ordered_settings = settings;
  for (std::size_t t = 0; t < settings.tolerance_of_triangle_mm.size(); ++t)
    ordered_settings.tolerance_of_triangle_mm[t] = settings.tolerance_of_triangle_mm[ordered.triangle[t]];
  BuildResult result = arena.execute([&] { return build(ordered.mesh, ordered_settings, progress, inCanonicalOrder(cover_too).mesh); });
  result.tree.provenance.mesh_hash = meshHash(mesh);
  result.tree.provenance.settings_hash = settingsHash(settings);
  return result;
}

}  // namespace spheretree::builder
