// SPDX-License-Identifier: GPL-3.0-or-later
#include "page/comparison_page.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <optional>
#include <system_error>
#include <thread>

#include "child_process.h"
#include "page/chart.h"
#include "page/embedded.h"
#include "page/model.h"
#include "page/page.h"
#include "pipeline/evaluation_json.h"
#include "pipeline/sound_mesh.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/file_io.h"
#include "spheretree/formats/mesh_file.h"
#include "spheretree/formats/sphere_tree_file.h"

namespace spheretree::tool {
namespace {

namespace fs = std::filesystem;
using pipeline::Comparison;
using pipeline::LeafFigures;
using pipeline::MeanFigures;
using pipeline::MeshFigures;
using pipeline::Method;
using pipeline::Run;
using pipeline::Sensitivity;

struct Measure {
  double LeafFigures::*field;
  const char *title, *axis;
};
constexpr std::array<Measure, 3> kMeasures{
    {{&LeafFigures::overhang_percent, "Worst overhang", "Worst overhang [% of the diagonal]"},
     {&LeafFigures::p99_percent, "Usual overhang (99th percentile)", "Overhang, 99th percentile [% of the diagonal]"},
     {&LeafFigures::excess_percent, "Excess volume", "Volume outside the object [% of its volume]"}}};

std::string label(const Method& method) { return name(method.builder) + " \u00b7 " + std::string(name(method.quality)); }

ChartPoint pointOf(const Method& method, const LeafFigures& figures, const Measure& measure) {
  ChartPoint p;
  p.x = figures.processor_seconds;
  p.y = figures.*measure.field;
  p.series = name(method.builder);
  p.title = label(method) + ": " + shortNumber(p.x) + " s, " + shortNumber(p.y) + " %";
  p.size = static_cast<int>(method.quality);
  p.square = method.builder.search || method.builder.kind == builder::BuilderKind::Cover;
  return p;
}

constexpr const char* kSeconds = "Processor time [s]";

std::vector<std::string> meanCharts(const std::vector<MeanFigures>& means) {
  std::vector<std::string> charts;
  for (const Measure& measure : kMeasures) {
    ScatterChart chart{measure.title, kSeconds, measure.axis, {}, {}};
    for (const MeanFigures& mean : means) chart.points.push_back(pointOf(mean.method, mean.figures, measure));
    charts.push_back(scatterSvg(chart));
  }
  return charts;
}

/// Worst overhang of every level of the trees, and of other programs' spheres, against the number of spheres.
std::string countChart(const Comparison& comparison, const MeshFigures& mesh) {
  const double percent = 100 / mesh.diagonal_mm;
  ScatterChart chart{"Spheres against accuracy", "Spheres", "Worst overhang [% of the diagonal]", {}, {}};
  chart.front = false;  // a small overhang is no advantage if part of the surface is uncovered
  const auto add = [&](const std::string& series, const std::string& title, const builder::LevelEvaluation& level) {
    ChartPoint p;
    p.x = static_cast<double>(level.spheres);
    p.y = level.overhang.max * percent;
    p.series = series;
    p.title = title + ": " + std::to_string(level.spheres) + " spheres, " + shortNumber(p.y) + " %";
    if (level.coverage.uncovered_fraction > 0) p.title += ", " + shortNumber(100 * level.coverage.uncovered_fraction) + " % uncovered";
    chart.points.push_back(p);
  };
  for (std::size_t i = 0; i < comparison.runs.size(); ++i) {
    const Run& run = comparison.runs[i];
    if (run.mesh != mesh.name || !run.isBuilt()) continue;
    const auto isBetter = [&](const Run& other) {
      return other.mesh == run.mesh && other.isBuilt() && other.method.builder == run.method.builder &&
             other.method.quality > run.method.quality;
    };
    if (std::any_of(comparison.runs.begin(), comparison.runs.end(), isBetter)) continue;  // only the best quality of each builder
    for (const builder::LevelEvaluation& level : run.levels) add(name(run.method.builder), label(run.method), level);
  }
  for (const pipeline::OtherFigures& other : mesh.others) {
    const double bare = 100 * other.level.coverage.uncovered_fraction;
    add(other.name + (bare > 0 ? ", " + shortNumber(bare) + " % uncovered" : ""), other.name + " (" + other.format + ")", other.level);
  }
  return scatterSvg(chart);
}

std::vector<std::string> meshCharts(const Comparison& comparison, const MeshFigures& mesh) {
  std::vector<std::string> charts;
  for (const Measure& measure : kMeasures) {
    ScatterChart chart{measure.title, kSeconds, measure.axis, {}, {}};
    for (const Run& run : comparison.runs)
      if (run.mesh == mesh.name && run.isBuilt()) chart.points.push_back(pointOf(run.method, leafFigures(comparison, run), measure));
    for (const pipeline::OtherFigures& other : mesh.others) {
      if (!(other.seconds > 0)) continue;
      const LeafFigures figures{other.seconds, other.seconds, 100 * other.level.overhang.max / mesh.diagonal_mm,
                                100 * other.level.overhang.p99 / mesh.diagonal_mm, 100 * other.level.excess_volume_fraction};
      ChartPoint p;
      p.x = other.seconds;
      p.y = figures.*measure.field;
      p.series = other.name;
      p.title = other.name + ": " + shortNumber(p.x) + " s, " + shortNumber(p.y) + " %";
      chart.points.push_back(p);
    }
    if (&measure == kMeasures.data() && mesh.limits.h_low_in_range)
      chart.limit = {mesh.limits.h_low / mesh.diagonal_mm * 100, "h_low: about the smallest possible"};
    charts.push_back(scatterSvg(chart));
  }
  if (!mesh.others.empty()) charts.push_back(countChart(comparison, mesh));
  return charts;
}

std::string joined(const std::vector<std::string>& parts) {
  std::string out;
  for (const std::string& part : parts) out += part;
  return out;
}

/// The summary in two or three sentences.
std::string leadOf(const Comparison& comparison) {
  const std::vector<MeanFigures>& means = comparison.means;
  if (means.empty()) return "<p class=\"bad\">No builder made a tree of every mesh; the table of runs says why.</p>";
  const auto worst = [](const MeanFigures& m) { return m.figures.overhang_percent; };
  const MeanFigures* best = &means.front();
  for (const MeanFigures& mean : means)
    if (worst(mean) < worst(*best)) best = &mean;
  const auto figures = [&](const MeanFigures& m) {
    return shortNumber(worst(m)) + " % of the diagonal in " + shortNumber(m.figures.processor_seconds) + " s";
  };
  std::string out = "<p><b>" + escaped(label(best->method)) + "</b> has the smallest worst overhang: " + figures(*best);
  const MeanFigures* rival = nullptr;
  for (const MeanFigures& mean : means)
    if (mean.method.builder != best->method.builder && (!rival || worst(mean) < worst(*rival))) rival = &mean;
  if (rival)
    out += ", against " + figures(*rival) + " for the next best builder, " + escaped(label(rival->method)) + " (" +
           shortNumber(worst(*rival) / worst(*best)) + " times the overhang)";
  const std::size_t meshes = comparison.meshes.size();
  out += ".</p>\n<p class=\"note\">" +
         std::string(meshes == 1 ? "One mesh" : "Geometric means over " + std::to_string(meshes) + " meshes") + "; " +
         std::to_string(comparison.levels) + " levels, branching " + std::to_string(comparison.branching) + ", seed " +
         std::to_string(comparison.seed) + "; " + escaped(comparison.processor) + ", " + std::to_string(comparison.threads) +
         " threads. Overhang: how far the spheres reach out of the object; every tree covers its object.";
  const auto isTriedOn = [](const MeshFigures& mesh) { return !mesh.others.empty(); };
  if (std::any_of(comparison.meshes.begin(), comparison.meshes.end(), isTriedOn))
    out += " Spheres of other programs are listed with their meshes, with the share of the surface that they leave uncovered.";
  out += "</p>";
  return out;
}

std::string meansTable(const std::vector<MeanFigures>& means) {
  HtmlTable table{
      "Geometric means over the meshes, leaves of the trees",
      {"Builder \u00b7 quality", "Worst overhang [% D]", "Processor time [s]", "99th percentile [% D]", "Excess volume [%]", "Time [s]"},
      {}};
  for (const MeanFigures& m : means)
    table.rows.push_back({escaped(label(m.method)), shortNumber(m.figures.overhang_percent), shortNumber(m.figures.processor_seconds),
                          shortNumber(m.figures.p99_percent), shortNumber(m.figures.excess_percent), shortNumber(m.figures.seconds)});
  return table.html();
}

std::string runsTable(const Comparison& comparison, const MeshFigures& mesh) {
  HtmlTable table{mesh.name + ": leaves of each tree; D = " + shortNumber(mesh.diagonal_mm) + " mm",
                  {"Builder \u00b7 quality", "Worst overhang [% D]", "Processor time [s]", "Leaves", "99th percentile [% D]",
                   "Uncovered [%]", "Excess volume [%]"},
                  {}};
  for (const Run& run : comparison.runs) {
    if (run.mesh != mesh.name) continue;
    if (!run.isBuilt()) {
      table.rows.push_back({escaped(label(run.method)), "<span class=\"bad\">failed: " + escaped(run.error) + "</span>"});
      continue;
    }
    const LeafFigures figures = leafFigures(comparison, run);
    const builder::LevelEvaluation& leaves = run.levels.back();
    table.rows.push_back({escaped(label(run.method)), shortNumber(figures.overhang_percent), shortNumber(figures.processor_seconds),
                          std::to_string(leaves.spheres), shortNumber(figures.p99_percent),
                          shortNumber(100 * leaves.coverage.uncovered_fraction), shortNumber(figures.excess_percent)});
  }
  const double percent = 100 / mesh.diagonal_mm;
  for (const pipeline::OtherFigures& other : mesh.others)
    table.rows.push_back({escaped(other.name) + " <span class=\"note\">" + escaped(other.format) + "</span>",
                          shortNumber(other.level.overhang.max * percent), other.seconds > 0 ? shortNumber(other.seconds) : "\u2013",
                          std::to_string(other.level.spheres), shortNumber(other.level.overhang.p99 * percent),
                          shortNumber(100 * other.level.coverage.uncovered_fraction),
                          shortNumber(100 * other.level.excess_volume_fraction)});
  return table.html();
}

/// The largest change of each kind over the meshes that `is_shown` selects, for each builder and quality.
template <class Shows>
std::string sensitivityTable(const std::vector<Sensitivity>& entries, std::string caption, Shows&& is_shown) {
  HtmlTable table{std::move(caption), {"Builder \u00b7 quality"}, {}};
  struct Cell {
    double largest = 0;
    bool same = true;
  };
  std::vector<std::pair<Method, std::vector<Cell>>> by_method;
  for (const Sensitivity& entry : entries) {
    if (!is_shown(entry) || entry.rows.empty()) continue;
    if (table.heads.size() == 1)
      for (const builder::SensitivityRow& row : entry.rows) table.heads.push_back(escaped(row.change));
    auto at = std::find_if(by_method.begin(), by_method.end(), [&](const auto& l) { return l.first == entry.method; });
    if (at == by_method.end()) at = by_method.insert(at, {entry.method, std::vector<Cell>(entry.rows.size())});
    for (std::size_t i = 0; i < entry.rows.size() && i < at->second.size(); ++i) {
      at->second[i].largest = std::max(at->second[i].largest, entry.rows[i].largest_change);
      at->second[i].same = at->second[i].same && entry.rows[i].same_spheres;
    }
  }
  for (const auto& [method, cells] : by_method) {
    std::vector<std::string> row{escaped(label(method))};
    for (const Cell& cell : cells) row.push_back(cell.same ? "same spheres" : shortNumber(100 * cell.largest));
    table.rows.push_back(row);
  }
  return table.rows.empty() ? "" : table.html();
}

std::string sensitivitySection(const Comparison& comparison) {
  const std::vector<Sensitivity>& entries = *comparison.sensitivity;
  std::string out =
      "<p>How much the bound on the worst overhang of the leaves changes when the mesh is rotated, its vertices shifted by up to 0.05 % of "
      "the diagonal, vertices or triangles listed in another order, the object scaled, each triangle cut into four. Largest of all "
      "cases.</p>" +
      sensitivityTable(entries, "Largest change over all meshes [%]", [](const Sensitivity&) { return true; });
  if (comparison.meshes.size() > 1)
    for (const MeshFigures& mesh : comparison.meshes)
      out += "<details><summary>" + escaped(mesh.name) + "</summary>" +
             sensitivityTable(entries, "Largest change [%]", [&](const Sensitivity& entry) { return entry.mesh == mesh.name; }) +
             "</details>\n";
  for (const Sensitivity& entry : entries)
    if (!entry.error.empty())
      out += "<p class=\"bad\">" + escaped(entry.mesh) + ", " + escaped(label(entry.method)) + ": " + escaped(entry.error) + "</p>\n";
  return out;
}

/// Whether a run is on the Pareto front of its mesh, by time and worst overhang.
bool isOnFront(const Comparison& comparison, const Run& run) {
  return std::none_of(comparison.runs.begin(), comparison.runs.end(), [&](const Run& other) {
    return other.mesh == run.mesh && other.isBuilt() && other.processor_seconds < run.processor_seconds &&
           other.levels.back().overhang.max < run.levels.back().overhang.max;
  });
}

struct Shown {
  std::size_t triangles;  // for each mesh
  bool all_trees;
};

struct MeshInMemory {
  const MeshFigures* figures;
  TriangleMesh mesh;  // empty: it cannot be read
  std::optional<builder::SurfaceWithSheets> surface;
};

std::vector<MeshInMemory> readMeshes(const Comparison& comparison, builder::Progress& progress) {
  std::vector<MeshInMemory> out;
  for (const MeshFigures& figures : comparison.meshes) {
    progress.stage("mesh " + figures.name);
    progress.check();
    MeshInMemory& mesh = out.emplace_back();
    mesh.figures = &figures;
    try {
      std::vector<std::string> notes;
      builder::RepairedMesh repaired = pipeline::soundMesh(formats::readMesh(figures.file, figures.unit_mm, figures.unit_mm).mesh,
                                                           figures.file.string(), builder::RepairKind::Auto, notes, progress);
      mesh.mesh = std::move(repaired.mesh);
      mesh.surface = builder::surfaceWithSheets(mesh.mesh, repaired.to_cover);
    } catch (const formats::FileError&) {  // moved since: the trees are shown without it
    } catch (const formats::FormatError&) {
    } catch (const builder::BuildError&) {
    }
  }
  return out;
}

/// The figures of a level that the 3D view shows.
Json levelsForView(const Run& run) {
  Json out = Json::array();
  for (const builder::LevelEvaluation& level : run.levels) {
    const Json all = pipeline::levelJson(level);
    Json l{{"overhang_mm", {{"max", level.overhang.max}}}, {"max_gap_mm", level.coverage.max_gap}};
    for (const char* key : {"worst_overhang_at_mm", "worst_gap_at_mm"})
      if (all.contains(key)) l[key] = all.at(key);
    out.push_back(l);
  }
  return out;
}

std::string assemble(const Comparison& comparison, const fs::path& folder, const std::vector<MeshInMemory>& meshes, const Shown& shown,
                     builder::Progress& progress) {
  Page page("Comparison of sphere-tree builders", leadOf(comparison));
  page.addSection(
      "means", "Speed against accuracy",
      "<p>Lower left is better. The line is the Pareto front: no other dot is both faster and tighter than one on it. Small, medium and "
      "large: quick, standard, best. Discs: published methods and other programs; squares: with the cover search.</p><div "
      "class=\"charts\">" +
          joined(meanCharts(comparison.means)) + "</div>\n" + meansTable(comparison.means));
  std::string missing, by_mesh;
  std::size_t left_out = 0;
  page.data.root["meshes"] = Json::array();
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    progress.check();
    const MeshInMemory& mesh = meshes[i];
    const std::string& name = mesh.figures->name;
    Json entry{{"name", name}, {"trees", Json::array()}};
    if (mesh.surface)
      entry["mesh"] = packMesh(page.data, mesh.mesh, *mesh.surface, shown.triangles);
    else
      missing += " " + escaped(name);
    for (const Run& run : comparison.runs) {
      if (run.mesh != name || !run.isBuilt()) continue;
      if (!shown.all_trees && !isOnFront(comparison, run)) {
        ++left_out;
        continue;
      }
      const SphereTree tree = formats::readSphereTree(folder / run.tree);
      entry["trees"].push_back({{"label", label(run.method)},
                                {"tree", packTree(page.data, tree, mesh.surface ? &mesh.surface->field : nullptr)},
                                {"levels", levelsForView(run)}});
    }
    page.data.root["meshes"].push_back(entry);
    by_mesh += "<details" + std::string(meshes.size() == 1 ? " open" : "") + "><summary>" + escaped(name) + " <span class=\"note\">" +
               std::to_string(mesh.figures->triangles) + " triangles</span></summary><div class=\"charts\">" +
               joined(meshCharts(comparison, *mesh.figures)) + "</div>\n" + runsTable(comparison, *mesh.figures) +
               "<p><button type=\"button\" data-mesh=\"" + std::to_string(i) + "\">Show in 3D</button></p></details>\n";
  }
  std::string view =
      "<p>Drag or use the arrow keys to turn, wheel or + and \u2212 to come nearer, shift and drag to move. Meshes are thinned for this "
      "view; "
      "the figures are those of the whole mesh.</p><div class=\"view\"></div>";
  if (left_out > 0)
    view += "<p class=\"note\">" + std::to_string(left_out) +
            " trees off the Pareto fronts are not in this page; they are in the folder trees.</p>";
  if (!missing.empty()) view += "<p class=\"note\">Meshes that could not be read any more:" + missing + ".</p>";
  page.addSection("view", "In 3D", view);
  page.addSection("meshes", "Mesh by mesh", by_mesh);
  if (comparison.sensitivity) page.addSection("sensitivity", "Sensitivity to the mesh", sensitivitySection(comparison));
  return page.html(std::array{embedded::viewScript(), embedded::compareScript()});
}

// Writes the chart as SVG and, by rsvg-convert, as PDF. Returns why there is no PDF.
std::string writeChart(const fs::path& stem, const std::string& svg, builder::Progress& progress) {
  const fs::path in = fs::absolute(stem.string() + ".svg");
  formats::writeWhole(in, svg);
  const ScratchFolder scratch;
  const fs::path out = scratch / "chart.pdf", messages = scratch / "messages.txt";
  try {
    // The environment says what date the PDF names: the same charts are the same bytes.
    ChildProcess child("env", {"SOURCE_DATE_EPOCH=0", "rsvg-convert", "--format=pdf", "--output=" + out.string(), in.string()}, messages);
    while (!child.hasEnded()) {
      progress.check();
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    if (child.status() != 0) return "no charts as PDF: rsvg-convert (Debian: librsvg2-bin) is not installed or fails";
  } catch (const std::system_error& error) {
    return std::string("no charts as PDF: ") + error.what();
  }
  constexpr std::uint64_t kMaxBytes = std::uint64_t{1} << 26;
  formats::writeWhole(stem.string() + ".pdf", formats::readFile(out, kMaxBytes, formats::FileRole::Working));
  return {};
}

}  // namespace

std::string writeComparisonCharts(const Comparison& comparison, const fs::path& folder, builder::Progress& progress) {
  const std::size_t count = comparison.meshes.size();
  const std::string means = count == 1 ? comparison.meshes[0].name : "Geometric means over " + std::to_string(count) + " meshes";
  std::string missing = writeChart(folder / "comparison", svgFile(means, meanCharts(comparison.means)), progress);
  for (const MeshFigures& mesh : comparison.meshes)
    missing = writeChart(folder / mesh.name, svgFile(mesh.name, meshCharts(comparison, mesh)), progress);
  return missing;
}

std::string comparisonPage(const Comparison& comparison, const fs::path& folder, std::size_t max_bytes, builder::Progress& progress) {
  const std::vector<MeshInMemory> meshes = readMeshes(comparison, progress);
  progress.stage("page");
  std::string page;
  for (const Shown& shown : {Shown{4000, true}, Shown{1500, true}, Shown{4000, false}, Shown{1500, false}, Shown{500, false}}) {
    page = assemble(comparison, folder, meshes, shown, progress);
    if (page.size() <= max_bytes) break;
  }
  return page;
}

}  // namespace spheretree::tool
