// SPDX-License-Identifier: GPL-3.0-or-later
// The page of a cohort: the summary, and its patients, the worst first.
#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>

#include "page/chart.h"
#include "page/report_page.h"
#include "pipeline/batch/cohort.h"

namespace spheretree::tool {
namespace {

using pipeline::PatientResult;
using pipeline::PatientState;

const char* markOf(PatientState state) { return state == PatientState::Ok ? "good" : state == PatientState::Missed ? "warn" : "bad"; }

std::string stateCell(PatientState state) { return "<span class=\"" + std::string(markOf(state)) + "\">" + nameOf(state) + "</span>"; }

/// A bar of the worst overhang as a multiple of its tolerance; a line marks the tolerance. `end`: the multiple at the
/// end of the bar.
std::string bar(const PatientResult& patient, double end) {
  if (!patient.worst_ratio) return "";
  const auto percent = [end](double ratio) { return shortNumber(100 * std::clamp(ratio / end, 0.0, 1.0)); };
  return "<span class=\"meter " + std::string(markOf(patient.state)) + "\"><i style=\"width:" + percent(*patient.worst_ratio) +
         "%\"></i><b style=\"left:" + percent(1) + "%\"></b></span>";
}

/// The multiple at the end of all bars. A few patients far beyond the others have full bars, so that the others do not
/// become short.
double barEnd(const std::vector<PatientResult>& patients) {
  std::vector<double> ratios;
  for (const PatientResult& p : patients)
    if (p.worst_ratio) ratios.push_back(*p.worst_ratio);
  if (ratios.empty()) return 1.25;
  std::sort(ratios.begin(), ratios.end());
  return std::max(1.25, std::min(ratios.back(), 3 * ratios[ratios.size() / 2]));
}

/// A relative path as a link.
std::string linkTo(const std::filesystem::path& path) {
  std::string out;
  for (const char c : path.generic_string()) {
    char code[4];
    std::snprintf(code, sizeof code, "%%%02X", static_cast<unsigned>(static_cast<unsigned char>(c)));
    out += std::isalnum(static_cast<unsigned char>(c)) || std::string_view("-_./~").find(c) != std::string_view::npos ? std::string(1, c)
                                                                                                                      : code;
  }
  return out.starts_with('/') || out.starts_with('.') ? out : "./" + out;
}

/// The name, as a link if there is a page of the patient.
std::string patientCell(const PatientResult& patient, const std::filesystem::path& folder, const std::filesystem::path& page) {
  const std::filesystem::path own = folder / patient.name / kPatientPage;
  std::error_code none;
  if (page.empty() || !std::filesystem::exists(own, none)) return escaped(patient.name);
  const std::filesystem::path from = std::filesystem::absolute(page).parent_path();
  return "<a href=\"" + escaped(linkTo(std::filesystem::relative(own, from))) + "\">" + escaped(patient.name) + "</a>";
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
  if (seconds < 60) return {"Seconds of work", shortNumber(seconds)};
  if (seconds < 3600) return {"Minutes of work", shortNumber(seconds / 60)};
  return {"Hours of work", shortNumber(seconds / 3600)};
}

}  // namespace

Report cohortReport(const std::filesystem::path& folder, const std::filesystem::path& page_file) {
  const std::vector<PatientResult> patients = pipeline::readCohortLogs(folder);
  Report report;
  HtmlTable table{"Patients, the worst first; the line in a bar is the tolerance",
                  {"Patient", "State", "Worst overhang / tolerance", "As a bar", "Worst object", "What went wrong", "Objects", "Failed",
                   "Missed", "Leaves", "Time [s]"},
                  {}};
  const double end = barEnd(patients);
  Json rows = Json::array();
  double seconds = 0;
  std::size_t leaves = 0;
  for (const PatientResult& p : patients) {
    seconds += p.seconds, leaves += p.leaves;
    rows.push_back(toJson(p));
    table.rows.push_back({patientCell(p, folder, page_file), stateCell(p.state), p.worst_ratio ? shortNumber(*p.worst_ratio) : "\u2013",
                          bar(p, end), escaped(p.worst_object),
                          p.error.empty() ? "" : "<span class=\"wrap words\">" + escaped(p.error) + "</span>",
                          std::to_string(p.built + p.cached + p.failed), std::to_string(p.failed), std::to_string(p.missed),
                          std::to_string(p.leaves), shortNumber(std::round(100 * p.seconds) / 100)});
  }
  Page page("Cohort: " + folder.filename().string(), verdict(patients));
  page.addSection("patients", "Patients",
                  figureBoxes({{"Patients", std::to_string(patients.size())}, {"Leaves", std::to_string(leaves)}, workBox(seconds)}) +
                      table.html() +
                      "<p class=\"note\">refused: the scene cannot be read; failed: an object has no tree; missed: a tolerance is not met. "
                      "spheretree report --cohort --pages writes a page of each patient, too, to which the names then link.</p>\n");
  report.html = page.html({});
  report.figures = {{"schema", "spheretree.cohort_report/1"}, {"patients", std::move(rows)}};
  return report;
}

}  // namespace spheretree::tool
