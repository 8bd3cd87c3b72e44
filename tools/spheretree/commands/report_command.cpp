// SPDX-License-Identifier: GPL-3.0-or-later
// spheretree report: one page from a comparison, a batch, a robot, a recording or the stability scenarios.
#include <cstdio>
#include <memory>

#include "json_text.h"
#include "options/command.h"
#include "page/chart.h"
#include "page/comparison_page.h"
#include "page/report_page.h"
#include "pipeline/batch/cohort.h"
#include "pipeline/comparison/comparison_json.h"
#include "robot/files/robot_files.h"
#include "run_files.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/file_io.h"
#include "terminal.h"

namespace spheretree::tool {
namespace {

namespace fs = std::filesystem;

struct ReportOptions {
  fs::path input, output, scene, recording;
  bool cohort = false, patients = false;
  bool json = false;
};

constexpr std::size_t kMaxComparisonBytes = 2'000'000, kMaxBytes = 5'000'000;

/// Writes the page of each patient that has a result.
void writePatientPages(const fs::path& folder, const RunFiles& files, builder::Progress& progress) {
  std::vector<fs::path> patients;
  for (const pipeline::PatientResult& patient : pipeline::readCohortLogs(folder))
    if (fs::exists(folder / patient.name / "report.json")) patients.push_back(folder / patient.name);
  for (const fs::path& patient : patients) files.willMake(patient / kPatientPage);
  for (const fs::path& patient : patients)
    formats::writeWhole(patient / kPatientPage, batchReport(patient, std::nullopt, kMaxBytes, progress).html);
}

Report makeReport(const ReportOptions& options, builder::Progress& progress) {
  const fs::path& in = options.input;
  if (options.cohort) {
    if (!options.scene.empty() || !options.recording.empty())
      throw UsageError("--scene and --recording do not go with --cohort. Leave them out.");
    return cohortReport(in, isDash(options.output) ? fs::path() : options.output);
  }
  if (options.patients) throw UsageError("--pages is for a cohort. Add --cohort, or leave it out.");
  const auto given = [](const fs::path& path) { return path.empty() ? std::optional<fs::path>() : std::optional<fs::path>(path); };
  std::error_code none;
  if (!fs::is_directory(in, none)) {
    if (!options.recording.empty()) throw UsageError("--recording is for the folder of a batch. Leave it out.");
    return recordingReport(in, given(options.scene), kMaxBytes, progress);
  }
  if (!options.scene.empty()) throw UsageError("--scene is for a recording; a folder contains its scene. Leave it out.");
  if (fs::exists(in / "report.json", none)) return batchReport(in, given(options.recording), kMaxBytes, progress);
  if (!options.recording.empty()) throw UsageError("--recording is for the folder of a batch. Leave it out.");
  if (fs::exists(in / "compare.json", none)) {
    Report report;
    const pipeline::Comparison comparison = pipeline::readComparison(in / "compare.json");
    report.figures = toJson(comparison);
    report.html = comparisonPage(comparison, in, kMaxComparisonBytes, progress);
    return report;
  }
  if (fs::exists(in / robot::kManifestName, none)) return robotReport(in, kMaxBytes, progress);
  if (fs::exists(in / "stability.json", none)) return stabilityReport(in, kMaxBytes, progress);
  for (const fs::directory_entry& entry : fs::directory_iterator(in, none))
    if (const std::string name = entry.path().filename().string(); name.starts_with("cohort.") && name.ends_with(".jsonl"))
      throw UsageError(in.string() + ": is the folder of a cohort. Add --cohort.");
  throw formats::FileError(in.string() +
                           ": neither report.json (batch) nor compare.json nor robot.json nor stability.json is in this folder. Name the "
                           "folder that one of these programs wrote.");
}

int runReport(const ReportOptions& options, builder::Progress& progress) {
  const RunFiles files;
  for (const fs::path& input : {options.input, options.scene, options.recording})
    if (!input.empty()) files.willRead(input);
  files.willWrite(options.output, {".html", ".htm"}, "the page");
  if (options.cohort && options.patients) writePatientPages(options.input, files, progress);
  const Report report = makeReport(options, progress);
  progress.check();
  formats::writeWhole(options.output, report.html);
  if (options.json)
    writeResult(jsonText(report.figures, 1) + "\n");
  else if (!isDash(options.output))
    printResult("%s: %zu bytes; open this page in a browser\n", plainText(options.output.string()).c_str(), report.html.size());
  return kExitOk;
}

}  // namespace

std::string viewSection(bool has_replay, const std::string& note) {
  return "<p>Drag or use the arrow keys to turn, wheel or + and \u2212 to come nearer, shift and drag to move. " + escaped(note) + "</p>" +
         (has_replay ? "<div class=\"time\"></div>" : "") + "<div class=\"view\"></div>";
}

std::string objectButtons(const std::string& name, std::size_t index) {
  const std::string at = std::to_string(index);
  return "<button type=\"button\" data-object=\"" + at + "\" title=\"Show its worst spot\">" + escaped(name) +
         "</button> <button type=\"button\" data-eye=\"" + at + "\" aria-pressed=\"false\" aria-label=\"Hide " + escaped(name) +
         " in the view\">hide</button>";
}

std::string figureBoxes(const std::vector<std::pair<std::string, std::string>>& boxes) {
  std::string out = "<div class=\"figure\">";
  for (const auto& [name, value] : boxes) out += "<div><b>" + escaped(value) + "</b>" + escaped(name) + "</div>";
  return out + "</div>\n";
}

void addReportCommand(Program& program) {
  const auto options = std::make_shared<ReportOptions>();
  CLI::App* app = addVerb(program, "report",
                          "Write one self-contained page from a batch, a comparison, a robot, a recording or the stability scenarios",
                          "spheretree report mouth -o mouth.html --recording probing.csv",
                          [options](builder::Progress& progress) { return runReport(*options, progress); });
  app->add_option("INPUT", options->input,
                  "Folder of batch, compare, robot or haptic-player --scenario; or a recording (.csv) of haptic-player")
      ->required()
      ->type_name("DIR|FILE");
  app->add_option("-o,--output", options->output, "Page to write (.html)")->required()->type_name("FILE");
  app->add_option("--scene", options->scene,
                  "The compiled scene (scene.json of batch) of a recording, to replay it in 3D; default: charts only")
      ->type_name("FILE");
  app->add_option("--recording", options->recording, "A recording in the scene of a batch, to replay it there; default: none")
      ->type_name("FILE");
  app->add_flag("--cohort", options->cohort,
                "Write a page of all patients, the worst first; INPUT is the folder of batch --cohort; default: off");
  app->add_flag("--pages", options->patients,
                "With --cohort: also write the page of each patient, PATIENT/report.html in INPUT, to which the names link; default: off");
  addForce(*app, program);
  app->add_flag("--json", options->json, "Print the figures of the page as JSON on stdout");
}

}  // namespace spheretree::tool
