// SPDX-License-Identifier: GPL-3.0-or-later
// spheretree grade: the figures of what a burr removed in a recorded run.
#include <tbb/global_control.h>

#include <filesystem>
#include <memory>

#include "base/useful_threads.h"
#include "json_text.h"
#include "mistyped.h"
#include "options/command.h"
#include "options/common_options.h"
#include "page/grade_page.h"
#include "pipeline/cut/grade.h"
#include "run_files.h"
#include "spheretree/formats/file_io.h"
#include "terminal.h"

namespace spheretree::tool {
namespace {

struct GradeOptions {
  std::filesystem::path input, output;
  std::string lesion = "lesion";
  double tolerance = 0;
  std::uint64_t last_tick = pipeline::kWholeRun;
  int threads = 0;
  bool json = false;
};

void printFigures(const std::vector<pipeline::GradedObject>& objects) {
  for (const pipeline::GradedObject& object : objects) {
    printResult("%s: removed %s mm3\n", plainText(object.name).c_str(), boundsText(object.removed).c_str());
    for (const pipeline::GradedLayer& layer : object.layers) {
      const builder::VolumeBounds left = layer.left();
      printResult("  %-12s removed %s mm3, left %s %%", plainText(layer.name).c_str(), boundsText(layer.removed).c_str(),
                  boundsText({100 * left.low, 100 * left.high}).c_str());
      if (layer.distance)
        printResult(layer.distance->high ? ", %s mm from the cut" : ", at least %s mm from the cut",
                    boundsText({layer.distance->low, layer.distance->high.value_or(layer.distance->low)}).c_str());
      printResult("\n");
    }
  }
}

int runGrade(const GradeOptions& options, bool quiet, builder::Progress& progress) {
  const RunFiles files;
  files.willRead(options.input);
  files.willWrite(options.output, {".html", ".htm"}, "the page");
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<std::size_t>(builder::usefulThreads(options.threads)));
  const pipeline::CutRun run = pipeline::readCutRun(options.input, options.last_tick, progress);
  const std::vector<pipeline::GradedObject> objects = pipeline::gradeRun(run, options.tolerance, options.lesion, progress);
  std::vector<std::vector<TriangleMesh>> left;  // for the page
  progress.stage("page");
  for (std::size_t i = 0; i < run.objects.size() && !options.output.empty(); ++i)
    left.push_back(pipeline::leftOfLayers(run.objects[i], objects[i], progress));
  clearProgressLine();
  if (!options.output.empty()) formats::writeWhole(options.output, gradePage(run, objects, left, options.input.filename().string()));
  if (options.json)
    writeResult(jsonText(pipeline::gradeJson(run, objects, options.input.string()), 1) + "\n");
  else if (!isDash(options.output))
    printFigures(objects);
  bool is_met = true;
  for (const pipeline::GradedObject& object : objects) {
    is_met = is_met && object.is_met;
    if (!object.is_met && !quiet)
      say("spheretree: " + object.name + ": the tolerance is not met with " + std::to_string(builder::CutVolumeSettings().max_cells) +
          " cells; the bounds hold, but are wider. Give a larger --volume-tolerance.");
  }
  return is_met ? kExitOk : kExitTargetMissed;
}

}  // namespace

void addGradeCommand(Program& program) {
  const auto options = std::make_shared<GradeOptions>();
  CLI::App* app =
      addVerb(program, "grade", "State what a burr removed in a recorded run, as proven bounds", "spheretree grade run.csv -o grade.html",
              [options, &program](builder::Progress& progress) { return runGrade(*options, program.quiet, progress); });
  app->add_option("RUN", options->input, "Recording (.csv) of haptic-player, in a scene with a burr and an object that can be cut")
      ->required()
      ->type_name("FILE");
  app->add_option("-o,--output", options->output, "Page to write (.html); default: none")->type_name("FILE");
  app->add_option("--volume-tolerance", options->tolerance,
                  "Largest sum of the widths of the bounds of the removed volumes of an object in mm3, 10^-6 to 10^6; default: 0.5 % of "
                  "what was removed")
      ->type_name("MM3")
      ->check(numberIn(1e-6, 1e6));
  app->add_option("--lesion", options->lesion, "Name of the layer that was to be removed; default lesion")->type_name("NAME");
  app->add_option("--at", options->last_tick, "Tick of the recording up to which it is graded; default: all of it")->type_name("TICK");
  addThreads(*app, options->threads);
  app->add_flag("--json", options->json, "Print the figures as JSON on stdout");
}

}  // namespace spheretree::tool
