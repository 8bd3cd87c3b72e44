// SPDX-License-Identifier: Apache-2.0
#include "spheretree/formats/cohort_list.h"

#include <cctype>
#include <map>

#include "spheretree/formats/file_io.h"
#include "text/json_element.h"

namespace spheretree::formats {
namespace {

constexpr std::size_t kMaxNameLength = 100;
constexpr const char* kReserved = "cache";  // name of a folder beside those of the patients

bool isPatientName(std::string_view name) {
  const auto isWord = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '-' || c == '_'; };
  return !name.empty() && name.size() <= kMaxNameLength && isWord(name[0]) &&
         std::all_of(name.begin(), name.end(), [&](char c) { return isWord(c) || c == '.'; });
}

std::string lowerCase(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

CohortPatient parsePatient(std::string_view line, const JsonSource& source) {
  const nlohmann::json parsed = parseJson(line, source);
  const JsonElement root(parsed, "", source);
  root.onlyKeys({"patient", "scene"});
  CohortPatient patient{root.at("patient").text(), root.at("scene").text()};
  if (!isPatientName(patient.name) || lowerCase(patient.name) == kReserved)
    root.at("patient").fail("is " + inQuotes(patient.name) + ", which cannot name a folder of results. Take 1 to " +
                            std::to_string(kMaxNameLength) + " letters, digits, -, _ and dots, with no dot in front, and not \"" +
                            kReserved + "\"");
  if (patient.scene.empty()) root.at("scene").fail("is empty");
  return patient;
}

}  // namespace

std::vector<CohortPatient> parseCohortList(std::string_view text, const std::string& name) {
  std::vector<CohortPatient> patients;
  std::map<std::string, std::size_t> line_of;
  for (std::size_t line = 1; !text.empty(); ++line) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view words = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (!words.empty() && words.back() == '\r') words.remove_suffix(1);
    if (words.find_first_not_of(" \t") == std::string_view::npos) continue;
    const JsonSource source{name + ": line " + std::to_string(line), "a patient of a cohort (.jsonl)"};
    patients.push_back(parsePatient(words, source));
    const auto [entry, is_new] = line_of.emplace(lowerCase(patients.back().name), line);
    if (!is_new)
      throw FormatError(source.name + ": the patient " + inQuotes(patients.back().name) + " is in line " + std::to_string(entry->second) +
                        " already. Give each its own name: it names the folder of the results.");
  }
  if (patients.empty()) throw FormatError(name + R"(: names no patient. A line is {"patient": "P001", "scene": "P001/mouth.scene.json"}.)");
  return patients;
}

std::vector<CohortPatient> readCohortList(const std::filesystem::path& path) {
  const std::vector<std::byte> bytes = readFile(path);
  return parseCohortList({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, shownName(path));
}

}  // namespace spheretree::formats
