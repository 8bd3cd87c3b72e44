// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/batch/cohort.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <fstream>
#include <map>
#include <numeric>
#include <system_error>

#include "json_text.h"
#include "program_end.h"
#include "run_files.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/file_io.h"
#include "spheretree/formats/scene_file.h"

namespace spheretree::pipeline {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr double kBytesOfAnObject = 4e6;  // size of a mesh file that takes about as long as another small object
constexpr std::array kStateNames{"ok", "missed", "failed", "refused"};
constexpr const char* kCohortSchema = "spheretree.cohort/1";

fs::path sceneOf(const CohortSettings& settings, const formats::CohortPatient& patient) {
  return patient.scene.is_absolute() ? patient.scene : settings.list.parent_path() / patient.scene;
}

void takeObjects(const BatchResult& batch, PatientResult& out) {
  const BatchTotals totals = totalsOf(batch);
  out.built = totals.built, out.cached = totals.cached, out.failed = totals.failed, out.leaves = totals.leaves;
  for (const ObjectResult& object : batch.objects) {
    if (object.status == ItemStatus::Failed && out.error.empty()) out.error = object.name + ": " + object.error;
    if (!object.hasTree()) continue;
    out.missed += !object.figures.tolerance_met.value_or(true);
    const std::optional<double> tolerance = object.figures.tolerance_mm;
    if (!tolerance || !(*tolerance > 0)) continue;
    const double ratio = object.figures.ratio ? object.figures.ratio->ratio : object.figures.leafBound() / *tolerance;
    if (out.worst_ratio && ratio <= *out.worst_ratio) continue;
    out.worst_ratio = ratio;
    out.worst_object = object.name;
  }
  out.state = out.failed > 0 ? PatientState::Failed : out.missed > 0 ? PatientState::Missed : PatientState::Ok;
}

PatientResult runPatient(const CohortSettings& settings, const formats::CohortPatient& patient, tool::WorkProgress& progress) {
  const auto begun = std::chrono::steady_clock::now();
  PatientResult out;
  out.name = patient.name;
  BatchSettings batch;
  batch.scene = sceneOf(settings, patient);
  batch.folder = settings.folder / patient.name;
  batch.cache = settings.cache.empty() ? settings.folder / "cache" : settings.cache;
  batch.threads = settings.threads;
  batch.overrides = settings.overrides;
  try {
    takeObjects(runBatch(batch, progress), out);
  } catch (const builder::Cancelled&) {
    throw;
  } catch (const std::exception& error) {  // affects only this patient
    out.state = PatientState::Refused;
    out.error = error.what();
  }
  out.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  return out;
}

PatientResult fromJson(const Json& json) {
  PatientResult out;
  if (json.at("schema").get<std::string>() != kCohortSchema) throw std::invalid_argument("the schema is not " + std::string(kCohortSchema));
  out.name = json.at("patient").get<std::string>();
  const auto state = std::find(kStateNames.begin(), kStateNames.end(), json.at("state").get<std::string>());
  if (state == kStateNames.end()) throw std::invalid_argument("the state is not ok, missed, failed or refused");
  out.state = static_cast<PatientState>(state - kStateNames.begin());
  if (!json.at("error").is_null()) out.error = json.at("error").get<std::string>();
  out.built = json.at("built").get<std::size_t>();
  out.cached = json.at("unchanged").get<std::size_t>();
  out.failed = json.at("failed").get<std::size_t>();
  out.missed = json.at("missed").get<std::size_t>();
  out.leaves = json.at("leaves").get<std::size_t>();
  if (!json.at("worst_ratio").is_null()) out.worst_ratio = json.at("worst_ratio").get<double>();
  if (!json.at("worst_object").is_null()) out.worst_object = json.at("worst_object").get<std::string>();
  out.work = json.at("work").get<double>();
  out.seconds = json.at("seconds").get<double>();
  return out;
}

void readLog(const fs::path& path, std::map<std::string, PatientResult>& patients) {
  const std::vector<std::byte> bytes = formats::readFile(path);
  std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  for (std::size_t line = 1; !text.empty(); ++line) {
    const std::size_t end = text.find('\n');
    if (end == text.npos) break;  // the program was killed while it wrote this line
    const std::string_view words = text.substr(0, end);
    text.remove_prefix(end + 1);
    if (words.empty()) continue;
    try {
      PatientResult patient = fromJson(Json::parse(words));
      patients.insert_or_assign(patient.name, patient);
    } catch (const std::exception& error) {
      throw formats::FormatError(path.string() + ": line " + std::to_string(line) + " is not an entry of a cohort log: " + error.what() +
                                 ". Delete the file and run its shard again.");
    }
  }
}

}  // namespace

const char* nameOf(PatientState state) { return kStateNames[static_cast<std::size_t>(state)]; }

double estimatedWork(const fs::path& path) {
  try {
    const formats::SceneFile scene = formats::readScene(path);
    std::map<std::string, std::size_t> files;
    double work = 0;
    const auto add = [&](const formats::SceneItem& item) {
      work += 1;
      if (!item.mesh.empty()) ++files[formats::scenePath(path, item.mesh).string()];
    };
    add(scene.tool);
    for (const formats::SceneItem& object : scene.objects) add(object);
    for (const auto& [file, unused] : files) {
      std::error_code none;
      const std::uintmax_t size = fs::file_size(file, none);
      if (!none) work += static_cast<double>(size) / kBytesOfAnObject;
    }
    return work;
  } catch (const std::exception&) {
    return 1;  // the run itself will report why
  }
}

std::vector<std::size_t> shareOut(const std::vector<double>& work, std::size_t shards) {
  std::vector<std::size_t> order(work.size()), shard_of(work.size(), 1);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return work[a] > work[b]; });
  std::vector<double> load(shards, 0);
  for (const std::size_t i : order) {
    const auto smallest = std::min_element(load.begin(), load.end());
    *smallest += work[i];
    shard_of[i] = static_cast<std::size_t>(smallest - load.begin()) + 1;
  }
  return shard_of;
}

std::vector<PatientResult> runCohort(const CohortSettings& settings, tool::WorkProgress& progress,
                                     const std::function<void(const PatientResult&, std::size_t, std::size_t)>& tell) {
  const tool::RunFiles files(progress);
  files.willRead(settings.list);
  const std::vector<formats::CohortPatient> patients = formats::readCohortList(settings.list);
  std::vector<double> work;
  for (const formats::CohortPatient& patient : patients) {
    progress.check();
    work.push_back(estimatedWork(sceneOf(settings, patient)));
  }
  const std::vector<std::size_t> shard_of = shareOut(work, settings.shard.count);
  files.makeFolder(settings.folder);
  const fs::path log_path =
      settings.folder / ("cohort." + std::to_string(settings.shard.index) + "-of-" + std::to_string(settings.shard.count) + ".jsonl");
  files.willMake(log_path);
  const auto of = static_cast<std::size_t>(std::count(shard_of.begin(), shard_of.end(), settings.shard.index));
  std::vector<PatientResult> results;
  formats::writeWhole(log_path, std::string());
  std::ofstream log(log_path, std::ios::app);
  std::string whole_log;
  for (std::size_t i = 0; i < patients.size(); ++i) {
    if (shard_of[i] != settings.shard.index) continue;
    PatientResult result = runPatient(settings, patients[i], progress);
    result.work = work[i];
    const std::string line = toJson(result).dump(-1, ' ', false, Json::error_handler_t::replace) + '\n';
    files.willHold(log_path, whole_log += line);
    log << line << std::flush;  // for programs that wait for it
    if (!log) throw formats::FileError(log_path.string() + ": a line cannot be written. Is the disk full?");
    results.push_back(std::move(result));
    tell(results.back(), results.size(), of);
  }
  return results;
}

Json toJson(const PatientResult& result) {
  const auto textOrNull = [](const std::string& text) { return text.empty() ? Json(nullptr) : Json(text); };
  return {{"schema", kCohortSchema},
          {"patient", result.name},
          {"state", nameOf(result.state)},
          {"error", textOrNull(result.error)},
          {"built", result.built},
          {"unchanged", result.cached},
          {"failed", result.failed},
          {"missed", result.missed},
          {"leaves", result.leaves},
          {"worst_ratio", result.worst_ratio ? Json(*result.worst_ratio) : Json(nullptr)},
          {"worst_object", textOrNull(result.worst_object)},
          {"work", result.work},
          {"seconds", result.seconds}};
}

std::vector<PatientResult> readCohortLogs(const fs::path& folder) {
  std::vector<std::pair<fs::file_time_type, fs::path>> logs;
  std::error_code none;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, none)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with("cohort.") && name.ends_with(".jsonl")) logs.emplace_back(fs::last_write_time(entry.path(), none), entry.path());
  }
  if (logs.empty())
    throw formats::FileError(folder.string() + ": holds no cohort log (cohort.I-of-N.jsonl). Name the folder of batch --cohort.");
  std::sort(logs.begin(), logs.end());
  std::map<std::string, PatientResult> patients;
  for (const auto& [time, path] : logs) readLog(path, patients);
  std::vector<PatientResult> results;
  for (const auto& [name, patient] : patients) results.push_back(patient);
  std::stable_sort(results.begin(), results.end(), [](const PatientResult& a, const PatientResult& b) {
    return a.state != b.state ? a.state > b.state : a.worst_ratio.value_or(0) > b.worst_ratio.value_or(0);
  });
  return results;
}

}  // namespace spheretree::pipeline
