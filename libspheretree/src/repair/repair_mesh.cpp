// SPDX-License-Identifier: GPL-3.0-or-later
#include "spheretree/builder/repair_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numeric>
#include <optional>
#include <set>

#include "base/negligible.h"
#include "geometry/distance_field.h"
#include "geometry/farthest_point.h"
#include "repair/fill_holes.h"
#include "repair/repair_soup.h"
#include "repair/resolve_overlaps.h"
#include "repair/separate_fans.h"
#include "repair/subtract_solid.h"
#include "repair/wrap_surface.h"
#include "spheretree/core/mesh_edit.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

// As shares of the diagonal, except areas.
constexpr double kHole = 0.25;                         // a border with a smaller box is a hole, otherwise an opening
constexpr double kAlpha = 0.01, kOffset = 1.0 / 1500;  // of a wrap
constexpr double kDeep = 1e-3;                         // matter deeper than this does not belong to the surface
constexpr double kLostArea = 0.005;  // share of the input's area that may be left without solid matter, before a wrap is preferred
constexpr double kThin = 5e-4;       // mean thickness below which a closed opening has only doubled a sheet
constexpr int kCutRounds = 6;        // rounds of cutting, since rounding may leave crossings
constexpr int kFreeRounds = 2;       // of them: before vertices are moved to a grid
// Bounds of the growth and of the work, before the wrap takes over.
constexpr std::size_t kGrowth = 4, kMoreTriangles = 200'000;     // triangles for each one read, and beside them
constexpr std::size_t kWork = 6'000'000, kWorkOfTriangle = 100;  // [us]; for each triangle beside it

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

std::string counted(std::size_t count, const char* one, const char* many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

std::vector<std::uint32_t> allTriangles(const TriangleMesh& mesh) {
  std::vector<std::uint32_t> all(mesh.triangles.size());
  std::iota(all.begin(), all.end(), 0u);
  return all;
}

/// A mesh that no step can repair.
bool isBeyondRepair(const MeshReport& report) {
  return report.has(DefectKind::NoTriangles) || report.has(DefectKind::BadIndex) || report.has(DefectKind::NonFinite) ||
         report.has(DefectKind::Scale) || !(report.area > 0);
}

double diagonalOf(const MeshReport& report) { return (report.high - report.low).norm(); }

class Repair {
 public:
  /// `more`: triangles beside those of the mesh, for the bounds of growth and work.
  Repair(const TriangleMesh& mesh, const MeshReport& report, Progress& progress, std::size_t more = 0)
      : input_(mesh),
        report_(report),
        progress_(progress),
        work_(progress, kWork + kWorkOfTriangle * (mesh.triangles.size() + more)),
        max_triangles_(kMoreTriangles + kGrowth * (mesh.triangles.size() + more)),
        diagonal_(diagonalOf(report)),
        is_modified_(mesh.triangles.size(), 0) {}

  /// The smallest change that works, without a wrap. Empty if it does not give a sound mesh within the bounds.
  std::optional<RepairedMesh> repair() {
    try {
      return repairInSteps();
    } catch (const TooMuchWork&) {
      gives_up_ = true;
      return {};
    }
  }

  /// The mesh without the solid `taken`; both are sound.
  std::optional<Difference> without(const TriangleMesh& taken) {
    start();
    const auto first = static_cast<std::uint32_t>(soup_.mesh.positions.size());
    soup_.mesh.positions.insert(soup_.mesh.positions.end(), taken.positions.begin(), taken.positions.end());
    for (const auto& [a, b, c] : taken.triangles) soup_.mesh.triangles.push_back({first + a, first + c, first + b});
    soup_.source.resize(soup_.mesh.triangles.size(), kNone);
    may_be_lost_ = std::numeric_limits<double>::infinity();  // surface that is taken away
    try {
      for (int round = 0; round < kCutRounds; ++round) {
        if (!resolve(round)) break;
        separate();
        const MeshReport state = checkMesh(soup_.mesh, kPlacesListed, progress_);
        if (!state.clean()) continue;
        soup_.mesh = withoutBuried(soup_.mesh, state);
        dropUnusedVertices(soup_.mesh);
        return Difference{std::move(soup_.mesh), moved()};
      }
    } catch (const TooMuchWork&) {
      return {};
    }
    return soup_.mesh.triangles.empty() ? std::optional(Difference{}) : std::nullopt;
  }

  /// Whether a bound of the growth or of the work ended the repair.
  bool givesUp() const { return gives_up_; }

  /// Whether the rest that needs a wrap is a sheet, which has no inside.
  bool isSheet() const { return is_sheet_; }

  /// `is_closed`: with its holes and openings filled, since the ball of the wrap would otherwise enter large ones.
  /// `gave_up`: the steps before it passed a bound.
  RepairedMesh wrap(bool is_closed, bool gave_up) {
    if (is_closed) {
      try {
        start();
        clean();
        closeBorders();
      } catch (const TooMuchWork&) {
        steps_.clear();
        is_closed = false;
      }
    }
    if (!is_closed) {
      start();
      note(RepairStepKind::DropFlat, dropFlat(soup_), "left out, since they have no area");
    }
    return wrapped(gave_up);
  }

 private:
  void start() {
    soup_.mesh = {input_.positions, input_.triangles, {}, {}};
    soup_.source = allTriangles(input_);
  }

  std::optional<RepairedMesh> repairInSteps() {
    start();
    clean();
    if (soup_.mesh.triangles.empty()) return {};
    is_sheet_ = isOneSided(soup_.mesh);
    closeBorders();
    for (int round = 0; round < kCutRounds; ++round) {
      work_.spend(soup_.mesh.triangles.size());
      MeshReport state = checkMesh(soup_.mesh, kPlacesListed, progress_);
      if (round == 0 && needsCuts(state) && !state.has(DefectKind::InsideOut)) state = turnCrossing(std::move(state));
      // After a cut the winding is correct; while components cross, their nesting is uncertain.
      if (state.has(DefectKind::InsideOut) && (round == 0 || !state.has(DefectKind::SelfIntersection))) state = turnOutward(state);
      if (state.clean()) return finish(state);
      if (needsCuts(state) && !resolve(round)) return {};
      separate();
      if (soup_.mesh.triangles.size() > max_triangles_) throw TooMuchWork{};
    }
    return {};
  }

  RepairedMesh wrapped(bool gave_up) {
    progress_.stage("wrap");
    const double alpha = kAlpha * std::max(diagonal_, std::sqrt(report_.area)), offset = kOffset * diagonal_;
    RepairedMesh out;
    out.mesh = wrapSurface(soup_.mesh, alpha, offset, progress_);
    progress_.check();
    out.result = checkMesh(out.mesh, kPlacesListed, progress_);
    RepairStep step{RepairStepKind::Wrap, {}, out.mesh.triangles.size(), 0, {}};
    if (out.result.clean()) {
      const DistanceField surface(soup_.mesh);
      step.change_mm = farthestFrom(surface, out.mesh, allTriangles(out.mesh), kNegligible * diagonal_, progress_);
      out.bound_mm = step.change_mm;
      const std::vector<char> is_removed = removed();
      std::vector<std::uint32_t> left;
      for (std::uint32_t t = 0; t < is_removed.size(); ++t)
        if (!is_removed[t]) left.push_back(t);
      PartsNearSurface clipped = clipToDepth(DistanceField(out.mesh), input_, left, alpha, progress_);
      out.to_cover = std::move(clipped.pieces);
      out.partly = std::move(clipped.partly);
      step.removed = std::move(clipped.removed);
    }
    step.text = std::string(gave_up ? "the crossings are too many to cut them along each other; " : "") + "wrapped: a closed surface of " +
                counted(step.count, "triangle", "triangles") + " around the whole, at most " + number(step.change_mm) +
                " mm away; gaps narrower than " + number(2 * alpha) + " mm are bridged, cavities filled; what lies deeper than " +
                number(alpha) + " mm within it needs no cover: " + counted(step.removed.size(), "triangle", "triangles") + " wholly, " +
                std::to_string(out.partly.size()) + " in part.";
    steps_.push_back(std::move(step));
    out.steps = std::move(steps_);
    return out;
  }

  void note(RepairStepKind kind, std::vector<std::uint32_t> removed, const std::string& what) {
    if (removed.empty()) return;
    std::sort(removed.begin(), removed.end());
    RepairStep step{kind, what + ": " + counted(removed.size(), "triangle", "triangles") + ".", removed.size(), 0, std::move(removed)};
    steps_.push_back(std::move(step));
  }

  void clean() {
    progress_.stage("repair");
    note(RepairStepKind::DropFlat, dropFlat(soup_), "left out, since they have no area");
    note(RepairStepKind::DropDuplicates, dropDuplicates(soup_), "left out, since they are duplicates");
    alignWinding(soup_);  // cracks and T-junctions are open edges only if neighbours have the same winding
    const Stitched stitched = stitchCracks(soup_, input_.triangles.size(), max_triangles_, work_);
    if (stitched.welded + stitched.split > 0) {
      for (std::size_t t = 0; t < is_modified_.size(); ++t) is_modified_[t] |= stitched.is_modified[t];
      steps_.push_back({RepairStepKind::StitchCracks,
                        "cracks stitched: " + counted(stitched.welded, "vertex", "vertices") + " joined with others, " +
                            std::to_string(stitched.split) + " put into an edge of a neighbour; moved by at most " +
                            number(stitched.moved) + " mm.",
                        stitched.welded + stitched.split,
                        stitched.moved,
                        {}});
      dropFlat(soup_);  // their sources are modified, and therefore still covered
      dropDuplicates(soup_);
    }
    dropFins();
    alignWinding(soup_);
    countTurned();
  }

  void dropFins() {
    const RepairSoup whole = soup_;
    std::vector<std::uint32_t> removed = builder::dropFins(soup_, work_);
    if (removed.empty()) return;
    std::vector<std::uint32_t> removed_triangles;
    for (std::uint32_t t = 0; t < whole.source.size(); ++t)
      if (std::binary_search(removed.begin(), removed.end(), whole.source[t])) removed_triangles.push_back(t);
    const double height = farthestFrom(DistanceField(soup_.mesh), whole.mesh, removed_triangles, kNegligible * diagonal_, progress_);
    steps_.push_back({RepairStepKind::DropFins,
                      counted(removed.size(), "triangle", "triangles") + " of fins left out, that stand on an edge of the rest, up to " +
                          number(height) + " mm high.",
                      removed.size(), height, removed});
  }

  /// Counts the turned triangles among those that are otherwise unchanged.
  void countTurned() {
    std::size_t turned = 0;
    for (std::size_t t = 0; t < soup_.source.size(); ++t) {
      if (soup_.source[t] == kNone) continue;
      Triangle before = input_.triangles[soup_.source[t]];
      const Triangle& after = soup_.mesh.triangles[t];
      const auto at = std::ranges::find(before, after[0]);
      if (at == before.end()) continue;
      std::rotate(before.begin(), at, before.end());
      turned += before[1] == after[2] && before[2] == after[1];
    }
    if (turned > 0)
      steps_.push_back({RepairStepKind::AlignWinding,
                        counted(turned, "triangle", "triangles") + " turned to agree with their neighbours.",
                        turned,
                        0,
                        {}});
  }

  void closeBorders() {
    const TriangleMesh before = soup_.mesh;
    const std::vector<FilledHole> holes = fillHoles(soup_, work_);
    if (holes.empty()) return;
    const DistanceField surface(before);
    for (const RepairStepKind kind : {RepairStepKind::FillHoles, RepairStepKind::CapOpenings}) {
      std::vector<std::uint32_t> added;
      std::size_t count = 0;
      double longest = 0;
      for (const FilledHole& hole : holes) {
        if ((hole.across >= kHole * diagonal_) != (kind == RepairStepKind::CapOpenings)) continue;
        ++count;
        longest = std::max(longest, hole.length);
        added.insert(added.end(), hole.triangles.begin(), hole.triangles.end());
      }
      if (count == 0) continue;
      const double far = farthestFrom(surface, soup_.mesh, added, kNegligible * diagonal_, progress_);
      const std::string what = kind == RepairStepKind::FillHoles ? counted(count, "hole", "holes") + " filled"
                                                                 : counted(count, "opening", "openings") + " closed";
      steps_.push_back({kind,
                        what + " with " + counted(added.size(), "triangle", "triangles") + ", the longest border " + number(longest) +
                            " mm; no point of a filling is farther than " + number(far) + " mm from the surface.",
                        count,
                        far,
                        {}});
    }
  }

  MeshReport turnOutward(const MeshReport& state) {
    noteTurned(state.count(DefectKind::InsideOut));
    soup_.mesh = orientOutward(std::move(soup_.mesh), state);
    return checkMesh(soup_.mesh, kPlacesListed, progress_);
  }

  /// While triangles cross, the check cannot tell which components are inside out; the sign of the volume decides. If
  /// they were cut unturned, they would bound nothing.
  MeshReport turnCrossing(MeshReport state) {
    const std::size_t count = turnInward(soup_, state.component_of, work_);
    if (count == 0) return state;
    noteTurned(count);
    return checkMesh(soup_.mesh, kPlacesListed, progress_);
  }

  void noteTurned(std::size_t count) {
    steps_.push_back(
        {RepairStepKind::TurnOutward, "inside out and turned: " + counted(count, "component", "components") + ".", count, 0, {}});
  }

  static bool needsCuts(const MeshReport& state) {
    return std::ranges::any_of(state.defects, [](const Defect& d) { return d.kind != DefectKind::NonManifoldVertex; });
  }

  bool resolve(int round) {
    progress_.stage("overlaps");
    // First the resolution of single precision, in each further round four times as wide.
    const double grid =
        round < kFreeRounds ? 0 : std::exp2(std::ilogb(diagonal_) - std::numeric_limits<float>::digits + 2 * (round - kFreeRounds));
    // The winding directions around a sheet that cannot be oriented are arbitrary.
    const Resolved resolved = resolveOverlaps(soup_, {kMaxCrossingPairs, max_triangles_}, grid,
                                              is_sheet_ ? report_.area : may_be_lost_ - lost_area_, progress_, work_);
    gives_up_ |= resolved.is_stopped;
    if (resolved.is_stopped || soup_.mesh.triangles.empty()) return false;
    lost_area_ += resolved.lost_area;
    if (lost_area_ > may_be_lost_) return false;
    for (const std::uint32_t source : resolved.lost) is_modified_[source] = 1, lost_.insert(source);  // still have to be covered
    for (const std::uint32_t source : resolved.moved) is_modified_[source] = 1;
    RepairStep* step = find(RepairStepKind::ResolveOverlaps);
    if (!step) {
      steps_.push_back({RepairStepKind::ResolveOverlaps, {}, 0, 0, {}});
      step = &steps_.back();
    }
    step->count = std::max(step->count, resolved.crossing_pairs);
    step->removed.insert(step->removed.end(), resolved.within.begin(), resolved.within.end());
    std::sort(step->removed.begin(), step->removed.end());
    step->removed.erase(std::unique(step->removed.begin(), step->removed.end()), step->removed.end());
    partly_.insert(resolved.partly_within.begin(), resolved.partly_within.end());
    step->text = "overlaps resolved: " + counted(step->count, "pair", "pairs") + " of triangles that cross cut along each other; " +
                 counted(step->removed.size(), "triangle", "triangles") + " wholly and " + std::to_string(partly_.size()) +
                 " in part left out, that lie within solid matter.";
    if (!lost_.empty())
      step->text += " " + counted(lost_.size(), "triangle", "triangles") + " with nothing solid on either side, covered all the same.";
    is_either_way_ |= resolved.is_either_way;
    if (is_either_way_) step->text += " Volume with reversed winding counts as solid, too.";
    // Rounded corners may coincide or be collinear.
    dropFlat(soup_);
    Stitched stitched = stitchCracks(soup_, input_.triangles.size(), max_triangles_, work_);
    for (std::size_t t = 0; t < is_modified_.size() && !stitched.is_modified.empty(); ++t) is_modified_[t] |= stitched.is_modified[t];
    step->change_mm += stitched.moved + resolved.snapped;
    dropFlat(soup_);
    for (const std::uint32_t source : cancelOpposites(soup_)) is_modified_[source] = 1;
    if (!findOpenEdges(soup_.mesh).empty()) fillHoles(soup_, work_);
    return true;
  }

  void separate() {
    for (const std::uint32_t source : cancelOpposites(soup_)) is_modified_[source] = 1;  // a filling may coincide with the rest
    if (!findOpenEdges(soup_.mesh).empty()) return;
    const SeparatedFans fans = separateFans(soup_, kNegligible * diagonal_);
    if (fans.copies == 0) return;
    for (std::size_t t = 0; t < fans.is_moved.size(); ++t)
      if (fans.is_moved[t] && soup_.source[t] != kNone) is_modified_[soup_.source[t]] = 1;
    RepairStep* step = find(RepairStepKind::SeparateBodies);
    if (!step) {
      steps_.push_back({RepairStepKind::SeparateBodies, {}, 0, 0, {}});
      step = &steps_.back();
    }
    step->count += fans.copies;
    step->change_mm += fans.moved;
    step->text = "bodies that touch drawn apart at " + counted(step->count, "vertex", "vertices") + ", by at most " +
                 number(step->change_mm) + " mm.";
  }

  std::optional<RepairedMesh> finish(const MeshReport& state) {
    if (find(RepairStepKind::CapOpenings) && !(2 * std::abs(state.volume) > kThin * diagonal_ * state.area)) {  // folded onto itself
      is_sheet_ = true;
      return {};
    }
    RepairedMesh out;
    if (const std::size_t buried = state.buriedComponents(); buried > 0) {
      std::vector<std::uint32_t> removed;
      for (std::size_t t = 0; t < soup_.source.size(); ++t)
        if (state.components[state.component_of[t]].buried && soup_.source[t] != kNone) removed.push_back(soup_.source[t]);
      std::sort(removed.begin(), removed.end());
      removed.erase(std::unique(removed.begin(), removed.end()), removed.end());
      steps_.push_back({RepairStepKind::DropBuried,
                        "left out, since within solid matter they bound nothing: " + counted(buried, "component", "components") + ".",
                        buried, 0, std::move(removed)});
      soup_.mesh = withoutBuried(soup_.mesh, state);
    }
    dropUnusedVertices(soup_.mesh);
    out.mesh = std::move(soup_.mesh);
    out.result = checkMesh(out.mesh, kPlacesListed, progress_);
    const std::vector<char> is_removed = removed();
    std::vector<std::uint32_t> modified;
    for (std::uint32_t t = 0; t < is_modified_.size(); ++t)
      if (is_modified_[t] && !is_removed[t]) modified.push_back(t);
    out.bound_mm = moved();
    if (!modified.empty()) {
      PartsNearSurface clipped = clipToDepth(DistanceField(out.mesh), input_, modified, kDeep * diagonal_, progress_);
      out.to_cover = std::move(clipped.pieces);
      partly_.insert(clipped.removed.begin(), clipped.removed.end());
      partly_.insert(clipped.partly.begin(), clipped.partly.end());
    }
    for (const std::uint32_t t : partly_)
      if (!is_removed[t]) out.partly.push_back(t);
    out.steps = std::move(steps_);
    return out;
  }

  /// For each triangle of the input: whether a step removed it.
  std::vector<char> removed() const {
    std::vector<char> is_removed(input_.triangles.size(), 0);
    for (const RepairStep& step : steps_)
      for (const std::uint32_t t : step.removed) is_removed[t] = 1;
    return is_removed;
  }

  /// How far the steps that move vertices can have moved one.
  double moved() const {
    double sum = 0;
    for (const RepairStep& step : steps_)
      if (step.kind == RepairStepKind::StitchCracks || step.kind == RepairStepKind::SeparateBodies ||
          step.kind == RepairStepKind::ResolveOverlaps)
        sum += step.change_mm;
    return sum;
  }

  RepairStep* find(RepairStepKind kind) {
    const auto at = std::ranges::find(steps_, kind, &RepairStep::kind);
    return at == steps_.end() ? nullptr : &*at;
  }

  const TriangleMesh& input_;
  const MeshReport& report_;
  Progress& progress_;
  RepairWork work_;
  std::size_t max_triangles_;
  double diagonal_;
  RepairSoup soup_;
  std::vector<char>
      is_modified_;  // for each triangle of the input: whether it is not exactly part of the result and still has to be covered
  std::vector<RepairStep> steps_;
  double may_be_lost_ = kLostArea * report_.area, lost_area_ = 0;
  std::set<std::uint32_t> partly_;  // triangles of the input that are removed where they lie within solid matter
  std::set<std::uint32_t> lost_;    // triangles of the input of which at least a part has nothing solid on either side
  bool is_either_way_ = false, is_sheet_ = false, gives_up_ = false;
};

/// The steps that a sound mesh may need, and the only ones with `off`.
RepairedMesh fixed(const TriangleMesh& mesh, const MeshReport& report) {
  RepairedMesh out;
  out.mesh = mesh;
  if (const std::size_t count = report.count(DefectKind::InsideOut); count > 0) {
    out.mesh = orientOutward(std::move(out.mesh), report);
    out.steps.push_back(
        {RepairStepKind::TurnOutward, "inside out and turned: " + counted(count, "component", "components") + ".", count, 0, {}});
  }
  if (const std::size_t buried = report.buriedComponents(); buried > 0) {
    std::vector<std::uint32_t> removed;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
      if (report.components[report.component_of[t]].buried) removed.push_back(t);
    out.mesh = withoutBuried(out.mesh, report);
    out.steps.push_back({RepairStepKind::DropBuried,
                         "left out, since within solid matter they bound nothing: " + counted(buried, "component", "components") + ".",
                         buried, 0, std::move(removed)});
  }
  return out;
}

}  // namespace

std::string_view name(RepairStepKind kind) {
  switch (kind) {
    case RepairStepKind::DropFlat:
      return "drop flat";
    case RepairStepKind::DropDuplicates:
      return "drop duplicates";
    case RepairStepKind::StitchCracks:
      return "stitch cracks";
    case RepairStepKind::DropFins:
      return "drop fins";
    case RepairStepKind::AlignWinding:
      return "align winding";
    case RepairStepKind::FillHoles:
      return "fill holes";
    case RepairStepKind::CapOpenings:
      return "cap openings";
    case RepairStepKind::TurnOutward:
      return "turn outward";
    case RepairStepKind::ResolveOverlaps:
      return "resolve overlaps";
    case RepairStepKind::SeparateBodies:
      return "separate bodies";
    case RepairStepKind::DropBuried:
      return "drop buried";
    case RepairStepKind::Wrap:
      break;
  }
  return "wrap";
}

RepairedMesh repairMesh(const TriangleMesh& mesh, RepairKind kind, Progress& progress) {
  const MeshReport report = checkMesh(mesh, kPlacesListed, progress);
  RepairedMesh out;
  if (kind != RepairKind::Wrap && (report.clean() || (kind == RepairKind::Auto && report.fixable()))) {
    out = fixed(mesh, report);
  } else if (kind == RepairKind::Off || isBeyondRepair(report)) {
    out.mesh = mesh;
    out.result = report;
  } else {
    std::optional<RepairedMesh> repaired;
    bool is_solid = false, gave_up = false;
    if (kind == RepairKind::Auto) {
      Repair repair(mesh, report, progress);
      repaired = repair.repair();
      is_solid = !repair.isSheet();
      gave_up = repair.givesUp();
    }
    out = repaired ? std::move(*repaired) : Repair(mesh, report, progress).wrap(is_solid, gave_up);
  }
  out.report = report;
  return out;
}

std::optional<Difference> subtractSolid(const TriangleMesh& from, const TriangleMesh& taken, Progress& progress) {
  const MeshReport report = checkMesh(from, kPlacesListed, progress);
  return Repair(from, report, progress, taken.triangles.size()).without(taken);
}

}  // namespace spheretree::builder
