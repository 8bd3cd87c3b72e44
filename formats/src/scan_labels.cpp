// SPDX-License-Identifier: Apache-2.0
#include "spheretree/formats/scan_labels.h"

#include "json_element.h"
#include "spheretree/formats/file_io.h"

namespace spheretree::formats {

ScanLabels parseScanLabels(std::string_view text, const std::string& name) {
  const JsonSource source{name, "labels of a scan (.json)"};
  const nlohmann::json parsed = parseJson(text, source);
  const JsonElement root(parsed, "", source);
  ScanLabels out;
  const JsonElement labels = root.at("labels");
  const std::size_t count = labels.size();
  if (count == 0) labels.fail("is empty: it has a number for each vertex of the mesh");
  out.labels.reserve(count);
  for (std::size_t i = 0; i < count; ++i) out.labels.push_back(static_cast<std::int32_t>(labels.item(i).integer(0, kMaxScanLabel)));
  if (root.has("instances")) {
    const JsonElement instances = root.at("instances");
    if (instances.size() != count)
      instances.fail("has " + std::to_string(instances.size()) + " numbers, but labels has " + std::to_string(count));
    for (std::size_t i = 0; i < count; ++i) (void)instances.item(i).integer(0, INT32_MAX);
  }
  if (root.has("id_patient") && !root.at("id_patient").isNull()) out.patient = root.at("id_patient").text();
  if (root.has("jaw") && !root.at("jaw").isNull()) {
    out.jaw = root.at("jaw").text();
    if (out.jaw != "upper" && out.jaw != "lower") root.at("jaw").fail("is " + inQuotes(out.jaw) + ", neither upper nor lower");
  }
  return out;
}

ScanLabels readScanLabels(const std::filesystem::path& path) {
  const std::vector<std::byte> bytes = readFile(path);
  return parseScanLabels({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, path.string());
}

}  // namespace spheretree::formats
