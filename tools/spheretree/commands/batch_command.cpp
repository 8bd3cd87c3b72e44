// SPDX-License-Identifier: GPL-3.0-or-later
// spheretree batch: turns every object of a scene into a tree, and writes a compiled scene and a report.
#include "pipeline/batch/batch.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <memory>

#include "mistyped.h"
#include "options/command.h"
#include "options/common_options.h"
#include "options/draft_options.h"
#include "page/chart.h"
#include "pipeline/batch/cohort.h"
#include "pipeline/builder_names.h"
#include "pipeline/missed_tolerance.h"
#include "run_files.h"
#include "terminal.h"

namespace spheretree::tool {
namespace {

using pipeline::BatchResult;
using pipeline::BatchSettings;
using pipeline::Budget;
using pipeline::BudgetResult;
using pipeline::ItemStatus;
using pipeline::ObjectResult;
using pipeline::Shard;

void printBudget(const BudgetResult& result) {
  printResult("budget: %.6g of %.6g %s", result.spent, result.budget.amount,
              result.budget.is_time ? "us a step (99th percentile, by the model)" : "leaves");
  if (result.worst_ratio)
    printResult("; the largest error is %.4g times the tolerance of its object, or that many mm where the scene gives none",
                *result.worst_ratio);
  printResult("\n");
  if (!result.met) say("spheretree: the budget is not met; the cheapest trees found were written. Allow more.");
}

/// Why a tree with graded tolerances misses them: the regions of work in which leaves reach out too far. Without any,
/// the tolerance of the object itself is missed.
std::string missedGraded(const pipeline::TreeFigures& figures) {
  std::string where;
  for (const pipeline::WorkFigures& region : figures.work.value_or(std::vector<pipeline::WorkFigures>()))
    if (region.overhang_bound_mm > region.tolerance_mm)
      where += (where.empty() ? "" : ", ") + region.name + " (" + shortNumber(region.overhang_bound_mm) + " mm instead of " +
               shortNumber(region.tolerance_mm) + " mm)";
  return (where.empty() ? "the tolerance of " + shortNumber(*figures.tolerance_mm) + " mm is not met"
                        : "the tolerance is not met in the region " + where) +
         "; the best result was written.";
}

/// Reports the objects that failed or missed their tolerance, and returns the number of the latter.
std::size_t reportFaults(const BatchResult& result) {
  constexpr std::size_t kListed = 3;
  std::vector<std::string> missed;
  std::vector<std::string> lines;
  for (const ObjectResult& object : result.objects) {
    if (object.status == ItemStatus::Failed) say("spheretree: " + object.name + ": " + object.error);
    if (!object.hasTree() || object.figures.tolerance_met.value_or(true)) continue;
    if (result.budget) continue;  // that is the price of the budget; the report shows it
    missed.push_back(object.name);
    const pipeline::TreeFigures& figures = object.figures;
    // With regions of work, the largest overhang is usually elsewhere, where more is allowed.
    const std::string what =
        figures.isGraded() ? missedGraded(figures) : pipeline::missedTolerance(*figures.tolerance_mm, figures.leafBound(), figures.leaves);
    lines.push_back("spheretree: " + object.name + ": " + what + " Allow more levels or a larger tolerance_mm.");
  }
  if (missed.size() <= kListed) {
    for (const std::string& line : lines) say(line);
  } else {
    std::string names;
    for (std::size_t i = 0; i < kListed; ++i) names += missed[i] + ", ";
    say("spheretree: " + std::to_string(missed.size()) + " objects miss their tolerance; the best results were written: " + names + "and " +
        std::to_string(missed.size() - kListed) + " more, which report.json lists. Allow more levels or a larger tolerance_mm.");
  }
  return missed.size();
}

/// Lists the repairs of the user's meshes, the largest change first; report.json and the page have all of them.
void printRepairs(const BatchResult& result, const BatchSettings& settings) {
  std::vector<const ObjectResult*> repaired;
  for (const ObjectResult& object : result.objects)
    if (object.hasTree() && !object.figures.repair.empty()) repaired.push_back(&object);
  if (repaired.empty()) return;
  std::stable_sort(repaired.begin(), repaired.end(),
                   [](const ObjectResult* a, const ObjectResult* b) { return a->figures.repairChange() > b->figures.repairChange(); });
  const auto large = static_cast<std::size_t>(
      std::count_if(repaired.begin(), repaired.end(), [](const ObjectResult* o) { return o->figures.isRepairLarge(); }));
  printResult("%s repaired", counted(repaired.size(), "mesh", "meshes").c_str());
  if (large > 0) printResult(", %zu by more than the tolerance, a hundredth of the object or a tenth of its triangles", large);
  printResult("; the largest changes:\n");
  constexpr std::size_t kListed = 8;
  for (std::size_t i = 0; i < std::min(kListed, repaired.size()); ++i) {
    const pipeline::TreeFigures& f = repaired[i]->figures;
    std::string text;
    for (const pipeline::RepairFigures& step : f.repair) text += " " + step.text;
    printResult("%s %s:%s\n", f.isRepairLarge() ? "!" : " ", repaired[i]->name.c_str(), plainText(text).c_str());
  }
  if (repaired.size() > kListed)
    printResult("  and %zu more: %s\n", repaired.size() - kListed, plainText((settings.folder / "report.json").string()).c_str());
}

/// For a dry run: lists what would be done.
int printPlan(const BatchSettings& settings, const BatchResult& result) {
  const pipeline::BatchTotals totals = totalsOf(result);
  printResult("%s: %zu to build, %zu unchanged, %zu cannot be read; nothing was written\n", plainText(settings.folder.string()).c_str(),
              totals.skipped, totals.cached, totals.failed);
  for (const ObjectResult& object : result.objects) {
    if (object.status == ItemStatus::Skipped) printResult("  build %s\n", object.name.c_str());
    if (object.status == ItemStatus::Failed) say("spheretree: " + object.name + ": " + object.error);
  }
  return totals.failed > 0 ? kExitPartlyFailed : kExitOk;
}

/// Prints the times of the stages, if the batch took long.
void printTimes(const BatchResult& result) {
  if (result.seconds < 1) return;
  const BatchResult::Times& times = result.times;
  printResult("time: read %.1f s, build %.1f s", times.read, times.build);
  if (result.speed) printResult(", chart %.1f s", times.chart);
  printResult(", write %.1f s", times.write);
  std::vector<const ObjectResult*> built;
  for (const ObjectResult& object : result.objects)
    if (object.status == ItemStatus::Built) built.push_back(&object);
  std::stable_sort(built.begin(), built.end(), [](const ObjectResult* a, const ObjectResult* b) { return a->seconds > b->seconds; });
  constexpr std::size_t kListed = 3;
  for (std::size_t i = 0; i < std::min(kListed, built.size()); ++i)
    printResult("%s%s %.1f s", i == 0 ? "; the longest: " : ", ", built[i]->name.c_str(), built[i]->seconds);
  printResult("\n");
}

int printResults(const BatchSettings& settings, const BatchResult& result) {
  if (settings.dry_run) return printPlan(settings, result);
  const std::size_t missed = reportFaults(result);
  if (const ObjectResult& tool = result.objects[0];
      !result.is_reference_named && tool.hasTree() && result.tool_distance_mm > tool.figures.diagonal_mm / 4)
    say("spheretree: warning: the reference point of the tool is " + shortNumber(result.tool_distance_mm) +
        " mm away from it, and forces are felt there. Set reference_point_mm, or reference_point to tip or centre.");
  const pipeline::BatchTotals totals = totalsOf(result);
  printResult("%s: %zu built, %zu unchanged, %zu failed", plainText(settings.folder.string()).c_str(), totals.built, totals.cached,
              totals.failed);
  if (settings.shard.count == 1)
    printResult("; %zu leaves\n", totals.leaves);
  else
    printResult("; %zu left to other shards. Run without --shard once all have ended.\n", totals.skipped);
  printTimes(result);
  if (result.budget) printBudget(*result.budget);
  printRepairs(result, settings);
  const bool is_missed = missed > 0 || (result.budget && !result.budget->met);
  if (settings.shard.count == 1 && totals.failed < result.objects.size() && !is_missed)
    printResult("next: spheretree report %s -o PAGE.html, or haptic-player %s\n", plainText(settings.folder.string()).c_str(),
                plainText((settings.folder / "scene.json").string()).c_str());
  if (totals.failed > 0) return kExitPartlyFailed;
  return is_missed ? kExitTargetMissed : kExitOk;
}

struct BatchOptions {
  std::vector<std::filesystem::path> inputs;  // one scene, or mesh files; empty with a cohort
  std::filesystem::path cohort;               // list of patients
  pipeline::SceneDraftSettings draft;
  BatchSettings settings;
};

/// Distinguishes a scene from mesh files.
BatchSettings settingsOf(const BatchOptions& options) {
  BatchSettings settings = options.settings;
  const auto isScene = [](const std::filesystem::path& path) { return isDash(path) || endingOf(path) == ".json"; };
  const auto scenes = std::count_if(options.inputs.begin(), options.inputs.end(), isScene);
  if (scenes > 0 && options.inputs.size() > 1) throw UsageError("a scene names all its meshes. Give one scene, or mesh files only.");
  if (scenes == 1) {
    const pipeline::SceneDraftSettings& draft = options.draft;
    if (!draft.tool.empty() || !draft.matches.empty() || draft.reach_mm || !draft.unit.empty())
      throw UsageError("--tool, --match, --reach and --unit are for mesh files; a scene holds these settings. Edit the scene.");
    settings.scene = options.inputs[0];
    return settings;
  }
  settings.draft = options.draft;
  settings.draft->files = options.inputs;
  std::swap(settings.draft->tolerance_mm, settings.overrides.tolerance_mm);  // --match has precedence over it
  return settings;
}

pipeline::CohortSettings cohortOf(const BatchOptions& options) {
  const BatchSettings& own = options.settings;
  const pipeline::SceneDraftSettings& draft = options.draft;
  if (!options.inputs.empty()) throw UsageError("--cohort names the scenes. Leave out " + options.inputs[0].string() + ".");
  if (own.budget || own.speed || own.dry_run || !own.paths.empty())
    throw UsageError("--budget, --chart, --trajectory and --dry-run are for one scene. Leave them out, or leave out --cohort.");
  if (!draft.tool.empty() || !draft.matches.empty() || draft.reach_mm || !draft.unit.empty())
    throw UsageError("--tool, --match, --reach and --unit are for mesh files; the scenes of a cohort hold these settings.");
  return {.list = options.cohort,
          .folder = own.folder,
          .cache = own.cache,
          .shard = own.shard,
          .threads = own.threads,
          .overrides = own.overrides};
}

/// Prints one line for each finished patient.
void printPatient(const pipeline::PatientResult& patient, std::size_t done, std::size_t of) {
  printResult("%zu/%zu %s: %s, %zu built, %zu unchanged, %zu failed, %zu leaves, %.1f s%s%s\n", done, of, patient.name.c_str(),
              nameOf(patient.state), patient.built, patient.cached, patient.failed, patient.leaves, patient.seconds,
              patient.error.empty() ? "" : "; ", plainText(patient.error).c_str());
}

int runCohortCommand(const BatchOptions& options, WorkProgress& progress) {
  const pipeline::CohortSettings settings = cohortOf(options);
  const std::vector<pipeline::PatientResult> patients = runCohort(settings, progress, printPatient);
  const auto worst = std::max_element(patients.begin(), patients.end(), [](const auto& a, const auto& b) { return a.state < b.state; });
  printResult("%s: %s in shard %zu of %zu\nnext: spheretree report --cohort %s -o PAGE.html\n", plainText(settings.folder.string()).c_str(),
              counted(patients.size(), "patient").c_str(), settings.shard.index, settings.shard.count,
              plainText(settings.folder.string()).c_str());
  if (worst == patients.end() || worst->state == pipeline::PatientState::Ok) return kExitOk;
  return worst->state == pipeline::PatientState::Missed ? kExitTargetMissed : kExitPartlyFailed;
}

int runBatchCommand(const BatchOptions& options, bool quiet, WorkProgress& progress) try {
  if (!options.cohort.empty()) return runCohortCommand(options, progress);
  if (options.inputs.empty()) throw UsageError("there is no input. Name a scene, mesh files, or a --cohort.");
  const BatchSettings settings = settingsOf(options);
  const BatchResult result = pipeline::runBatch(settings, progress);
  if (!quiet)
    for (const std::string& note : result.notes) say("spheretree: " + note);
  return printResults(settings, result);
} catch (const builder::Cancelled&) {
  return explain(kProgram, kExitInterrupted, "interrupted. The trees that were finished are kept; the same command goes on from there.");
}

std::string parseBudget(const std::string& text, std::optional<Budget>& budget) {
  Budget parsed;
  const char* end = text.data() + text.size();
  const auto [unit, error] = std::from_chars(text.data(), end, parsed.amount);
  parsed.is_time = std::string_view(unit, end) == "us";
  const bool is_number = error == std::errc() && std::isfinite(parsed.amount) && parsed.amount > 0;
  const bool is_count = unit == end && parsed.amount >= 1 && parsed.amount <= 1e9 && parsed.amount == std::floor(parsed.amount);
  if (!is_number || !(parsed.is_time || is_count)) return text + " is neither a number of leaves, such as 6000, nor a time, such as 20us";
  budget = parsed;
  return "";
}

std::string parseShard(const std::string& text, Shard& shard) {
  const char* end = text.data() + text.size();
  const auto [slash, bad_index] = std::from_chars(text.data(), end, shard.index);
  if (bad_index == std::errc() && slash != end && *slash == '/') {
    const auto [last, bad_count] = std::from_chars(slash + 1, end, shard.count);
    if (bad_count == std::errc() && last == end && shard.index >= 1 && shard.index <= shard.count && shard.count <= 10000) return "";
  }
  return text + " is not I/N with 1 <= I <= N <= 10000";
}

/// Options for a quick look; the scene itself does not change.
void addOverrides(CLI::App& app, formats::TreeSettings& overrides) {
  app.add_option("--quality", overrides.quality, "quick, standard or best for every object; default: the setting of the scene")
      ->type_name("NAME")
      ->check(CLI::IsMember(pipeline::namesOf(pipeline::kQualities)));
  app.add_option("--builder", overrides.builder,
                 "Builder of every object, with the names of build --builder; default: the setting of the scene")
      ->type_name("NAME")
      ->check(CLI::IsMember(pipeline::namesOf(pipeline::kBuilders)));
  app.add_flag("--search", overrides.search, "The cover search distributes the balls of published builders, as in build");
  app.add_option("--tolerance", overrides.tolerance_mm,
                 "Tolerance of every object in mm, above 0 and at most 10^6; default: the setting of the scene")
      ->type_name("MM")
      ->check(numberIn(1e-9, formats::kMaxSceneLength));
}

}  // namespace

void addBatchCommand(Program& program) {
  const auto all = std::make_shared<BatchOptions>();
  const std::shared_ptr<BatchSettings> options(all, &all->settings);
  CLI::App* app = addVerb(program, "batch", "Build the trees of every object of a scene; unchanged trees are taken from a cache",
                          "spheretree batch mouth.scene.json -o mouth\n  spheretree batch mouth.glb probe.stl -o mouth --tolerance 0.1",
                          [all, &program](WorkProgress& progress) { return runBatchCommand(*all, program.quiet, progress); });
  app->add_option("SCENE|MESH", all->inputs,
                  "Scene to read (.scene.json); spheretree help scene lists its keys. Or mesh files: each of their parts becomes an "
                  "object, as with spheretree scene")
      ->type_name("FILE");
  app->add_option("--cohort", all->cohort,
                  "In place of SCENE|MESH: many patients, one line of JSON each, such as {\"patient\": \"P001\", \"scene\": "
                  "\"P001/mouth.scene.json\"}; results go to DIR/P001 and so on; default: none")
      ->type_name("FILE");
  app->add_option("-o,--output", options->folder, "Folder for NAME.stree, scene.json and report.json; created if it is missing")
      ->required()
      ->type_name("DIR");
  app->add_option("--cache", options->cache, "Folder that keeps finished trees, named by a hash of mesh and settings; default DIR/cache")
      ->type_name("DIR");
  app->add_option_function<std::string>(
         "--shard", [options](const std::string& text) { (void)parseShard(text, options->shard); },
         "Build only the I-th of N shares of the trees, into the cache; with --cohort, of the patients, with their results; default 1/1: "
         "everything, with the results")
      ->type_name("I/N")
      ->check([](const std::string& text) {
        Shard ignored;
        return parseShard(text, ignored);
      });
  app->add_option_function<std::string>(
         "--budget", [options](const std::string& text) { (void)parseBudget(text, options->budget); },
         "LEAVES (1 to 10^9): share this number of leaves among all trees so that the largest error is as small as possible. TIMEus (such "
         "as 20us, above 0): find the trees with the smallest error whose haptic step takes at most this many microseconds, by a model "
         "that is the same on every machine; default: none, each object has its own levels and tolerance")
      ->type_name("LEAVES|TIMEus")
      ->check([](const std::string& text) {
        std::optional<Budget> ignored;
        return parseBudget(text, ignored);
      });
  app->add_flag("--chart", options->speed,
                "Also measure the scene and each object with 8, 64, 512 and 4,096 leaves and with each tolerance of the scene, for the "
                "chart of speed against accuracy in the report; default: off");
  app->add_option("--trajectory", options->paths,
                  "Trajectory or recording (.csv) of the tool, from which --chart and a --budget in us take their steps; may be given "
                  "again; default: contacts at random")
      ->type_name("FILE")
      ->allow_extra_args(false);
  addOverrides(*app, options->overrides);
  addDraftOptions(*app, all->draft);
  app->add_flag("--dry-run", options->dry_run, "Only list the trees that would be built, and write nothing; default: off");
  addThreads(*app, options->threads);
  addForce(*app, program);
}

}  // namespace spheretree::tool
