// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/batch/tree_cache.h"

#include <nlohmann/json.hpp>

#include "json_text.h"
#include "run_files.h"
#include "spheretree/builder/provenance.h"
#include "spheretree/core/sphere_tree_codec.h"
#include "spheretree/core/tissue_codec.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/file_io.h"
#include "spheretree/formats/sphere_tree_file.h"

namespace spheretree::pipeline {

using Json = nlohmann::ordered_json;

std::optional<TreeResult> TreeCache::find(const std::string& key) const {
  const std::filesystem::path tree = folder_ / (key + ".stree"), record = folder_ / (key + ".json");
  std::error_code ignored;
  if (!std::filesystem::exists(record, ignored) || !std::filesystem::exists(tree, ignored)) return std::nullopt;
  try {
    // The entries are internal files: the program may read and rewrite them.
    const auto read = [](const std::filesystem::path& file) {
      return formats::readFile(file, formats::kMaxFileBytes, formats::FileRole::Working);
    };
    const std::vector<std::byte> bytes = read(tree), text = read(record);
    const auto* begin = reinterpret_cast<const char*>(text.data());
    const Json json = Json::parse(begin, begin + text.size());
    if (json.at("schema") != kRecordSchema || json.at("tree_hash") != toHex(builder::bytesHash(bytes))) return std::nullopt;
    return TreeResult{formats::parseSphereTree(bytes, tree.string()), treeFiguresFromJson(json.at("record")),
                      json.at("seconds").get<double>()};
  } catch (const formats::FileError&) {  // if an entry is invalid, the tree is built again
  } catch (const formats::FormatError&) {
  } catch (const nlohmann::json::exception&) {
  }
  return std::nullopt;
}

void TreeCache::prepare() const {
  tool::RunFiles().makeFolder(folder_);
  formats::checkWritable(folder_ / "record.json");
}

void TreeCache::store(const std::string& key, const TreeResult& result) const {
  const std::vector<std::byte> bytes = encodeSphereTree(result.tree);
  // The tree is written first: a record without its tree is not a valid entry, nor is one whose hash does not match.
  formats::writeWhole(folder_ / (key + ".stree"), bytes, formats::FileRole::Working);
  const Json json{{"schema", kRecordSchema},
                  {"tree_hash", toHex(builder::bytesHash(bytes))},
                  {"seconds", result.seconds},
                  {"record", toJson(result.figures)}};
  formats::writeWhole(folder_ / (key + ".json"), tool::jsonText(json, 1) + "\n", formats::FileRole::Working);
}

std::vector<std::byte> TreeCache::findSoft(const std::string& key) const {
  const std::filesystem::path file = folder_ / (key + ".soft");
  std::error_code ignored;
  if (!std::filesystem::exists(file, ignored)) return {};
  try {
    std::vector<std::byte> bytes = formats::readFile(file, formats::kMaxFileBytes, formats::FileRole::Working);
    SphereTree tree;
    Tissue tissue;
    if (decodeSoftTree(bytes, tree, tissue) == LoadStatus::Ok && !tissue.empty()) return bytes;
  } catch (const formats::FileError&) {  // then it is computed again
  }
  return {};
}

void TreeCache::storeSoft(const std::string& key, const std::vector<std::byte>& bytes) const {
  formats::writeWhole(folder_ / (key + ".soft"), bytes, formats::FileRole::Working);
}

}  // namespace spheretree::pipeline
