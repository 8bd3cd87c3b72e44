// SPDX-License-Identifier: GPL-3.0-or-later
// The page of a batch: the summary, the objects, the scene in 3D.
#include <algorithm>
#include <array>
#include <map>

#include "page/embedded.h"
#include "page/recording.h"
#include "page/report_page.h"
#include "page/scene_view.h"
#include "pipeline/batch/batch_result.h"
#include "pipeline/batch/soften_items.h"
#include "pipeline/evaluation_json.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/file_io.h"
#include "spheretree/formats/scene_file.h"

namespace spheretree::tool {
namespace {

namespace fs = std::filesystem;
using pipeline::BatchResult;
using pipeline::ItemStatus;
using pipeline::ObjectResult;
using pipeline::SpeedRow;

constexpr const char* kDash = "\u2013";
constexpr const char* kChangedMuch = " had to be changed by more than the tolerance, a hundredth of the object or a tenth of its triangles";

std::string numberOrDash(const std::optional<double>& value) { return value ? shortNumber(*value) : kDash; }

std::string count(std::size_t n, const std::string& thing, const std::string& things = "") {
  return std::to_string(n) + " " + (n == 1 ? thing : things.empty() ? thing + "s" : things);
}

bool isRepairLarge(const ObjectResult& object) { return object.hasTree() && object.figures.isRepairLarge(); }

bool missed(const ObjectResult& object) { return object.hasTree() && !object.figures.tolerance_met.value_or(true); }

std::string leadOf(const BatchResult& result) {
  const pipeline::BatchTotals totals = totalsOf(result);
  const std::size_t objects = result.objects.size();
  const auto missing = static_cast<std::size_t>(std::count_if(result.objects.begin(), result.objects.end(), missed));
  std::string out = "<p>";
  const auto large = static_cast<std::size_t>(std::count_if(result.objects.begin(), result.objects.end(), isRepairLarge));
  if (totals.failed == 0 && missing > 0)
    out += "<span class=\"bad\">" + count(missing, "object") + " of " + std::to_string(objects) +
           " missed the tolerance asked for</span>; all are certified" +
           (large > 0 ? ", but " + count(large, "mesh", "meshes") + kChangedMuch : "");
  else if (totals.failed == 0 && large > 0)
    out += "<span class=\"warn\">All " + count(objects, "tree") + " are certified, but " + count(large, "mesh", "meshes") + kChangedMuch +
           "</span> (<a href=\"#repairs\">what was done</a>)";
  else if (totals.failed == 0)
    out += "<span class=\"good\">All " + count(objects, "tree") + " are whole and certified</span>";
  else
    out += "<span class=\"bad\">" + count(totals.failed, "object") + " of " + std::to_string(objects) +
           " failed</span>; the others are certified" +
           (large > 0 ? ", but <span class=\"warn\">" + count(large, "mesh", "meshes") + kChangedMuch + "</span>" : "");
  out += ": " + std::to_string(totals.leaves) + " leaves represent " + std::to_string(totals.triangles) +
         " triangles, and none reaches farther than <b>" + shortNumber(totals.overhang_bound_mm) + " mm</b> out of its object.</p>\n";
  if (totals.failed > 0 && missing > 0) out += "<p class=\"bad\">" + count(missing, "object") + " missed the tolerance asked for.</p>\n";
  out += "<p class=\"note\">" + std::to_string(totals.built) + " built and " + std::to_string(totals.cached) + " unchanged, in " +
         shortNumber(result.seconds) + " s; " + shortNumber(static_cast<double>(totals.bytes) / 1e6) + " MB of trees; scene " +
         escaped(result.scene.string()) + ".</p>";
  return out;
}

/// `index` of an object: its index among the placed objects of the scene, for its button.
std::string objectTable(const BatchResult& result, const std::map<std::string, std::size_t>& index) {
  HtmlTable table{"Objects; overhang of the leaves: how far they reach out of the object",
                  {"Object", "Overhang, proven [mm]", "Tolerance [mm]", "State", "99th percentile [mm]", "Leaves", "Triangles",
                   "Diagonal [mm]", "Build [s]"},
                  {}};
  for (const ObjectResult& o : result.objects) {
    const auto at = index.find(o.name);
    const std::string head = at == index.end() ? escaped(o.name) : objectButtons(o.name, at->second);
    if (!o.hasTree()) {
      table.rows.push_back({head, "<span class=\"bad\">failed:</span> " + escaped(o.error)});
      continue;
    }
    const pipeline::TreeFigures& f = o.figures;
    const pipeline::LevelFigures& leaves = f.levels.back();
    const std::string tolerance = numberOrDash(f.tolerance_mm);
    const std::string bound = numberOrDash(leaves.overhang_bound_mm);
    const std::string repaired = f.repair.empty() ? "" : f.isRepairLarge() ? ", <span class=\"warn\">repaired</span>" : ", repaired";
    table.rows.push_back({head, missed(o) ? "<span class=\"bad\">" + bound + "</span>" : bound, tolerance,
                          std::string(o.is_tool ? "tool, " : "") + (o.status == ItemStatus::Built ? "built" : "cached") + repaired +
                              (missed(o) ? ", <span class=\"bad\">tolerance missed</span>" : ""),
                          leaves.measured ? shortNumber(leaves.measured->overhang.p99) : kDash, std::to_string(f.leaves),
                          std::to_string(f.triangles), shortNumber(f.diagonal_mm), shortNumber(o.seconds)});
  }
  return table.html();
}

/// The repairs of the meshes before the build, the largest change first; empty if there were none.
std::string repairTable(const BatchResult& result) {
  std::vector<const ObjectResult*> repaired;
  for (const ObjectResult& o : result.objects)
    if (o.hasTree() && !o.figures.repair.empty()) repaired.push_back(&o);
  if (repaired.empty()) return "";
  std::stable_sort(repaired.begin(), repaired.end(),
                   [](const ObjectResult* a, const ObjectResult* b) { return a->figures.repairChange() > b->figures.repairChange(); });
  HtmlTable table{"Defective meshes; the largest change first",
                  {"Object", "Largest change [mm]", "Of its diagonal [%]", "Triangles left out", "What was done"},
                  {}};
  for (const ObjectResult* o : repaired) {
    const pipeline::TreeFigures& f = o->figures;
    std::string steps;
    for (const pipeline::RepairFigures& step : f.repair) steps += (steps.empty() ? "" : " ") + escaped(step.text);
    const std::size_t removed = f.removedTriangles();
    const auto marked = [](bool is_large, const std::string& text) { return is_large ? "<span class=\"warn\">" + text + "</span>" : text; };
    table.rows.push_back({escaped(o->name), marked(f.isChangeLarge(), shortNumber(f.repairChange())),
                          shortNumber(100 * f.repairChange() / f.diagonal_mm),
                          marked(f.isLossLarge(), std::to_string(removed) + " of " + std::to_string(f.input_triangles)),
                          "<span class=\"wrap words\">" + steps + "</span>"});
  }
  return "<p>The trees cover the input and the added surfaces. Check what is in colour: a change larger than the tolerance of the object "
         "or a hundredth of its diagonal, and more than a tenth of its triangles left out.</p>" +
         table.html();
}

/// Charts of the whole scene.
std::string speedCharts(const std::vector<SpeedRow>& rows) {
  ScatterChart leaves{"Leaves against overhang", "Leaves", "Overhang, proven [mm]", {}, {}},
      step{"Time of a servo step against overhang", "Step, 99th percentile [us]", "Overhang, proven [mm]", {}, {}};
  for (const SpeedRow& row : rows) {
    if (row.object) continue;
    ChartPoint p;
    p.x = static_cast<double>(row.leaves);
    p.y = row.overhang_bound_mm;
    p.chosen = row.chosen;
    p.series = p.chosen ? "chosen" : "";
    p.title = shortNumber(p.x) + " leaves, " + shortNumber(p.y) + " mm";
    leaves.points.push_back(p);
    if (!row.cost) continue;
    p.x = row.cost->time_us_p99;
    p.title = shortNumber(p.x) + " us, " + shortNumber(p.y) + " mm";
    step.points.push_back(p);
  }
  return "<p>Lower left is better; the ring marks the chosen trees.</p><div class=\"charts\">" + scatterSvg(leaves) +
         (step.points.empty() ? "" : scatterSvg(step)) + "</div>\n";
}

/// A dot for each object.
std::string objectCharts(const BatchResult& result) {
  std::vector<const ObjectResult*> objects;
  for (const ObjectResult& o : result.objects)
    if (o.hasTree() && o.figures.levels.back().overhang_bound_mm) objects.push_back(&o);
  std::stable_sort(objects.begin(), objects.end(),
                   [](const ObjectResult* a, const ObjectResult* b) { return a->figures.leafBound() > b->figures.leafBound(); });
  ScatterChart leaves{"Leaves against overhang, object by object", "Leaves", "Overhang, proven [mm]", {}, {}},
      size{"Size against overhang", "Diagonal [mm]", "Overhang, proven [mm]", {}, {}};
  leaves.front = size.front = false;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const ObjectResult& o = *objects[i];
    ChartPoint p{static_cast<double>(o.figures.leaves), o.figures.leafBound(), i < 6 ? o.name : "", o.name, 1, false};
    leaves.points.push_back(p);
    p.x = o.figures.diagonal_mm;
    size.points.push_back(p);
  }
  if (objects.size() < 3) return "";  // then the rows of the table show as much
  const auto [smallest, largest] = std::minmax_element(
      objects.begin(), objects.end(), [](const ObjectResult* a, const ObjectResult* b) { return a->figures.leaves < b->figures.leaves; });
  const bool same_leaves = 10 * (*largest)->figures.leaves < 13 * (*smallest)->figures.leaves;  // all dots would be in one line
  return "<p>Each dot is an object; the six with the largest overhang are named.</p><div class=\"charts\">" +
         (same_leaves ? "" : scatterSvg(leaves)) + scatterSvg(size) + "</div>\n";
}

std::string charts(const BatchResult& result) {
  const bool has_rows =
      result.speed && std::any_of(result.speed->begin(), result.speed->end(), [](const SpeedRow& r) { return !r.object; });
  return has_rows ? speedCharts(*result.speed) : objectCharts(result);
}

Json levelsOf(const pipeline::TreeFigures& figures) {
  Json out = Json::array();
  for (const pipeline::LevelFigures& level : figures.levels) out.push_back(pipeline::levelJson(*level.measured));
  return out;
}

/// The notes about soft tissue; empty without any.
std::string tissueList(const BatchResult& result) {
  std::string items;
  for (const ObjectResult& o : result.objects)
    for (const std::string& note : o.figures.notes)
      if (o.hasTree() && note.starts_with(pipeline::kSoftNote))
        items += "<li>" + escaped(o.name) + ": " + escaped(note.substr(std::string_view(pipeline::kSoftNote).size())) + "</li>";
  return items.empty() ? "" : "<ul>" + items + "</ul>";
}

}  // namespace

Report batchReport(const fs::path& folder, const std::optional<fs::path>& recording_file, std::size_t max_bytes,
                   builder::Progress& progress) {
  Report out;
  const BatchResult result = pipeline::readBatchResult(folder / "report.json");
  out.figures = toJson(result);
  std::optional<Recording> recording;
  if (recording_file) recording = readRecording(*recording_file);
  const fs::path scene_file = folder / "scene.json";
  std::optional<formats::SceneFile> scene;
  std::string remark;
  ShownMeshes meshes;
  if (fs::exists(scene_file)) {
    scene = formats::readScene(scene_file);
    if (recording) remark = remarkOnScene(*recording, *recording_file, scene_file);
    progress.stage("meshes");
    // As given to batch: relative to the folder in which batch ran, which is often the parent folder of its results.
    const fs::path& source = result.scene;
    meshes = meshesOf(fs::exists(source) || source.is_absolute() ? source : fs::absolute(folder).parent_path() / source, progress);
  }
  for (const std::size_t triangles : {1500, 600, 200}) {
    progress.check();
    progress.stage("page");
    Page page("Batch " + folder.filename().string(), leadOf(result));
    std::map<std::string, std::size_t> index;
    std::string view = "<p class=\"bad\">No scene was written: the tool or every object failed.</p>";
    if (scene) {
      page.data.root["scenes"] = Json::array();
      ModelStore models(page.data, triangles);
      Json shown = sceneForView(*scene, scene_file, meshes, models);
      for (Json& object : shown["objects"]) {
        index.emplace(object.at("name").get<std::string>(), index.size());
        for (const ObjectResult& entry : result.objects)
          if (entry.name == object.at("name") && entry.hasTree() && entry.figures.levels.back().measured)
            object["levels"] = levelsOf(entry.figures);
      }
      if (recording) shown["replays"].push_back(packRecording(page.data, recording_file->stem().string(), *recording));
      page.data.root["scenes"].push_back(shown);
      view = viewSection(recording.has_value(),
                         std::string("A name in the table below shows the object's worst spot; a double click hides what is in front.") +
                             (meshes.empty() ? " The meshes were not found: spheres without colours of overhang." : ""));
    }
    page.addSection("view", "In 3D", view);
    page.addSection("objects", "Objects", objectTable(result, index));
    if (const std::string repairs = repairTable(result); !repairs.empty()) page.addSection("repairs", "Repaired meshes", repairs);
    if (const std::string tissue = tissueList(result); !tissue.empty()) page.addSection("tissue", "Soft tissue", tissue);
    if (const std::string drawn = charts(result); !drawn.empty()) page.addSection("charts", "Size against accuracy", drawn);
    if (recording)
      page.addSection("run", "The recorded run",
                      runVerdict(recordingFigures(*recording)) + (remark.empty() ? "" : "<p>" + escaped(remark) + "</p>") +
                          recordingBoxes(recordingFigures(*recording)) + recordingCharts(*recording));
    out.html = scene ? page.html(std::array{embedded::viewScript(), embedded::reportScript()}) : page.html({});
    if (out.html.size() <= max_bytes) break;
  }
  if (recording) out.figures["recording"] = recordingFigures(*recording);
  return out;
}

}  // namespace spheretree::tool
