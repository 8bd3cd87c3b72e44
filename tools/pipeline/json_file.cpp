// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/json_file.h"

#include "spheretree/formats/file_io.h"

namespace spheretree::pipeline {

nlohmann::ordered_json readJson(const std::filesystem::path& path, const std::string& schema) {
  using Json = nlohmann::ordered_json;
  const std::vector<std::byte> bytes = formats::readFile(path);
  const char* text = reinterpret_cast<const char*>(bytes.data());
  Json out = Json::parse(text, text + bytes.size(), nullptr, false);
  if (out.is_discarded()) throw formats::FormatError(path.string() + ": not JSON. Make it again.");
  if (!out.is_object() || out.value("schema", Json()) != schema)
    throw formats::FormatError(path.string() + ": its schema is not " + schema + ". Make it again with this version.");
  return out;
}

}  // namespace spheretree::pipeline
