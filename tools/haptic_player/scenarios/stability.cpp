// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenarios/stability.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>

#include "run_files.h"
#include "scenarios/parallel_jobs.h"
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

/// Runs the scenario on bodies that are rotated, scaled and built with other seeds, and stores the worst value of each
/// figure in `outcome`.
void runTurned(const Scenario& scenario, ScenarioContext& context, Mode mode, Outcome& outcome) {
  ScenarioContext less{context.bodies, {context.settings.share * kTurnedShare, 0}, context.progress};
  for (int n = 1; n <= context.settings.turned; ++n) {
    context.bodies.setVariant(static_cast<std::uint64_t>(n));
    const Outcome turned = scenario.run(less, mode);
    context.bodies.setVariant(0);
    for (std::size_t i = 0; i < outcome.figures.size(); ++i) {
      std::optional<double>& worst = outcome.figures[i].turned;
      worst = worst ? std::max(*worst, turned.figures[i].value) : turned.figures[i].value;
    }
  }
}

/// The recording in the format of the player, with the depth as measured independently of the runtime.
std::string recordingText(const Outcome& outcome) {
  std::string text(recordingHeader());
  for (std::size_t i = 0; i < outcome.recording.size(); ++i) {
    RecordedStep row = outcome.recording[i];
    row.penetration = static_cast<double>(outcome.penetration[i]);
    appendRow(text, row);
  }
  return text;
}

/// One scenario in one mode.
struct ModeRun {
  std::size_t result;  // number of the scenario
  Mode mode;
  Outcome outcome;
  double seconds;
  std::string recording;  // file name; empty: none
};

void runInMode(const Scenario& scenario, ScenarioContext& context, const std::filesystem::path& folder, ModeRun& run) {
  const auto start = std::chrono::steady_clock::now();
  run.outcome = scenario.run(context, run.mode);
  if (run.mode == Mode::Constrained && scenario.is_turned) runTurned(scenario, context, run.mode, run.outcome);
  if (!folder.empty() && !run.outcome.recording.empty()) {
    formats::makeFolder(folder);
    run.recording = scenario.id + "." + std::string(name(run.mode)) + ".csv";
    tool::RunFiles().willMake(folder / run.recording);
    formats::writeWhole(folder / run.recording, recordingText(run.outcome));
  }
  std::vector<RecordedStep>().swap(run.outcome.recording);
  std::vector<float>().swap(run.outcome.penetration);
  run.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// The outcome whose bodies and notes represent the scenario.
const Outcome& leading(const ScenarioResult& r) {
  const auto ours = r.outcomes.find(Mode::Constrained);
  return ours != r.outcomes.end() ? ours->second : r.outcomes.begin()->second;
}

/// Figure `i` in all modes. "verdict" is of the constrained mode, "paper_verdict" of the paper's, "verdicts" of each.
Json figureJson(const ScenarioResult& r, std::size_t i) {
  const Figure& figure = leading(r).figures[i];
  Json results = Json::object(), verdicts = Json::object();
  for (const auto& [mode, outcome] : r.outcomes) {
    results[std::string(name(mode))] = number(outcome.figures[i].value);
    verdicts[std::string(name(mode))] = verdictOf(outcome.figures[i]);
  }
  Json json{{"quantity", figure.quantity}, {"unit", figure.unit}, {"pass", number(figure.pass)}, {"results", results}};
  if (r.outcomes.contains(Mode::Constrained)) json["verdict"] = verdicts["constrained"];
  if (r.outcomes.contains(Mode::Published)) json["paper_verdict"] = verdicts["paper"];
  json["verdicts"] = verdicts;
  if (figure.turned) json["turned"] = number(*figure.turned);
  return json;
}

/// The figure that represents the scenario: the first one that the constrained mode misses, otherwise the first one
/// that another mode misses, otherwise the first one.
std::size_t headline(const ScenarioResult& r) {
  std::vector<const Outcome*> outcomes{&leading(r)};
  for (const auto& [mode, outcome] : r.outcomes) outcomes.push_back(&outcome);
  for (const Outcome* outcome : outcomes)
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

}  // namespace

const std::vector<Scenario>& scenarios() {
  static const std::vector<Scenario> all = [] {
    std::vector<Scenario> list = contactScenarios();
    for (const auto& more : {popThroughScenarios(), numericScenarios(), builderScenarios(), deviceScenarios(), rubbingScenarios(),
                             tissueScenarios(), cuttingScenarios(), handScenarios()})
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

bool holds(const Figure& figure) {  // NaN does not pass
  return figure.informative || (figure.value <= figure.pass && (!figure.turned || *figure.turned <= figure.pass));
}

bool holds(const Outcome& outcome) {
  return std::all_of(outcome.figures.begin(), outcome.figures.end(), [](const Figure& f) { return holds(f); });
}

bool holds(const ScenarioResult& result) {
  if (const auto ours = result.outcomes.find(Mode::Constrained); ours != result.outcomes.end()) return holds(ours->second);
  return std::all_of(result.outcomes.begin(), result.outcomes.end(), [](const auto& entry) { return holds(entry.second); });
}

std::vector<ScenarioResult> runScenarios(std::span<const Scenario* const> scenarios, const ScenarioContext& context,
                                         const RunSettings& settings, tool::WorkProgress& progress,
                                         const std::function<void(const ScenarioResult&)>& tell) {
  std::vector<ScenarioResult> results;
  std::vector<ModeRun> runs;
  for (const Scenario* scenario : scenarios) {
    results.push_back({scenario, {}, 0, {}});
    for (const Mode mode : settings.modes)
      if (isOurs(mode) || scenario->for_all) runs.push_back({results.size() - 1, mode, {}, 0, {}});
  }
  std::vector<Job> jobs;
  for (ModeRun& run : runs) {
    const Scenario& scenario = *scenarios[run.result];
    jobs.push_back({scenario.id + " " + std::string(name(run.mode)),
                    [&run, &scenario, &settings](ScenarioContext& own) { runInMode(scenario, own, settings.folder, run); }});
  }
  std::size_t told = 0;
  const auto tellBefore = [&](std::size_t end) {
    for (; told < end; ++told)
      if (tell) tell(results[told]);
  };
  progress.stage("scenarios");
  runJobs(jobs, context, settings.threads, progress, [&](std::size_t k) {
    ModeRun& run = runs[k];
    ScenarioResult& result = results[run.result];
    tellBefore(run.result);
    if (!result.outcomes.empty() && result.outcomes.begin()->second.figures.size() != run.outcome.figures.size())
      throw std::logic_error(result.scenario->id + ": figures of two kinds");
    if (!run.recording.empty()) result.recordings[std::string(name(run.mode))] = run.recording;
    result.outcomes.emplace(run.mode, std::move(run.outcome));
    result.seconds += run.seconds;
    if (k + 1 == runs.size() || runs[k + 1].result != run.result) tellBefore(run.result + 1);
  });
  tellBefore(results.size());
  return results;
}

std::string tableHead(std::span<const Mode> modes) {
  char cell[80];
  std::snprintf(cell, sizeof cell, "%-63s %9s", "scenario, quantity", "pass <=");
  std::string text = cell;
  for (const Mode mode : modes) {
    std::snprintf(cell, sizeof cell, " %11s", std::string(name(mode)).c_str());
    text += cell;
  }
  return text + "      turned  verdict\n";
}

std::string tableRows(const ScenarioResult& r, std::span<const Mode> modes) {
  char cell[200];
  std::snprintf(cell, sizeof cell, "%-4s %s\n", r.scenario->id.c_str(), r.scenario->title.c_str());
  std::string text = cell;
  if (r.outcomes.empty()) return text + "     only for paper and constrained: it asks our own runtime\n";
  for (std::size_t i = 0; i < leading(r).figures.size(); ++i) {
    const Figure& f = leading(r).figures[i];
    const std::string quantity = f.quantity + (f.unit == "1" ? "" : " [" + f.unit + "]");
    std::snprintf(cell, sizeof cell, "     %-58s %9.4g", quantity.c_str(), f.pass);
    text += cell;
    for (const Mode mode : modes) {
      const auto found = r.outcomes.find(mode);
      if (found == r.outcomes.end())
        std::snprintf(cell, sizeof cell, " %11s", "-");
      else
        std::snprintf(cell, sizeof cell, " %11.4g", found->second.figures[i].value);
      text += cell;
    }
    std::snprintf(cell, sizeof cell, f.turned ? " %11.4g" : "           -", f.turned.value_or(0));
    text += cell + ("  " + verdictOf(f)) + "\n";
  }
  return text;
}

nlohmann::ordered_json stabilityJson(const std::vector<ScenarioResult>& results, builder::Quality quality) {
  Json list = Json::array();
  for (const ScenarioResult& r : results) {
    Json figures = Json::array();
    if (r.outcomes.empty()) continue;
    for (std::size_t i = 0; i < leading(r).figures.size(); ++i) figures.push_back(figureJson(r, i));
    Json scenario{{"id", r.scenario->id}, {"alias", r.scenario->alias}, {"title", r.scenario->title}};
    if (!figures.empty()) scenario.update(figures[headline(r)]);
    Json verdicts = Json::object();
    for (const auto& [mode, outcome] : r.outcomes) verdicts[std::string(name(mode))] = holds(outcome) ? "holds" : "falls short";
    if (verdicts.contains("constrained")) scenario["verdict"] = verdicts["constrained"];
    if (verdicts.contains("paper")) scenario["paper_verdict"] = verdicts["paper"];
    scenario["verdicts"] = verdicts;
    scenario["figures"] = figures;
    scenario["note"] = leading(r).note;
    scenario["recordings"] = r.recordings;
    const Outcome& o = leading(r);
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
  const tool::RunFiles files;
  formats::makeFolder(folder);
  std::set<const Body*> bodies;  // order of addresses; each body makes files of its own
  for (const ScenarioResult& r : results) {
    if (r.outcomes.empty()) continue;
    if (leading(r).tool) bodies.insert(leading(r).tool);
    for (const PlacedBody& object : leading(r).objects) bodies.insert(object.body);
  }
  for (const Body* body : bodies) {
    for (const char* ending : {".stree", ".off"}) files.willMake(folder / (body->name + ending));
    formats::writeSphereTree(folder / (body->name + ".stree"), body->tree);
    formats::writeWhole(folder / (body->name + ".off"), offText(body->mesh));
  }
  files.willMake(folder / "stability.json");
  formats::writeWhole(folder / "stability.json", stabilityJson(results, quality).dump(1) + '\n');
}

}  // namespace spheretree::player
