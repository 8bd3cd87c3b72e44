// SPDX-License-Identifier: GPL-3.0-or-later
#include "comparison/comparison_page.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "commands/sound_mesh.h"
#include "page/chart.h"
#include "page/embedded.h"
#include "page/model.h"
#include "spheretree/builder/build_sphere_tree.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/file_io.h"
#include "spheretree/formats/mesh_file.h"
#include "spheretree/formats/sphere_tree_file.h"

namespace spheretree::tool {
namespace {

namespace fs = std::filesystem;

struct Measure {
  const char *key, *title, *axis;
};
constexpr std::array<Measure, 3> kMeasures{
    {{"overhang_percent", "Worst overhang", "Worst overhang [% of the diagonal]"},
     {"p99_percent", "Usual overhang (99th percentile)", "Overhang, 99th percentile [% of the diagonal]"},
     {"excess_percent", "Excess volume", "Volume outside the object [% of its volume]"}}};

/// The figures of a run that the charts show, or null if it failed.
Json figuresOf(const Json& run, double diagonal) {
  if (run.at("status") != "built") return nullptr;
  const Json& leaves = run.at("levels").back();
  const Json& overhang = leaves.at("overhang_mm");
  const double percent = 100 / diagonal;
  return {{"processor_seconds", run.at("processor_seconds")},
          {"seconds", run.at("seconds")},
          {"overhang_percent", overhang.at("max").get<double>() * percent},
          {"p99_percent", overhang.at("p99").get<double>() * percent},
          {"excess_percent", leaves.at("excess_volume_fraction").get<double>() * 100}};
}

double diagonalOf(const Json& comparison, const std::string& mesh) {
  for (const Json& m : comparison.at("meshes"))
    if (m.at("name") == mesh) return m.at("diagonal_mm").get<double>();
  throw formats::FormatError("compare.json: a run names the mesh '" + mesh +
                             "', which is not among the meshes. Run spheretree compare again.");
}

std::string label(const Json& entry) {
  return entry.at("builder").get<std::string>() + " \u00b7 " + entry.at("quality").get<std::string>();
}

int sizeOf(const std::string& quality) { return quality == "quick" ? 0 : quality == "best" ? 2 : 1; }

ChartPoint pointOf(const Json& entry, const Json& figures, const Measure& measure) {
  ChartPoint p;
  p.x = figures.at("processor_seconds").get<double>();
  p.y = figures.at(measure.key).get<double>();
  p.series = entry.at("builder").get<std::string>();
  p.title = label(entry) + ": " + shortNumber(p.x) + " s, " + shortNumber(p.y) + " %";
  p.size = sizeOf(entry.at("quality").get<std::string>());
  return p;
}

std::string seconds() { return "Processor time [s]"; }

std::vector<std::string> meanCharts(const Json& means) {
  std::vector<std::string> charts;
  for (const Measure& measure : kMeasures) {
    ScatterChart chart{measure.title, seconds(), measure.axis, {}, {}};
    for (const Json& mean : means) chart.points.push_back(pointOf(mean, mean, measure));
    charts.push_back(scatterSvg(chart));
  }
  return charts;
}

std::vector<std::string> meshCharts(const Json& comparison, const Json& mesh) {
  std::vector<std::string> charts;
  const double diagonal = mesh.at("diagonal_mm").get<double>();
  for (const Measure& measure : kMeasures) {
    ScatterChart chart{measure.title, seconds(), measure.axis, {}, {}};
    for (const Json& run : comparison.at("runs")) {
      if (run.at("mesh") != mesh.at("name") || run.at("status") != "built") continue;
      chart.points.push_back(pointOf(run, figuresOf(run, diagonal), measure));
    }
    const Json& limit = mesh.at("limit_mm");
    if (&measure == kMeasures.data() && limit.at("h_low_in_range").get<bool>())
      chart.limit = {limit.at("h_low").get<double>() / diagonal * 100, "h_low: about the least possible"};
    charts.push_back(scatterSvg(chart));
  }
  return charts;
}

std::string joined(const std::vector<std::string>& parts) {
  std::string out;
  for (const std::string& part : parts) out += part;
  return out;
}

std::string settingsWords(const Json& comparison) {
  const Json& s = comparison.at("settings");
  return s.at("levels").dump() + " levels, branching " + s.at("branching").dump() + ", seed " + s.at("seed").dump();
}

/// The verdict in two or three sentences.
std::string leadOf(const Json& comparison, const Json& means) {
  const std::size_t meshes = comparison.at("meshes").size();
  if (means.empty()) return "<p class=\"bad\">No builder made a tree of every mesh; the table of runs says why.</p>";
  const auto worst = [](const Json& m) { return m.at("overhang_percent").get<double>(); };
  const Json* best = &means.front();
  for (const Json& mean : means)
    if (worst(mean) < worst(*best)) best = &mean;
  const auto figures = [&](const Json& m) {
    return shortNumber(worst(m)) + " % of the diagonal in " + shortNumber(m.at("processor_seconds").get<double>()) + " s";
  };
  std::string out = "<p><b>" + escaped(label(*best)) + "</b> has the least worst overhang: " + figures(*best);
  const Json* rival = nullptr;
  for (const Json& mean : means)
    if (mean.at("builder") != best->at("builder") && (!rival || worst(mean) < worst(*rival))) rival = &mean;
  if (rival)
    out += ", against " + figures(*rival) + " for the next best builder, " + escaped(label(*rival)) + " (" +
           shortNumber(worst(*rival) / worst(*best)) + " times the overhang)";
  out += ".</p>\n<p class=\"note\">" +
         std::string(meshes == 1 ? "One mesh" : "Geometric means over " + std::to_string(meshes) + " meshes") + "; " +
         settingsWords(comparison) + "; " + escaped(comparison.at("machine").at("processor").get<std::string>()) + ", " +
         comparison.at("machine").at("threads").dump() +
         " threads. Overhang: how far the spheres reach out of the object; every tree covers its object.</p>";
  return out;
}

std::string meansTable(const Json& means) {
  HtmlTable table{
      "Geometric means over the meshes, leaves of the trees",
      {"Builder \u00b7 quality", "Processor time [s]", "Time [s]", "Worst overhang [% D]", "99th percentile [% D]", "Excess volume [%]"},
      {}};
  for (const Json& m : means) {
    std::vector<std::string> row{escaped(label(m))};
    for (const char* key : {"processor_seconds", "seconds", "overhang_percent", "p99_percent", "excess_percent"})
      row.push_back(shortNumber(m.at(key).get<double>()));
    table.rows.push_back(row);
  }
  return table.html();
}

std::string runsTable(const Json& comparison, const Json& mesh) {
  HtmlTable table{
      mesh.at("name").get<std::string>() + ": leaves of each tree; D = " + shortNumber(mesh.at("diagonal_mm").get<double>()) + " mm",
      {"Builder \u00b7 quality", "Processor time [s]", "Leaves", "Worst overhang [% D]", "99th percentile [% D]", "Uncovered [%]",
       "Excess volume [%]"},
      {}};
  for (const Json& run : comparison.at("runs")) {
    if (run.at("mesh") != mesh.at("name")) continue;
    const Json figures = figuresOf(run, mesh.at("diagonal_mm").get<double>());
    if (figures.is_null()) {
      table.rows.push_back({escaped(label(run)), "<span class=\"bad\">failed: " + escaped(run.value("error", "")) + "</span>"});
      continue;
    }
    const Json& leaves = run.at("levels").back();
    table.rows.push_back({escaped(label(run)), shortNumber(figures.at("processor_seconds").get<double>()), leaves.at("spheres").dump(),
                          shortNumber(figures.at("overhang_percent").get<double>()), shortNumber(figures.at("p99_percent").get<double>()),
                          shortNumber(100 * leaves.at("uncovered_fraction").get<double>()),
                          shortNumber(figures.at("excess_percent").get<double>())});
  }
  return table.html();
}

/// The largest change of each kind over the meshes that `is_shown` picks, for each builder and quality.
template <class Shows>
std::string stabilityTable(const Json& stability, std::string caption, Shows&& is_shown) {
  HtmlTable table{std::move(caption), {"Builder \u00b7 quality"}, {}};
  struct Cell {
    double largest = 0;
    bool same = true;
  };
  std::vector<std::pair<std::string, std::vector<Cell>>> by_label;
  for (const Json& entry : stability) {
    if (!is_shown(entry) || !entry.contains("rows")) continue;
    const Json& rows = entry.at("rows");
    if (table.heads.size() == 1)
      for (const Json& row : rows) table.heads.push_back(escaped(row.at("change").get<std::string>()));
    auto at = std::find_if(by_label.begin(), by_label.end(), [&](const auto& l) { return l.first == label(entry); });
    if (at == by_label.end()) at = by_label.insert(at, {label(entry), std::vector<Cell>(rows.size())});
    for (std::size_t i = 0; i < rows.size() && i < at->second.size(); ++i) {
      at->second[i].largest = std::max(at->second[i].largest, rows[i].at("largest_change").get<double>());
      at->second[i].same = at->second[i].same && rows[i].at("same_spheres").get<bool>();
    }
  }
  for (const auto& [name, cells] : by_label) {
    std::vector<std::string> row{escaped(name)};
    for (const Cell& cell : cells) row.push_back(cell.same ? "same spheres" : shortNumber(100 * cell.largest));
    table.rows.push_back(row);
  }
  return table.rows.empty() ? "" : table.html();
}

std::string stabilitySection(const Json& comparison) {
  const Json& stability = comparison.at("stability");
  std::string out =
      "<p>How much the bound on the worst overhang of the leaves changes when the mesh is turned, its vertices shifted by up to 0.05 % of "
      "the diagonal, vertices or triangles listed in another order, the object scaled, each triangle cut into four. Largest of all "
      "cases.</p>" +
      stabilityTable(stability, "Largest change over all meshes [%]", [](const Json&) { return true; });
  if (comparison.at("meshes").size() > 1)
    for (const Json& mesh : comparison.at("meshes"))
      out += "<details><summary>" + escaped(mesh.at("name").get<std::string>()) + "</summary>" +
             stabilityTable(stability, "Largest change [%]", [&](const Json& entry) { return entry.at("mesh") == mesh.at("name"); }) +
             "</details>\n";
  for (const Json& entry : stability)
    if (entry.contains("error"))
      out += "<p class=\"bad\">" + escaped(entry.at("mesh").get<std::string>()) + ", " + escaped(label(entry)) + ": " +
             escaped(entry.at("error").get<std::string>()) + "</p>\n";
  return out;
}

/// Whether a run is on the Pareto front of its mesh, by time and worst overhang.
bool isOnFront(const Json& comparison, const Json& run) {
  const Json mine = figuresOf(run, 1);
  for (const Json& other : comparison.at("runs")) {
    if (other.at("mesh") != run.at("mesh") || other.at("status") != "built") continue;
    const Json theirs = figuresOf(other, 1);
    if (theirs.at("processor_seconds") < mine.at("processor_seconds") && theirs.at("overhang_percent") < mine.at("overhang_percent"))
      return false;
  }
  return true;
}

struct Shown {
  std::size_t triangles;  // of a mesh
  bool all_trees;
};

struct MeshInMemory {
  Json entry;
  TriangleMesh mesh;  // empty: cannot be read
  std::optional<builder::SurfaceWithSheets> surface;
};

std::vector<MeshInMemory> readMeshes(const Json& comparison, builder::Progress& progress) {
  std::vector<MeshInMemory> out;
  for (const Json& entry : comparison.at("meshes")) {
    progress.stage("mesh " + entry.at("name").get<std::string>());
    progress.check();
    MeshInMemory& mesh = out.emplace_back();
    mesh.entry = entry;
    try {
      std::vector<std::string> notes;
      const std::string file = entry.at("file").get<std::string>();
      builder::RepairedMesh repaired =
          soundMesh(formats::readMesh(file, entry.value("unit_mm", 1.0)).mesh, file, builder::RepairKind::Auto, notes, progress);
      mesh.mesh = std::move(repaired.mesh);
      mesh.surface = builder::surfaceWithSheets(mesh.mesh, repaired.to_cover);
    } catch (const formats::FileError&) {  // moved since: the trees are shown without it
    } catch (const formats::FormatError&) {
    } catch (const builder::BuildError&) {
    }
  }
  return out;
}

/// Only what the 3D view shows of a level's figures.
Json levelsForView(const Json& run) {
  Json out = Json::array();
  for (const Json& level : run.at("levels")) {
    Json l{{"overhang_mm", {{"max", level.at("overhang_mm").at("max")}}}, {"max_gap_mm", level.at("max_gap_mm")}};
    for (const char* key : {"worst_overhang_at_mm", "worst_gap_at_mm"})
      if (level.contains(key)) l[key] = level.at(key);
    out.push_back(l);
  }
  return out;
}

std::string assemble(const Json& comparison, const Json& means, const fs::path& folder, const std::vector<MeshInMemory>& meshes,
                     const Shown& shown, builder::Progress& progress) {
  Page page("Comparison of sphere-tree builders", leadOf(comparison, means));
  page.addSection(
      "means", "Speed against accuracy",
      "<p>Lower left is better. The line is the Pareto front: no other dot is both faster and tighter than one on it. Small, medium and "
      "large dots: quick, standard, best.</p><div class=\"charts\">" +
          joined(meanCharts(means)) + "</div>\n" + meansTable(means));
  std::string missing, by_mesh;
  std::size_t left_out = 0;
  page.data.root["meshes"] = Json::array();
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    progress.check();
    const MeshInMemory& mesh = meshes[i];
    const std::string name = mesh.entry.at("name").get<std::string>();
    Json entry{{"name", name}, {"trees", Json::array()}};
    if (mesh.surface)
      entry["mesh"] = packMesh(page.data, mesh.mesh, *mesh.surface, shown.triangles);
    else
      missing += " " + escaped(name);
    for (const Json& run : comparison.at("runs")) {
      if (run.at("mesh") != name || run.at("status") != "built") continue;
      if (!shown.all_trees && !isOnFront(comparison, run)) {
        ++left_out;
        continue;
      }
      const SphereTree tree = formats::readSphereTree(folder / run.at("tree").get<std::string>());
      entry["trees"].push_back({{"label", label(run)},
                                {"tree", packTree(page.data, tree, mesh.surface ? &mesh.surface->field : nullptr)},
                                {"levels", levelsForView(run)}});
    }
    page.data.root["meshes"].push_back(entry);
    by_mesh += "<details" + std::string(meshes.size() == 1 ? " open" : "") + "><summary>" + escaped(name) + " <span class=\"note\">" +
               mesh.entry.at("triangles").dump() + " triangles</span></summary><div class=\"charts\">" +
               joined(meshCharts(comparison, mesh.entry)) + "</div>\n" + runsTable(comparison, mesh.entry) +
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
  if (comparison.contains("stability")) page.addSection("stability", "Stability", stabilitySection(comparison));
  return page.html(std::array{embedded::viewScript(), embedded::compareScript()});
}

}  // namespace

Json geometricMeans(const Json& comparison) {
  Json out = Json::array();
  const std::size_t meshes = comparison.at("meshes").size();
  std::vector<std::pair<std::string, std::vector<Json>>> by_method;
  for (const Json& run : comparison.at("runs")) {
    const Json figures = figuresOf(run, diagonalOf(comparison, run.at("mesh").get<std::string>()));
    if (figures.is_null()) continue;
    auto at = std::find_if(by_method.begin(), by_method.end(), [&](const auto& c) { return c.first == label(run); });
    if (at == by_method.end()) at = by_method.insert(at, {label(run), {}});
    Json entry = figures;
    entry["builder"] = run.at("builder");
    entry["quality"] = run.at("quality");
    at->second.push_back(entry);
  }
  for (const auto& [name, runs] : by_method) {
    if (runs.size() != meshes) continue;
    Json mean{{"builder", runs.front().at("builder")}, {"quality", runs.front().at("quality")}};
    for (const char* key : {"processor_seconds", "seconds", "overhang_percent", "p99_percent", "excess_percent"}) {
      double logs = 0;
      for (const Json& run : runs) logs += std::log(std::max(run.at(key).get<double>(), 1e-9));
      mean[key] = std::exp(logs / static_cast<double>(runs.size()));
    }
    out.push_back(mean);
  }
  return out;
}

void writeComparisonCharts(const Json& comparison, const fs::path& folder) {
  const std::string means = "Geometric means over " + std::to_string(comparison.at("meshes").size()) + " meshes";
  formats::writeWhole(folder / "comparison.svg", svgFile(means, meanCharts(geometricMeans(comparison))));
  for (const Json& mesh : comparison.at("meshes")) {
    const std::string name = mesh.at("name").get<std::string>();
    formats::writeWhole(folder / (name + ".svg"), svgFile(name, meshCharts(comparison, mesh)));
  }
}

std::string comparisonPage(const Json& comparison, const fs::path& folder, std::size_t most_bytes, builder::Progress& progress) {
  const Json means = geometricMeans(comparison);
  const std::vector<MeshInMemory> meshes = readMeshes(comparison, progress);
  progress.stage("page");
  std::string page;
  for (const Shown& shown : {Shown{4000, true}, Shown{1500, true}, Shown{4000, false}, Shown{1500, false}, Shown{500, false}}) {
    page = assemble(comparison, means, folder, meshes, shown, progress);
    if (page.size() <= most_bytes) break;
  }
  return page;
}

}  // namespace spheretree::tool
