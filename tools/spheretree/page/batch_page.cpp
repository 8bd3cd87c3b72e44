// SPDX-License-Identifier: GPL-3.0-or-later
// The page of a batch: the verdict, the objects, the scene in 3D.
#include <algorithm>
#include <array>

#include "page/embedded.h"
#include "page/recording.h"
#include "page/report_page.h"
#include "page/scene_view.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/file_io.h"
#include "spheretree/formats/scene_file.h"

namespace spheretree::tool {
namespace {

namespace fs = std::filesystem;

std::string numberOf(const Json& entry, const char* key) {
  return entry.contains(key) && entry.at(key).is_number() ? shortNumber(entry.at(key).get<double>()) : "\u2013";
}

Json leafOverhang(const Json& object, const char* which) {
  if (!object.contains("levels") || object.at("levels").empty()) return nullptr;
  const Json& overhang = object.at("levels").back().at("overhang_mm");
  return overhang.contains(which) ? overhang.at(which) : Json();
}

std::string count(std::size_t n, const std::string& thing) { return std::to_string(n) + " " + thing + (n == 1 ? "" : "s"); }

std::string leadOf(const Json& report) {
  const Json& totals = report.at("totals");
  const std::size_t objects = totals.at("objects").get<std::size_t>(), failed = totals.at("failed").get<std::size_t>();
  std::size_t missed = 0;
  for (const Json& o : report.at("objects")) missed += o.contains("tolerance_met") && o.at("tolerance_met") == false;
  std::string out = "<p>";
  if (failed == 0)
    out += "<span class=\"good\">All " + count(objects, "tree") + " are whole and certified</span>";
  else
    out += "<span class=\"bad\">" + count(failed, "object") + " of " + std::to_string(objects) + " failed</span>; the others are certified";
  out += ": " + totals.at("leaves").dump() + " leaves stand for " + totals.at("triangles").dump() +
         " triangles, and none reaches farther than <b>" + shortNumber(totals.at("overhang_bound_mm").get<double>()) +
         " mm</b> out of its object.</p>\n";
  if (missed > 0) out += "<p class=\"bad\">" + count(missed, "object") + " missed the tolerance asked for.</p>\n";
  out += "<p class=\"note\">" + totals.at("built").dump() + " built and " + totals.at("cached").dump() + " unchanged, in " +
         shortNumber(totals.at("seconds").get<double>()) + " s; " + shortNumber(totals.at("bytes").get<double>() / 1e6) +
         " MB of trees; scene " + escaped(report.at("scene").get<std::string>()) + ".</p>";
  return out;
}

/// `index` of an object is its place among the placed objects of the scene, for its button.
std::string objectTable(const Json& report, const std::map<std::string, std::size_t>& index) {
  HtmlTable table{"Objects; overhang of the leaves: how far they reach out of the object",
                  {"Object", "State", "Triangles", "Leaves", "Overhang, proven [mm]", "99th percentile [mm]", "Tolerance [mm]",
                   "Diagonal [mm]", "Build [s]"},
                  {}};
  for (const Json& o : report.at("objects")) {
    const std::string name = o.at("name").get<std::string>();
    const auto at = index.find(name);
    const std::string head =
        at == index.end() ? escaped(name)
                          : "<button type=\"button\" data-object=\"" + std::to_string(at->second) + "\" title=\"Show its worst spot\">" +
                                escaped(name) + "</button> <button type=\"button\" data-eye=\"" + std::to_string(at->second) +
                                "\" aria-pressed=\"false\" aria-label=\"Hide " + escaped(name) + " in the view\">hide</button>";
    const std::string status = o.at("status").get<std::string>();
    if (status == "failed") {
      table.rows.push_back({head, "<span class=\"bad\">failed: " + escaped(o.value("error", "")) + "</span>"});
      continue;
    }
    const Json bound = leafOverhang(o, "bound"), p99 = leafOverhang(o, "p99");
    const bool missed = o.contains("tolerance_met") && o.at("tolerance_met") == false;
    table.rows.push_back({head, (o.value("role", "") == "tool" ? "tool, " : "") + status, numberOf(o, "triangles"), numberOf(o, "leaves"),
                          bound.is_number() ? shortNumber(bound.get<double>()) : "\u2013",
                          p99.is_number() ? shortNumber(p99.get<double>()) : "\u2013",
                          missed ? "<span class=\"bad\">" + numberOf(o, "tolerance_mm") + " missed</span>" : numberOf(o, "tolerance_mm"),
                          numberOf(o, "diagonal_mm"), numberOf(o, "seconds")});
  }
  return table.html();
}

/// Rows of `pareto` that stand for the whole scene, or else the objects themselves.
std::string charts(const Json& report) {
  ScatterChart leaves{"Leaves against overhang", "Leaves", "Overhang, proven [mm]", {}, {}},
      step{"Time of a servo step against overhang", "Step, 99th percentile [us]", "Overhang, proven [mm]", {}, {}};
  for (const Json& row : report.value("pareto", Json::array())) {
    if (!row.at("object").is_null()) continue;
    ChartPoint p;
    p.x = row.at("leaves").get<double>();
    p.y = row.at("overhang_bound_mm").get<double>();
    p.chosen = row.value("chosen", false);
    p.series = p.chosen ? "chosen" : "";
    p.title = shortNumber(p.x) + " leaves, " + shortNumber(p.y) + " mm";
    leaves.points.push_back(p);
    if (!row.contains("step_us_p99") || !row.at("step_us_p99").is_number()) continue;
    p.x = row.at("step_us_p99").get<double>();
    p.title = shortNumber(p.x) + " us, " + shortNumber(p.y) + " mm";
    step.points.push_back(p);
  }
  if (!leaves.points.empty())
    return "<p>Lower left is better; the ring marks what was chosen.</p><div class=\"charts\">" + scatterSvg(leaves) +
           (step.points.empty() ? "" : scatterSvg(step)) + "</div>\n";
  std::vector<std::pair<double, const Json*>> objects;
  for (const Json& o : report.at("objects"))
    if (leafOverhang(o, "bound").is_number() && o.contains("leaves")) objects.emplace_back(leafOverhang(o, "bound").get<double>(), &o);
  std::stable_sort(objects.begin(), objects.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  ScatterChart size{"Size against overhang", "Diagonal [mm]", "Overhang, proven [mm]", {}, {}};
  leaves.title = "Leaves against overhang, object by object";
  leaves.front = size.front = false;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const Json& o = *objects[i].second;
    ChartPoint p{o.at("leaves").get<double>(),
                 objects[i].first,
                 i < 6 ? o.at("name").get<std::string>() : "",
                 o.at("name").get<std::string>(),
                 1,
                 false};
    leaves.points.push_back(p);
    p.x = o.at("diagonal_mm").get<double>();
    size.points.push_back(p);
  }
  return "<p>Each dot is an object; the six with the largest overhang are named.</p><div class=\"charts\">" + scatterSvg(leaves) +
         scatterSvg(size) + "</div>\n";
}

}  // namespace

Report batchReport(const fs::path& folder, const std::optional<fs::path>& recording_file, std::size_t most_bytes,
                   builder::Progress& progress) {
  Report out;
  out.figures = readJson(folder / "report.json", "spheretree.batch/1");
  const Json& report = out.figures;
  std::optional<Recording> recording;
  if (recording_file) recording = readRecording(*recording_file);
  const fs::path scene_file = folder / "scene.json";
  std::optional<formats::SceneFile> scene;
  std::map<std::string, ShownMesh> meshes;
  if (fs::exists(scene_file)) {
    scene = formats::readScene(scene_file);
    progress.stage("meshes");
    // As it was given to batch: from the folder where batch ran, which is often the one beside its results.
    const fs::path source = report.at("scene").get<std::string>();
    meshes = meshesOf(fs::exists(source) || source.is_absolute() ? source : fs::absolute(folder).parent_path() / source, progress);
  }
  for (const std::size_t triangles : {1500, 600, 200}) {
    progress.check();
    progress.stage("page");
    Page page("Batch " + folder.filename().string(), leadOf(report));
    std::map<std::string, std::size_t> index;
    std::string view = "<p class=\"bad\">No scene was written: the tool or every object failed.</p>";
    if (scene) {
      page.data.root["scenes"] = Json::array();
      ModelStore models(page.data, triangles);
      Json shown = sceneForView(*scene, scene_file, meshes, models);
      for (Json& object : shown["objects"]) {
        index.emplace(object.at("name").get<std::string>(), index.size());
        for (const Json& entry : report.at("objects"))
          if (entry.at("name") == object.at("name") && entry.contains("levels") && leafOverhang(entry, "max").is_number())
            object["levels"] = entry.at("levels");
      }
      if (recording) shown["replays"].push_back(packRecording(page.data, recording_file->stem().string(), *recording));
      page.data.root["scenes"].push_back(shown);
      view = viewSection(recording.has_value(),
                         std::string("A name in the table above shows the object's worst spot; a double click hides what is in front.") +
                             (meshes.empty() ? " The meshes were not found: spheres without colours of overhang." : ""));
    }
    page.addSection("charts", "Size against accuracy", charts(report));
    page.addSection("objects", "Objects", objectTable(report, index));
    page.addSection("view", "In 3D", view);
    if (recording) page.addSection("run", "The recorded run", recordingBoxes(recordingFigures(*recording)) + recordingCharts(*recording));
    out.html = scene ? page.html(std::array{embedded::viewScript(), embedded::reportScript()}) : page.html({});
    if (out.html.size() <= most_bytes) break;
  }
  if (recording) out.figures["recording"] = recordingFigures(*recording);
  return out;
}

}  // namespace spheretree::tool
