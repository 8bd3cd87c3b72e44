// SPDX-License-Identifier: GPL-3.0-or-later
// The page of a cohort: the summary, and its patients, the worst first.
#include <algorithm>

#include "page/chart.h"
#include "page/report_page.h"
#include "pipeline/batch/cohort.h"

namespace spheretree::tool {
namespace {

using pipeline::PatientResult;
using pipeline::PatientState;

std::string stateCell(PatientState state) {
  const char* mark = state == PatientState::Ok ? "good" : state == PatientState::Missed ? "warn" : "bad";
  return "<span class=\"" + std::string(mark) + "\">" + nameOf(state) + "</span>";
}

std::string verdict(const std::vector<PatientResult>& patients) {
  const auto with = [&](PatientState state) {
    return static_cast<std::size_t>(std::count_if(patients.begin(), patients.end(), [&](const auto& p) { return p.state == state; }));
  };
  const std::size_t ok = with(PatientState::Ok);
  if (ok == patients.size()) return "<p><span class=\"good\">All " + std::to_string(ok) + " patients are built</span> as requested.</p>\n";
  std::string out = "<p><span class=\"bad\">" + std::to_string(patients.size() - ok) + " of " + std::to_string(patients.size()) +
                    (patients.size() - ok == 1 ? " patients is" : " patients are") + " not as requested</span>: ";
  for (const PatientState state : {PatientState::Refused, PatientState::Failed, PatientState::Missed})
    out += std::to_string(with(state)) + " " + nameOf(state) + (state == PatientState::Missed ? ".</p>\n" : ", ");
  return out;
}

/// In the largest unit in which the time is at least one.
std::pair<std::string, std::string> workBox(double seconds) {
  if (seconds < 60) return {"seconds of work", shortNumber(seconds)};
  if (seconds < 3600) return {"minutes of work", shortNumber(seconds / 60)};
  return {"hours of work", shortNumber(seconds / 3600)};
}

}  // namespace

Report cohortReport(const std::filesystem::path& folder) {
  const std::vector<PatientResult> patients = pipeline::readCohortLogs(folder);
  Report report;
  HtmlTable table{"Patients, the worst first",
                  {"patient", "state", "what went wrong", "worst overhang / tolerance", "worst object", "built", "unchanged", "failed",
                   "missed", "leaves", "seconds"},
                  {}};
  Json rows = Json::array();
  double seconds = 0;
  std::size_t leaves = 0;
  for (const PatientResult& p : patients) {
    seconds += p.seconds, leaves += p.leaves;
    rows.push_back(toJson(p));
    table.rows.push_back({escaped(p.name), stateCell(p.state), "<span class=\"wrap words\">" + escaped(p.error) + "</span>",
                          p.worst_ratio ? shortNumber(*p.worst_ratio) : "\u2013", escaped(p.worst_object), std::to_string(p.built),
                          std::to_string(p.cached), std::to_string(p.failed), std::to_string(p.missed), std::to_string(p.leaves),
                          shortNumber(p.seconds)});
  }
  Page page("Cohort " + folder.filename().string(), verdict(patients));
  page.addSection("patients", "Patients",
                  figureBoxes({{"patients", std::to_string(patients.size())}, {"leaves", std::to_string(leaves)}, workBox(seconds)}) +
                      table.html() +
                      "<p class=\"note\">refused: the scene cannot be read; failed: an object has no tree; missed: a tolerance is not met. "
                      "One patient: spheretree report FOLDER/PATIENT.</p>\n");
  report.html = page.html({});
  report.figures = {{"schema", "spheretree.cohort_report/1"}, {"patients", std::move(rows)}};
  return report;
}

}  // namespace spheretree::tool
