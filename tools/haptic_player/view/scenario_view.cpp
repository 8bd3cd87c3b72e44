// SPDX-License-Identifier: GPL-3.0-or-later
// A stability scenario in both modes side by side: it is run first, stepped, and then both are shown at the same time.
#include <cstdio>

#include "program_end.h"
#include "scenarios/stability.h"
#include "view/replay_view.h"
#include "view/run_view.h"
#include "view/settings_of_options.h"

namespace spheretree::player {
namespace {

std::string shortNumber(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

view::Stage stageOf(const Outcome& outcome) {
  view::Stage stage;
  const auto add = [&](const Body& body, std::size_t index) {
    stage.bodies.push_back(view::bodyOf(body.name, &body.tree, &body.mesh, view::colourOf(body.name, index)));
    return stage.bodies.size() - 1;
  };
  stage.tool = add(*outcome.tool, 0);
  stage.reference_point = outcome.reference_point;
  for (std::size_t i = 0; i < outcome.objects.size(); ++i)
    stage.objects.push_back({add(*outcome.objects[i].body, i + 1), outcome.objects[i].pose});
  return stage;
}

/// Computes the contacts at the recorded poses with the runtime. They are left out if objects moved or the coupling was
/// different.
ShownRun withContacts(const Outcome& outcome, runtime::Mode mode) {
  runtime::SceneDescription d;
  d.tool = outcome.tool->tree;
  d.reference_point = outcome.reference_point;
  for (const PlacedBody& object : outcome.objects) d.objects.push_back({object.body->tree, object.pose});
  if (outcome.cutting && mode == runtime::Mode::Constrained) {
    std::string fault;
    d.burr = outcome.cutting->burr;
    d.objects[0].cut = runtime::cutModel(d.objects[0].tree, outcome.cutting->material, fault);
  }
  d.step_limits = runtime::defaultLimits(d.objects.size());
  ShownRun run = shownRun(outcome.recording, compiledScene(d, "scenario"), mode, {});
  run.note.clear();
  return run;
}

ReplayedRun runOf(const Outcome& outcome, Mode mode, const std::string& name) {
  ReplayedRun run;
  run.title = name;
  run.stage = std::make_unique<view::Stage>(stageOf(outcome));
  run.run = withContacts(outcome, runtimeMode(mode));
  for (std::size_t i = 0; i < run.run.steps.size() && i < outcome.penetration.size(); ++i)
    run.run.steps[i].penetration = static_cast<double>(outcome.penetration[i]);
  for (const Figure& figure : outcome.figures) {
    const std::string unit = figure.unit == "1" ? "" : " " + figure.unit;
    run.results.push_back({figure.quantity,
                           shortNumber(figure.value) + (figure.informative ? "" : " of " + shortNumber(figure.pass)) + unit,
                           !holds(figure)});
  }
  return run;
}

}  // namespace

int viewScenario(const ViewOptions& options, const Scenario& scenario, ScenarioContext& context, builder::Progress& progress) {
  if (!options.replay.empty()) throw tool::UsageError("--replay is for recordings; a scenario is run. Leave one of them out");
  checkPictures(options);
  std::vector<ReplayedRun> runs;
  for (const auto& [mode, name] : {std::pair(Mode::Published, "published method"), std::pair(Mode::Constrained, "constrained mode")}) {
    const Outcome outcome = scenario.run(context, mode);
    if (outcome.recording.empty() || !outcome.tool)
      throw tool::UsageError("--scenario " + scenario.id + ": it has no steps to show. Run it without --view");
    runs.push_back(runOf(outcome, mode, name));
  }
  Replay replay(std::move(runs));
  replay.state.title = scenario.id + " " + scenario.title;
  if (options.picture.empty())
    showReplay(replay, windowOf(options), progress);
  else
    drawReplay(replay, picturesOf(options), progress);
  return tool::kExitOk;
}

}  // namespace spheretree::player
