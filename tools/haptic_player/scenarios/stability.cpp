// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenarios/stability.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>

#include "spheretree/formats/file_io.h"
#include "spheretree/formats/sphere_tree_file.h"

namespace spheretree::player {
namespace {

using Json = nlohmann::ordered_json;

std::string lower(std::string s) {
  for (char& c : s) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return s;
}

std::string verdictOf(const Figure& figure) { return figure.informative ? "reported" : holds(figure) ? "holds" : "falls short"; }

/// JSON has no infinity.
Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json poseJson(const Configuration& pose) {
  const Quaternion& q = pose.orientation;
  return {{"position_mm", {pose.position.x(), pose.position.y(), pose.position.z()}}, {"quaternion_wxyz", {q.w(), q.x(), q.y(), q.z()}}};
}

Json figureJson(const Figure& paper, const Figure& constrained) {
  return {{"quantity", constrained.quantity},  {"unit", constrained.unit},
          {"pass", number(constrained.pass)},  {"results", {{"paper", number(paper.value)}, {"constrained", number(constrained.value)}}},
          {"verdict", verdictOf(constrained)}, {"paper_verdict", verdictOf(paper)}};
}

/// The figure that stands for the scenario: the first that the constrained mode misses, else the first that the paper's
/// misses, else the first.
std::size_t headline(const ScenarioResult& r) {
  for (const Outcome* outcome : {&r.constrained, &r.paper})
    for (std::size_t i = 0; i < outcome->figures.size(); ++i)
      if (!holds(outcome->figures[i])) return i;
  return 0;
}

std::string offText(const TriangleMesh& mesh) {
  std::string text = "OFF\n" + std::to_string(mesh.positions.size()) + ' ' + std::to_string(mesh.triangles.size()) + " 0\n";
  char line[96];
  for (const Eigen::Vector3d& p : mesh.positions) {
    std::snprintf(line, sizeof line, "%.9g %.9g %.9g\n", p.x(), p.y(), p.z());
    text += line;
  }
  for (const auto& [a, b, c] : mesh.triangles) text += "3 " + std::to_string(a) + ' ' + std::to_string(b) + ' ' + std::to_string(c) + '\n';
  return text;
}

/// As the player records, with the depth as measured from outside the runtime.
std::string recordingText(const Outcome& outcome) {
  std::string text(recordingHeader());
  for (std::size_t i = 0; i < outcome.recording.size(); ++i) {
    RecordedStep row = outcome.recording[i];
    row.penetration = static_cast<double>(outcome.penetration[i]);
    appendRow(text, row);
  }
  return text;
}

}  // namespace

const std::vector<Scenario>& scenarios() {
  static const std::vector<Scenario> all = [] {
    std::vector<Scenario> list = contactScenarios();
    for (const auto& more : {popThroughScenarios(), numericScenarios(), builderScenarios(), deviceScenarios(), handScenarios()})
      list.insert(list.end(), more.begin(), more.end());
    std::stable_sort(list.begin(), list.end(), [](const Scenario& a, const Scenario& b) {
      return a.id[0] != b.id[0] ? a.id[0] < b.id[0] : std::stoi(a.id.substr(1)) < std::stoi(b.id.substr(1));
    });
    return list;
  }();
  return all;
}

std::vector<const Scenario*> selectScenarios(const std::string& names) {
  std::vector<const Scenario*> chosen;
  for (std::size_t begin = 0; begin <= names.size();) {
    const std::size_t end = std::min(names.find(',', begin), names.size());
    const std::string name = lower(names.substr(begin, end - begin));
    bool known = false;
    for (const Scenario& s : scenarios())
      if (name == "all" || name == lower(s.id) || name == s.alias) {
        chosen.push_back(&s);
        known = true;
      }
    if (!known) {
      std::string list;
      for (const Scenario& s : scenarios()) list += (list.empty() ? "" : ", ") + s.id + " (" + s.alias + ")";
      throw std::invalid_argument("no scenario is called '" + name + "'. There are: all, " + list + ".");
    }
    begin = end + 1;
  }
  return chosen;
}

bool holds(const Figure& figure) { return figure.informative || figure.value <= figure.pass; }  // NaN does not hold

bool holds(const Outcome& outcome) {
  return std::all_of(outcome.figures.begin(), outcome.figures.end(), [](const Figure& f) { return holds(f); });
}

ScenarioResult runScenario(const Scenario& scenario, Bench& bench, const std::filesystem::path& folder) {
  const auto start = std::chrono::steady_clock::now();
  ScenarioResult result{&scenario, {}, {}, 0, {}};
  for (const runtime::Mode mode : {runtime::Mode::Paper, runtime::Mode::Constrained}) {
    const bool is_paper = mode == runtime::Mode::Paper;
    Outcome outcome = scenario.run(bench, mode);
    if (!folder.empty() && !outcome.recording.empty()) {
      formats::makeFolder(folder);
      const std::string name = scenario.id + (is_paper ? ".paper.csv" : ".constrained.csv");
      formats::writeWhole(folder / name, recordingText(outcome));
      result.recordings[is_paper ? "paper" : "constrained"] = name;
    }
    std::vector<RecordedStep>().swap(outcome.recording);
    std::vector<float>().swap(outcome.penetration);
    (is_paper ? result.paper : result.constrained) = std::move(outcome);
    bench.progress.advance(is_paper ? 0.5 : 1);
  }
  if (result.paper.figures.size() != result.constrained.figures.size()) throw std::logic_error(scenario.id + ": figures of two kinds");
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

std::string tableRows(const ScenarioResult& r) {
  char line[200];
  std::snprintf(line, sizeof line, "%-4s %s\n", r.scenario->id.c_str(), r.scenario->title.c_str());
  std::string text = line;
  for (std::size_t i = 0; i < r.constrained.figures.size(); ++i) {
    const Figure& f = r.constrained.figures[i];
    const std::string quantity = f.quantity + (f.unit == "1" ? "" : " [" + f.unit + "]");
    std::snprintf(line, sizeof line, "     %-58s %9.4g %11.4g %11.4g  %s\n", quantity.c_str(), f.pass, r.paper.figures[i].value, f.value,
                  verdictOf(f).c_str());
    text += line;
  }
  return text;
}

nlohmann::ordered_json stabilityJson(const std::vector<ScenarioResult>& results, builder::Quality quality) {
  Json list = Json::array();
  for (const ScenarioResult& r : results) {
    Json figures = Json::array();
    for (std::size_t i = 0; i < r.constrained.figures.size(); ++i)
      figures.push_back(figureJson(r.paper.figures[i], r.constrained.figures[i]));
    Json scenario{{"id", r.scenario->id}, {"alias", r.scenario->alias}, {"title", r.scenario->title}};
    if (!figures.empty()) scenario.update(figures[headline(r)]);
    scenario["verdict"] = holds(r.constrained) ? "holds" : "falls short";
    scenario["paper_verdict"] = holds(r.paper) ? "holds" : "falls short";
    scenario["figures"] = figures;
    scenario["note"] = r.constrained.note;
    scenario["recordings"] = r.recordings;
    const Outcome& o = r.constrained;
    if (o.tool) {
      scenario["tool"] = {{"name", o.tool->name},
                          {"tree", o.tool->name + ".stree"},
                          {"mesh", o.tool->name + ".off"},
                          {"reference_point_mm", {o.reference_point.x(), o.reference_point.y(), o.reference_point.z()}}};
      Json objects = Json::array();
      for (const PlacedBody& object : o.objects) {
        Json entry{{"name", object.body->name}, {"tree", object.body->name + ".stree"}, {"mesh", object.body->name + ".off"}};
        entry.update(poseJson(object.pose));
        objects.push_back(std::move(entry));
      }
      scenario["objects"] = objects;
    }
    scenario["seconds"] = std::round(r.seconds * 100) / 100;
    list.push_back(std::move(scenario));
  }
  return {{"schema", "spheretree.stability/1"}, {"quality", std::string(builder::name(quality))}, {"scenarios", list}};
}

void writeStability(const std::filesystem::path& folder, const std::vector<ScenarioResult>& results, builder::Quality quality) {
  formats::makeFolder(folder);
  std::set<const Body*> bodies;  // order of addresses; each makes files of its own
  for (const ScenarioResult& r : results) {
    if (r.constrained.tool) bodies.insert(r.constrained.tool);
    for (const PlacedBody& object : r.constrained.objects) bodies.insert(object.body);
  }
  for (const Body* body : bodies) {
    formats::writeSphereTree(folder / (body->name + ".stree"), body->tree);
    formats::writeWhole(folder / (body->name + ".off"), offText(body->mesh));
  }
  formats::writeWhole(folder / "stability.json", stabilityJson(results, quality).dump(1) + '\n');
}

}  // namespace spheretree::player
