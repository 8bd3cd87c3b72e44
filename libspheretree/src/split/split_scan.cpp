// SPDX-License-Identifier: GPL-3.0-or-later
#include "split/split_scan.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdio>
#include <map>
#include <numeric>
#include <stdexcept>

#include "mesh/crossing_triangles.h"
#include "mesh/mesh_edges.h"
#include "repair/repair_soup.h"
#include "spheretree/builder/build_settings.h"
#include "spheretree/builder/mesh_checks.h"
#include "spheretree/builder/repair_mesh.h"
#include "spheretree/core/mesh_edit.h"
#include "split/close_scan.h"
#include "split/cut_labels.h"
#include "split/fill_scan.h"
#include "split/label_pieces.h"
#include "split/part_solids.h"
#include "split/untangle_scan.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr double kStubMargin = 1;    // thickness of the gum below the stubs [mm]
constexpr double kOpenShare = 0.05;  // of the area of a scan: its vector area; less is a closed surface with small holes
constexpr int kMaxRecuts = 3;        // rounds of removing triangles that a wall crosses

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

double volumeOf(const TriangleMesh& mesh) {  // by the divergence theorem, about a vertex
  double sixfold = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vector3d& o = mesh.positions[0];
    sixfold += (mesh.corner(t, 0) - o).dot((mesh.corner(t, 1) - o).cross(mesh.corner(t, 2) - o));
  }
  return sixfold / 6;
}

class Splitter {
 public:
  Splitter(const SplitSettings& settings, Progress& progress) : settings_(settings), progress_(progress) {}

  SplitScan run(const TriangleMesh& scan, std::span<const std::int32_t> labels) {
    progress_.stage("labels");
    prepare(scan, {labels.begin(), labels.end()});
    const LabelPieces pieces = findLabelPieces(surface_.mesh, surface_.vertex_region, settings_.min_area_mm2);
    if (pieces.region_label.size() < 2)
      throw BuildError("no label other than gum (0) has " + number(settings_.min_area_mm2) + " mm2 or more: there is no tooth to cut out.");
    if (pieces.islands > 0)
      out_.notes.push_back(std::to_string(pieces.islands) + (pieces.islands == 1 ? " island" : " islands") + " of less than " +
                           number(settings_.min_area_mm2) + " mm2 joined the neighbour around.");
    surface_.is_doubtful = pieces.is_island;
    surface_.vertex_region = pieces.region;
    surface_.region_label = pieces.region_label;
    progress_.check();
    progress_.stage("cut");
    out_.lost_area = out_.scan_area - surfaceArea(surface_.mesh);
    const double base = std::max(settings_.base_mm, settings_.root_mm > 0 ? settings_.root_mm + kStubMargin : 0);
    out_.moved = untangleScan(surface_);
    const double untangled = surfaceArea(surface_.mesh);
    const std::size_t crossed = dropCrossings(surface_);
    clearBase(surface_, out_.up, base);
    out_.holes = fillScanHoles(surface_);
    noteCrossings(crossed, untangled - scannedArea());
    const PartSolids solids = cutAndClose(base);
    out_.lost_area = std::max(0.0, out_.lost_area + untangled - scannedArea());
    finishParts(pieces, solids);
    countCrossings();
    return std::move(out_);
  }

 private:
  /// Makes a manifold surface without debris, and determines the upward direction.
  void prepare(const TriangleMesh& scan, std::vector<std::int32_t> labels) {
    out_.scan_area = surfaceArea(scan);
    RepairSoup soup{{scan.positions, scan.triangles, {}, {}}, std::vector<std::uint32_t>(scan.triangles.size())};
    std::iota(soup.source.begin(), soup.source.end(), 0u);
    dropFlat(soup);
    dropDuplicates(soup);
    alignWinding(soup);
    RepairWork work(progress_);
    const std::size_t max_triangles = 4 * scan.triangles.size();  // as repairMesh() limits it
    stitchCracks(soup, scan.triangles.size(), max_triangles, work);
    dropFlat(soup);
    dropDuplicates(soup);
    double surplus = surfaceArea(soup.mesh);
    std::size_t removed = soup.mesh.triangles.size();
    dropFins(soup, work);
    alignWinding(soup);
    TriangleMesh& mesh = soup.mesh;
    makeManifold(mesh);
    surplus -= surfaceArea(mesh), removed -= mesh.triangles.size();
    if (removed > 0)
      out_.notes.push_back(std::to_string(removed) + " triangles with " + number(surplus) +
                           " mm2 were left out where several layers of the scan are connected.");
    dropDebris(mesh);
    if (mesh.triangles.empty()) throw BuildError("the scan has no surface of " + number(settings_.min_area_mm2) + " mm2 or more.");
    keepUsed(mesh, labels);
    findUp(mesh, labels);
    surface_.is_invented.assign(mesh.triangles.size(), 0);
    surface_.vertex_region = std::move(labels);
    surface_.mesh = std::move(mesh);
  }

  /// An open scan looks up. The normals of a closed one, such as a cast with its base, cancel one another; those of its
  /// crowns do not.
  void findUp(const TriangleMesh& mesh, const std::vector<std::int32_t>& labels) {
    Vector3d whole = Vector3d::Zero(), crowns = Vector3d::Zero();
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const Vector3d normal = (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0)) / 2;
      whole += normal;
      if (std::all_of(mesh.triangles[t].begin(), mesh.triangles[t].end(), [&](std::uint32_t v) { return labels[v] != kGumLabel; }))
        crowns += normal;
    }
    const bool is_closed = !(whole.norm() > kOpenShare * surfaceArea(mesh));
    if (settings_.up) {
      out_.up = settings_.up->normalized();
    } else if (is_closed) {
      if (!(crowns.norm() > 0)) throw BuildError("the scan is closed, so up cannot be told. Say it: --up X,Y,Z.");
      out_.up = crowns.normalized();
      out_.notes.push_back("The scan is closed, so up cannot be told from it as a whole: it is where the crowns look, (" +
                           number(out_.up.x()) + ", " + number(out_.up.y()) + ", " + number(out_.up.z()) +
                           "). If it is not, add --up X,Y,Z.");
    } else {
      out_.up = whole.normalized();
    }
  }

  void dropDebris(TriangleMesh& mesh) {
    Groups groups(mesh.positions.size());
    for (const Triangle& t : mesh.triangles) groups.join(t[0], t[1]), groups.join(t[1], t[2]);
    std::map<std::uint32_t, double> area;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) area[groups.root(mesh.triangles[t][0])] += triangleArea(mesh, t);
    const auto dropped = std::count_if(area.begin(), area.end(), [&](const auto& a) { return a.second < settings_.min_area_mm2; });
    if (dropped == 0) return;
    std::erase_if(mesh.triangles, [&](const Triangle& t) { return area.at(groups.root(t[0])) < settings_.min_area_mm2; });
    out_.notes.push_back(std::to_string(dropped) + " loose pieces of less than " + number(settings_.min_area_mm2) + " mm2 were left out.");
  }

  void noteCrossings(std::size_t removed, double filled_area) {
    if (out_.moved.count > 0)
      out_.notes.push_back("The scan crossed itself: " + std::to_string(out_.moved.count) + " vertices were moved, by " +
                           number(out_.moved.mean) + " mm on average and at most " + number(out_.moved.farthest) + " mm.");
    if (removed > 0)
      out_.notes.push_back("The scan crosses itself: " + std::to_string(removed) + " triangles were left out, and with those round them " +
                           number(filled_area) + " mm2 of it was filled.");
  }

  /// Area of the surface that is not invented.
  double scannedArea() const {
    double area = 0;
    for (std::size_t t = 0; t < surface_.mesh.triangles.size(); ++t)
      if (!surface_.is_invented[t]) area += triangleArea(surface_.mesh, t);
    return area;
  }

  /// Cuts the surface and closes the regions. Noise can leave a part of a crown no thicker than its triangles, and a
  /// crown can reach under its own border, so that every wall crosses them. Then these triangles and those around them
  /// are removed, the holes are filled, and the cut is made anew.
  PartSolids cutAndClose(double base) {
    const double area = scannedArea();
    std::size_t removed = 0;
    for (int round = 0;; ++round) {
      ScanSurface uncut = surface_;
      cutLabels(surface_, settings_.smooth_mm);
      progress_.check();
      progress_.stage("close");
      addBase(surface_, out_.up, base);
      PartSolids solids = findWalls(surface_, {out_.up, settings_.root_mm});
      progress_.check();
      const std::vector<char> is_dropped = around(uncut, solids.crossed);
      if (round == kMaxRecuts || is_dropped.empty()) {
        if (removed > 0)
          out_.notes.push_back("No wall could pass " + std::to_string(removed) + " triangles: these and those around them, " +
                               number(area - scannedArea()) + " mm2 of the scan, were left out.");
        if (!solids.short_roots.empty())
          out_.notes.push_back(std::to_string(solids.short_roots.size()) + " roots are shorter than " + number(settings_.root_mm) +
                               " mm, since longer ones would cross something; the shortest has " +
                               number(*std::min_element(solids.short_roots.begin(), solids.short_roots.end())) + " mm.");
        return solids;
      }
      removed += solids.crossed.size();
      dropTriangles(uncut, is_dropped);
      surface_ = std::move(uncut);
      progress_.stage("cut");
      clearBase(surface_, out_.up, base);
      out_.holes = fillScanHoles(surface_);
    }
  }

  /// True for all fillings, and for the triangles of the scan at each vertex of the given triangles of the cut surface.
  /// Empty if there are no such triangles: where only the base is crossed, another round would change nothing.
  std::vector<char> around(const ScanSurface& uncut, const std::vector<std::uint32_t>& cut_triangles) const {
    std::vector<char> is_around = uncut.is_invented, is_bad(surface_.mesh.positions.size(), 0);
    for (const std::uint32_t t : cut_triangles)
      for (const std::uint32_t v : surface_.mesh.triangles[t]) is_bad[v] = 1;  // each piece of a triangle has one of its corners
    bool is_any = false;
    for (std::size_t t = 0; t < is_around.size(); ++t)
      for (const std::uint32_t v : uncut.mesh.triangles[t])
        if (is_bad[v]) is_around[t] = is_any = true;
    return is_any ? is_around : std::vector<char>();
  }

  static void keepUsed(TriangleMesh& mesh, std::vector<std::int32_t>& labels) {
    std::vector<char> is_used(mesh.positions.size(), 0);
    for (const Triangle& t : mesh.triangles)
      for (const std::uint32_t v : t) is_used[v] = 1;
    std::size_t kept = 0;
    for (std::size_t v = 0; v < is_used.size(); ++v)
      if (is_used[v]) labels[kept++] = labels[v];
    labels.resize(kept);
    dropUnusedVertices(mesh);
  }

  void finishParts(const LabelPieces& pieces, const PartSolids& solids) {
    std::vector<std::int32_t> order;
    for (std::int32_t region = 1; region < static_cast<std::int32_t>(pieces.region_label.size()); ++region) order.push_back(region);
    order.push_back(kGumRegion);
    double rims = 0;
    for (std::size_t i = 0; i < order.size(); ++i) {
      progress_.check();
      progress_.stage("mend");
      progress_.advance(static_cast<double>(i) / static_cast<double>(order.size()));
      const auto region = static_cast<std::size_t>(order[i]);
      SplitPart part;
      part.label = pieces.region_label[region];
      part.piece = pieces.region_piece[region];
      part.mesh = solidOf(surface_, solids, order[i], part.is_invented);
      if (part.mesh.triangles.empty()) continue;
      for (std::size_t t = 0; t < part.mesh.triangles.size(); ++t)
        (part.is_invented[t] ? part.invented_area : part.scanned_area) += triangleArea(part.mesh, t);
      part.rim_length = solids.rim_length[region];
      rims += part.rim_length;
      if (order[i] == kGumRegion) part.rim_length = rims;
      mend(part);
      out_.parts.push_back(std::move(part));
    }
  }

  void mend(SplitPart& part) {
    RepairedMesh repaired = repairMesh(part.mesh, RepairKind::Auto, progress_);
    for (const RepairStep& step : repaired.steps) part.notes.push_back(step.text);
    part.is_sound = repaired.isSound();
    if (!repaired.steps.empty() && part.is_sound) {
      part.mesh = std::move(repaired.mesh);
      part.is_invented.clear();
    } else if (!part.is_sound && !repaired.result.defects.empty() && !repaired.result.defects[0].first.empty()) {
      part.fault = repaired.result.defects[0].first[0].point;
      part.notes.push_back(repaired.result.summary());
    }
    part.mesh.part.clear();
    part.mesh.part_names.clear();
    part.volume = volumeOf(part.mesh);
  }

  /// Counts the crossings of all solids together. Vertices at the same place count as one, so that walls that two
  /// solids share do not cross.
  void countCrossings() {
    progress_.stage("crossings");
    TriangleMesh all;
    std::vector<std::uint32_t> part_of;
    std::vector<Vector3d> points;
    for (const SplitPart& part : out_.parts) points.insert(points.end(), part.mesh.positions.begin(), part.mesh.positions.end());
    std::vector<std::uint32_t> order(points.size()), index(points.size());
    std::iota(order.begin(), order.end(), 0u);
    const auto less = [&](std::uint32_t a, std::uint32_t b) {
      return std::lexicographical_compare(points[a].data(), points[a].data() + 3, points[b].data(), points[b].data() + 3);
    };
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return less(a, b) || (!less(b, a) && a < b); });
    for (std::size_t i = 0; i < order.size(); ++i)
      index[order[i]] = i > 0 && !less(order[i - 1], order[i]) ? index[order[i - 1]] : order[i];
    all.positions = points;
    std::uint32_t first = 0;
    for (std::uint32_t p = 0; p < out_.parts.size(); ++p) {
      for (const Triangle& t : out_.parts[p].mesh.triangles) {
        all.triangles.push_back({index[first + t[0]], index[first + t[1]], index[first + t[2]]});
        part_of.push_back(p);
      }
      first += static_cast<std::uint32_t>(out_.parts[p].mesh.positions.size());
    }
    for (const auto& [a, b] : findCrossingTriangles(all, kMaxCrossingPairs, progress_).pairs) {
      if (part_of[a] == part_of[b]) continue;  // counted by the checks of the part
      ++out_.crossing_pairs;
      for (const std::uint32_t t : {a, b}) {
        SplitPart& part = out_.parts[part_of[t]];
        if (part.crossing_pairs++ == 0) part.crossing = (all.corner(t, 0) + all.corner(t, 1) + all.corner(t, 2)) / 3;
      }
    }
  }

  const SplitSettings& settings_;
  Progress& progress_;
  ScanSurface surface_;
  SplitScan out_;
};

}  // namespace

SplitScan splitScan(const TriangleMesh& scan, std::span<const std::int32_t> label_of_vertex, const SplitSettings& settings,
                    Progress& progress) {
  if (label_of_vertex.size() != scan.positions.size()) throw std::invalid_argument("a scan needs one label for each of its vertices");
  if (std::any_of(label_of_vertex.begin(), label_of_vertex.end(), [](std::int32_t label) { return label < 0; }))
    throw std::invalid_argument("the label of a vertex is negative");
  if (settings.up && !(settings.up->allFinite() && settings.up->norm() > 0)) throw std::invalid_argument("up is not a direction");
  if (!(settings.smooth_mm >= 0 && settings.min_area_mm2 >= 0 && settings.base_mm > 0 && settings.root_mm >= 0))
    throw std::invalid_argument("a length of the split is negative or no number");
  return Splitter(settings, progress).run(scan, label_of_vertex);
}

}  // namespace spheretree::builder
