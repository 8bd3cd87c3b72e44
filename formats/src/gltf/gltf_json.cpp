// SPDX-License-Identifier: Apache-2.0
#include "gltf/gltf_json.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "text/json_element.h"
#include "text/little_endian.h"
#include "text/text_encoding.h"
#include "text/text_scan.h"

namespace spheretree::formats {
namespace {

constexpr int kMaxJsonDepth = 64;  // glTF itself needs 9; extras have no limit

}  // namespace

bool isGlb(std::span<const char> bytes) { return bytes.size() >= 4 && std::string_view(bytes.data(), 4) == "glTF"; }

std::string place(const std::string& key, std::uint64_t index) { return key + "[" + std::to_string(index) + "]"; }

void refuseElement(const MeshAssembly& assembly, const std::string& where, const std::string& what) {
  assembly.refuse(where + " " + what + ". The file is damaged or not valid glTF 2.0: export it again.");
}

GltfJson::GltfJson(std::span<const char> bytes, const MeshAssembly& assembly) : assembly_(assembly) {
  if (!isGlb(bytes) && std::find(bytes.begin(), bytes.end(), '\0') != bytes.end())
    assembly.refuse(
        "does not begin with \"glTF\", as a GLB does, and is not text, as a .gltf is. The file is damaged, of another kind, or in "
        "UTF-16.");
  parse(isGlb(bytes) ? openContainer(bytes) : asText(bytes, assembly.name()));
}

std::span<const char> GltfJson::openContainer(std::span<const char> bytes) {
  constexpr std::uint32_t kJsonChunk = 0x4e4f534a, kBinChunk = 0x004e4942;
  if (bytes.size() < 20)
    assembly_.refuse("is a GLB of only " + std::to_string(bytes.size()) + " bytes. It is cut off: copy or export it again.");
  if (const std::uint32_t version = littleUint32(bytes.data() + 4); version != 2)
    assembly_.refuse("is GLB of version " + std::to_string(version) + "; only version 2 is read. Export it as glTF 2.0.");
  const std::uint32_t length = littleUint32(bytes.data() + 8);
  if (length > bytes.size())
    assembly_.refuse("has " + std::to_string(bytes.size()) + " of the " + std::to_string(length) +
                     " bytes that its header announces. It is cut off: copy or export it again.");
  bytes_after_end_ = bytes.size() - length;
  std::span<const char> rest = bytes.first(length), json;
  rest = rest.subspan(std::min<std::size_t>(12, rest.size()));
  for (int chunk = 0; !rest.empty(); ++chunk) {
    const std::string where = "chunk " + std::to_string(chunk);
    if (rest.size() < 8) assembly_.refuse(where + " has no room for its header. The file is damaged: export it again.");
    const std::uint32_t size = littleUint32(rest.data()), type = littleUint32(rest.data() + 4);
    rest = rest.subspan(8);
    if (size > rest.size())
      assembly_.refuse(where + " announces " + std::to_string(size) + " bytes, but " + std::to_string(rest.size()) +
                       " are left. The file is cut off or damaged: copy or export it again.");
    if ((chunk == 0) != (type == kJsonChunk))
      assembly_.refuse(where + " is of the wrong type: a GLB begins with one JSON chunk. Export it again.");
    if (chunk == 0) json = rest.first(size);
    if (chunk == 1 && type == kBinChunk) binary_chunk_ = rest.first(size);
    rest = rest.subspan(size);
  }
  return json;
}

void GltfJson::parse(std::span<const char> text) {
  if (text.empty()) assembly_.refuse("holds no JSON. Export it again.");
  // Counted in advance: the parser's own callback takes quadratic time for long arrays.
  int depth = 0;
  bool in_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_string && c == '\\') ++i;
    if (c == '"') in_string = !in_string;
    if (in_string) continue;
    if (c == '[' || c == '{') ++depth;
    if (c == ']' || c == '}') --depth;
    if (depth > kMaxJsonDepth)
      assembly_.refuse("its JSON is nested more than " + std::to_string(kMaxJsonDepth) + " deep. Export it again.");
  }
  try {
    root_ = nlohmann::json::parse(text.begin(), text.end());
  } catch (const nlohmann::json::exception& error) {
    assembly_.refuse(jsonFault({text.data(), text.size()}, error) + " The file is damaged: export it again.");
  }
  if (!root_.is_object()) assembly_.refuse("its JSON is not an object. Export it again.");
}

const nlohmann::json* GltfJson::find(const nlohmann::json& object, const char* key) {
  const auto found = object.find(key);
  return found == object.end() ? nullptr : &*found;
}

const nlohmann::json& GltfJson::array(const char* key) const {
  static const nlohmann::json empty = nlohmann::json::array();
  const nlohmann::json* found = find(root_, key);
  if (!found) return empty;
  if (!found->is_array()) refuse(key, "is not an array");
  return *found;
}

const nlohmann::json& GltfJson::element(const char* key, std::uint64_t index, const std::string& from) const {
  const nlohmann::json& all = array(key);
  if (index >= all.size()) refuse(from, "names " + place(key, index) + ", but there are only " + std::to_string(all.size()));
  if (!all[index].is_object()) refuse(place(key, index), "is not an object");
  return all[index];
}

std::uint64_t GltfJson::asUnsigned(const nlohmann::json& value, const std::string& where) const {
  if (value.is_number_unsigned()) return value.get<std::uint64_t>();
  if (value.is_number_float()) {  // JSON has one kind of number: 3.0 is also an integer
    const double number = value.get<double>();
    if (number >= 0 && number <= 0x1p53 && number == std::floor(number)) return static_cast<std::uint64_t>(number);
  }
  refuse(where, "is not a whole number of 0 or more");
}

std::optional<std::uint64_t> GltfJson::findUnsigned(const nlohmann::json& object, const char* key, const std::string& where) const {
  const nlohmann::json* found = find(object, key);
  if (!found) return std::nullopt;
  return asUnsigned(*found, where + "." + key);
}

std::uint64_t GltfJson::getUnsigned(const nlohmann::json& object, const char* key, const std::string& where) const {
  const std::optional<std::uint64_t> found = findUnsigned(object, key, where);
  if (!found) refuse(where, "has no \"" + std::string(key) + "\"");
  return *found;
}

std::string GltfJson::findText(const nlohmann::json& object, const char* key) {
  const nlohmann::json* found = find(object, key);
  return found && found->is_string() ? found->get<std::string>() : std::string();
}

const nlohmann::json* GltfJson::findExtension(const nlohmann::json& object, const char* name) const {
  const nlohmann::json* extensions = find(object, "extensions");
  if (!extensions || !extensions->is_object()) return nullptr;
  const nlohmann::json* found = find(*extensions, name);
  return found && found->is_object() ? found : nullptr;
}

const nlohmann::json& GltfJson::getObject(const nlohmann::json& object, const char* key, const std::string& where) const {
  const nlohmann::json* found = find(object, key);
  if (!found || !found->is_object()) refuse(where, "has no object \"" + std::string(key) + "\"");
  return *found;
}

}  // namespace spheretree::formats
