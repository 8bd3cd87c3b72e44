// SPDX-License-Identifier: GPL-3.0-or-later
#include "spheretree/builder/build_sphere_tree.h"

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "certify/certify_cover.h"
#include "certify/redundant_spheres.h"
#include "cover/build_cover.h"
#include "geometry/distance_field.h"
#include "mesh/canonical_order.h"
#include "mesh/surface_with_sheets.h"
#include "published/build_by_regions.h"
#include "published/reduce_burst.h"
#include "published/reduce_expand.h"
#include "published/reduce_grid.h"
#include "published/reduce_hubbard.h"
#include "published/reduce_merge.h"
#include "published/reduce_octree.h"
#include "published/reduce_spawn.h"
#include "simplified_input.h"
#include "spheretree/builder/provenance.h"
#include "spheretree/core/mesh_edit.h"
#include "tree/hierarchy.h"
#include "tree/promote_leaves.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr double kFar = 16;                // mesh diagonals from its frame's origin at which float32 needs an origin of its own
constexpr double kResolution = 2e-3;       // of certification, as a share of the stand-off
constexpr double kLeastResolution = 1e-7;  // ... and of the diagonal

constexpr int kAttempts = 4;           // more, with a smaller tolerance each
constexpr std::size_t kFewNodes = 21;  // one leaf more is much
constexpr double kHopeless = 1.05;     // times the tolerance: fewer leaves hardly ever reach out so much less

void require(bool holds, const char* what) {
  if (!holds) throw std::invalid_argument(std::string("build: ") + what);
}

void validate(const BuildSettings& s) {
  require(s.levels >= kMinLevels && s.levels <= kMaxLevels, "levels must be 2 to 6");
  require(s.branching >= kMinBranching && s.branching <= kMaxBranching, "branching must be 2 to 8");
  require(std::isfinite(s.tolerance_mm) && s.tolerance_mm >= 0, "tolerance must be finite and not negative");
  require(s.threads >= 0, "threads must not be negative");
  require(s.most_leaves >= 0, "the number of leaves must not be negative");
  require(s.most_leaves == 0 || s.builder == BuilderKind::Cover, "a number of leaves is for the builder cover");
  for (const double t : s.tolerance_of_triangle_mm)
    require(std::isfinite(t) && s.tolerance_mm > 0 && t >= s.tolerance_mm,
            "the tolerance of a triangle must be finite and not below the tolerance");
  require(s.tolerance_of_triangle_mm.empty() || s.builder == BuilderKind::Cover, "tolerances of triangles are for the builder cover");
}

// The published method that builds by regions; Cover, Octree and Combined are none.
Method methodOf(BuilderKind kind) {
  switch (kind) {
    case BuilderKind::Merge:
      return {reduceMerge, true};
    case BuilderKind::Burst:
      return {reduceBurst, true};
    case BuilderKind::Expand:
      return {reduceExpand, true};
    case BuilderKind::Spawn:
      return {reduceSpawn, false};
    case BuilderKind::Grid:
      return {reduceGrid, false};
    case BuilderKind::Hubbard:
      return {reduceHubbard, true};
    default:
      throw std::invalid_argument("build: '" + std::string(name(kind)) +
                                  "' cannot be combined; use merge, burst, expand, spawn, grid or hubbard");
  }
}

// In the pose of the search mesh; so is the tolerance of the settings.
LevelBalls buildLevels(const TriangleMesh& mesh, const DistanceField& field, const BuildSettings& settings, Progress& progress) {
  PublishedSettings published;
  published.levels = settings.levels;
  published.branching = settings.branching;
  published.quality = settings.quality;
  published.tolerance_mm = settings.tolerance_mm;
  published.seed = settings.seed;
  std::vector<Method> methods;
  switch (settings.builder) {
    case BuilderKind::Cover:
      return buildCover(mesh, field, settings, progress);
    case BuilderKind::Octree:
      return buildOctree(mesh, field, published, progress);
    case BuilderKind::Combined: {
      const std::vector<BuilderKind> usual{BuilderKind::Expand, BuilderKind::Merge, BuilderKind::Burst};
      for (const BuilderKind member : settings.combine.empty() ? usual : settings.combine) methods.push_back(methodOf(member));
      break;
    }
    default:
      methods.push_back(methodOf(settings.builder));
  }
  return buildByRegions(mesh, field, methods, published, progress);
}

// Levels are built for a tolerance so much smaller, as certification makes spheres grow: it closes the gaps that a search leaves open.
double aimOf(const BuildSettings& settings) {
  if (settings.builder == BuilderKind::Octree) return 1;  // leaves none
  if (settings.builder == BuilderKind::Cover) return 1.02;
  return settings.quality == Quality::Best ? 1.015 : 1.045;
}

// Float32 holds 7 digits: far from the origin they would go into the place of the mesh, not into its shape.
Vector3d chooseOrigin(const DistanceField& field) {
  const double most = std::max(field.box().min().cwiseAbs().maxCoeff(), field.box().max().cwiseAbs().maxCoeff());
  return most > kFar * field.diagonal() ? Vector3d(field.box().center()) : Vector3d::Zero();
}

// Proven: no point of the ball is farther from the surface than this, outside. The ball about c holds no point farther out than its
// radius, less the distance from c to the surface.
double overhangBound(const DistanceField& field, const Vector3d& origin, const Sphere& s) {
  const Vector3d c = Vector3d(s.x, s.y, s.z) + origin;
  const double rounding = 1e-12 * (c.cwiseAbs().maxCoeff() + field.diagonal());
  return s.radius + field.signedDistance(c) + rounding;
}

float roundUp(double x) {
  const auto f = static_cast<float>(x);
  return static_cast<double>(f) < x ? std::nextafterf(f, std::numeric_limits<float>::infinity()) : f;
}

// The spheres of each level, each level (with the spheres that ended above it) certified to cover the mesh.
struct CertifiedLevels {
  std::vector<std::vector<Sphere>> spheres;
  std::vector<std::vector<std::uint32_t>> parents;  // as in LevelBalls
  std::vector<double> largest_growth;               // (levels)
  std::size_t pieces = 0;
  double wanted = 0;                                       // overhang bound of the deepest level, before certification [mm] ...
  double bound = std::numeric_limits<double>::infinity();  // ... and after

  std::size_t count() const {
    std::size_t all = 0;
    for (const std::vector<Sphere>& level : spheres) all += level.size();
    return all;
  }
};

class Certifier {
 public:
  Certifier(const TriangleMesh& mesh, const DistanceField& field, const Vector3d& origin, std::uint64_t seed, Progress& progress)
      : mesh_(mesh), field_(field), origin_(origin), seed_(seed), progress_(progress) {}

  CertifiedLevels certify(const LevelBalls& levels) {
    out_ = {};
    ended_.clear();
    out_.parents = levels.parents;
    out_.spheres.resize(levels.balls.size());
    for (std::size_t level = 0; level < levels.balls.size(); ++level) {
      progress_.advance(static_cast<double>(level) / static_cast<double>(levels.balls.size()));
      certifyLevel(levels, level);
    }
    return std::move(out_);
  }

 private:
  struct Ended {  // a ball that stands for its part at all deeper levels: one sphere for all of them
    std::size_t level, index;
  };

  void certifyLevel(const LevelBalls& levels, std::size_t level) {
    const std::size_t own = levels.balls[level].size();
    std::vector<Ball> set = levels.balls[level];
    for (const Ended& e : ended_) set.push_back({levels.balls[e.level][e.index].centre, out_.spheres[e.level][e.index].radius});
    double stand_off = 0;
    for (const Ball& b : set) stand_off = std::max(stand_off, b.radius + field_.signedDistance(b.centre));
    const double resolution = std::max(kResolution * stand_off, kLeastResolution * field_.diagonal());
    CertifiedCover certified = certifyCover(mesh_, set, origin_, resolution, progress_);
    out_.pieces += certified.pieces;
    out_.largest_growth.push_back(certified.largest_growth);
    const bool deepest = level + 1 == levels.balls.size();
    if (deepest) {
      out_.wanted = stand_off;
      dropRedundant(certified.spheres, own);
      out_.bound = 0;
      for (const Sphere& s : certified.spheres) out_.bound = std::max(out_.bound, overhangBound(field_, origin_, s));
    }
    const std::size_t kept = certified.spheres.size() - ended_.size();
    out_.spheres[level].assign(certified.spheres.begin(), certified.spheres.begin() + static_cast<std::ptrdiff_t>(kept));
    for (std::size_t i = 0; i < ended_.size(); ++i) out_.spheres[ended_[i].level][ended_[i].index] = certified.spheres[kept + i];
    if (levels.parents.empty() || deepest) return;
    std::vector<char> has_child(own, 0);
    for (const std::uint32_t parent : levels.parents[level + 1]) has_child.at(parent) = 1;
    for (std::size_t i = 0; i < own; ++i)
      if (!has_child[i]) ended_.push_back({level, i});
  }

  // Leaves that add nothing; no sphere above loses its last child by that.
  void dropRedundant(std::vector<Sphere>& set, std::size_t own) {
    if (out_.spheres.size() < 2) return;
    const std::size_t above = out_.spheres[out_.spheres.size() - 2].size();
    std::vector<std::uint32_t> group(set.size(), static_cast<std::uint32_t>(above));  // what ended above is no child of any
    if (!out_.parents.empty()) std::copy(out_.parents.back().begin(), out_.parents.back().end(), group.begin());
    std::vector<char> fixed(own, 0);
    fixed.resize(set.size(), 1);
    const std::size_t most = out_.parents.empty() ? own - std::min(own, above) : own;
    const std::vector<char> needless = findRedundantSpheres(mesh_, set, origin_, group, fixed, most, seed_, progress_);
    std::size_t kept = 0;
    for (std::size_t i = 0; i < set.size(); ++i) {
      if (needless[i]) continue;
      set[kept] = set[i];
      if (!out_.parents.empty() && i < own) out_.parents.back()[kept] = out_.parents.back()[i];
      ++kept;
    }
    if (!out_.parents.empty()) out_.parents.back().resize(kept - (set.size() - own));
    set.resize(kept);
  }

  const TriangleMesh& mesh_;
  const DistanceField& field_;
  Vector3d origin_;
  std::uint64_t seed_;
  Progress& progress_;
  CertifiedLevels out_;
  std::vector<Ended> ended_;
};

// One after the other.
class Stages {
 public:
  explicit Stages(BuildStatistics& statistics) : statistics_(statistics) {}
  void finish(const char* stage) {
    const auto now = std::chrono::steady_clock::now();
    statistics_.stages.push_back({stage, std::chrono::duration<double>(now - begun_).count()});
    begun_ = now;
  }

 private:
  BuildStatistics& statistics_;
  std::chrono::steady_clock::time_point begun_ = std::chrono::steady_clock::now();
};

// Levels as the settings ask for them, certified. With a tolerance: with the fewest nodes found that keep it.
class LevelSearch {
 public:
  LevelSearch(const SimplifiedInput& search, const BuildSettings& settings, Certifier& certifier, Stages& stages, Progress& progress)
      : search_(search), settings_(settings), certifier_(certifier), stages_(stages), progress_(progress) {
    // Balls that cover the simplified surface with a stand-off h cover the mesh given once they have grown by the bound, and stand off
    // from it by at most h and twice the bound: its distance from their centres may be less by the bound, too.
    farthest_ = std::max(0.0, settings.tolerance_mm - 2 * search.distance_bound_mm) / search.pose.scale;
  }

  CertifiedLevels run() {
    const bool tries_full = settings_.tolerance_mm > 0 && settings_.builder != BuilderKind::Octree;  // whose cells join instead
    if (tries_full) tryFull(2);
    if (isKept(best_)) {
      offer(full(1, kMinBranching));
      return std::move(best_);
    }
    double aim = farthest_ / aimOf(settings_);
    best_ = forTolerance(aim);
    // Only certification can have pushed it beyond: aim lower by as much.
    for (int attempt = 0; attempt < kAttempts && best_.wanted <= settings_.tolerance_mm && !isKept(best_); ++attempt) {
      aim *= 0.99 * settings_.tolerance_mm / best_.bound;
      best_ = forTolerance(aim);
    }
    // It may push less far, too.
    if (aim < farthest_ && isKept(best_) && best_.count() <= kFewNodes) offer(forTolerance(farthest_));
    if (tries_full && settings_.levels > 2) tryFull(3);
    return std::move(best_);
  }

 private:
  bool isKept(const CertifiedLevels& levels) const { return levels.bound <= settings_.tolerance_mm; }
  void offer(CertifiedLevels other) {
    if (isKept(other) && (!isKept(best_) || other.count() < best_.count())) best_ = std::move(other);
  }

  // A leaf more is much of a tree of few nodes, and such trees are soon made. So all full ones are tried, each as tight as it comes, down
  // to the first that is hopeless.
  void tryFull(int depth) {
    for (int branching = settings_.branching; branching >= kMinBranching; --branching) {
      std::size_t nodes = 1;
      for (int level = 1, width = 1; level < depth; ++level) nodes += static_cast<std::size_t>(width *= branching);
      if (nodes > kFewNodes || (isKept(best_) && nodes >= best_.count())) continue;
      CertifiedLevels tree = full(depth, branching);
      const bool is_hopeless = tree.bound > kHopeless * settings_.tolerance_mm;
      offer(std::move(tree));
      if (is_hopeless) return;
    }
  }

  CertifiedLevels full(int depth, int branching) {
    BuildSettings how = settings_;
    how.levels = std::max(depth, kMinLevels);
    how.branching = branching;
    how.tolerance_mm = 0;
    return certified(how, static_cast<std::size_t>(depth));
  }
  CertifiedLevels forTolerance(double tolerance) {
    BuildSettings how = settings_;
    how.tolerance_mm = tolerance;
    return certified(how, kMaxLevels);
  }
  CertifiedLevels certified(const BuildSettings& how, std::size_t most_levels) {
    progress_.stage("balls");
    LevelBalls levels = inFrameOfMesh(buildLevels(search_.mesh, search_.field, how, progress_), search_.pose);
    if (levels.balls.size() > most_levels) levels.balls.resize(most_levels);
    stages_.finish("balls");
    progress_.stage("certify");
    CertifiedLevels out = certifier_.certify(levels);
    stages_.finish("certify");
    return out;
  }

  const SimplifiedInput& search_;
  const BuildSettings& settings_;
  Certifier& certifier_;
  Stages& stages_;
  Progress& progress_;
  double farthest_;       // tolerance in the pose of the search mesh
  CertifiedLevels best_;  // found so far
};

// The field that the balls of a graded tree keep their distance in; of no triangles if the tree is not graded.
DistanceField gradedField(const TriangleMesh& mesh, const TriangleMesh& sheets, const BuildSettings& settings) {
  if (settings.tolerance_of_triangle_mm.empty()) return DistanceField();
  std::vector<double> slack = settings.tolerance_of_triangle_mm;
  for (double& s : slack) s -= settings.tolerance_mm;
  return DistanceField(mesh, slack, sheets);
}

BuildResult build(const TriangleMesh& mesh, const BuildSettings& settings, Progress& progress, const TriangleMesh& cover_too) {
  BuildResult result;
  Stages stages(result.statistics);

  progress.stage("distances");
  const SurfaceWithSheets surface = surfaceWithSheets(mesh, cover_too);
  const DistanceField& field = surface.field;
  if (!(field.volume() > 0)) throw BuildError("the mesh encloses no volume: it is flat, open or inside out");
  stages.finish("distances");

  const DistanceField graded = gradedField(mesh, surface.sheets, settings);
  const bool is_graded = graded.triangleCount() > 0;
  const SimplifiedInput search = simplifyInput(mesh, surface.sheets, cover_too, settings, progress);
  result.statistics.simplification = {search.simplified_triangles, search.distance_bound_mm};
  stages.finish("search mesh");

  const Vector3d origin = chooseOrigin(field);
  const TriangleMesh to_cover = joined(mesh, cover_too);  // triangles of both; the sharing of vertices does not matter
  // A graded tree aims at keeping its distance in the graded field.
  const DistanceField& goal = is_graded ? graded : field;
  Certifier certifier(to_cover, goal, origin, settings.seed, progress);
  CertifiedLevels levels = LevelSearch(search, settings, certifier, stages, progress).run();
  result.statistics.certified_pieces = levels.pieces;

  progress.stage("hierarchy");
  std::vector<std::vector<std::uint32_t>> parents = std::move(levels.parents);
  if (parents.empty()) {
    const bool counts_nodes = settings.tolerance_mm > 0;
    std::vector<std::size_t> parent_count;
    if (counts_nodes) parent_count = promoteLeaves(to_cover, origin, settings.branching, settings.seed, levels.spheres, progress);
    parents = groupLevels(levels.spheres, settings.branching, counts_nodes ? SpareParents::Omit : SpareParents::Fill, parent_count);
  }
  SphereTree& tree = result.tree;
  tree = assembleTree(levels.spheres, parents, settings.branching);
  tree.origin_mm = {origin.x(), origin.y(), origin.z()};
  std::vector<double> bound(tree.nodeCount());
  for (std::size_t i = 0; i < bound.size(); ++i) bound[i] = overhangBound(field, origin, tree.cover[i]);
  result.statistics.levels.resize(static_cast<std::size_t>(tree.levelCount()));
  for (int level = 0; level < tree.levelCount(); ++level) {
    double most = 0;
    for (const std::uint32_t node : levelSet(tree, level)) most = std::max(most, bound[node]);
    const auto l = static_cast<std::size_t>(level);
    tree.statistics[l].overhang_bound = roundUp(most);
    result.statistics.levels[l] = {tree.statistics[l].sphere_count, most, levels.largest_growth[l]};
  }
  double& met = result.statistics.least_tolerance_mm;
  met = result.statistics.levels.back().overhang_bound_mm;
  if (is_graded) {
    met = 0;
    for (const std::uint32_t leaf : levelSet(tree, tree.levelCount() - 1))
      met = std::max(met, overhangBound(graded, origin, tree.cover[leaf]));
  }
  result.statistics.tolerance_met = !(settings.tolerance_mm > 0) || met <= settings.tolerance_mm;

  Provenance& from = tree.provenance;
  from.builder = name(settings.builder);
  from.quality = name(settings.quality);
  from.generator = "spheretree " SPHERETREE_VERSION;
  from.unit_mm = settings.unit_mm;
  from.diagonal_mm = field.diagonal();
  from.volume_mm3 = field.volume();
  from.area_mm2 = field.area();
  from.tolerance_mm = settings.tolerance_mm;
  if (is_graded) from.work_overhang_mm = roundUp(met);
  from.triangle_count = mesh.triangles.size();
  from.seed = settings.seed;
  const std::string fault = findFault(tree);
  if (!fault.empty()) throw std::logic_error("build: the tree is unsound, please report this: " + fault);
  stages.finish("hierarchy");
  return result;
}

}  // namespace

std::string_view name(BuilderKind kind) {
  switch (kind) {
    case BuilderKind::Cover:
      return "cover";
    case BuilderKind::Combined:
      return "combined";
    case BuilderKind::Merge:
      return "merge";
    case BuilderKind::Burst:
      return "burst";
    case BuilderKind::Expand:
      return "expand";
    case BuilderKind::Spawn:
      return "spawn";
    case BuilderKind::Grid:
      return "grid";
    case BuilderKind::Hubbard:
      return "hubbard";
    case BuilderKind::Octree:
      return "octree";
  }
  return "";
}

std::string_view name(Quality quality) {
  switch (quality) {
    case Quality::Quick:
      return "quick";
    case Quality::Standard:
      return "standard";
    case Quality::Best:
      return "best";
  }
  return "";
}

BuildResult buildSphereTree(const TriangleMesh& mesh, const BuildSettings& settings, Progress& progress, const TriangleMesh& cover_too) {
  validate(settings);
  if (mesh.triangles.empty()) throw BuildError("the mesh has no triangles");
  const int threads = settings.threads > 0 ? settings.threads : tbb::this_task_arena::max_concurrency();
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(std::max(threads, 1)));
  tbb::task_arena arena(threads);
  require(settings.tolerance_of_triangle_mm.empty() || settings.tolerance_of_triangle_mm.size() == mesh.triangles.size(),
          "there must be one tolerance for each triangle");
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
