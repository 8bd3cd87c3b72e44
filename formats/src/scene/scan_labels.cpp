// SPDX-License-Identifier: Apache-2.0
#include "spheretree/formats/scan_labels.h"

#include <cmath>
#include <optional>

#include "spheretree/formats/file_io.h"
#include "spheretree/formats/path_name.h"
#include "text/json_element.h"

namespace spheretree::formats {

namespace {

/// Programs that compute labels write 44.0 as well as 44.
std::int32_t wholeLabel(const JsonElement& e) {
  const double value = e.number();
  if (!(value >= 0 && value <= kMaxScanLabel && value == std::floor(value)))
    e.fail("is not a whole number from 0 to " + std::to_string(kMaxScanLabel));
  return static_cast<std::int32_t>(value);
}

/// "upper" or "lower" for the usual words, in any case.
std::optional<std::string> jawOf(std::string word) {
  for (char& c : word)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  word = trimmed(word);
  for (const char* upper : {"upper", "upper jaw", "upperjaw", "upper_jaw", "maxilla", "maxillary", "top", "u"})
    if (word == upper) return "upper";
  for (const char* lower : {"lower", "lower jaw", "lowerjaw", "lower_jaw", "mandible", "mandibular", "bottom", "l"})
    if (word == lower) return "lower";
  return std::nullopt;
}

}  // namespace

ScanLabels parseScanLabels(std::string_view text, const std::string& name) {
  const JsonSource source{name, "labels of a scan (.json)"};
  const nlohmann::json parsed = parseJson(text, source);
  const JsonElement root(parsed, "", source);
  ScanLabels out;
  const JsonElement labels = root.at("labels");
  const std::size_t count = labels.size();
  if (count == 0) labels.fail("is empty: it has a number for each vertex of the mesh");
  out.labels.reserve(count);
  for (std::size_t i = 0; i < count; ++i) out.labels.push_back(wholeLabel(labels.item(i)));
  if (root.has("id_patient") && root.at("id_patient").isText()) out.patient = root.at("id_patient").text();
  if (root.has("jaw") && !root.at("jaw").isNull()) {
    const std::optional<std::string> jaw = jawOf(root.at("jaw").text());
    if (!jaw) root.at("jaw").fail("is " + inQuotes(root.at("jaw").text()) + ", neither upper nor lower");
    out.jaw = *jaw;
  }
  return out;
}

ScanLabels readScanLabels(const std::filesystem::path& path) {
  const std::vector<std::byte> bytes = readFile(path);
  return parseScanLabels({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, toUtf8(path));
}

}  // namespace spheretree::formats
