// SPDX-License-Identifier: GPL-3.0-or-later
// spheretree split: makes closed teeth and gums, with a scene for batch, from labelled intraoral scans.
#include <memory>

#include "json_text.h"
#include "mistyped.h"
#include "options/command.h"
#include "options/common_options.h"
#include "pipeline/split/split_job.h"
#include "run_files.h"
#include "spheretree/formats/scan_labels.h"
#include "terminal.h"

namespace spheretree::tool {
namespace {

struct SplitOptions {
  pipeline::SplitJobSettings job;
  bool json = false;
};

int runSplitCommand(const SplitOptions& options, builder::Progress& progress) {
  for (const std::filesystem::path& input : options.job.scans)
    if (isDash(input)) throw UsageError("a scan is read twice, which standard input (-) cannot be. Save it as a file first.");
  const pipeline::SplitJobResult result = pipeline::runSplit(options.job, progress);
  for (const std::string& note : result.notes) say("spheretree: " + note);
  if (options.json)
    writeResult(jsonText(result.report, 1) + "\n");
  else
    printResult("%s: %s, %s; %zu refused, %zu cross a neighbour\n", plainText(options.job.folder.string()).c_str(),
                counted(result.teeth, "tooth", "teeth").c_str(), counted(result.gums, "gum").c_str(), result.refused, result.crossing);
  if (!options.json && result.refused + result.crossing == 0)
    printResult("next: spheretree batch %s -o DIR\n", plainText((options.job.folder / "mouth.scene.json").string()).c_str());
  if (result.refused > 0) return kExitPartlyFailed;
  return result.crossing > 0 ? kExitTargetMissed : kExitOk;
}

void addSources(CLI::App& app, pipeline::SplitJobSettings& job) {
  app.add_option("SCAN", job.scans, "Labelled scan of one jaw, or of both: OBJ, PLY, STL, OFF, glTF or GLB")->required()->type_name("FILE");
  app.add_option(
         "--labels", job.labels,
         "Labels as JSON in the form of Teeth3DS+, one file for each scan; default: none, then --label-property or --parts is needed")
      ->type_name("FILE");
  app.add_option("--label-property", job.source.property,
                 "Scalar property of the vertices or faces of a PLY file, or colour, that holds the labels; default: none")
      ->type_name("NAME");
  app.add_flag("--parts", job.source.parts,
               "Take the parts of the file as labels; their names contain the numbers of the teeth; default: off");
  app.add_option("--numbering", job.source.numbering, "Numbers in the labels: fdi, universal or palmer; default fdi")
      ->type_name("NAME")
      ->check(CLI::IsMember({"fdi", "universal", "palmer"}));
  app.add_option("--label-side", job.source.side,
                 "What has the labels: vertices, faces or auto; default auto: by their number, and in a PLY the side whose labels vary")
      ->type_name("NAME")
      ->check(CLI::IsMember({"vertices", "faces", "auto"}));
  app.add_option("--gum-label", job.source.gum_label, "Label that is gum, beside 0; 1 to 999; default: none")
      ->type_name("N")
      ->check(CLI::Range(1, static_cast<int>(formats::kMaxScanLabel)));
  app.add_option("--frame", job.frame,
                 "LPS or RAS: turn scans whose header states the other one (SPACE=); default: none, as they are stored")
      ->type_name("NAME")
      ->check(CLI::IsMember({"LPS", "RAS"}));
  app.add_option("--jaw", job.jaw, "Jaw of a single scan: upper, lower or auto; default auto: from the labels")
      ->type_name("NAME")
      ->check(CLI::IsMember({"upper", "lower", "auto"}));
  addUnit(app, job.unit);
}

}  // namespace

void addSplitCommand(Program& program) {
  const auto options = std::make_shared<SplitOptions>();
  CLI::App* app = addVerb(program, "split", "Cut labelled intraoral scans into closed teeth and gums, with a scene for batch",
                          "spheretree split upper.obj lower.obj --labels upper.json lower.json \\\n    --opening 30 -o patient",
                          [options](builder::Progress& progress) { return runSplitCommand(*options, progress); });
  addSources(*app, options->job);
  builder::SplitSettings& split = options->job.split;
  app->add_option("-o,--output", options->job.folder, "Folder for NAME.ply, mouth.scene.json and split.json; created if it is missing")
      ->required()
      ->type_name("DIR");
  app->add_option("--base", split.base_mm, "Distance from the lowest point of a scan to the base of its gum in mm, 0.001 to 100; default 4")
      ->type_name("MM")
      ->check(numberIn(1e-3, 100));
  app->add_option("--root", split.root_mm, "Length of a conical stub under each crown in mm, 0 to 30; default 0: a cap")
      ->type_name("MM")
      ->check(numberIn(0, 30));
  app->add_option("--smooth", split.smooth_mm,
                  "Largest distance in mm by which smoothing may move the border of a label, 0 to 10; default 0.15")
      ->type_name("MM")
      ->check(numberIn(0, 10));
  app->add_option("--min-area", split.min_area_mm2, "Area in mm2 below which a piece of a label joins its neighbour, 0 to 1000; default 4")
      ->type_name("MM2")
      ->check(numberIn(0, 1000));
  app->add_option_function<std::vector<double>>(
         "--up", [&split](const std::vector<double>& v) { split.up = Eigen::Vector3d(v.at(0), v.at(1), v.at(2)); },
         "Direction from the gum to the biting edges, three numbers; default: where the scan looks, or in a closed one the crowns")
      ->type_name("X,Y,Z")
      ->delimiter(',')
      ->expected(3)
      ->check(numberIn(-1e6, 1e6));
  app->add_option("--opening", options->job.opening_deg,
                  "Angle in degrees by which the lower of two jaws is rotated in the scene to open the mouth, 0 to 60; default: as scanned")
      ->type_name("DEG")
      ->check(numberIn(0, 60));
  app->add_flag("--json", options->json, "Print split.json in place of a summary; default: off");
  app->add_option("--marked", options->job.marked, "GLB of all parts that marks the surfaces added to the scan; default: none")
      ->type_name("FILE");
  addForce(*app, program);
}

}  // namespace spheretree::tool
