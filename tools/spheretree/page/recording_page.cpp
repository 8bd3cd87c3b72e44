// SPDX-License-Identifier: GPL-3.0-or-later
// Pages of a recorded run and of the stability scenarios.
#include <algorithm>
#include <array>

#include "page/embedded.h"
#include "page/recording.h"
#include "page/report_page.h"
#include "page/scene_view.h"
#include "pipeline/json_file.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/file_io.h"
#include "spheretree/formats/mesh_file.h"

namespace spheretree::tool {
namespace {

namespace fs = std::filesystem;

constexpr std::array<std::size_t, 3> kTriangles{2000, 800, 200};  // of a mesh in a page; decreases until the page is small enough

std::string numberOrDash(const Json& value) { return value.is_number() ? shortNumber(value.get<double>()) : "\u2013"; }

std::string verdictCell(const std::string& verdict) {
  return (verdict == "holds"      ? "<span class=\"good\">"
          : verdict == "reported" ? "<span>"
                                  : "<span class=\"bad\">") +
         escaped(verdict) + "</span>";
}

/// A value and whether it passes; `verdict` as in stability.json.
std::string judged(const Json& value, const std::string& verdict) {
  const std::string mark = verdict == "holds" ? " \u2713" : verdict == "reported" ? "" : " \u2717";
  return (verdict == "holds"      ? "<span class=\"good\">"
          : verdict == "reported" ? "<span>"
                                  : "<span class=\"bad\">") +
         numberOrDash(value) + mark + "</span>";
}

/// Text that may take several lines of a cell.
std::string wrapped(const std::string& words) { return "<span class=\"wrap\">" + escaped(words) + "</span>"; }

std::vector<std::string> figureCells(const Json& f) {
  const bool is_reported = f.value("verdict", "reported") == "reported";
  return {wrapped(f.at("quantity").get<std::string>()),
          judged(f.at("results").value("constrained", Json()), f.value("verdict", "reported")),
          judged(f.at("results").value("paper", Json()), f.value("paper_verdict", "reported")),
          is_reported ? "\u2013" : numberOrDash(f.at("pass")), escaped(f.at("unit") == "1" ? "" : f.at("unit").get<std::string>())};
}

std::string scenarioTable(const Json& scenario) {
  HtmlTable table{"Figures; a value must not exceed its pass figure. \u2713 holds, \u2717 falls short; others are reported only.",
                  {"Quantity", "Constrained", "Paper", "Pass", "Unit"},
                  {}};
  for (const Json& f : scenario.at("figures")) table.rows.push_back(figureCells(f));
  return table.html();
}

/// Force, energy, penetration and spectrum, with both modes in one chart each.
std::string modeCharts(const std::vector<std::pair<std::string, Recording>>& runs) {
  std::string out = "<div class=\"charts wide\">";
  if (runs.empty()) return "";
  const auto longest =
      std::max_element(runs.begin(), runs.end(), [](const auto& a, const auto& b) { return a.second.steps() < b.second.steps(); });
  const std::vector<float>& time = longest->second.time;
  const auto chart = [&](const std::string& title, const std::string& axis, auto&& values, std::optional<ScatterChart::Line> line) {
    TraceChart c{title, "Time [s]", axis, time, {}, false, line};
    for (const auto& [mode, run] : runs) c.traces.push_back({mode, values(run)});
    out += traceCharts(c);
  };
  chart(
      "Force on the hand", "Force [N]", [](const Recording& r) { return forceLength(r); }, std::nullopt);
  chart(
      "Energy taken from the hand; below 0 the renderer has given energy", "Energy [mJ]", [](const Recording& r) { return energyTaken(r); },
      ScatterChart::Line{0, ""});
  if (std::all_of(runs.begin(), runs.end(), [](const auto& r) { return !r.second.penetration.empty(); }))
    chart(
        "Penetration of the tool's leaf spheres", "Depth [mm]", [](const Recording& r) { return r.penetration; },
        ScatterChart::Line{0.01, "passes: 0.01 mm"});
  TraceChart spectra{"Spectrum of the force", "Frequency [Hz]", "Amplitude [N]", {}, {}, true, {}};
  for (const auto& [mode, run] : runs) {
    const double seconds = std::max(1e-9, static_cast<double>(run.time.back()) - run.time.front());
    const Spectrum s = spectrumOf(forceLength(run), static_cast<double>(run.steps() - 1) / seconds);
    if (s.hertz.size() > spectra.x.size()) spectra.x = s.hertz;
    spectra.traces.push_back({mode, s.amplitude});
  }
  if (!spectra.x.empty()) out += traceCharts(spectra);
  return out + "</div>\n";
}

std::vector<std::pair<std::string, Recording>> runsOf(const Json& scenario, const fs::path& folder) {
  std::vector<std::pair<std::string, Recording>> runs;
  for (const auto& [mode, file] : scenario.at("recordings").items())
    runs.emplace_back(mode, readRecording(folder / file.get<std::string>()));
  return runs;
}

/// Names in a stability.json are file names in its folder; anything else is refused.
fs::path inFolder(const fs::path& folder, const Json& name) {
  const fs::path file = name.get<std::string>();
  if (file.has_parent_path() || file.empty())
    throw formats::FormatError(file.string() + ": not a file of " + folder.string() + ". Run haptic-player again.");
  return folder / file;
}

Json scenarioForView(const Json& scenario, const fs::path& folder, ModelStore& models) {
  const auto add = [&](const Json& body) {
    const ShownMesh mesh{formats::readMesh(inFolder(folder, body.at("mesh"))).mesh, {}};
    models.add(body.at("name").get<std::string>(), inFolder(folder, body.at("tree")), &mesh);
  };
  const Json& tool = scenario.at("tool");
  add(tool);
  Json out{{"name", scenario.at("id").get<std::string>() + " " + scenario.at("title").get<std::string>()},
           {"tool", {{"name", tool.at("name")}, {"model", tool.at("name")}, {"reference_point_mm", tool.at("reference_point_mm")}}},
           {"objects", Json::array()},
           {"replays", Json::array()}};
  for (const Json& object : scenario.at("objects")) {
    add(object);
    out["objects"].push_back({{"name", object.at("name")},
                              {"model", object.at("name")},
                              {"position_mm", object.at("position_mm")},
                              {"quaternion_wxyz", object.at("quaternion_wxyz")}});
  }
  return out;
}

Page stabilityPage(const Json& stability, const fs::path& folder, std::size_t triangles, builder::Progress& progress) {
  std::size_t hold = 0, paper = 0;
  for (const Json& s : stability.at("scenarios"))
    hold += s.value("verdict", "") == "holds", paper += s.value("paper_verdict", "") == "holds";
  const std::string of = std::to_string(stability.at("scenarios").size());
  Page page("Stability of the haptic step", "<p><b>" + std::to_string(hold) + " of " + of + "</b> scenarios hold in constrained mode, " +
                                                std::to_string(paper) + " of " + of + " with the published algorithm.</p>");
  HtmlTable table{"Scenarios; for each the deciding figure. \u2713 holds, \u2717 falls short.",
                  {"Scenario", "Constrained", "Paper", "Pass", "Unit", "Quantity"},
                  {}};
  std::string details;
  page.data.root["scenes"] = Json::array();
  ModelStore models(page.data, triangles);
  bool has_replay = false;
  for (const Json& s : stability.at("scenarios")) {
    progress.check();
    const std::string title = s.at("id").get<std::string>() + " " + s.at("title").get<std::string>();
    progress.stage(title);
    if (s.contains("results")) {
      std::vector<std::string> cells = figureCells(s);
      std::rotate(cells.begin(), cells.begin() + 1, cells.end());  // the quantity, which is long, stands last
      cells.insert(cells.begin(), wrapped(title));
      table.rows.push_back(std::move(cells));
    }
    const auto runs = runsOf(s, folder);
    details += "<details><summary>" + escaped(title) + " <span class=\"note\">" + verdictCell(s.value("verdict", "reported")) +
               "</span></summary>";
    if (s.contains("note") && !s.at("note").get<std::string>().empty())
      details += "<p>" + escaped(s.at("note").get<std::string>()) + "</p>";
    details += scenarioTable(s) + modeCharts(runs);
    if (s.contains("tool")) {
      Json scene = scenarioForView(s, folder, models);
      for (const auto& [mode, run] : runs) scene["replays"].push_back(packRecording(page.data, mode, run)), has_replay = true;
      details +=
          "<p><button type=\"button\" data-scene=\"" + std::to_string(page.data.root["scenes"].size()) + "\">Show in 3D</button></p>";
      page.data.root["scenes"].push_back(scene);
    }
    details += "</details>\n";
  }
  page.addSection("scenarios", "Scenarios", table.html());
  if (!page.data.root["scenes"].empty())
    page.addSection("view", "In 3D",
                    viewSection(has_replay, "Grey: the tool as it is shown. Blue glass: where the hand is. Arrow: the force on the hand."));
  page.addSection("details", "Each scenario", details);
  return page;
}

}  // namespace

std::string runVerdict(const Json& figures) {
  const double given = -figures.at("energy_mj").at("smallest").get<double>();
  const std::size_t faults = figures.at("steps_with_faults").get<std::size_t>();
  double touched = 0;
  for (const Json& row : figures.at("touched")) touched += row.at("seconds").get<double>();
  const std::string in_touch = touched > 0 ? ", " + shortNumber(touched) + " s of them in touch" : "";
  std::string out = "<p>" + shortNumber(figures.at("seconds").get<double>()) + " s" + in_touch + ", with forces up to <b>" +
                    shortNumber(figures.at("largest_force_n").get<double>()) + " N</b>. ";
  out += given > 1e-6 ? "The renderer gave up to <b>" + shortNumber(given) + " mJ</b> to the hand; a sampled spring always gives a little. "
                      : "The renderer never gave energy to the hand: it was passive. ";
  out += faults == 0 ? "No step had a fault." : "<span class=\"bad\">" + std::to_string(faults) + " steps had a fault.</span>";
  return out + "</p>";
}

/// Empty if the recording has no such data.
std::string touchedTable(const Json& figures) {
  HtmlTable table{
      "Touched objects, in the order of the first touch, with the time for which each was pressed most", {"Object", "Time [s]"}, {}};
  for (const Json& row : figures.at("touched"))
    table.rows.push_back({escaped(row.at("name").get<std::string>()), shortNumber(row.at("seconds").get<double>())});
  return table.rows.empty() ? "" : table.html();
}

std::string recordingBoxes(const Json& f) {
  return figureBoxes({{"Duration", shortNumber(f.at("seconds").get<double>()) + " s"},
                      {"Largest force", shortNumber(f.at("largest_force_n").get<double>()) + " N"},
                      {"Largest change of force in a step", shortNumber(f.at("largest_force_step_n").get<double>()) + " N"},
                      {"Hand beyond the tool", shortNumber(f.at("largest_hand_to_tool_mm").get<double>()) + " mm"},
                      {"Least energy", shortNumber(f.at("energy_mj").at("smallest").get<double>()) + " mJ"},
                      {"Step time, 99th percentile", shortNumber(f.at("total_us").at("p99").get<double>()) + " \u00b5s"},
                      {"Steps with faults", std::to_string(f.at("steps_with_faults").get<std::size_t>())}}) +
         touchedTable(f);
}

Report recordingReport(const fs::path& file, const std::optional<fs::path>& scene_file, std::size_t max_bytes,
                       builder::Progress& progress) {
  progress.stage("recording");
  const Recording recording = readRecording(file);
  Report report;
  report.figures = {{"schema", "spheretree.recording_report/1"}, {"recording", file.string()}, {"figures", recordingFigures(recording)}};
  const Json& figures = report.figures["figures"];
  for (const std::size_t triangles : kTriangles) {
    progress.check();
    Page page("Recording " + file.filename().string(), runVerdict(figures));
    const std::string run = recordingBoxes(figures) + recordingCharts(recording);
    if (scene_file) {
      const std::string remark = remarkOnScene(recording, file, *scene_file);
      page.data.root["scenes"] = Json::array();
      ModelStore models(page.data, triangles);
      Json scene = sceneForView(formats::readScene(*scene_file), *scene_file, {}, models);
      scene["replays"].push_back(packRecording(page.data, file.stem().string(), recording));
      page.data.root["scenes"].push_back(scene);
      page.addSection(
          "view", "Replay",
          viewSection(true, "Grey: the tool as it is shown. Blue glass: where the hand is. Arrow: the force on the hand. " + remark));
      page.addSection("run", "The run", run);
      report.html = page.html(std::array{embedded::viewScript(), embedded::reportScript()});
    } else {
      page.addSection("run", "The run", run);
      report.html = page.html({});
    }
    if (report.html.size() <= max_bytes) break;
  }
  return report;
}

Report stabilityReport(const fs::path& folder, std::size_t max_bytes, builder::Progress& progress) {
  return pipeline::readJsonAs(folder / "stability.json", "spheretree.stability/1", [&](const Json& stability) {
    Report report;
    report.figures = stability;
    for (const std::size_t triangles : kTriangles) {
      report.html =
          stabilityPage(stability, folder, triangles, progress).html(std::array{embedded::viewScript(), embedded::reportScript()});
      if (report.html.size() <= max_bytes) break;
    }
    return report;
  });
}

}  // namespace spheretree::tool
